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
use crate::joint::Row;
use std::sync::Arc;

/// Multiplications of a factorisation over the numbers of the factor above which it costs more than [`MOST`] solves.
const WORTH: u64 = 20;
/// The most solves of a step with an earlier step's factor.
const MOST: usize = 8;
/// What may be left of rates, over what was left to the first solve.
const LEFT: f64 = 1e-10;
/// What a solve leaves of what there was, above which the factor is too old.
const SLOW: f64 = 0.5;
/// How far bodies may turn with a factor: before any has become too old, and at most, rad.
const REACH: f64 = 1e-3;
const FARTHEST: f64 = 0.1;
/// By how much that grows in a step: where bodies turn faster, a factor is tried in vain once in a hundred steps.
const GROWTH: f64 = 1.007;

/// The rows of a step's joints, and the masses they act on: what a factorisation is of.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Factorised {
    rows: Vec<Row>,
    masses: Masses,
}

/// A factorisation for the steps to come.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct JointFactor {
    /// What it is of; none where the next step is to have one of its own.
    of: Option<Arc<Factorised>>,
    /// How far bodies on joints have turned since, in the last step, and may turn until it is too old, rad.
    turned: f64,
    turn: f64,
    reach: f64,
}

impl Default for JointFactor {
    fn default() -> JointFactor {
        JointFactor { of: None, turned: 0.0, turn: 0.0, reach: REACH }
    }
}

impl Factorised {
    /// Whether it is of the same system as rows and masses are now, but for the poses of the bodies.
    fn is_of(&self, rows: &[Row], masses: &Masses) -> bool {
        let same_bodies = || self.rows.iter().zip(rows).all(|(a, b)| a.bodies == b.bodies);
        self.rows.len() == rows.len() && self.masses.inv_mass == masses.inv_mass && same_bodies()
    }
}

impl JointFactor {
    /// Whether there is a factorisation.
    pub fn is_there(&self) -> bool {
        self.of.is_some()
    }

    /// Whether it is the same as another: no step between has factorised.
    pub fn is_same(&self, other: &JointFactor) -> bool {
        matches!([&self.of, &other.of], [Some(a), Some(b)] if Arc::ptr_eq(a, b))
    }

    /// Have none: the next step factorises.
    pub fn end(&mut self) {
        self.of = None;
    }

    /// Check that it may be that of a model, as a file gives it.
    ///
    /// # Errors
    /// What does not fit, for a message.
    pub fn fit(&self, n_bodies: usize) -> Result<(), String> {
        let is_row = |row: &Row| {
            let vectors = [row.linear, row.angular_a, row.angular_b];
            let are_bodies = row.bodies.iter().all(|b| (*b as usize) < n_bodies);
            are_bodies && vectors.iter().all(|v| v.is_finite()) && row.softness >= 0.0
        };
        let is_sound = |of: &Arc<Factorised>| of.rows.iter().all(is_row) && of.masses.are_of(n_bodies);
        let are_numbers = [self.turned, self.turn, self.reach].iter().all(|x| *x >= 0.0);
        match are_numbers && self.of.as_ref().is_none_or(is_sound) {
            true => Ok(()),
            false => Err("has a factorisation of joints that there cannot be".into()),
        }
    }
}

impl Joints {
    /// [`Joints::prepare`] of a step in which joints act alone: from what an earlier step has factorised, while that lasts. Solves are then to be
    /// finished ([`Joints::finish`]).
    pub fn prepare_from(&mut self, masses: &Masses, last: JointFactor) {
        if !self.rows.is_empty() {
            self.analyse_what_is_new(masses);
        }
        let is_large = self.factor.work() >= WORTH * self.factor.n_numbers() as u64;
        let lasts = !self.rows.is_empty() && is_large && self.motors.is_empty() && !self.is_stiff && !self.is_light;
        let is_near = lasts && last.turned <= last.reach;
        let is_own = |of: &Arc<Factorised>| self.of.as_ref().is_some_and(|own| Arc::ptr_eq(own, of));
        let of = last.of.clone().filter(|of| is_near && (is_own(of) || of.is_of(&self.rows, masses)));
        let is_slow = last.turn > last.reach;
        self.lasting = JointFactor { of: None, turned: 0.0, reach: (last.reach * GROWTH).min(FARTHEST), ..last };
        let Some(of) = of else {
            if lasts && !is_slow {
                self.renew(masses)
            } else {
                self.prepare(masses)
            }
            return;
        };
        if !is_own(&of) {
            let rows = std::mem::replace(&mut self.rows, of.rows.clone());
            self.is_factorised = false;
            self.factorise(&of.masses);
            self.rows = rows;
            self.of = Some(of);
        }
        self.find_softness(masses);
        (self.is_old, self.n_solves, self.lasting.turned) = (true, 0, last.turned);
    }

    /// Factorise the rows of the step for it and those after it.
    fn renew(&mut self, masses: &Masses) {
        self.factorise(masses);
        self.of = Some(Arc::new(Factorised { rows: self.rows.clone(), masses: masses.clone() }));
        (self.is_old, self.lasting.turned) = (false, 0.0);
    }

    /// The factorisation for the next step, after one in which bodies turn by `turn`, rad.
    pub fn lasting(&mut self, turn: f64) -> JointFactor {
        let is_worn = self.is_old && self.n_solves > MOST;
        if is_worn {
            self.lasting.reach = self.lasting.turned / 2.0;
        }
        let JointFactor { turned, reach, .. } = self.lasting;
        JointFactor { of: self.of.clone().filter(|_| !is_worn), turned: turned + turn, turn, reach }
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
            let left = self.left(response);
            if left <= LEFT * self.first_left {
                return;
            }
            self.renew_if_slow(masses, left, before);
            self.solve(masses, response);
            before = left;
        }
    }

    /// The greatest rate that is left, m/s or rad/s.
    fn left(&self, response: &Response) -> f64 {
        let of = |(k, row): (usize, &Row)| {
            row.speed_in(&response.twist) + self.bias[k] + self.softness[k] * response.lambda[k]
        };
        self.rows.iter().enumerate().map(of).fold(0.0, |most: f64, left| most.max(left.abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_of_another_model_does_not_fit() {
        let row = Row { bodies: [0, 2], linear: glam::DVec3::X, ..Row::default() };
        let of = |row: Row, masses: Masses| JointFactor {
            of: Some(Arc::new(Factorised { rows: vec![row], masses })),
            ..JointFactor::default()
        };
        let masses = |n: usize| {
            let mut masses = Masses::default();
            (masses.inv_mass, masses.inv_moment) = (vec![1.0; n], vec![1.0; n]);
            masses
        };
        assert!(JointFactor::default().fit(3).is_ok() && of(row, masses(3)).fit(3).is_ok());
        assert!(of(row, masses(2)).fit(2).is_err() && of(row, masses(2)).fit(3).is_err());
        assert!(of(Row { linear: row.linear * f64::NAN, ..row }, masses(3)).fit(3).is_err());
        assert!(JointFactor { reach: f64::NAN, ..JointFactor::default() }.fit(3).is_err());
    }
}
