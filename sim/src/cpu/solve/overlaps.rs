//! Recovery of overlaps: a displacement of the bodies that makes overlaps smaller, apart from their velocities.
//!
//! An overlap that is recovered by the contacts' impulses adds to the bodies' momentum. A solve that is cut off leaves most of the error
//! of a deep bed's slow modes, which then oscillate from step to step, and grow: such a bed never rests. So the velocities see an overlap
//! as a gap of zero, and what is left of it at the step's end moves the positions alone. The displacement is one step of steepest descent
//! from rest with the same operator, so that joints take part in it and the centre of mass stays where it is; the rest of the overlaps is
//! left to the next steps, which see it again.

use super::bodies::BodyOperator;
use super::cells::Cells;
use super::operator::Operator;
use super::response::Response;
use super::schedule;
use crate::contacts::Arms;
use crate::rows::reduce_chunks;
use crate::twist::Twist;
use glam::DVec3;

/// Share of the step to the minimum along the direction: more would open some contacts for the sake of others.
const SHARE: f64 = 0.5;

/// The displacement, and the impulses that make it.
#[derive(Default)]
pub struct Displacement {
    /// Displacements over the step size, m/s and rad/s, world (n_bodies, or empty where nothing overlaps).
    pub twist: Vec<Twist>,
    /// Share of the displacements that is made.
    pub share: f64,
    /// Impulses along the contacts' normals, N s (n_contacts).
    push: Vec<f64>,
}

/// Find the displacement after the solve of a step, with the velocities of `response`; in one of `period` steps, for
/// all of them.
pub fn recover(op: &mut BodyOperator, period: u64, response: &mut Response, out: &mut Displacement) {
    let slope = op.push_apart(period as f64, response, &mut out.push);
    if slope == 0.0 {
        return;
    }
    let mut moved = Response { twist: std::mem::take(&mut out.twist), lambda: vec![] };
    let curvature = op.displace(&out.push, &mut moved);
    if curvature > 0.0 {
        let share = SHARE * (slope / curvature).min(1.0);
        if op.recovery.least == 0.0 {
            op.keep_angular_momentum(&out.push, &moved.lambda, share, response);
        }
        out.twist = moved.twist;
        out.share = share;
    }
}

impl BodyOperator<'_> {
    /// Set `push` to the impulse that alone would recover what is left of each contact's overlap. Returns the sum of the impulses times
    /// the speeds of recovery, J.
    fn push_apart(&self, period: f64, response: &Response, push: &mut Vec<f64>) -> f64 {
        let contacts = self.contacts;
        let least = -self.recovery.least;
        if !contacts.gap.iter().any(|gap| *gap < least) {
            return 0.0;
        }
        push.resize(contacts.len(), 0.0);
        let [slope] = reduce_chunks(push, |first, rows| {
            let mut slope = 0.0;
            for (k, push) in rows.iter_mut().enumerate() {
                let i = first + k;
                *push = 0.0;
                if contacts.gap[i] < least {
                    let speed = self.normal_speed(i, response);
                    let left = self.recovery.overlap_speed(contacts.gap[i], speed, period);
                    *push = left / self.masses.normal_response(contacts, i);
                    slope += *push * left;
                }
            }
            [slope]
        });
        slope
    }

    /// The velocities that the impulses `push` give to bodies and joints at rest. Returns twice their energy, J.
    fn displace(&mut self, push: &[f64], moved: &mut Response) -> f64 {
        self.clear_sums(&mut moved.twist);
        let sums = Cells::new(&mut moved.twist);
        // SAFETY: contacts that are visited concurrently have no moving body in common.
        schedule::each(self.contacts, |i| unsafe {
            if push[i] != 0.0 {
                self.add_block(i, self.contacts.normal[i] * push[i], &sums);
            }
        });
        let masses = self.masses;
        let [energy] = reduce_chunks(&mut moved.twist, |first, rows| {
            let mut energy = 0.0;
            for (k, twist) in rows.iter_mut().enumerate() {
                *twist = masses.change::<false>(first + k, twist);
                energy += masses.energy::<false>(first + k, twist);
            }
            [energy]
        });
        self.joints.reset(moved);
        if self.joints.rows.is_empty() {
            return energy;
        }
        self.joints.solve_at_rest(masses, moved);
        self.energy(moved)
    }

    /// Relative speed along a contact's normal, m/s. Arms along it have no part in it.
    #[inline]
    fn normal_speed(&self, contact: usize, response: &Response) -> f64 {
        let of = |b: usize| response.twist[b];
        let velocity = match self.contacts.arms {
            Arms::Any(_) => self.contacts.velocity(contact, of),
            Arms::Along(_) => {
                let [a, b] = self.contacts.bodies[contact].map(|b| of(b as usize).v);
                b - a
            }
        };
        velocity.dot(self.contacts.normal[contact])
    }

    /// Turn the bodies so that the displacement by the share `share` of the impulses leaves the angular momentum as it is, which counts
    /// without gravity: a pair that is pushed apart with the impulse p while it slides at v changes it by h p × v.
    fn keep_angular_momentum(&self, push: &[f64], lambda: &[f64], share: f64, response: &mut Response) {
        let (contacts, masses) = (self.contacts, self.masses);
        let pushes = (0..contacts.len()).map(|i| (contacts.bodies[i], contacts.normal[i] * push[i]));
        let pulls = self.joints.rows.iter().zip(lambda).map(|(row, impulse)| (row.bodies, row.linear * *impulse));
        let half = 0.5 * share * self.recovery.step;
        let move_both = |bodies: [u32; 2]| bodies.iter().all(|b| masses.inv_mass[*b as usize] > 0.0);
        for (bodies, push) in pushes.chain(pulls).filter(|(bodies, push)| *push != DVec3::ZERO && move_both(*bodies)) {
            let [a, b] = bodies.map(|b| response.twist[b as usize].v);
            let turn = push.cross(b - a) * half;
            bodies.iter().for_each(|b| response.twist[*b as usize].w -= masses.apply_inv_inertia(*b as usize, turn));
        }
    }
}
