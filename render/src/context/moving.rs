//! Motion blocks: what their calls come to at `MotionEnd` (RISpec 6.3).

use crate::context::motion_block::{MotionBlock, Moving};
use crate::context::primitives::{one_sphere, quadric_patches};
use crate::context::state::Context;
use crate::gprim::quadric::Quadric;
use crate::gprim::variables::{attach_variables, uniform_numbers};
use crate::scene::attributes::TEXTURE_CORNERS;
use crate::scene::motion;
use crate::scene::patch::Patch;
use crate::scene::variables::{VariableName, VariableNames};
use glam::Mat4;
use ri::{Fail, Instances, Params, RiResult};

/// What is said where a block's primitives cannot be matched.
const CUT_DIFFERENTLY: &str = "the primitives of a motion block are cut differently: the first alone is drawn";

impl Context {
    /// The end of a motion block.
    pub(super) fn close(&mut self, block: MotionBlock) -> RiResult {
        let MotionBlock { times, calls, .. } = block;
        if calls.len() != times.len() {
            return Err(Fail::new(format!(
                "a motion block of {} times has {} calls that can move",
                times.len(),
                calls.len()
            )));
        }
        if calls.is_empty() {
            return Ok(());
        }
        let transforms = calls.iter().filter(|call| matches!(call, Moving::Concat(_) | Moving::Set(_))).count();
        if transforms == calls.len() {
            self.moving_transform(&times, &calls);
            return Ok(());
        }
        if transforms > 0 {
            return Err(Fail::new("a motion block has transformations and primitives"));
        }
        if calls.iter().all(|call| matches!(call, Moving::Quadric(..))) {
            let quadrics = calls.into_iter().filter_map(|call| match call {
                Moving::Quadric(quadric, params) => Some((quadric, params)),
                _ => None,
            });
            return self.moving_quadrics(&times, quadrics.collect());
        }
        let first_is_spheres = matches!(calls[0], Moving::Spheres(..));
        let (mut patches, mut spheres) = (vec![], vec![]);
        for call in calls {
            match call {
                Moving::Patches(p, names) => patches.push((p, names)),
                Moving::Spheres(s, uniform) => spheres.push((s, uniform)),
                Moving::Quadric(..) | Moving::Concat(_) | Moving::Set(_) => {}
            }
        }
        if !patches.is_empty() && !spheres.is_empty() {
            self.scene.warn(CUT_DIFFERENTLY.into());
            patches.truncate(1);
            spheres.truncate(1);
        }
        if first_is_spheres { self.moving_spheres(&times, spheres) } else { self.moving_patches(&times, patches) }
    }

    /// The transformations of a motion block, over what holds before it.
    fn moving_transform(&mut self, times: &[f32], calls: &[Moving]) {
        let before = |time: f32| if self.moves.is_empty() { self.transform } else { motion::at(&self.moves, time) };
        let keys = times.iter().zip(calls).map(|(time, call)| match call {
            Moving::Concat(m) => (*time, before(*time) * *m),
            Moving::Set(m) => (*time, *m),
            _ => (*time, before(*time)),
        });
        self.moves = keys.collect();
        self.transform = motion::at(&self.moves, self.options.shutter[0]);
    }

    /// The quadrics of a motion block, cut alike however far they go round.
    fn moving_quadrics(&mut self, times: &[f32], quadrics: Vec<(Quadric, Params)>) -> RiResult {
        let varies = quadrics.iter().any(|(_, params)| params.iter().any(|p| !p.decl.class.is_whole()));
        let radii: Option<Vec<f32>> = quadrics.iter().map(|(quadric, _)| quadric.whole_sphere()).collect();
        if let Some(radii) = radii.filter(|_| !varies && self.attributes.texture_corners == TEXTURE_CORNERS) {
            let spheres =
                radii.into_iter().zip(quadrics).map(|(r, (_, params))| Ok((one_sphere(r), uniform_numbers(params)?)));
            return self.moving_spheres(times, spheres.collect::<Result<_, Fail>>()?);
        }
        if quadrics.iter().all(|(quadric, _)| quadric.sweep == 0.0) {
            return Err(Fail::new("the quadric's numbers make no surface"));
        }
        let pieces = quadrics.iter().map(|(quadric, _)| quadric.pieces());
        let pieces = pieces.fold([1, 1], |[a, b], [c, d]| [a.max(c), b.max(d)]);
        let cut = quadrics.iter().map(|(quadric, params)| {
            let mut patches = quadric_patches(quadric, pieces)?;
            let names = attach_variables(&mut patches, params)?;
            Ok((patches, names))
        });
        self.moving_patches(times, cut.collect::<Result<_, Fail>>()?)
    }

    /// The patches of a motion block: the same primitive at its times.
    fn moving_patches(&mut self, times: &[f32], mut calls: Vec<(Vec<Patch>, VariableNames)>) -> RiResult {
        let (mut first, names) = calls.remove(0);
        if calls.iter().any(|(later, _)| later.len() != first.len()) {
            self.scene.warn(CUT_DIFFERENTLY.into());
            calls.clear();
        }
        if calls.is_empty() {
            return self.add_patches(first, names);
        }
        for (k, patch) in first.iter_mut().enumerate() {
            let keys: Vec<_> = times
                .iter()
                .copied()
                .zip(std::iter::once(patch.p).chain(calls.iter().map(|(later, _)| later[k].p)))
                .collect();
            (patch.p, patch.moves) = motion::in_shutter(&keys, self.options.shutter);
            patch.flat &= patch.moves.is_empty();
        }
        self.add_patches(first, names)
    }

    /// The spheres of a motion block, with the variables of each call: those of the first hold.
    fn moving_spheres(&mut self, times: &[f32], calls: Vec<(Instances, Vec<(VariableName, Vec<f32>)>)>) -> RiResult {
        let later: Vec<Instances> = calls[1..].iter().map(|(spheres, _)| spheres.clone()).collect();
        let Some((mut first, uniform)) = calls.into_iter().next() else { return Ok(()) };
        let Some(last) = later.last() else { return self.add_spheres(first, uniform) };
        if later.iter().any(|spheres| spheres.len() != first.len()) {
            self.scene.warn("the primitives of a motion block are not as many: the first alone is drawn".into());
            return self.add_spheres(first, uniform);
        }
        if first.len() == 1 {
            // One sphere moves and grows as its space does.
            let before = self.place();
            let home = first.matrix(0).inverse();
            let places = later.iter().map(|spheres| Moving::Concat(spheres.matrix(0) * home));
            let places: Vec<Moving> = std::iter::once(Moving::Concat(Mat4::IDENTITY)).chain(places).collect();
            self.moving_transform(times, &places);
            let done = self.add_spheres(first, uniform);
            (self.transform, self.moves) = before;
            return done;
        }
        if later.iter().any(|spheres| spheres.scale != first.scale) {
            self.scene.warn("points keep their first width while they move".into());
        }
        if later.len() > 1 {
            self.scene.warn("points move straight from the first time of a motion block to the last".into());
        }
        first.moved = Some(([times[0], times[times.len() - 1]], last.position.clone()));
        self.add_spheres(first, uniform)
    }

    /// `MotionBegin`.
    pub(super) fn open_motion_block(&mut self, times: Vec<f32>) -> RiResult {
        if self.motion.is_some() {
            return Err(Fail::new("MotionBegin within MotionBegin"));
        }
        if times.windows(2).any(|t| !(t[0] < t[1])) {
            return Err(Fail::new("the times of a motion block must rise"));
        }
        self.motion = Some(MotionBlock { times, calls: vec![], cuts: vec![] });
        Ok(())
    }
}
