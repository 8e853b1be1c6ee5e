//! Limits of joints, as rows of theirs. One that holds is a row like any other: Ψ, its distance from the limit, is 0 at the end of the step, or what of
//! it is recovered. One that does not hold has a compliance far above its response, so that it gives nothing, and the structure of the factor is the same.
//! Which of them hold is found by rounds ([`super::pivoting`]): a row that would pull is let go, and a limit that would be passed is held.

use super::motors::FREE;
use super::pivoting::Wrong;
use super::response::Response;
use crate::cpu::masses::Masses;
use crate::joint::Row;

/// What is rounding, over the speeds of a row's bodies.
const ROUNDING: f64 = 1e-9;
/// The same without any speed, m/s or rad/s.
const LEAST: f64 = 1e-10;

/// A limit that may be met in the step.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Id of the joint.
    pub joint: u32,
    /// Its row among those of the joints.
    pub row: u32,
    /// Whether it is a maximum.
    pub is_most: bool,
    /// Whether it holds.
    pub is_held: bool,
    /// Bias of its row where it holds, (Ψ − kept)/h, m/s or rad/s.
    pub rate: f64,
    /// What Ψ changes by over the step beyond its rate at the start, over h, m/s or rad/s.
    pub curve: f64,
}

/// The limits that may be met in a step, by their joints.
#[derive(Default)]
pub struct Limits(Vec<Limit>);

impl Limits {
    /// Discard those of the last step.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Add a limit.
    pub fn push(&mut self, limit: Limit) {
        self.0.push(limit);
    }

    /// Number of limits.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// All limits.
    pub fn iter(&self) -> impl Iterator<Item = &Limit> {
        self.0.iter()
    }

    /// [`Limits::iter`], to change them.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Limit> {
        self.0.iter_mut()
    }

    /// Those of a joint, whose rows are the last of the joint's.
    pub fn of_joint(&self, joint: u32) -> &[Limit] {
        let below = |id: u32| self.0.partition_point(|limit| limit.joint < id);
        &self.0[below(joint)..below(joint + 1)]
    }

    /// Let the rows be those of limits that hold, or do not.
    pub fn soften(&self, rows: &mut [Row], masses: &Masses) {
        self.soften_where(rows, masses, |limit| !limit.is_held);
    }

    /// Let the rows be those of limits none of which holds.
    pub fn soften_all(&self, rows: &mut [Row], masses: &Masses) {
        self.soften_where(rows, masses, |_| true);
    }

    fn soften_where(&self, rows: &mut [Row], masses: &Masses, is_free: impl Fn(&Limit) -> bool) {
        for limit in &self.0 {
            let row = &mut rows[limit.row as usize];
            row.softness = if is_free(limit) { FREE * masses.response(row) } else { 0.0 };
        }
    }

    /// Set the bias of the rows.
    pub fn set_bias(&self, bias: &mut [f64]) {
        for limit in &self.0 {
            bias[limit.row as usize] = if limit.is_held { limit.rate } else { 0.0 };
        }
    }

    /// The limits that are on the wrong side in a response: those that pull, and those that are passed. Rates of less than `error`, m/s or rad/s, are not seen.
    pub fn wrong(&self, rows: &[Row], masses: &Masses, response: &Response, error: f64) -> Vec<Wrong> {
        let of = |(index, limit): (usize, &Limit)| {
            let row = &rows[limit.row as usize];
            let [a, b] = row.bodies.map(|b| response.twist[b as usize]);
            let excess = match limit.is_held {
                true => -response.lambda[limit.row as usize] * masses.response(row),
                false => -(row.speed(a, b) + limit.rate + limit.curve),
            };
            let error = (ROUNDING * row.speeds(a, b) + LEAST).max(error);
            (excess > error).then_some(Wrong { index, side: if limit.is_held { 1.0 } else { 0.0 }, excess })
        };
        self.0.iter().enumerate().filter_map(of).collect()
    }

    /// Put a limit on its other side.
    pub fn set(&mut self, wrong: &Wrong) {
        self.0[wrong.index].is_held = wrong.side == 0.0;
    }
}
