//! Overlaps of the bodies of a model, by the broad and the narrow phase of a step.

use crate::backend::Backend;
use crate::cpu::Cpu;
use crate::model::Model;
use crate::plan::StepPlan;
use crate::stages::Stage;
use crate::state::State;

/// An overlap of two shapes.
pub struct Overlap {
    /// Ids of bodies A and B.
    pub bodies: [u32; 2],
    /// Ids of the overlapping shapes of A and B.
    pub shapes: [u32; 2],
    /// Maximum penetration, m.
    pub depth: f64,
}

/// The overlaps of a state, one per pair of shapes that penetrate each other. Inactive bodies are left out: the poses that the other
/// bodies will have when these appear are not known.
pub fn overlaps(model: &Model, state: &State) -> Vec<Overlap> {
    let mut state =
        State { contacts: Default::default(), sleepers: Default::default(), fat_aabb: None, ..state.clone() };
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
