//! Frames and contact tables from the state, and lines of `report.csv` from step reports.

use crate::contacts::Contacts;
use crate::joint::SpringKind;
use crate::model::Model;
use crate::pose::Pose;
use crate::shape::ShapeKind;
use crate::simulation::StepReport;
use crate::stages::Stage;
use crate::state::State;
use frame::{Column, Frame};
use glam::{DQuat, DVec3};
use std::collections::HashMap;

/// The frame of the state's time, with index `index`: one row per shape of the bodies that have appeared, in the order of the shapes,
/// then one per spring between two points that acts.
///
/// Columns: id (of the body; springs count on from the bodies), part (index of the shape on its body), class (of a spring its name),
/// shape, pos_x..z (m) and quat_w..z of the shape, vel_x..z (m/s) at its centre, speed (m/s), omega_x..z (rad/s, shape's frame),
/// half_x..z (m: radius three times for a sphere, half axes, half lengths; radius, radius, half length for cylinder, capsule and cone; 0
/// for a plane, whose normal is its z axis). Each hull, mesh and height field has a shape name of its own, as `hull_0`. The shape
/// `spring` is a rod along its z axis from point to point, as thick as it is drawn.
pub fn frame_of(model: &Model, state: &State, index: u64) -> Frame {
    let mut frame = Frame::new(index, state.time);
    let rows: Vec<usize> =
        (0..model.n_shapes()).filter(|s| !state.is_inactive(model.shape_body[*s] as usize)).collect();
    let rods: Vec<Rod> = (0..model.springs.len()).filter_map(|k| Rod::of(model, state, k)).collect();
    let body = |s: usize| model.shape_body[s] as usize;
    let places: Vec<Pose> =
        rows.iter().map(|s| state.shape_pose(model, *s)).chain(rods.iter().map(|rod| rod.place)).collect();
    let ids = rows.iter().map(|s| body(*s)).chain(rods.iter().map(|rod| model.n_bodies() + rod.spring));
    frame.push("id", "", Column::I64(ids.map(|id| id as i64).collect()));
    let parts = parts(model, &rows).into_iter().chain(rods.iter().map(|_| 0)).collect();
    frame.push("part", "", Column::I64(parts));
    frame.push("class", "", classes(model, &rows, &rods));
    frame.push("shape", "", shapes(model, &rows, &rods));
    for (i, name) in ["pos_x", "pos_y", "pos_z"].into_iter().enumerate() {
        frame.push(name, "m", Column::F64(places.iter().map(|p| p.position[i]).collect()));
    }
    let spin = |s: usize| state.orientation[body(s)] * state.angular_velocity[body(s)];
    let of_shape = |(s, place): (&usize, &Pose)| {
        let arm = place.position - state.position[body(*s)];
        let w = spin(*s);
        (state.velocity[body(*s)] + w.cross(arm), place.orientation.inverse() * w)
    };
    let motion: Vec<(DVec3, DVec3)> =
        rows.iter().zip(&places).map(of_shape).chain(rods.iter().map(|rod| (rod.velocity, DVec3::ZERO))).collect();
    let sizes: Vec<DVec3> = rows.iter().map(|s| model.shape_size[*s]).chain(rods.iter().map(|rod| rod.half)).collect();
    let mut single = |name: &str, unit: &str, value: &dyn Fn(usize) -> f64| {
        frame.push(name, unit, Column::F32((0..places.len()).map(|r| value(r) as f32).collect()));
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
        single(name, "m", &|r| sizes[r][i]);
    }
    frame
}

/// A spring between two points, as a rod.
struct Rod {
    /// Index of the spring.
    spring: usize,
    /// Its middle, with z along it.
    place: Pose,
    /// Velocity of its middle, m/s.
    velocity: DVec3,
    /// Radius, radius and half length, m.
    half: DVec3,
}

impl Rod {
    /// The rod of a spring; none if it is rotational, does not act, or has no length.
    fn of(model: &Model, state: &State, index: usize) -> Option<Rod> {
        /// Radius over length.
        const THICKNESS: f64 = 0.02;
        let spring = &model.springs[index];
        let ends = state.spring_frames(spring);
        let (a, b) = (ends.a.position, ends.b.position);
        let length = a.distance(b);
        let is_there = spring.bodies.iter().all(|body| !state.is_inactive(*body as usize));
        if spring.kind != SpringKind::Line
            || !is_there
            || !(spring.from..spring.until).contains(&state.time)
            || !(length > 1e-9)
        {
            return None;
        }
        let orientation = DQuat::from_rotation_arc(DVec3::Z, (b - a) / length);
        let at = |body: u32, point: DVec3| {
            let body = body as usize;
            let w = state.orientation[body] * state.angular_velocity[body];
            state.velocity[body] + w.cross(point - state.position[body])
        };
        Some(Rod {
            spring: index,
            place: Pose { position: 0.5 * (a + b), orientation },
            velocity: 0.5 * (at(spring.bodies[0], a) + at(spring.bodies[1], b)),
            half: DVec3::new(THICKNESS * length, THICKNESS * length, 0.5 * length),
        })
    }
}

