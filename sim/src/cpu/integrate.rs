//! Integrate the poses of the bodies with their new velocities.
//! in     motion            [n_bodies]  m/s and rad/s, world
//! in     joint_start       [n_joints + 1]
//! in     joint_row         [n_rows]
//! in     joint_impulse     [n_rows]    N s, N m s: joint states are recorded before the poses change
//! inout  position          [n_bodies]  m
//! inout  orientation       [n_bodies]
//! out    velocity          [n_bodies]  m/s, world
//! out    angular_velocity  [n_bodies]  rad/s, principal frame
//! Source: PHYSICS, q⁺ = q + h L(q) v⁺; the rotation over a step is exact, and the angular momentum in the world frame is
//! constant over it, so that a free body keeps it to round-off.

use crate::inertia::is_isotropic;
use crate::model::Model;
use crate::rows::CHUNK;
use crate::state::{Activity, State};
use crate::twist::Twist;
use glam::{DQuat, DVec3};
use rayon::prelude::*;

/// The stage.
pub fn run(model: &Model, motion: &[Twist], state: &mut State) {
    let (h, activity) = (model.step, &state.activity);
    let columns = (
        state.position.par_chunks_mut(CHUNK),
        state.orientation.par_chunks_mut(CHUNK),
        state.velocity.par_chunks_mut(CHUNK),
        state.angular_velocity.par_chunks_mut(CHUNK),
    );
    columns.into_par_iter().with_min_len(8).enumerate().for_each(|(chunk, (position, orientation, velocity, spin))| {
        for k in 0..position.len() {
            let b = chunk * CHUNK + k;
            if activity[b] != Activity::Moving {
                (velocity[k], spin[k]) = (DVec3::ZERO, DVec3::ZERO);
                continue;
            }
            let Twist { v, w } = motion[b];
            let before = orientation[k];
            let after = (rotation(w * h) * before).normalize();
            position[k] += v * h;
            velocity[k] = v;
            orientation[k] = after;
            let inverse = model.inv_inertia[b];
            spin[k] = if is_isotropic(inverse) {
                after.inverse() * w
            } else {
                let momentum = before * ((before.inverse() * w) / inverse);
                (after.inverse() * momentum) * inverse
            };
        }
    });
    state.steps += 1;
    state.time = state.steps as f64 * h;
}

/// The rotation by a rotation vector, rad: its direction is the axis, its length the angle.
#[inline]
fn rotation(angle: DVec3) -> DQuat {
    let q = 0.25 * angle.length_squared();
    if q > 1e-3 {
        return DQuat::from_scaled_axis(angle);
    }
    // Series in the square of the half angle, to round-off.
    let sine = 1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0)));
    let cosine = 1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0)));
    let v = angle * (0.5 * sine);
    DQuat::from_xyzw(v.x, v.y, v.z, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_is_the_rotation() {
        for length in [0.0, 1e-9, 1e-4, 0.03, 0.0632] {
            let angle = DVec3::new(2.0, -1.0, 0.5).normalize() * length;
            assert!((rotation(angle) - DQuat::from_scaled_axis(angle)).length() < 1e-16 * 4.0, "{length}");
        }
    }
}
