//! A bounding volume hierarchy over the primitives, for shadows and for shaders that trace.
//!
//! Spheres and ellipsoids are met directly, patches as triangles. A sphere does not shadow itself: it is convex, and where it
//! faces away from the light it is dark already; so shadows need no bias on the very surfaces where a bias would show.

use crate::scene::attributes::Attributes;
use crate::scene::facets::{facets_of, meet_triangle};
use crate::scene::shape::Shape;
use crate::scene::source::Item;
use crate::scene::world::Scene;
use glam::{Mat4, Vec3, Vec3A, Vec4};
use rayon::prelude::*;

/// What stops a ray.
#[derive(Clone, Copy, Debug)]
enum Occluder {
    Sphere {
        center: Vec3,
        radius: f32,
    },
    /// Index of the matrix that makes it the unit sphere.
    Ellipsoid {
        inverse: u32,
    },
    Triangle {
        a: Vec3,
        ab: Vec3,
        ac: Vec3,
        flat: bool,
    },
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

/// A node: a leaf has `count` occluders from `at`, an inner node its second child at `at` and the first right behind it. Both
/// numbers stand, by their bits, behind the corners of the box, so that a node is half a cache line.
#[derive(Clone, Copy, Debug)]
struct Node {
    min_at: Vec4,
    max_count: Vec4,
}

impl Node {
    fn new((min, max): (Vec3A, Vec3A), at: u32, count: u32) -> Node {
        Node { min_at: min.extend(f32::from_bits(at)), max_count: max.extend(f32::from_bits(count)) }
    }

    #[inline(always)]
    fn bounds(&self) -> (Vec3A, Vec3A) {
        (Vec3A::from_vec4(self.min_at), Vec3A::from_vec4(self.max_count))
    }

    #[inline(always)]
    fn at(&self) -> u32 {
        self.min_at.w.to_bits()
    }

