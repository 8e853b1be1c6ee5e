//! Write the contacts of every candidate pair, then list each body's contacts.
//! in   candidate  [n_candidates]  pairs of shapes
//!      margin     [n_shapes]      m
//! out  contacts   [n_contacts]    every column but the impulses
//! Source: paper §3, stages 7–9, on the pairs that `pair_write` kept.
//!
//! The contact point is the middle between the two surfaces, the same for both bodies, so that impulses keep the angular
//! momentum of the pair to round-off.

use super::PIECE;
use super::bounds::{self, Ball};
use super::collide::{MAX_POINTS, Placed, Point, Points, collide, collide_balls, collide_triangle, surface_of};
use super::pair_write::Candidates;
use crate::state::Arms;
use crate::{Contacts, Model, ShapeKind, State};
use glam::DVec3;
use rayon::prelude::*;

/// What the stage reads.
#[derive(Clone, Copy)]
pub struct Input<'a> {
    /// The model.
    pub model: &'a Model,
    /// The state.
    pub state: &'a State,
    /// How far from their surfaces contacts are looked for, m (n_shapes).
    pub margin: &'a [f32],
    /// The balls, if the model has balls only (n_shapes; else none).
    pub balls: &'a [Ball],
}

impl Input<'_> {
    /// A ball's centre and radius, m.
    #[inline(always)]
    fn ball(&self, s: usize) -> (DVec3, f64) {
        match self.balls.get(s) {
            Some(ball) => (ball.centre(), ball.reach() - self.margin[s] as f64),
            None => (self.model.shape_place(self.state, s).position, self.model.shape_size[s].x),
        }
    }

    /// Whether two balls are near enough.
    #[inline(always)]
    fn touch(&self, s: usize, t: usize) -> bool {
        if let (Some(a), Some(b)) = (self.balls.get(s), self.balls.get(t)) {
            let reach = a.reach() + b.reach();
            return (a.centre() - b.centre()).length_squared() <= reach * reach;
        }
        let ((a, r_a), (b, r_b)) = (self.ball(s), self.ball(t));
        let reach = r_a + r_b + (self.margin[s] + self.margin[t]) as f64;
        (a - b).length_squared() <= reach * reach
    }

    #[inline]
    fn tight(&self, s: usize) -> super::Aabb {
        bounds::tight(self.model, self.state, s, self.margin[s])
    }
}

/// What touches, of a piece of the candidates.
#[derive(Default)]
pub struct Touching {
    /// Candidates that touch, in order: two balls by their place in the piece, others by [`POINTS`] plus their place in `some`.
    who: Vec<u32>,
    /// Candidates that touch, not two balls: their place in the piece, their triangle and their range in `point`.
    some: Vec<[u32; 4]>,
    /// Points of those.
    point: Vec<Point>,
    /// Contacts of the piece.
    n: usize,
}

/// Set for candidates whose points are kept; those of two balls are cheaper to find again than to keep.
const POINTS: u32 = 1 << 31;

