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
use crate::state::{Arms, Incident};
use crate::{Contacts, Model, ShapeKind, State};
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

/// What touches, of a piece of the candidates.
#[derive(Default)]
pub struct Touching {
    /// Two balls, by their place in the piece; where they touch is cheaper to find again than to keep.
    balls: Vec<u32>,
    /// Others: their place in the piece and the end of their points in `point`.
    others: Vec<[u32; 2]>,
    /// Points of those.
    point: Vec<Point>,
}

impl Touching {
    /// Contacts of the piece.
    fn len(&self) -> usize {
        self.balls.len() + self.point.len()
    }
}

/// The stage. `touching` is scratch.
pub fn run(at: &Input, candidate: &[Candidates], touching: &mut Vec<Touching>, contacts: &mut Contacts) {
    let arms = std::mem::take(&mut contacts.arms);
    if at.balls.is_empty() {
        let middle = |bodies: [u32; 2], point: &Point, _| {
            let middle = 0.5 * (point.on_first + point.on_second);
            bodies.map(|b| middle - at.state.position[b as usize])
        };
        let mut arms = if let Arms::Any(arms) = arms { arms } else { vec![] };
        let ball = |s: u32| Ball::of(at.model, at.state, s as usize, at.margin[s as usize]);
        find_and_write(at, ball, candidate, touching, contacts, &mut arms, middle);
        contacts.arms = Arms::Any(arms);
    } else {
        // The contact point is half the gap away from a ball's surface.
        let along = |_, point: &Point, radii: [f64; 2]| radii.map(|r| r + 0.5 * point.gap);
        let mut arms = if let Arms::Along(arms) = arms { arms } else { vec![] };
        let ball = |s: u32| at.balls[s as usize];
        find_and_write(at, ball, candidate, touching, contacts, &mut arms, along);
        contacts.arms = Arms::Along(arms);
    }
    let Contacts { bodies, incident: Incident { start, list }, .. } = contacts;
    // Two sides a contact: side k is that of body k % 2 of contact k / 2.
    let sides = || bodies.as_flattened().iter().enumerate().map(|(k, body)| (*body, k as u32));
    gpu::radix_sort::distribute_cpu(at.model.n_bodies(), sides, start, list);
}

/// The stage, but for the lists of the bodies. `ball` gives a shape that is a ball; `arms_of` makes the arms of two bodies
/// that touch in a point, of which those that are balls have the radii given.
fn find_and_write<A: Copy + Default + Send>(
    at: &Input,
    ball: impl Fn(u32) -> Ball + Sync,
    candidate: &[Candidates],
    touching: &mut Vec<Touching>,
    contacts: &mut Contacts,
    arms: &mut Vec<A>,
    arms_of: impl Fn([u32; 2], &Point, [f64; 2]) -> A + Sync,
) {
    touching.resize_with(candidate.len(), Touching::default);
    let few = candidate.iter().map(|c| c.len()).sum::<usize>() < 4 * PIECE;
    let least = if few { candidate.len().max(1) } else { 1 };
    let pieces = touching.par_iter_mut().zip(candidate).with_min_len(least).with_max_len(least);
    pieces.for_each(|(touching, candidate)| {
        touching.find_balls(&candidate.balls, &ball);
        touching.find_others(at, &candidate.others);
    });

    let n = touching.iter().map(|t| t.len()).sum();
    let Contacts { bodies, key, normal, gap, law, .. } = contacts;
    let columns = (
        touching.par_iter().zip(candidate),
        split(bodies, n, touching),
        split(key, n, touching),
        split(normal, n, touching),
        split(gap, n, touching),
        split(law, n, touching),
        split(arms, n, touching),
    );
    let n_materials = at.model.material_names.len() as u32;
    columns.into_par_iter().with_min_len(least).with_max_len(least).for_each(
        |((touching, candidate), bodies, key, normal, gap, law, arms)| {
            let mut i = 0;
            touching.each(candidate, &ball, at.model, |[p, q], key_of_pair, point| {
                let turned = p.body > q.body;
                let radii = if turned { [q.radius, p.radius] } else { [p.radius, q.radius] };
                bodies[i] = if turned { [q.body, p.body] } else { [p.body, q.body] };
                key[i] = key_of_pair;
                normal[i] = if turned { -point.normal } else { point.normal };
                gap[i] = point.gap;
                law[i] = p.material * n_materials + q.material;
                arms[i] = arms_of(bodies[i], point, radii);
                i += 1;
            });
        },
    );
}

