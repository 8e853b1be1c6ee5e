//! Motion blocks: what their calls come to at `MotionEnd` (RISpec 6.3).

use crate::context::motion_block::{MotionBlock, Moving};
use crate::context::open_object::Uniform;
use crate::context::quadrics::{one_sphere, quadric_patches};
use crate::context::state::Context;
use crate::gprim::quadric::Quadric;
use crate::gprim::variables::{attach_variables, uniform_numbers};
use crate::scene::attributes::Attribute;
use crate::scene::motion;
use crate::scene::patch::{Patch, TEXTURE_CORNERS};
use crate::scene::variables::VariableNames;
use glam::Mat4;
use ri::{Fail, Instances, Params, RiResult};

/// What is said where a block's primitives cannot be matched.
const CUT_DIFFERENTLY: &str = "the primitives of a motion block are cut differently: the first alone is drawn";

/// The greatest angle between two times of a rotation, radians: straight in between, a point is off its circle by less than a
/// hundredth of the radius.
const STEP: f32 = 0.262;

/// The most times between two of a rotation's own.
const MAX_STEPS: f32 = 256.0;

/// The times and calls of a motion block, of rotations about one axis with so many times between that the way is round: it is the
/// angle that goes evenly from one to the next.
fn turns(times: Vec<f32>, calls: Vec<Moving>) -> (Vec<f32>, Vec<Moving>) {
    let angles = calls.iter().map(|call| match (&calls[0], call) {
        (Moving::Turn(first, _), Moving::Turn(axis, angle)) if axis.dot(*first).abs() > 0.999_999 => {
            Some((*first, angle * axis.dot(*first).signum()))
        }
        _ => None,
    });
    let Some(angles) = angles.collect::<Option<Vec<_>>>() else { return (times, calls) };
    let (mut all, mut at) = (vec![times[0]], vec![Moving::Turn(angles[0].0, angles[0].1)]);
    for (t, pair) in times.windows(2).zip(angles.windows(2)) {
        let [(axis, a), (_, b)] = [pair[0], pair[1]];
        let n = ((b - a).abs() / STEP).ceil().clamp(1.0, MAX_STEPS) as usize;
        for k in 1..=n {
            let part = k as f32 / n as f32;
            all.push(if k == n { t[1] } else { t[0] + (t[1] - t[0]) * part });
            at.push(Moving::Turn(axis, a + (b - a) * part));
        }
    }
    (all, at)
}

/// The times and quadrics of a motion block. Where angles change, others are added between two times, enough that the way is round: it is
/// the quadric's numbers that go evenly from one time to the next.
fn between(times: &[f32], quadrics: Vec<(Quadric, Params)>) -> (Vec<f32>, Vec<(Quadric, Params)>) {
    let mut all = vec![];
    for (t, pair) in times.windows(2).zip(quadrics.windows(2)) {
        let [(a, params), (b, _)] = pair else { continue };
        let n = (a.turned_to(b) / STEP).ceil().clamp(1.0, MAX_STEPS) as usize;
        all.push((t[0], (*a, params.clone())));
        for part in (1..n).map(|k| k as f32 / n as f32) {
            all.push((t[0] + (t[1] - t[0]) * part, (a.mixed(b, part), params.clone())));
        }
    }
    all.extend(times.last().copied().zip(quadrics.into_iter().next_back()));
    all.into_iter().unzip()
}

impl Context {
    /// The end of a motion block.
    pub(super) fn close(&mut self, block: MotionBlock) -> RiResult {
        let MotionBlock { times, calls, first, n_set, colors, .. } = block;
        if let Some(first) = first {
            self.attributes = *first;
        }
        for which in [Attribute::Color, Attribute::Opacity] {
            let keys = colors.iter().filter(|(own, _)| *own == which).map(|(_, value)| *value);
            self.moving_color(which, &times, &keys.collect::<Vec<_>>())?;
        }
        if calls.is_empty() && (n_set > 0 || !colors.is_empty()) {
            return Ok(());
        }
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
        let is_transform = |call: &&Moving| matches!(call, Moving::Concat(_) | Moving::Turn(..) | Moving::Set(_));
        let transforms = calls.iter().filter(is_transform).count();
        if transforms == calls.len() {
            let (times, calls) = turns(times, calls);
            self.moving_transform(&times, &calls);
            return Ok(());
        }
        if transforms > 0 {
            return Err(Fail::new("a motion block has transformations and primitives"));
        }
        let (times, calls) = self.alike(times, calls);
        self.moving_primitives(&times, calls)
    }

