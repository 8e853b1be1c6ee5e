//! Write the contacts of every candidate pair, then list each body's contacts.
//! in   candidate  [n_candidates]  pairs of shapes
//!      place      [n_shapes]
//!      margin     [n_shapes]      m
//! out  contacts   [n_contacts]    every column but the impulses
//! Source: paper §3, stages 7–9, on the pairs that `pair_write` kept.
//!
//! The contact point is the middle between the two surfaces, the same for both bodies, so that impulses keep the angular
//! momentum of the pair to round-off.

use super::collide::{MAX_POINTS, Placed, Point, Points, collide, collide_balls, collide_triangle, surface_of};
use super::pair_write::Candidate;
use super::{Aabb, PIECE};
use crate::{Contacts, Model, Pose, ShapeKind, State};
use glam::DVec3;
use rayon::prelude::*;

/// What the stage reads.
#[derive(Clone, Copy)]
pub struct Input<'a> {
    /// The model.
    pub model: &'a Model,
    /// The state.
    pub state: &'a State,
    /// Where the shapes are (n_shapes).
    pub place: &'a [Pose],
    /// How far from their surfaces contacts are looked for, m (n_shapes).
    pub margin: &'a [f64],
    /// Boxes (n_shapes).
    pub aabb: &'a [Aabb],
}

/// What touches, of a piece of the candidates.
#[derive(Default)]
pub struct Touching {
    /// Candidates that touch, in order: two balls by their place in the piece, others by [`POINTS`] plus their place in `some`.
    who: Vec<u32>,
    /// Candidates that touch, not two balls: their place in the piece and their range in `point`.
    some: Vec<[u32; 3]>,
    /// Points of those.
    point: Vec<Point>,
    /// Contacts of the piece.
    n: usize,
}

/// Set for candidates whose points are kept; those of two balls are cheaper to find again than to keep.
const POINTS: u32 = 1 << 31;

/// The stage. `touching` is scratch.
pub fn run(at: &Input, candidate: &[Vec<Candidate>], touching: &mut Vec<Touching>, contacts: &mut Contacts) {
    touching.resize_with(candidate.len(), Touching::default);
    let few = candidate.iter().map(Vec::len).sum::<usize>() < 4 * PIECE;
    let least = if few { candidate.len().max(1) } else { 1 };
    let pieces = touching.par_iter_mut().zip(candidate).with_min_len(least).with_max_len(least);
    pieces.for_each(|(touching, candidate)| touching.find(at, candidate));

    let n = touching.iter().map(|t| t.n).sum();
    contacts.bodies.resize(n, [0; 2]);
    contacts.key.resize(n, [0; 3]);
    contacts.normal.resize(n, DVec3::ZERO);
    contacts.arm_a.resize(n, DVec3::ZERO);
    contacts.arm_b.resize(n, DVec3::ZERO);
    contacts.gap.resize(n, 0.0);
    contacts.law.resize(n, 0);
    (
        touching.par_iter().zip(candidate),
        split(&mut contacts.bodies, touching),
        split(&mut contacts.key, touching),
        split(&mut contacts.normal, touching),
        split(&mut contacts.arm_a, touching),
        split(&mut contacts.arm_b, touching),
        split(&mut contacts.gap, touching),
        split(&mut contacts.law, touching),
    )
        .into_par_iter()
        .with_min_len(least)
        .with_max_len(least)
        .for_each(|((touching, candidate), bodies, key, normal, arm_a, arm_b, gap, law)| {
            let mut i = 0;
            touching.each(at, candidate, |[s, t, triangle], point| {
                let (a, b) = (at.model.shape_body[s as usize], at.model.shape_body[t as usize]);
                let (low, high) = (a.min(b), a.max(b));
                let middle = 0.5 * (point.on_first + point.on_second);
                bodies[i] = [low, high];
                key[i] = [s, t, (triangle << 17) ^ point.feature];
                normal[i] = if a > b { -point.normal } else { point.normal };
                arm_a[i] = middle - at.state.position[low as usize];
                arm_b[i] = middle - at.state.position[high as usize];
                gap[i] = point.gap;
                law[i] = at.model.law(s as usize, t as usize);
                i += 1;
            });
        });
    list_incident(at.model.n_bodies(), contacts);
}

impl Touching {
    /// Find which candidates touch, and where.
    fn find(&mut self, at: &Input, candidate: &[Candidate]) {
        self.who.clear();
        self.some.clear();
        self.point.clear();
        let mut out = [Point::default(); MAX_POINTS];
        for (k, pair) in candidate.iter().enumerate() {
            let [s, t] = [pair[0] as usize, pair[1] as usize];
            if are_balls(at.model, s, t) {
                let touch = at.model.shape_size[s].x + at.model.shape_size[t].x + at.margin[s] + at.margin[t];
                if (at.place[s].position - at.place[t].position).length_squared() <= touch * touch {
                    self.who.push(k as u32);
                }
            } else if at.aabb[s].overlaps(&at.aabb[t]) {
                let n = points(at, *pair, &mut out);
                if n > 0 {
                    self.who.push(POINTS | self.some.len() as u32);
                    let first = self.point.len() as u32;
                    self.some.push([k as u32, first, first + n as u32]);
                    self.point.extend_from_slice(&out[..n]);
                }
            }
        }
        self.n = self.who.len() - self.some.len() + self.point.len();
    }

    /// Visit the contacts of the piece in order; normals point from the first shape to the second.
    #[inline]
    fn each(&self, at: &Input, candidate: &[Candidate], mut visit: impl FnMut(Candidate, &Point)) {
        for who in &self.who {
            if who & POINTS == 0 {
                let pair = candidate[*who as usize];
                let ball = |s: u32| (&at.place[s as usize].position, at.model.shape_size[s as usize].x);
                visit(pair, &collide_balls(ball(pair[0]), ball(pair[1])));
            } else {
                let [k, first, end] = self.some[(who ^ POINTS) as usize];
                self.point[first as usize..end as usize].iter().for_each(|p| visit(candidate[k as usize], p));
            }
        }
    }
}

#[inline]
fn are_balls(model: &Model, s: usize, t: usize) -> bool {
    model.shape_kind[s] == ShapeKind::Sphere && model.shape_kind[t] == ShapeKind::Sphere
}

/// The points of a candidate.
fn points(at: &Input, [s, t, triangle]: Candidate, out: &mut Points) -> usize {
    let (model, s, t) = (at.model, s as usize, t as usize);
    let reach = at.margin[s] + at.margin[t];
    let [a, b] = [s, t].map(|s| Placed::of(model, &at.place[s], s));
    if let Some(surface) = surface_of(model, t) {
        let corners = surface.corners(triangle).map(|v| b.position + b.orientation * v);
        collide_triangle(&a, corners, surface.sharp[triangle as usize], reach, out)
    } else if let Some(surface) = surface_of(model, s) {
        let corners = surface.corners(triangle).map(|v| a.position + a.orientation * v);
        let n = collide_triangle(&b, corners, surface.sharp[triangle as usize], reach, out);
        out[..n].iter_mut().for_each(|p| p.normal = -p.normal);
        n
    } else {
        collide(&a, &b, reach, out)
    }
}

/// Cut a column as the pieces are cut.
fn split<'a, T>(mut column: &'a mut [T], pieces: &[Touching]) -> Vec<&'a mut [T]> {
    pieces
        .iter()
        .map(|piece| {
            let (own, rest) = std::mem::take(&mut column).split_at_mut(piece.n);
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
