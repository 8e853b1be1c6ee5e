//! A bounding volume hierarchy over the primitives, for shadows and for shaders that trace.
//!
//! Spheres and ellipsoids are met directly, patches as triangles. A sphere does not shadow itself: it is convex, and where it
//! faces away from the light it is dark already; so shadows need no bias on the very surfaces where a bias would show.

use crate::cpu::tree::Tree;
use crate::scene::facets::{Cut, Sight, meet_triangle, quads_of};
use crate::scene::shape::Shape;
use crate::scene::source::Item;
use crate::scene::world::Scene;
use glam::{Mat4, Vec3};
use rayon::prelude::*;

/// What stops a ray.
#[derive(Clone, Copy, Debug)]
pub enum Occluder {
    Sphere {
        center: Vec3,
        radius: f32,
    },
    /// Index of the matrix that makes it the unit sphere.
    Ellipsoid {
        inverse: u32,
    },
    Triangle {
        corners: [Vec3; 3],
        /// How near the start of a ray it may be in its own way, as it stands off a curved surface; `None` if that is flat.
        room: Option<f32>,
    },
}

/// How far beside a triangle of a solid or of a curved surface, in parts of it, a ray still meets it: what rounding makes of a corner, so
/// that nothing gets through between neighbours.
const BESIDE: f32 = 1e-5;
/// The same of a flat surface: a ray through its very edge meets it, wherever rounding puts the two.
const BESIDE_FLAT: f32 = 1e-6;

/// What rounding makes of places on two surfaces that touch, in parts of their coordinates.
const ROUNDING: f32 = 4e-6;

/// How deep within a sphere a point where another surface touches it may be found, in parts of the radius, besides that.
const ON_ROUND: f32 = 1e-5;

/// How near an edge of a triangle, in parts of it, the triangle beyond it may be met as well.
const AT_EDGE: f32 = 1e-4;

/// A surface in the way of a ray.
#[derive(Clone, Copy)]
pub struct Layer {
    /// How far along it.
    pub t: f32,
    /// What.
    pub item: Item,
    /// Whether another facet of the surface may be met there, too: on an edge that they share.
    pub at_edge: bool,
}

/// Where a ray meets something.
pub struct Crossing {
    /// How far along it.
    pub t: f32,
    /// What.
    pub item: Item,
    /// Of a sphere, whether the ray enters it.
    pub enters: Option<bool>,
    /// The direction's part along the cross product of those along u and v.
    pub along: f32,
}

/// The hierarchy.
#[derive(Default)]
pub struct Bvh {
    tree: Tree,
    occluders: Vec<(Item, Occluder)>,
    inverses: Vec<Mat4>,
    /// By source: light gets through it, in part.
    translucent: Vec<bool>,
    /// Whether that is so of any: each ray that nothing blocks asks.
    any_translucent: bool,
}

impl Bvh {
    /// Build it over those items of a scene.
    pub fn build(scene: &Scene, of: impl Fn(Item) -> bool) -> Bvh {
        let translucent: Vec<bool> = scene.sources.iter().map(|s| !s.blocks_light()).collect();
        let any_translucent = translucent.contains(&true);
        Bvh { translucent, any_translucent, ..Bvh::of(scene, scene.items().filter(|item| of(*item))) }
    }

    /// Build it over some items of a scene, as if all were opaque.
    pub fn of(scene: &Scene, items: impl Iterator<Item = Item>) -> Bvh {
        /// Items whose occluders one thread finds.
        const CHUNK: usize = 1024;
        let items: Vec<Item> = items.collect();
        let of_chunk = |items: &[Item]| {
            let mut own = Bvh::default();
            for item in items {
                let (shape, to_world) = scene.place(*item);
                own.add(*item, shape, to_world);
            }
            own
        };
        let of_chunks: Vec<Bvh> = items.par_chunks(CHUNK).map(of_chunk).collect();
        let mut bvh = Bvh::default();
        of_chunks.into_iter().for_each(|own| bvh.extend(own));
        let (tree, order) = Tree::new(bvh.occluders.par_iter().map(|(_, occluder)| bvh.bound(occluder)));
        bvh.tree = tree;
        bvh.occluders = order.par_iter().with_min_len(CHUNK).map(|k| bvh.occluders[*k as usize]).collect();
        bvh
    }

