//! Probes: the quantities of `probes.csv`, one line per instant, with units in the header.

use crate::joint::{Coordinate, SpringKind};
use crate::load::Function;
use crate::model_file::Probes;
use crate::{Model, Pose, State};
use glam::DVec3;
use std::fmt::Write;

/// Header of `probes.csv`, with its line break: the names of the quantities with their units.
///
/// After the time come, per body: position and orientation of the model file's body frame, velocity of the centre of mass (world), and
/// angular velocity (body frame). Per joint: the reaction force and torque of body B on body A, about the origin of the joint's frame on
/// A, both in that frame (`_joint`) and in the world (`_world`), the coordinate and its rate if the kind of joint has one, the constraint violation, and
/// effort and work of what drives it. Per spring: force and length, or torque and angle. Per pair of classes: number of contacts with an impulse, and
/// total force on the second class (world). With energies: kinetic, potential and elastic energy, that of bodies that have come, and the work of motors and of loads, as far as
/// there are such, maximum penetration, and mean slip speed of the contacts with an impulse.
pub fn probe_header(model: &Model, probes: &Probes) -> String {
    let mut h = String::from("time [s]");
    let mut add = |name: &str, parts: &[(&str, &str)]| {
        for (part, unit) in parts {
            let _ = write!(h, ",{}", guard::text::cell(&format!("{name}.{part} [{unit}]")));
        }
    };
    for b in &probes.bodies {
        add(
            &model.body_names.of(*b).map_or_else(|| format!("body_{b}"), String::from),
            &[
                ("x", "m"),
                ("y", "m"),
                ("z", "m"),
                ("qw", "1"),
                ("qx", "1"),
                ("qy", "1"),
                ("qz", "1"),
                ("vx", "m/s"),
                ("vy", "m/s"),
                ("vz", "m/s"),
                ("wx", "rad/s"),
                ("wy", "rad/s"),
                ("wz", "rad/s"),
            ],
        );
    }
    for j in &probes.joints {
        let joint = &model.joints[*j as usize];
        let units = match joint.kind.coordinate() {
            Some(Coordinate::Angle) => Some(("angle", "rad", "rad/s")),
            Some(_) => Some(("length", "m", "m/s")),
            None => None,
        };
        for (force, torque) in [
            (["fx_joint", "fy_joint", "fz_joint"], ["tx_joint", "ty_joint", "tz_joint"]),
            (["fx_world", "fy_world", "fz_world"], ["tx_world", "ty_world", "tz_world"]),
        ] {
            add(&joint.name, &force.map(|part| (part, "N")));
            add(&joint.name, &torque.map(|part| (part, "N m")));
        }
        if let Some((name, unit, rate)) = units {
            add(&joint.name, &[(name, unit), ("rate", rate)]);
        }
        add(&joint.name, &[("violation", "m or rad")]);
        if let Some((name, ..)) = units.filter(|_| joint.is_driven()) {
            add(&joint.name, &[("effort", if name == "angle" { "N m" } else { "N" }), ("work", "J")]);
        }
    }
    for s in &probes.springs {
        let spring = &model.springs[*s as usize];
        let parts = match spring.kind {
            SpringKind::Angle => [("torque", "N m"), ("angle", "rad")],
            SpringKind::Line | SpringKind::Point => [("force", "N"), ("length", "m")],
        };
        add(&spring.name, &parts);
    }
    for (name, _) in &probes.contacts {
        add(name, &[("n", "1"), ("fx", "N"), ("fy", "N"), ("fz", "N")]);
    }
    if probes.energies {
        let has = Sources::of(model);
        add("energy", &[("kinetic", "J"), ("potential", "J")]);
        has.springs.then(|| add("energy", &[("elastic", "J")]));
        has.arrivals.then(|| add("energy", &[("arrived", "J")]));
        has.motors.then(|| add("work", &[("motors", "J")]));
        has.loads.then(|| add("work", &[("loads", "J")]));
        add("contacts", &[("worst_penetration", "m"), ("mean_slip", "m/s")]);
    }
    h.push('\n');
    h
}

/// What a model has besides bodies that stores energy or gives it.
struct Sources {
    springs: bool,
    /// Bodies that appear or are let go.
    arrivals: bool,
    /// Motors, lengths and preloads that change.
    motors: bool,
    loads: bool,
}

