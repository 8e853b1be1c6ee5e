//! Write the contacts of every candidate pair, then list each body's contacts.
//! in   candidate  [n_candidates]  pairs of shapes
//!      place      [n_shapes]
//!      margin     [n_shapes]      m
//! out  contacts   [n_contacts]    every column but the impulses
//! Source: paper §3, stages 7–9, on the pairs that `pair_write` kept.
//!
//! The contact point is the middle between the two surfaces, the same for both bodies, so that impulses keep the angular
//! momentum of the pair to round-off.

use super::collide::{MAX_POINTS, Placed, Point, collide, collide_triangle, surface_of};
use super::pair_write::Candidate;
use super::{Pieces, collect_pieces};
use crate::{Contacts, Model, Pose, ShapeKind, State};
use glam::DVec3;
use rayon::prelude::*;

/// A contact as it is found.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    bodies: [u32; 2],
    key: [u32; 3],
    normal: DVec3,
    arm_a: DVec3,
    arm_b: DVec3,
    gap: f64,
    law: u32,
}

/// The stage. `pieces` is scratch.
pub fn run(
    model: &Model,
    state: &State,
    candidate: &[Candidate],
    place: &[Pose],
    margin: &[f64],
    pieces: &mut Pieces<Found>,
    contacts: &mut Contacts,
) {
    collect_pieces(candidate.len(), pieces, |i, found| meet(model, state, candidate[i], place, margin, found));
    write_columns(pieces, contacts);
    list_incident(model.n_bodies(), contacts);
}

/// The contacts of one candidate.
#[inline]
fn meet(model: &Model, state: &State, candidate: Candidate, place: &[Pose], margin: &[f64], found: &mut Vec<Found>) {
    let [s, t, triangle] = candidate;
    let (s, t) = (s as usize, t as usize);
    let reach = margin[s] + margin[t];
    let both = model.shape_kind[s] == ShapeKind::Sphere && model.shape_kind[t] == ShapeKind::Sphere;
    if both {
        // Most candidates are balls, and most of those do not touch: out again at once.
        let touch = model.shape_size[s].x + model.shape_size[t].x + reach;
        if (place[s].position - place[t].position).length_squared() > touch * touch {
            return;
        }
    }
    let mut out = [Point::default(); MAX_POINTS];
    let (a, b) = (Placed::of(model, &place[s], s), Placed::of(model, &place[t], t));
    let mut swap = model.shape_body[s] > model.shape_body[t];
    let n = if let Some(surface) = surface_of(model, t) {
        let corners = surface.corners(triangle).map(|v| b.position + b.orientation * v);
        collide_triangle(&a, corners, surface.sharp[triangle as usize], reach, &mut out)
    } else if let Some(surface) = surface_of(model, s) {
        let corners = surface.corners(triangle).map(|v| a.position + a.orientation * v);
        swap = !swap;
        collide_triangle(&b, corners, surface.sharp[triangle as usize], reach, &mut out)
    } else {
        collide(&a, &b, reach, &mut out)
    };
    let (low, high) = (model.shape_body[s].min(model.shape_body[t]), model.shape_body[s].max(model.shape_body[t]));
    for point in &out[..n] {
        let middle = 0.5 * (point.on_first + point.on_second);
        found.push(Found {
            bodies: [low, high],
            key: [s as u32, t as u32, (triangle << 17) ^ point.feature],
            normal: if swap { -point.normal } else { point.normal },
            arm_a: middle - state.position[low as usize],
            arm_b: middle - state.position[high as usize],
            gap: point.gap,
            law: model.law(s, t),
        });
    }
}

/// The pieces' contacts, one after the other, into columns.
fn write_columns(pieces: &Pieces<Found>, contacts: &mut Contacts) {
    let pieces = pieces.filled();
    let n = pieces.iter().map(Vec::len).sum();
    contacts.bodies.resize(n, [0; 2]);
    contacts.key.resize(n, [0; 3]);
    contacts.normal.resize(n, DVec3::ZERO);
    contacts.arm_a.resize(n, DVec3::ZERO);
    contacts.arm_b.resize(n, DVec3::ZERO);
    contacts.gap.resize(n, 0.0);
    contacts.law.resize(n, 0);
    (
        pieces,
        split(&mut contacts.bodies, pieces),
        split(&mut contacts.key, pieces),
        split(&mut contacts.normal, pieces),
        split(&mut contacts.arm_a, pieces),
        split(&mut contacts.arm_b, pieces),
        split(&mut contacts.gap, pieces),
        split(&mut contacts.law, pieces),
    )
        .into_par_iter()
        .with_min_len(8)
        .for_each(|(piece, bodies, key, normal, arm_a, arm_b, gap, law)| {
            for (i, c) in piece.iter().enumerate() {
                (bodies[i], key[i], normal[i]) = (c.bodies, c.key, c.normal);
                (arm_a[i], arm_b[i], gap[i], law[i]) = (c.arm_a, c.arm_b, c.gap, c.law);
            }
        });
}

/// Cut a column as the pieces are cut.
fn split<'a, T, U>(mut column: &'a mut [T], pieces: &[Vec<U>]) -> Vec<&'a mut [T]> {
    pieces
        .iter()
        .map(|piece| {
            let (own, rest) = std::mem::take(&mut column).split_at_mut(piece.len());
            column = rest;
            own
        })
        .collect()
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
