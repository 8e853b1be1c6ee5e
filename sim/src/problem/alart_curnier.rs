//! Alart and Curnier's function of exact friction, whose zero is each contact's law, and its derivative.
//!
//! With y = r − s u and the disk of radius μ max(y_n, 0),
//!
//! ```text
//! F_n = r_n − max(y_n, 0)        F_t = r_t − Π_disk(y_t)
//! ```
//!
//! which, unlike the natural map, has no kink where a contact that is at the edge of its cone hardly slips. The velocities are those of
//! u = Wr + q + c (r − a), where c is a compliance of each contact, and a any anchor.

use super::dense::Lu;
use super::matrix::MatrixOperator;
use crate::cpu::solve::cone::project_cone;
use glam::{DMat3, DVec3};

/// What a contact does.
#[derive(Clone, Copy, PartialEq)]
pub enum Status {
    Open,
    Sticks,
    Slides,
}

/// The function of one contact, its status, and the derivative of the projection.
pub struct Local {
    /// F.
    pub value: DVec3,
    pub status: Status,
    slope: DMat3,
}

/// The function of a contact with velocity u and multiplier r; s is any positive number, by which the two are weighed.
pub fn local(u: DVec3, r: DVec3, mu: f64, s: f64) -> Local {
    let y = r - u * s;
    if !(y.x > 0.0) {
        return Local { value: r, status: Status::Open, slope: DMat3::ZERO };
    }
    let (radius, length) = (mu * y.x, y.y.hypot(y.z));
    if length <= radius {
        return Local { value: r - y, status: Status::Sticks, slope: DMat3::IDENTITY };
    }
    let (a, b, ratio) = (y.y / length, y.z / length, radius / length);
    let value = r - DVec3::new(y.x, a * radius, b * radius);
    let slope = DMat3::from_cols(
        DVec3::new(1.0, mu * a, mu * b),
        DVec3::new(0.0, ratio * (1.0 - a * a), -ratio * a * b),
        DVec3::new(0.0, -ratio * a * b, ratio * (1.0 - b * b)),
    );
    Local { value, status: Status::Slides, slope }
}

/// The derivative J of the function, factorised.
pub struct Derivative<'a> {
    op: &'a MatrixOperator,
    locals: &'a [Local],
    /// s of each contact (n_contacts).
    eta: &'a [f64],
    /// First row of each closed contact, and a number out of range for open ones, whose multipliers a step makes zero (n_contacts).
    place: Vec<usize>,
    lu: Lu,
}

/// The place of an open contact.
const OPEN: usize = usize::MAX;

impl<'a> Derivative<'a> {
    /// Factorise J at the functions of all contacts, with their s and compliances; none if it is singular.
    pub fn new(
        op: &'a MatrixOperator,
        locals: &'a [Local],
        eta: &'a [f64],
        compliance: &[f64],
    ) -> Option<Derivative<'a>> {
        let (mut place, mut m) = (vec![OPEN; locals.len()], 0);
        for (place, _) in place.iter_mut().zip(locals).filter(|(_, l)| l.status != Status::Open) {
            *place = m;
            m += 3;
        }
        let mut a = vec![0.0; m * m];
        for (i, l) in locals.iter().enumerate().filter(|(_, l)| l.status != Status::Open) {
            let slope = l.slope * eta[i];
            let mut put = |j: usize, block: DMat3| {
                for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                    a[(place[i] + r) * m + place[j] + c] += block.col(c)[r];
                }
            };
            put(i, DMat3::IDENTITY - l.slope + slope * compliance[i]);
            for (j, block) in op.blocks(i).filter(|(j, _)| place[*j] != OPEN) {
                put(j, slope * block);
            }
        }
        Some(Derivative { op, locals, eta, lu: Lu::new(m, a)?, place })
    }

    /// The x of J x = −values (n_contacts).
    pub fn solve(&self, values: &[DVec3]) -> Vec<DVec3> {
        let mut rhs = vec![];
        for (i, l) in self.locals.iter().enumerate().filter(|(_, l)| l.status != Status::Open) {
            let slope = l.slope * self.eta[i];
            let open = self.op.blocks(i).filter(|(j, _)| self.place[*j] == OPEN);
            let right = open.fold(-values[i], |right, (j, block)| right + (slope * block) * values[j]);
            rhs.extend(right.to_array());
        }
        self.lu.solve(&mut rhs);
        let of = |(value, at): (&DVec3, &usize)| if *at == OPEN { -*value } else { DVec3::from_slice(&rhs[*at..]) };
        values.iter().zip(&self.place).map(of).collect()
    }

    /// The derivative of the projection times s, applied to a change of a contact's velocity: the change of the function.
    pub fn of_velocity(&self, i: usize, du: DVec3) -> DVec3 {
        self.locals[i].slope * du * self.eta[i]
    }

    /// The sign of det J: 1 or −1.
    pub fn sign(&self) -> f64 {
        self.lu.sign()
    }
}

/// The multiplier after a step: of a contact that slides, on the edge of its cone, whose curvature a step along the tangent leaves.
pub fn moved(r: DVec3, mu: f64, status: Status) -> DVec3 {
    let tangent = r.y.hypot(r.z);
    if status == Status::Slides && r.x > 0.0 && tangent > 0.0 {
        let scale = mu * r.x / tangent;
        return DVec3::new(r.x, r.y * scale, r.z * scale);
    }
    project_cone(r, DVec3::X, mu)
}
