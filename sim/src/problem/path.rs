//! The central path of exact friction, followed by its length: small stiff problems, from no knowledge of the solution.
//!
//! The cones are made those of Lorentz: z = (μ r_n, r_t) and s = (u_n/μ + |u_t|, u_t) with u = Wr + q, both in x_n ≥ |x_t|, and a solution
//! has z ∘ s = 0 with the Jordan product ∘. The path is that of the solutions of
//!
//! ```text
//! s = s(z)        z ∘ s = τ w (1, 0, 0)
//! ```
//!
//! with a weight w of each contact. Far out, at great τ, there is one. Exact friction is not monotone, so that the path may turn: where methods that only lower τ stall, it
//! is followed by its length, as in numerical continuation (Allgower, Georg 1990), through its turns to τ = 0. Directions are those of
//! Newton's method in the scaling of Nesterov and Todd; lengths are measured in it too, over √τ, and log τ is one more coordinate. Near the
//! end, Newton's method on the law itself takes over.

use super::dense::Lu;
use super::matrix::MatrixOperator;
use super::newton;
use crate::cpu::solve::lorentz::{Scaling, longest, product, quotient};
use crate::cpu::solve::operator::Operator;
use glam::{DMat3, DVec3};

/// First step along the path, and the limits of steps.
const FIRST_STEP: f64 = 0.5;
const MAX_STEP: f64 = 1.0;
const MIN_STEP: f64 = 1e-3;
/// Where the path starts, over the size of the problem.
const START: f64 = 10.0;
/// Number of corrections of a step, and the distance from the path, over τ, at which they end.
const CORRECTIONS: u32 = 10;
const CENTRED: f64 = 0.3;
/// Distance from s = s(z), over √τ, at which they end.
const FEASIBLE: f64 = 0.02;
/// Least cosine of the angle by which the path turns in a step, if the step is not as short as this.
const TURN: f64 = 0.7;
const TURN_STEP: f64 = 0.02;
/// Error from which on Newton's method is tried, again at a tenth of it, and the factorisations that it may take.
const NEAR: f64 = 1e-5;
const NEWTON: u32 = 15;

/// A point near the path.
#[derive(Clone)]
struct Point {
    z: Vec<DVec3>,
    s: Vec<DVec3>,
    tau: f64,
}

/// A direction: changes of z, s and log τ.
#[derive(Clone)]
struct Direction {
    z: Vec<DVec3>,
    s: Vec<DVec3>,
    log_tau: f64,
}

impl Point {
    /// Move by a share of a direction, at most by `share` of the way to the boundary.
    fn advance(&mut self, d: &Direction, most: f64, share: f64) {
        let limit =
            |x: &[DVec3], d: &[DVec3]| x.iter().zip(d).map(|(x, d)| longest(*x, *d)).fold(f64::INFINITY, f64::min);
        let t = (share * limit(&self.z, &d.z).min(limit(&self.s, &d.s))).min(most);
        self.z.iter_mut().zip(&d.z).for_each(|(x, d)| *x += *d * t);
        self.s.iter_mut().zip(&d.s).for_each(|(x, d)| *x += *d * t);
        self.tau *= (t * d.log_tau).exp();
    }

    /// The multipliers r of z.
    fn gamma(&self, op: &MatrixOperator) -> Vec<DVec3> {
        self.z.iter().zip(&op.friction).map(|(z, mu)| DVec3::new(z.x / mu, z.y, z.z)).collect()
    }
}

/// A problem, and the weights of its contacts.
#[derive(Clone, Copy)]
struct Weighted<'a> {
    op: &'a MatrixOperator,
    weights: &'a [f64],
}

/// The problem at a point.
struct Local<'a> {
    /// The problem.
    of: Weighted<'a>,
    /// Contact velocities u.
    velocity: Vec<DVec3>,
    /// s(z) − s.
    residual: Vec<DVec3>,
    scalings: Vec<Scaling>,
    /// λ = W z = W⁻¹ s.
    lambda: Vec<DVec3>,
    tau: f64,
}

