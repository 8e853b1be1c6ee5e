//! Recovery of overlaps: a displacement of the bodies that makes overlaps smaller, apart from their velocities.
//!
//! An overlap that is recovered by the contacts' impulses adds to the bodies' momentum. A solve that is cut off leaves most of the error
//! of a deep bed's slow modes, which then oscillate from step to step, and grow: such a bed never rests. So the velocities see an overlap
//! as a gap of zero, and what is left of it at the step's end moves the positions alone. The displacement is one step of steepest descent
//! from rest with the same operator, so that joints take part in it and the centre of mass stays where it is; the rest of the overlaps is
//! left to the next steps, which see it again.

use super::bodies::BodyOperator;
use super::operator::Operator;
use super::response::Response;
use crate::rows::{fill_rows, reduce_chunks};
use crate::twist::Twist;
use glam::DVec3;

/// Share of the step to the minimum along the direction: more would open some contacts for the sake of others.
const SHARE: f64 = 0.5;

/// The displacement, and the columns from which it is made.
#[derive(Default)]
pub struct Displacement {
    /// Displacements over the step size, m/s and rad/s, world (n_bodies, or empty where nothing overlaps).
    pub twist: Vec<Twist>,
    gamma: Vec<DVec3>,
    response: Response,
}

/// Find the displacement after a solve with the solution `gamma` and its `response`.
pub fn recover(op: &mut BodyOperator, gamma: &[DVec3], response: &Response, out: &mut Displacement) {
    out.twist.clear();
    let contacts = op.contacts;
    out.gamma.clear();
    out.gamma.extend_from_slice(gamma);
    let this = &*op;
    let [slope] = reduce_chunks(&mut out.gamma[..contacts.len()], |first, rows| {
        let mut slope = 0.0;
        for (k, gamma) in rows.iter_mut().enumerate() {
            let i = first + k;
            if contacts.gap[i] >= -this.recovery.least {
                continue;
            }
            let normal = contacts.normal[i];
            let speed = contacts.velocity(i, |b| response.twist[b]).dot(normal);
            let left = this.recovery.overlap_speed(contacts.gap[i], speed);
            let impulse = left / this.normal_response(i);
            *gamma += normal * impulse;
            slope += impulse * left;
        }
        [slope]
    });
    if slope == 0.0 {
        return;
    }
    op.response(&out.gamma, &mut out.response);
    let curvature = op.curvature(&out.response, response);
    if curvature > 0.0 {
        let share = SHARE * (slope / curvature).min(1.0);
        out.twist.resize(response.twist.len(), Twist::default());
        let (moved, still) = (&out.response.twist, &response.twist);
        fill_rows(&mut out.twist, |b| moved[b].minus(&still[b]).times(share));
    }
}
impl BodyOperator<'_> {
    /// Relative speed along a contact's normal that a unit impulse along it makes, without joints, 1/kg.
    fn normal_response(&self, contact: usize) -> f64 {
        let (bodies, normal) = (self.contacts.bodies[contact], self.contacts.normal[contact]);
        let of = |(body, arm): (u32, DVec3)| {
            let (b, turn) = (body as usize, arm.cross(normal));
            self.masses.inv_mass[b] + turn.dot(self.masses.apply_inv_inertia(b, turn))
        };
        let [a, b] = self.contacts.arms(contact);
        of((bodies[0], a)) + of((bodies[1], b))
    }
}
