//! The CPU back end: one file per stage, over the columns of the model and the state. [`crate::stages`] has their order.
//!
//! Every stage that runs in parallel splits its rows into chunks of fixed length, so that results have the same bits for any number
//! of threads.

mod arcs;
mod bin_emit;
mod bin_start;
pub mod bounds;
mod by_shape;
mod collide;
mod contact_rows;
mod contact_solve;
mod contact_write;
mod force;
mod geometric_stiffness;
pub(crate) mod given;
pub(crate) mod impacts;
mod integrate;
mod joint_write;
pub(crate) mod masses;
pub(crate) mod mechanism;
mod pair_write;
mod recycle;
pub(crate) mod solve;
mod sphere_pairs;
mod strikes;
mod warm_start;

use crate::aabb::Aabb;
use crate::backend::Backend;
use crate::joint::Row;
use crate::model::Model;
use crate::outcome::StepOutcome;
use crate::plan::StepPlan;
use crate::sphere::Sphere;
use crate::stages::{Column, Stage, View};
use crate::state::State;
use crate::twist::Twist;
use bin_emit::Bins;
use masses::Masses;
use pair_write::Pairs;
use solve::joints::Joints;
use solve::overlaps::Displacement;
use solve::response::Response;

/// The CPU back end, with the columns between its stages that are not in the state.
#[derive(Default)]
pub struct Cpu {
    masses: Masses,
    margin: Vec<f32>,
    tight_aabb: Vec<Aabb>,
    spheres: Vec<Sphere>,
    /// Whether `pairs` are those of the state's fat AABBs.
    has_pairs: bool,
    /// Whether `pairs` are valid in this step: every shape is still inside its fat AABB.
    pairs_hold: bool,
    bins: Bins,
    pairs: Pairs,
    touching: contact_write::Touching,
    /// Whether pairs have all contacts within their margins, as on a device.
    has_all_contacts: bool,
    last: warm_start::Last,
    free: Vec<Twist>,
    joint_start: Vec<u32>,
    joints: Joints,
    response: Response,
    displacement: Displacement,
    solver: contact_solve::Workspace,
    outcome: StepOutcome,
}

impl Backend for Cpu {
    fn name(&self) -> &'static str {
        "cpu"
    }

    fn prepare(&mut self, model: &Model, state: &State, _plan: &StepPlan) {
        self.masses.prepare(model, state);
        self.joints.invalidate();
    }

    fn run(&mut self, stage: Stage, model: &Model, plan: &StepPlan, state: &mut State) -> bool {
        match stage {
            Stage::Bounds => self.bounds(model, plan, state),
            Stage::BinEmit | Stage::BinSort | Stage::BinStart | Stage::PairWrite if self.pairs_hold => return false,
            Stage::BinEmit => bin_emit::run(model, state, plan, &mut self.bins),
            Stage::BinSort => gpu::radix_sort::sort_cpu(&mut self.bins.bin, &mut self.bins.shape, self.bins.grid.len()),
            Stage::BinStart => bin_start::run(&self.bins.bin, &mut self.bins.start),
            Stage::PairWrite => {
                pair_write::run(model, state, &self.bins, &mut self.pairs);
                self.has_pairs = true;
                // The broad phase does not run in every step; in between the solver uses the bins' memory.
                self.bins = Bins::default();
            }
            Stage::ContactWrite => self.contact_write(model, plan, state),
            Stage::WarmStart => warm_start::run(plan, &mut self.last, &mut state.contacts),
            Stage::Force => force::run(model, plan, state, &mut self.masses, &mut self.free),
            Stage::JointWrite => {
                let out = joint_write::Output {
                    start: &mut self.joint_start,
                    joints: &mut self.joints,
                    free: &mut self.free,
                };
                joint_write::run(model, state, &mut self.masses, out);
            }
            Stage::ContactSolve => self.contact_solve(model, plan, state),
            Stage::Integrate => {
                let Cpu { joint_start, joints, response, outcome, .. } = self;
                joint_write::record(model, state, (joint_start, joints), response, outcome);
                integrate::run(model, &self.response.twist, &self.displacement, state);
            }
        }
        true
    }

    fn outcome(&self) -> StepOutcome {
        self.outcome
    }

    fn column<'a>(&'a self, state: &'a State, column: Column) -> View<'a> {
        let row = |r: &Row| {
            let [l, a, b] = [r.linear, r.angular_a, r.angular_b].map(|v| v.to_array());
            [l[0], l[1], l[2], a[0], a[1], a[2], b[0], b[1], b[2], r.psi, r.rate, r.softness]
        };
        let sphere = |s: &Sphere| [s.centre.x, s.centre.y, s.centre.z, s.reach, s.radius];
        match column {
            Column::Margin => View::of_f32(&self.margin),
            Column::TightAabb => View::of_any(&self.tight_aabb),
            Column::Sphere => View::of_rows(&self.spheres, sphere),
            Column::BinLevel => View::of_any(&self.bins.grid.level),
            Column::BinLow => View::of_any(&self.bins.grid.low),
            Column::Bin => View::of_u32(&self.bins.bin),
            Column::BinShape => View::of_u32(&self.bins.shape),
            Column::BinStart => View::of_u32(&self.bins.start),
            Column::SpherePairStart => View::of_u32(&self.pairs.sphere_start),
            Column::SpherePair => View::of_u32(&self.pairs.spheres),
            Column::OtherPairStart => View::of_u32(&self.pairs.other_start),
            Column::OtherPair => View::of_u32(&self.pairs.others),
            Column::Free => View::of_f64(&self.free),
            Column::Tensor => View::of_f64(self.masses.tensors()),
            Column::JointStart => View::of_u32(&self.joint_start),
            Column::JointRow => View::of_rows(&self.joints.rows, row),
            Column::JointKept => View::of_f64(&self.joints.kept),
            Column::JointBias => View::of_f64(&self.joints.bias),
            Column::Motion => View::of_f64(&self.response.twist),
            Column::Displacement => View::of_f64(&self.displacement.twist),
            Column::JointImpulse => View::of_f64(&self.response.lambda),
            column => View::of_state(state, column).expect("all other columns are the state's"),
        }
    }
}

