//! What rays meet: surfaces by themselves, and those of solids, of which only the surfaces of the whole count (RISpec 5.9).
//!
//! A ray through solids meets the surfaces of their primitives, each of which it enters or leaves; the ray begins inside of those that
//! it leaves first. A surface is one of the whole where the whole begins or ends with it. Which side of a surface is outside is
//! found by how often a ray from it meets the primitive's surfaces, however the scene turns its normals.

use crate::cpu::bvh::{Bvh, Crossing, Layer};
use crate::cpu::displaced::{Displace, Displaced, is_meshed};
use crate::cpu::mesh::Spot;
use crate::cpu::openness::Surroundings;
use crate::scene::attributes::Attributes;
use crate::scene::camera::Camera;
use crate::scene::facets::{Cut, facets_of};
use crate::scene::shape::Shape;
use crate::scene::solid::{Met, Solids, Walk};
use crate::scene::source::Item;
use crate::scene::world::Scene;
use glam::Vec3;
use rayon::prelude::*;
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::sync::OnceLock;
use std::sync::atomic::AtomicU64;

/// The part of the way to a light at whose end surfaces do not count.
pub const BEFORE_END: f32 = 1.0 - 1e-4;

/// What rounding makes of how far along a ray two facets are that share an edge, in parts of that and of where the ray begins.
pub const ROUNDING: f32 = 1e-5;

/// What rays meet.
#[derive(Default)]
pub struct Rays<'a> {
    surfaces: Bvh,
    displaced: Option<Box<Displaced<'a>>>,
    solids: Option<Hulls<'a>>,
    /// What closes the sky, once a shader asks for that.
    surroundings: OnceLock<Surroundings>,
    /// How much rays have asked.
    pub tally: Tally,
}

/// How much rays have asked, in all.
#[derive(Default)]
pub struct Tally {
    /// Rays of `occlusion`.
    pub occlusion: AtomicU64,
    /// Surface shaders that were run for an opacity.
    pub opacities: AtomicU64,
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
        Rays { surfaces, displaced: displaced(&open), solids, surroundings: OnceLock::new(), tally: Tally::default() }
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

