//! Displaced surfaces as rays meet them: of each item the meshes of its grids, diced as for the camera and displaced.
//!
//! What the camera does not see is diced more coarsely, by its distance. Large items are displaced before the first bucket, in
//! parallel; others, of which a scene may have very many, when a ray first comes near. What a displacement shader moves by less
//! than a part of a pixel is left to [`crate::cpu::bvh`], undisplaced.

use crate::cpu::mesh::{Mesh, Spot};
use crate::cpu::tree::Tree;
use crate::gprim::bound::{displacement_reach, raster_bound};
use crate::gprim::dice::Dicer;
use crate::gprim::grid::{Grid, Sink, Subject};
use crate::gprim::split::Waiting;
use crate::scene::camera::{Camera, RasterBound};
use crate::scene::motion::instants;
use crate::scene::shape::Shape;
use crate::scene::source::{Item, ItemView};
use crate::scene::world::Scene;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use sl::machine::Machine;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

/// Pixels of displacement below which it is not worth meshes.
const LEAST: f32 = 0.25;

/// Square pixels from which an item of patches is displaced in parallel.
const LARGE: f32 = 16384.0;

/// Pieces of a large item that are displaced at a time.
const PIECES: usize = 256;

/// Displaces a grid.
pub type Displace<'a> = Arc<dyn Fn(&Subject<'_>, &mut Grid, &mut Machine) + Send + Sync + 'a>;

/// Displaced items.
pub struct Displaced<'a> {
    scene: &'a Scene,
    camera: Camera,
    displace: Displace<'a>,
    entries: Vec<Entry>,
    tree: Tree,
    index: HashMap<(u32, u32), u32>,
}

/// An item, and its form once that was wanted.
struct Entry {
    item: Item,
    form: OnceLock<Form>,
}

/// The meshes of an item.
struct Form {
    meshes: Vec<Mesh>,
    tree: Tree,
}

/// Whether rays meet an item as displaced.
pub fn is_meshed(scene: &Scene, camera: &Camera, item: Item) -> bool {
    let source = &scene.sources[item.source as usize];
    source.attributes.displacement.is_some() && source.attributes.traces_displaced() && {
        let view = scene.view(item);
        let (min, max) = camera_bounds(camera, &view);
        let nearest = if min.z > 0.0 { min.z } else { camera.near.max(1e-3 * (max - min).length()) };
        reach_of(&view) * camera.pixels_at(nearest) > LEAST
    }
}

/// The greatest displacement of an item, world units.
fn reach_of(view: &ItemView<'_>) -> f32 {
    let scale = view.to_world.x_axis.truncate().length();
    match view.shape {
        Shape::Sphere => {
            let m = view.to_world;
            let radius = [m.x_axis, m.y_axis, m.z_axis].map(|a| a.truncate().length()).into_iter().fold(0.0, f32::max);
            displacement_reach(view, radius)
        }
        Shape::Patches(patches, _) => {
            let size = |p: &[Vec3; 16]| p.iter().map(|q| (*q - p[0]).length()).fold(0.0, f32::max);
            displacement_reach(view, patches.iter().map(|patch| size(&patch.p)).fold(0.0, f32::max) * scale)
        }
    }
}

/// The box of an item as it is before displacement, in a space.
fn bounds_in(m: glam::Mat4, shape: &Shape) -> (Vec3, Vec3) {
    match shape {
        Shape::Sphere => {
            let row = |k: usize| Vec3::new(m.x_axis[k], m.y_axis[k], m.z_axis[k]).length();
            let (center, half) = (m.w_axis.truncate(), Vec3::new(row(0), row(1), row(2)));
            (center - half, center + half)
        }
        Shape::Patches(patches, _) => patches
            .iter()
            .flat_map(|patch| patch.p)
            .map(|p| m.transform_point3(p))
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p))),
    }
}

fn camera_bounds(camera: &Camera, view: &ItemView<'_>) -> (Vec3, Vec3) {
    bounds_in(camera.to_camera * view.to_world, view.shape)
}

