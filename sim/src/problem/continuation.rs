//! Numerical continuation of exact friction by the length of a curve: small stiff problems that sweeps and the central path leave unsolved.
//!
//! With a compliance ε D of the contacts, of diagonal D, the problem u = Wr + q + ε D (r − a) has one solution for great ε, near the anchor
//! a, and is the problem itself for ε = 0. The solutions between are a curve of r and λ = log ε, on which Alart and Curnier's function F is
//! zero. It has kinks, where a contact opens, closes, sticks or slips, and it turns: ε rises for a while before it falls on. So it is
//! followed by its length (pseudo-arc-length; Allgower and Georg 1990), and the sign of det ∂F/∂r says which way is on, at turns and kinks
//! alike (a solution's index; Kojima and Hirabayashi 1984). Once the error is lower than the anchor's and rises again, the best multipliers
//! become the anchor of another curve, with other weights in D.

use super::alart_curnier::{Derivative, Local, Status, local, moved};
use super::matrix::MatrixOperator;
use crate::cpu::solve::operator::Operator;
use crate::fill::SplitMix64;
use glam::DVec3;

/// ε at which a curve starts, over the mean eigenvalue of the blocks W_ii, and the λ beyond which it is lost.
const START: f64 = 3.0;
const LOST: f64 = 3.0;
/// Newton steps to the start of a curve.
const START_STEPS: u32 = 30;
/// First, greatest and least step along a curve.
const FIRST_STEP: f64 = 0.3;
const MAX_STEP: f64 = 0.7;
const MIN_STEP: f64 = 1e-11;
/// Number of corrections of a step, and after how many the residual must halve.
const CORRECTIONS: u32 = 8;
const HALVES: u32 = 4;
/// Residual at which corrections end, over that of ε D (r − a).
const ON_CURVE: f64 = 1e-4;
/// Least cosine of the angle by which a curve turns in a step, if the step is not as short as this.
const TURN: f64 = 0.3;
const TURN_STEP: f64 = 0.05;
/// A curve ends once the error is lower than the anchor's by the first, and has risen from its least by the second.
const LOWER: f64 = 0.7;
const RISEN: f64 = 3.0;

/// A problem with compliant contacts.
struct Compliant<'a> {
    op: &'a MatrixOperator,
    anchor: &'a [DVec3],
    /// D (n_contacts).
    weights: Vec<f64>,
    /// |q|.
    scale: f64,
    /// The error that is sought.
    tolerance: f64,
}

/// A point: multipliers, λ, and the problem there.
struct Point {
    gamma: Vec<DVec3>,
    log: f64,
    /// ε D and the s of Alart and Curnier's function (n_contacts).
    compliance: Vec<f64>,
    eta: Vec<f64>,
    locals: Vec<Local>,
    /// |F / s|.
    residual: f64,
}

/// −J⁻¹ F and −J⁻¹ ∂F/∂λ with J = ∂F/∂r, and the sign of det J.
struct Linear {
    newton: Vec<DVec3>,
    along: Vec<DVec3>,
    sign: f64,
}

impl Linear {
    /// The tangent at a point that goes on.
    fn tangent(&self, at: &Point, orientation: f64) -> Tangent {
        let squared = dot(&at.gamma, &at.gamma).max(1e-30);
        let log = self.sign * orientation / (dot(&self.along, &self.along) / squared + 1.0).sqrt();
        Tangent { gamma: self.along.iter().map(|x| *x * log).collect(), log, squared }
    }
}

/// A unit direction of r and λ; lengths of r are over |r|.
struct Tangent {
    gamma: Vec<DVec3>,
    log: f64,
    /// |r|².
    squared: f64,
}

/// A place on a curve, the tangent there, and the next step.
struct Place {
    point: Point,
    tangent: Tangent,
    step: f64,
    /// det J times the change of λ keeps this sign.
    orientation: f64,
}

