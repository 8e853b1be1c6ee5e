//! What a back end is: the stages of a step over columns of its own.

use crate::model::Model;
use crate::outcome::StepOutcome;
use crate::plan::StepPlan;
use crate::stages::{Column, Stage, View};
use crate::state::State;

/// A back end. It runs whole stages; how it orders the work within one is its own affair, but the columns that it writes are those
/// of [`crate::stages::COLUMNS`].
pub trait Backend: Send {
    /// The name, as `run.json` has it.
    fn name(&self) -> &'static str;

    /// Take up a plan: other bodies move, or the settings have changed.
    fn prepare(&mut self, model: &Model, state: &State, plan: &StepPlan);

    /// Run a stage; whether it had to: the pairs of the last step may still hold.
    fn run(&mut self, stage: Stage, model: &Model, plan: &StepPlan, state: &mut State) -> bool;

    /// What the stages of the step have come to.
    fn outcome(&self) -> StepOutcome;

    /// A column as it is after a stage that writes it.
    fn column<'a>(&'a self, state: &'a State, column: Column) -> View<'a>;
}
