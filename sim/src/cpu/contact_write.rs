//! Narrow phase: write the contacts of the candidate pairs.
//! in   position           [n_bodies]       m
//! in   orientation        [n_bodies]
//! in   velocity           [n_bodies]       m/s
//! in   angular_velocity   [n_bodies]       rad/s
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
use super::collide::{Triangle, collide, collide_triangle, pass, surface_of};
use super::contact_rows::{Rows, along};
use super::pair_write::Pairs;
use super::recycle::{Keeping, Last, Reach, collide_or_recycle, keeps, moved};
use super::strikes::{Moving, Near, Strikes};
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
    /// Whether pairs have all contacts within their margins, or those alone that may close in the step ([`Strikes`]).
    pub are_all: bool,
}

/// The pairs that touch: the stage's own columns, which keep their memory from step to step.
#[derive(Default)]
pub struct Touching {
    /// Ascending indices of the sphere pairs that touch, within their part, at the start of a range of the length of all the part's pairs
    /// (n_sphere_pairs). Their contact points are cheaper to compute again than to store.
    place: Vec<u32>,
    /// Number of sphere pairs that touch in each part.
    n: Vec<usize>,
    /// The shapes with their margins, where the plan has any shapes (n_shapes).
    moving: Vec<Moving>,
    /// The bodies that may be struck in the step.
    strikes: Strikes,
    /// Other pairs that touch, by parts.
    others: Vec<Others>,
    /// The manifolds that are kept for the next step, of parts whose manifolds have changed.
    manifolds: Manifolds,
}

impl Touching {
    /// Take the manifolds that are kept for the next step; `last` are those of the last step, whose memory is kept.
    pub fn take_manifolds(&mut self, mut last: Manifolds) -> Manifolds {
        for (k, others) in self.others.iter().enumerate() {
            if others.keeps_last {
                std::mem::swap(&mut self.manifolds.parts[k], &mut last.parts[k]);
            }
        }
        std::mem::replace(&mut self.manifolds, last)
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

/// The shapes of a step.
struct Shapes<'a> {
    /// Where they are, and how they move, or both empty.
    placed: &'a [Placed<'a>],
    moving: &'a [Moving],
    /// What may be struck; none where pairs have all contacts within their margins.
    strikes: Option<&'a Strikes>,
}

impl Shapes<'_> {
    /// Whether the margins of two shapes may overlap.
    fn are_near(&self, s: u32, t: u32) -> bool {
        self.placed.is_empty() || self.moving[s as usize].is_near(&self.moving[t as usize])
    }

    /// The tight AABB of a shape.
    fn tight(&self, at: &Input, s: u32) -> Aabb {
        let s = s as usize;
        at.tight.get(s).copied().unwrap_or_else(|| bounds::tight(at.model, at.state, s, at.margin[s]))
    }

    /// The gap up to which two shapes have contacts, and one that they have at least, m.
    fn reach(&self, Seen { near, bodies, .. }: &Seen, shapes: [u32; 2]) -> (f64, f64) {
        let reach = match self.strikes {
            Some(strikes) => strikes.reach(near, *bodies, shapes.map(|s| &self.moving[s as usize])),
            None => near.full,
        };
        (reach as f64, near.gap as f64)
    }
}

/// A gap that two shapes with margins, whose sum is `full`, m, have at least, m: that of balls about them, or of one above a plane; 0 for triangles.
fn least_gap([a, b]: [&Placed; 2], [moving_a, moving_b]: [&Moving; 2], full: f32) -> f32 {
    let above = |plane: &Placed, other: &Placed| {
        ((other.position - plane.position).dot(plane.rotation.z_axis) - other.extent) as f32
    };
    match (a.kind, b.kind) {
        (ShapeKind::Plane, _) => above(a, b),
        (_, ShapeKind::Plane) => above(b, a),
        _ if a.extent + b.extent == f64::INFINITY => 0.0,
        _ => moving_a.gap(moving_b, full),
    }
}

/// Another pair with overlapping margins.
struct Seen {
    near: Near,
    bodies: [u32; 2],
    manifold: Manifold,
}

/// The manifold that a pair had in the last step.
#[derive(Clone, Copy)]
enum Manifold {
    /// It was not looked for.
    Unknown,
    None,
    /// Its part and index, and how far the shapes have moved against each other since its points were found, m.
    Of([u32; 2], f64),
}

impl Manifold {
    /// That of the pair `k` of a part.
    fn find(
        at: &Input,
        (part, k): (usize, u32),
        (shapes, placed): ([u32; 2], [&Placed; 2]),
        found: &mut usize,
    ) -> Manifold {
        if !placed.iter().all(|shape| keeps(shape.kind)) {
            return Manifold::None;
        }
        match at.last.find(part, k, shapes, found) {
            Some(last) => Manifold::Of(last, moved(placed, at.last.get(last).0)),
            None => Manifold::None,
        }
    }