/// The stage. `touching` is scratch.
pub fn run(at: &Input, candidate: &[Candidates], touching: &mut Vec<Touching>, contacts: &mut Contacts) {
    touching.resize_with(candidate.len(), Touching::default);
    let few = candidate.iter().map(|c| c.pair.len()).sum::<usize>() < 4 * PIECE;
    let least = if few { candidate.len().max(1) } else { 1 };
    let pieces = touching.par_iter_mut().zip(candidate).with_min_len(least).with_max_len(least);
    pieces.for_each(|(touching, candidate)| touching.find(at, candidate));

    let n = touching.iter().map(|t| t.n).sum();
    contacts.bodies.resize(n, [0; 2]);
    contacts.key.resize(n, [0; 3]);
    contacts.normal.resize(n, DVec3::ZERO);
    contacts.gap.resize(n, 0.0);
    contacts.law.resize(n, 0);
    let Contacts { bodies, key, normal, gap, law, arms, .. } = contacts;
    let columns = (
        split(bodies, touching),
        split(key, touching),
        split(normal, touching),
        split(gap, touching),
        split(law, touching),
    );
    if !at.balls.is_empty() {
        if !matches!(arms, Arms::Along(_)) {
            *arms = Arms::Along(vec![]);
        }
        let Arms::Along(reach) = arms else { unreachable!("it was made so") };
        reach.resize(n, [0.0; 2]);
        // The contact point is half the gap away from a ball's surface.
        let reach_of = |body: u32, shape: u32, point: &Point| {
            let moves = at.model.inv_mass[body as usize] > 0.0;
            if moves { at.ball(shape as usize).1 + 0.5 * point.gap } else { 0.0 }
        };
        let arms_of =
            |[a, b]: [u32; 2], [s, t]: [u32; 2], point: &Point| [reach_of(a, s, point), reach_of(b, t, point)];
        write(at, candidate, touching, least, columns, split(reach, touching), arms_of);
    } else {
        if !matches!(arms, Arms::Any(_)) {
            *arms = Arms::Any(vec![]);
        }
        let Arms::Any(arms) = arms else { unreachable!("it was made so") };
        arms.resize(n, [DVec3::ZERO; 2]);
        let arms_of = |bodies: [u32; 2], _, point: &Point| {
            let middle = 0.5 * (point.on_first + point.on_second);
            bodies.map(|b| middle - at.state.position[b as usize])
        };
        write(at, candidate, touching, least, columns, split(arms, touching), arms_of);
    }
    list_incident(at.model.n_bodies(), contacts);
}

