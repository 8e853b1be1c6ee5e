//! Bodies of a model that overlap.

use crate::backend::Backend;
use crate::cpu::Cpu;
use crate::model::Model;
use crate::plan::StepPlan;
use crate::stages::Stage;
use crate::state::State;

/// Two bodies that overlap.
pub struct Overlap {
    /// The bodies.
    pub bodies: [u32; 2],
    /// Their shapes.
    pub shapes: [u32; 2],
    /// How deep, m.
    pub depth: f64,
}

/// The overlaps of a state, the deepest of each pair of shapes. What appears later must not overlap then; where that is nobody
/// knows yet.
pub fn overlaps(model: &Model, state: &State) -> Vec<Overlap> {
    let mut state = State { contacts: Default::default(), fat_aabb: None, ..state.clone() };
    state.wake(model);
    let plan = StepPlan::resolve(model, &state);
    let mut cpu = Cpu::default();
    cpu.prepare(model, &state, &plan);
    for stage in Stage::ALL.into_iter().take_while(|stage| *stage != Stage::WarmStart) {
        cpu.run(stage, model, &plan, &mut state);
    }
    let contacts = &state.contacts;
    let mut found: Vec<Overlap> = vec![];
    for i in 0..contacts.len() {
        let (depth, [s, t, _]) = (-contacts.gap[i], contacts.key[i]);
        match found.last_mut() {
            _ if depth <= 0.0 => {}
            Some(last) if last.shapes == [s, t] => last.depth = last.depth.max(depth),
            _ => found.push(Overlap { bodies: contacts.bodies[i], shapes: [s, t], depth }),
        }
    }
    found
}
