//! What rays meet: surfaces by themselves, and those of solids, of which only the surfaces of the whole count (RISpec 5.9).
//!
//! A ray through solids meets the surfaces of their primitives, each of which it enters or leaves; the ray begins inside of those that
//! it leaves first. A surface is one of the whole where the whole begins or ends with it. Which side of a surface is outside is
//! found by how often a ray from it meets the primitive's surfaces, however the scene turns its normals.

use crate::cpu::bvh::{Bvh, Crossing};
use crate::cpu::displaced::{Displace, Displaced, is_meshed};
use crate::cpu::mesh::Spot;
use crate::cpu::openness::Surroundings;
use crate::scene::attributes::Attributes;
use crate::scene::camera::Camera;
use crate::scene::facets::{Cut, facets_of};
use crate::scene::shape::Shape;
use crate::scene::solid::{Met, Solids, Walk};
use crate::scene::source::{Item, Source};
use crate::scene::world::Scene;
use glam::{Quat, Vec3};
use rayon::prelude::*;
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::sync::OnceLock;

/// The part of the way to a light at whose end surfaces do not count.
pub const BEFORE_END: f32 = 1.0 - 1e-4;

/// What rays meet.
#[derive(Default)]
pub struct Rays<'a> {
    surfaces: Bvh,
    displaced: Option<Box<Displaced<'a>>>,
    solids: Option<Hulls<'a>>,
    /// What closes the sky, once a shader asks for that.
    surroundings: OnceLock<Surroundings>,
}

/// The surfaces of solids.
struct Hulls<'a> {
    bvh: Bvh,
    displaced: Option<Box<Displaced<'a>>>,
    solids: Solids,
    /// By source: the primitive of a solid that it is a part of.
    leaves: Vec<Option<u32>>,
    /// By source: whether it casts shadows, and whether light gets through it, in part.
    casts: Vec<bool>,
    /// By source and item: whether the cross product of the directions along u and v points out of the primitive.
    outward: Vec<Vec<bool>>,
}

