//! Factorisations that last for many steps. Where joints act alone and hardly move in a step, as those of nets that hang, trusses and slow machines, the
//! factor of an earlier step solves them nearly: what it leaves is solved again with it, until as little is left as by a factorisation of the step's
//! own (iterative refinement). Large systems alone gain by it, whose factorisation costs many solves.
//!
//! How far bodies may turn until a factor is too old differs: long chains of joints tell less than a thousandth of a radian. It is learnt from the
//! factors that were.
//!
//! What was factorised is part of the state, so that a run that resumes goes on with the same factor.

use super::Joints;
use crate::cpu::masses::Masses;
use crate::cpu::solve::response::Response;
use crate::joint_factor::{Factorised, JointFactor};
use std::sync::Arc;

/// Multiplications of a factorisation over the numbers of the factor above which it costs more than [`MOST`] solves.
const WORTH: u64 = 20;
/// The most solves of a step with an earlier step's factor.
const MOST: usize = 8;
/// What may be left of rates, over what was left to the first solve.
const LEFT: f64 = 1e-10;
/// What a solve leaves of what there was, above which the factor is too old.
const SLOW: f64 = 0.5;
/// How far bodies may turn with a factor at most, rad.
const FARTHEST: f64 = 0.1;
/// By how much that grows in a step: where bodies turn faster, a factor is tried in vain once in a hundred steps.
const GROWTH: f64 = 1.007;

impl Joints {
    /// [`Joints::prepare`] of a step in which joints act alone: from what an earlier step has factorised, while that lasts. Solves are then to be
    /// finished ([`Joints::finish`]).
    pub fn prepare_from(&mut self, masses: &Masses, last: JointFactor) {
        let JointFactor { of, turned, turn, reach } = last;
        self.lasting = JointFactor { of: None, turned: 0.0, turn, reach: (reach * GROWTH).min(FARTHEST) };
        if self.rows.is_empty() {
            return self.prepare(masses);
        }
        self.analyse_what_is_new(masses);
        let is_large = self.factor.work() >= WORTH * self.factor.n_numbers() as u64;
        let lasts = is_large && self.n_bounds() == 0 && !self.is_stiff && !self.is_light;
        let is_own = |of: &Arc<Factorised>| self.of.as_ref().is_some_and(|own| Arc::ptr_eq(own, of));
        let is_near = lasts && turned <= reach;
        let Some(of) = of.filter(|of| is_near && (is_own(of) || of.is_of(&self.rows, masses))) else {
            if lasts && turn <= reach {
                return self.renew(masses);
            }
            (self.of, self.is_old) = (None, false);
            return self.factorise_with_bounds(masses);
        };
        if !is_own(&of) {
            let rows = std::mem::replace(&mut self.rows, of.rows.clone());
            self.is_factorised = false;
            self.factorise(&of.masses);
            self.rows = rows;
            self.of = Some(of);
        }
        self.find_softness(masses);
        (self.is_old, self.n_solves, self.lasting.turned) = (true, 0, turned);
    }

    /// Factorise the rows of the step for it and those after it.
    fn renew(&mut self, masses: &Masses) {
        self.factorise(masses);
        self.of = Some(Arc::new(Factorised { rows: self.rows.clone(), masses: masses.clone() }));
        (self.is_old, self.lasting.turned) = (false, 0.0);
    }

    /// The factorisation for the next step, after one in which bodies turn by `turn`, rad.
    pub fn lasting(&self, turn: f64) -> JointFactor {
        let JointFactor { turned, reach, .. } = self.lasting;
        JointFactor { of: self.of.clone(), turned: turned + turn, turn, reach }
    }

    /// Whether the factor is that of an earlier step.
    pub fn is_old(&self) -> bool {
        self.is_old
    }

    /// Replace the factor of an earlier step, if it is that, where a solve has left `left` of `before`, or where there were many solves. Returns
    /// whether it is replaced.
    pub fn renew_if_slow(&mut self, masses: &Masses, left: f64, before: f64) -> bool {
        let is_slow = self.is_old && (self.n_solves >= MOST || !(left <= SLOW * before));
        if is_slow {
            self.lasting.reach = self.lasting.turned / 2.0;
            self.renew(masses);
        }
        is_slow
    }

    /// Solve what the factor of an earlier step has left; nothing after other solves.
    pub fn finish(&mut self, masses: &Masses, response: &mut Response) {
        let mut before = self.first_left;
        while self.is_old {
            let left = self.residual_with(response, 1.0);
            if left <= LEFT * self.first_left {
                return;
            }
            self.renew_if_slow(masses, left, before);
            self.solve(masses, response);
            before = left;
        }
    }
}