/// A step that was made: the point, the tangent there, the number of corrections, and the step.
type Made = (Point, Tangent, u32, f64);

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// a + t b.
fn sum(a: &[DVec3], b: &[DVec3], t: f64) -> Vec<DVec3> {
    a.iter().zip(b).map(|(a, b)| *a + *b * t).collect()
}

/// Follow curves from some multipliers until the error is within a tolerance or `budget` factorisations are made. Returns the best
/// multipliers and their error; `budget` is what is left.
pub fn follow(op: &MatrixOperator, start: &[DVec3], tolerance: f64, budget: &mut u32) -> (Vec<DVec3>, f64) {
    let mean = (0..start.len()).map(|i| 1.0 / op.eta(i)).sum::<f64>() / start.len() as f64;
    let scale = op.scale();
    let mut best = (start.to_vec(), op.error(start, true));
    let mut weights = vec![mean; start.len()];
    let mut random = SplitMix64(0);
    while best.1 > tolerance && *budget > 0 {
        let anchor = best.0.clone();
        let of = Compliant { op, anchor: &anchor, weights: weights.clone(), scale, tolerance };
        of.trace(&mut best, budget);
        weights.fill_with(|| mean * 2f64.powf(random.between(-1.0, 1.0)));
    }
    best
}

impl Compliant<'_> {
    fn at(&self, gamma: Vec<DVec3>, log: f64) -> Point {
        let op = self.op;
        let compliance: Vec<f64> = self.weights.iter().map(|d| log.exp() * d).collect();
        let eta: Vec<f64> = compliance.iter().enumerate().map(|(i, c)| 1.0 / (1.0 / op.eta(i) + c)).collect();
        let of = |i: usize| {
            let u = op.velocity(&gamma, i) + (gamma[i] - self.anchor[i]) * compliance[i];
            local(u, gamma[i], op.friction[i], eta[i])
        };
        let locals: Vec<Local> = (0..gamma.len()).map(of).collect();
        let residual = locals.iter().zip(&eta).map(|(l, s)| (l.value / *s).length_squared()).sum::<f64>().sqrt();
        Point { gamma, log, compliance, eta, locals, residual }
    }

    /// ε D (r − a): the change of u with λ.
    fn give(&self, at: &Point, i: usize) -> DVec3 {
        (at.gamma[i] - self.anchor[i]) * at.compliance[i]
    }

    /// The residual of a point on the curve is no more.
    fn on_curve(&self, at: &Point) -> f64 {
        let give = (0..at.gamma.len()).map(|i| self.give(at, i).length_squared()).sum::<f64>().sqrt();
        ON_CURVE * give + (1e-5 * self.tolerance).max(3e-15) * self.scale
    }

    /// None if J is singular, or without budget.
    fn linear(&self, at: &Point, budget: &mut u32) -> Option<Linear> {
        *budget = budget.checked_sub(1)?;
        let derivative = Derivative::new(self.op, &at.locals, &at.eta, &at.compliance)?;
        let values: Vec<DVec3> = at.locals.iter().map(|l| l.value).collect();
        let by_log: Vec<DVec3> = (0..values.len()).map(|i| derivative.of_velocity(i, self.give(at, i))).collect();
        Some(Linear { newton: derivative.solve(&values), along: derivative.solve(&by_log), sign: derivative.sign() })
    }

    /// The tangent that goes on.
    fn tangent(&self, at: &Point, orientation: f64, budget: &mut u32) -> Option<Tangent> {
        Some(self.linear(at, budget)?.tangent(at, orientation))
    }

    /// A point moved by Newton's steps: those of contacts that slide stay on the edge of their cones.
    fn stepped(&self, at: &Point, change: &[DVec3], log: f64) -> Point {
        let of = |i: usize| moved(at.gamma[i] + change[i], self.op.friction[i], at.locals[i].status);
        self.at((0..change.len()).map(of).collect(), log)
    }

    /// The start of the curve, and its tangent.
    fn start(&self, budget: &mut u32) -> Option<Place> {
        let mut point = self.at(self.anchor.to_vec(), START.ln());
        for _ in 0..START_STEPS {
            let linear = self.linear(&point, budget)?;
            point = self.stepped(&point, &linear.newton, point.log);
            if point.residual <= 1e-12 * self.scale {
                break;
            }
        }
        // λ falls at first.
        let linear = self.linear(&point, budget)?;
        let orientation = -linear.sign;
        let tangent = linear.tangent(&point, orientation);
        Some(Place { point, tangent, step: FIRST_STEP, orientation })
    }

    /// Follow the curve, and keep the best multipliers and their error.
    fn trace(&self, best: &mut (Vec<DVec3>, f64), budget: &mut u32) {
        let anchored = best.1;
        let end = (1e-4 * self.tolerance).min(1e-12).ln();
        let Some(mut place) = self.start(budget) else { return };
        while best.1 > self.tolerance && *budget > 0 && (end..LOST).contains(&place.point.log) {
            if !self.advance(&mut place, budget) {
                if place.step < MIN_STEP {
                    break;
                }
                continue;
            }
            let error = self.op.error(&place.point.gamma, true);
            if error < best.1 {
                *best = (place.point.gamma.clone(), error);
            }
            if error > RISEN * best.1 && best.1 < LOWER * anchored {
                break;
            }
        }
    }

    /// Make a step, or shorten the next one and say no.
    fn advance(&self, place: &mut Place, budget: &mut u32) -> bool {
        let made = self.smooth(place, budget).or_else(|| self.past_kink(place, budget));
        let Some((point, tangent, corrections, step)) = made else {
            place.step *= 0.3;
            return false;
        };
        place.step = match corrections {
            0..=2 => (3.0 * step).min(MAX_STEP),
            3..=4 => (1.7 * step).min(MAX_STEP),
            5..=6 => step,
            _ => 0.8 * step,
        };
        (place.point, place.tangent) = (point, tangent);
        true
    }

    /// A step along the tangent; none if the curve turns away.
    fn smooth(&self, place: &Place, budget: &mut u32) -> Option<Made> {
        let (point, corrections) = self.corrected(&place.point, &place.tangent, place.step, budget)?;
        let tangent = self.tangent(&point, place.orientation, budget)?;
        let cosine =
            dot(&place.tangent.gamma, &tangent.gamma) / place.tangent.squared + place.tangent.log * tangent.log;
        (place.step <= TURN_STEP || cosine >= TURN).then_some((point, tangent, corrections, place.step))
    }

    /// A step from the next kink, along the tangent beyond it.
    fn past_kink(&self, place: &Place, budget: &mut u32) -> Option<Made> {
        let (from, along) = (&place.point, &place.tangent);
        let way = self.to_kink(from, along);
        if !(way < place.step) {
            return None;
        }
        let beyond = way * 1.001 + 1e-9;
        let kink = self.at(sum(&from.gamma, &along.gamma, beyond), from.log + beyond * along.log);
        let tangent = self.tangent(&kink, place.orientation, budget)?;
        let mut step = place.step.min(way.max(1e-4));
        for _ in 0..3 {
            if let Some((point, corrections)) = self.corrected(&kink, &tangent, step, budget) {
                let tangent = self.tangent(&point, place.orientation, budget)?;
                return Some((point, tangent, corrections, step));
            }
            step *= 0.1;
        }
        None
    }

    /// The point of the curve across the tangent at a step, and the number of corrections; none if they do not converge nearby.
    fn corrected(&self, from: &Point, tangent: &Tangent, step: f64, budget: &mut u32) -> Option<(Point, u32)> {
        let mut point = self.at(sum(&from.gamma, &tangent.gamma, step), from.log + step * tangent.log);
        let mut least = f64::INFINITY;
        for made in 0..=CORRECTIONS {
            if point.residual < self.on_curve(&point) {
                let away = sum(&point.gamma, &from.gamma, -1.0);
                let length = (dot(&away, &away) / tangent.squared + (point.log - from.log).powi(2)).sqrt();
                return (length <= 3.0 * step + 1e-12).then_some((point, made));
            }
            let diverges = !(point.residual <= 1e3 * self.scale) || made >= HALVES && point.residual > 0.5 * least;
            if made == CORRECTIONS || diverges {
                return None;
            }
            least = least.min(point.residual);
            let linear = self.linear(&point, budget)?;
            let across = dot(&tangent.gamma, &linear.along) / tangent.squared + tangent.log;
            let share = -dot(&tangent.gamma, &linear.newton) / tangent.squared / across;
            let share = if across.abs() > 1e-14 { share.clamp(-0.5, 0.5) } else { 0.0 };
            point = self.stepped(&point, &sum(&linear.newton, &linear.along, share), point.log + share);
        }
        None
    }

    /// The way along the tangent to the first change of a contact's status.
    fn to_kink(&self, at: &Point, along: &Tangent) -> f64 {
        let of = |i: usize| {
            let coupled = self.op.blocks(i).map(|(j, block)| block * along.gamma[j]).sum::<DVec3>();
            let du = coupled + along.gamma[i] * at.compliance[i] + self.give(at, i) * along.log;
            let u = self.op.velocity(&at.gamma, i) + self.give(at, i);
            let (y, dy) = (at.gamma[i] - u * at.eta[i], along.gamma[i] - du * at.eta[i]);
            changes(at.locals[i].status, y, dy, self.op.friction[i])
        };
        (0..at.gamma.len()).map(of).fold(f64::INFINITY, f64::min)
    }
}