impl<'a> Rays<'a> {
    /// Over all items of a scene, displaced as this camera sees them.
    pub fn new(scene: &'a Scene, camera: &Camera, displace: &Displace<'a>) -> Rays<'a> {
        let of = |item: Item| &*scene.sources[item.source as usize].attributes;
        let has_rays = scene.sources.iter().any(|source| source.attributes.traces());
        let meshed = |item: Item| has_rays && is_meshed(scene, camera, item);
        let open = |item: Item| has_rays && of(item).casts_shadows && of(item).solid.is_none();
        let displaced = |are: &dyn Fn(Item) -> bool| {
            let items: Vec<Item> = scene.items().filter(|i| are(*i) && meshed(*i)).collect();
            (!items.is_empty()).then(|| Box::new(Displaced::new(scene, camera, items, displace.clone())))
        };
        let is_part = |item: Item| of(item).solid.is_some();
        let hulls = || Hulls::new(scene, displaced(&is_part), |item| is_part(item) && !meshed(item));
        let solids = scene.sources.iter().any(|s| s.attributes.solid.is_some()).then(hulls);
        let surfaces = Bvh::build(scene, |item| open(item) && !meshed(item));
        Rays { surfaces, displaced: displaced(&open), solids, surroundings: OnceLock::new() }
    }

    /// What displacement shaders meet, if any of a scene traces: what does not itself wait for such a shader.
    pub fn of_displacement(scene: &Scene) -> Rays<'a> {
        let traces = |a: &Attributes| a.displacement.as_ref().is_some_and(|shader| shader.program.traces);
        let is_asked = scene.sources.iter().any(|source| traces(&source.attributes));
        let is_met = |a: &Attributes| a.casts_shadows && a.solid.is_none() && a.displacement.is_none();
        let met = |item: Item| is_asked && is_met(&scene.sources[item.source as usize].attributes);
        Rays { surfaces: Bvh::build(scene, met), ..Rays::default() }
    }

    /// What they meet, undisplaced and displaced, if none of it is of solids.
    pub fn open_surfaces(&self) -> Option<(&Bvh, Option<&Displaced<'a>>)> {
        self.solids.is_none().then_some((&self.surfaces, self.displaced.as_deref()))
    }

    /// Whether rays meet an item as displaced.
    pub fn meets_displaced(&self, item: Item) -> bool {
        self.all_displaced().any(|displaced| displaced.has(item))
    }

    /// Where a ray meets an item that is displaced, nearest to a distance.
    pub fn spot(&self, item: Item, from: Vec3, dir: Vec3, distance: f32) -> Option<Spot> {
        self.all_displaced().find_map(|displaced| displaced.spot(item, from, dir, distance))
    }

    /// What closes the sky of a scene, which must be that of the rays.
    pub fn surroundings(&self, scene: &Scene) -> &Surroundings {
        self.surroundings.get_or_init(|| Surroundings::new(scene))
    }

    fn all_displaced(&self) -> impl Iterator<Item = &Displaced<'a>> {
        let hulls = self.solids.as_ref().and_then(|hulls| hulls.displaced.as_deref());
        self.displaced.as_deref().into_iter().chain(hulls)
    }

    /// Whether light gets through some of what casts shadows, in part.
    pub fn any_translucent(&self) -> bool {
        self.surfaces.any_translucent()
    }

    /// As [`Bvh::blocked`].
    pub fn blocked(&self, own: Item, from: Vec3, to: Vec3, bias: [f32; 2]) -> bool {
        // What a lamp lies in, as in a ceiling, is not between.
        let to = from + (to - from) * BEFORE_END;
        self.surfaces.blocked(own, from, to, bias)
            || self.displaced.as_ref().is_some_and(|displaced| {
                let (way, length) = (to - from, (to - from).length());
                length > 0.0
                    && displaced.blocked(from, way / length, length, |item| !self.surfaces.is_translucent(item))
            })
            || self.solids.as_ref().is_some_and(|hulls| {
                let (way, length) = (to - from, (to - from).length());
                let first = || hulls.first(own, from, way / length, 0.0, bias, |item| hulls.blocks(item));
                length > 0.0 && first().is_some_and(|(t, _)| t < length)
            })
    }

    /// As [`Bvh::nearest`].
    pub fn nearest(&self, own: Item, from: Vec3, dir: Vec3, least: f32, bias: [f32; 2]) -> Option<(f32, Item)> {
        let open = self.surfaces.nearest(own, from, dir, least, bias);
        let displaced = self.displaced.as_ref().and_then(|displaced| displaced.nearest(from, dir, least));
        let solid = self
            .solids
            .as_ref()
            .and_then(|hulls| hulls.first(own, from, dir, least, bias, |item| hulls.casts[item.source as usize]));
        [open, displaced, solid].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// All surfaces along a direction within a length, nearest first. Those of one thing are at least `step` of how far they are from each
    /// other: what is an edge of two of its facets is met once.
    #[allow(clippy::too_many_arguments)]
    pub fn layers(
        &self,
        scene: &Scene,
        own: Item,
        from: Vec3,
        dir: Vec3,
        length: f32,
        bias: [f32; 2],
        step: impl Fn(f32) -> f32,
    ) -> Vec<(f32, Item)> {
        let mut met = vec![];
        self.surfaces.layers(own, from, dir, length, bias, &step, &mut met);
        if let Some(displaced) = &self.displaced {
            let mut spots = vec![];
            displaced.spots(from, dir, &mut spots);
            met.extend(spots.into_iter().map(|(item, spot)| (spot.t, item)));
        }
        if let Some(hulls) = &self.solids {
            let casts = |item: Item| hulls.casts[item.source as usize];
            hulls.surfaces(own, from, dir, bias, |t, item| met.extend(casts(item).then_some((t, item))));
        }
        met.retain(|(t, _)| *t < length);
        met.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1.source, a.1.index).cmp(&(b.1.source, b.1.index))));
        if met.len() > 1 {
            let mut last: HashMap<_, f32> = HashMap::new();
            met.retain(|(t, item)| {
                let before = last.entry(scene.whole_of(*item)).or_insert(f32::NEG_INFINITY);
                let counts = *t > *before + step(*before);
                *before = if counts { *t } else { *before };
                counts
            });
        }
        met
    }

    /// Whether there is anything along a direction, as [`Rays::nearest`] finds it.
    pub fn meets(&self, own: Item, from: Vec3, dir: Vec3, bias: [f32; 2]) -> bool {
        self.surfaces.meets(own, from, dir, bias)
            || self.displaced.as_ref().is_some_and(|displaced| displaced.blocked(from, dir, f32::INFINITY, |_| true))
            || self.solids.as_ref().is_some_and(|hulls| {
                hulls.first(own, from, dir, 0.0, bias, |item| hulls.casts[item.source as usize]).is_some()
            })
    }

    /// Whether the cross product of the directions along u and v of a primitive of a solid points out of it.
    pub fn is_outward(&self, item: Item) -> bool {
        let known =
            self.solids.as_ref().and_then(|hulls| hulls.outward.get(item.source as usize)?.get(item.index as usize));
        known.copied().unwrap_or(true)
    }
}

