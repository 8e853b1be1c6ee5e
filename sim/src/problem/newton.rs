//! Newton's method on exact friction, with a proximal term: small stiff problems to the rounding error, from a point near the solution.
//!
//! Each contact's law is the zero of Alart and Curnier's function: with y = r − s u and the disk of radius μ max(y_n, 0),
//!
//! ```text
//! F_n = r_n − max(y_n, 0)        F_t = r_t − Π_disk(y_t)
//! ```
//!
//! which, unlike the natural map, has no kink where a contact that is at the edge of its cone hardly slips. Redundant contacts make W
//! singular; a proximal term ρ (r − r_k) makes each step's system regular, and has no part in the solution (Acary, Brémond, Huber 2018).
//! ρ falls while the steps converge fast and rises where they do not.

use super::dense::Lu;
use super::matrix::MatrixOperator;
use crate::cpu::solve::cone::project_cone;
use crate::cpu::solve::operator::Operator;
use glam::{DMat3, DVec3};

/// First ρ over the mean eigenvalue of the blocks W_ii.
const FIRST: f64 = 0.01;
/// Number of Newton steps after which a proximal step is given up.
const STEPS: u32 = 15;
/// Number of steps without halving the residual after which it is given up.
const STALLED: u32 = 6;

/// What a contact does.
#[derive(Clone, Copy, PartialEq)]
enum Status {
    Open,
    Sticks,
    Slides,
}

/// The function of one contact, its status, and the derivative of the projection.
struct Local {
    value: DVec3,
    status: Status,
    slope: DMat3,
}

fn local(u: DVec3, r: DVec3, mu: f64, s: f64) -> Local {
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

/// Take proximal steps until the error is within a tolerance or `budget` factorisations are made. Returns the best multipliers and
/// their error; `budget` is what is left.
pub fn polish(op: &MatrixOperator, start: &[DVec3], tolerance: f64, budget: &mut u32) -> (Vec<DVec3>, f64) {
    let scale = (op.q.iter().map(|q| q.length_squared()).sum::<f64>()).sqrt();
    let mean = (0..start.len()).map(|i| 1.0 / op.eta(i)).sum::<f64>() / start.len() as f64;
    let (mut rho, mut cautious) = (FIRST * mean, 0);
    let mut gamma = start.to_vec();
    let mut best = (gamma.clone(), op.error(start, true));
    while best.1 > tolerance && *budget > 0 && rho < 100.0 * mean {
        let goal = (0.03 * best.1.min(op.error(&gamma, true))).max(0.1 * tolerance) * scale;
        let (next, steps, converged) = proximal(op, &gamma, rho, goal, budget);
        let error = op.error(&next, true);
        if error < best.1 {
            best = (next.clone(), error);
        }
        if !converged {
            (rho, cautious) = (3.0 * rho, 3);
            continue;
        }
        gamma = next;
        cautious -= 1;
        rho *= if steps >= 9 { 1.5 } else { 1.0 };
        if steps <= 5 && cautious <= 0 {
            rho = (rho / 3.0).max(1e-9 * mean);
        }
    }
    best
}

/// Solve the problem with a proximal term at `anchor`, until the residual is within `goal`. Returns the multipliers, the number of steps,
/// and whether they converged.
fn proximal(op: &MatrixOperator, anchor: &[DVec3], rho: f64, goal: f64, budget: &mut u32) -> (Vec<DVec3>, u32, bool) {
    let mut gamma = anchor.to_vec();
    let (mut least, mut stalled) = (f64::INFINITY, 0);
    for step in 0..=STEPS {
        let of = |i: usize| {
            let u = op.velocity(&gamma, i) + (gamma[i] - anchor[i]) * rho;
            local(u, gamma[i], op.friction[i], op.eta(i))
        };
        let locals: Vec<Local> = (0..gamma.len()).map(of).collect();
        let residual =
            locals.iter().enumerate().map(|(i, l)| (l.value / op.eta(i)).length_squared()).sum::<f64>().sqrt();
        if residual <= goal {
            return (gamma, step, true);
        }
        stalled = if residual < 0.5 * least { 0 } else { stalled + 1 };
        least = least.min(residual);
        if step == STEPS || stalled > STALLED || *budget == 0 || !residual.is_finite() {
            break;
        }
        *budget -= 1;
        let Some(change) = direction(op, &locals, rho) else { break };
        for (i, (r, d)) in gamma.iter_mut().zip(change).enumerate() {
            *r = moved(*r + d, op.friction[i], locals[i].status);
        }
    }
    (gamma, STEPS, false)
}

/// Newton's direction. The multipliers of open contacts become zero, so that the system is one of the closed contacts.
fn direction(op: &MatrixOperator, locals: &[Local], rho: f64) -> Option<Vec<DVec3>> {
    let mut place = vec![usize::MAX; locals.len()];
    let mut m = 0;
    for (place, _) in place.iter_mut().zip(locals).filter(|(_, l)| l.status != Status::Open) {
        *place = m;
        m += 3;
    }
    let (mut a, mut rhs) = (vec![0.0; m * m], vec![0.0; m]);
    for (i, l) in locals.iter().enumerate().filter(|(_, l)| l.status != Status::Open) {
        let slope = l.slope * op.eta(i);
        let mut right = -l.value;
        let mut put = |j: usize, block: DMat3| {
            for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                a[(place[i] + r) * m + place[j] + c] += block.col(c)[r];
            }
        };
        put(i, DMat3::IDENTITY - l.slope + slope * rho);
        for p in op.start[i] as usize..op.start[i + 1] as usize {
            let j = op.column[p] as usize;
            let block = slope * op.block[p];
            if place[j] == usize::MAX {
                right += block * locals[j].value;
            } else {
                put(j, block);
            }
        }
        rhs[place[i]..place[i] + 3].copy_from_slice(&right.to_array());
    }
    Lu::new(m, a)?.solve(&mut rhs);
    let of =
        |(l, at): (&Local, &usize)| if l.status == Status::Open { -l.value } else { DVec3::from_slice(&rhs[*at..]) };
    Some(locals.iter().zip(&place).map(of).collect())
}

/// The multiplier after a step: of a contact that slides, on the edge of its cone, whose curvature a step along the tangent leaves.
fn moved(r: DVec3, mu: f64, status: Status) -> DVec3 {
    let tangent = r.y.hypot(r.z);
    if status == Status::Slides && r.x > 0.0 && tangent > 0.0 {
        let scale = mu * r.x / tangent;
        return DVec3::new(r.x, r.y * scale, r.z * scale);
    }
    project_cone(r, DVec3::X, mu)
}
