//! What a line of the probes asks of the device: sums over the contacts, and the states of the bodies that are probed, in the place of all columns.
//! in   row, gamma, motion                     of the step's contacts
//! in   position, orientation, velocity, spin  of the bodies
//! out  sums    [1 + n_pairs]  slip speeds, m/s, and the number of contacts with an impulse, if there are energies; of each pair of classes the impulse,
//!                             N s, and their number
//! out  states  [n_probed]
//! Kernels: probe_contacts.wgsl, probe_total.wgsl, probe_bodies.wgsl. Twin: probe.rs

use super::bodies::Bodies;
use super::parts::{groups, kernel, kernel_of};
use super::problem::Problem;
use super::rows::BodyState;
use crate::model::Model;
use crate::model_file::Probes;
use crate::stages::Stage;
use glam::DVec3;
use gpu::{Buffer, Commands, Device, GpuError, Kernel, Kernels, ReadBack, Work};

/// The columns and kernels of the probes of a run, and their commands.
pub struct Probing {
    /// Ids of the bodies, pairs of classes, and whether there are energies.
    bodies: Vec<u32>,
    pairs: Vec<[u32; 2]>,
    energies: bool,
    body: Buffer<u32>,
    states: Buffer<BodyState>,
    class: Buffer<u32>,
    sums: Buffer<[f32; 4]>,
    of_bodies: Kernel,
    of_contacts: Kernel,
    total: Kernel,
    /// The commands for the columns that the solver has now.
    commands: Option<Commands>,
    /// Whether the last step was probed, so that the next one is likely to be.
    is_likely: bool,
    /// What is on its way back of the last step, if it was expected to be probed.
    begun: Option<Begun>,
}

/// Sums and states on their way back.
struct Begun {
    sums: ReadBack<[f32; 4]>,
    states: Option<ReadBack<BodyState>>,
}

/// What has been measured.
pub struct Measured {
    /// States of the probed bodies.
    pub states: Vec<BodyState>,
    /// Mean slip speed of the contacts with an impulse, m/s.
    pub mean_slip: f64,
    /// Of each pair of classes, the number of contacts with an impulse and their impulse on the second class, N s.
    pub between: Vec<(usize, DVec3)>,
}

impl Probing {
    /// For the probes of a run.
    pub fn new(
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
            energies: probes.energies,
            commands: None,
            is_likely: false,
            begun: None,
        })
    }

    /// Whether these are the quantities of probes.
    pub fn is_of(&self, probes: &Probes) -> bool {
        (&self.bodies, self.energies) == (&probes.bodies, probes.energies)
            && self.pairs.iter().eq(probes.contacts.iter().map(|(_, pair)| pair))
    }

    /// Forget the commands, which are for columns that are no more.
    pub fn forget(&mut self) {
        (self.commands, self.begun) = (None, None);
    }

    /// Begin to measure behind the commands of a step, if it is likely to be probed: what is measured comes back with its summary.
    ///
    /// # Errors
    /// Those of [`Commands::submit`] and [`Buffer::read_back`].
    pub fn follow(&mut self, device: &Device, problem: &Problem, at: &Bodies) -> Result<(), GpuError> {
        self.begun = None;
        if std::mem::take(&mut self.is_likely) {
            self.begun = Some(self.begin(device, problem, at)?);
        }
        Ok(())
    }

    fn begin(&mut self, device: &Device, problem: &Problem, at: &Bodies) -> Result<Begun, GpuError> {
        let commands = self.commands.take().unwrap_or_else(|| self.record(device, problem, at));
        commands.submit(device)?;
        self.commands = Some(commands);
        let n = self.bodies.len();
        Ok(Begun {
            sums: self.sums.read_back(device, 1 + self.pairs.len())?,
            states: if n > 0 { Some(self.states.read_back(device, n)?) } else { None },
        })
    }

    fn record(&self, device: &Device, problem: &Problem, at: &Bodies) -> Commands {
        let mut commands = Commands::new();
        commands.stage(Stage::Integrate.name());
        let n = problem.n_contacts.n.bind();
        let rows = [problem.row(), problem.motion.bind(), problem.gamma.bind(), self.class.bind()];
        let bound: Vec<gpu::Bound> = rows.into_iter().chain([n, problem.of_contacts.bind()]).collect();
        let slip = self.energies.then_some((0, [0; 3]));
        let between = self.pairs.iter().enumerate().map(|(i, [a, b])| (1 + i, [1, *a, *b]));
        for (place, params) in slip.into_iter().chain(between) {
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

    /// Measure at the end of a step.
    ///
    /// # Errors
    /// Those of [`Commands::submit`] and [`Buffer::read_back`].
    pub fn measure(&mut self, device: &Device, problem: &Problem, at: &Bodies) -> Result<Measured, GpuError> {
        let begun = match self.begun.take() {
            Some(begun) => begun,
            None => self.begin(device, problem, at)?,
        };
        self.is_likely = true;
        let sums = begun.sums.wait(device)?;
        let states = begun.states.map_or(Ok(vec![]), |states| states.wait(device))?;
        let [slip, _, _, n] = sums[0].map(f64::from);
        let force = |row: &[f32; 4]| {
            let [x, y, z, n] = row.map(f64::from);
            (n as usize, DVec3::new(x, y, z))
        };
        Ok(Measured {
            states,
            mean_slip: if n > 0.0 { slip / n } else { 0.0 },
            between: sums[1..].iter().map(force).collect(),
        })
    }
}
