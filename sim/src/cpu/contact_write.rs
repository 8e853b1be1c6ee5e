//! Write the contacts of every candidate pair.
//! in   candidate  [n_candidates]  pairs of shapes
//!      margin     [n_shapes]      m
//! out  contacts   [n_contacts]    every column but the impulses
//! Source: paper §3, stages 7–9, on the pairs that `pair_write` kept.
//!
//! The contact point is the middle between the two surfaces, the same for both bodies, so that impulses keep the angular
//! momentum of the pair to round-off.

use super::bounds::{self, Ball};
use super::collide::{MAX_POINTS, Placed, Point, Points, collide, collide_triangle, surface_of};
use super::contact_rows::{Rows, along};
use super::pair_write::Pairs;
use super::{PIECE, ball_pairs, cut};
use crate::lanes::widest;
use crate::state::{Arms, Tiles};
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

/// Which candidates touch.
#[derive(Default)]
pub struct Touching {
    /// Two balls; where they touch is cheaper to find again than to keep.
    pub balls: Balls,
    /// Others, piece by piece.
    others: Vec<Others>,
}

/// Candidates of two balls that touch, piece by piece.
#[derive(Default)]
pub struct Balls {
    /// Their places in the piece, rising; there is room for all of a piece's candidates.
    place: Vec<u32>,
    room: Vec<usize>,
    /// How many there are in each piece.
    n: Vec<usize>,
}

impl Balls {
    /// Their places, piece by piece.
    pub fn pieces(&self) -> Vec<&[u32]> {
        let mut rest = &self.place[..];
        let piece = |(room, n): (&usize, &usize)| {
            let (own, after) = rest.split_at(*room);
            rest = after;
            &own[..*n]
        };
        self.room.iter().zip(&self.n).map(piece).collect()
    }
}

/// Other candidates of a piece.
#[derive(Default)]
struct Others {
    /// Those that touch: their place in the piece and the end of their points in `point`.
    some: Vec<[u32; 2]>,
    point: Vec<Point>,
}

impl Touching {
    /// Contacts of each piece.
    pub fn lengths(&self) -> impl Iterator<Item = usize> {
        self.balls.n.iter().zip(&self.others).map(|(n, others)| n + others.point.len())
    }
}

/// The stage. `touching` is scratch.
pub fn run(at: &Input, candidate: &Pairs, touching: &mut Touching, contacts: &mut Contacts) {
    contacts.arms = match std::mem::take(&mut contacts.arms) {
        arms if at.balls.is_empty() => {
            let mut arms = if let Arms::Any(arms) = arms { arms } else { vec![] };
            let middle = |bodies: [u32; 2], point: &Point, _: [f64; 2]| {
                let middle = 0.5 * (point.on_first + point.on_second);
                bodies.map(|b| middle - at.state.position[b as usize])
            };
            let ball = |s: u32| Ball::of(at.model, at.state, s as usize, at.margin[s as usize]);
            let find = |pairs: &[[u32; 2]], place: &mut [u32]| find_balls(pairs, ball, place);
            let write = |pairs: &[[u32; 2]], places: &[u32], rows: &mut Rows<_>| {
                for (i, place) in places.iter().enumerate() {
                    let pair = pairs[*place as usize];
                    rows.put_balls(i, pair, pair.map(ball), middle);
                }
            };
            find_and_write(at, candidate, touching, contacts, &mut arms, (find, write, middle));
            Arms::Any(arms)
        }
        arms => {
            let mut arms = if let Arms::Along(arms) = arms { arms } else { vec![] };
            let balls = at.balls;
            let find = |pairs: &[[u32; 2]], place: &mut [u32]| widest(ball_pairs::Find { pairs, balls, place });
            let write = |pairs: &[[u32; 2]], places: &[u32], rows: &mut Rows<_>| {
                widest(ball_pairs::Write { pairs, places, balls, rows })
            };
            find_and_write(at, candidate, touching, contacts, &mut arms, (find, write, along));
            Arms::Along(arms)
        }
    };
    let first = touching.lengths().scan(0, |first, n| {
        *first += n as u32;
        Some(*first - n as u32)
    });
    contacts.tiles = Tiles { start: first.collect(), n_first: candidate.n_first };
}

