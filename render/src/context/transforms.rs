//! Calls that concatenate transformations.

use crate::context::state::Context;
use glam::{Mat4, Vec3};
use ri::{Fail, RiResult};

impl Context {
    /// Concatenate a perspective.
    pub(super) fn concat_perspective(&mut self, fov: f32) -> RiResult {
        if !(fov > 0.0 && fov < 179.9) {
            return Err(Fail::new(format!("the angle of Perspective is {fov}, expected 0 to 179.9 degrees")));
        }
        if self.to_camera.is_none() && self.transform == Mat4::IDENTITY && self.options.fov.is_none() {
            // Of a camera it is what a projection is.
            self.options.fov = Some(fov);
            return Ok(());
        }
        if self.to_camera.is_none() && self.open_object.is_none() {
            let message =
                "`Perspective` after other transformations of the camera, expected `Projection \"perspective\"`";
            return Err(Fail::new(message));
        }
        let f = 1.0 / (0.5 * fov.to_radians()).tan();
        // x and y over z; z between 0 and 1 of the near and far plane 1 and infinity (RISpec 4.3).
        let m = [f, 0.0, 0.0, 0.0, 0.0, f, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, -1.0, 0.0];
        self.concat(Mat4::from_cols_array(&m), "`Perspective`")
    }

    /// Concatenate a skew.
    pub(super) fn concat_skew(&mut self, angle: f32, from: [f32; 3], to: [f32; 3]) -> RiResult {
        if !(angle.abs() < 90.0) {
            return Err(Fail::new(format!("the angle of a skew is {angle}, expected less than 90 degrees either way")));
        }
        // Points move along `to`, by as much as turns `from` by the angle towards it.
        let (a, b) = (Vec3::from(from), Vec3::from(to));
        let (Some(a), Some(b)) = (a.try_normalize(), b.try_normalize()) else {
            return Err(Fail::new("a direction of a skew is zero"));
        };
        let (along, across) = (a.dot(b), (1.0 - a.dot(b).powi(2)).max(0.0).sqrt());
        if across < 1e-6 {
            return Err(Fail::new("the directions of a skew are the same"));
        }
        let side = (b - a * along) / across;
        // What stands straight along `a` is turned by the angle: a unit along it moves by this much towards `side`.
        let turned = angle.to_radians().tan();
        let shift = side * turned;
        let m = Mat4::from_cols(
            (Vec3::X + shift * a.x).extend(0.0),
            (Vec3::Y + shift * a.y).extend(0.0),
            (Vec3::Z + shift * a.z).extend(0.0),
            glam::Vec4::W,
        );
        self.concat(m, "`Skew`")
    }
}
