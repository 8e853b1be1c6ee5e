//! The stages of a step on the processor, and steps that are taken in parts where their joints bend too much ([`crate::pace`]).

use crate::backend::Backend;
use crate::contacts::Contacts;
use crate::cpu::Cpu;
use crate::joint_factor::JointFactor;
use crate::manifolds::Manifolds;
use crate::model::Model;
use crate::outcome::StepOutcome;
use crate::pace::{Coarse, IN_PART, IN_STEP, MOST};
use crate::plan::{StepPlan, has_joints};
use crate::sleep;
use crate::stages::{Stage, check};
use crate::state::State;
use std::time::Instant;

/// Wall time of each stage, ms.
pub type StageTimes = [f64; Stage::ALL.len()];

/// Take a step, in parts where its joints need them. Returns the wall times and the outcome of all parts.
pub fn step(
    cpu: &mut Cpu,
    (model, plan): (&mut Model, &StepPlan),
    state: &mut State,
    is_checked: bool,
) -> Result<(StageTimes, StepOutcome), String> {
    let (h, start, steps) = (model.step, state.time, state.steps);
    let (mut stage_ms, mut outcome) = (StageTimes::default(), StepOutcome::default());
    // In parts of the least length.
    let (mut taken, mut length) = (0, MOST / state.pace.parts());
    state.contacts.scale(f64::from(length) / f64::from(MOST));
    while taken < MOST {
        model.part = f64::from(length) / f64::from(MOST);
        model.step = h * model.part;
        let coarse = match length {
            _ if !has_joints(model) => None,
            MOST => Some(IN_STEP),
            2.. => Some(IN_PART),
            _ => None,
        };
        let ran = run_stages(cpu, &Stage::ALL, (model, plan), state, (is_checked, coarse));
        (model.step, model.part) = (h, 1.0);
        match ran? {
            Ran::Whole(times) => {
                taken += length;
                (state.time, state.steps) = (start + h * f64::from(taken) / f64::from(MOST), steps);
                stage_ms.iter_mut().zip(times).for_each(|(sum, ms)| *sum += ms);
                outcome = outcome.and(cpu.outcome());
            }
            // The plan is the same whether bodies sleep or move.
            Ran::Woken => cpu.prepare(model, state, plan),
            Ran::TooLong => {
                let shorter = length / cpu.outcome().bend.parts().min(length);
                state.contacts.scale(f64::from(shorter) / f64::from(length));
                length = shorter;
                // Manifolds have the order of pairs that may be gone.
                state.fat_aabb = None;
            }
        }
    }
    // Forces are impulses over the step.
    state.contacts.scale(f64::from(MOST / length));
    state.steps = steps + 1;
    state.time = state.steps as f64 * h;
    let parts = MOST / length;
    state.pace = state.pace.after(parts, outcome.bend);
    Ok((stage_ms, StepOutcome { parts, ..outcome }))
}

/// What the stages change of a state before the bodies move.
pub struct Kept {
    contacts: Contacts,
    manifolds: Manifolds,
    step_length: f64,
    joint_factor: JointFactor,
}

impl Kept {
    /// That of a state from which the step may begin again: one in which bodies sleep, or whose step `may_divide`.
    pub fn of(state: &State, may_divide: bool) -> Option<Kept> {
        let kept = || Kept {
            contacts: state.contacts.clone(),
            manifolds: state.manifolds.clone(),
            step_length: state.step_length,
            joint_factor: state.joint_factor.clone(),
        };
        (may_divide || !state.sleepers.are_none()).then(kept)
    }

    /// Begin the step again.
    pub fn restore(self, state: &mut State) {
        (state.contacts, state.manifolds) = (self.contacts, self.manifolds);
        (state.step_length, state.joint_factor) = (self.step_length, self.joint_factor);
    }
}

/// What has come of the stages of a step.
pub enum Ran {
    /// All have run; their wall times.
    Whole(StageTimes),
    /// A body has woken that the step will touch: it begins again.
    Woken,
    /// The step is too long for how its joints bend: it begins again, in parts.
    TooLong,
}

/// Run stages of a step; it begins again, in parts, where it is too long by `coarse`.
pub fn run_stages(
    backend: &mut dyn Backend,
    stages: &[Stage],
    (model, plan): (&Model, &StepPlan),
    state: &mut State,
    (is_checked, coarse): (bool, Option<Coarse>),
) -> Result<Ran, String> {
    let mut stage_ms = StageTimes::default();
    let mut last = Instant::now();
    let mut before = None;
    for stage in stages.iter().copied() {
        if stage == Stage::ContactWrite {
            before = Kept::of(state, coarse.is_some());
        }
        let has_run = backend.run(stage, model, plan, state);
        if matches!(stage, Stage::ContactWrite | Stage::ContactSolve) && before.is_some() {
            let is_solved = stage == Stage::ContactSolve;
            let touched = if state.sleepers.are_none() { vec![] } else { sleep::touched(model, state, is_solved) };
            let is_long = is_solved && coarse.is_some_and(|coarse| coarse.is_too_long(&backend.outcome().bend));
            if let Some(before) = before.take_if(|_| is_long || !touched.is_empty()) {
                before.restore(state);
                if touched.is_empty() {
                    return Ok(Ran::TooLong);
                }
                sleep::rouse(state, touched);
                return Ok(Ran::Woken);
            }
        }
        let now = Instant::now();
        if has_run {
            stage_ms[stage as usize] = (now - last).as_secs_f64() * 1e3;
            if is_checked {
                check(stage, model, plan, state, |column| backend.column(state, column))?;
            }
        }
        last = Instant::now();
    }
    Ok(Ran::Whole(stage_ms))
}