    /// Add the occluders of another.
    fn extend(&mut self, other: Bvh) {
        let before = self.inverses.len() as u32;
        self.inverses.extend(other.inverses);
        self.occluders.extend(other.occluders.into_iter().map(|(item, occluder)| match occluder {
            Occluder::Ellipsoid { inverse } => (item, Occluder::Ellipsoid { inverse: before + inverse }),
            other => (item, other),
        }));
    }

    fn add(&mut self, item: Item, shape: &Shape, to_world: Mat4) {
        match shape {
            Shape::Sphere => {
                let [x, y, z] = [to_world.x_axis, to_world.y_axis, to_world.z_axis].map(|a| a.truncate().length());
                let even = (x - y).abs() <= 1e-4 * x && (x - z).abs() <= 1e-4 * x;
                let occluder = if even {
                    Occluder::Sphere { center: to_world.w_axis.truncate(), radius: x }
                } else {
                    self.inverses.push(to_world.inverse());
                    Occluder::Ellipsoid { inverse: self.inverses.len() as u32 - 1 }
                };
                self.occluders.push((item, occluder));
            }
            Shape::Patches(patches, _) => {
                for patch in patches.iter() {
                    let cut = Cut::of(patch);
                    for [a, b, c, d] in quads_of(patch, cut, to_world) {
                        let long = [(b - a).length().max((c - d).length()), (d - a).length().max((c - b).length())];
                        let room = (!patch.flat).then(|| (long[0] * cut.room[0]).hypot(long[1] * cut.room[1]));
                        let has_area = |[a, b, c]: &[Vec3; 3]| (*b - *a).cross(*c - *a).length_squared() > 0.0;
                        let sound = [[a, b, c], [a, c, d]].into_iter().filter(has_area);
                        self.occluders.extend(sound.map(|corners| (item, Occluder::Triangle { corners, room })));
                    }
                }
            }
        }
    }

    /// The box around an occluder.
    pub fn bound(&self, occluder: &Occluder) -> (Vec3, Vec3) {
        match *occluder {
            Occluder::Sphere { center, radius } => (center - radius, center + radius),
            Occluder::Ellipsoid { inverse } => {
                let m = self.inverses[inverse as usize].inverse();
                let row = |k: usize| Vec3::new(m.x_axis[k], m.y_axis[k], m.z_axis[k]).length();
                let reach = Vec3::new(row(0), row(1), row(2));
                (m.w_axis.truncate() - reach, m.w_axis.truncate() + reach)
            }
            // A ray along the side of a box may miss it by a not-a-number, and an edge by what rounding makes of that.
            Occluder::Triangle { corners: [a, b, c], .. } => {
                let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
                let room = 1e-6 * lo.abs().max(hi.abs()).max_element();
                (lo - room, hi + room)
            }
        }
    }

    /// The boxes of what stops rays, in whose order [`Bvh::occluders`] has it.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// What stops rays, by leaves.
    pub fn occluders(&self) -> &[(Item, Occluder)] {
        &self.occluders
    }

    /// The matrix of an ellipsoid.
    pub fn inverse(&self, index: u32) -> &Mat4 {
        &self.inverses[index as usize]
    }

    /// Whether light gets through some of what casts shadows, in part.
    pub fn any_translucent(&self) -> bool {
        self.any_translucent
    }

    /// Whether light gets through an item, in part.
    pub fn is_translucent(&self, item: Item) -> bool {
        self.translucent[item.source as usize]
    }

    /// Add all places where a ray of unit direction meets something, in no order. `own` and `bias` as for [`Bvh::nearest`].
    pub fn crossings(&self, own: Option<Item>, from: Vec3, dir: Vec3, bias: [f32; 2], met: &mut Vec<Crossing>) {
        if self.tree.is_empty() || !from.is_finite() || !dir.is_finite() {
            return;
        }
        let way = [from, dir];
        self.tree.leaves(from, dir, f32::INFINITY, |leaf, length| {
            for (item, occluder) in &self.occluders[leaf] {
                let is_own = own == Some(*item);
                let mut push =
                    |t: Option<f32>, enters, along| met.extend(t.map(|t| Crossing { t, item: *item, enters, along }));
                if let Occluder::Triangle { corners, room } = *occluder {
                    let [ab, ac] = edges_of(corners);
                    let near = match room {
                        // Of the numbers' rounding alone: what is opposite may be as near as a solid is thin.
                        None => bias[0].min(1e-5 * ab.length().max(ac.length()) + 1e-6 * from.abs().max_element()),
                        Some(room) => bias[is_own as usize].max(facet_room(room, is_own)),
                    };
                    // A ray through a corner meets a triangle there, at least: of two that share an edge, one counts.
                    let t =
                        meet_triangle(&Sight::new(from, dir), corners, BESIDE).map(|(t, _)| t).filter(|t| *t > near);
                    push(t, None, dir.dot(ab.cross(ac)));
                    continue;
                }
                let first = self.distance(is_own, occluder, way, 0.0, bias);
                let other = first.and_then(|t| self.distance(is_own, occluder, way, t * (1.0 + 1e-6), bias));
                // Of two crossings of a sphere the first enters; a lone one leaves it.
                push(first, Some(other.is_some()), 0.0);
                push(other, Some(false), 0.0);
            }
            Some(length)
        });
    }