impl Sources {
    fn of(model: &Model) -> Sources {
        let has_changing_preload = model.springs.iter().any(|s| !matches!(s.preload, Function::Constant(_)));
        Sources {
            springs: !model.springs.is_empty(),
            arrivals: !model.scheduled.is_empty(),
            motors: has_changing_preload || model.joints.iter().any(|joint| joint.is_driven()),
            loads: !model.loads.is_empty(),
        }
    }
}

/// What a line of the probes has of all bodies and contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    /// Kinetic and potential energy, J, maximum penetration, m, and mean slip speed of the contacts with an impulse, m/s.
    pub whole: [f64; 4],
    /// Of each pair of classes, the number of contacts with an impulse and their total force on the second class, N.
    pub between: Vec<(usize, DVec3)>,
}

impl Sums {
    /// The sums of a state whose columns are up to date; those of all bodies are zeros where no energies are asked for.
    pub fn of(model: &Model, state: &State, probes: &Probes) -> Sums {
        let whole = match probes.energies {
            true => {
                let energies = [state.kinetic_energy(model), state.potential_energy(model)];
                [energies[0], energies[1], state.worst_penetration(), mean_slip(state)]
            }
            false => [0.0; 4],
        };
        Sums { whole, between: probes.contacts.iter().map(|(_, pair)| between(model, state, *pair)).collect() }
    }
}

/// Line of `probes.csv` at the state's time, with its line break, from a state that has the probed bodies, joints and springs as they are then; the
/// values are in the order of [`probe_header`].
pub fn probe_line(model: &Model, state: &State, probes: &Probes, sums: &Sums) -> String {
    let mut line = format!("{:.9}", state.time);
    let mut add = |values: &[f64]| {
        for x in values {
            // Of nothing there is no negative.
            let _ = write!(line, ",{:.9e}", x + 0.0);
        }
    };
    for b in &probes.bodies {
        let b = *b as usize;
        let principal = Pose { position: state.position[b], orientation: state.orientation[b] };
        let frame = principal.place(&model.body_frame[b]);
        let q = frame.orientation;
        let w = model.body_frame[b].orientation.inverse() * state.angular_velocity[b];
        add(&frame.position.to_array());
        add(&[q.w, q.x, q.y, q.z]);
        add(&state.velocity[b].to_array());
        add(&w.to_array());
    }
    for j in &probes.joints {
        let (joint, s) = (&model.joints[*j as usize], &state.joints[*j as usize]);
        [s.force, s.torque, s.force_world, s.torque_world].iter().for_each(|v| add(&v.to_array()));
        if joint.kind.coordinate().is_some() {
            add(&[s.coordinate, s.rate]);
        }
        add(&[s.violation]);
        if joint.is_driven() {
            add(&[s.effort, s.work]);
        }
    }
    for s in &probes.springs {
        let s = &state.springs[*s as usize];
        add(&[s.force, s.coordinate]);
    }
    for (n, force) in &sums.between {
        add(&[*n as f64]);
        add(&force.to_array());
    }
    if probes.energies {
        let ([energies @ .., penetration, slip], has) = (sums.whole, Sources::of(model));
        add(&energies);
        has.springs.then(|| add(&[state.elastic_energy(model)]));
        has.arrivals.then(|| add(&[state.arrived]));
        has.motors.then(|| add(&[state.work_of_motors()]));
        has.loads.then(|| add(&[state.load_work]));
        add(&[penetration, slip]);
    }
    line.push('\n');
    line
}

/// Number of contacts between two classes with an impulse, and their total force on bodies of the second, N.
fn between(model: &Model, state: &State, [first, second]: [u32; 2]) -> (usize, DVec3) {
    let (mut n, mut force) = (0, DVec3::ZERO);
    for (c, i) in state.all_contacts() {
        let classes = c.bodies[i].map(|b| model.class[b as usize]);
        let sign = if classes == [first, second] {
            1.0
        } else if classes == [second, first] {
            -1.0
        } else {
            continue;
        };
        if c.impulse[i] != DVec3::ZERO {
            n += 1;
            force += c.impulse[i] * (sign / model.step);
        }
    }
    (n, force)
}

/// Mean slip speed of the contacts with an impulse, m/s.
fn mean_slip(state: &State) -> f64 {
    let (mut n, mut sum) = (0usize, 0.0);
    for (c, i) in state.all_contacts().filter(|(c, i)| c.impulse[*i] != DVec3::ZERO) {
        sum += c.velocity(i, |b| state.twist(b)).reject_from_normalized(c.normal[i]).length();
        n += 1;
    }
    if n == 0 { 0.0 } else { sum / n as f64 }
}
