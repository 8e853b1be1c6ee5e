//! The state as a frame table, and the steps' report as CSV.

use crate::stages::STAGES;
use crate::{Model, State, StepReport};
use frame::{Column, Frame};

/// The table of one instant: one row a shape's body, in the order of the bodies.
///
/// Columns: id, class, shape, pos_x..z (m), quat_w..z, vel_x..z (m/s), speed (m/s), omega_x..z (rad/s, body frame), size_x..z
/// (m: radius three times for a sphere, half lengths for a box, 0 for a plane, whose normal is its z axis).
pub fn frame_of(model: &Model, state: &State, number: u64) -> Frame {
    let mut frame = Frame::new(number, state.time);
    let bodies: Vec<usize> = model.shape_body.iter().map(|b| *b as usize).collect();
    let shape_names = ["sphere", "box", "plane"].map(str::to_string).to_vec();
    frame.push("id", "", Column::I64(bodies.iter().map(|b| *b as i64).collect()));
    let classes = bodies.iter().map(|b| model.class[*b]).collect();
    frame.push("class", "", Column::Category { codes: classes, names: model.class_names.clone() });
    let shapes = model.shape_kind.iter().map(|k| *k as u32).collect();
    frame.push("shape", "", Column::Category { codes: shapes, names: shape_names });
    for (i, name) in ["pos_x", "pos_y", "pos_z"].into_iter().enumerate() {
        frame.push(name, "m", Column::F64(bodies.iter().map(|b| state.position[*b][i]).collect()));
    }
    let mut single = |name: &str, unit: &str, value: &dyn Fn(usize) -> f64| {
        frame.push(name, unit, Column::F32(bodies.iter().map(|b| value(*b) as f32).collect()));
    };
    single("quat_w", "", &|b| state.orientation[b].w);
    single("quat_x", "", &|b| state.orientation[b].x);
    single("quat_y", "", &|b| state.orientation[b].y);
    single("quat_z", "", &|b| state.orientation[b].z);
    for (i, name) in ["vel_x", "vel_y", "vel_z"].into_iter().enumerate() {
        single(name, "m/s", &|b| state.velocity[b][i]);
    }
    single("speed", "m/s", &|b| state.velocity[b].length());
    for (i, name) in ["omega_x", "omega_y", "omega_z"].into_iter().enumerate() {
        single(name, "rad/s", &|b| state.angular_velocity[b][i]);
    }
    for (i, name) in ["size_x", "size_y", "size_z"].into_iter().enumerate() {
        frame.push(name, "m", Column::F32(model.shape_size.iter().map(|s| s[i] as f32).collect()));
    }
    frame
}

/// The head of `report.csv`.
pub fn report_header() -> String {
    let stages: Vec<String> = STAGES.iter().map(|s| format!("{s} [ms]")).collect();
    format!("step,time [s],contacts,iterations,residual [m/s],worst_penetration [m],{}\n", stages.join(","))
}

/// A line of `report.csv`.
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
