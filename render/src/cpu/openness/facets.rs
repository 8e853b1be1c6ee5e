//! Facets of patches as they close cones: those near a point by themselves, those farther away together.

use crate::cpu::openness::cones::{Axes, CONES, Cap, Packed, SIN, SOLID, Tint, axes, phase, smooth};
use crate::scene::facets::{Cut, quads_of};
use crate::scene::patch::Patch;
use crate::scene::shape::Shape;
use crate::scene::source::Item;
use crate::scene::world::Scene;
use glam::{Mat4, Vec3};
use std::f32::consts::PI;

/// Radii of a node's sphere from its middle, from which on it stands for its facets.
const FAR: f32 = 2.5;

/// Solid angles from which on a node counts, and counts in full.
const LEAST: [f32; 2] = [0.002, 0.006];

/// The height of a point over a facet's plane, in parts of how far the facet reaches from it, below which it lies in the plane: what
/// numbers of single precision leave of it.
const IN_PLANE: f32 = 2e-6;

/// Heights of a point over a facet, from how many on the facet is wide: what is seen of it at a slant, up to this sine, is far away.
const WIDE: f32 = 20.0;
const SLANT: f32 = 0.6;

/// The height of a point over a facet of its own curved surface, in parts of how far that leaves the facet, from which on the facet counts in
/// full: what lies beside the point is a part of the surface, which bends there and not at the facet's edge.
const HOLLOW_BESIDE: f32 = 8.0;

/// The depths of a point under such a facet, in the same parts, up to which it does not count at all, and from which on it does in full: under
/// the chord of a hollow the surface itself lies at the first.
const HOLLOW_UNDER: [f32; 2] = [1.5, 3.0];

/// The cosine between the normals of a facet and of a point of another surface under it, from which on the two surfaces are taken to touch there
/// from within, as the round end of a tube does.
const TOUCHES: f32 = 0.8;

/// A facet of four corners; of a triangle two are the same.
#[derive(Clone, Copy)]
pub struct Facet {
    pub corners: [Vec3; 4],
    /// Its normal by its area; of a closed surface it points outwards.
    pub area: Vec3,
    pub closed: bool,
    pub color: Packed,
    /// The whole that it is of, and how far that surface leaves it, m; 0 of what is flat or closed.
    pub whole: u32,
    pub off: f32,
}

/// Facets, seen from afar.
#[derive(Clone, Copy)]
pub struct Node {
    pub center: Vec3,
    pub radius: f32,
    /// The sum of the normals by area, and that of the areas.
    pub normal: Vec3,
    pub area: f32,
    /// Of an inner node, its second child, whose first is the next; of a leaf its facet.
    pub next: u32,
    pub leaf: bool,
    /// The mean colour by area.
    pub color: Packed,
}

/// What facets do to the cones of a point.
pub struct Shut {
    /// The way to the sun, 0 for none.
    pub sun: Vec3,
    /// How much of each cone they close; that by how squarely they face the sun; and of this what is far away.
    pub closed: [f32; CONES],
    pub bright: [f32; CONES],
    pub far: [f32; CONES],
    pub tint: Tint,
}

/// All of a scene.
pub struct Facets {
    pub facets: Vec<Facet>,
    pub nodes: Vec<Node>,
}

impl Facets {
    /// Of some items of a scene.
    pub fn new(scene: &Scene, items: &[Item]) -> Facets {
        let mut facets = vec![];
        for item in items {
            if let (Shape::Patches(patches, _), to_world) = scene.place(*item) {
                let color = Packed::new(scene.view(*item).color);
                add_facets(&mut facets, patches, to_world, scene.whole_of(*item), color);
            }
        }
        let mut nodes = vec![];
        if !facets.is_empty() {
            build(&mut facets, 0, &mut nodes);
        }
        Facets { facets, nodes }
    }

    /// Close the cones of a point on a whole.
    pub fn close(&self, own: u32, at: Vec3, normal: Vec3, shut: &mut Shut) {
        if self.nodes.is_empty() {
            return;
        }
        let cones = axes();
        let mut stack = [0u32; 64];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let k = stack[top];
            let node = &self.nodes[k as usize];
            let to = node.center - at;
            if to.dot(normal) <= -node.radius {
                continue;
            }
            let d2 = to.length_squared();
            if d2 > FAR * FAR * node.radius * node.radius {
                node.close(to, d2, normal, cones, shut);
            } else if node.leaf {
                self.facets[node.next as usize].close(own, [at, normal], cones, shut);
            } else {
                stack[top] = node.next;
                stack[top + 1] = k + 1;
                top += 2;
            }
        }
    }
}

