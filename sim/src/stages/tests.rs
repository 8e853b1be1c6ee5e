//! The checks of columns find faults.

use super::*;
use crate::ModelBuilder;
use crate::backend::Backend;
use crate::cpu::Cpu;
use crate::model_file::ShapeFile;

/// A sphere and a box on the ground, after the stages up to the given one.
fn stepped(last: Stage) -> (Model, StepPlan, State, Cpu) {
    let mut builder = ModelBuilder::new("two");
    builder.material("stone", 2600.0, 0.5);
    builder.body("ground", "stone", ShapeFile::plane([0.0, 0.0, 1.0]));
    builder.body("sphere", "stone", ShapeFile::sphere(0.1)).position = [0.0, 0.0, 0.1];
    builder.body("box", "stone", ShapeFile::cuboid([0.2, 0.3, 0.4])).position = [1.0, 0.0, 0.2];
    let sim = builder.simulation().unwrap();
    let (model, mut state) = (sim.model, sim.state);
    let plan = StepPlan::resolve(&model, &state);
    let mut cpu = Cpu::default();
    cpu.prepare(&model, &state, &plan);
    for stage in Stage::ALL {
        cpu.run(stage, &model, &plan, &mut state);
        check(stage, &model, &plan, &state, |column| cpu.column(&state, column)).unwrap();
        if stage == last {
            break;
        }
    }
    (model, plan, state, cpu)
}

#[test]
fn the_table_has_the_columns_in_the_order_of_the_enum() {
    for (k, spec) in COLUMNS.iter().enumerate() {
        assert_eq!(spec.column as usize, k);
        assert!(!spec.writers.is_empty() && !spec.readers.is_empty(), "`{}` has no writer or no reader", spec.name);
        assert_eq!(COLUMNS.iter().filter(|other| other.name == spec.name).count(), 1, "`{}` stands twice", spec.name);
    }
}

#[test]
fn faults_are_found() {
    let (model, plan, state, cpu) = stepped(Stage::ContactWrite);
    assert_eq!(state.contacts.len(), 5, "a sphere and four corners");
    let fault = |change: &dyn Fn(&mut State)| {
        let mut state = state.clone();
        change(&mut state);
        check(Stage::ContactWrite, &model, &plan, &state, |column| cpu.column(&state, column)).unwrap_err()
    };
    let expect = |change: &dyn Fn(&mut State), part: &str| {
        let message = fault(change);
        assert!(message.contains(part), "{message}");
    };
    expect(&|s| s.contacts.gap[2] = f64::NAN, "column `contact_gap` has a value that is not finite at index 2");
    expect(&|s| s.contacts.law.truncate(4), "column `contact_law` has 4 rows, expected 5");
    expect(&|s| s.contacts.law[1] = 7, "column `contact_law` has 7 where ids are below 1");
    expect(&|s| s.contacts.bodies[0][1] = 3, "column `contact_bodies` has 3 where ids are below 3");
    expect(&|s| s.contacts.tiles.start[0] = 1, "column `contact_start` does not go from 0 to 5");
    expect(&|s| s.contacts.arms = Arms::Along(vec![[0.0; 2]; 5]), "column `contact_arms`");
}

#[test]
fn tiles_that_share_a_body_are_found() {
    let (_, _, mut state, _) = stepped(Stage::ContactWrite);
    check_tiles(&state).unwrap();
    // The corners of the box, in two tiles of one round.
    state.contacts.tiles = crate::contacts::Tiles { start: vec![0, 2, 5, 5], n_first: 2, ..Default::default() };
    state.contacts.bodies = vec![[0, 1], [0, 2], [0, 2], [0, 2], [0, 2]];
    assert!(check_tiles(&state).unwrap_err().contains("body 2 has contacts in two tiles"));
}
