//! Narrow phase: write the contacts of the candidate pairs.
//! in   position           [n_bodies]       m
//! in   orientation        [n_bodies]
//! in   margin             [n_shapes]       m
//! in   tight_aabb         [n_shapes]       m, where the plan has any shapes
//! in   sphere             [n_shapes]       where the plan has spheres only
//! in   sphere_pair_start  [n_tiles + 2]
//! in   sphere_pair        [n_sphere_pairs]
//! in   other_pair_start   [n_tiles + 2]
//! in   other_pair         [n_other_pairs]
//! out  contact_start      [n_tiles + 2]
//! out  contact_bodies     [n_contacts]
//! out  contact_key        [n_contacts]
//! out  contact_pair       [n_contacts]
//! out  contact_normal     [n_contacts]
//! out  contact_arms       [n_contacts]     m, where the plan has any shapes
//! out  contact_reach      [n_contacts]     m, where it has spheres only
//! out  contact_gap        [n_contacts]     m
//! out  contact_law        [n_contacts]
//! Source: paper §3, stages 7–9, on the pairs of `pair_write`.
//!
//! The contact point is the middle between the two surfaces, the same for both bodies, so that impulses keep the angular
//! momentum of the pair to round-off. Contacts are counted part by part of the tiles, the counts scanned, and the rows written.

use super::collide::convex::Axis;
use super::collide::point::{MAX_POINTS, Placed, Point, Points, swap_shapes};
use super::collide::rolling::is_curved;
use super::collide::{Triangle, Way, collide, collide_triangle, pass, surface_of};
use super::contact_rows::{Rows, along};
use super::pair_write::Pairs;
use super::recycle::{Last, collide_or_recycle, keeps};
use super::{bounds, sphere_pairs};
use crate::aabb::Aabb;
use crate::contacts::{Arms, Contacts, OTHER, Tiles};
use crate::lanes::widest;
use crate::manifolds::{Manifolds, PartManifolds};
use crate::model::Model;
use crate::plan::{Narrow, StepPlan};
use crate::rows::{CHUNK, cut, fill_rows};
use crate::shape::ShapeKind;
use crate::sphere::Sphere;
use crate::state::State;
use crate::twist::Twist;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// The input of the stage.
pub struct Input<'a> {
    /// The model.
    pub model: &'a Model,
    /// The plan of the step.
    pub plan: &'a StepPlan,
    /// The state.
    pub state: &'a State,
    /// Distance from the shapes' surfaces within which contacts are generated, m (n_shapes).
    pub margin: &'a [f32],
    /// Tight AABBs, m, where the plan has any shapes (n_shapes).
    pub tight: &'a [Aabb],
    /// The spheres, where the plan has spheres only (n_shapes).
    pub spheres: &'a [Sphere],
    /// The manifolds of the last step.
    pub last: Last<'a>,
}

/// The pairs that touch: the stage's own columns, which keep their memory from step to step.
#[derive(Default)]
pub struct Touching {
    /// Ascending indices of the sphere pairs that touch, within their part, at the start of a range of the length of all the part's pairs
    /// (n_sphere_pairs). Their contact points are cheaper to compute again than to store.
    place: Vec<u32>,
    /// Number of sphere pairs that touch in each part.
    n: Vec<usize>,
    /// Balls about the shapes with their margins, where the plan has any shapes (n_shapes).
    balls: Vec<Ball>,
    /// Other pairs that touch, by parts.
    others: Vec<Others>,
    /// The manifolds that are kept for the next step.
    pub manifolds: Manifolds,
}

/// A ball about a shape with its margin, in single precision, rounded up: what most pairs of a dense pile are told apart by.
#[derive(Clone, Copy, Default)]
struct Ball {
    centre: [f32; 3],
    radius: f32,
}

impl Ball {
    fn of(placed: &Placed, margin: f32) -> Ball {
        // The rounding of two centres, and of the radius.
        let rounding = 2.5e-7 * placed.position.abs().max_element();
        Ball {
            centre: placed.position.as_vec3().to_array(),
            radius: ((placed.extent + margin as f64) * (1.0 + 1e-6) + rounding) as f32,
        }
    }

    /// Whether the balls may overlap.
    #[inline(always)]
    fn is_near(&self, other: &Ball) -> bool {
        let reach = self.radius + other.radius;
        let of = |k: usize| self.centre[k] - other.centre[k];
        of(0) * of(0) + of(1) * of(1) + of(2) * of(2) <= reach * reach
    }
}

/// Candidate pairs of a tile that one task collides.
struct Part {
    tile: usize,
    /// Whether they are among the tile's pairs of spheres; the others come after these.
    is_of_spheres: bool,
    /// Their range among these pairs of the tile.
    range: Range<usize>,
}

