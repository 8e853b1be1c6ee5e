//! Frames and contact tables from the state, and lines of `report.csv` from step reports.

use crate::model::Model;
use crate::pose::Pose;
use crate::shape::ShapeKind;
use crate::simulation::StepReport;
use crate::stages::Stage;
use crate::state::State;
use frame::{Column, Frame};
use glam::DVec3;

/// The frame of the state's time, with index `index`: one row per shape of the bodies that have appeared, in the order of the shapes.
///
/// Columns: id (of the body), part (index of the shape on its body), class, shape, pos_x..z (m) and quat_w..z of the shape, vel_x..z (m/s) at its centre, speed (m/s),
/// omega_x..z (rad/s, shape's frame), half_x..z (m: radius three times for a sphere, half axes, half lengths; radius, radius,
/// half length for cylinder, capsule and cone; 0 for a plane, whose normal is its z axis). Each hull, mesh and height field has a
/// shape name of its own, as `hull_0`.
pub fn frame_of(model: &Model, state: &State, index: u64) -> Frame {
    let mut frame = Frame::new(index, state.time);
    let rows: Vec<usize> =
        (0..model.n_shapes()).filter(|s| !state.is_inactive(model.shape_body[*s] as usize)).collect();
    let body = |s: usize| model.shape_body[s] as usize;
    let places: Vec<Pose> = rows.iter().map(|s| state.shape_pose(model, *s)).collect();
    frame.push("id", "", Column::I64(rows.iter().map(|s| body(*s) as i64).collect()));
    frame.push("part", "", Column::I64(parts(model, &rows)));
    let classes = rows.iter().map(|s| model.class[body(*s)]).collect();
    frame.push("class", "", Column::Category { codes: classes, names: model.class_names.clone() });
    let (names, codes) = shape_names(model, &rows);
    frame.push("shape", "", Column::Category { codes, names });
    for (i, name) in ["pos_x", "pos_y", "pos_z"].into_iter().enumerate() {
        frame.push(name, "m", Column::F64(places.iter().map(|p| p.position[i]).collect()));
    }
    let spin = |s: usize| state.orientation[body(s)] * state.angular_velocity[body(s)];
    let motion: Vec<(DVec3, DVec3)> = rows
        .iter()
        .zip(&places)
        .map(|(s, place)| {
            let arm = place.position - state.position[body(*s)];
            let w = spin(*s);
            (state.velocity[body(*s)] + w.cross(arm), place.orientation.inverse() * w)
        })
        .collect();
    let mut single = |name: &str, unit: &str, value: &dyn Fn(usize) -> f64| {
        frame.push(name, unit, Column::F32((0..rows.len()).map(|r| value(r) as f32).collect()));
    };
    single("quat_w", "1", &|r| places[r].orientation.w);
    single("quat_x", "1", &|r| places[r].orientation.x);
    single("quat_y", "1", &|r| places[r].orientation.y);
    single("quat_z", "1", &|r| places[r].orientation.z);
    for (i, name) in ["vel_x", "vel_y", "vel_z"].into_iter().enumerate() {
        single(name, "m/s", &|r| motion[r].0[i]);
    }
    single("speed", "m/s", &|r| motion[r].0.length());
    for (i, name) in ["omega_x", "omega_y", "omega_z"].into_iter().enumerate() {
        single(name, "rad/s", &|r| motion[r].1[i]);
    }
    for (i, name) in ["half_x", "half_y", "half_z"].into_iter().enumerate() {
        single(name, "m", &|r| model.shape_size[rows[r]][i]);
    }
    frame
}

/// Index of each row's shape among the shapes of its body.
fn parts(model: &Model, rows: &[usize]) -> Vec<i64> {
    let mut n_before = vec![0; model.n_bodies()];
    let index = |s: &usize| {
        let next: &mut i64 = &mut n_before[model.shape_body[*s] as usize];
        *next += 1;
        *next - 1
    };
    rows.iter().map(index).collect()
}

/// Shape names, and the index of each row's name.
fn shape_names(model: &Model, rows: &[usize]) -> (Vec<String>, Vec<u32>) {
    let mut names: Vec<String> = ShapeKind::ALL.iter().map(|k| k.name().to_string()).collect();
    let codes = rows
        .iter()
        .map(|&s| {
            let kind = model.shape_kind[s];
            if !matches!(kind, ShapeKind::Hull | ShapeKind::Mesh | ShapeKind::HeightField) {
                return kind as u32;
            }
            let name = format!("{}_{}", kind.name(), model.shape_part[s]);
            names.iter().position(|n| *n == name).unwrap_or_else(|| {
                names.push(name);
                names.len() - 1
            }) as u32
        })
        .collect();
    (names, codes)
}

/// The contact table of the frame with index `index`: one row per contact of the last step.
///
/// Columns: body_a, body_b (ids), class_a, class_b, pos_x..z (m, world) of the contact point, normal_x..z (out of A, world),
/// force_x..z (N, world) on B, the mean over the step, and gap (m).
pub fn contacts_of(model: &Model, state: &State, index: u64) -> Frame {
    let mut frame = Frame::new(index, state.time);
    let c = &state.contacts;
    let n = c.len();
    for (side, name) in [(0, "body_a"), (1, "body_b")] {
        frame.push(name, "", Column::I64((0..n).map(|i| c.bodies[i][side] as i64).collect()));
    }
    for (side, name) in [(0, "class_a"), (1, "class_b")] {
        let codes = (0..n).map(|i| model.class[c.bodies[i][side] as usize]).collect();
        frame.push(name, "", Column::Category { codes, names: model.class_names.clone() });
    }
    let mut triple = |names: [&str; 3], unit: &str, value: &dyn Fn(usize) -> DVec3| {
        for (k, name) in names.into_iter().enumerate() {
            frame.push(name, unit, Column::F64((0..n).map(|i| value(i)[k]).collect()));
        }
    };
    triple(["pos_x", "pos_y", "pos_z"], "m", &|i| state.contact_point(i));
    triple(["normal_x", "normal_y", "normal_z"], "1", &|i| c.normal[i]);
    triple(["force_x", "force_y", "force_z"], "N", &|i| c.impulse[i] / model.step);
    frame.push("gap", "m", Column::F64(c.gap.clone()));
    frame
}

/// Header of `report.csv`, with its line break: names and units of the quantities of a [`StepReport`], a column for each stage's time.
pub fn report_header() -> String {
    let stages: Vec<String> = Stage::ALL.iter().map(|s| format!("{} [ms]", s.name())).collect();
    format!("step [1],time [s],contacts [1],iterations [1],residual [m/s],worst_penetration [m],{}\n", stages.join(","))
}

/// Line of `report.csv` for a step, with its line break; the values are in the order of [`report_header`].
pub fn report_line(r: &StepReport) -> String {
    let stages: Vec<String> = r.stage_ms.iter().map(|ms| format!("{ms:.4}")).collect();
    format!(
        "{},{:.9},{},{},{:.6e},{:.6e},{}\n",
        r.step,
        r.time,
        r.contacts,
        r.iterations,
        r.residual,
        r.worst_penetration,
        stages.join(",")
    )
}
