//! Integrate the poses of the bodies with their new velocities.
//! in     motion            [n_bodies]  m/s and rad/s, world
//! in     displacement      [n_bodies]  m/s and rad/s, world: moves the poses alone; empty where nothing overlaps
//! in     joint_start       [n_joints + 1]
//! in     joint_row         [n_rows]
//! in     joint_impulse     [n_rows]    N s, N m s: joint states are recorded before the poses change
//! inout  position          [n_bodies]  m
//! inout  orientation       [n_bodies]
//! out    velocity          [n_bodies]  m/s, world
//! out    angular_velocity  [n_bodies]  rad/s, principal frame
//! Source: PHYSICS, q⁺ = q + h L(q) v⁺. The angular momentum in the world frame is constant over a step, so that a free body keeps it to
//! round-off. A body of isotropic inertia turns by its new velocity; any other by a splitting of its energy about its principal axes, which is
//! the same in both directions of time, so that energy does not drift.

use super::solve::overlaps::Displacement;
use crate::inertia::is_isotropic;
use crate::model::Model;
use crate::pose::Pose;
use crate::rows::CHUNK;
use crate::state::{Activity, State};
use crate::twist::Twist;
use glam::{DQuat, DVec3};
use rayon::prelude::*;

/// The stage.
pub fn run(model: &Model, motion: &[Twist], displacement: &Displacement, state: &mut State) {
    let (h, activity) = (model.step, &state.activity);
    let part = h * displacement.share;
    let columns = (
        state.position.par_chunks_mut(CHUNK),
        state.orientation.par_chunks_mut(CHUNK),
        state.velocity.par_chunks_mut(CHUNK),
        state.angular_velocity.par_chunks_mut(CHUNK),
    );
    columns.into_par_iter().with_min_len(2).enumerate().for_each(|(chunk, (position, orientation, velocity, spin))| {
        for k in 0..position.len() {
            let b = chunk * CHUNK + k;
            match activity[b] {
                Activity::Moving => {}
                Activity::Held | Activity::Asleep => {
                    (velocity[k], spin[k]) = (DVec3::ZERO, DVec3::ZERO);
                    continue;
                }
                // It begins with the velocity that it has.
                Activity::Inactive => continue,
            }
            velocity[k] = motion[b].v;
            let from = Pose { position: position[k], orientation: orientation[k] };
            let moved = displacement.twist.get(b).map(|moved| (moved, part));
            let (to, turning) = moved_pose(&from, &motion[b], model.inv_inertia[b], h, moved);
            (position[k], orientation[k], spin[k]) = (to.position, to.orientation, turning);
        }
    });
    state.steps += 1;
    state.time = state.steps as f64 * h;
}

/// The pose of a body after a step `h`, s, with the velocities `motion`, and its angular velocity in its own frame, rad/s. `inverse` has the
/// inverse principal moments, 1/(kg m²); `moved` a displacement over h, and the time that it goes on for, s.
#[inline(always)]
pub fn moved_pose(
    from: &Pose,
    &Twist { v, w }: &Twist,
    inverse: DVec3,
    h: f64,
    moved: Option<(&Twist, f64)>,
) -> (Pose, DVec3) {
    let mut position = from.position + v * h;
    let (mut orientation, mut spin) = if is_isotropic(inverse) {
        let after = unit(rotation(w * h) * from.orientation);
        (after, after.inverse() * w)
    } else {
        tumble(from.orientation, w, inverse, h)
    };
    if let Some((moved, part)) = moved {
        position += moved.v * part;
        if moved.w != DVec3::ZERO {
            // What is turned keeps its angular momentum, too.
            let momentum = orientation * (spin / inverse);
            orientation = unit(rotation(moved.w * part) * orientation);
            let into = orientation.inverse();
            spin = if is_isotropic(inverse) { into * w } else { (into * momentum) * inverse };
        }
    }
    (Pose { position, orientation }, spin)
}

