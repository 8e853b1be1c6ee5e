//! What a device takes from the plan of a step.

use crate::plan::{ContactMethod, Narrow, StepPlan};
use crate::settings::Method;

/// The method of a plan.
pub fn method_of(plan: &StepPlan) -> Method {
    match plan.method {
        ContactMethod::Sweeps => Method::GaussSeidel,
        ContactMethod::Blocks(method) => method,
    }
}

/// [`StepPlan::takeover`] on a device: of contacts with friction alone.
pub fn takeover(plan: &StepPlan) -> Option<f64> {
    plan.takeover.filter(|_| !plan.resists())
}

/// Whether the pairs of a plan have to be in tiles.
pub fn needs_tiles(plan: &StepPlan) -> bool {
    method_of(plan) == Method::GaussSeidel || takeover(plan).is_some()
}

/// In one of how many steps overlaps are recovered, as on the CPU.
pub fn recovery_period(plan: &StepPlan) -> u64 {
    if plan.method == ContactMethod::Sweeps && plan.narrow == Narrow::Spheres { 4 } else { 1 }
}