    /// Whether anything that lets no light through stands between two points. How near the start the triangles of `own` itself do not
    /// count is `bias[1]`, those of others what rounding makes, at most `bias[0]`; the spheres and flat patches of `own` never count.
    pub fn blocked(&self, own: Item, from: Vec3, to: Vec3, bias: [f32; 2]) -> bool {
        if self.tree.is_empty() {
            return false;
        }
        let way = to - from;
        let length = way.length();
        if !(length > 0.0) || !from.is_finite() {
            return false;
        }
        let dir = way / length;
        let (mut blocked, way) = (false, [from, dir]);
        self.tree.leaves(from, dir, length, |leaf, length| {
            blocked = self.occluders[leaf].iter().any(|(item, o)| {
                !self.translucent[item.source as usize] && self.stops(*item == own, o, way, length, bias)
            });
            (!blocked).then_some(length)
        });
        blocked
    }

    /// The nearest thing along a direction of unit length from `least` on, for a ray from a surface of `own`: how far, and what. Of things as
    /// far as each other, but for rounding, it is the first of the scene, as the camera sees it.
    pub fn nearest(&self, own: Item, from: Vec3, dir: Vec3, least: f32, bias: [f32; 2]) -> Option<(f32, Item)> {
        if self.tree.is_empty() || !from.is_finite() || !dir.is_finite() {
            return None;
        }
        let (mut best, way): (Option<(f32, Item)>, _) = (None, [from, dir]);
        let reach = from.abs().max_element();
        let room = |t: f32| ROUNDING * (t + reach);
        self.tree.leaves(from, dir, f32::INFINITY, |leaf, _| {
            for (item, occluder) in &self.occluders[leaf] {
                let Some(t) = self.met(*item == own, occluder, way, least, bias) else { continue };
                let goes_before = best.is_none_or(|(known, first)| {
                    let is_first = (item.source, item.index) < (first.source, first.index);
                    t < if is_first { known + room(known) } else { known - room(known) }
                });
                if goes_before {
                    best = Some((t, *item));
                }
            }
            Some(best.map_or(f32::INFINITY, |(t, _)| t + room(t)))
        });
        best
    }

    /// Add all surfaces along a direction of unit length within a length, each as [`Bvh::nearest`] finds it, in no order; those of one
    /// thing are at least `step` of how far they are from each other.
    #[allow(clippy::too_many_arguments)]
    pub fn layers(
        &self,
        own: Item,
        from: Vec3,
        dir: Vec3,
        length: f32,
        bias: [f32; 2],
        step: impl Fn(f32) -> f32,
        out: &mut Vec<Layer>,
    ) {
        if self.tree.is_empty() || !from.is_finite() || !dir.is_finite() {
            return;
        }
        let way = [from, dir];
        self.tree.leaves(from, dir, length, |leaf, length| {
            for (item, occluder) in &self.occluders[leaf] {
                if let Occluder::Triangle { corners, .. } = *occluder {
                    let t = self.met(*item == own, occluder, way, 0.0, bias).filter(|t| *t < length);
                    out.extend(t.map(|t| Layer { t, item: *item, at_edge: is_at_edge(way, corners) }));
                    continue;
                }
                let mut least = 0.0;
                while let Some(t) = self.met(*item == own, occluder, way, least, bias).filter(|t| *t < length) {
                    out.push(Layer { t, item: *item, at_edge: true });
                    least = t + step(t);
                }
            }
            Some(length)
        });
    }

    /// Whether there is anything along a direction of unit length, as [`Bvh::nearest`] finds it.
    pub fn meets(&self, own: Item, from: Vec3, dir: Vec3, bias: [f32; 2]) -> bool {
        self.meets_within(own, from, dir, f32::INFINITY, bias)
    }

