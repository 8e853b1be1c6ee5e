//! The direct solves of a small problem of exact friction: when they are tried, in which order, and what they cost.

use super::matrix::MatrixOperator;
use super::{newton, path};
use crate::fill::SplitMix64;
use glam::DVec3;

/// Iterations after which the sweeps are held to stall.
const STALL: u32 = 16_000;
/// Maximum number of contacts: a factorisation has n³ operations, and the matrix (3n)² numbers.
const MAX_CONTACTS: usize = 700;
/// Factorisations that Newton's method may take at a time.
const NEWTON: u32 = 40;
/// Factorisations after which another path is tried, with other weights: the first has turned too often.
const PATH: u32 = 800;
/// Maximum number of paths.
const PATHS: u32 = 4;

/// The multipliers that a direct solve found.
pub struct Found {
    /// Multipliers with the lowest error (n_contacts).
    pub gamma: Vec<DVec3>,
    /// Their error.
    pub error: f64,
    /// Name of the method that found them.
    pub method: &'static str,
    /// Number of iterations that take as long as the solve took.
    pub iterations: u32,
}

/// The iteration from which on direct solves of exact friction are tried; never for a large problem.
pub fn first(op: &MatrixOperator) -> u32 {
    let is_small = op.q.len() <= MAX_CONTACTS && op.q.iter().any(|q| q.length_squared() > 0.0);
    if is_small { STALL } else { u32::MAX }
}

/// Iterations that take as long as a factorisation.
fn cost(op: &MatrixOperator) -> u32 {
    /// Operations on a block in a sweep, measured against those of a factorisation.
    const OF_A_BLOCK: f64 = 1200.0;
    let rows = 3.0 * op.q.len() as f64;
    (rows.powi(3) / (OF_A_BLOCK * op.block.len() as f64)).max(1.0) as u32
}

/// Solve exact friction for at most as long as a number of iterations takes: by Newton's method from the best multipliers so far, then
/// along central paths.
pub fn solve(op: &MatrixOperator, start: &[DVec3], tolerance: f64, iterations: u32) -> Found {
    let cost = cost(op);
    let all = iterations / cost;
    let mut found = Found { gamma: start.to_vec(), error: op.error(start, true), method: "newton", iterations: 0 };
    let mut own = NEWTON.min(all / 8);
    let mut left = all - own;
    found.keep(newton::polish(op, start, tolerance, &mut own), "newton");
    left += own;
    // The cones of contacts without friction have no interior.
    if found.error > tolerance && op.friction.iter().all(|mu| *mu > 0.0) {
        let mut weights = vec![1.0; start.len()];
        let mut random = SplitMix64(0);
        for _ in 0..PATHS {
            if found.error <= tolerance {
                break;
            }
            let mut own = PATH.min(left);
            left -= own;
            found.keep(path::follow(op, &weights, tolerance, &mut own), "central_path");
            left += own;
            weights.fill_with(|| 2f64.powf(random.between(-1.0, 1.0)));
        }
    }
    Found { iterations: (all - left).saturating_mul(cost), ..found }
}

impl Found {
    /// Keep what another method found, if it is better.
    fn keep(&mut self, (gamma, error): (Vec<DVec3>, f64), method: &'static str) {
        if error < self.error {
            (self.gamma, self.error, self.method) = (gamma, error, method);
        }
    }
}