    #[inline(always)]
    fn count(&self) -> u32 {
        self.max_count.w.to_bits()
    }
}

/// The hierarchy.
#[derive(Default)]
pub struct Bvh {
    nodes: Vec<Node>,
    occluders: Vec<(Item, Occluder)>,
    inverses: Vec<Mat4>,
    /// By source: light gets through it, in part.
    translucent: Vec<bool>,
}

/// Occluders of a leaf.
const LEAF: usize = 4;

impl Bvh {
    /// Build it over the items of a scene whose attributes are such.
    pub fn build(scene: &Scene, of: impl Fn(&Attributes) -> bool) -> Bvh {
        let translucent = scene.sources.iter().map(|s| !s.attributes.blocks_light()).collect();
        let mut bvh = Bvh { translucent, ..Bvh::default() };
        for item in scene.items() {
            if of(&scene.sources[item.source as usize].attributes) {
                let (shape, to_world) = scene.place(item);
                bvh.add(item, shape, to_world);
            }
        }
        let boxed = |(k, (_, occluder)): (usize, &(Item, Occluder))| {
            let (min, max) = bvh.bound(occluder);
            Boxed { min: min.extend(f32::from_bits(k as u32)), max: max.extend(0.0) }
        };
        let mut boxes: Vec<Boxed> = bvh.occluders.par_iter().enumerate().map(boxed).collect();
        if !boxes.is_empty() {
            bvh.nodes = split(&mut boxes, 0);
        }
        bvh.occluders = boxes.iter().map(|x| bvh.occluders[x.min.w.to_bits() as usize]).collect();
        bvh
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
                    let facets = facets_of(patch, to_world).map(|[a, b, c]| (a, b - a, c - a));
                    let sound = facets.filter(|(_, ab, ac)| ab.cross(*ac).length_squared() > 0.0);
                    let triangles = sound.map(|(a, ab, ac)| Occluder::Triangle { a, ab, ac, flat: patch.flat });
                    self.occluders.extend(triangles.map(|triangle| (item, triangle)));
                }
            }
        }
    }

    fn bound(&self, occluder: &Occluder) -> (Vec3, Vec3) {
        match *occluder {
            Occluder::Sphere { center, radius } => (center - radius, center + radius),
            Occluder::Ellipsoid { inverse } => {
                let m = self.inverses[inverse as usize].inverse();
                let row = |k: usize| Vec3::new(m.x_axis[k], m.y_axis[k], m.z_axis[k]).length();
                let reach = Vec3::new(row(0), row(1), row(2));
                (m.w_axis.truncate() - reach, m.w_axis.truncate() + reach)
            }
            Occluder::Triangle { a, ab, ac, .. } => (a.min(a + ab).min(a + ac), a.max(a + ab).max(a + ac)),
        }
    }

    /// Whether light gets through some of what casts shadows, in part.
    pub fn any_translucent(&self) -> bool {
        self.translucent.contains(&true)
    }

    /// Whether light gets through an item, in part.
    pub fn is_translucent(&self, item: Item) -> bool {
        self.translucent[item.source as usize]
    }

    /// Add all places where a ray of unit direction meets something, in no order. `own` and `bias` as for [`Bvh::nearest`].
    pub fn crossings(&self, own: Option<Item>, from: Vec3, dir: Vec3, bias: [f32; 2], met: &mut Vec<Crossing>) {
        if self.nodes.is_empty() || !from.is_finite() || !dir.is_finite() {
            return;
        }
        self.leaves(from, dir, f32::INFINITY, |leaf, length| {
            for (item, occluder) in leaf {
                let is_own = own == Some(*item);
                let mut push =
                    |t: Option<f32>, enters, along| met.extend(t.map(|t| Crossing { t, item: *item, enters, along }));
                if let Occluder::Triangle { a, ab, ac, flat } = *occluder {
                    let size = ab.length().max(ac.length());
                    let near = if flat {
                        bias[0].min(1e-4 * size)
                    } else {
                        bias[is_own as usize].max(facet_room(size, is_own))
                    };
                    let t = meet_triangle(from, dir, a, ab, ac).map(|(t, _)| t).filter(|t| *t > near);
                    push(t, None, dir.dot(ab.cross(ac)));
                    continue;
                }
                let first = self.distance(is_own, occluder, from, dir, 0.0, bias);
                let other = first.and_then(|t| self.distance(is_own, occluder, from, dir, t * (1.0 + 1e-6), bias));
                // Of two crossings of a sphere the first enters; a lone one leaves it.
                push(first, Some(other.is_some()), 0.0);
                push(other, Some(false), 0.0);
            }
            Some(length)
        });
    }

    /// Whether anything that lets no light through stands between two points. How near the start a triangle does not count is `bias[0]`, and `bias[1]`
    /// for the triangles of `own` itself, whose spheres and flat patches never count.
    pub fn blocked(&self, own: Item, from: Vec3, to: Vec3, bias: [f32; 2]) -> bool {
        if self.nodes.is_empty() {
            return false;
        }
        let way = to - from;
        let length = way.length();
        if !(length > 0.0) || !from.is_finite() {
            return false;
        }
        let dir = way / length;
        let mut blocked = false;
        self.leaves(from, dir, length, |leaf, length| {
            blocked = leaf.iter().any(|(item, o)| {
                !self.translucent[item.source as usize]
                    && self.stops(*item == own, o, from, dir, length, bias[(*item == own) as usize])
            });
            (!blocked).then_some(length)
        });
        blocked
    }

    /// The nearest thing along a direction of unit length from `least` on, for a ray from a surface of `own`: how far, and what.
    pub fn nearest(&self, own: Item, from: Vec3, dir: Vec3, least: f32, bias: [f32; 2]) -> Option<(f32, Item)> {
        if self.nodes.is_empty() || !from.is_finite() || !dir.is_finite() {
            return None;
        }
        let mut best: Option<(f32, Item)> = None;
        self.leaves(from, dir, f32::INFINITY, |leaf, mut length| {
            for (item, occluder) in leaf {
                if let Some(t) = self.distance(*item == own, occluder, from, dir, least, bias).filter(|t| *t < length) {
                    length = t;
                    best = Some((t, *item));
                }
            }
            Some(length)
        });
        best
    }

    /// Visit the leaves that a ray meets within a length; the visitor answers how much of the length still counts, or ends it.
    #[inline(always)]
    fn leaves(
        &self,
        from: Vec3,
        dir: Vec3,
        mut length: f32,
        mut visit: impl FnMut(&[(Item, Occluder)], f32) -> Option<f32>,
    ) {
        let (origin, inv) = (Vec3A::from(from), Vec3A::from(dir).recip());
        let mut stack = [0u32; 64];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let at = stack[top];
            let node = &self.nodes[at as usize];
            let (min, max) = node.bounds();
            let (t0, t1) = ((min - origin) * inv, (max - origin) * inv);
            let enter = t0.min(t1).max_element().max(0.0);
            let leave = t0.max(t1).min_element().min(length);
            // A ray in the plane of a side gives a NaN there, which must not hide the node.
            if enter > leave {
                continue;
            }
            if node.count() == 0 {
                stack[top] = node.at();
                stack[top + 1] = at + 1;
                top += 2;
                continue;
            }
            match visit(&self.occluders[node.at() as usize..(node.at() + node.count()) as usize], length) {
                Some(rest) => length = rest,
                None => return,
            }
        }
    }

    /// How far along a ray an occluder is met, from `least` on, and beyond what it cannot mean: the surface that the ray starts
    /// from, where it stands off what was shaded. `bias` as for [`Bvh::blocked`].
    fn distance(
        &self,
        own: bool,
        occluder: &Occluder,
        from: Vec3,
        dir: Vec3,
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
            Occluder::Triangle { flat: true, .. } if own => None,
            Occluder::Triangle { a, ab, ac, flat } => {
                let size = ab.length().max(ac.length());
                let near = if flat { 1e-5 * size } else { bias[own as usize].max(facet_room(size, own)) };
                meet_triangle(from, dir, a, ab, ac).map(|(t, _)| t).filter(|t| *t > near.max(least))
            }
        }
    }

    #[inline]
    fn stops(&self, own: bool, occluder: &Occluder, from: Vec3, dir: Vec3, length: f32, bias: f32) -> bool {
        match *occluder {
            Occluder::Sphere { center, radius } => {
                !own && {
                    let to = center - from;
                    let along = to.dot(dir);
                    let off2 = (to - dir * along).length_squared();
                    let r2 = radius * radius;
                    off2 < r2 && {
                        let half = (r2 - off2).sqrt();
                        along + half > 0.0 && along - half < length
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
                        root - b > 0.0 && (-b - root) < length * a
                    }
                }
            }
            Occluder::Triangle { a, ab, ac, flat } => {
                !(own && flat)
                    && meet_triangle(from, dir, a, ab, ac).is_some_and(|(t, _)| {
                        let facet = if flat { 0.0 } else { facet_room(ab.length().max(ac.length()), own) };
                        t > bias.max(facet) && t < length
                    })
            }
        }
    }
}