thread_local! {
    /// The walk of a thread, whose memory is kept from ray to ray.
    static WALK: RefCell<Walk> = RefCell::default();
}

impl<'a> Hulls<'a> {
    fn new(scene: &Scene, displaced: Option<Box<Displaced<'a>>>, is_still: impl Fn(Item) -> bool) -> Hulls<'a> {
        let of = |f: &dyn Fn(&crate::scene::attributes::Attributes) -> bool| {
            scene.sources.iter().map(|s| f(&s.attributes)).collect::<Vec<bool>>()
        };
        let mut hulls = Hulls {
            bvh: Bvh::build(scene, is_still),
            displaced,
            solids: scene.solids.clone(),
            leaves: scene.sources.iter().map(|s| s.attributes.solid).collect(),
            casts: of(&|a| a.casts_shadows),
            outward: vec![],
        };
        let all = scene.sources.par_iter().enumerate().map(|(s, source)| {
            let n = if source.attributes.solid.is_some() { source.len() } else { 0 };
            let is_met = source.duplicates.is_empty();
            (0..n).map(|i| !is_met || hulls.finds_outward(scene, Item { source: s as u32, index: i as u32 })).collect()
        });
        let outward = all.collect();
        hulls.outward = outward;
        hulls.say_open(scene);
        hulls
    }

    /// Say which primitives do not enclose a volume.
    fn say_open(&self, scene: &Scene) {
        let is_open = |(s, source): (usize, &Source)| {
            let n = if source.attributes.solid.is_some() && source.duplicates.is_empty() { source.len() } else { 0 };
            (0..n).any(|i| self.is_open(scene, Item { source: s as u32, index: i as u32 }))
        };
        let open: Vec<bool> = scene.sources.par_iter().enumerate().map(is_open).collect();
        let mut said = HashSet::new();
        for (source, _) in scene.sources.iter().zip(open).filter(|(_, open)| *open) {
            if said.insert(source.attributes.solid) {
                let message = "a primitive of a solid does not enclose a volume: parts of the solid may be missing";
                scene.warnings.add_at(source.spot, message.into());
            }
        }
    }

    /// Whether lines through an item pass through its primitive's surfaces an odd number of times: two of six, since one may run through
    /// an edge.
    fn is_open(&self, scene: &Scene, item: Item) -> bool {
        let facets = self.facets(scene, item);
        let leaf = self.leaves[item.source as usize];
        let is_odd = |k: &usize| {
            let [a, b, c] = facets[(facets.len() * (2 * k + 1)) / 12];
            let (along, normal) = ((b - a).normalize_or_zero(), (b - a).cross(c - a).normalize_or_zero());
            let size = (b - a).cross(c - a).length() / (b - a).length().max((c - a).length()).max((c - b).length());
            if !(size > 0.0) {
                return false;
            }
            // Askew, each another way: straight through a wall without ends a line meets the wall over against it.
            let turned = Quat::from_axis_angle(normal, *k as f32 * 1.1 + 0.3) * along;
            let dir = (turned * 0.94 + normal * 0.34 + Vec3::new(0.0213, 0.0127, -0.0171)).normalize_or_zero();
            let from = a * 0.41 + b * 0.28 + c * 0.31;
            let mut met = vec![];
            for dir in [dir, -dir] {
                self.crossings(None, from, dir, [1e-3 * size; 2], &mut met);
            }
            met.iter().filter(|m| self.leaves[m.item.source as usize] == leaf).count() % 2 == 0
        };
        !facets.is_empty() && (0..6).filter(is_odd).count() >= 2
    }

    /// The facets of an item, as rays meet it; none of a whole sphere.
    fn facets(&self, scene: &Scene, item: Item) -> Vec<[Vec3; 3]> {
        let (shape, to_world) = scene.place(item);
        let displaced = self.displaced.as_ref().and_then(|displaced| displaced.facets(item));
        match (displaced, shape) {
            (Some(facets), _) => facets,
            (None, Shape::Patches(patches, _)) => {
                patches.iter().flat_map(|p| facets_of(p, Cut::of(p), to_world)).collect()
            }
            (None, Shape::Sphere) => vec![],
        }
    }

    /// Whether no light gets through an item that casts shadows.
    fn blocks(&self, item: Item) -> bool {
        self.casts[item.source as usize] && !self.bvh.is_translucent(item)
    }

    /// Whether the cross product of the directions along u and v of an item points out of its primitive: a ray that way leaves it if
    /// it meets an even number of its surfaces. Of three rays from different places most are believed.
    fn finds_outward(&self, scene: &Scene, item: Item) -> bool {
        let facets = self.facets(scene, item);
        // By area: at a pole a facet has none, or what rounding makes of it, and no normal.
        let mut area = 0.0;
        let sums = facets.iter().map(|[a, b, c]| {
            area += (b - a).cross(c - a).length();
            area
        });
        let sums: Vec<f32> = sums.collect();
        if !(area > 0.0) {
            return true;
        }
        let leaf = self.leaves[item.source as usize];
        let leaves_it = |part: f32| {
            let [a, b, c] = facets[sums.partition_point(|sum| *sum <= area * part).min(facets.len() - 1)];
            let normal = (b - a).cross(c - a).normalize_or_zero();
            // Less than what is opposite is away: a facet along a bore is as wide as that, and may be much longer.
            let size = (b - a).cross(c - a).length() / (b - a).length().max((c - a).length()).max((c - b).length());
            // Off the middle and the normal, where edges of other surfaces may lie.
            let from = a * 0.41 + b * 0.28 + c * 0.31;
            let dir = (normal + Vec3::new(0.0213, 0.0127, -0.0171)).normalize_or_zero();
            let mut met = vec![];
            self.crossings(None, from, dir, [1e-3 * size; 2], &mut met);
            met.iter().filter(|m| self.leaves[m.item.source as usize] == leaf).count() % 2 == 0
        };
        [0.23, 0.51, 0.83].into_iter().filter(|part| leaves_it(*part)).count() >= 2
    }

    /// Add all places where a ray meets a surface of a primitive, as [`Bvh::crossings`].
    fn crossings(&self, own: Option<Item>, from: Vec3, dir: Vec3, bias: [f32; 2], met: &mut Vec<Crossing>) {
        self.bvh.crossings(own, from, dir, bias, met);
        let mut spots = vec![];
        if let Some(displaced) = &self.displaced {
            displaced.spots(from, dir, &mut spots);
        }
        met.extend(spots.iter().map(|(item, s)| Crossing { t: s.t, item: *item, enters: None, along: s.along }));
    }

    /// Which way a ray goes through a surface that it meets.
    fn enters(&self, met: &Crossing) -> bool {
        match met.enters {
            Some(enters) => enters,
            None => (met.along < 0.0) == self.outward[met.item.source as usize][met.item.index as usize],
        }
    }

    /// The first surface of a whole along a ray, from `least` on, that counts.
    fn first(
        &self,
        own: Item,
        from: Vec3,
        dir: Vec3,
        least: f32,
        bias: [f32; 2],
        counts: impl Fn(Item) -> bool,
    ) -> Option<(f32, Item)> {
        let mut first: Option<(f32, Item)> = None;
        self.surfaces(own, from, dir, bias, |t, item| {
            if t > least && first.is_none_or(|(before, _)| t < before) && counts(item) {
                first = Some((t, item));
            }
        });
        first
    }

    /// Visit the surfaces of wholes along a ray.
    fn surfaces(&self, own: Item, from: Vec3, dir: Vec3, bias: [f32; 2], mut visit: impl FnMut(f32, Item)) {
        let mut met = vec![];
        self.crossings(Some(own), from, dir, bias, &mut met);
        if met.is_empty() {
            return;
        }
        met.sort_by(|a, b| a.t.total_cmp(&b.t).then((a.item.source, a.item.index).cmp(&(b.item.source, b.item.index))));
        let placed = |(name, m): (usize, &Crossing)| {
            let leaf = self.leaves[m.item.source as usize]?;
            Some(Met { at: m.t, leaf, enters: self.enters(m), name: name as u32 })
        };
        let mut line: Vec<Met> = met.iter().enumerate().filter_map(placed).collect();
        WALK.with_borrow_mut(|walk| {
            let kept = walk.surfaces(&self.solids, &mut line);
            let surfaces = line.iter().zip(kept).filter(|(_, kept)| **kept).map(|(m, _)| &met[m.name as usize]);
            surfaces.for_each(|m| visit(m.t, m.item));
        });
    }
}