    /// The calls of a motion block, or the first alone if they are not of one kind.
    fn alike(&self, mut times: Vec<f32>, mut calls: Vec<Moving>) -> (Vec<f32>, Vec<Moving>) {
        let kind = std::mem::discriminant(&calls[0]);
        if calls.iter().any(|call| std::mem::discriminant(call) != kind) {
            self.scene.warn(CUT_DIFFERENTLY.into());
            times.truncate(1);
            calls.truncate(1);
        }
        (times, calls)
    }

    /// Primitives of one kind at the times of a motion block.
    fn moving_primitives(&mut self, times: &[f32], calls: Vec<Moving>) -> RiResult {
        let (mut patches, mut spheres, mut quadrics, mut blobbies) = (vec![], vec![], vec![], vec![]);
        for call in calls {
            match call {
                Moving::Patches(p, names) => patches.push((p, names)),
                Moving::Spheres(s, uniform, particles) => spheres.push((s, uniform, particles)),
                Moving::Quadric(quadric, params) => quadrics.push((quadric, params)),
                Moving::Blobby(call) => blobbies.push(*call),
                Moving::Concat(_) | Moving::Turn(..) | Moving::Set(_) => {}
            }
        }
        if !quadrics.is_empty() {
            self.moving_quadrics(times, quadrics)
        } else if !blobbies.is_empty() {
            self.moving_blobbies(times, &blobbies)
        } else if !spheres.is_empty() {
            self.moving_spheres(times, spheres)
        } else {
            self.moving_patches(times, patches)
        }
    }

    /// The colours or opacities of a motion block.
    fn moving_color(&mut self, which: Attribute, times: &[f32], values: &[[f32; 3]]) -> RiResult {
        let Some(first) = values.first() else { return Ok(()) };
        if values.len() != times.len() {
            let (n, of) = (values.len(), times.len());
            self.scene.warn(format!("a motion block of {of} times has {n} of `{which:?}`: the first holds"));
            return self.set_color(which, *first);
        }
        let keys: Vec<(f32, [f32; 3])> = times.iter().copied().zip(values.iter().copied()).collect();
        self.set_color_over_time(which, motion::at(&keys, self.options.shutter[0]), keys)
    }

