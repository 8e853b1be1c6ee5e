//! Surfaces in one plane: where one covers another, which of them is seen depends on their order in the scene, and not on how their depths
//! are rounded.
//!
//! The first in the scene is seen, as of all that is equally deep; area lights go before what is none. The others are sampled as if they were
//! a little farther: by more than depths are in error where places lie on steps of the raster and depths are interpolated over
//! micropolygons. Nothing moves on the raster, and shaders see everything where it is.
//!
//! What is flat and stays flat takes part: faces of polygons, flat patches, disks. What is displaced, or a part of a solid, does not, and the
//! faces of a mesh are not told apart from each other.

use crate::cpu::tree::Tree;
use crate::gprim::split::coarsening;
use crate::scene::camera::Camera;
use crate::scene::motion::Instant;
use crate::scene::patch::Patch;
use crate::scene::shape::Shape;
use crate::scene::source::{Item, Source, SourceShape};
use crate::scene::world::Scene;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::ControlFlow;

/// The most that lie over each other and are told apart.
const MOST_STEPS: u32 = 2;

/// Of those that cover one, how many are looked at.
const MOST_COVERING: usize = 256;

/// By how much depths are in error where places are rounded, in pixels of a surface's slope: a bit more than the steps of the raster.
const SNAPPED: f32 = 1.5 / 1024.0;

/// By how much they are in error where they are interpolated over micropolygons a pixel large, in parts of the slope's square over the depth.
const BENT: f32 = 1.0;

/// How far points are off their plane where they are rounded, in parts of the greatest numbers that they are computed of.
const ROUNDED: f32 = 1e-6;

/// The most that a step is, in parts of the depth, and all steps: in planes that are seen from their edge.
const MOST: f32 = 1.0 / 64.0;
const MOST_IN_ALL: f32 = 1.0 / 4.0;

/// How an item lies behind others in its plane.
#[derive(Clone, Copy, Debug)]
pub struct Behind {
    /// The normal of the plane, world space, as the shutter opens.
    normal: Vec3,
    /// How many lie over each other before it.
    steps: f32,
    /// The greatest shading rate of all that lie in one plane with others.
    rate: f32,
}

impl Behind {
    /// Shift points on the raster farther: x, y and depth at each moment of their item.
    pub fn shift(&self, camera: &Camera, instants: &[Instant], raster: &mut [Vec<[f32; 3]>]) {
        let place = |at: [f32; 3]| Vec2::new(at[0], at[1]);
        let moves: Vec<f32> = match &*raster {
            [first, .., last] => first.iter().zip(last).map(|(a, b)| place(*a).distance(place(*b))).collect(),
            _ => vec![],
        };
        for (instant, raster) in instants.iter().zip(raster) {
            let own = self.at(instant);
            let reach = instant.to_camera.w_axis.truncate().length();
            // What is behind the eye is not there.
            for (k, at) in raster.iter_mut().enumerate().filter(|(_, at)| at[2].is_finite()) {
                at[2] += own.farther(camera, reach, *at, moves.get(k).copied().unwrap_or(0.0));
            }
        }
    }

    /// The same at a moment of the item, in camera space.
    fn at(&self, instant: &Instant) -> Behind {
        let normal = instant.to_camera.inverse().transpose().transform_vector3(self.normal);
        Behind { normal: normal.normalize_or_zero(), ..*self }
    }