/// How near its start a ray passes a facet of a curved surface, which stands off the surface: its own neighbourhood is not in its
/// shadow.
fn facet_room(size: f32, own: bool) -> f32 {
    size * if own { 2.0 } else { 0.5 }
}

/// The box of an occluder, whose number stands, by its bits, behind the first corner.
#[derive(Clone, Copy)]
struct Boxed {
    min: Vec4,
    max: Vec4,
}

impl Boxed {
    fn bounds(&self) -> (Vec3A, Vec3A) {
        (Vec3A::from_vec4(self.min), Vec3A::from_vec4(self.max))
    }

    fn center(&self) -> Vec3A {
        Vec3A::from_vec4(0.5 * (self.min + self.max))
    }
}

/// The box around nothing.
const NOTHING: (Vec3A, Vec3A) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);

fn join(a: (Vec3A, Vec3A), b: (Vec3A, Vec3A)) -> (Vec3A, Vec3A) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Occluders from which on the two sides of a split are split at the same time.
const PARALLEL: usize = 8192;

/// Split a run of boxes at the best of 16 planes along each axis by the surface area heuristic: the nodes, depth first. The boxes
/// are put in the leaves' order; `first` is the place of the first.
fn split(boxes: &mut [Boxed], first: u32) -> Vec<Node> {
    let mut nodes = vec![];
    if boxes.len() < PARALLEL {
        split_into(boxes, first, &mut nodes);
        return nodes;
    }
    let (node, middle) = divide(boxes, first);
    let (left, right) = boxes.split_at_mut(middle);
    let (left, right) = rayon::join(|| split(left, first), || split(right, first + middle as u32));
    nodes.reserve(1 + left.len() + right.len());
    nodes.push(Node::new(node.bounds(), 1 + left.len() as u32, 0));
    for side in [left, right] {
        let before = nodes.len() as u32;
        let moved = |n: Node| if n.count() == 0 { Node::new(n.bounds(), n.at() + before, 0) } else { n };
        nodes.extend(side.into_iter().map(moved));
    }
    nodes
}