impl Part {
    /// The least number of pairs of a part, unless its tile has fewer, of other pairs and of pairs of spheres; and of parts, unless they would have
    /// fewer pairs.
    const LEAST: [usize; 2] = [512, 4096];
    const MANY: usize = 32;

    /// The parts of all tiles, in order.
    fn all(pairs: &Pairs) -> Vec<Part> {
        let of_all = [pairs.others.len(), pairs.spheres.len()];
        let length = [0, 1].map(|k| Part::LEAST[k].max(of_all[k].div_ceil(Part::MANY)));
        let mut parts = vec![];
        for tile in 0..pairs.n_tiles() {
            for (is_of_spheres, n) in [(true, pairs.spheres_of(tile).len()), (false, pairs.others_of(tile).len())] {
                let length = length[is_of_spheres as usize];
                let part = |first: usize| Part { tile, is_of_spheres, range: first..(first + length).min(n) };
                parts.extend((0..n).step_by(length).map(part));
            }
        }
        parts
    }

    /// Its pairs of spheres.
    fn spheres<'a>(&self, pairs: &'a Pairs) -> &'a [[u32; 2]] {
        if self.is_of_spheres { &pairs.spheres_of(self.tile)[self.range.clone()] } else { &[] }
    }

    /// Its other pairs.
    fn others<'a>(&self, pairs: &'a Pairs) -> &'a [[u32; 3]] {
        if self.is_of_spheres { &[] } else { &pairs.others_of(self.tile)[self.range.clone()] }
    }
}

/// The other pairs of a part that touch.
#[derive(Default)]
struct Others {
    /// Index of each pair within the part, and the end of its points in `point`.
    touching: Vec<[u32; 2]>,
    point: Vec<Point>,
}

/// The stage.
pub fn run(at: &Input, pairs: &Pairs, touching: &mut Touching, contacts: &mut Contacts) {
    contacts.arms = match (at.plan.narrow, std::mem::take(&mut contacts.arms)) {
        (Narrow::Any, arms) => {
            let shapes = (0..at.model.n_shapes()).into_par_iter().with_min_len(CHUNK);
            let placed: Vec<Placed> =
                shapes.map(|s| Placed::of(at.model, at.state.shape_pose(at.model, s), s)).collect();
            touching.balls.resize(at.model.n_shapes(), Ball::default());
            fill_rows(&mut touching.balls, |s| Ball::of(&placed[s], at.margin[s]));
            let mut arms = if let Arms::Any(arms) = arms { arms } else { vec![] };
            let arms_of = |bodies: [u32; 2], point: &Point, _: [f64; 2]| {
                let contact = match at.surface_of(bodies, point.gap) {
                    Some(0) => point.on_first,
                    Some(_) => point.on_second,
                    None => 0.5 * (point.on_first + point.on_second),
                };
                bodies.map(|b| contact - at.state.position[b as usize])
            };
            let sphere = |s: u32| Sphere::of(at.model, at.state, s as usize, at.margin[s as usize]);
            let find = |pairs: &[[u32; 2]], place: &mut [u32]| find_spheres(pairs, sphere, place);
            let write = |pairs: &[[u32; 2]], places: &[u32], rows: &mut Rows<_>| {
                for (i, place) in places.iter().enumerate() {
                    let pair = pairs[*place as usize];
                    rows.put_spheres(i, pair, pair.map(sphere), arms_of);
                }
            };
            find_and_write(at, (pairs, &placed), touching, contacts, &mut arms, (find, write, arms_of));
            Arms::Any(arms)
        }
        (Narrow::Spheres, arms) => {
            let mut arms = if let Arms::Along(arms) = arms { arms } else { vec![] };
            let spheres = at.spheres;
            let find = |pairs: &[[u32; 2]], place: &mut [u32]| widest(sphere_pairs::Find { pairs, spheres, place });
            let write = |pairs: &[[u32; 2]], places: &[u32], rows: &mut Rows<_>| {
                widest(sphere_pairs::Write { pairs, places, spheres, rows })
            };
            let arms_of = |bodies: [u32; 2], point: &Point, radii: [f64; 2]| match at.surface_of(bodies, point.gap) {
                Some(_) => radii,
                None => along(bodies, point, radii),
            };
            find_and_write(at, (pairs, &[]), touching, contacts, &mut arms, (find, write, arms_of));
            Arms::Along(arms)
        }
    };
}