    /// How much farther a point on the raster is sampled, whose plane is given in camera space: `reach` is how far the world's origin is from
    /// the eye, and `moves` how far the point moves on the raster while the shutter is open.
    fn farther(&self, camera: &Camera, reach: f32, [x, y, z]: [f32; 3], moves: f32) -> f32 {
        let (n, reach) = (self.normal, reach.max(z));
        let (x, y) = ((x - camera.center.x) / camera.scale.x, (camera.center.y - y) / camera.scale.y);
        // Depth for each pixel right and down; in perspective, 1 / z is linear on the raster.
        let (along, unit) = if camera.perspective { (n.dot(Vec3::new(x, y, 1.0)), z) } else { (n.z, 1.0) };
        let slope = unit * ((n.x / camera.scale.x).abs() + (n.y / camera.scale.y).abs()) / along.abs();
        // What is blurred has larger micropolygons.
        let edge = slope * coarsening(moves + 2.0 * camera.confusion(z).abs());
        let bent = if camera.perspective { BENT * self.rate * edge * edge / z } else { 0.0 };
        let step = (SNAPPED * slope + bent + ROUNDED * reach / along.abs()).min(MOST * z);
        // A plane through the eye is a line, and nothing of it is seen.
        if step.is_finite() { (self.steps * step).min(MOST_IN_ALL * z) } else { 0.0 }
    }
}

/// The items that lie behind others in their planes.
#[derive(Default)]
pub struct Coplanar {
    behind: HashMap<Item, Behind>,
}

