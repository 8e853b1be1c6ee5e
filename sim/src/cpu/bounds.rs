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
use crate::solve::Twist;
use crate::{Model, ShapeKind, State};
use glam::{DMat3, DVec3, Vec3A};

/// A ball in its place, in one piece for those who look for its neighbours. It stands in a row of the solver's velocities, which
/// nobody needs before the solver makes them anew.
#[derive(Clone, Copy, Default)]
#[repr(transparent)]
pub struct Ball(Twist);

impl Ball {
    fn of(centre: DVec3, reach: f64) -> Ball {
        Ball(Twist { v: centre, w: DVec3::new(reach, 0.0, 0.0) })
    }

    /// Its centre, m, world.
    #[inline(always)]
    pub fn centre(&self) -> DVec3 {
        self.0.v
    }

    /// Its radius and its margin, m.
    #[inline(always)]
    pub fn reach(&self) -> f64 {
        self.0.w.x
    }
}

/// Room for so many balls in the rows of a column of velocities.
pub fn rows_of(velocities: Vec<Twist>, n: usize) -> Vec<Ball> {
    let mut rows = std::mem::ManuallyDrop::new(velocities);
    // SAFETY: a ball is a motion by another name (`repr(transparent)`), and the column is not used again.
    let mut balls = unsafe { Vec::from_raw_parts(rows.as_mut_ptr().cast(), rows.len(), rows.capacity()) };
    balls.resize(n, Ball::default());
    balls
}

/// The rows for the velocities again.
pub fn rows_back(balls: Vec<Ball>) -> Vec<Twist> {
    let mut rows = std::mem::ManuallyDrop::new(balls);
    // SAFETY: as above.
    unsafe { Vec::from_raw_parts(rows.as_mut_ptr().cast(), rows.len(), rows.capacity()) }
}

/// The stage; whether pairs must be found anew. The roomy boxes are renewed if so. `balls` is as long as the model has shapes if
/// it has balls only, else empty.
pub fn run(model: &Model, state: &State, margin: &mut Vec<f32>, balls: &mut [Ball], roomy: &mut Vec<Aabb>) -> bool {
    let n = model.n_shapes();
    margin.resize(n, 0.0);
    if !balls.is_empty() {
        return of_balls(model, state, margin, balls, roomy);
    }
    let known = roomy.len() == n;
    let rooms = &*roomy;
    let [left] = sweep(margin, |first, margin| {
        let mut left = 0.0;
        for (k, margin) in margin.iter_mut().enumerate() {
            let s = first + k;
            let body = model.shape_body[s] as usize;
            let spin =
                if model.is_centred_ball(s) { 0.0 } else { state.angular_velocity[body].length() * arm(model, s) };
            *margin = (model.envelope + (state.velocity[body].length() + spin) * model.step) as f32;
            if known && !rooms[s].holds(&tight(model, state, s, *margin)) {
                left += 1.0;
            }
        }
        [left]
    });
    if known && left == 0.0 {
        return false;
    }
    renew(model, state, margin, roomy);
    true
}

/// The same of balls.
fn of_balls(model: &Model, state: &State, margin: &mut [f32], balls: &mut [Ball], roomy: &mut Vec<Aabb>) -> bool {
    let known = roomy.len() == margin.len();
    let rooms = &*roomy;
    let [left] = sweep_two(margin, balls, |first, margin, balls| {
        let mut left = 0.0;
        for (k, (margin, ball)) in margin.iter_mut().zip(balls).enumerate() {
            let s = first + k;
            let body = model.shape_body[s] as usize;
            *margin = (model.envelope + state.velocity[body].length() * model.step) as f32;
            *ball = Ball::of(state.position[body], model.shape_size[s].x + *margin as f64);
            let holds = |room: &Aabb| {
                if model.shape_kind[s] == ShapeKind::Sphere && !model.absent[body] {
                    room.holds(&Aabb::about(ball.centre(), DVec3::splat(ball.reach())))
                } else {
                    room.holds(&tight(model, state, s, *margin))
                }
            };
            if known && !holds(&rooms[s]) {
                left += 1.0;
            }
        }
        [left]
    });
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
    let grown = DVec3::splat(margin as f64);
    if model.is_centred_ball(s) {
        return Aabb::about(state.position[body], model.shape_size[s] + grown);
    }
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
    let spin = if model.is_centred_ball(s) { 0.0 } else { state.angular_velocity[body].length() * arm(model, s) };
    let moved = (state.velocity[body] * model.step * STEPS).as_vec3a();
    let room = Vec3A::splat(0.5 * ROOM * (b.max - b.min).min_element() + (spin * model.step * STEPS) as f32);
    Aabb { min: b.min - room + moved.min(Vec3A::ZERO), max: b.max + room + moved.max(Vec3A::ZERO) }
}

/// How far from its body's centre a shape's surface moves with the spin, m; a ball's does not leave its place.
fn arm(model: &Model, s: usize) -> f64 {
    let own = if model.shape_kind[s] == ShapeKind::Sphere { 0.0 } else { model.shape_size[s].length() };
    model.shape_pose[s].position.length() + own
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