/// The stage for one layout of arms: `find` writes the indices of the sphere pairs that touch to a column and returns their count,
/// `write` writes their contacts, and `arms_of` makes the arms of the others. `placed` has where the shapes are, or is empty.
fn find_and_write<A: Copy + Default + Send>(
    at: &Input,
    (pairs, placed): (&Pairs, &[Placed]),
    touching: &mut Touching,
    contacts: &mut Contacts,
    arms: &mut Vec<A>,
    (find, write, arms_of): (
        impl Fn(&[[u32; 2]], &mut [u32]) -> usize + Sync,
        impl Fn(&[[u32; 2]], &[u32], &mut Rows<A>) + Sync,
        impl Fn([u32; 2], &Point, [f64; 2]) -> A + Sync,
    ),
) {
    let parts = &Part::all(pairs);
    let Touching { place, n, others, balls, manifolds } = touching;
    manifolds.parts.resize_with(parts.len(), PartManifolds::default);
    others.resize_with(parts.len(), Others::default);
    n.resize(parts.len(), 0);
    place.resize(pairs.spheres.len(), 0);
    let mut slots = cut(place, parts.iter().map(|part| part.spheres(pairs).len()));
    let each =
        (parts, &mut slots, &mut *n, &mut *others, &mut manifolds.parts).into_par_iter().with_max_len(1).enumerate();
    each.for_each(|(k, (part, slots, n, others, kept))| {
        *n = find(part.spheres(pairs), slots);
        others.find(at, (placed, balls), k, part.others(pairs), kept);
    });

    let Contacts { bodies, key, pair, normal, gap, law, tiles, .. } = contacts;
    let counts = n.iter().zip(&*others).map(|(n, others)| (*n + others.point.len()) as u32);
    let start = &mut counts.chain([0]).collect::<Vec<u32>>();
    gpu::scan::exclusive_cpu(start);
    let start = &*start;
    let first_part = |tile: usize| parts.partition_point(|part| part.tile < tile);
    *tiles = Tiles {
        start: (0..=pairs.n_tiles()).map(|tile| start[first_part(tile)]).collect(),
        n_first: pairs.n_first,
        place: pairs.place.clone(),
        n_places: pairs.n_places,
    };
    let columns = (
        (parts, slots, n, others).into_par_iter(),
        split(bodies, start),
        split(key, start),
        split(pair, start),
        split(normal, start),
        split(gap, start),
        split(law, start),
        split(arms, start),
    );
    let n_materials = at.model.material_names.len() as u32;
    columns.into_par_iter().with_max_len(1).for_each(
        |((part, places, n, others), bodies, key, pair, normal, gap, law, arms)| {
            let first = part.range.start as u32;
            let places = &places[..*n];
            let mut rows = Rows { bodies, key, normal, gap, law, arms, n_materials };
            pair.iter_mut().zip(places).for_each(|(pair, place)| *pair = first + place);
            write(part.spheres(pairs), places, &mut rows);
            let mut i = *n;
            others.each(at.model, part.others(pairs), |k, shapes, key, point| {
                pair[i] = OTHER | (first + k);
                rows.put(i, shapes, key, point, &arms_of);
                i += 1;
            });
        },
    );
}

/// Find which sphere pairs touch, as [`sphere_pairs::Find`] does, of spheres that have no column.
fn find_spheres(pairs: &[[u32; 2]], sphere: impl Fn(u32) -> Sphere, place: &mut [u32]) -> usize {
    let mut n = 0;
    for (k, [s, t]) in pairs.iter().enumerate() {
        place[n] = k as u32;
        n += sphere(*s).is_near(&sphere(*t)) as usize;
    }
    n
}

impl Others {
    /// Find which of the other pairs touch, and their points.
    fn find(
        &mut self,
        at: &Input,
        (placed, balls): (&[Placed], &[Ball]),
        part: usize,
        pairs: &[[u32; 3]],
        kept: &mut PartManifolds,
    ) {
        self.touching.clear();
        self.point.clear();
        kept.clear();
        let mut found = 0;
        let tight = |s: u32| {
            at.tight
                .get(s as usize)
                .copied()
                .unwrap_or_else(|| bounds::tight(at.model, at.state, s as usize, at.margin[s as usize]))
        };
        let place = |s: u32| Placed::of(at.model, at.state.shape_pose(at.model, s as usize), s as usize);
        let is_near = |s: u32, t: u32| match (balls.get(s as usize), balls.get(t as usize)) {
            (Some(a), Some(b)) => a.is_near(b),
            _ => true,
        };
        let mut out = [Point::default(); MAX_POINTS];
        for (k, &[s, t, triangle]) in pairs.iter().enumerate() {
            if is_near(s, t) && tight(s).overlaps(&tight(t)) {
                let own;
                let both = match (placed.get(s as usize), placed.get(t as usize)) {
                    (Some(a), Some(b)) => [a, b],
                    _ => {
                        own = [s, t].map(place);
                        [&own[0], &own[1]]
                    }
                };
                let n = points(at, (part, k), [s, t, triangle], both, (kept, &mut found), &mut out);
                if n > 0 {
                    self.point.extend_from_slice(&out[..n]);
                    self.touching.push([k as u32, self.point.len() as u32]);
                }
            }
        }
    }

