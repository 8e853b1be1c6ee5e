//! What a line of the probes asks of the device: sums over the contacts, and the states of the bodies that are probed, in the place of all columns.
//! in   row, gamma, motion                     of the step's contacts
//! in   position, orientation, velocity, spin  of the bodies
//! out  sums    [1 + n_pairs]  slip speeds, m/s, and the number of contacts with an impulse; of each pair of classes the force over h, N s, and their
//!                             number
//! out  states  [n_probed]
//! Kernels: probe_contacts.wgsl, probe_total.wgsl, probe_bodies.wgsl. Twin: probe.rs

use super::bodies::Bodies;
use super::parts::{groups, kernel, kernel_of};
use super::problem::Problem;
use super::rows::BodyState;
use super::{Fault, Gpu};
use crate::model::Model;
use crate::model_file::Probes;
use crate::probe::Sums;
use crate::stages::Stage;
use crate::state::State;
use glam::DVec3;
use gpu::{Buffer, Commands, Device, GpuError, Kernel, Kernels, Work};

/// The columns and kernels of the probes of a run, and their commands.
pub struct Probing {
    /// Ids of the bodies, and pairs of classes.
    bodies: Vec<u32>,
    pairs: Vec<[u32; 2]>,
    body: Buffer<u32>,
    states: Buffer<BodyState>,
    class: Buffer<u32>,
    sums: Buffer<[f32; 4]>,
    of_bodies: Kernel,
    of_contacts: Kernel,
    total: Kernel,
    /// The commands for the columns that the solver has now.
    commands: Option<Commands>,
}

impl Probing {
    fn new(
        device: &Device,
        kernels: &Kernels,
        (model, probes): (&Model, &Probes),
        problem: &Problem,
    ) -> Result<Probing, GpuError> {
        let pairs: Vec<[u32; 2]> = probes.contacts.iter().map(|(_, pair)| *pair).collect();
        let ids = if probes.bodies.is_empty() { &[0][..] } else { &probes.bodies };
        let text = include_str!("probe_contacts.wgsl");
        Ok(Probing {
            body: Buffer::of(device, "probed bodies", ids)?,
            states: Buffer::zeros(device, "states of probed bodies", ids.len())?,
            class: Buffer::of(device, "classes", if pairs.is_empty() { &[0] } else { &model.class })?,
            sums: Buffer::zeros(device, "sums of probes", 1 + pairs.len())?,
            of_bodies: kernel(device, kernels, "probe_bodies", include_str!("probe_bodies.wgsl"))?,
            of_contacts: kernel_of(problem.layout, device, kernels, ("probe_contacts", text))?,
            total: kernel(device, kernels, "probe_total", include_str!("probe_total.wgsl"))?,
            bodies: probes.bodies.clone(),
            pairs,
            commands: None,
        })
    }

    /// Whether these are the quantities of probes.
    fn is_of(&self, probes: &Probes) -> bool {
        self.bodies == probes.bodies && self.pairs.iter().eq(probes.contacts.iter().map(|(_, pair)| pair))
    }

    /// Forget the commands, which are for columns that are no more.
    pub fn forget(&mut self) {
        self.commands = None;
    }

    fn record(&self, device: &Device, problem: &Problem, at: &Bodies) -> Commands {
        let mut commands = Commands::new();
        commands.stage(Stage::Integrate.name());
        let n = problem.n_contacts.n.bind();
        let rows = [problem.row(), problem.motion.bind(), problem.gamma.bind(), self.class.bind()];
        let bound: Vec<gpu::Bound> = rows.into_iter().chain([n, problem.of_contacts.bind()]).collect();
        let slip = [0; 3];
        let between = self.pairs.iter().map(|[a, b]| [1, *a, *b]);
        for (place, params) in [slip].into_iter().chain(between).enumerate() {
            commands.dispatch(device, &self.of_contacts, &bound, &params, problem.contacts());
            let of_total = [problem.of_contacts.bind(), n, self.sums.bind()];
            commands.dispatch(device, &self.total, &of_total, &[place as u32], Work::Groups(1));
        }
        if !self.bodies.is_empty() {
            let state = [at.position.bind(), at.orientation.bind(), at.velocity.bind(), at.spin.bind()];
            let bound: Vec<gpu::Bound> =
                [self.body.bind()].into_iter().chain(state).chain([self.states.bind()]).collect();
            commands.dispatch(device, &self.of_bodies, &bound, &[], groups(self.bodies.len()));
        }
        commands
    }
}

impl Gpu {
    /// Measure what a line of the probes has at the end of a step, and bring the probed bodies up to date in the state. None where the state is up to
    /// date, or has sleeping bodies, whose contacts are not on the device.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn probe(&mut self, model: &Model, state: &mut State, probes: &Probes) -> Result<Option<Sums>, Fault> {
        if !self.has_old_bodies || self.before.from != Stage::Bounds || !state.sleepers.are_none() {
            return Ok(None);
        }
        let (device, problem) = (&self.device, &self.solve.problem);
        let mut own = match self.probing.take().filter(|own| own.is_of(probes)) {
            Some(own) => own,
            None => Probing::new(device, &self.kernels, (model, probes), problem)?,
        };
        let at = &self.collision.bodies;
        let commands = own.commands.take().unwrap_or_else(|| own.record(device, problem, at));
        commands.submit(device)?;
        own.commands = Some(commands);
        let sums = own.sums.read_back(device, 1 + own.pairs.len())?;
        if !own.bodies.is_empty() {
            let states = own.states.read_back(device, own.bodies.len())?.wait(device)?;
            let put = |state: &mut State| states.iter().for_each(|row| at.put(state, row));
            match &self.mechanism {
                Some(mechanism) => mechanism.keep(state, put),
                None => put(state),
            }
        }
        let sums = sums.wait(device)?;
        let wide = |row: &[f32; 4]| row.map(f64::from);
        let [slip, _, _, n] = wide(&sums[0]);
        let force = |row: &[f32; 4]| {
            let [x, y, z, n] = wide(row);
            (n as usize, DVec3::new(x, y, z) / model.step)
        };
        let between = sums[1..].iter().map(force).collect();
        let [kinetic, potential, deepest] = self.measured;
        let whole = [kinetic, potential, deepest, if n > 0.0 { slip / n } else { 0.0 }];
        self.probing = Some(own);
        Ok(Some(Sums { whole, between }))
    }
}