    /// The same within a length.
    pub fn meets_within(&self, own: Item, from: Vec3, dir: Vec3, length: f32, bias: [f32; 2]) -> bool {
        if self.tree.is_empty() || !from.is_finite() || !dir.is_finite() {
            return false;
        }
        let (mut meets, way) = (false, [from, dir]);
        self.tree.leaves(from, dir, length, |leaf, length| {
            meets = self.occluders[leaf]
                .iter()
                .any(|(item, occluder)| self.met(*item == own, occluder, way, 0.0, bias).is_some_and(|t| t < length));
            (!meets).then_some(length)
        });
        meets
    }

    /// As [`Bvh::distance`], but that a ray from where another surface touches a round one does not meet that on its way out.
    fn met(
        &self,
        own: bool,
        occluder: &Occluder,
        way @ [from, dir]: [Vec3; 2],
        least: f32,
        bias: [f32; 2],
    ) -> Option<f32> {
        let touches = !own
            && match *occluder {
                Occluder::Sphere { center, radius } => leaves_sphere(center - from, dir, radius, from, bias[0]),
                Occluder::Ellipsoid { inverse } => leaves_ellipsoid(&self.inverses[inverse as usize], way, bias[0]),
                Occluder::Triangle { .. } => false,
            };
        if touches { None } else { self.distance(own, occluder, way, least, bias) }
    }

    /// How far along a ray an occluder is met, from `least` on, and beyond what it cannot mean: the surface that the ray starts
    /// from, where it stands off what was shaded. `bias` as for [`Bvh::blocked`].
    fn distance(
        &self,
        own: bool,
        occluder: &Occluder,
        [from, dir]: [Vec3; 2],
        least: f32,
        bias: [f32; 2],
    ) -> Option<f32> {
        // The nearer crossing that is far enough.
        let root = |a: f32, b: f32, c: f32, near: f32| {
            let disc = b * b - a * c;
            let half = disc.max(0.0).sqrt();
            [(-b - half) / a, (-b + half) / a].into_iter().find(|t| disc > 0.0 && *t > near.max(least))
        };
        // Of a displaced sphere nobody knows where it was met.
        let displaced = own && bias[1] > bias[0];
        match *occluder {
            Occluder::Sphere { .. } | Occluder::Ellipsoid { .. } if displaced => None,
            Occluder::Sphere { center, radius } => {
                let o = from - center;
                let near = if own { bias[1].min(0.5 * radius) } else { 0.0 };
                root(1.0, o.dot(dir), o.length_squared() - radius * radius, near)
            }
            Occluder::Ellipsoid { inverse } => {
                let m = &self.inverses[inverse as usize];
                let (o, d) = (m.transform_point3(from), m.transform_vector3(dir));
                root(d.length_squared(), o.dot(d), o.length_squared() - 1.0, if own { bias[1] } else { 0.0 })
            }
            Occluder::Triangle { room: None, .. } if own => None,
            Occluder::Triangle { corners, room } => {
                let near = near_start(own, room, edges_of(corners), from, bias);
                let beside = if room.is_some() { BESIDE } else { BESIDE_FLAT };
                meet_triangle(&Sight::new(from, dir), corners, beside).map(|(t, _)| t).filter(|t| *t > near.max(least))
            }
        }
    }

    #[inline]
    fn stops(&self, own: bool, occluder: &Occluder, [from, dir]: [Vec3; 2], length: f32, bias: [f32; 2]) -> bool {
        match *occluder {
            Occluder::Sphere { center, radius } => {
                !own && {
                    let to = center - from;
                    let along = to.dot(dir);
                    let off2 = (to - dir * along).length_squared();
                    let r2 = radius * radius;
                    off2 < r2 && {
                        let half = (r2 - off2).sqrt();
                        along + half > 0.0 && along - half < length && !leaves_sphere(to, dir, radius, from, bias[0])
                    }
                }
            }
            Occluder::Ellipsoid { inverse } => {
                !own && {
                    let m = &self.inverses[inverse as usize];
                    let (o, d) = (m.transform_point3(from), m.transform_vector3(dir));
                    let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared() - 1.0);
                    let disc = b * b - a * c;
                    disc > 0.0 && {
                        let root = disc.sqrt();
                        root - b > 0.0 && (-b - root) < length * a && !leaves_ellipsoid(m, [from, dir], bias[0])
                    }
                }
            }
            Occluder::Triangle { corners, room } => {
                let beside = if room.is_some() { BESIDE } else { BESIDE_FLAT };
                !(own && room.is_none())
                    && meet_triangle(&Sight::new(from, dir), corners, beside)
                        .is_some_and(|(t, _)| t < length && t > near_start(own, room, edges_of(corners), from, bias))
            }
        }
    }
}