    /// Visit the contacts in order, each with the index of its pair, its two shapes as for [`Rows::put`], its key and its point; normals point from the first
    /// shape to the second.
    fn each(&self, model: &Model, pairs: &[[u32; 3]], mut visit: impl FnMut(u32, [Sphere; 2], [u32; 3], &Point)) {
        let mut first = 0;
        for [k, end] in &self.touching {
            let [s, t, triangle] = pairs[*k as usize];
            let both = [s, t].map(|s| {
                let (s, is_sphere) = (s as usize, model.shape_kind[s as usize] == ShapeKind::Sphere);
                let radius = if is_sphere { model.shape_size[s].x } else { 0.0 };
                Sphere { radius, body: model.shape_body[s], material: model.shape_material[s], ..Sphere::default() }
            });
            for point in &self.point[first..*end as usize] {
                visit(*k, both, [s, t, (triangle << 17) ^ point.feature], point);
            }
            first = *end as usize;
        }
    }
}

/// The contact points of a pair of a part, its manifold kept where it is one of convex shapes. Returns their count.
fn points(
    at: &Input,
    (part, pair): (usize, usize),
    [s, t, triangle]: [u32; 3],
    [a, b]: [&Placed; 2],
    (kept, found): (&mut PartManifolds, &mut usize),
    out: &mut Points,
) -> usize {
    let (model, shapes, s, t) = (at.model, [s, t], s as usize, t as usize);
    let reach = (at.margin[s] + at.margin[t]) as f64;
    let way = || at.way(shapes.map(|s| model.shape_body[s as usize] as usize), [a, b]);
    if let Some(surface) = surface_of(model, t) {
        collide_triangle(a, &Triangle::of(surface, triangle, b), reach, out)
    } else if let Some(surface) = surface_of(model, s) {
        let n = collide_triangle(b, &Triangle::of(surface, triangle, a), reach, out);
        swap_shapes(out, n)
    } else if keeps(a.kind) && keeps(b.kind) {
        let last = at.last.find(part, pair as u32, shapes, found);
        collide_or_recycle(
            [a, b],
            (pair as u32, shapes),
            (reach, at.model.recycle, at.model.solver.rest_gap),
            last,
            way,
            (kept, out),
        )
    } else {
        let n = collide(a, b, reach, out);
        let is_plane = [a, b].iter().any(|shape| shape.kind == ShapeKind::Plane);
        if is_plane { n } else { pass([a, b], way, (reach, model.solver.rest_gap), (&mut Axis::default(), n), out) }
    }
}

impl Input<'_> {
    /// How two shapes of these bodies move in the step.
    fn way(&self, bodies: [usize; 2], shapes: [&Placed; 2]) -> Way {
        let Input { model, state, .. } = self;
        let mut way = Way { step: model.step, ..Way::default() };
        for (k, body) in bodies.into_iter().enumerate() {
            let Twist { v, w } = state.twist(body);
            way.velocity[k] = v + w.cross(shapes[k].position - state.position[body]);
            way.spin[k] = if is_curved(shapes[k].kind) { DVec3::ZERO } else { w };
            way.fall[k] = if state.moves(body) { model.gravity * model.step } else { DVec3::ZERO };
        }
        way
    }

    /// The body, 0 for A and 1 for B, on whose surface a contact at a gap has its point: that which moves, where the other is held in
    /// place and they have not met yet. Between two bodies that move the point is in the middle, which keeps the angular momentum.
    #[inline(always)]
    fn surface_of(&self, bodies: [u32; 2], gap: f64) -> Option<usize> {
        match bodies.map(|b| self.state.moves(b as usize)) {
            [true, false] if gap > 0.0 => Some(0),
            [false, true] if gap > 0.0 => Some(1),
            _ => None,
        }
    }
}

/// Resize a column to the number of contacts, and split it by tiles.
fn split<'a, T: Clone + Default>(column: &'a mut Vec<T>, start: &[u32]) -> Vec<&'a mut [T]> {
    column.resize(start.last().map_or(0, |n| *n as usize), T::default());
    cut(column, start.windows(2).map(|ends| (ends[1] - ends[0]) as usize))
}