/// Classes of the rows: of the bodies, and the names of the springs.
fn classes(model: &Model, rows: &[usize], rods: &[Rod]) -> Column {
    let of_bodies = rows.iter().map(|s| model.class[model.shape_body[*s] as usize]);
    if rods.is_empty() {
        return Column::Category { codes: of_bodies.collect(), names: model.class_names.clone() };
    }
    let mut words = Words::new(model.class_names.iter().map(String::as_str));
    let of_rods = rods.iter().map(|rod| words.code(&model.springs[rod.spring].name));
    Column::Category { codes: of_bodies.chain(of_rods).collect(), names: words.names }
}

/// Shapes of the rows.
fn shapes(model: &Model, rows: &[usize], rods: &[Rod]) -> Column {
    let mut words = Words::new(ShapeKind::ALL.iter().map(|kind| kind.name()));
    let mut code = |s: &usize| {
        let kind = model.shape_kind[*s];
        match kind {
            ShapeKind::Hull | ShapeKind::Mesh | ShapeKind::HeightField => {
                words.code(&format!("{}_{}", kind.name(), model.shape_part[*s]))
            }
            kind => kind as u32,
        }
    };
    let mut codes: Vec<u32> = rows.iter().map(&mut code).collect();
    codes.extend(rods.iter().map(|_| words.code("spring")));
    Column::Category { codes, names: words.names }
}

/// The words of a column, each with its code.
struct Words {
    names: Vec<String>,
    codes: HashMap<String, u32>,
}

impl Words {
    fn new<'a>(names: impl Iterator<Item = &'a str>) -> Words {
        let mut words = Words { names: vec![], codes: HashMap::new() };
        for name in names {
            words.code(name);
        }
        words
    }

    /// The code of a word, which is added if it is missing.
    fn code(&mut self, name: &str) -> u32 {
        if let Some(code) = self.codes.get(name) {
            return *code;
        }
        let code = self.names.len() as u32;
        self.names.push(name.into());
        self.codes.insert(name.into(), code);
        code
    }
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

/// The contact table of the frame with index `index`: one row per contact of the last step.
///
/// Columns: body_a, body_b (ids), class_a, class_b, pos_x..z (m, world) of the contact point, normal_x..z (out of A, world),
/// force_x..z (N, world) on B, the mean over the step, and gap (m).
pub fn contacts_of(model: &Model, state: &State, index: u64) -> Frame {
    let mut frame = Frame::new(index, state.time);
    let all = || state.all_contacts();
    for (side, name) in [(0, "body_a"), (1, "body_b")] {
        frame.push(name, "", Column::I64(all().map(|(c, i)| c.bodies[i][side] as i64).collect()));
    }
    for (side, name) in [(0, "class_a"), (1, "class_b")] {
        let codes = all().map(|(c, i)| model.class[c.bodies[i][side] as usize]).collect();
        frame.push(name, "", Column::Category { codes, names: model.class_names.clone() });
    }
    let mut triple = |names: [&str; 3], unit: &str, value: &dyn Fn((&Contacts, usize)) -> DVec3| {
        for (k, name) in names.into_iter().enumerate() {
            frame.push(name, unit, Column::F64(all().map(|contact| value(contact)[k]).collect()));
        }
    };
    triple(["pos_x", "pos_y", "pos_z"], "m", &|contact| state.contact_point(contact));
    triple(["normal_x", "normal_y", "normal_z"], "1", &|(c, i)| c.normal[i]);
    triple(["force_x", "force_y", "force_z"], "N", &|(c, i)| c.impulse[i] / model.step);
    frame.push("gap", "m", Column::F64(all().map(|(c, i)| c.gap[i]).collect()));
    frame
}

/// Header of `report.csv`, with its line break: names and units of the quantities of a [`StepReport`], a column for each stage's time.
pub fn report_header() -> String {
    let stages: Vec<String> = Stage::ALL.iter().map(|s| format!("{} [ms]", s.name())).collect();
    format!("step,time [s],contacts,iterations,residual [m/s],worst_penetration [m],parts,{}\n", stages.join(","))
}

/// Line of `report.csv` for a step, with its line break; the values are in the order of [`report_header`].
pub fn report_line(r: &StepReport) -> String {
    let stages: Vec<String> = r.stage_ms.iter().map(|ms| format!("{ms:.4}")).collect();
    format!(
        "{},{:.9},{},{},{:.6e},{:.6e},{},{}\n",
        r.step,
        r.time,
        r.contacts,
        r.iterations,
        r.residual,
        r.worst_penetration,
        r.parts,
        stages.join(",")
    )
}
