//! Bound every shape by an axis-aligned box, grown by its margin.
//! in    position          [n_bodies]
//! in    orientation       [n_bodies]
//! in    velocity          [n_bodies]  m/s
//! in    angular_velocity  [n_bodies]  rad/s
//! out   margin            [n_shapes]  m, distance within which contacts are generated: δ + |v| h
//! out   tight_aabb        [n_shapes]  m, grown by the margin, where the plan has any shapes
//! out   sphere            [n_shapes]  where the plan has spheres only
//! out   fat_aabb          [n_shapes]  m, renewed when a tight box has left its fat one
//! Source: paper §3, before stage 1; pair lists that hold for several steps are Verlet's (1967).
//!
//! The broad phase does not run in every step: it finds the pairs of fat AABBs, which hold until a tight box leaves its fat one.
//! Contacts depend on the tight boxes alone, so that the fat margin changes no result but the order of contacts.

use crate::aabb::Aabb;
use crate::model::Model;
use crate::plan::{Narrow, StepPlan};
use crate::rows::{fill_rows, reduce_chunks_of_two};
use crate::shape::ShapeKind;
use crate::sphere::Sphere;
use crate::state::State;
use glam::{DMat3, DVec3, Vec3A};

/// The columns of the stage that are not in the state.
pub struct Output<'a> {
    /// Margins, m.
    pub margin: &'a mut Vec<f32>,
    /// Tight AABBs, m, where the plan has any shapes.
    pub tight: &'a mut Vec<Aabb>,
    /// Spheres, where the plan has spheres only.
    pub spheres: &'a mut Vec<Sphere>,
}

/// The stage. Returns whether the fat AABBs were renewed, so that the broad phase must run.
pub fn run(
    model: &Model,
    plan: &StepPlan,
    state: &State,
    Output { margin, tight: tight_aabb, spheres }: Output,
    fat_aabb: &mut Option<Vec<Aabb>>,
) -> bool {
    let n = model.n_shapes();
    margin.resize(n, 0.0);
    tight_aabb.resize(if plan.narrow == Narrow::Any { n } else { 0 }, Aabb::default());
    spheres.resize(if plan.narrow == Narrow::Spheres { n } else { 0 }, Sphere::default());
    let known = fat_aabb.as_deref().filter(|boxes| boxes.len() == n);
    let margin_of = |s: usize, spin: f64| {
        let speed = state.velocity[model.shape_body[s] as usize].length() + spin;
        (model.envelope + speed * model.step) as f32
    };
    let has_left = |s: usize, tight: Aabb| known.is_some_and(|boxes| !boxes[s].contains(&tight));
    let [left] = if plan.narrow == Narrow::Any {
        reduce_chunks_of_two(margin, tight_aabb, |first, margin, boxes| {
            let mut left = 0;
            for (k, (margin, own)) in margin.iter_mut().zip(boxes).enumerate() {
                let s = first + k;
                *margin = margin_of(s, surface_speed(model, state, s));
                *own = tight(model, state, s, *margin);
                left += has_left(s, *own) as u32;
            }
            [left as f64]
        })
    } else {
        reduce_chunks_of_two(margin, spheres, |first, margin, spheres| {
            let mut left = 0;
            for (k, (margin, sphere)) in margin.iter_mut().zip(spheres).enumerate() {
                let s = first + k;
                *margin = margin_of(s, 0.0);
                *sphere = Sphere::centred(model, state, s, *margin);
                let is_present = model.shape_kind[s] == ShapeKind::Sphere && !state.is_inactive(sphere.body as usize);
                let tight = if is_present { sphere.tight() } else { tight(model, state, s, *margin) };
                left += has_left(s, tight) as u32;
            }
            [left as f64]
        })
    };
    if known.is_some() && left == 0.0 {
        return false;
    }
    let boxes = fat_aabb.get_or_insert_default();
    boxes.resize(n, Aabb::default());
    let known = &*tight_aabb;
    fill_rows(boxes, |s| {
        let tight = known.get(s).copied().unwrap_or_else(|| tight(model, state, s, margin[s]));
        fatten(model, state, s, tight)
    });
    true
}

/// The tight AABB: the box of a shape, grown by its margin, m; empty if its body is inactive.
#[inline]
pub fn tight(model: &Model, state: &State, s: usize, margin: f32) -> Aabb {
    let body = model.shape_body[s] as usize;
    if state.is_inactive(body) {
        return Aabb::EMPTY;
    }
    if model.is_centred_sphere(s) {
        return Sphere::centred(model, state, s, margin).tight();
    }
    let grown = DVec3::splat(margin as f64);
    let at = state.shape_pose(model, s);
    let reach = reach_of(model.shape_kind[s], model.shape_size[s], || DMat3::from_quat(at.orientation));
    Aabb::about(at.position, reach + grown)
}

/// Number of steps for which a fat AABB covers the motion of its shape.
pub const STEPS: f64 = 5.0;
/// Fat margin at rest, over half the shortest edge of the tight box.
pub const FAT_MARGIN: f32 = 0.04;

/// The fat AABB of a shape from its tight one.
fn fatten(model: &Model, state: &State, s: usize, b: Aabb) -> Aabb {
    let body = model.shape_body[s] as usize;
    if !state.moves(body) || b.min.x > b.max.x {
        return b;
    }
    let spin = surface_speed(model, state, s);
    let moved = (state.velocity[body] * model.step * STEPS).as_vec3a();
    let grown = Vec3A::splat(0.5 * FAT_MARGIN * (b.max - b.min).min_element() + (spin * model.step * STEPS) as f32);
    Aabb { min: b.min - grown + moved.min(Vec3A::ZERO), max: b.max + grown + moved.max(Vec3A::ZERO) }
}

/// Maximum speed of a shape's surface by the angular velocity of its body, m/s; 0 for a sphere about its body's centre of mass, whose
/// box does not change.
#[inline]
fn surface_speed(model: &Model, state: &State, s: usize) -> f64 {
    if model.is_centred_sphere(s) {
        return 0.0;
    }
    let own = if model.shape_kind[s] == ShapeKind::Sphere { 0.0 } else { model.shape_size[s].length() };
    let arm = model.shape_pose[s].position.length() + own;
    state.angular_velocity[model.shape_body[s] as usize].length() * arm
}

/// Half lengths of the box of a shape with a rotation.
fn reach_of(kind: ShapeKind, size: DVec3, rotation: impl Fn() -> DMat3) -> DVec3 {
    let of_box = |h: DVec3| {
        let r = rotation();
        r.x_axis.abs() * h.x + r.y_axis.abs() * h.y + r.z_axis.abs() * h.z
    };
    match kind {
        ShapeKind::Sphere => size,
        ShapeKind::Ellipsoid => {
            let r = rotation();
            let (x, y, z) = (r.x_axis * size.x, r.y_axis * size.y, r.z_axis * size.z);
            (x * x + y * y + z * z).map(f64::sqrt)
        }
        ShapeKind::Capsule => rotation().z_axis.abs() * size.z + size.x,
        ShapeKind::Cylinder => {
            let axis = rotation().z_axis;
            axis.abs() * size.z + (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt) * size.x
        }
        ShapeKind::Box | ShapeKind::Cone | ShapeKind::Hull | ShapeKind::Mesh | ShapeKind::HeightField => of_box(size),
        ShapeKind::Plane => DVec3::INFINITY,
    }
}
