//! The recording of a step: the stages up to its contacts, and what follows by the method of the plan, or by Gauss–Seidel where that may
//! take over.

use super::plan::recovery_period;
use super::probing::Probing;
use super::recorded::{Recorded, Solving};
use super::{Fault, Gpu, force, integrate};
use crate::model::Model;
use crate::plan::StepPlan;
use crate::stages::Stage;
use gpu::Commands;

impl Gpu {
    /// Record a step.
    pub(super) fn record(&mut self, model: &Model, plan: &StepPlan) -> Result<(), Fault> {
        self.record_by(model, plan, recovery_period(plan))
    }

    /// Record a step, of which one in `period` recovers overlaps.
    pub(super) fn record_by(&mut self, model: &Model, plan: &StepPlan, period: u64) -> Result<(), Fault> {
        let find = self.record_find(model, plan, false);
        let held = if self.before.from == Stage::Bounds { Some(self.record_find(model, plan, true)) } else { None };
        let own = self.record_solving(model, period, false)?;
        let landing = if self.solve.may_land() { Some(self.record_solving(model, period, true)?) } else { None };
        // A step is recorded again where there may be other pairs.
        self.holding.forget();
        self.probing.iter_mut().for_each(Probing::forget);
        self.recorded = Recorded { find, held, ahead: None, own, landing, period };
        Ok(())
    }

    /// Record the stages up to the contacts with their starting point, for pairs that hold or any.
    fn record_find(&self, model: &Model, plan: &StepPlan, hold: bool) -> Commands {
        let Gpu { device, collision, warm_start, solve, .. } = self;
        let mut find = Commands::new();
        if let Some(mechanism) = &self.mechanism {
            find.stage(Stage::JointWrite.name());
            mechanism.record_pose(device, &mut find, &collision.bodies);
        }
        let from = self.before.from;
        match hold {
            true => collision.record_held(device, &mut find, model, self.knows_next()),
            false => collision.record_from(device, &mut find, model, from),
        }
        let starts_here = from <= Stage::WarmStart;
        if starts_here {
            find.stage(Stage::WarmStart.name());
            match plan.warm_starts {
                true => warm_start.record(device, &mut find, collision.columns(), solve.problem.impulses()),
                false => solve.problem.impulses().into_iter().for_each(|column| find.clear(column)),
            }
        }
        if plan.start().is_some() {
            if !starts_here {
                find.stage(Stage::ContactSolve.name());
            }
            self.rest.record(device, &mut find, &solve.problem);
        }
        find
    }

    /// Record a step from its contacts on, by the method or by what takes over from it.
    fn record_solving(&self, model: &Model, period: u64, is_landing: bool) -> Result<Solving, Fault> {
        let Gpu { device, kernels, collision, solve, .. } = self;
        let mut start = Commands::new();
        if self.before.from <= Stage::Force {
            start.stage(Stage::Force.name());
            force::record(device, kernels, &mut start, model, (&collision.bodies, &solve.problem.free))?;
            if let Some(impacts) = &self.impacts {
                impacts.record(device, &mut start, &solve.problem);
            }
        }
        if let Some(mechanism) = &self.mechanism {
            start.stage(Stage::JointWrite.name());
            solve.problem.record_inertia(&mut start, &collision.bodies);
            mechanism.record_free(device, &mut start, &solve.problem);
        }
        solve.record_start(device, kernels, &mut start, (model, collision, is_landing))?;
        let mut measure = Commands::new();
        if let Some(mechanism) = &self.mechanism {
            solve.record_end(device, &mut measure, is_landing);
            measure.stage(Stage::JointWrite.name());
            mechanism.record_effect(device, &mut measure, (&solve.problem, &self.overlaps));
        }
        let end = |recovery| self.record_end(model, recovery, is_landing);
        let (end, recovery) = (end(None)?, end(Some(period))?);
        Ok(Solving { start, solve: solve.record(device, kernels, is_landing)?, measure, end, recovery })
    }

    /// Record the end of a step, with the recovery of overlaps for a number of steps, if any.
    fn record_end(&self, model: &Model, recovery: Option<u64>, is_landing: bool) -> Result<Commands, Fault> {
        let Gpu { device, kernels, collision, warm_start, solve, overlaps, survey, .. } = self;
        let (problem, room) = (&solve.problem, collision.room());
        let mut commands = Commands::new();
        let (c, from) = (&mut commands, self.before.from);
        let solves = from < Stage::Integrate;
        if solves {
            solve.record_end(device, c, is_landing);
            match recovery {
                Some(period) => overlaps.record(device, kernels, c, model, (problem, period))?,
                None => overlaps.record_none(c),
            }
        }
        c.stage(Stage::Integrate.name());
        if let Some(mechanism) = self.mechanism.as_ref().filter(|_| solves) {
            mechanism.record_effect(device, c, (problem, overlaps));
        }
        let bodies = &collision.bodies;
        integrate::record(device, kernels, c, (model, bodies), (problem, overlaps, room))?;
        if from <= Stage::WarmStart {
            warm_start.record_keep(device, c, collision.columns(), (problem.impulses(), room));
        }
        if self.knows_next() {
            collision.record_next(device, c, model);
        }
        let rounds = collision.tiles().map(|tiles| &tiles.round_start);
        survey.record(device, kernels, c, (model, bodies), (problem, room, collision.lasts()), rounds)?;
        Ok(commands)
    }
}
