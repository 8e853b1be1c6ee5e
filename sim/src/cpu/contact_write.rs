//! Write the contacts of every candidate pair: count, scan, write; then list each body's contacts.
//! in   candidate  [n_candidates]  pairs of shapes
//!      margin     [n_shapes]      m
//! out  contacts   [n_contacts]    every column but gamma
//! Source: paper §3, stages 7–9, on the pairs that `pair_write` kept.

use super::collide::{MAX_POINTS, Placed, Point, collide};
use super::{fill_rows, scatter_rows};
use crate::{Contacts, Model, State};

/// The stage. `count` and `points` are scratch.
pub fn run(
    model: &Model,
    state: &State,
    candidate: &[[u32; 2]],
    margin: &[f64],
    count: &mut Vec<u32>,
    points: &mut Vec<(u32, Point)>,
    contacts: &mut Contacts,
) {
    let meet = |i: usize, out: &mut [Point; MAX_POINTS]| {
        let [s, t] = candidate[i].map(|s| s as usize);
        collide(&placed(model, state, s), &placed(model, state, t), margin[s] + margin[t], out)
    };
    count.clear();
    count.resize(candidate.len() + 1, 0);
    let n = candidate.len();
    fill_rows(&mut count[..n], |i| meet(i, &mut [Point::default(); MAX_POINTS]) as u32);
    let n_contacts = gpu::scan::exclusive_cpu(count) as usize;
    points.resize(n_contacts, Default::default());
    scatter_rows(points, count, |i, out| {
        if !out.is_empty() {
            let mut found = [Point::default(); MAX_POINTS];
            let n = meet(i, &mut found);
            for (slot, point) in out.iter_mut().zip(&found[..n]) {
                *slot = (i as u32, *point);
            }
        }
    });
    write_columns(model, state, candidate, points, contacts);
    list_incident(model.n_bodies(), contacts);
}

fn placed(model: &Model, state: &State, shape: usize) -> Placed {
    let body = model.shape_body[shape] as usize;
    Placed {
        kind: model.shape_kind[shape],
        size: model.shape_size[shape],
        position: state.position[body],
        orientation: state.orientation[body],
    }
}

/// Points between shapes become contacts between bodies, A the body with the lower index.
fn write_columns(
    model: &Model,
    state: &State,
    candidate: &[[u32; 2]],
    points: &[(u32, Point)],
    contacts: &mut Contacts,
) {
    let n = points.len();
    let pair = |i: usize| candidate[points[i].0 as usize].map(|s| s as usize);
    let bodies = |i: usize| pair(i).map(|s| model.shape_body[s]);
    let swapped = |i: usize| bodies(i)[0] > bodies(i)[1];
    let end = |i: usize, second: bool| {
        let (_, point) = &points[i];
        let take_second = second != swapped(i);
        let body = bodies(i)[take_second as usize] as usize;
        (if take_second { point.on_second } else { point.on_first }) - state.position[body]
    };
    contacts.bodies.resize(n, [0; 2]);
    contacts.key.resize(n, [0; 3]);
    contacts.normal.resize(n, Default::default());
    contacts.arm_a.resize(n, Default::default());
    contacts.arm_b.resize(n, Default::default());
    contacts.gap.resize(n, 0.0);
    contacts.friction.resize(n, 0.0);
    fill_rows(&mut contacts.bodies, |i| {
        let [a, b] = bodies(i);
        [a.min(b), a.max(b)]
    });
    fill_rows(&mut contacts.key, |i| {
        let [s, t] = pair(i);
        [s as u32, t as u32, points[i].1.feature]
    });
    fill_rows(&mut contacts.normal, |i| if swapped(i) { -points[i].1.normal } else { points[i].1.normal });
    fill_rows(&mut contacts.arm_a, |i| end(i, false));
    fill_rows(&mut contacts.arm_b, |i| end(i, true));
    fill_rows(&mut contacts.gap, |i| points[i].1.gap);
    fill_rows(&mut contacts.friction, |i| {
        let [s, t] = pair(i);
        model.shape_friction[s].min(model.shape_friction[t])
    });
}

/// List the contacts of each body, in the contacts' order.
fn list_incident(n_bodies: usize, contacts: &mut Contacts) {
    let start = &mut contacts.incident_start;
    start.clear();
    start.resize(n_bodies + 1, 0);
    for body in contacts.bodies.iter().flatten() {
        start[*body as usize] += 1;
    }
    gpu::scan::exclusive_cpu(start);
    contacts.incident.resize(2 * contacts.bodies.len(), 0);
    for (i, pair) in contacts.bodies.iter().enumerate() {
        for (side, body) in pair.iter().enumerate() {
            let slot = &mut start[*body as usize];
            contacts.incident[*slot as usize] = 2 * i as u32 + side as u32;
            *slot += 1;
        }
    }
    // Each start has moved to the next body's: move them back by one.
    start.rotate_right(1);
    start[0] = 0;
}
