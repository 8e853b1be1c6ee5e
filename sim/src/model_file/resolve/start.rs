//! Checks of the state at the start: bodies that overlap, motors and lengths that begin elsewhere than their joints, springs that are too stiff.

use crate::joint::{Coordinate, Motor};
use crate::model_file::Resolved;
use crate::spring_rates::{self, Rate};
use frame::Fault;
use frame::yaml::Document;
use std::collections::BTreeMap;

/// Keys of the file for what it names, by the ids of that in the columns; what comes from a base has none.
#[derive(Default)]
pub(in crate::model_file) struct Keys {
    pub(super) bodies: BTreeMap<u32, String>,
    pub(super) joints: BTreeMap<u32, String>,
    pub(super) springs: BTreeMap<u32, String>,
}

/// Warn of motors and lengths that do not begin where their joints are: the first step goes there, however far it is.
pub(super) fn jumps(resolved: &mut Resolved, doc: &Document, keys: &Keys) {
    /// Angle, rad, and way over the size of the joint's bodies, that are a jump.
    const JUMP: f64 = 1e-2;
    let Resolved { model, state, warnings, .. } = resolved;
    // Largest half length of each body, m.
    let mut half = vec![0.0f64; model.n_bodies()];
    for s in (0..model.n_shapes()).filter(|s| !model.shape_kind[*s].is_surface()) {
        let own = &mut half[model.shape_body[s] as usize];
        *own = own.max(model.shape_size[s].max_element());
    }
    for (id, (joint, now)) in model.joints.iter().zip(&state.joints).enumerate() {
        let coordinate = joint.kind.coordinate().filter(|_| joint.acts(0.0));
        let (what, goal) = match (&joint.motor, coordinate) {
            // With a maximum effort it comes there bit by bit.
            (Some(Motor::Position(_)), Some(_)) if joint.max_effort.is_some() => continue,
            (Some(Motor::Position(motion)), Some(_)) => ("motor", motion.at(0.0)),
            (_, Some(Coordinate::Length)) => ("length", joint.length.at(0.0)),
            _ => continue,
        };
        let (is, is_angle) = (now.coordinate, coordinate == Some(Coordinate::Angle));
        let [a, b] = joint.bodies.map(|b| half[b as usize]);
        let (size, unit) = if is_angle { (1.0, "rad") } else { (a.max(b), "m") };
        if (goal - is).abs() > JUMP * size.max(1e-3) {
            let message = format!(
                "the {what} of joint `{}` begins at {goal:.3} {unit}, where the joint is at {is:.3} {unit}: the first step jumps there",
                joint.name
            );
            let key = keys.joints.get(&(id as u32));
            warnings.push(key.map_or(message.clone(), |key| doc.fault(&format!("{key}.{what}"), message).to_string()));
        }
    }
}

/// Warn of springs that would let bodies swing faster than a step resolves: they hold as if they were damped.
pub(super) fn stiff_springs(resolved: &mut Resolved, doc: &Document, keys: &Keys) {
    /// Swing in a step, rad, from which on a spring is implicit.
    const IMPLICIT: f64 = 1.0;
    let Resolved { model, state, warnings, .. } = resolved;
    let rates = spring_rates::rates(model, state);
    let stiff: Vec<_> = rates.iter().filter(|rate| rate.own * model.step >= IMPLICIT).collect();
    let Some(Rate { spring, own, .. }) = stiff.iter().max_by(|a, b| a.own.total_cmp(&b.own)) else { return };
    let message = format!(
        "spring `{}` is stiffer than steps of {:.2e} s resolve: it would let what it holds swing by {:.1} rad in a step, and holds it as if it were damped{}",
        model.springs[*spring].name,
        model.step,
        own * model.step,
        if stiff.len() > 1 { format!(", as do {} others", stiff.len() - 1) } else { String::new() }
    );
    let hint = format!("steps of {:.1e} s resolve it", 0.1 / own);
    let key = keys.springs.get(&(*spring as u32));
    warnings.push(match key {
        Some(key) => doc.fault(&format!("{key}.stiffness"), message).hint(hint).to_string(),
        None => format!("{message}; {hint}"),
    });
}

/// Check overlaps at the start: one deeper than a radius is an error, one deeper than a tenth of it a warning.
pub(super) fn overlaps(resolved: &mut Resolved, doc: &Document, keys: &Keys) -> Result<(), Fault> {
    let Resolved { model, state, warnings, .. } = resolved;
    let found = crate::overlaps::overlaps(model, state);
    let mut n_warned = 0;
    for o in &found {
        let radius = o.shapes.map(|s| match model.shape_kind[s as usize] {
            kind if kind.is_surface() => f64::INFINITY,
            _ => model.shape_size[s as usize].min_element(),
        });
        let radius = radius[0].min(radius[1]);
        let text = || {
            let [a, b] = o.bodies.map(|b| model.body_label(b as usize));
            format!("bodies {a} and {b} overlap by {:.3e} m at the start", o.depth)
        };
        let key = o.bodies.iter().rev().find_map(|b| keys.bodies.get(b));
        if o.depth > radius {
            let key = key.cloned().unwrap_or_default();
            return Err(doc.fault(&key, format!("{}, more than a radius of {radius:.3e} m", text())).hint(
                "move one of them, put them in groups that pass through each other, or connect them by a joint",
            ));
        }
        if o.depth > 0.1 * radius {
            n_warned += 1;
            if n_warned <= 5 {
                warnings.push(key.map_or_else(&text, |key| doc.fault(key, text()).to_string()));
            }
        }
    }
    if n_warned > 5 {
        warnings.push(format!("{} more pairs of bodies overlap at the start", n_warned - 5));
    }
    Ok(())
}
