//! Bound every shape by an axis-aligned box, grown by its margin.
//! in   position, orientation, velocity        [n_bodies]
//!      shape_kind, shape_size, shape_pose     [n_shapes]  m
//! inout roomy                                 [n_shapes]  m, boxes that pairs were found for
//! out  place                                  [n_shapes]  where each shape is
//!      margin                                 [n_shapes]  m, how far from its surface contacts are looked for: δ + |v| h
//!      aabb                                   [n_shapes]  m, world; empty for a body that is absent
//! Source: paper §3, before stage 1; the list of pairs that outlives a step is Verlet's (1967).
//!
//! Pairs are not looked for at every step: boxes are given room to move, pairs are found for these, and the list holds until a
//! box leaves its own. Contacts hang on the tight boxes alone, so that the room changes no result but their order.

use super::{Aabb, fill_rows};
use crate::{Model, Pose, ShapeKind, State};
use glam::{DMat3, DVec3, Vec3A};

/// The stage.
pub fn run(model: &Model, state: &State, place: &mut Vec<Pose>, margin: &mut Vec<f64>, aabb: &mut Vec<Aabb>) {
    let n = model.n_shapes();
    place.resize(n, Pose::default());
    margin.resize(n, 0.0);
    aabb.resize(n, Aabb::default());
    fill_rows(place, |s| {
        let body = model.shape_body[s] as usize;
        let own = Pose { position: state.position[body], orientation: state.orientation[body] };
        if model.shape_kind[s] == ShapeKind::Sphere && model.shape_pose[s].position == DVec3::ZERO {
            return own;
        }
        own.place(&model.shape_pose[s])
    });
    let place = &*place;
    fill_rows(margin, |s| {
        let body = model.shape_body[s] as usize;
        let arm = model.shape_pose[s].position.length() + non_round(model.shape_kind[s], model.shape_size[s]);
        let spin = if arm > 0.0 { state.angular_velocity[body].length() } else { 0.0 };
        model.envelope + (state.velocity[body].length() + spin * arm) * model.step
    });
    let margin = &*margin;
    fill_rows(aabb, |s| {
        if model.absent[model.shape_body[s] as usize] {
            return Aabb::EMPTY;
        }
        let at = &place[s];
        let reach = reach_of(model.shape_kind[s], model.shape_size[s], || DMat3::from_quat(at.orientation)) + margin[s];
        Aabb::about(at.position, reach)
    });
}

/// Steps for which a box has room at the speed of its shape.
const STEPS: f64 = 5.0;
/// Room at rest, in half the least edge of the box.
const ROOM: f32 = 0.04;

/// Give the boxes room again if one has left its own; whether pairs must be found again.
pub fn renew(model: &Model, state: &State, place: &[Pose], aabb: &[Aabb], roomy: &mut Vec<Aabb>) -> bool {
    if roomy.len() == aabb.len() && aabb.iter().zip(&*roomy).all(|(b, room)| room.holds(b)) {
        return false;
    }
    roomy.resize(aabb.len(), Aabb::default());
    fill_rows(roomy, |s| {
        let (body, b) = (model.shape_body[s] as usize, aabb[s]);
        if model.inv_mass[body] == 0.0 || b.min.x > b.max.x {
            return b;
        }
        let arm =
            (place[s].position - state.position[body]).length() + non_round(model.shape_kind[s], model.shape_size[s]);
        let turned = if arm > 0.0 { state.angular_velocity[body].length() * arm } else { 0.0 };
        let moved = (state.velocity[body] * model.step * STEPS).as_vec3a();
        let room = Vec3A::splat(0.5 * ROOM * (b.max - b.min).min_element() + (turned * model.step * STEPS) as f32);
        Aabb { min: b.min - room + moved.min(Vec3A::ZERO), max: b.max + room + moved.max(Vec3A::ZERO) }
    });
    true
}

/// How far the surface of a shape moves with its spin; a ball's does not leave its place.
fn non_round(kind: ShapeKind, size: DVec3) -> f64 {
    if kind == ShapeKind::Sphere { 0.0 } else { size.length() }
}

/// Half lengths of the box around a turned shape.
fn reach_of(kind: ShapeKind, size: DVec3, turn: impl Fn() -> DMat3) -> DVec3 {
    let of_box = |h: DVec3| {
        let r = turn();
        r.x_axis.abs() * h.x + r.y_axis.abs() * h.y + r.z_axis.abs() * h.z
    };
    match kind {
        ShapeKind::Sphere => size,
        ShapeKind::Ellipsoid => {
            let r = turn();
            let (x, y, z) = (r.x_axis * size.x, r.y_axis * size.y, r.z_axis * size.z);
            (x * x + y * y + z * z).map(f64::sqrt)
        }
        ShapeKind::Capsule => turn().z_axis.abs() * size.z + size.x,
        ShapeKind::Cylinder => {
            let axis = turn().z_axis;
            axis.abs() * size.z + (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt) * size.x
        }
        ShapeKind::Box | ShapeKind::Cone | ShapeKind::Hull | ShapeKind::Mesh | ShapeKind::HeightField => of_box(size),
        ShapeKind::Plane => DVec3::INFINITY,
    }
}
