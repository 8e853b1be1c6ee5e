//! A factorisation of the joints that lasts for many steps, as part of the state: what was factorised, from which the same factor is made again.
//! [`crate::cpu::solve::joints`] makes it and uses it.

use crate::cpu::masses::Masses;
use crate::joint::Row;
use std::sync::Arc;

/// How far bodies may turn with a factor before any has become too old, rad.
const REACH: f64 = 1e-3;

/// The rows of a step's joints, and the masses they act on: what a factorisation is of.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Factorised {
    /// The rows.
    pub rows: Vec<Row>,
    /// The masses.
    pub masses: Masses,
}

/// A factorisation for the steps to come.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct JointFactor {
    /// What it is of; none where the next step is to have one of its own.
    pub(crate) of: Option<Arc<Factorised>>,
    /// How far bodies on joints have turned since, in the last step, and may turn until it is too old, rad.
    pub(crate) turned: f64,
    pub(crate) turn: f64,
    pub(crate) reach: f64,
}

impl Default for JointFactor {
    fn default() -> JointFactor {
        JointFactor { of: None, turned: 0.0, turn: 0.0, reach: REACH }
    }
}

impl Factorised {
    /// Whether it is of the same system as rows and masses are now, but for the poses of the bodies.
    pub fn is_of(&self, rows: &[Row], masses: &Masses) -> bool {
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
