//! Quadrics (RISpec 5.1): whole spheres as instances, all others as patches.

use crate::context::motion_block::Moving;
use crate::context::state::Context;
use crate::gprim::perspective::is_projective;
use crate::gprim::quadric::{Outline, Quadric};
use crate::gprim::variables::{Counts, attach_variables, uniform_numbers};
use crate::scene::patch::{Patch, TEXTURE_CORNERS};
use glam::Vec3;
use ri::{Fail, InstanceShape, Instances, Params, RiResult};

impl Context {
    pub(super) fn draw_sphere(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        // A sphere that grows from a point in a motion block is not drawn.
        let may_be_drawn = radius.is_finite() && (radius != 0.0 || self.motion.is_none());
        if !(may_be_drawn && z_min.is_finite() && z_max.is_finite() && sweep.is_finite()) {
            return Err(Fail::new(format!(
                "a sphere of radius {radius} from {z_min} to {z_max} over {sweep}° cannot be drawn"
            )));
        }
        if radius == 0.0 {
            self.say_empty();
            return Ok(());
        }
        let r = radius.abs();
        let varies = params.iter().any(|p| !p.decl.class.is_whole());
        let is_whole = z_min <= -r && z_max >= r && sweep.abs() >= 360.0;
        let own_corners = self.texture_corners() == TEXTURE_CORNERS;
        if is_whole && !varies && own_corners && self.motion.is_none() && !is_projective(&self.transform) {
            self.say_sweep(sweep);
            self.say_surplus(&params, Counts::FOUR);
            let uniform = uniform_numbers(params)?;
            return self.add_spheres(one_sphere(r), uniform, false);
        }
        let angle = |z: f32| (z / r).clamp(-1.0, 1.0).asin();
        self.quadric(Outline::Circle([0.0; 2], r, [z_min, z_max].map(angle)), sweep, params)
    }

    /// Warn of what has no area, as a particle that has shrunk to a point.
    fn say_empty(&self) {
        self.scene.warn("a quadric whose numbers make no area is not seen".into());
    }

    /// Warn of a sweep of more than a whole turn.
    fn say_sweep(&self, sweep: f32) {
        if sweep.is_finite() && sweep.abs() > 360.0 {
            self.scene.warn(format!("a quadric's sweep is {sweep}°, expected at most 360: it is one turn"));
        }
    }

    /// A quadric: a profile, swept.
    pub(super) fn quadric(&mut self, outline: Outline, sweep: f32, params: Params) -> RiResult {
        self.say_texts(&params);
        self.say_surplus(
            &params,
            Counts { varying: usize::MAX, vertex: usize::MAX, facevarying: usize::MAX, ..Counts::FOUR },
        );
        let quadric = Quadric { outline, sweep };
        if let Some(block) = &mut self.motion {
            block.calls.push(Moving::Quadric(quadric, params));
            return Ok(());
        }
        if sweep == 0.0 {
            self.say_empty();
            return Ok(());
        }
        self.say_sweep(sweep);
        let mut patches = quadric_patches(&quadric, quadric.pieces())?;
        if patches.iter().all(has_no_area) {
            self.say_empty();
        }
        let names = attach_variables(&mut patches, &params)?;
        self.add_patches(patches, names)
    }
}

/// The patches of a quadric, of so many pieces; an error if its numbers are none.
pub(super) fn quadric_patches(quadric: &Quadric, pieces: [usize; 2]) -> Result<Vec<Patch>, Fail> {
    let patches = if quadric.sweep.is_finite() { quadric.patches(pieces) } else { vec![] };
    let sound = |patch: &Patch| patch.p.iter().all(|p| p.is_finite());
    if !patches.is_empty() && patches.iter().all(sound) {
        return Ok(patches);
    }
    Err(Fail::new("the quadric's numbers make no surface"))
}

/// Whether a patch is a line, straight or not, or a point.
fn has_no_area(patch: &Patch) -> bool {
    if (0..16).all(|k| patch.p[k] == patch.p[k % 4]) || (0..16).all(|k| patch.p[k] == patch.p[k / 4 * 4]) {
        return true;
    }
    let from = |k: usize| patch.p[k] - patch.p[0];
    let longest =
        (0..16).map(from).fold(Vec3::ZERO, |a, b| if b.length_squared() > a.length_squared() { b } else { a });
    (0..16).all(|k| from(k).cross(longest) == Vec3::ZERO)
}

/// A sphere about the origin, as an instance array of one, so that object space keeps its unit.
pub(super) fn one_sphere(radius: f32) -> Instances {
    Instances {
        shape: InstanceShape::Sphere,
        position: vec![[0.0; 3]],
        orientation: vec![],
        scale: vec![[radius; 3]],
        offset: vec![],
        params: vec![],
        moved: None,
    }
}
