//! What is out of focus: the strata are taken one by one. From a stratum's cell of the lens, and in its time, a micropolygon covers
//! little, and only the one sample of each pixel that belongs to the stratum is tried.

use crate::cpu::blur::quad::{At, Quad};
use crate::cpu::lanes::{LANES, Lanes};
use crate::cpu::micropolygon::Micropolygon;
use crate::cpu::samples::edges::AtEdge;
use crate::cpu::samples::{EDGE, LensSamples, SampledGrid, Samples, Tally};

impl Samples {
    /// Sample a micropolygon between two times; `strata` are the bounds of time and lens.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(super) fn through_lens<L: Lanes>(
        &mut self,
        quad: &Quad,
        [from, until]: [f32; 2],
        strata: &[[[f32; 2]; 3]],
        samples: &LensSamples,
        point: usize,
        grid: &SampledGrid<'_>,
        tally: &mut Tally,
    ) {
        for (stratum, bounds) in strata.iter().enumerate() {
            if bounds[0][1] < from || bounds[0][0] >= until {
                continue;
            }
            let [xs, ys] = quad.bound(*bounds).map(|[lo, hi]| [lo - EDGE, hi + EDGE]);
            let Some(([px0, px1], [py0, py1])) = self.pixels_within(xs, ys) else { continue };
            for py in py0..=py1 {
                let row = (stratum * self.height + py) * self.width;
                for px in (px0..=px1).step_by(LANES) {
                    let k = row + px;
                    let at = At {
                        x: L::load(&samples.x, k),
                        y: L::load(&samples.y, k),
                        t: L::load(&samples.time, k),
                        lens: [L::load(&samples.lens[0], k), L::load(&samples.lens[1], k)],
                    };
                    let met = quad.meet::<L, true>(&at);
                    // Lanes beyond the row are other pixels'.
                    let count = (px1 + 1 - px).min(LANES);
                    let mut takes = met.within(&at, [xs, ys], [from, until]).bits() & ((1 << count) - 1);
                    tally.tried += count as u64;
                    if takes == 0 {
                        continue;
                    }
                    let (times, in_first) = (at.t.to_array(), met.in_first.bits());
                    let both = in_first & met.in_second.bits();
                    let ([p0, p1, p2], [q0, q1, q2]) = (met.first, met.second);
                    let first = [p0.to_array(), p1.to_array(), p2.to_array()];
                    let other = [q0.to_array(), q1.to_array(), q2.to_array()];
                    while takes != 0 {
                        let l = takes.trailing_zeros() as usize;
                        takes &= takes - 1;
                        let sample = samples.sample[k + l] as usize;
                        if self.z[sample] <= quad.near {
                            continue;
                        }
                        let mut second = in_first >> l & 1 == 0;
                        let mut parts = if second { &other } else { &first }.map(|v| v[l]);
                        let mut at_edge = AtEdge::default();
                        if grid.as_layers && (both >> l & 1 == 1 || !quad.is_clear(parts)) {
                            let moment = [times[l], samples.lens[0][k + l], samples.lens[1][k + l]];
                            let place = [samples.x[k + l], samples.y[k + l]];
                            let Some(found) = quad.at_edges(place, moment, point, grid) else { continue };
                            (second, parts, at_edge) = found;
                        }
                        let (w, z) = quad.at(second, parts, times[l]);
                        if z < self.z[sample] {
                            tally.hit = true;
                            let micropolygon = Micropolygon::new(grid.index, point, second);
                            let area = || parts[0] + parts[1] + parts[2];
                            self.record(sample, z, micropolygon, ([w[1], w[2]], at_edge), grid, area);
                            self.mark(px + l, px + l, py, py);
                        }
                    }
                }
            }
        }
    }
}