/// Add the facets of the patches of an item.
fn add_facets(facets: &mut Vec<Facet>, patches: &[Patch], to_world: Mat4, whole: u32, color: Packed) {
    let first = facets.len();
    let mut pieces = vec![];
    for patch in patches {
        let cut = Cut::even(patch);
        for (corners, piece) in quads_of(patch, cut, to_world).zip(cut.pieces()) {
            if let Some(facet) = facet_of(corners, color, whole) {
                facets.push(facet);
                pieces.push((patch, piece));
            }
        }
    }
    // What is closed is seen from outside, where its facets are behind those that bend away from them.
    if !orient(&mut facets[first..]) {
        let all = facets[first..].iter_mut().zip(pieces);
        all.for_each(|(facet, (patch, piece))| facet.off = facet.leaves(patch, piece, to_world));
    }
}

/// A facet of some corners, if it has an area.
fn facet_of(corners: [Vec3; 4], color: Packed, whole: u32) -> Option<Facet> {
    let [a, b, c, d] = corners;
    let area = 0.5 * (c - a).cross(d - b);
    (area.length() > 0.0 && area.is_finite()).then_some(Facet { corners, area, closed: false, color, whole, off: 0.0 })
}

/// Where the facets of an item enclose it, mark them and turn their normals outwards; whether they do.
fn orient(facets: &mut [Facet]) -> bool {
    let (mut sum, mut all, mut volume) = (Vec3::ZERO, 0.0, 0.0);
    let Some(origin) = facets.first().map(|f| f.corners[0]) else { return false };
    for facet in &*facets {
        (sum, all) = (sum + facet.area, all + facet.area.length());
        volume += (facet.middle() - origin).dot(facet.area);
    }
    let encloses = sum.length() < 0.02 * all && facets.len() > 3;
    if encloses {
        let side = if volume < 0.0 { -1.0 } else { 1.0 };
        facets.iter_mut().for_each(|facet| (facet.area, facet.closed) = (side * facet.area, true));
    }
    encloses
}

/// Put facets in the order of a hierarchy's leaves, and add its nodes, depth first.
fn build(facets: &mut [Facet], first: u32, nodes: &mut Vec<Node>) {
    let here = nodes.len();
    nodes.push(Node::new(facets, first));
    if facets.len() == 1 {
        return;
    }
    let hull = |(lo, hi): (Vec3, Vec3), f: &Facet| (lo.min(f.middle()), hi.max(f.middle()));
    let (lo, hi) = facets.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), hull);
    let axis = (hi - lo).max_position();
    facets.sort_by(|a, b| a.middle()[axis].total_cmp(&b.middle()[axis]));
    let half = facets.len() / 2;
    let (left, right) = facets.split_at_mut(half);
    build(left, first, nodes);
    nodes[here].next = nodes.len() as u32;
    build(right, first + half as u32, nodes);
}

impl Node {
    /// Of facets, the first of which has this index.
    fn new(facets: &[Facet], first: u32) -> Node {
        let corners = || facets.iter().flat_map(|f| f.corners);
        let (lo, hi) = corners().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)));
        let center = 0.5 * (lo + hi);
        let radius = corners().map(|p| (p - center).length()).fold(0.0, f32::max);
        let (normal, area): (Vec3, f32) =
            (facets.iter().map(|f| f.area).sum(), facets.iter().map(|f| f.area.length()).sum());
        let color: Vec3 = facets.iter().map(|f| f.color.color() * f.area.length()).sum();
        let color = Packed::new((color / area).to_array());
        Node { center, radius, normal, area, next: first, leaf: facets.len() == 1, color }
    }

    /// What it closes from afar. Of what encloses something, a quarter of its area is seen in the mean (Cauchy).
    fn close(&self, to: Vec3, d2: f32, facing: Vec3, cones: &Axes, shut: &mut Shut) {
        let way = to / d2.sqrt();
        let even = self.normal.length();
        let seen = self.normal.dot(way).abs() + 0.25 * (self.area - even).max(0.0);
        let solid = (seen / d2).min(PI * self.radius * self.radius / d2);
        if solid <= LEAST[0] {
            return;
        }
        let fade = smooth(((solid - LEAST[0]) / (LEAST[1] - LEAST[0])).min(1.0));
        let sin2 = (solid / PI).min(1.0);
        shut.tint.add(self.color, fade * sin2 * way.dot(facing).max(0.0));
        let bright = if shut.sun == Vec3::ZERO { 0.0 } else { phase(way.dot(shut.sun)) };
        let covers = Cap::new(way, sin2, fade).covers(cones);
        for (k, cover) in covers.into_iter().enumerate() {
            shut.closed[k] += cover;
            shut.bright[k] += cover * bright;
        }
    }
}