impl<'a> Displaced<'a> {
    /// The items of a list, all of which are displaced.
    pub fn new(scene: &'a Scene, camera: &Camera, items: Vec<Item>, displace: Displace<'a>) -> Displaced<'a> {
        let bounds = items.par_iter().map(|item| {
            let view = scene.view(*item);
            let (min, max) = bounds_in(view.to_world, view.shape);
            let reach = 1.001 * reach_of(&view);
            (min - reach, max + reach)
        });
        let (tree, order) = Tree::new(bounds);
        let entry = |k: &u32| Entry { item: items[*k as usize], form: OnceLock::new() };
        let entries: Vec<Entry> = order.iter().map(entry).collect();
        let at = |(k, e): (usize, &Entry)| ((e.item.source, e.item.index), k as u32);
        let index = entries.iter().enumerate().map(at).collect();
        let displaced = Displaced { scene, camera: camera.clone(), displace, entries, tree, index };
        for entry in &displaced.entries {
            if displaced.is_large(entry.item) {
                let _ = entry.form.set(displaced.displace(entry.item, true));
            }
        }
        displaced
    }

    /// Whether an item covers much of the image and is of patches.
    fn is_large(&self, item: Item) -> bool {
        let view = self.scene.view(item);
        let mut moments = vec![];
        instants(&self.camera, &view, &mut moments);
        let [low, high] = self.camera.raster_view();
        let bound = raster_bound(&self.camera, &view, &moments);
        matches!(view.shape, Shape::Patches(..))
            && bound.is_some_and(|b| (b.max.min(high) - b.min.max(low)).max(Vec2::ZERO).element_product() > LARGE)
    }

    /// Whether there is no memory for more meshes, which ends the image.
    fn is_full(&self) -> bool {
        if self.scene.stopped().is_some() {
            return true;
        }
        let Err(full) = guard::memory::check() else { return false };
        self.scene.stop(None, &format!(
            "no room for the displaced surfaces that rays meet: {full}, a greater `ShadingRate` takes less, and surfaces that \
             cast no shadows (`Attribute \"visibility\" \"transmission\" [0]`) take none"
        ));
        true
    }

    fn form<'s>(&'s self, entry: &'s Entry) -> &'s Form {
        entry.form.get_or_init(|| self.displace(entry.item, false))
    }

    /// The meshes of an item; `parallel` if this thread holds no other's work up.
    fn displace(&self, item: Item, parallel: bool) -> Form {
        let view = self.scene.view(item);
        let mut moments = vec![];
        instants(&self.camera, &view, &mut moments);
        let subject = Subject { item, view: &view, instants: &moments, camera: &self.camera, parameters: false };
        let mut dicer = Dicer::default();
        let mut sink = Meshes::new(self, subject);
        dicer.dice(&subject, &mut sink);
        let most = if parallel { PIECES } else { usize::MAX };
        while dicer.queue.len() < most
            && !self.is_full()
            && let Some(waiting) = dicer.queue.pop_before(None)
        {
            dicer.dice_waiting(&subject, &waiting, &mut sink);
        }
        let mut meshes = sink.meshes;
        let rest = dicer.queue.take();
        let piece = |waiting: &Waiting| {
            let (mut dicer, mut sink) = (Dicer::default(), Meshes::new(self, subject));
            dicer.dice_waiting(&subject, waiting, &mut sink);
            while let Some(waiting) = dicer.queue.pop_before(None).filter(|_| !self.is_full()) {
                dicer.dice_waiting(&subject, &waiting, &mut sink);
            }
            sink.meshes
        };
        if !rest.is_empty() {
            meshes.par_extend(rest.par_iter().with_max_len(1).flat_map_iter(piece));
        }
        let (tree, order) = Tree::alone(meshes.iter().map(Mesh::bounds));
        let mut meshes: Vec<Option<Mesh>> = meshes.into_iter().map(Some).collect();
        let meshes = order.iter().filter_map(|k| meshes[*k as usize].take()).collect();
        Form { meshes, tree }
    }

    /// Whether rays meet an item here.
    pub fn has(&self, item: Item) -> bool {
        self.index.contains_key(&(item.source, item.index))
    }

    /// The triangles of an item that is here.
    pub fn facets(&self, item: Item) -> Option<Vec<[Vec3; 3]>> {
        let entry = &self.entries[*self.index.get(&(item.source, item.index))? as usize];
        Some(self.form(entry).meshes.iter().flat_map(Mesh::facets).collect())
    }

    /// The triangles of all items, each with its item and how near its start a ray meets none of its mesh; none if there are more than these.
    pub fn all_facets(&self, most: usize) -> Option<Vec<(Item, [Vec3; 3], f32)>> {
        let n = AtomicUsize::new(0);
        let of = |entry: &Entry| {
            // Nothing more is displaced once there are too many.
            if n.load(Ordering::Relaxed) > most {
                return vec![];
            }
            let meshes = &self.form(entry).meshes;
            let facets = meshes.iter().flat_map(|mesh| mesh.facets().map(|facet| (entry.item, facet, mesh.room())));
            let own: Vec<_> = facets.collect();
            n.fetch_add(own.len(), Ordering::Relaxed);
            own
        };
        let all: Vec<Vec<_>> = self.entries.par_iter().with_max_len(1).map(of).collect();
        (n.into_inner() <= most).then(|| all.into_iter().flatten().collect())
    }

    /// Visit the meshes that a ray meets within a length; the visitor answers how much of the length still counts, or ends it.
    fn meshes(&self, from: Vec3, dir: Vec3, length: f32, mut visit: impl FnMut(Item, &Mesh, f32) -> Option<f32>) {
        if self.tree.is_empty() || !from.is_finite() || !dir.is_finite() {
            return;
        }
        self.tree.leaves(from, dir, length, |leaf, mut length| {
            for entry in &self.entries[leaf] {
                length = visit_form(entry.item, self.form(entry), (from, dir, length), &mut visit)?;
            }
            Some(length)
        });
    }

    /// Whether an item that `blocks` stands on the way from a place.
    pub fn blocked(&self, from: Vec3, dir: Vec3, length: f32, blocks: impl Fn(Item) -> bool) -> bool {
        let mut blocked = false;
        self.meshes(from, dir, length, |item, mesh, length| {
            blocked = blocks(item) && mesh.blocks(from, dir, length);
            (!blocked).then_some(length)
        });
        blocked
    }

    /// The first thing along a direction of unit length from `least` on.
    pub fn nearest(&self, from: Vec3, dir: Vec3, least: f32) -> Option<(f32, Item)> {
        let mut best = None;
        self.meshes(from, dir, f32::INFINITY, |item, mesh, length| {
            let found = mesh.nearest(from, dir, least, length);
            best = found.map(|t| (t, item)).or(best);
            Some(found.unwrap_or(length))
        });
        best
    }

    /// Add all places where a ray meets something.
    pub fn spots(&self, from: Vec3, dir: Vec3, out: &mut Vec<(Item, Spot)>) {
        let mut found = vec![];
        self.meshes(from, dir, f32::INFINITY, |item, mesh, length| {
            mesh.spots(from, dir, 0.0, &mut found);
            out.extend(found.drain(..).map(|spot| (item, spot)));
            Some(length)
        });
    }

    /// Where a ray meets an item that is here, nearest to a distance.
    pub fn spot(&self, item: Item, from: Vec3, dir: Vec3, distance: f32) -> Option<Spot> {
        let entry = &self.entries[*self.index.get(&(item.source, item.index))? as usize];
        let mut found = vec![];
        visit_form(item, self.form(entry), (from, dir, f32::INFINITY), &mut |_, mesh, length| {
            mesh.spots(from, dir, 0.0, &mut found);
            Some(length)
        });
        found.into_iter().min_by(|a, b| (a.t - distance).abs().total_cmp(&(b.t - distance).abs()))
    }
}