impl<'a> Local<'a> {
    fn new(of: Weighted<'a>, at: &Point) -> Local<'a> {
        let op = of.op;
        let gamma = at.gamma(op);
        let velocity: Vec<DVec3> = (0..gamma.len()).map(|i| op.velocity(&gamma, i)).collect();
        let image = |(u, mu): (&DVec3, &f64)| DVec3::new(u.x / mu + u.y.hypot(u.z), u.y, u.z);
        let residual = velocity.iter().zip(&op.friction).map(image).zip(&at.s).map(|(image, s)| image - *s).collect();
        let scalings: Vec<Scaling> = at.z.iter().zip(&at.s).map(|(z, s)| Scaling::new(*z, *s)).collect();
        let lambda = scalings.iter().zip(&at.z).map(|(w, z)| w.apply(*z)).collect();
        Local { of, velocity, residual, scalings, lambda, tau: at.tau }
    }

    /// τ w (1, 0, 0) of a contact.
    fn target(&self, i: usize) -> DVec3 {
        DVec3::X * (self.tau * self.of.weights[i])
    }

    /// λ ∘ λ less that, of each contact.
    fn centring(&self) -> Vec<DVec3> {
        self.lambda.iter().enumerate().map(|(i, l)| product(*l, *l) - self.target(i)).collect()
    }

    /// The inner product of changes of z, in the scaling and over τ.
    fn inner(&self, a: &[DVec3], b: &[DVec3]) -> f64 {
        let of = |i: usize| self.scalings[i].apply(a[i]).dot(self.scalings[i].apply(b[i]));
        (0..a.len()).map(of).sum::<f64>() / (self.tau * a.len() as f64)
    }

    /// Factorise N' + W², with the derivative N' of s(z).
    fn factorise(&self) -> Option<Lu> {
        let op = self.of.op;
        let m = 3 * self.scalings.len();
        let mut a = vec![0.0; m * m];
        for (i, scaling) in self.scalings.iter().enumerate() {
            let mut put = |j: usize, block: DMat3| {
                for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                    a[(3 * i + r) * m + 3 * j + c] += block.col(c)[r];
                }
            };
            put(i, scaling.square());
            let u = self.velocity[i];
            let slip = u.y.hypot(u.z).max(f64::MIN_POSITIVE);
            let own = DMat3::from_cols(
                DVec3::X / op.friction[i],
                DVec3::new(u.y / slip, 1.0, 0.0),
                DVec3::new(u.z / slip, 0.0, 1.0),
            );
            for p in op.start[i] as usize..op.start[i + 1] as usize {
                let j = op.column[p] as usize;
                put(j, own * op.block[p] * DMat3::from_diagonal(DVec3::new(1.0 / op.friction[j], 1.0, 1.0)));
            }
        }
        Lu::new(m, a)
    }

    /// The direction with λ ∘ (W dz + W⁻¹ ds) = c and ds = N' dz + residual.
    fn direction(&self, lu: &Lu, c: impl Fn(usize) -> DVec3, residual: impl Fn(usize) -> DVec3) -> Direction {
        let n = self.lambda.len();
        let target: Vec<DVec3> = (0..n).map(|i| self.scalings[i].apply(quotient(self.lambda[i], c(i)))).collect();
        let mut flat: Vec<f64> = (0..n).flat_map(|i| (target[i] - residual(i)).to_array()).collect();
        lu.solve(&mut flat);
        let z: Vec<DVec3> = flat.chunks(3).map(DVec3::from_slice).collect();
        let s = (0..n).map(|i| target[i] - self.scalings[i].square() * z[i]).collect();
        Direction { z, s, log_tau: 0.0 }
    }

    /// The direction along the path for log τ that grows by one.
    fn along(&self, lu: &Lu) -> Direction {
        let direction = self.direction(lu, |i| self.target(i), |_| DVec3::ZERO);
        Direction { log_tau: 1.0, ..direction }
    }
}

