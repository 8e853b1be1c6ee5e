//! Bounds of items: on the raster, over all their moments, displacement included.

use crate::scene::attributes::DisplacementBound;
use crate::scene::camera::{Camera, RasterBound};
use crate::scene::motion::Instant;
use crate::scene::shape::Shape;
use crate::scene::source::ItemView;
use glam::{Mat4, Vec3};

/// The greatest displacement of an item in world units.
pub fn displacement_reach(view: &ItemView<'_>, size: f32) -> f32 {
    if view.attributes.displacement.is_none() {
        return 0.0;
    }
    match view.attributes.displacement_bound {
        None => 0.1 * size,
        Some(DisplacementBound::Object(bound)) => bound * longest(view.object_to_world),
        Some(DisplacementBound::World(bound)) => bound,
    }
}

/// The length that a matrix makes of a unit along the axis that it stretches most.
pub fn longest(m: Mat4) -> f32 {
    [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.truncate().length()).into_iter().fold(0.0, f32::max)
}

/// The raster bound of an item over all its moments, displacement included; none where it is never in the depth range.
pub fn raster_bound(camera: &Camera, view: &ItemView<'_>, instants: &[Instant]) -> Option<RasterBound> {
    let bounds = instants.iter().filter_map(|instant| {
        let (min, max) = camera_box(instant.to_camera * view.to_world, view);
        if min.is_finite() && max.is_finite() { camera.bound(min, max) } else { None }
    });
    bounds.reduce(RasterBound::join)
}

/// The box of an item in camera space, displacement included.
fn camera_box(m: Mat4, view: &ItemView<'_>) -> (Vec3, Vec3) {
    let (min, max) = match view.shape {
        Shape::Sphere => {
            let row = |k: usize| Vec3::new(m.x_axis[k], m.y_axis[k], m.z_axis[k]).length();
            let (center, half) = (m.w_axis.truncate(), Vec3::new(row(0), row(1), row(2)));
            (center - half, center + half)
        }
        Shape::Patches(patches, _) => patches
            .iter()
            .flat_map(|patch| patch.p.iter().chain(patch.moves.iter().flat_map(|(_, p)| p)))
            .map(|p| m.transform_point3(*p))
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p))),
    };
    let reach = displacement_reach(view, 0.5 * (max - min).max_element());
    (min - reach, max + reach)
}