/// The orientation of a body of anisotropic inertia after a step without torque, and its angular velocity in its own frame, rad/s; it
/// begins with the angular velocity `w` in the world. `inverse` has the inverse principal moments, 1/(kg m²).
///
/// With its angular momentum L in its own frame and the middle moment I₂ its energy is |L|²/2I₂ + Σ L_k²/2 (1/I_k − 1/I₂) over the two other
/// axes. The first term turns it about L and commutes with the others, each of which turns it about its own axis; all keep L in the world.
/// The two alternate, half, whole and half a part (Strang 1968): exact for a body with an axis of symmetry, however slender and fast.
/// Not inlined: spheres, which do not need it, keep their registers.
#[inline(never)]
fn tumble(before: DQuat, w: DVec3, inverse: DVec3, h: f64) -> (DQuat, DVec3) {
    /// The greatest angle of the swing between the two axes in a part, rad.
    const PART: f64 = 0.25;
    /// The most parts, of what rotates beyond all bounds.
    const MOST: f64 = 1e4;
    let [slow, middle, fast] = by_size(inverse);
    let local = (before.inverse() * w) / inverse;
    let momentum = before * local;
    let rates = [slow, fast].map(|k| inverse[k] - inverse[middle]);
    let swing2 = -rates[0] * rates[1] * momentum.length_squared() * (h * h);
    let n_parts = if swing2 <= PART * PART { 1.0 } else { (swing2.sqrt() / PART).ceil().min(MOST) };
    let mut frame = Turning { local: local.to_array(), turned: DQuat::IDENTITY.to_array() };
    let time = h / n_parts;
    for _ in 0..n_parts as u32 {
        frame.turn(slow, rates[0] * (0.5 * time));
        frame.turn(fast, rates[1] * time);
        frame.turn(slow, rates[0] * (0.5 * time));
    }
    let turned = DQuat::from_array(frame.turned);
    let after = unit(rotation(momentum * (inverse[middle] * h)) * before * turned);
    (after, (after.inverse() * momentum) * inverse)
}

/// A frame that turns about its own axes.
struct Turning {
    /// The angular momentum in the frame, kg m²/s.
    local: [f64; 3],
    /// The rotation of the frame so far.
    turned: [f64; 4],
}

impl Turning {
    /// Turn about an axis, for `rate`, rad s/(kg m²), times the angular momentum about it.
    #[inline(always)]
    fn turn(&mut self, axis: usize, rate: f64) {
        if rate == 0.0 {
            return;
        }
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let Turning { local, turned: q } = self;
        let [sine, cosine] = half_angle(rate * local[axis]);
        let (s, c) = (2.0 * sine * cosine, 1.0 - 2.0 * sine * sine);
        (local[i], local[j]) = (c * local[i] + s * local[j], c * local[j] - s * local[i]);
        (q[axis], q[3]) = (q[axis] * cosine + q[3] * sine, q[3] * cosine - q[axis] * sine);
        (q[i], q[j]) = (q[i] * cosine + q[j] * sine, q[j] * cosine - q[i] * sine);
    }
}

/// The axes in the order of the values, ascending.
fn by_size(values: DVec3) -> [usize; 3] {
    let mut order = [0, 1, 2];
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if values[order[j]] < values[order[i]] {
            order.swap(i, j);
        }
    }
    order
}

/// The rotation by a rotation vector, rad: its direction is the axis, its length the angle.
#[inline]
fn rotation(angle: DVec3) -> DQuat {
    let q = 0.25 * angle.length_squared();
    if q > SMALL {
        return DQuat::from_scaled_axis(angle);
    }
    let [over_half, cosine] = series(q);
    let v = angle * (0.5 * over_half);
    DQuat::from_xyzw(v.x, v.y, v.z, cosine)
}

/// The unit quaternion of a product of unit quaternions, whose length is 1 to round-off: a step of Newton's method.
#[inline(always)]
fn unit(q: DQuat) -> DQuat {
    q * (1.5 - 0.5 * q.length_squared())
}

/// The sine and the cosine of half an angle, rad.
#[inline(always)]
fn half_angle(angle: f64) -> [f64; 2] {
    let half = 0.5 * angle;
    let q = half * half;
    if q > SMALL {
        return half.sin_cos().into();
    }
    let [over_half, cosine] = series(q);
    [half * over_half, cosine]
}

/// The greatest square of half an angle of which the series is right to round-off, rad².
const SMALL: f64 = 1e-3;

