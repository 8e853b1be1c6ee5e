//! What is out of focus: the strata are taken one by one. From a stratum's cell of the lens, and in its time, a micropolygon covers
//! little, and only the one sample of each pixel that belongs to the stratum is tried.

use super::{At, Quad};
use crate::cpu::lanes::{LANES, Lanes};
use crate::cpu::samples::{EDGE, Look, Samples, Tally};
use crate::cpu::visible::Micropolygon;
use crate::film::jitter::Jitter;

/// The moments of a bucket's samples: one stratum of time after another, in each pixel after pixel, which has one sample there.
#[derive(Default)]
pub struct Moments {
    /// Place, pixels of the whole picture: what is decided by it is decided alike in every bucket.
    x: Vec<f32>,
    y: Vec<f32>,
    /// Part of the time that the shutter is open.
    time: Vec<f32>,
    /// Place on the lens.
    lens: [Vec<f32>; 2],
    /// The sample among all of the bucket.
    sample: Vec<u32>,
}

impl Samples {
    /// Give the samples of a bucket their moments.
    pub fn set_moments(&mut self, jitter: &Jitter) {
        let Some(moments) = jitter.moments.as_ref().filter(|_| jitter.lens) else { return };
        let [sx, sy] = self.strata;
        let mut own = std::mem::take(&mut self.moments);
        let Moments { x, y, time, lens: [lens_x, lens_y], sample } = &mut own;
        [&mut *x, y, time, lens_x, lens_y].into_iter().for_each(Vec::clear);
        sample.clear();
        for stratum in 0..sx * sy {
            for (px, py) in (0..self.height).flat_map(|py| (0..self.width).map(move |px| (px, py))) {
                let ([column, row], moment) = moments.of(px as i64 + self.x0, py as i64 + self.y0, stratum);
                let k = self.index([px, py], [column as usize, row as usize]);
                x.push(self.x[k] + self.x0 as f32);
                y.push(self.y[k] + self.y0 as f32);
                time.push(moment[0]);
                lens_x.push(moment[1]);
                lens_y.push(moment[2]);
                sample.push(k as u32);
            }
        }
        // The last are tested with lanes beyond them, which are nowhere.
        x.extend([f32::INFINITY; LANES]);
        [y, time, lens_x, lens_y].into_iter().for_each(|v| v.extend([0.0; LANES]));
        self.moments = own;
    }

    /// Sample a micropolygon between two times; `strata` are the bounds of time and lens.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(super) fn through_lens<L: Lanes>(
        &mut self,
        quad: &Quad,
        [from, until]: [f32; 2],
        strata: &[[[f32; 2]; 3]],
        moments: &Moments,
        point: usize,
        look: &Look,
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
                        x: L::load(&moments.x, k),
                        y: L::load(&moments.y, k),
                        t: L::load(&moments.time, k),
                        lens: [L::load(&moments.lens[0], k), L::load(&moments.lens[1], k)],
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
                    let ([p0, p1, p2], [q0, q1, q2]) = (met.first, met.second);
                    let first = [p0.to_array(), p1.to_array(), p2.to_array()];
                    let other = [q0.to_array(), q1.to_array(), q2.to_array()];
                    while takes != 0 {
                        let l = takes.trailing_zeros() as usize;
                        takes &= takes - 1;
                        let sample = moments.sample[k + l] as usize;
                        if self.z[sample] <= quad.near {
                            continue;
                        }
                        let second = in_first >> l & 1 == 0;
                        let parts = if second { &other } else { &first };
                        let (w, z) = quad.at(second, [parts[0][l], parts[1][l], parts[2][l]], times[l]);
                        if z < self.z[sample] {
                            tally.hit = true;
                            let micropolygon = Micropolygon::new(look.grid, point, second);
                            self.keep(sample, z, micropolygon, [w[1], w[2]], look);
                            self.mark(px + l, px + l, py, py);
                        }
                    }
                }
            }
        }
    }
}
