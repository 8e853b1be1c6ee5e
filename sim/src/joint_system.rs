//! The linear system of the joints of a state, S = BᵀM⁻¹B + C: what a step factorises once and solves in each iteration. For benchmarks.

use crate::backend::Backend;
use crate::cpu::Cpu;
use crate::cpu::masses::Masses;
use crate::cpu::solve::joints::Joints;
use crate::cpu::solve::response::Response;
use crate::joint::{JointState, SpringState};
use crate::model::Model;
use crate::plan::StepPlan;
use crate::stages::Stage;
use crate::state::State;
use crate::twist::Twist;
use glam::DVec3;

/// The joints of a state, and the velocities that they act on.
pub struct JointSystem {
    joints: Joints,
    masses: Masses,
    response: Response,
}

impl JointSystem {
    /// The joints of a state in its next step.
    pub fn new(model: &Model, state: &State) -> JointSystem {
        let mut state = State { contacts: Default::default(), fat_aabb: None, ..state.clone() };
        state.joints.resize(model.joints.len(), JointState::default());
        state.springs.resize(model.springs.len(), SpringState::default());
        state.wake(model);
        let plan = StepPlan::resolve(model, &state);
        let mut cpu = Cpu::default();
        cpu.prepare(model, &state, &plan);
        for stage in Stage::ALL.into_iter().take_while(|stage| *stage != Stage::ContactSolve) {
            cpu.run(stage, model, &plan, &mut state);
        }
        let (joints, masses) = cpu.into_joints();
        let fall = Twist { v: model.gravity * model.step, w: DVec3::new(0.3, -0.2, 0.1) };
        let response = Response { twist: vec![fall; model.n_bodies()], lambda: vec![] };
        JointSystem { joints, masses, response }
    }

    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.joints.rows.len()
    }

    /// Numbers of the factor, zeros in it included, and multiplications of a factorisation.
    pub fn size(&self) -> (usize, u64) {
        self.joints.size()
    }

    /// Discard the sparsity pattern and the order of elimination.
    pub fn forget(&mut self) {
        self.joints.forget();
    }

    /// Factorise; the first time, and after [`JointSystem::forget`], with the analysis.
    pub fn factorise(&mut self) {
        self.joints.prepare(&self.masses);
    }

    /// Solve once. Returns the greatest |dΨ/dt + Cλ| that is left of it, m/s or rad/s.
    pub fn solve(&mut self) -> f64 {
        self.joints.reset(&mut self.response);
        self.joints.solve_at_rest(&self.masses, &mut self.response);
        self.joints.residual_at_rest(&self.response)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;
    use crate::model_file::ModelFile;
    use frame::yaml;
    use std::path::Path;

    /// Bodies on a jittered lattice with joints of all kinds between neighbours: closed loops, redundant rows, soft springs, motors.
    fn mechanism(n: usize) -> String {
        const KINDS: [&str; 8] =
            ["spherical", "revolute", "universal", "fixed", "cylindrical", "prismatic", "point_on_plane", "revolute"];
        let mut random = SplitMix64(8);
        let mut bodies =
            "name: test\nstep: 0.001\nduration: 1\nframe_rate: 1\nmaterials: {m: {density: 800, friction: 0.3}}\n\
                          pass_through: [[g, g]]\nbodies:\n"
                .to_string();
        let (mut joints, mut springs) = ("joints:\n".to_string(), "springs:\n".to_string());
        for i in 0..n {
            for k in 0..n {
                let at = [i as f64, k as f64, random.between(-0.2, 0.2)];
                bodies += &format!(
                    "  - {{name: b{i}_{k}, material: m, group: g, position: {at:?}, box: {{size: [0.3, 0.5, {}]}}}}\n",
                    random.between(0.2, 0.9)
                );
                for (a, b) in [(i.wrapping_sub(1), k), (i, k.wrapping_sub(1))] {
                    let other = if a < n && b < n { format!("b{a}_{b}") } else { "world".into() };
                    let kind = KINDS[random.below(8)];
                    let axis = if kind == "spherical" { "" } else { ", axis: [0, 0, 1]" };
                    let motor = if kind == "revolute" && k % 3 == 0 { ", motor: {speed: 0.5}" } else { "" };
                    joints += &format!(
                        "  - {{name: j{i}_{k}_{a}_{b}, kind: {kind}, a: {other}, b: b{i}_{k}, position: [{}, {}, 0.1]{axis}{motor}}}\n",
                        at[0] - 0.5,
                        at[1] - 0.4
                    );
                }
                if i > 1 {
                    springs += &format!(
                        "  - {{name: s{i}_{k}, a: b{}_{k}, b: b{i}_{k}, position: [{}, {k}, 0], position_b: [{i}, {k}, 0.1], stiffness: 1.0e7, damping: 200}}\n",
                        i - 2,
                        i - 2
                    );
                }
            }
        }
        bodies + &joints + if n > 2 { &springs } else { "" }
    }

    #[test]
    fn mechanisms_of_all_kinds_are_solved_to_rounding() {
        for n in [1, 2, 4, 7] {
            let (file, doc) = yaml::parse::<ModelFile>(Path::new("test.yaml"), mechanism(n)).expect("sound YAML");
            let resolved = file.resolve(&doc).unwrap_or_else(|e| panic!("{e}"));
            let mut system = JointSystem::new(&resolved.model, &resolved.state);
            let least = 5 * n * n;
            assert!(system.n_rows() >= least, "{} rows of {n} x {n} bodies", system.n_rows());
            system.factorise();
            let left = system.solve();
            let most = system.response.lambda.iter().fold(0.0, |most: f64, l| l.abs().max(most));
            assert!(left < 1e-9 && most > 1e-3, "{n} x {n} bodies: {left:e}, multipliers of up to {most:e}");
            // Again, and after the analysis has been made again.
            let bits = |s: &JointSystem| s.response.lambda.iter().map(|l| l.to_bits()).collect::<Vec<u64>>();
            let mut again = JointSystem::new(&resolved.model, &resolved.state);
            again.factorise();
            again.forget();
            again.factorise();
            again.solve();
            assert!(bits(&system) == bits(&again));
        }
    }

    /// Two hubs, one of them hinged to the world, with pendulums on both.
    fn hubs(n: usize) -> String {
        let mut bodies =
            "name: test\nstep: 0.001\nduration: 1\nframe_rate: 1\nmaterials: {m: {density: 800, friction: 0.3}}\n\
                          pass_through: [[g, g]]\nbodies:\n"
                .to_string();
        let mut joints = "joints:\n".to_string();
        for (hub, z) in [("left", 0.0), ("right", 9.0)] {
            bodies += &format!(
                "  - {{name: {hub}, material: m, group: g, position: [0, 0, {z}], box: {{size: [{n}, 0.5, 0.3]}}}}\n"
            );
            for i in 0..n {
                let x = i as f64 - 0.5 * n as f64;
                bodies += &format!(
                    "  - {{name: {hub}{i}, material: m, group: g, position: [{x}, 1, {z}], sphere: {{radius: 0.2}}}}\n"
                );
                joints += &format!(
                    "  - {{name: {hub}{i}, kind: revolute, a: {hub}, b: {hub}{i}, position: [{x}, 0.3, {z}], axis: [0, 0, 1]}}\n"
                );
            }
        }
        joints += "  - {name: both, kind: universal, a: left, b: right, position: [1, 0, 5]}\n";
        joints += "  - {name: held, kind: spherical, a: world, b: left, position: [3, 1, 0]}\n";
        bodies + &joints
    }

    #[test]
    fn hubs_cost_in_proportion_to_their_joints() {
        let solved = |n: usize| {
            let (file, doc) = yaml::parse::<ModelFile>(Path::new("test.yaml"), hubs(n)).expect("sound YAML");
            let resolved = file.resolve(&doc).unwrap_or_else(|e| panic!("{e}"));
            let mut system = JointSystem::new(&resolved.model, &resolved.state);
            system.factorise();
            let left = system.solve();
            assert!(left < 1e-9, "{n} joints on each hub: {left:e}");
            system.size()
        };
        // Few joints are coupled by their body alone.
        let ((_, few), (numbers, many)) = (solved(10), solved(300));
        assert!(
            few > 0 && numbers < 2 * 300 * 200 && many < 2 * 300 * 1000,
            "{numbers} numbers, {many} multiplications"
        );
    }
}