/// The least t > 0 at which a contact with y + t dy has another status.
fn changes(status: Status, y: DVec3, dy: DVec3, mu: f64) -> f64 {
    let ahead = |t: f64| if t > 0.0 { t } else { f64::INFINITY };
    let opens_or_closes = if (status == Status::Open) == (dy.x > 0.0) { ahead(-y.x / dy.x) } else { f64::INFINITY };
    if status == Status::Open {
        return opens_or_closes;
    }
    // |y_t|² = μ² y_n².
    let product = |a: DVec3, b: DVec3| a.y * b.y + a.z * b.z - mu * mu * a.x * b.x;
    let (a, b, c) = (product(dy, dy), product(y, dy), product(y, y));
    let k = -b - (b * b - a * c).sqrt().copysign(b);
    let edge = |t: f64| if y.x + t * dy.x > 0.0 { ahead(t) } else { f64::INFINITY };
    opens_or_closes.min(edge(k / a)).min(edge(c / k))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_kink_is_where_the_status_changes() {
        let v = DVec3::new;
        // Opens at 2, slides at 1: |y_t| = t meets μ y_n = 2 − t.
        assert!((changes(Status::Sticks, v(2.0, 0.0, 0.0), v(-1.0, 1.0, 0.0), 1.0) - 1.0).abs() < 1e-12);
        // Slides on until it opens.
        assert!((changes(Status::Slides, v(2.0, 3.0, 0.0), v(-1.0, 0.0, 0.0), 1.0) - 2.0).abs() < 1e-12);
        // Sticks again: 3 − t meets 2.
        assert!((changes(Status::Slides, v(2.0, 3.0, 0.0), v(0.0, -1.0, 0.0), 1.0) - 1.0).abs() < 1e-12);
        assert!((changes(Status::Open, v(-2.0, 3.0, 0.0), v(4.0, 0.0, 0.0), 1.0) - 0.5).abs() < 1e-12);
        assert_eq!(changes(Status::Open, v(-2.0, 3.0, 0.0), v(-4.0, 9.0, 0.0), 1.0), f64::INFINITY);
        assert_eq!(changes(Status::Sticks, v(2.0, 0.0, 0.0), v(1.0, 0.1, 0.0), 1.0), f64::INFINITY);
    }
}