/// The stage, but for the tiles: `find` puts the places of balls that touch into a column and returns how many, `write` writes
/// their contacts, and `arms_of` makes the arms of the others.
fn find_and_write<A: Copy + Default + Send>(
    at: &Input,
    candidate: &Pairs,
    touching: &mut Touching,
    contacts: &mut Contacts,
    arms: &mut Vec<A>,
    (find, write, arms_of): (
        impl Fn(&[[u32; 2]], &mut [u32]) -> usize + Sync,
        impl Fn(&[[u32; 2]], &[u32], &mut Rows<A>) + Sync,
        impl Fn([u32; 2], &Point, [f64; 2]) -> A + Sync,
    ),
) {
    let pieces = &candidate.pieces;
    let Touching { balls, others } = touching;
    others.resize_with(pieces.len(), Others::default);
    balls.n.resize(pieces.len(), 0);
    balls.room.clear();
    balls.room.extend(pieces.iter().map(|piece| piece.balls.len()));
    balls.place.resize(balls.room.iter().sum(), 0);
    let least = if pieces.iter().map(|piece| piece.len()).sum::<usize>() < 4 * PIECE { pieces.len().max(1) } else { 1 };
    let rooms = cut(&mut balls.place, balls.room.iter().copied());
    let each = (rooms, &mut balls.n, others, pieces).into_par_iter().with_min_len(least).with_max_len(least);
    each.for_each(|(room, n, others, piece)| {
        *n = find(&piece.balls, room);
        others.find(at, &piece.others);
    });

    let Contacts { bodies, key, normal, gap, law, .. } = contacts;
    let places = touching.balls.pieces();
    let columns = (
        (pieces, places, &touching.others).into_par_iter(),
        split(bodies, touching),
        split(key, touching),
        split(normal, touching),
        split(gap, touching),
        split(law, touching),
        split(arms, touching),
    );
    let n_materials = at.model.material_names.len() as u32;
    columns.into_par_iter().with_min_len(least).with_max_len(least).for_each(
        |((piece, places, others), bodies, key, normal, gap, law, arms)| {
            let mut rows = Rows { bodies, key, normal, gap, law, arms, n_materials };
            write(&piece.balls, places, &mut rows);
            let mut i = places.len();
            others.each(at.model, &piece.others, |pair, key, point| {
                rows.put(i, pair, key, point, &arms_of);
                i += 1;
            });
        },
    );
}

/// Find which of any balls touch, as [`ball_pairs::Find`] does.
fn find_balls(pairs: &[[u32; 2]], ball: impl Fn(u32) -> Ball, place: &mut [u32]) -> usize {
    let mut n = 0;
    for (k, [s, t]) in pairs.iter().enumerate() {
        place[n] = k as u32;
        n += ball(*s).is_near(&ball(*t)) as usize;
    }
    n
}

impl Others {
    /// Find which of the other candidates touch, and where.
    fn find(&mut self, at: &Input, candidates: &[[u32; 3]]) {
        self.some.clear();
        self.point.clear();
        let tight = |s: u32| bounds::tight(at.model, at.state, s as usize, at.margin[s as usize]);
        let mut out = [Point::default(); MAX_POINTS];
        for (k, &[s, t, triangle]) in candidates.iter().enumerate() {
            if tight(s).overlaps(&tight(t)) {
                let n = points(at, [s, t], triangle, &mut out);
                if n > 0 {
                    self.point.extend_from_slice(&out[..n]);
                    self.some.push([k as u32, self.point.len() as u32]);
                }
            }
        }
    }

    /// Visit the contacts in order, each with its two shapes as far as balls go, its key and its point; normals point from the
    /// first shape to the second.
    fn each(&self, model: &Model, candidates: &[[u32; 3]], mut visit: impl FnMut([Ball; 2], [u32; 3], &Point)) {
        let mut first = 0;
        for [k, end] in &self.some {
            let [s, t, triangle] = candidates[*k as usize];
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

/// Make room for the contacts in a column, and cut it as the pieces are cut.
fn split<'a, T: Clone + Default>(column: &'a mut Vec<T>, touching: &Touching) -> Vec<&'a mut [T]> {
    column.resize(touching.lengths().sum(), T::default());
    cut(column, touching.lengths())
}
