//! Motion blocks: what their calls are kept as until `MotionEnd`, and what comes of them then (RISpec 6.3).

use super::Context;
use crate::motion;
use crate::scene::{Patch, Shape, SourceShape};
use glam::{Mat4, Vec3};
use ri::{Fail, Instances, RiResult};

/// A transformation at rising times.
pub(super) type Keys = Vec<(f32, Mat4)>;

/// A transformation as the shutter opens, and its keys if it moves.
pub(super) type Place = (Mat4, Keys);

/// An open `MotionBegin`: its times, and what its calls were.
pub(super) struct MotionBlock {
    pub(super) times: Vec<f32>,
    pub(super) calls: Vec<Moving>,
}

/// A call within a motion block.
pub(super) enum Moving {
    /// A transformation after the current one.
    Concat(Mat4),
    /// One in its place.
    Set(Mat4),
    Patches(Vec<Patch>),
    Spheres(Instances, Vec<(String, Vec<f32>)>),
}

impl Context {
    /// The end of a motion block.
    pub(super) fn close(&mut self, block: MotionBlock) -> RiResult {
        let MotionBlock { times, calls } = block;
        if calls.len() != times.len() {
            return Err(Fail::new(format!(
                "a motion block of {} times has {} calls that can move",
                times.len(),
                calls.len()
            )));
        }
        let kind = |call: &Moving| match call {
            Moving::Concat(_) | Moving::Set(_) => 0,
            Moving::Patches(_) => 1,
            Moving::Spheres(..) => 2,
        };
        let Some(first) = calls.first().map(kind) else { return Ok(()) };
        if calls.iter().any(|call| kind(call) != first) {
            if calls.iter().any(|call| kind(call) == 0) {
                return Err(Fail::new("a motion block has transformations and primitives"));
            }
            self.scene.warn("the primitives of a motion block are cut differently: the first alone is drawn".into());
        }
        let (mut patches, mut spheres, mut numbers) = (vec![], vec![], vec![]);
        if first == 0 {
            self.moving_transform(&times, &calls);
            return Ok(());
        }
        for call in calls {
            match call {
                Moving::Patches(p) => patches.push(p),
                Moving::Spheres(s, uniform) => {
                    spheres.push(s);
                    numbers = uniform;
                }
                Moving::Concat(_) | Moving::Set(_) => {}
            }
        }
        if first == 1 { self.moving_patches(&times, patches) } else { self.moving_spheres(&times, spheres, numbers) }
    }

    /// Another transformation in place of the current one.
    pub(super) fn set_transform(&mut self, m: Mat4) -> RiResult {
        match &mut self.motion {
            Some(block) => block.calls.push(Moving::Set(m)),
            None => (self.transform, self.moves) = (m, vec![]),
        }
        Ok(())
    }

    pub(super) fn place(&self) -> Place {
        (self.transform, self.moves.clone())
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

    /// The patches of a motion block: the same primitive at its times.
    fn moving_patches(&mut self, times: &[f32], mut calls: Vec<Vec<Patch>>) -> RiResult {
        let mut first = calls.remove(0);
        if calls.iter().any(|later| later.len() != first.len()) {
            self.scene.warn("the primitives of a motion block are cut differently: the first alone is drawn".into());
            return self.add_patches(first);
        }
        for (k, patch) in first.iter_mut().enumerate() {
            let keys: Vec<_> =
                times.iter().copied().zip(std::iter::once(patch.p).chain(calls.iter().map(|c| c[k].p))).collect();
            (patch.p, patch.moves) = motion::in_shutter(&keys, self.options.shutter);
            patch.flat &= patch.moves.is_empty();
        }
        self.add_patches(first)
    }

    /// The spheres of a motion block.
    fn moving_spheres(
        &mut self,
        times: &[f32],
        mut calls: Vec<Instances>,
        uniform: Vec<(String, Vec<f32>)>,
    ) -> RiResult {
        let mut first = calls.remove(0);
        let (Some(last), Some([open, close])) = (calls.pop(), times.first().zip(times.last()).map(|(a, b)| [*a, *b]))
        else {
            return self.add_spheres(first, uniform);
        };
        if last.len() != first.len() {
            self.scene.warn("the primitives of a motion block are not as many: the first alone is drawn".into());
            return self.add_spheres(first, uniform);
        }
        let (a, b) = (first.scale[0][0], last.scale[0][0]);
        if first.len() == 1 && a != b {
            // A ball that grows is one whose space does.
            let before = self.place();
            let grow = [Moving::Concat(Mat4::IDENTITY), Moving::Concat(Mat4::from_scale(Vec3::splat(b / a)))];
            self.moving_transform(&[open, close], &grow);
            let done = self.add_spheres(first, uniform);
            (self.transform, self.moves) = before;
            return done;
        }
        if first.scale != last.scale {
            self.scene.warn("points keep their first width while they move".into());
        }
        first.moved = Some(([open, close], last.position));
        self.add_spheres(first, uniform)
    }

    /// Spheres by columns, or as parts of the object that is open.
    pub(super) fn add_spheres(&mut self, instances: Instances, uniform: Vec<(String, Vec<f32>)>) -> RiResult {
        if let Some(block) = &mut self.motion {
            block.calls.push(Moving::Spheres(instances, uniform));
            return Ok(());
        }
        if self.open_object.is_none() {
            return self.push(SourceShape::Spheres(instances), uniform);
        }
        let outer = self.transform;
        for i in 0..instances.len() {
            self.transform = outer * instances.matrix(i);
            self.add(Shape::Sphere, uniform.clone())?;
        }
        self.transform = outer;
        Ok(())
    }
}