impl Touching {
    /// Find which balls touch.
    #[inline(always)]
    fn find_balls(&mut self, pairs: &[[u32; 2]], ball: impl Fn(u32) -> Ball) {
        /// Pairs whose answers are gathered without asking: nothing foretells them.
        const BLOCK: usize = 64;
        self.balls.clear();
        for (block, pairs) in pairs.chunks(BLOCK).enumerate() {
            let (mut found, mut n) = ([0; BLOCK], 0);
            for (k, [s, t]) in pairs.iter().enumerate() {
                let (p, q) = (ball(*s), ball(*t));
                let reach = p.reach + q.reach;
                found[n] = (block * BLOCK + k) as u32;
                n += ((p.centre - q.centre).length_squared() <= reach * reach) as usize;
            }
            self.balls.extend_from_slice(&found[..n]);
        }
    }

    /// Find which of the other candidates touch, and where.
    fn find_others(&mut self, at: &Input, candidates: &[[u32; 3]]) {
        self.others.clear();
        self.point.clear();
        let tight = |s: u32| bounds::tight(at.model, at.state, s as usize, at.margin[s as usize]);
        let mut out = [Point::default(); MAX_POINTS];
        for (k, &[s, t, triangle]) in candidates.iter().enumerate() {
            if tight(s).overlaps(&tight(t)) {
                let n = points(at, [s, t], triangle, &mut out);
                if n > 0 {
                    self.point.extend_from_slice(&out[..n]);
                    self.others.push([k as u32, self.point.len() as u32]);
                }
            }
        }
    }

    /// Visit the contacts of the piece in order, each with its two shapes as far as balls go, its key and its point; normals
    /// point from the first shape to the second.
    #[inline(always)]
    fn each(
        &self,
        candidate: &Candidates,
        ball: impl Fn(u32) -> Ball,
        model: &Model,
        mut visit: impl FnMut([Ball; 2], [u32; 3], &Point),
    ) {
        for k in &self.balls {
            let pair = candidate.balls[*k as usize];
            let [p, q] = pair.map(&ball);
            let point = collide_balls((p.centre, p.radius), (q.centre, q.radius));
            visit([p, q], [pair[0], pair[1], point.feature], &point);
        }
        let mut first = 0;
        for [k, end] in &self.others {
            let [s, t, triangle] = candidate.others[*k as usize];
            let both = [s, t].map(|s| {
                let (s, is_ball) = (s as usize, model.shape_kind[s as usize] == ShapeKind::Sphere);
                let radius = if is_ball { model.shape_size[s].x } else { 0.0 };
                Ball { radius, body: model.shape_body[s], material: model.shape_material[s], ..Ball::default() }
            });
            for point in &self.point[first..*end as usize] {
                visit(both, [s, t, (triangle << 17) ^ point.feature], point);
            }
            first = *end as usize;
        }
    }
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

/// Make room for `n` rows in a column, and cut it as the pieces are cut.
fn split<'a, T: Clone + Default>(column: &'a mut Vec<T>, n: usize, pieces: &[Touching]) -> Vec<&'a mut [T]> {
    column.resize(n, T::default());
    let mut rest = &mut column[..];
    pieces
        .iter()
        .map(|piece| {
            let (own, after) = std::mem::take(&mut rest).split_at_mut(piece.len());
            rest = after;
            own
        })
        .collect()
}