fn split_into(boxes: &mut [Boxed], first: u32, nodes: &mut Vec<Node>) {
    let (node, middle) = divide(boxes, first);
    let here = nodes.len();
    nodes.push(node);
    if boxes.len() <= LEAF {
        return;
    }
    let (left, right) = boxes.split_at_mut(middle);
    split_into(left, first, nodes);
    nodes[here] = Node::new(node.bounds(), nodes.len() as u32, 0);
    split_into(right, first + middle as u32, nodes);
}

/// The node of a run as a leaf, and how many of the run go to its first side; the run is put in order for that.
fn divide(boxes: &mut [Boxed], first: u32) -> (Node, usize) {
    let hull = |(a, b), x: &Boxed| (join(a, x.bounds()), join(b, (x.center(), x.center())));
    let (bounds, (lo, hi)) = boxes.iter().fold((NOTHING, NOTHING), hull);
    let node = Node::new(bounds, first, boxes.len() as u32);
    if boxes.len() <= LEAF {
        return (node, 0);
    }
    let mut middle =
        best_plane(boxes, lo, hi).map_or(0, |(axis, plane)| partition(boxes, |x| x.center()[axis] < plane));
    if middle == 0 || middle == boxes.len() {
        // All centres in one place: halves of the run will do.
        middle = boxes.len() / 2;
    }
    (node, middle)
}

fn best_plane(boxes: &[Boxed], lo: Vec3A, hi: Vec3A) -> Option<(usize, f32)> {
    const BINS: usize = 16;
    let area = |(lo, hi): (Vec3A, Vec3A)| {
        let d = (hi - lo).max(Vec3A::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    };
    let width = hi - lo;
    let scale = (BINS as f32 / width).to_array();
    let mut bins = [[(0u32, NOTHING); BINS]; 3];
    for x in boxes {
        let at = (x.center() - lo).to_array();
        for (axis, bins) in bins.iter_mut().enumerate() {
            // Along an axis that has no width this is not a number, and makes bin 0.
            let bin = &mut bins[((at[axis] * scale[axis]) as usize).min(BINS - 1)];
            *bin = (bin.0 + 1, join(bin.1, x.bounds()));
        }
    }
    let mut best: Option<(f32, usize, f32)> = None;
    for (axis, bins) in bins.iter().enumerate().filter(|(axis, _)| width[*axis] > 0.0) {
        let mut after = [(0u32, NOTHING); BINS];
        let mut sum = (0, NOTHING);
        for k in (1..BINS).rev() {
            sum = (sum.0 + bins[k].0, join(sum.1, bins[k].1));
            after[k] = sum;
        }
        let mut before = (0u32, NOTHING);
        for k in 1..BINS {
            before = (before.0 + bins[k - 1].0, join(before.1, bins[k - 1].1));
            if before.0 > 0 && after[k].0 > 0 {
                let cost = before.0 as f32 * area(before.1) + after[k].0 as f32 * area(after[k].1);
                if best.is_none_or(|(c, ..)| cost < c) {
                    best = Some((cost, axis, lo[axis] + width[axis] * k as f32 / BINS as f32));
                }
            }
        }
    }
    best.map(|(_, axis, plane)| (axis, plane))
}

/// Move what satisfies `first` to the front, keeping the order on both sides; how many do.
fn partition(boxes: &mut [Boxed], first: impl Fn(&Boxed) -> bool) -> usize {
    let mut back = vec![];
    let mut front = 0;
    for k in 0..boxes.len() {
        let x = boxes[k];
        if first(&x) {
            boxes[front] = x;
            front += 1;
        } else {
            back.push(x);
        }
    }
    boxes[front..].copy_from_slice(&back);
    front
}
