//! Bound every shape by an axis-aligned box, grown by its margin.
//! in   position, orientation, velocity        [n_bodies]
//!      shape_kind, shape_size, shape_pose     [n_shapes]  m
//! inout roomy                                 [n_shapes]  m, boxes that pairs were found for
//! out  margin                                 [n_shapes]  m, how far from its surface contacts are looked for: δ + |v| h
//!      ball                                   [n_shapes]  where the model has balls only
//!      whether a shape's box has left its roomy one
//! Source: paper §3, before stage 1; the list of pairs that outlives a step is Verlet's (1967).
//!
//! Pairs are not looked for at every step: boxes are given room to move, pairs are found for these, and the list holds until a
//! box leaves its own. Contacts hang on the tight boxes alone, so that the room changes no result but their order.

use super::{Aabb, fill_rows, sweep, sweep_two};
use crate::twist::Twist;
use crate::{Model, ShapeKind, State};
use glam::{DMat3, DVec3, Vec3A};

/// A ball in its place: all that those who look for its contacts ask for, in one piece. It has the size of a [`Twist`], so
/// that the column of balls can stand where the solver keeps its velocities, which nobody needs before it makes them anew.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Ball {
    /// Its centre, m, world.
    pub centre: DVec3,
    /// Its radius and its margin, m.
    pub reach: f64,
    /// Its radius, m.
    pub radius: f64,
    /// The body that carries it.
    pub body: u32,
    /// Its material.
    pub material: u32,
}

impl Ball {
    /// A shape that is a ball; `margin` is how far from its surface contacts are looked for, m.
    #[inline]
    pub fn of(model: &Model, state: &State, s: usize, margin: f32) -> Ball {
        Ball { centre: model.shape_place(state, s).position, ..Ball::centred(model, state, s, margin) }
    }

    /// The same of a ball about its body's centre.
    #[inline(always)]
    fn centred(model: &Model, state: &State, s: usize, margin: f32) -> Ball {
        let (body, radius) = (model.shape_body[s], model.shape_size[s].x);
        let centre = state.position[body as usize];
        Ball { centre, reach: radius + margin as f64, radius, body, material: model.shape_material[s] }
    }

    /// Whether another is within both margins.
    #[inline(always)]
    pub fn is_near(&self, other: &Ball) -> bool {
        let reach = self.reach + other.reach;
        (self.centre - other.centre).length_squared() <= reach * reach
    }

    /// The box around it and its margin.
    #[inline(always)]
    fn tight(&self) -> Aabb {
        Aabb::about(self.centre, DVec3::splat(self.reach))
    }

    /// Room for `n` balls in the rows of a column of velocities.
    pub fn rows_in(velocities: Vec<Twist>, n: usize) -> Vec<Ball> {
        let mut balls: Vec<Ball> = bytemuck::cast_vec(velocities);
        balls.resize(n, Ball::default());
        balls
    }
}

/// The stage; whether pairs must be found anew. The roomy boxes are renewed if so. `balls` is as long as the model has shapes if
/// it has balls only, else empty.
pub fn run(model: &Model, state: &State, margin: &mut Vec<f32>, balls: &mut [Ball], roomy: &mut Vec<Aabb>) -> bool {
    let n = model.n_shapes();
    margin.resize(n, 0.0);
    let (known, rooms) = (roomy.len() == n, &*roomy);
    let margin_of = |s: usize, spin: f64| {
        let speed = state.velocity[model.shape_body[s] as usize].length() + spin;
        (model.envelope + speed * model.step) as f32
    };
    let has_left = |s: usize, tight: Aabb| known && !rooms[s].holds(&tight);
    let [left] = if balls.is_empty() {
        sweep(margin, |first, margin| {
            let mut left = 0;
            for (k, margin) in margin.iter_mut().enumerate() {
                let s = first + k;
                *margin = margin_of(s, surface_speed(model, state, s));
                left += has_left(s, tight(model, state, s, *margin)) as u32;
            }
            [left as f64]
        })
    } else {
        sweep_two(margin, balls, |first, margin, balls| {
            let mut left = 0;
            for (k, (margin, ball)) in margin.iter_mut().zip(balls).enumerate() {
                let s = first + k;
                *margin = margin_of(s, 0.0);
                *ball = Ball::centred(model, state, s, *margin);
                let is_here = model.shape_kind[s] == ShapeKind::Sphere && !model.absent[ball.body as usize];
                let tight = if is_here { ball.tight() } else { tight(model, state, s, *margin) };
                left += has_left(s, tight) as u32;
            }
            [left as f64]
        })
    };
    if known && left == 0.0 {
        return false;
    }
    renew(model, state, margin, roomy);
    true
}

fn renew(model: &Model, state: &State, margin: &[f32], roomy: &mut Vec<Aabb>) {
    roomy.resize(margin.len(), Aabb::default());
    fill_rows(roomy, |s| with_room(model, state, s, tight(model, state, s, margin[s])));
}

/// The box around a shape grown by its margin; empty if its body is absent.
#[inline]
pub fn tight(model: &Model, state: &State, s: usize, margin: f32) -> Aabb {
    let body = model.shape_body[s] as usize;
    if model.absent[body] {
        return Aabb::EMPTY;
    }
    if model.is_centred_ball(s) {
        return Ball::centred(model, state, s, margin).tight();
    }
    let grown = DVec3::splat(margin as f64);
    let at = model.shape_place(state, s);
    let reach = reach_of(model.shape_kind[s], model.shape_size[s], || DMat3::from_quat(at.orientation));
    Aabb::about(at.position, reach + grown)
}

/// Steps for which a box has room at the speed of its shape.
const STEPS: f64 = 5.0;
/// Room at rest, in half the least edge of the box.
const ROOM: f32 = 0.04;

/// A shape's box with room to move.
fn with_room(model: &Model, state: &State, s: usize, b: Aabb) -> Aabb {
    let body = model.shape_body[s] as usize;
    if model.inv_mass[body] == 0.0 || b.min.x > b.max.x {
        return b;
    }
    let spin = surface_speed(model, state, s);
    let moved = (state.velocity[body] * model.step * STEPS).as_vec3a();
    let room = Vec3A::splat(0.5 * ROOM * (b.max - b.min).min_element() + (spin * model.step * STEPS) as f32);
    Aabb { min: b.min - room + moved.min(Vec3A::ZERO), max: b.max + room + moved.max(Vec3A::ZERO) }
}

/// The speed at which a shape's surface leaves its place by the spin of its body, m/s; that of a ball about its body's centre
/// does not.
#[inline]
fn surface_speed(model: &Model, state: &State, s: usize) -> f64 {
    if model.is_centred_ball(s) {
        return 0.0;
    }
    let own = if model.shape_kind[s] == ShapeKind::Sphere { 0.0 } else { model.shape_size[s].length() };
    let arm = model.shape_pose[s].position.length() + own;
    state.angular_velocity[model.shape_body[s] as usize].length() * arm
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
