//! The way back: the columns of a state from those on the device.

use super::probing::Probing;
use super::{Fault, Gpu};
use crate::contacts::{Arms, Contacts, NO_PAIR};
use crate::manifolds::Manifolds;
use crate::model::Model;
use crate::model_file::Probes;
use crate::plan::Narrow;
use crate::probe::Sums;
use crate::stages::Stage;
use crate::state::State;
use glam::DVec3;

impl Gpu {
    /// Bring a state up to date: its columns are those on the device.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn fetch(&mut self, model: &Model, state: &mut State) -> Result<(), Fault> {
        self.fetch_bodies(state)?;
        if !self.is_stale {
            return Ok(());
        }
        self.survey.fetch(&self.device, state)?;
        let from = self.before.from;
        if from == Stage::Bounds {
            state.fat_aabb = Some(self.collision.fetch_boxes(&self.device, model)?);
        }
        if from < Stage::Integrate {
            state.step_length = self.solve.step_length(&self.device)?;
        }
        if self.before.finds() {
            state.contacts = self.contacts(self.n_contacts)?;
            // Contact points are found again in each step here.
            state.manifolds = Manifolds::default();
        } else if from < Stage::Integrate {
            self.fetch_impulses(state)?;
        }
        self.is_stale = false;
        Ok(())
    }

    /// Bring the poses and velocities of a state up to date.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn fetch_bodies(&mut self, state: &mut State) -> Result<(), Fault> {
        if !self.has_old_bodies {
            return Ok(());
        }
        let fetch = |state: &mut State| self.collision.bodies.fetch(&self.device, state);
        match &self.mechanism {
            Some(mechanism) => mechanism.keep(state, fetch)?,
            None => fetch(state)?,
        }
        self.has_old_bodies = false;
        Ok(())
    }

    /// Measure what a line of the probes has at the end of a step, and bring the probed bodies up to date in the state. None where the state is up to
    /// date, or has sleeping bodies, whose contacts are not on the device.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn probe(&mut self, model: &Model, state: &mut State, probes: &Probes) -> Result<Option<Sums>, Fault> {
        if !self.has_old_bodies || self.before.from != Stage::Bounds || !state.sleepers.are_none() {
            return Ok(None);
        }
        let (device, problem, bodies) = (&self.device, &self.solve.problem, &self.collision.bodies);
        let mut probing = match self.probing.take().filter(|own| own.is_of(probes)) {
            Some(own) => own,
            None => Probing::new(device, &self.kernels, (model, probes), problem)?,
        };
        let measured = probing.measure(device, problem, bodies)?;
        self.probing = Some(probing);
        let put = |state: &mut State| measured.states.iter().for_each(|row| bodies.put(state, row));
        match &self.mechanism {
            Some(mechanism) => mechanism.keep(state, put),
            None => put(state),
        }
        let [kinetic, potential, deepest] = self.measured;
        let force = |(n, impulse): &(usize, DVec3)| (*n, *impulse / model.step);
        let between = measured.between.iter().map(force).collect();
        Ok(Some(Sums { whole: [kinetic, potential, deepest, measured.mean_slip], between }))
    }

    /// The first `n` contacts of the device, with their impulses.
    pub fn contacts(&self, n: usize) -> Result<Contacts, Fault> {
        let rows = self.solve.problem.contact.read(&self.device, n)?;
        let impulses = self.solve.problem.gamma.read(&self.device, n)?;
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let arms = match self.solve.problem.layout.narrow {
            Narrow::Spheres => Arms::Along(rows.iter().map(|c| c.reach.map(f64::from)).collect()),
            Narrow::Any => {
                let arms = self.solve.problem.arms.read(&self.device, n)?;
                Arms::Any(arms.iter().map(|arm| [arm.a, arm.b].map(vector)).collect())
            }
        };
        let rolling = match self.solve.problem.layout.rolls {
            true => self.solve.problem.roll.read(&self.device, n)?,
            false => vec![],
        };
        Ok(Contacts {
            bodies: rows.iter().map(|c| c.bodies).collect(),
            key: rows.iter().map(|c| [c.shapes[0], c.shapes[1], c.feature]).collect(),
            pair: vec![NO_PAIR; n],
            normal: rows.iter().map(|c| vector(c.normal).normalize()).collect(),
            arms,
            gap: rows.iter().map(|c| c.gap as f64).collect(),
            law: rows.iter().map(|c| c.law).collect(),
            impulse: impulses.iter().map(|z| vector([z[0], z[1], z[2]])).collect(),
            rolling_impulse: rolling.iter().map(|z| vector([z[0], z[1], z[2]])).collect(),
            ..Contacts::default()
        })
    }
}
