//! The direct solves of exact friction in small parts: when they are tried, in which order, and what they cost.

use super::components::{part, split};
use super::matrix::MatrixOperator;
use super::{continuation, newton, path};
use crate::fill::SplitMix64;
use glam::DVec3;

/// Iterations after which the sweeps are held to stall.
const STALL: u32 = 16_000;
/// Maximum number of contacts of a part: a factorisation has n³ operations, and the matrix (3n)² numbers.
const MAX_CONTACTS: usize = 700;
/// Factorisations that Newton's method may take at a time.
const NEWTON: u32 = 40;
/// Factorisations after which another path is tried, with other weights: the first has turned too often.
const PATH: u32 = 800;
/// Maximum number of paths.
const PATHS: u32 = 4;
/// Factorisations that the continuation may take.
const CONTINUATION: u32 = 20_000;
/// The methods, in the order in which they are tried.
const METHODS: [&str; 3] = ["newton", "central_path", "continuation"];

/// The multipliers that direct solves found.
pub struct Found {
    /// Multipliers with the lowest error (n_contacts).
    pub gamma: Vec<DVec3>,
    /// Their error.
    pub error: f64,
    /// Name of the method that found them; of several parts, the last one in the order of trial.
    pub method: &'static str,
    /// Number of iterations that take as long as the solves took.
    pub iterations: u32,
}

/// How long direct solves may take, in iterations.
#[derive(Clone, Copy)]
pub struct Limits {
    /// Newton's method and the central paths.
    pub early: u32,
    /// The continuation.
    pub late: u32,
}

/// The iteration from which on direct solves of exact friction are tried; never for a problem with a large part.
pub fn first(op: &MatrixOperator) -> u32 {
    let is_small = split(op).last().is_some_and(|part| part.len() <= MAX_CONTACTS);
    if is_small && op.q.iter().any(|q| q.length_squared() > 0.0) { STALL } else { u32::MAX }
}

/// Iterations on a problem that take as long as a factorisation of a part.
fn cost(op: &MatrixOperator, contacts: usize) -> f64 {
    /// Operations on a block in a sweep, measured against those of a factorisation.
    const OF_A_BLOCK: f64 = 1200.0;
    (3.0 * contacts as f64).powi(3) / (OF_A_BLOCK * op.block.len() as f64)
}

/// Solve exact friction, part by part, from the best multipliers so far.
pub fn solve(op: &MatrixOperator, start: &[DVec3], tolerance: f64, limits: Limits) -> Found {
    let mut gamma = start.to_vec();
    let (mut left, mut method) = ([limits.early, limits.late].map(f64::from), 0);
    let parts = split(op);
    for contacts in &parts {
        let own = part(op, contacts);
        let cost = cost(op, contacts.len());
        let budgets = left.map(|iterations| (iterations / cost) as u32);
        // The squares of the parts' residuals add up.
        let tolerance = tolerance * (op.scale() / own.scale()) / (parts.len() as f64).sqrt();
        let start = contacts.iter().map(|i| start[*i]).collect();
        let mut solve = PartSolve::new(&own, start, tolerance, budgets);
        solve.run();
        (0..2).for_each(|k| left[k] -= f64::from(budgets[k] - solve.budgets[k]) * cost);
        method = method.max(solve.method);
        contacts.iter().zip(&solve.gamma).for_each(|(i, own)| gamma[*i] = *own);
    }
    let iterations = (f64::from(limits.early) - left[0] + f64::from(limits.late) - left[1]).ceil() as u32;
    Found { error: op.error(&gamma, true), gamma, method: METHODS[method], iterations }
}

/// The solve of one part.
struct PartSolve<'a> {
    op: &'a MatrixOperator,
    tolerance: f64,
    /// The best multipliers, their error, and the method that found them, in the order of trial.
    gamma: Vec<DVec3>,
    error: f64,
    method: usize,
    /// Factorisations that are left to Newton's method and the paths, and to the continuation.
    budgets: [u32; 2],
}

impl<'a> PartSolve<'a> {
    fn new(op: &'a MatrixOperator, gamma: Vec<DVec3>, tolerance: f64, budgets: [u32; 2]) -> PartSolve<'a> {
        // What nothing moves needs no impulses.
        let gamma = if op.scale() > 0.0 { gamma } else { vec![DVec3::ZERO; gamma.len()] };
        let error = op.error(&gamma, true);
        PartSolve { op, tolerance, gamma, error, method: 0, budgets }
    }

    fn run(&mut self) {
        let most = NEWTON.min(self.budgets[0] / 8);
        self.attempt(0, most, |solve, own| newton::polish(solve.op, &solve.gamma, solve.tolerance, own));
        // The cones of contacts without friction have no interior.
        if self.op.friction.iter().all(|mu| *mu > 0.0) {
            let mut weights = vec![1.0; self.gamma.len()];
            let mut random = SplitMix64(0);
            for _ in 0..PATHS {
                self.attempt(1, PATH, |solve, own| path::follow(solve.op, &weights, solve.tolerance, own));
                weights.fill_with(|| 2f64.powf(random.between(-1.0, 1.0)));
            }
        }
        let of = |solve: &Self, own: &mut u32| continuation::follow(solve.op, &solve.gamma, solve.tolerance, own);
        self.attempt(2, CONTINUATION, of);
    }

    /// Let a method make at most a number of factorisations, unless the part is solved, and keep what it finds, if that is better.
    fn attempt(&mut self, method: usize, most: u32, find: impl FnOnce(&Self, &mut u32) -> (Vec<DVec3>, f64)) {
        let budget = usize::from(method == 2);
        let own = most.min(self.budgets[budget]);
        if self.error <= self.tolerance || own == 0 {
            return;
        }
        let mut left = own;
        let (gamma, error) = find(self, &mut left);
        self.budgets[budget] -= own - left;
        if error < self.error {
            (self.gamma, self.error, self.method) = (gamma, error, method);
        }
    }
}