impl Coplanar {
    /// Those of a scene.
    pub fn of(scene: &Scene) -> Coplanar {
        let sources = scene.sources.par_iter().enumerate().with_min_len(256);
        let all: Vec<Flat> = sources.flat_map_iter(|(s, source)| flats_of(scene, s, source)).collect();
        let flats = beside_others(scene, all);
        if flats.is_empty() {
            return Coplanar::default();
        }
        let (tree, order) = Tree::new(flats.par_iter().map(|flat| (flat.min, flat.max)));
        let planes = Planes { scene, flats: &flats, tree, order };
        let mut covered: Vec<usize> = (0..flats.len()).into_par_iter().filter(|k| planes.is_covered(*k)).collect();
        covered.sort_by_key(|k| planes.turn(*k));
        let mut steps: HashMap<usize, u32> = HashMap::with_capacity(covered.len());
        let mut rate = 0.0f32;
        for k in &covered {
            let (mut most, mut left) = (0, MOST_COVERING);
            planes.covering(*k, |other| {
                most = most.max(steps.get(&other).copied().unwrap_or(0));
                rate = rate.max(planes.rate(other)).max(planes.rate(*k));
                left -= 1;
                if left == 0 || most == MOST_STEPS { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            steps.insert(*k, (most + 1).min(MOST_STEPS));
        }
        let behind = |k: &usize| {
            let (item, steps) = (flats[*k].item, steps[k] as f32);
            let normal = Outline::of(scene, item).map_or(Vec3::ZERO, |own| own.normal);
            (item, Behind { normal, steps, rate })
        };
        Coplanar { behind: covered.iter().map(behind).collect() }
    }

    /// How an item lies behind others in its plane, if it does.
    pub fn behind(&self, item: Item) -> Option<&Behind> {
        if self.behind.is_empty() { None } else { self.behind.get(&item) }
    }
}

/// Something flat, with its box in the world.
struct Flat {
    item: Item,
    min: Vec3,
    max: Vec3,
}

/// What is flat in a source.
fn flats_of<'a>(scene: &'a Scene, s: usize, source: &'a Source) -> impl Iterator<Item = Flat> + 'a {
    let a = &source.attributes;
    let parts = match &source.shape {
        _ if !a.visible || a.displacement.is_some() || a.solid.is_some() => 0..0,
        SourceShape::Spheres(_) => 0..0,
        SourceShape::One(_) => 0..1,
        SourceShape::Objects(_, parts) => 0..parts.len(),
    };
    let (n_parts, n) = (parts.len(), if parts.is_empty() { 0 } else { source.shape.n_instances() });
    let instances = (0..n).filter(|i| source.repeats.get(*i) != Some(&0));
    let items = instances.flat_map(move |i| {
        parts.clone().map(move |part| Item { source: s as u32, index: (i * n_parts + part) as u32 })
    });
    items.filter_map(|item| Outline::of(scene, item).map(|Outline { min, max, .. }| Flat { item, min, max }))
}

/// Those of flat things that are within the box of another primitive's: the faces of a mesh are none to each other.
fn beside_others(scene: &Scene, all: Vec<Flat>) -> Vec<Flat> {
    let of = |flat: &Flat| scene.whole_of(flat.item);
    let wholes: Vec<&[Flat]> = all.chunk_by(|a, b| of(a) == of(b)).collect();
    if wholes.len() < 2 {
        return vec![];
    }
    let bounds: Vec<(Vec3, Vec3)> = wholes
        .par_iter()
        .map(|own| own.iter().fold((own[0].min, own[0].max), |(lo, hi), flat| (lo.min(flat.min), hi.max(flat.max))))
        .collect();
    let (tree, order) = Tree::new(bounds.par_iter().copied());
    let is_beside = |flat: &Flat, own: u32| {
        let (room, mut found) = (Vec3::splat(room(flat.min, flat.max, Vec3::ONE)), false);
        let (lo, hi) = (flat.min - room, flat.max + room);
        tree.meeting(lo, hi, |leaf| {
            let meets = |k: &u32| {
                let (min, max) = bounds[*k as usize];
                *k != own && min.cmple(hi).all() && max.cmpge(lo).all()
            };
            found = found || order[leaf].iter().any(meets);
        });
        found
    };
    let firsts = wholes.iter().map(|own| own.len()).enumerate();
    let names: Vec<u32> = firsts.flat_map(|(k, n)| std::iter::repeat_n(k as u32, n)).collect();
    let kept: Vec<bool> = all.par_iter().zip(&names).map(|(flat, own)| is_beside(flat, *own)).collect();
    all.into_iter().zip(kept).filter_map(|(flat, is_kept)| is_kept.then_some(flat)).collect()
}

/// How far rounding may move what is in a plane with a normal off that, by the box around it.
fn room(min: Vec3, max: Vec3, normal: Vec3) -> f32 {
    let reach = min.abs().max(max.abs());
    1e-6 * normal.abs().dot(reach) + 2e-7 * reach.max_element()
}

/// The patch of a shape that is one, if all of it is in one plane and stays there.
fn flat_patch(shape: &Shape) -> Option<&Patch> {
    let Shape::Patches(patches, _) = shape else { return None };
    let [patch] = patches.as_slice() else { return None };
    let [a, b, c, d] = CORNERS.map(|k| patch.p[k]);
    let (long, other) = (c - a, d - b);
    let in_plane = || {
        let normal = long.cross(other).normalize_or_zero();
        patch.p.iter().all(|p| (*p - a).dot(normal).abs() <= 1e-6 * long.length().max(other.length()))
    };
    (patch.moves.is_empty() && (patch.flat || in_plane())).then_some(patch)
}

/// The corners of a patch among its control points, one after the other around it.
const CORNERS: [usize; 4] = [0, 3, 15, 12];

/// What is flat, found by its place.
struct Planes<'a> {
    scene: &'a Scene,
    flats: &'a [Flat],
    tree: Tree,
    order: Vec<u32>,
}

impl Planes<'_> {
    /// What decides which of two is seen: that of the lesser turn is.
    fn turn(&self, k: usize) -> (bool, u32, u32) {
        let item = self.flats[k].item;
        (self.scene.attributes(item).area_light.is_none(), item.source, item.index)
    }

    fn rate(&self, k: usize) -> f32 {
        self.scene.attributes(self.flats[k].item).shading_rate
    }

    /// Whether another covers a part of it and is seen before it.
    fn is_covered(&self, k: usize) -> bool {
        let mut covered = false;
        self.covering(k, |_| {
            covered = true;
            ControlFlow::Break(())
        });
        covered
    }

    /// Visit those that cover a part of one and are seen before it.
    fn covering(&self, k: usize, mut visit: impl FnMut(usize) -> ControlFlow<()>) {
        let Some(own) = Outline::of(self.scene, self.flats[k].item) else { return };
        let (turn, room) = (self.turn(k), Vec3::splat(own.room()));
        let (lo, hi) = (own.min - room, own.max + room);
        let whole = self.scene.whole_of(self.flats[k].item);
        let covers = |flat: &Flat| {
            let is_near = flat.min.cmple(hi).all() && flat.max.cmpge(lo).all();
            is_near
                && self.scene.whole_of(flat.item) != whole
                && Outline::of(self.scene, flat.item).is_some_and(|other| own.meets(&other))
        };
        let mut ended = false;
        self.tree.meeting(lo, hi, |leaf| {
            for other in self.order[leaf].iter().map(|k| *k as usize) {
                ended = ended || self.turn(other) < turn && covers(&self.flats[other]) && visit(other).is_break();
            }
        });
    }
}

/// The outline of what is flat, world space.
struct Outline {
    /// Its corners, and the control points of what may have bent edges.
    points: [Vec3; 16],
    n: usize,
    normal: Vec3,
    min: Vec3,
    max: Vec3,
}

impl Outline {
    /// Of an item that is flat and has an area.
    fn of(scene: &Scene, item: Item) -> Option<Outline> {
        let (shape, to_world) = scene.place(item);
        let patch = flat_patch(shape)?;
        let n = if patch.flat { 4 } else { 16 };
        let inner = (0..16).filter(|k| !CORNERS.contains(k));
        let mut points = [Vec3::ZERO; 16];
        for (point, k) in points.iter_mut().zip(CORNERS.into_iter().chain(inner)).take(n) {
            *point = to_world.transform_point3(patch.p[k]);
        }
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| points[k]);
        let normal = (c - a).cross(d - b).try_normalize()?;
        let own = &points[..n];
        let (min, max) = own.iter().fold((own[0], own[0]), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
        (min.is_finite() && max.is_finite()).then_some(Outline { points, n, normal, min, max })
    }

