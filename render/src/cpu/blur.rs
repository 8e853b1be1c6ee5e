//! Sampling what moves or is out of focus: every sample has a moment and a place on the lens, and is tried against the
//! micropolygon as it is seen at that moment from there.
//!
//! Through a lens, the strata are taken one by one and several pixels at a time ([`lens`]); without one, pixels one by one and
//! several strata of time at a time ([`moving`]).

mod lens;
mod moving;
pub mod quad;

use crate::cpu::blur::quad::{Quad, Track};
use crate::cpu::lanes::{Lanes, with_lanes};
use crate::cpu::samples::{SampledGrid, Samples, Tally};

impl Samples {
    with_lanes! {
        /// Sample micropolygons of a grid in rows of `nu` points, each named by its first point.
        pub fn blurred = blurred_lanes(nu: usize, micropolygons: &[u32], track: &Track<'_>, grid: &SampledGrid<'_>) -> Tally
    }

    #[inline(always)]
    fn blurred_lanes<L: Lanes>(
        &mut self,
        nu: usize,
        micropolygons: &[u32],
        track: &Track<'_>,
        grid: &SampledGrid<'_>,
    ) -> Tally {
        let mut tally = Tally::default();
        let Some(strata) = &track.jitter.moments else { return tally };
        let lens = std::mem::take(&mut self.lens);
        let last = track.instants.len() - 1;
        for point in micropolygons {
            let k = *point as usize;
            for key in 0..last.max(1) {
                let quad = Quad::new([k, k + 1, k + nu + 1, k + nu], track, key, grid.side);
                // The last key lasts to the end.
                let until = if key + 1 < last { track.instants[key + 1].time } else { f32::INFINITY };
                let times = [track.instants[key].time, until];
                if track.camera.has_lens() {
                    self.through_lens::<L>(&quad, times, &strata.bounds, &lens, k, grid, &mut tally);
                } else if !grid.as_layers {
                    self.moving::<L, true>(&quad, times, &strata.bounds, k, grid, &mut tally);
                } else {
                    self.moving::<L, false>(&quad, times, &strata.bounds, k, grid, &mut tally);
                }
            }
        }
        self.lens = lens;
        tally
    }
}
