//! What comes back of every step: counts, residual and worst overlap for the report, and the energies and extremes for the watch.
//! in     mass, position, velocity, spin   of the bodies
//! inout  lowest    [n_bodies]  J/kg: least potential so far, over that of the level
//! out    summary   [1]
//! Kernels: survey.wgsl, survey_peaks.wgsl, summary.wgsl. Twin: watch.rs, Survey

use super::bodies::Bodies;
use super::fault::Fault;
use super::parts::{bits, groups, kernel};
use super::problem::Problem;
use super::rows::{Fixed, Summary};
use crate::model::Model;
use crate::state::State;
use crate::watch;
use glam::DVec3;
use gpu::{Buffer, Commands, Device, GpuError, Kernels, Work};

/// The columns.
pub struct Survey {
    /// Potential of the level, from which heights are measured, J/kg.
    potential: f64,
    /// A point of the level, fine units (1).
    level: Buffer<Fixed>,
    /// Least potential of each body so far, J/kg (n_bodies).
    lowest: Buffer<f32>,
    /// As bits: the greatest speed squared and kinetic energy (2).
    peaks: Buffer<u32>,
    /// The bodies that have them (2).
    body: Buffer<u32>,
    none: Buffer<u32>,
    no_rounds: Buffer<u32>,
    /// The summary of the last step (1).
    pub summary: Buffer<Summary>,
}

impl Survey {
    /// For the bodies of a state; the level is at the bottom of the box that the watch knows.
    pub fn new(device: &Device, model: &Model, state: &State, bodies: &Bodies) -> Result<Survey, Fault> {
        let potential = state.watch.lowest.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let potential = if potential.is_finite() { potential } else { 0.0 };
        let g = model.gravity;
        let point = if g == DVec3::ZERO { DVec3::ZERO } else { -g * (potential / g.length_squared()) };
        let point = bodies.scale.fix(point).ok_or(Fault::Position(0))?;
        // What positions in fixed point make of it.
        let potential = -g.dot(bodies.scale.unfix(point));
        let survey = Survey {
            potential,
            level: Buffer::of(device, "level", &[point])?,
            lowest: Buffer::zeros(device, "lowest", bodies.n)?,
            peaks: Buffer::zeros(device, "peaks", 2)?,
            body: Buffer::zeros(device, "peak bodies", 2)?,
            no_rounds: Buffer::zeros(device, "no rounds", 10)?,
            none: Buffer::of(device, "no bodies", &[u32::MAX; 2])?,
            summary: Buffer::zeros(device, "summary", 1)?,
        };
        let lowest: Vec<f32> = state.watch.lowest.iter().map(|l| (l - potential) as f32).collect();
        survey.lowest.write(device, &lowest);
        Ok(survey)
    }

    /// Record the survey after the integration; `room` says whether there was room for all pairs.
    pub fn record(
        &self,
        device: &Device,
        kernels: &Kernels,
        commands: &mut Commands,
        (model, bodies): (&Model, &Bodies),
        (problem, room, [lasts, next]): (&Problem, &Buffer<u32>, [&Buffer<u32>; 2]),
        round_start: Option<&Buffer<u32>>,
    ) -> Result<(), GpuError> {
        let get = |name, text| kernel(device, kernels, name, text);
        let [mass, velocity, spin] = [bodies.mass.bind(), bodies.velocity.bind(), bodies.spin.bind()];
        let (peaks, body, sums) = (self.peaks.bind(), self.body.bind(), problem.of_bodies.bind());
        commands.clear(&self.peaks);
        commands.copy(&self.none, &self.body, 2);
        let survey = get("survey", include_str!("survey.wgsl"))?;
        let from = [mass, bodies.position.bind(), velocity, spin, self.level.bind(), self.lowest.bind()];
        let bound: Vec<gpu::Bound> = from.into_iter().chain([sums, peaks, room.bind()]).collect();
        let g = model.gravity;
        let params = [g.x, g.y, g.z, model.step, bodies.scale.fine()].map(bits);
        commands.dispatch(device, &survey, &bound, &params, groups(bodies.n));
        let kernel = get("survey_peaks", include_str!("survey_peaks.wgsl"))?;
        commands.dispatch(device, &kernel, &[mass, velocity, spin, peaks, body], &[], groups(bodies.n));
        let kernel = get("summary", include_str!("summary.wgsl"))?;
        let solve = [problem.scalars.bind(), peaks, body, problem.worst.bind(), room.bind()];
        // Where there are no tiles, no round has any.
        let rounds = round_start.unwrap_or(&self.no_rounds);
        let rest = [problem.n_contacts.n.bind(), lasts.bind(), next.bind(), rounds.bind(), self.summary.bind()];
        let bound: Vec<gpu::Bound> = [sums].into_iter().chain(solve).chain(rest).collect();
        commands.dispatch(device, &kernel, &bound, &[bodies.n as u32], Work::Groups(1));
        Ok(())
    }

    /// What the watch asks of a summary; `mass` is that of the moving bodies, kg.
    pub fn of_watch(&self, summary: &Summary, mass: f64) -> watch::Survey {
        watch::Survey {
            kinetic: summary.kinetic as f64,
            potential: summary.potential as f64 + mass * self.potential,
            over_lowest: summary.over_lowest as f64,
            oscillation: summary.oscillation as f64,
            mass,
            fastest: (body(summary.fastest), summary.speed2 as f64),
            most_energetic: (body(summary.most_energetic), summary.greatest as f64),
        }
    }

    /// Read the least potentials back.
    pub fn fetch(&self, device: &Device, state: &mut State) -> Result<(), GpuError> {
        let lowest = self.lowest.read(device, state.watch.lowest.len())?;
        state.watch.lowest = lowest.into_iter().map(|l| self.potential + l as f64).collect();
        Ok(())
    }
}

/// A body of the summary; 0 where none moves.
fn body(found: u32) -> usize {
    if found == u32::MAX { 0 } else { found as usize }
}