    /// All surfaces along a direction within a length, nearest first; an edge of two facets of a primitive is met once, and faces of it that
    /// lie in one place are each. Of what is round, the second is at least `step` of how far the first is from that.
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
            met.extend(spots.into_iter().map(|(item, spot)| Layer { t: spot.t, item, at_edge: true }));
        }
        if let Some(hulls) = &self.solids {
            let casts = |item: Item| hulls.casts[item.source as usize];
            let mut add = |t, item| met.extend(casts(item).then_some(Layer { t, item, at_edge: true }));
            hulls.surfaces(own, from, dir, bias, &mut add);
        }
        met.retain(|layer| layer.t < length);
        let order = |layer: &Layer| (layer.item.source, layer.item.index);
        met.sort_by(|a, b| a.t.total_cmp(&b.t).then(order(a).cmp(&order(b))));
        met.retain(|layer| !scene.leaves_particle(layer.item, from + dir * layer.t, dir));
        if met.len() > 1 {
            let mut last: HashMap<u32, Layer> = HashMap::new();
            let rounding = ROUNDING * from.abs().max_element();
            met.retain(|layer| {
                let whole = scene.whole_of(layer.item);
                let is_next = |before: &Layer| {
                    let is_behind = layer.t > before.t + ROUNDING * before.t.abs() + rounding;
                    is_behind || !(layer.at_edge || before.at_edge)
                };
                let counts = last.get(&whole).is_none_or(is_next);
                counts.then(|| last.insert(whole, *layer));
                counts
            });
        }
        met.into_iter().map(|layer| (layer.t, layer.item)).collect()
    }

    /// Whether there is anything along a direction, as [`Rays::nearest`] finds it.
    pub fn meets(&self, own: Item, from: Vec3, dir: Vec3, bias: [f32; 2]) -> bool {
        self.surfaces.meets(own, from, dir, bias)
            || self.displaced.as_ref().is_some_and(|displaced| displaced.blocked(from, dir, f32::INFINITY, |_| true))
            || self.solids.as_ref().is_some_and(|hulls| {
                hulls.first(own, from, dir, 0.0, bias, |item| hulls.casts[item.source as usize]).is_some()
            })
    }

    /// The same within a length.
    pub fn meets_within(&self, own: Item, from: Vec3, dir: Vec3, length: f32, bias: [f32; 2]) -> bool {
        self.surfaces.meets_within(own, from, dir, length, bias)
            || self.displaced.as_ref().is_some_and(|displaced| displaced.blocked(from, dir, length, |_| true))
            || self.solids.as_ref().is_some_and(|hulls| {
                let first = hulls.first(own, from, dir, 0.0, bias, |item| hulls.casts[item.source as usize]);
                first.is_some_and(|(t, _)| t < length)
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
    fn new(scene: &Scene, displaced: Option<Box<Displaced<'a>>>, is_still: impl Fn(Item) -> bool + Sync) -> Hulls<'a> {
        let of = |f: &dyn Fn(&crate::scene::attributes::Attributes) -> bool| {
            scene.sources.iter().map(|s| f(&s.attributes)).collect::<Vec<bool>>()
        };
        let mut hulls = Hulls {
            bvh: Bvh::build(scene, &is_still),
            displaced,
            solids: scene.solids.clone(),
            leaves: scene.sources.iter().map(|s| s.attributes.solid).collect(),
            casts: of(&|a| a.casts_shadows),
            outward: vec![],
        };
        let mut primitives: BTreeMap<u32, Vec<Item>> = BTreeMap::new();
        for (s, source) in scene.sources.iter().enumerate() {
            hulls.outward.push(vec![true; if source.attributes.solid.is_some() { source.len() } else { 0 }]);
            if let Some(leaf) = source.attributes.solid.filter(|_| source.repeats.is_empty()) {
                let items = (0..source.len()).map(|i| Item { source: s as u32, index: i as u32 });
                primitives.entry(leaf).or_default().extend(items);
            }
        }
        let primitives: Vec<Vec<Item>> = primitives.into_values().collect();
        let known: Vec<(Vec<bool>, bool)> =
            primitives.par_iter().map(|items| hulls.hull(scene, items, &is_still)).collect();
        for (items, (outward, is_open)) in primitives.iter().zip(known) {
            for (item, outward) in items.iter().zip(outward) {
                hulls.outward[item.source as usize][item.index as usize] = outward;
            }
            if is_open {
                let message = "a primitive of a solid does not enclose a volume: parts of the solid may be missing";
                scene.warnings.add_at(scene.sources[items[0].source as usize].spot, message.into());
            }
        }
        hulls
    }

    /// Of the items of a primitive, which way each is turned, and whether they do not enclose a volume.
    fn hull(&self, scene: &Scene, items: &[Item], is_still: impl Fn(Item) -> bool) -> (Vec<bool>, bool) {
        let facets: Vec<Vec<[Vec3; 3]>> = items.iter().map(|item| self.facets(scene, *item)).collect();
        if facets.iter().all(Vec::is_empty) {
            return (vec![true; items.len()], false);
        }
        let still = Bvh::of(scene, items.iter().copied().filter(|item| is_still(*item)));
        let leaf = self.leaves[items[0].source as usize];
        let count = |from: Vec3, dir: Vec3, bias: f32| {
            let (mut met, mut spots) = (vec![], vec![]);
            still.crossings(None, from, dir, [bias; 2], &mut met);
            if let Some(displaced) = &self.displaced {
                displaced.spots(from, dir, &mut spots);
            }
            met.len() + spots.iter().filter(|(item, _)| self.leaves[item.source as usize] == leaf).count()
        };
        let outward = facets.iter().map(|facets| finds_outward(facets, &count)).collect();
        (outward, is_open(&facets.concat(), &count))
    }

    /// The facets of an item, as rays meet it; none of a whole sphere.
    fn facets(&self, scene: &Scene, item: Item) -> Vec<[Vec3; 3]> {
        let displaced = self.displaced.as_ref().and_then(|displaced| displaced.facets(item));
        displaced.unwrap_or_else(|| still_facets(scene, item))
    }

    /// Whether no light gets through an item that casts shadows.
    fn blocks(&self, item: Item) -> bool {
        self.casts[item.source as usize] && !self.bvh.is_translucent(item)
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

/// Say which primitives that are solids by themselves do not enclose a volume, as they are before displacement.
pub fn say_open(scene: &Scene) {
    let open = scene.solids.lone.par_iter().map(|lone| {
        let of = |s: u32| (0..scene.sources[s as usize].len()).map(move |i| Item { source: s, index: i as u32 });
        let items: Vec<Item> = lone.sources.clone().flat_map(of).collect();
        let bvh = Bvh::of(scene, items.iter().copied());
        let facets: Vec<_> = items.iter().flat_map(|item| still_facets(scene, *item)).collect();
        is_open(&facets, &|from, dir, bias| {
            let mut met = vec![];
            bvh.crossings(None, from, dir, [bias; 2], &mut met);
            met.len()
        })
    });
    let open: Vec<bool> = open.collect();
    for (lone, _) in scene.solids.lone.iter().zip(open).filter(|(_, is_open)| *is_open) {
        let message = "a `SolidBegin \"primitive\"` does not enclose a volume: its surfaces are drawn as they are";
        scene.warnings.add_at(lone.spot, message.into());
    }
}

/// The facets of an item before displacement, as rays meet it; none of a whole sphere.
pub fn still_facets(scene: &Scene, item: Item) -> Vec<[Vec3; 3]> {
    match scene.place(item) {
        (Shape::Patches(patches, _), to_world) => {
            patches.iter().flat_map(|p| facets_of(p, Cut::of(p), to_world)).collect()
        }
        (Shape::Sphere, _) => vec![],
    }
}

/// Whether the cross product of the directions along u and v of an item with these facets points out of its primitive: a ray that way
/// leaves it if it meets an even number of its surfaces, which `count` knows. Of three rays from different places most are believed.
fn finds_outward(facets: &[[Vec3; 3]], count: &impl Fn(Vec3, Vec3, f32) -> usize) -> bool {
    let sums = areas(facets);
    let area = sums.last().copied().unwrap_or(0.0);
    if !(area > 0.0) {
        return true;
    }
    let leaves_it = |part: f32| {
        let [a, b, c] = facets[sums.partition_point(|sum| *sum <= area * part).min(facets.len() - 1)];
        let normal = (b - a).cross(c - a).normalize_or_zero();
        // Less than what is opposite is away: a facet along a bore is as wide as that, and may be much longer.
        let size = (b - a).cross(c - a).length() / (b - a).length().max((c - a).length()).max((c - b).length());
        // Off the middle and the normal, where edges of other surfaces may lie.
        let from = a * 0.41 + b * 0.28 + c * 0.31;
        let dir = (normal + Vec3::new(0.0213, 0.0127, -0.0171)).normalize_or_zero();
        // Where the facet itself lies is known as far as numbers are.
        let bias = (1e-3 * size).max(1e-6 * from.abs().max_element());
        count(from, dir, bias).is_multiple_of(2)
    };
    [0.23, 0.51, 0.83].into_iter().filter(|part| leaves_it(*part)).count() >= 2
}

/// Lines that are drawn through a primitive to find whether it encloses a volume, how many more if one of them says that it does not, and
/// how many of all may say so: one may run through an edge.
const LINES: usize = 128;
const MORE_LINES: usize = 256;
const MOST_ODD: usize = 2;

/// Whether lines through a primitive with these facets, from one side of it to the other, meet its surfaces an odd number of times.
pub fn is_open(facets: &[[Vec3; 3]], count: &impl Fn(Vec3, Vec3, f32) -> usize) -> bool {
    let sums = areas(facets);
    let area = sums.last().copied().unwrap_or(0.0);
    let hull = |(lo, hi): (Vec3, Vec3), p: &Vec3| (lo.min(*p), hi.max(*p));
    let (lo, hi) = facets.iter().flatten().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), hull);
    let size = (hi - lo).length();
    if !(area > 0.0 && size.is_finite()) {
        return false;
    }
    let is_odd = |k: usize, n: usize| {
        let spread = |by: f32| (0.5 + (k + 1) as f32 * by).fract();
        let part = (k as f32 + 0.5) / n as f32;
        let [a, b, c] = facets[sums.partition_point(|sum| *sum <= area * part).min(facets.len() - 1)];
        let (x, y) = (0.25 * spread(0.618_034), 0.25 * spread(0.754_878));
        let through = a + (b - a) * (0.2 + x) + (c - a) * (0.25 + y);
        // All ways alike: by height and turn (Archimedes).
        let (height, turn) = (2.0 * spread(0.569_84) - 1.0, std::f32::consts::TAU * spread(0.682_328));
        let dir = Vec3::new(turn.cos(), turn.sin(), 0.0) * (1.0 - height * height).sqrt() + Vec3::Z * height;
        // From so far away that no facet counts as the one that the line starts from.
        !count(through - dir * (2.0 * size), dir, 0.0).is_multiple_of(2)
    };
    (0..LINES).any(|k| is_odd(k, LINES)) && (0..MORE_LINES).filter(|k| is_odd(*k, MORE_LINES)).count() > MOST_ODD
}

/// Sums of the areas of facets, twice. At a pole a facet has none, or what rounding makes of it, and no normal.
fn areas(facets: &[[Vec3; 3]]) -> Vec<f32> {
    let mut sum = 0.0;
    let areas = facets.iter().map(|[a, b, c]| {
        sum += (b - a).cross(c - a).length();
        sum
    });
    areas.collect()
}