/// Follow the path with some weights (n_contacts) until the error is within a tolerance or `budget` factorisations are made. All
/// coefficients of friction are above zero. Returns the best multipliers and their error; `budget` is what is left.
pub fn follow(op: &MatrixOperator, weights: &[f64], tolerance: f64, budget: &mut u32) -> (Vec<DVec3>, f64) {
    let of = Weighted { op, weights };
    let n = op.q.len();
    let speed = (op.q.iter().map(|q| q.length_squared()).sum::<f64>() / n as f64).sqrt();
    let mean = (0..n).map(|i| 1.0 / op.eta(i)).sum::<f64>() / n as f64;
    let z = weights.iter().map(|w| DVec3::X * (START * speed / mean * w)).collect();
    let s = vec![DVec3::X * (START * speed); n];
    let mut at = Point { z, s, tau: (START * speed).powi(2) / mean };
    let far = 10.0 * at.tau;
    let mut best = (vec![DVec3::ZERO; n], f64::INFINITY);
    // The last point on the path, and its tangent.
    let mut last: Option<(Point, Direction)> = None;
    let (mut step, mut near) = (FIRST_STEP, NEAR);
    while *budget > 0 && at.tau < far {
        let corrections = correct(of, &mut at, last.as_ref().map(|(_, tangent)| tangent), mean, budget);
        let gamma = at.gamma(op);
        let error = op.error(&gamma, true);
        if error < best.1 {
            best = (gamma, error);
        }
        if best.1 <= near && best.1 > tolerance {
            near = 0.1 * best.1;
            let mut own = NEWTON.min(*budget);
            *budget -= own;
            let ended = newton::polish(op, &best.0, tolerance, &mut own);
            *budget += own;
            if ended.1 < best.1 {
                best = ended;
            }
        }
        if best.1 <= tolerance {
            break;
        }
        let tangent = corrections.and_then(|_| tangent(of, &at, last.as_ref().map(|(_, tangent)| tangent), budget));
        let turns = matches!((&tangent, &last), (Some((_, cosine)), Some(_)) if *cosine < TURN && step > TURN_STEP);
        match (tangent, &last) {
            (Some((tangent, _)), _) if !turns => {
                if last.is_some() && corrections.is_some_and(|made| made <= 3) {
                    step = (1.6 * step).min(MAX_STEP);
                }
                last = Some((at.clone(), tangent));
            }
            // Again from the last point, by less.
            (_, Some((point, _))) if step > MIN_STEP => {
                step *= 0.4;
                at = point.clone();
            }
            _ => break,
        }
        if let Some((_, tangent)) = &last {
            at.advance(tangent, step, 0.6);
        }
    }
    best
}

/// Correct a point onto the path, across the tangent. Returns the number of corrections; none if they do not converge.
fn correct(of: Weighted, at: &mut Point, tangent: Option<&Direction>, mean: f64, budget: &mut u32) -> Option<u32> {
    for made in 0..CORRECTIONS {
        let local = Local::new(of, at);
        let centring = local.centring();
        let distance = centring.iter().map(|c| c.length_squared()).fold(0.0, f64::max).sqrt() / at.tau;
        let residual = local.residual.iter().map(|r| r.length_squared()).sum::<f64>();
        let residual = (residual / (centring.len() as f64 * at.tau * mean)).sqrt();
        if distance < CENTRED && residual < FEASIBLE {
            return Some(made);
        }
        if !distance.is_finite() || !residual.is_finite() || *budget == 0 {
            return None;
        }
        *budget -= 1;
        let lu = local.factorise()?;
        let mut change = local.direction(&lu, |i| -centring[i], |i| local.residual[i]);
        if let Some(tangent) = tangent {
            let along = local.along(&lu);
            let (a, b) = (local.inner(&tangent.z, &change.z), local.inner(&tangent.z, &along.z) + tangent.log_tau);
            let share = if b.abs() > 1e-12 { (-a / b).clamp(-0.5, 0.5) } else { 0.0 };
            change.z.iter_mut().zip(&along.z).for_each(|(d, a)| *d += *a * share);
            change.s.iter_mut().zip(&along.s).for_each(|(d, a)| *d += *a * share);
            change.log_tau = share;
        }
        at.advance(&change, 1.0, 0.9);
    }
    None
}

/// The unit tangent at a point of the path, on from the last one, or at first to lower τ, and the cosine of the angle between them.
fn tangent(of: Weighted, at: &Point, last: Option<&Direction>, budget: &mut u32) -> Option<(Direction, f64)> {
    *budget = budget.saturating_sub(1);
    let local = Local::new(of, at);
    let along = local.along(&local.factorise()?);
    let length = (local.inner(&along.z, &along.z) + 1.0).sqrt();
    let cosine = last.map_or(-1.0, |last| {
        let of_last = (local.inner(&last.z, &last.z) + last.log_tau * last.log_tau).sqrt();
        (local.inner(&last.z, &along.z) + last.log_tau) / (length * of_last)
    });
    let scale = cosine.signum() / length;
    let scaled = |x: &[DVec3]| x.iter().map(|x| *x * scale).collect();
    Some((Direction { z: scaled(&along.z), s: scaled(&along.s), log_tau: scale }, cosine.abs()))
}
