//! Motion while the shutter is open: values at rising times, straight in between.
//!
//! Streams give keys in their own time; a scene has them in parts of the time that the shutter is open, 0 to 1, and everything
//! else of the scene is as at 0: that is when surfaces are diced, shaded and cast their shadows.

use crate::scene::camera::Camera;
pub use crate::scene::keys::{at, in_shutter, later, segment};
use crate::scene::shape::Shape;
use crate::scene::source::ItemView;
use glam::{Mat4, Vec3};

/// A moment of an item's motion.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Part of the time that the shutter is open.
    pub time: f32,
    /// Where the item stood in the world as the shutter opened → camera space now.
    pub to_camera: Mat4,
    /// The eye, as seen from the item: in the world as the shutter opened. In parallel projection, the direction that it looks in.
    pub eye: Vec3,
}

/// Where the item stood in the world as the shutter opened → where it stands at a part of the time that that is open.
pub fn carried(view: &ItemView<'_>, time: f32) -> Mat4 {
    let home = view.source.to_world;
    later(home, &view.source.moves, time) * Mat4::from_translation(view.shift * time) * home.inverse()
}

/// The moments between which an item moves straight: only the first if it stands still before a camera that does.
pub fn instants(camera: &Camera, view: &ItemView<'_>, out: &mut Vec<Instant>) {
    let seen_from = |to_world: Mat4| {
        if camera.perspective { to_world.transform_point3(Vec3::ZERO) } else { to_world.transform_vector3(Vec3::Z) }
    };
    out.clear();
    out.push(Instant { time: 0.0, to_camera: camera.to_camera, eye: seen_from(camera.to_world) });
    let deformed = match view.shape {
        Shape::Patches(patches, _) => patches.first().map_or(&[][..], |p| p.moves.as_slice()),
        Shape::Sphere => &[],
    };
    let own = !view.source.moves.is_empty() || view.shift != Vec3::ZERO;
    if !own && camera.moves.is_empty() && deformed.is_empty() {
        return;
    }
    let mut times: Vec<f32> = camera.moves.iter().chain(&view.source.moves).map(|(t, _)| *t).collect();
    times.extend(deformed.iter().map(|(t, _)| *t));
    if view.shift != Vec3::ZERO {
        times.push(1.0);
    }
    times.sort_by(f32::total_cmp);
    times.dedup();
    for time in times {
        let mut to_camera = later(camera.to_camera, &camera.moves, time);
        if own {
            to_camera *= carried(view, time);
        }
        out.push(Instant { time, to_camera, eye: seen_from(to_camera.inverse()) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_cut_to_the_shutter() {
        let keys = [(0.0, [0.0; 3]), (1.0, [2.0; 3]), (3.0, [4.0; 3])];
        assert_eq!(at(&keys, -1.0), [0.0; 3]);
        assert_eq!(at(&keys, 0.5), [1.0; 3]);
        assert_eq!(at(&keys, 2.0), [3.0; 3]);
        assert_eq!(at(&keys, 9.0), [4.0; 3]);
        let (first, later) = in_shutter(&keys, [0.5, 2.0]);
        assert_eq!((first, later.len()), ([1.0; 3], 2));
        assert!((later[0].0 - 1.0 / 3.0).abs() < 1e-6 && later[0].1 == [2.0; 3] && later[1] == (1.0, [3.0; 3]));
        assert_eq!(in_shutter(&keys, [1.0, 1.0]), ([2.0; 3], vec![]));
    }
}
