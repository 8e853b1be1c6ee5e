//! Which limits of joints hold where rounds do not find it, as in long chains of hinges at their limits, whose rows are coupled by the arms of all links
//! between them: an interior point method for the linear complementarity problem λ ≥ 0, w = Bᵀv + Ψ/h ≥ 0, λ w = 0 of the limits, with the joints and
//! what contacts do as they are. A step of it is one solve of the joints, in which a limit has the compliance w/λ.
//! Source: Mehrotra, *On the implementation of a primal-dual interior point method* (1992).

use super::Joints;
use crate::cpu::masses::Masses;
use crate::cpu::solve::limits::Limit;
use crate::cpu::solve::response::Response;
use crate::twist::Twist;

/// The most steps.
const MOST: usize = 40;
/// What a step goes of the way to the nearest bound.
const SHY: f64 = 0.99;
/// What may be left of the mean λ w.
const LEFT: f64 = 1e-16;

/// A limit on the way.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// λ and w, N s and m/s or N m s and rad/s.
    at: [f64; 2],
    /// What they change by in a step.
    by: [f64; 2],
    /// The rate that a unit impulse gives the two bodies, 1/kg or 1/(kg m²).
    response: f64,
}

impl Joints {
    /// Let those limits hold that do so with what else acts on the bodies of a response, for another round. Rows are linear, or on the arcs of the last
    /// round. The response is lost.
    pub(super) fn settle_limits(&mut self, masses: &Masses, response: &mut Response, is_linear: bool) {
        if is_linear {
            self.bias.clone_from(&self.linear_bias);
            self.motors.set_bias(&self.rows, &mut self.bias);
            self.limits.iter_mut().for_each(|limit| limit.curve = 0.0);
        }
        for (row, lambda) in self.rows.iter().zip(&response.lambda) {
            masses.apply_row_impulse(&mut response.twist, row, -lambda);
        }
        let apart = response.twist.clone();
        // Arms of links may ask for far more than what parts two bodies at the rate at which they pass a limit.
        let rates = self.limits.iter().map(|limit| {
            let row = &self.rows[limit.row as usize];
            let passes = (row.speed_in(&apart) + limit.rate + limit.curve).abs();
            passes.max(response.lambda[limit.row as usize].abs() * masses.response(row))
        });
        let most = rates.fold(f64::MIN_POSITIVE, f64::max);
        let start = |limit: &Limit| {
            let response = masses.response(&self.rows[limit.row as usize]);
            Point { at: [most / response, most], by: [0.0; 2], response }
        };
        let mut points: Vec<Point> = self.limits.iter().map(start).collect();
        let first = mean(&points, 0.0);
        for _ in 0..MOST {
            for (limit, Point { at: [l, w], .. }) in self.limits.iter().zip(&points) {
                self.rows[limit.row as usize].softness = w / l;
            }
            self.factorise(masses);
            // Straight to the solution, then as central as that shows to be needed, with the products that it leaves.
            let before = mean(&points, 0.0);
            let straight = vec![0.0; points.len()];
            self.step_limits((masses, &apart), &straight, &mut points, response);
            let aim = (mean(&points, way(&points).min(1.0)) / before).powi(3) * before;
            let aims: Vec<f64> = points.iter().map(|p| aim / p.response - p.by[0] * p.by[1]).collect();
            self.step_limits((masses, &apart), &aims, &mut points, response);
            let way = (SHY * way(&points)).min(1.0);
            points.iter_mut().for_each(|p| (0..2).for_each(|k| p.at[k] += way * p.by[k]));
            if mean(&points, 0.0) <= LEFT * first {
                break;
            }
        }
        for (limit, Point { at: [l, w], response, .. }) in self.limits.iter_mut().zip(&points) {
            limit.is_held = l * response > *w;
        }
        self.bias.clone_from(&self.linear_bias);
    }

    /// Find the step of the limits to the products λ w of `aims`, where the bodies have the velocities `apart` without joints.
    fn step_limits(
        &mut self,
        (masses, apart): (&Masses, &[Twist]),
        aims: &[f64],
        points: &mut [Point],
        response: &mut Response,
    ) {
        for (limit, (Point { at: [l, w], .. }, aim)) in self.limits.iter().zip(points.iter().zip(aims)) {
            self.bias[limit.row as usize] = limit.rate + limit.curve - w - aim / l;
        }
        response.twist.clear();
        response.twist.extend_from_slice(apart);
        self.reset(response);
        self.solve(masses, response);
        for (limit, (Point { at: [l, w], by, .. }, aim)) in self.limits.iter().zip(points.iter_mut().zip(aims)) {
            let next = response.lambda[limit.row as usize];
            *by = [next - *l, (aim - *w * next) / *l];
        }
    }
}

/// Mean λ w, over what a unit impulse does, after a part `way` of the step.
fn mean(points: &[Point], way: f64) -> f64 {
    let product = |p: &Point| (p.at[0] + way * p.by[0]) * (p.at[1] + way * p.by[1]) * p.response;
    points.iter().map(product).sum::<f64>() / points.len() as f64
}

/// The part of the step at which a bound is met.
fn way(points: &[Point]) -> f64 {
    let bounds =
        points.iter().flat_map(|p| [0, 1].map(|k| if p.by[k] < 0.0 { -p.at[k] / p.by[k] } else { f64::INFINITY }));
    bounds.fold(f64::INFINITY, f64::min)
}