/// Visit the meshes of an item that a ray meets, as [`Displaced::meshes`].
fn visit_form(
    item: Item,
    form: &Form,
    (from, dir, mut length): (Vec3, Vec3, f32),
    visit: &mut impl FnMut(Item, &Mesh, f32) -> Option<f32>,
) -> Option<f32> {
    if form.tree.is_empty() {
        return Some(length);
    }
    let mut goes_on = true;
    form.tree.leaves(from, dir, length, |leaf, mut rest| {
        for mesh in &form.meshes[leaf] {
            let answer = visit(item, mesh, rest);
            goes_on = answer.is_some();
            rest = answer?;
        }
        length = rest;
        Some(rest)
    });
    goes_on.then_some(length)
}

/// Takes the grids of an item as meshes.
struct Meshes<'a, 's> {
    displaced: &'a Displaced<'s>,
    subject: Subject<'a>,
    machine: Machine,
    meshes: Vec<Mesh>,
    /// Corners of what the camera sees of the raster.
    view: [Vec2; 2],
}

impl<'a, 's> Meshes<'a, 's> {
    fn new(displaced: &'a Displaced<'s>, subject: Subject<'a>) -> Meshes<'a, 's> {
        let view = displaced.camera.raster_view();
        Meshes { displaced, subject, machine: Machine::default(), meshes: vec![], view }
    }
}

impl Sink for Meshes<'_, '_> {
    fn shows(&mut self, bound: &RasterBound) -> bool {
        let [low, high] = self.view;
        bound.max.cmpge(low).all() && bound.min.cmple(high).all()
    }

    fn takes_unseen(&self) -> bool {
        true
    }

    fn take(&mut self, grid: &mut Grid) {
        if self.displaced.is_full() {
            return;
        }
        (self.displaced.displace)(&self.subject, grid, &mut self.machine);
        self.meshes.extend(Mesh::new(grid));
    }
}
