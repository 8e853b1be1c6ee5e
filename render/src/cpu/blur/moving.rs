//! What moves before a pinhole: pixel by pixel, the samples of several strata of time together, which an image of motion holds side
//! by side.

use crate::cpu::blur::quad::{At, Quad, on_line};
use crate::cpu::lanes::{LANES, Lanes};
use crate::cpu::micropolygon::Micropolygon;
use crate::cpu::samples::edges::AtEdge;
use crate::cpu::samples::{EDGE, SampledGrid, Samples, Tally};

/// Samples of a pixel that meet a micropolygon: places and times; depth and weights; parts of the triangle's area over against its corners; which
/// are in the first triangle, and which in both.
struct Found {
    place: [[f32; LANES]; 3],
    met: [[f32; LANES]; 3],
    parts: [[f32; LANES]; 3],
    first: u32,
    both: u32,
}

impl Found {
    #[inline(always)]
    fn new<L: Lanes>(place: [L; 3], met: [L; 3], parts: [L; 3], [first, second]: [L; 2]) -> Found {
        let [x, y, t] = place;
        let [z, w1, w2] = met;
        let [a, b, c] = parts;
        Found {
            place: [x.to_array(), y.to_array(), t.to_array()],
            met: [z.to_array(), w1.to_array(), w2.to_array()],
            parts: [a.to_array(), b.to_array(), c.to_array()],
            first: first.bits(),
            both: first.bits() & second.bits(),
        }
    }
}

impl Samples {
    /// Record what is sampled as layers are, for the samples `taken` from `k` on.
    fn moving_layers(
        &mut self,
        quad: &Quad,
        found: &Found,
        k: usize,
        mut taken: u32,
        point: usize,
        grid: &SampledGrid<'_>,
    ) {
        while taken != 0 {
            let l = taken.trailing_zeros() as usize;
            taken &= taken - 1;
            let ([x, y, t], [mut z, w1, w2], mut parts) =
                (found.place.map(|v| v[l]), found.met.map(|v| v[l]), found.parts.map(|v| v[l]));
            let (mut second, mut w, mut at_edge) = (found.first >> l & 1 == 0, [w1, w2], AtEdge::default());
            if found.both >> l & 1 == 1 || !quad.is_clear(parts) {
                let Some(exact) = quad.at_edges([x, y], [t, 0.0, 0.0], point, grid) else { continue };
                at_edge = exact.2;
                if exact.0 != second {
                    (second, parts) = (exact.0, exact.1);
                    let (weights, depth) = quad.at_pinhole(second, parts, t);
                    (z, w) = (depth, [weights[1], weights[2]]);
                }
            }
            if z < self.z[k + l] {
                let name = Micropolygon::new(grid.index, point, second);
                self.record(k + l, z, name, (w, at_edge), grid, || parts[0] + parts[1] + parts[2]);
            }
        }
    }

    /// Sample a micropolygon between two times; `strata` are the bounds of time.
    ///
    /// It is long because what it would call had to be inlined for the processor at hand (see `crate::cpu::lanes`).
    #[inline(always)]
    pub(super) fn moving<L: Lanes, const OPAQUE: bool>(
        &mut self,
        quad: &Quad,
        [from, until]: [f32; 2],
        strata: &[[[f32; 2]; 3]],
        point: usize,
        grid: &SampledGrid<'_>,
        tally: &mut Tally,
    ) {
        let (ox, oy) = (self.x0 as f32, self.y0 as f32);
        let names = [Micropolygon::new(grid.index, point, false).id(), Micropolygon::new(grid.index, point, true).id()];
        let zero = L::splat(0.0);
        for (group, strata) in strata.chunks(LANES).enumerate() {
            let times = [strata[0][0][0], strata[strata.len() - 1][0][1]];
            if times[1] < from || times[0] >= until {
                continue;
            }
            let [xs, ys] = quad.bound([times, [0.0; 2], [0.0; 2]]);
            let (xs, ys) = ([xs[0] - EDGE, xs[1] + EDGE], [ys[0] - EDGE, ys[1] + EDGE]);
            let Some(([px0, px1], [py0, py1])) = self.pixels_within(xs, ys) else { continue };
            tally.tried += ((px1 + 1 - px0) * (py1 + 1 - py0) * strata.len()) as u64;
            for py in py0..=py1 {
                let mut first = px1 + 1;
                let mut last = px0;
                for px in px0..=px1 {
                    let k = (py * self.width + px) * self.padded + group * LANES;
                    let old = L::load(&self.z, k);
                    let at = At {
                        // As places of the whole image: what is decided by them is decided alike in every bucket.
                        x: L::load(&self.x, k) + L::splat(ox),
                        y: L::load(&self.y, k) + L::splat(oy),
                        t: L::load(&self.time, k),
                        lens: [zero, zero],
                    };
                    let met = quad.meet::<L, false>(&at);
                    let takes = met.within(&at, [xs, ys], [from, until]);
                    if takes.bits() == 0 {
                        continue;
                    }
                    let ([p0, p1, p2], [q0, q1, q2], in_first) = (met.first, met.second, met.in_first);
                    let (a0, a1, a2) = (in_first.select(p0, q0), in_first.select(p1, q1), in_first.select(p2, q2));
                    let whole = a0 + a1 + a2;
                    // Weights of a point on the widened edge are those of a point inside nearby.
                    let (w0, w1, w2) = ((a0 / whole).max(zero), (a1 / whole).max(zero), (a2 / whole).max(zero));
                    let sum = w0 + w1 + w2;
                    let (w0, w1, w2) = (w0 / sum, w1 / sum, w2 / sum);
                    let middle = on_line(&quad.z, 2, at.t);
                    let z1 = in_first.select(on_line(&quad.z, 1, at.t), middle);
                    let z2 = in_first.select(middle, on_line(&quad.z, 3, at.t));
                    let z = on_line(&quad.z, 0, at.t) * w0 + z1 * w1 + z2 * w2;
                    let takes = takes.and(z.lt(old));
                    let taken = takes.bits();
                    if taken == 0 {
                        continue;
                    }
                    (first, last) = (first.min(px), px);
                    if OPAQUE {
                        takes.select(z, old).store(&mut self.z, k);
                        takes.store_id(in_first, [names[1], names[0]], &mut self.visible, k);
                        let [v1, v2] = &mut self.weights;
                        takes.select(w1, L::load(v1, k)).store(v1, k);
                        takes.select(w2, L::load(v2, k)).store(v2, k);
                    } else {
                        let (place, is_in) = ([at.x, at.y, at.t], [in_first, met.in_second]);
                        let found = Found::new(place, [z, w1, w2], [a0, a1, a2], is_in);
                        self.moving_layers(quad, &found, k, taken, point, grid);
                    }
                }
                if first <= last {
                    tally.hit = true;
                    self.mark(first, last, py, py);
                }
            }
        }
    }
}