    /// A gap that the shapes have at least, as far as it tells, m.
    fn least_gap(self, at: &Input) -> f32 {
        match self {
            Manifold::Of(last, moved) => (at.last.get(last).0.gap - moved) as f32,
            _ => f32::NEG_INFINITY,
        }
    }

    /// The overlap that the shapes had when its points were found, m.
    fn overlap(self, at: &Input) -> f32 {
        if let Manifold::Of(last, _) = self { -at.last.get(last).0.gap as f32 } else { 0.0 }
    }
}

/// The other pairs of a part that touch.
#[derive(Default)]
struct Others {
    /// Those with overlapping margins, in order.
    seen: Vec<Seen>,
    /// Index of each pair within the part, and the end of its points in `point`.
    touching: Vec<[u32; 2]>,
    point: Vec<Point>,
    /// Whether their manifolds are all those of the last step, which are not copied.
    keeps_last: bool,
}

/// The stage.
pub fn run(at: &Input, pairs: &Pairs, touching: &mut Touching, contacts: &mut Contacts) {
    contacts.arms = match (at.plan.narrow, std::mem::take(&mut contacts.arms)) {
        (Narrow::Any, arms) => {
            let shapes = (0..at.model.n_shapes()).into_par_iter().with_min_len(CHUNK);
            let placed: Vec<Placed> =
                shapes.map(|s| Placed::of(at.model, at.state.shape_pose(at.model, s), s)).collect();
            touching.moving.resize(at.model.n_shapes(), Moving::default());
            fill_rows(&mut touching.moving, |s| Moving::of((at.model, at.state), s, &placed[s], at.margin[s]));
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
    let Touching { place, n, others, moving, strikes, manifolds } = touching;
    let strikes = (!at.are_all && !placed.is_empty()).then(|| {
        strikes.begin(at.model, at.state, !pairs.spheres.is_empty());
        &*strikes
    });
    let shapes = &Shapes { placed, moving: &moving[..placed.len()], strikes };
    manifolds.parts.resize_with(parts.len(), PartManifolds::default);
    others.resize_with(parts.len(), Others::default);
    n.resize(parts.len(), 0);
    place.resize(pairs.spheres.len(), 0);
    let mut slots = cut(place, parts.iter().map(|part| part.spheres(pairs).len()));
    let each = (parts, &mut slots, &mut *n, &mut *others).into_par_iter().with_max_len(1).enumerate();
    each.for_each(|(k, (part, slots, n, others))| {
        *n = find(part.spheres(pairs), slots);
        others.look(at, shapes, k, part.others(pairs));
    });
    follow_strikes(at, shapes, pairs, parts, others);
    let each = (parts, &mut *others, &mut manifolds.parts).into_par_iter().with_max_len(1);
    each.enumerate().for_each(|(k, (part, others, kept))| others.find(at, shapes, k, part.others(pairs), kept));

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

/// Let strikes follow each other along the pairs, until there is no news of any body.
fn follow_strikes(at: &Input, shapes: &Shapes, pairs: &Pairs, parts: &[Part], others: &[Others]) {
    let Some(strikes) = shapes.strikes.filter(|strikes| strikes.are_any()) else { return };
    for round in Strikes::LOOK + 1.. {
        let each = (parts, others).into_par_iter().with_max_len(1);
        let follow = each.map(|(part, others)| others.follow(at, (shapes, strikes), round, part.others(pairs)));
        if !follow.reduce(|| false, |a, b| a | b) {
            return;
        }
    }
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
    /// See which of the other pairs have overlapping margins, and whether they may strike each other.
    fn look(&mut self, at: &Input, shapes: &Shapes, part: usize, pairs: &[[u32; 3]]) {
        self.seen.clear();
        let mut found = 0;
        for (k, &[s, t, _]) in pairs.iter().enumerate() {
            if !shapes.are_near(s, t) {
                continue;
            }
            let apart = shapes.tight(at, s).gap(&shapes.tight(at, t));
            if apart > 0.0 {
                continue;
            }
            let (k, full) = (k as u32, at.margin[s as usize] + at.margin[t as usize]);
            let bodies = [s, t].map(|s| at.model.shape_body[s as usize]);
            let Some(strikes) = shapes.strikes else {
                self.seen.push(Seen { near: Near::whole(k, full), bodies, manifold: Manifold::Unknown });
                continue;
            };
            let [a, b] = [s, t].map(|s| &shapes.placed[s as usize]);
            let moving = [s, t].map(|s| &shapes.moving[s as usize]);
            let mut near = strikes.near(k, moving, (full, apart + full));
            if !near.is_beyond() {
                near.gap = near.gap.max(least_gap([a, b], moving, full));
            }
            let mut manifold = Manifold::Unknown;
            if !near.is_beyond() {
                manifold = Manifold::find(at, (part, k), ([s, t], [a, b]), &mut found);
                near.gap = near.gap.max(manifold.least_gap(at));
                strikes.look(at.state, &near, bodies, moving, manifold.overlap(at));
            }
            self.seen.push(Seen { near, bodies, manifold });
        }
    }

    /// Let strikes follow each other, once more over the pairs. Returns whether there is news of any body.
    fn follow(&self, at: &Input, (shapes, strikes): (&Shapes, &Strikes), round: u32, pairs: &[[u32; 3]]) -> bool {
        let follow = |seen: &Seen| {
            let [s, t, _] = pairs[seen.near.k as usize];
            let moving = [s, t].map(|s| &shapes.moving[s as usize]);
            strikes.follow(at.state, round, &seen.near, seen.bodies, moving)
        };
        let with_news = self.seen.iter().filter(|seen| strikes.have_news(round, seen.bodies));
        with_news.fold(false, |any, seen| follow(seen) | any)
    }

    /// Find which of the other pairs touch, and their points.
    fn find(&mut self, at: &Input, shapes: &Shapes, part: usize, pairs: &[[u32; 3]], kept: &mut PartManifolds) {
        let mut found = 0;
        self.touching.clear();
        self.point.clear();
        let mut keeping = Keeping::begin(kept, at.last.part(part));
        let place = |s: u32| Placed::of(at.model, at.state.shape_pose(at.model, s as usize), s as usize);
        let mut out = [Point::default(); MAX_POINTS];
        for seen in &self.seen {
            let [s, t, triangle] = pairs[seen.near.k as usize];
            let own;
            let both = match (shapes.placed.get(s as usize), shapes.placed.get(t as usize)) {
                (Some(a), Some(b)) => [a, b],
                _ => {
                    own = [s, t].map(place);
                    [&own[0], &own[1]]
                }
            };
            let n = points(at, (seen, shapes, part), [s, t, triangle], both, (&mut keeping, &mut found), &mut out);
            if n > 0 {
                self.point.extend_from_slice(&out[..n]);
                self.touching.push([seen.near.k, self.point.len() as u32]);
            }
        }
        self.keeps_last = keeping.end();
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
    (seen, shapes, part): (&Seen, &Shapes, usize),
    [s, t, triangle]: [u32; 3],
    [a, b]: [&Placed; 2],
    (keeping, found): (&mut Keeping, &mut usize),
    out: &mut Points,
) -> usize {
    let (model, ids, s, t) = (at.model, [s, t], s as usize, t as usize);
    let reach = (at.margin[s] + at.margin[t]) as f64;
    let way = || {
        let of = |s: usize, placed: &Placed| {
            shapes.moving.get(s).copied().unwrap_or_else(|| Moving::of((model, at.state), s, placed, 0.0))
        };
        Moving::way((model, at.state), seen.bodies, [&of(s, a), &of(t, b)])
    };
    if let Some(surface) = surface_of(model, t) {
        collide_triangle(a, &Triangle::of(surface, triangle, b), reach, out)
    } else if let Some(surface) = surface_of(model, s) {
        let n = collide_triangle(b, &Triangle::of(surface, triangle, a), reach, out);
        swap_shapes(out, n)
    } else if keeps(a.kind) && keeps(b.kind) {
        let (contacts, gap) = shapes.reach(seen, ids);
        let look = reach.min(2.0 * model.envelope);
        let (manifold, gap) = match seen.manifold {
            // It has no points, and its manifold is let go: the next one begins without.
            Manifold::Unknown if gap > contacts => return 0,
            Manifold::Unknown => {
                let manifold = Manifold::find(at, (part, seen.near.k), (ids, [a, b]), found);
                (manifold, gap.max(manifold.least_gap(at) as f64))
            }
            known => (known, gap),
        };
        let last = if let Manifold::Of(last, moved) = manifold { Some((at.last.get(last), moved)) } else { None };
        let bounds = (Reach { contacts, look }, gap, model.recycle, model.solver.rest_gap);
        collide_or_recycle([a, b], (seen.near.k, ids), bounds, last, way, (keeping, out))
    } else {
        let n = collide(a, b, reach, out);
        let is_plane = [a, b].iter().any(|shape| shape.kind == ShapeKind::Plane);
        if is_plane { n } else { pass([a, b], way, (reach, model.solver.rest_gap), (&mut Axis::default(), n), out) }
    }
}

impl Input<'_> {
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