/// The sine of half an angle over it, and its cosine, from its square: series, to round-off.
#[inline(always)]
fn series(q: f64) -> [f64; 2] {
    let sine = 1.0 - q * (1.0 / 6.0 - q * (1.0 / 120.0 - q * (1.0 / 5040.0 - q * (1.0 / 362880.0))));
    let cosine = 1.0 - q * (1.0 / 2.0 - q * (1.0 / 24.0 - q * (1.0 / 720.0 - q * (1.0 / 40320.0))));
    [sine, cosine]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fast_discs_keep_their_axis() {
        // A disc of 1 kg and 0.1 m that wobbles, by up to 3 rad in a step.
        let inverse = DVec3::new(370.0, 370.0, 200.0);
        for fast in [900.0, 1200.0, 3000.0] {
            let (mut q, mut w) = (DQuat::IDENTITY, DVec3::new(1.0, 0.0, fast));
            let energy = |w: DVec3| 0.5 * (w * w / inverse).element_sum();
            let before = energy(w);
            for _ in 0..2_000 {
                (q, w) = tumble(q, q * w, inverse, 1e-3);
                assert!((energy(w) / before - 1.0).abs() < 1e-6 && w.z > 0.99 * fast, "{fast}: {w}");
            }
        }
    }

    /// A rod a thousand times as long as thick, at up to half a turn in a step: it keeps its spin about its axis, and its energy.
    #[test]
    fn slender_rods_keep_their_spin() {
        for (inverse, off) in [(DVec3::new(2e6, 12.0, 12.0), 1e-10), (DVec3::new(12.0, 2e6, 12.1), 0.02)] {
            let axis = if inverse.x > inverse.y { DVec3::X } else { DVec3::Y };
            for speed in [1.0, 50.0, 300.0, 3000.0] {
                let mut q = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
                let mut w = 0.1 * axis + speed * DVec3::Z;
                let energy = |w: DVec3| 0.5 * (w * w / inverse).element_sum();
                let (e, momentum) = (energy(w), q * (w / inverse));
                for _ in 0..2_000 {
                    (q, w) = tumble(q, q * w, inverse, 1e-3);
                    assert!((energy(w) / e - 1.0).abs() < off, "{speed}: energy {}", energy(w) / e);
                    assert!(off > 1e-6 || (w.dot(axis) - 0.1).abs() < 1e-5, "{speed}: spin {}", w.dot(axis));
                    assert!((q * (w / inverse) - momentum).length() < 1e-9 * momentum.length());
                }
            }
        }
    }

    #[test]
    fn what_tumbles_keeps_momentum_and_energy() {
        // Moments of a box of 1 x 2 x 3, about its middle axis, where a free body turns over again and again.
        let (inverse, h) = (DVec3::new(1.0 / 13.0, 1.0 / 10.0, 1.0 / 5.0), 1e-3);
        let (mut q, mut w) = (DQuat::from_rotation_x(0.3), DVec3::new(0.02, 10.0, 0.01));
        let momentum = |q: DQuat, w: DVec3| q * (w / inverse);
        let energy = |w: DVec3| 0.5 * (w * w / inverse).element_sum();
        let (l, e) = (momentum(q, w), energy(w));
        let (mut worst, mut turned) = (0.0, false);
        for _ in 0..10_000 {
            (q, w) = tumble(q, q * w, inverse, h);
            worst = f64::max(worst, (energy(w) / e - 1.0).abs());
            turned |= w.y < -5.0;
        }
        assert!(turned && worst < 1e-5, "{worst}");
        assert!((momentum(q, w) - l).length() < 1e-10 * l.length());
    }

    /// Before it appears it stays where it is; then it goes on with its velocity.
    #[test]
    fn a_body_that_appears_begins_with_its_velocity() {
        let mut builder = crate::ModelBuilder::new("late");
        builder.material("stone", 2600.0, 0.5);
        let ball = builder.body("ball", "stone", crate::model_file::ShapeFile::sphere(0.1));
        (ball.velocity, ball.appears) = ([1.0, 0.0, 0.0], Some(0.01));
        let mut sim = builder.simulation().unwrap();
        sim.model.gravity = DVec3::ZERO;
        let after = |sim: &mut crate::Simulation, n: usize| {
            (0..n).for_each(|_| drop(sim.step()));
            sim.state.position[0].x / sim.model.step
        };
        let before = (0.01 / sim.model.step).round() as usize;
        assert_eq!(after(&mut sim, before), 0.0);
        assert!((after(&mut sim, 20) - 20.0).abs() < 1e-9, "{}", sim.state.position[0]);
    }

    #[test]
    fn the_series_is_the_rotation() {
        for length in [0.0, 1e-9, 1e-4, 0.03, 0.0632] {
            let angle = DVec3::new(2.0, -1.0, 0.5).normalize() * length;
            assert!((rotation(angle) - DQuat::from_scaled_axis(angle)).length() < 1e-16 * 4.0, "{length}");
        }
    }
}