    /// The transformations of a motion block, over what holds before it.
    fn moving_transform(&mut self, times: &[f32], calls: &[Moving]) {
        let before = |time: f32| if self.moves.is_empty() { self.transform } else { motion::at(&self.moves, time) };
        let keys = times.iter().zip(calls).map(|(time, call)| match call {
            Moving::Concat(m) => (*time, before(*time) * *m),
            Moving::Turn(axis, angle) => (*time, before(*time) * Mat4::from_axis_angle(*axis, *angle)),
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
        if let Some(radii) = radii.filter(|_| !varies && self.texture_corners() == TEXTURE_CORNERS) {
            let spheres = radii
                .into_iter()
                .zip(quadrics)
                .map(|(r, (_, params))| Ok((one_sphere(r), uniform_numbers(params)?, false)));
            return self.moving_spheres(times, spheres.collect::<Result<_, Fail>>()?);
        }
        if quadrics.iter().all(|(quadric, _)| quadric.sweep == 0.0) {
            return Err(Fail::new("the quadric's numbers make no surface"));
        }
        let (times, quadrics) = between(times, quadrics);
        let pieces = quadrics.iter().map(|(quadric, _)| quadric.pieces());
        let pieces = pieces.fold([1, 1], |[a, b], [c, d]| [a.max(c), b.max(d)]);
        let cut = quadrics.iter().map(|(quadric, params)| {
            let mut patches = quadric_patches(quadric, pieces)?;
            let names = attach_variables(&mut patches, params)?;
            Ok((patches, names))
        });
        self.moving_patches(&times, cut.collect::<Result<_, Fail>>()?)
    }

    /// The patches of a motion block: the same primitive at its times.
    pub(super) fn moving_patches(&mut self, times: &[f32], mut calls: Vec<(Vec<Patch>, VariableNames)>) -> RiResult {
        let (mut first, names) = calls.remove(0);
        if calls.iter().any(|(later, _)| later.len() != first.len()) {
            self.scene.warn(CUT_DIFFERENTLY.into());
            calls.clear();
        }
        if calls.is_empty() {
            return self.add_patches(first, names);
        }
        let differs = |a: &Patch, b: &Patch| a.varying != b.varying || a.uniform != b.uniform;
        if calls.iter().any(|(later, _)| first.iter().zip(later).any(|(a, b)| differs(a, b))) {
            self.warn_of_variables();
        }
        let (before, part) = motion::segment(times, self.options.shutter[0]);
        for (k, patch) in first.iter_mut().enumerate() {
            if before > 0 {
                let Patch { st, curved_st, varying, uniform, normals, .. } = calls[before - 1].0[k].clone();
                *patch = Patch { st, curved_st, varying, uniform, normals, ..patch.clone() };
            }
            if part > 0.0 {
                patch.blend_variables(&calls[before].0[k], part);
            }
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

    /// Say that variables do not move.
    pub(super) fn warn_of_variables(&mut self) {
        let what =
            "the variables of a primitive in a motion block are those of when the shutter opens; they do not move";
        self.scene.warn(what.into());
    }

    /// The spheres of a motion block, with the variables of each call: those of the last before the shutter opens hold.
    fn moving_spheres(&mut self, times: &[f32], mut calls: Vec<(Instances, Uniform, bool)>) -> RiResult {
        type Call = (Instances, Uniform, bool);
        let differs = |a: &Call, b: &Call| a.1 != b.1 || a.0.params != b.0.params;
        if calls.iter().any(|later| differs(&calls[0], later)) {
            self.warn_of_variables();
            let (before, _) = motion::segment(times, self.options.shutter[0]);
            if let Some((spheres, uniform, _)) = calls.get(before).cloned()
                && spheres.len() == calls[0].0.len()
            {
                calls[0].0.params = spheres.params;
                calls[0].1 = uniform;
            }
        }
        let later: Vec<Instances> = calls[1..].iter().map(|(spheres, ..)| spheres.clone()).collect();
        let Some((mut first, uniform, particles)) = calls.into_iter().next() else { return Ok(()) };
        let Some(last) = later.last() else { return self.add_spheres(first, uniform, particles) };
        if later.iter().any(|spheres| spheres.len() != first.len()) {
            self.scene.warn("the primitives of a motion block are not as many: the first alone is drawn".into());
            return self.add_spheres(first, uniform, particles);
        }
        if first.len() == 1 {
            // One sphere moves and grows as its space does.
            let before = self.place();
            let home = first.matrix(0).inverse();
            let places = later.iter().map(|spheres| Moving::Concat(spheres.matrix(0) * home));
            let places: Vec<Moving> = std::iter::once(Moving::Concat(Mat4::IDENTITY)).chain(places).collect();
            self.moving_transform(times, &places);
            let done = self.add_spheres(first, uniform, particles);
            (self.transform, self.moves) = before;
            return done;
        }
        if later.len() > 1 || later.iter().any(|spheres| spheres.scale != first.scale) {
            // Each goes its own way, as one sphere does.
            return (0..first.len()).try_for_each(|k| {
                let all = std::iter::once(&first).chain(&later);
                let own = all.map(|spheres| (spheres.alone(k), uniform.clone(), particles));
                self.moving_spheres(times, own.collect())
            });
        }
        first.moved = Some(([times[0], times[times.len() - 1]], last.position.clone()));
        self.add_spheres(first, uniform, particles)
    }

    /// `MotionBegin`.
    pub(super) fn open_motion_block(&mut self, times: Vec<f32>) -> RiResult {
        if self.motion.is_some() {
            return Err(Fail::new("MotionBegin within MotionBegin"));
        }
        if times.windows(2).any(|t| !(t[0] < t[1])) {
            return Err(Fail::new("the times of a motion block must rise"));
        }
        self.motion = Some(MotionBlock { times, calls: vec![], first: None, n_set: 0, colors: vec![], cuts: vec![] });
        Ok(())
    }
}