/// Whether a ray begins on a sphere, or hardly within, and goes outwards: `to` is the way to its middle.
#[inline(always)]
fn leaves_sphere(to: Vec3, dir: Vec3, radius: f32, from: Vec3, bias: f32) -> bool {
    to.dot(dir) <= 0.0 && {
        let least = radius - bias.min(ON_ROUND * radius + ROUNDING * from.abs().max_element());
        to.length_squared() >= least * least
    }
}

/// The same of an ellipsoid, by the matrix that makes it the unit sphere.
#[inline(always)]
fn leaves_ellipsoid(m: &Mat4, [from, dir]: [Vec3; 2], bias: f32) -> bool {
    let (o, d) = (m.transform_point3(from), m.transform_vector3(dir));
    o.dot(d) >= 0.0 && {
        let rounding = ON_ROUND + ROUNDING * m.transform_vector3(from).abs().max_element();
        let least = 1.0 - rounding.min(bias * d.length());
        o.length_squared() >= least * least
    }
}

/// Whether a ray meets a triangle so near an edge that it may meet the one beyond it as well.
fn is_at_edge([from, dir]: [Vec3; 2], corners: [Vec3; 3]) -> bool {
    let met = meet_triangle(&Sight::new(from, dir), corners, BESIDE);
    met.is_none_or(|(_, [u, v])| u.min(v).min(1.0 - u - v) < AT_EDGE)
}

/// The edges of a triangle from its first corner.
#[inline(always)]
fn edges_of([a, b, c]: [Vec3; 3]) -> [Vec3; 2] {
    [b - a, c - a]
}

/// How near the start of a ray from a surface a triangle does not count: of the surface's own where it may have been shaded, of others
/// where rounding may put it, and as far as it stands off its own curved surface.
#[inline(always)]
fn near_start(own: bool, room: Option<f32>, [ab, ac]: [Vec3; 2], from: Vec3, bias: [f32; 2]) -> f32 {
    let room = facet_room(room.unwrap_or(0.0), own);
    if own {
        return bias[1].max(room);
    }
    let size = ab.length_squared().max(ac.length_squared()).sqrt();
    bias[0].min(1e-5 * size + ROUNDING * from.abs().max_element()).max(room)
}

/// How near its start a ray passes a facet of a curved surface, which stands off the surface: its own neighbourhood is not in its
/// shadow.
fn facet_room(room: f32, own: bool) -> f32 {
    room * if own { 2.0 } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shadows end on lines of points where edges of flat surfaces, and what they shade, are cut alike: rounding says nothing there.
    #[test]
    fn a_ray_through_an_edge_of_a_flat_surface_meets_it() {
        let mut state = 1u64;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u64 << 23) as f32 - 1.0
        };
        let mut place = |size: f32| Vec3::new(number(), number(), number()) * size;
        let (item, other) = (Item { source: 0, index: 0 }, Item { source: 0, index: 1 });
        let mut n = 0;
        for k in 0..1000 {
            let corners = [place(4.0), place(4.0), place(4.0)];
            let [a, b] = [corners[k % 3], corners[(k + 1) % 3]];
            let (from, edge) = (place(2.0), a + (b - a) * (0.2 + 0.6 * (k % 7) as f32 / 7.0));
            let across = edges_of(corners)[0].cross(edges_of(corners)[1]);
            // Of a triangle that is seen edge-on, or is a needle, nothing is known.
            if across.dot((edge - from).normalize()).abs() < 8.0 {
                continue;
            }
            let mut bvh = Bvh { translucent: vec![false], ..Bvh::default() };
            bvh.occluders = vec![(item, Occluder::Triangle { corners, room: None })];
            let bound = bvh.bound(&bvh.occluders[0].1);
            bvh.tree = Tree::new([bound].into_par_iter()).0;
            assert!(bvh.blocked(other, from, edge + (edge - from), [0.0; 2]), "{corners:?} from {from} by {edge}");
            n += 1;
        }
        assert!(n > 300, "{n} rays");
    }
}
