//! The interface of a back end: the stages of a step, over columns of its own.

use crate::model::Model;
use crate::outcome::StepOutcome;
use crate::plan::StepPlan;
use crate::stages::{Column, Stage, View};
use crate::state::State;

/// A back end, which runs whole stages over columns of its own and of the state. The columns that it writes are those of
/// [`COLUMNS`](crate::stages::COLUMNS); the division of a stage's work into tasks is its own.
pub trait Backend: Send {
    /// Name of the back end, as in `run.json`.
    fn name(&self) -> &'static str;

    /// Adopt a plan: called before the first step, and whenever the activity of a body or the solver settings have changed.
    fn prepare(&mut self, model: &Model, state: &State, plan: &StepPlan);

    /// Run a stage. Returns false for a stage of the broad phase that was skipped because the pairs of an earlier step are still valid.
    fn run(&mut self, stage: Stage, model: &Model, plan: &StepPlan, state: &mut State) -> bool;

    /// Outcome of the last step, once all its stages have run.
    fn outcome(&self) -> StepOutcome;

    /// View of a column for [`check`](crate::stages::check), after a stage that writes it.
    fn column<'a>(&'a self, state: &'a State, column: Column) -> View<'a>;
}
