//! The interface of a back end: the stages of a step, over columns of its own.

use crate::model::Model;
use crate::outcome::StepOutcome;
use crate::plan::StepPlan;
use crate::stages::{Column, Stage, View};
use crate::state::State;

/// A back end, which runs whole stages. It may divide the work of a stage as it likes; the columns that it writes are those of
/// [`COLUMNS`](crate::stages::COLUMNS).
pub trait Backend: Send {
    /// Name of the back end, as in `run.json`.
    fn name(&self) -> &'static str;

    /// Adopt a plan: before the first step, and whenever other bodies move or the settings have changed.
    fn prepare(&mut self, model: &Model, state: &State, plan: &StepPlan);

    /// Run a stage. Returns false for a stage of the broad phase that was skipped because the pairs of an earlier step are still valid.
    fn run(&mut self, stage: Stage, model: &Model, plan: &StepPlan, state: &mut State) -> bool;

    /// Outcome of the step's stages.
    fn outcome(&self) -> StepOutcome;

    /// View of a column, after a stage that writes it.
    fn column<'a>(&'a self, state: &'a State, column: Column) -> View<'a>;
}