/// The columns but the arms, cut as the pieces are.
type Columns<'a> =
    (Vec<&'a mut [[u32; 2]]>, Vec<&'a mut [[u32; 3]]>, Vec<&'a mut [DVec3]>, Vec<&'a mut [f64]>, Vec<&'a mut [u32]>);

/// Write the columns; `arms_of` makes the arms of two bodies with their shapes that touch in a point.
fn write<A: Send>(
    at: &Input,
    candidate: &[Candidates],
    touching: &[Touching],
    least: usize,
    (bodies, key, normal, gap, law): Columns,
    arms: Vec<&mut [A]>,
    arms_of: impl Fn([u32; 2], [u32; 2], &Point) -> A + Sync,
) {
    (touching.par_iter().zip(candidate), bodies, key, normal, gap, law, arms)
        .into_par_iter()
        .with_min_len(least)
        .with_max_len(least)
        .for_each(|((touching, candidate), bodies, key, normal, gap, law, arms)| {
            let mut i = 0;
            touching.each(at, candidate, |[s, t], triangle, point| {
                let (a, b) = (at.model.shape_body[s as usize], at.model.shape_body[t as usize]);
                let turned = a > b;
                let (pair, shapes) = if turned { ([b, a], [t, s]) } else { ([a, b], [s, t]) };
                bodies[i] = pair;
                key[i] = [s, t, (triangle << 17) ^ point.feature];
                normal[i] = if turned { -point.normal } else { point.normal };
                gap[i] = point.gap;
                law[i] = at.model.law(s as usize, t as usize);
                arms[i] = arms_of(pair, shapes, point);
                i += 1;
            });
        });
}

impl Touching {
    /// Find which candidates touch, and where.
    fn find(&mut self, at: &Input, candidate: &Candidates) {
        self.who.clear();
        self.some.clear();
        self.point.clear();
        let mut out = [Point::default(); MAX_POINTS];
        let mut triangles = candidate.triangle.iter().peekable();
        for (k, pair) in candidate.pair.iter().enumerate() {
            let [s, t] = pair.map(|s| s as usize);
            let triangle = triangles.next_if(|own| own[0] as usize == k).map_or(0, |own| own[1]);
            if are_balls(at.model, s, t) {
                if at.touch(s, t) {
                    self.who.push(k as u32);
                }
            } else if at.tight(s).overlaps(&at.tight(t)) {
                let n = points(at, *pair, triangle, &mut out);
                if n > 0 {
                    self.who.push(POINTS | self.some.len() as u32);
                    let first = self.point.len() as u32;
                    self.some.push([k as u32, triangle, first, first + n as u32]);
                    self.point.extend_from_slice(&out[..n]);
                }
            }
        }
        self.n = self.who.len() - self.some.len() + self.point.len();
    }

    /// Visit the contacts of the piece in order; normals point from the first shape to the second.
    #[inline]
    fn each(&self, at: &Input, candidate: &Candidates, mut visit: impl FnMut([u32; 2], u32, &Point)) {
        for who in &self.who {
            let ball;
            let (pair, triangle, points) = if who & POINTS == 0 {
                let pair = candidate.pair[*who as usize];
                ball = [collide_balls(at.ball(pair[0] as usize), at.ball(pair[1] as usize))];
                (pair, 0, &ball[..])
            } else {
                let [k, triangle, first, end] = self.some[(who ^ POINTS) as usize];
                (candidate.pair[k as usize], triangle, &self.point[first as usize..end as usize])
            };
            points.iter().for_each(|p| visit(pair, triangle, p));
        }
    }
}

#[inline]
fn are_balls(model: &Model, s: usize, t: usize) -> bool {
    model.shape_kind[s] == ShapeKind::Sphere && model.shape_kind[t] == ShapeKind::Sphere
}

/// The points of a candidate.
fn points(at: &Input, [s, t]: [u32; 2], triangle: u32, out: &mut Points) -> usize {
    let (model, s, t) = (at.model, s as usize, t as usize);
    let reach = (at.margin[s] + at.margin[t]) as f64;
    let [a, b] = [s, t].map(|s| Placed::of(model, &model.shape_place(at.state, s), s));
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

/// List the contacts of each body, in the contacts' order. Each thread looks at all contacts for a range of bodies.
fn list_incident(n_bodies: usize, contacts: &mut Contacts) {
    let Contacts { bodies, incident_start: start, incident, .. } = contacts;
    let n_ranges = if bodies.len() < 4 * PIECE { 1 } else { rayon::current_num_threads().min(8) };
    let length = n_bodies.div_ceil(n_ranges).max(1);
    start.clear();
    start.resize(n_bodies + 1, 0);
    start[..n_bodies].par_chunks_mut(length).enumerate().for_each(|(range, count)| {
        let first = range * length;
        for body in bodies.iter().flatten() {
            if let Some(count) = (*body as usize).checked_sub(first).and_then(|b| count.get_mut(b)) {
                *count += 1;
            }
        }
    });
    gpu::scan::exclusive_cpu(start);
    incident.resize(2 * bodies.len(), 0);
    let mut rest = &mut incident[..];
    let mut ranges = vec![];
    for (range, slots) in start[..n_bodies].chunks(length).enumerate() {
        let end = start[((range + 1) * length).min(n_bodies)];
        let (own, after) = std::mem::take(&mut rest).split_at_mut((end - slots[0]) as usize);
        rest = after;
        ranges.push((slots[0], own));
    }
    start[..n_bodies].par_chunks_mut(length).zip(ranges).enumerate().for_each(|(range, (slot, (base, own)))| {
        let first = range * length;
        for (i, pair) in bodies.iter().enumerate() {
            for (side, body) in pair.iter().enumerate() {
                if let Some(slot) = (*body as usize).checked_sub(first).and_then(|b| slot.get_mut(b)) {
                    own[(*slot - base) as usize] = 2 * i as u32 + side as u32;
                    *slot += 1;
                }
            }
        }
    });
    // Each start has moved to the next body's: move them back by one.
    start.rotate_right(1);
    start[0] = 0;
}