    fn points(&self) -> &[Vec3] {
        &self.points[..self.n]
    }

    fn size(&self) -> f32 {
        (self.max - self.min).length()
    }

    /// The greatest coordinates, without their signs.
    fn reach(&self) -> Vec3 {
        self.min.abs().max(self.max.abs())
    }

    /// How far rounding may move what is in its plane off that.
    fn room(&self) -> f32 {
        room(self.min, self.max, self.normal)
    }

    /// Whether another lies in its plane, and both cover some area.
    fn meets(&self, other: &Outline) -> bool {
        let (large, small) = if self.size() >= other.size() { (self, other) } else { (other, self) };
        let (room, from) = (large.room().max(small.room()), large.points[0]);
        if small.points().iter().any(|p| (*p - from).dot(large.normal).abs() > room) {
            return false;
        }
        let (u, v) = large.normal.any_orthonormal_pair();
        let flat = |p: &Vec3| Vec2::new((*p - from).dot(u), (*p - from).dot(v));
        let extent = |own: &Outline, axis: Vec2| {
            let along = own.points().iter().map(|p| flat(p).dot(axis));
            along.fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)))
        };
        // Neighbours that share an edge cover nothing together.
        let beside = 1e-4 * small.size() + 1e-6 * large.reach().max_element();
        let edges = |own: &Outline| [0, 1, 2, 3].map(|k| flat(&own.points[(k + 1) % 4]) - flat(&own.points[k]));
        let axes = edges(large).into_iter().chain(edges(small)).map(Vec2::perp).chain([Vec2::X, Vec2::Y]);
        axes.filter_map(Vec2::try_normalize).all(|axis| {
            let ((lo, hi), (other_lo, other_hi)) = (extent(large, axis), extent(small, axis));
            lo < other_hi - beside && other_lo < hi - beside
        })
    }
}