impl Facet {
    fn middle(&self) -> Vec3 {
        0.25 * self.corners.iter().sum::<Vec3>()
    }

    /// How far the piece of a patch that it stands for leaves its plane, m: `piece` has the middle and the half width of its parameters.
    fn leaves(&self, patch: &Patch, [[u, v], [du, dv]]: [[f32; 2]; 2], to_world: Mat4) -> f32 {
        if patch.flat {
            return 0.0;
        }
        let normal = self.area.normalize_or_zero();
        let height = |p: Vec3| (p - self.corners[0]).dot(normal).abs();
        let ways = [(0.0, 0.0), (du, 0.0), (-du, 0.0), (0.0, dv), (0.0, -dv)];
        let on_patch = ways.map(|(x, y)| height(to_world.transform_point3(patch.at(u + x, v + y))));
        let most = on_patch.into_iter().chain(self.corners.map(height)).fold(0.0, f32::max);
        let rounding = IN_PLANE * (self.area.length().sqrt() + self.corners[0].length());
        if most > rounding && most.is_finite() { most } else { 0.0 }
    }

    /// How much it counts at a point of its own surface that is so high over its plane, on the side that the surface faces there: not where
    /// it stands for the surface about the point, which it would hide the sky from in a hollow.
    fn counts(&self, above: f32) -> f32 {
        let part = if above > 0.0 {
            above / (HOLLOW_BESIDE * self.off)
        } else {
            (-above / self.off - HOLLOW_UNDER[0]) / (HOLLOW_UNDER[1] - HOLLOW_UNDER[0])
        };
        smooth(part.clamp(0.0, 1.0))
    }

    /// What it closes near a point on a whole, with its normal there: where a cone lies within the planes through the point and its edges.
    fn close(&self, own: u32, [at, normal]: [Vec3; 2], cones: &Axes, shut: &mut Shut) {
        let q = self.corners.map(|p| p - at);
        let size = self.area.length().sqrt();
        let in_plane = IN_PLANE * (size + at.length() + q[0].length() + q[2].length());
        if q.iter().all(|q| q.dot(normal) <= in_plane) {
            return;
        }
        let height = q[0].dot(self.area) / (size * size);
        if height.abs() < in_plane || self.closed && height > 0.0 {
            return;
        }
        let side = height.signum();
        let facing = self.area.dot(normal);
        let above = -height * facing.signum();
        let is_touched = above < 0.0 && facing > TOUCHES * size * size;
        let counts = if self.off > 0.0 && (self.whole == own || is_touched) { self.counts(above) } else { 1.0 };
        if counts == 0.0 {
            return;
        }
        let edges = [0, 1, 2, 3].map(|k| (side * q[k].cross(q[(k + 1) % 4])).normalize_or_zero());
        // A cone that is wider than the facet is not covered by it whole.
        let solid = solid_angle([q[0], q[1], q[2]]) + solid_angle([q[0], q[2], q[3]]);
        let most = counts * (1.5 * solid / SOLID).min(1.0);
        // Light comes along the way to its plane, or to its middle, whichever is more before the surface.
        let (plane, middle) = (side * self.area.dot(normal) / (size * size), (self.middle() - at).normalize_or_zero());
        shut.tint.add(self.color, counts * solid / PI * plane.max(middle.dot(normal)).max(0.1));
        let mut cover = [most; CONES];
        for edge in edges.iter().filter(|edge| **edge != Vec3::ZERO) {
            for (k, cover) in cover.iter_mut().enumerate() {
                let sin = edge.x * cones.x[k] + edge.y * cones.y[k] + edge.z * cones.z[k];
                *cover *= smooth((0.5 + sin * (0.5 / SIN)).clamp(0.0, 1.0));
            }
        }
        shut.closed.iter_mut().zip(&cover).for_each(|(closed, cover)| *closed += cover);
        // The side that is seen, if the sun shines on it.
        let across = self.area / -(side * size * size);
        let bright = across.dot(shut.sun);
        if bright > 0.0 {
            let wide = bright * (size / (WIDE * height.abs()) - 1.0).clamp(0.0, 1.0);
            for (k, cover) in cover.into_iter().enumerate() {
                let sine = (across.x * cones.x[k] + across.y * cones.y[k] + across.z * cones.z[k]).abs();
                shut.bright[k] += bright * cover;
                shut.far[k] += wide * cover * (1.0 - sine * (1.0 / SLANT)).max(0.0);
            }
        }
    }
}

/// The solid angle of a triangle as seen from the origin (Van Oosterom and Strackee 1983).
fn solid_angle([a, b, c]: [Vec3; 3]) -> f32 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let volume = a.dot(b.cross(c)).abs();
    2.0 * volume.atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}