impl Cpu {
    /// The back end for the first stages of steps that a device completes, whose contacts are those that it would find itself.
    pub fn before_device() -> Cpu {
        Cpu { has_all_contacts: true, ..Cpu::default() }
    }

    /// The rows of the joints and the masses of a step, after the stage that writes them.
    pub fn into_joints(self) -> (Joints, Masses) {
        (self.joints, self.masses)
    }

    fn bounds(&mut self, model: &Model, plan: &StepPlan, state: &mut State) {
        let mut fat_aabb = state.fat_aabb.take();
        let out = bounds::Output { margin: &mut self.margin, tight: &mut self.tight_aabb, spheres: &mut self.spheres };
        let has_left = bounds::run(model, plan, state, out, &mut fat_aabb);
        state.fat_aabb = fat_aabb;
        self.pairs_hold = self.has_pairs && !has_left;
        if !self.pairs_hold {
            self.solver.release();
        }
    }

    fn contact_write(&mut self, model: &Model, plan: &StepPlan, state: &mut State) {
        let mut contacts = std::mem::take(&mut state.contacts);
        let manifolds = std::mem::take(&mut state.manifolds);
        let (n_shapes, pairs_hold) = (model.n_shapes(), self.pairs_hold);
        let take = || self.last.take(plan, &mut contacts, n_shapes, pairs_hold);
        let ((), last) = rayon::join(take, || recycle::Last::new(&manifolds, n_shapes, pairs_hold));
        let at = contact_write::Input {
            model,
            plan,
            state,
            margin: &self.margin,
            tight: &self.tight_aabb,
            spheres: &self.spheres,
            last,
            are_all: self.has_all_contacts || plan.coheres,
        };
        contact_write::run(&at, &self.pairs, &mut self.touching, &mut contacts);
        state.contacts = contacts;
        state.manifolds = self.touching.take_manifolds(manifolds);
    }

    fn contact_solve(&mut self, model: &Model, plan: &StepPlan, state: &mut State) {
        let mut contacts = std::mem::take(&mut state.contacts);
        let mut joint_factor = std::mem::take(&mut state.joint_factor);
        let columns = contact_solve::Columns {
            masses: &self.masses,
            free: &self.free,
            joints: &mut self.joints,
            joint_factor: &mut joint_factor,
            joint_start: &self.joint_start,
            response: &mut self.response,
            displacement: &mut self.displacement,
        };
        *self.solver.step_length() = state.step_length;
        (self.outcome.solver, self.outcome.worst) =
            contact_solve::run(model, plan, state, &mut contacts, columns, &mut self.solver);
        self.outcome.bend = self.solver.bend();
        (state.step_length, state.joint_factor) = (*self.solver.step_length(), joint_factor);
        state.contacts = contacts;
    }
}
