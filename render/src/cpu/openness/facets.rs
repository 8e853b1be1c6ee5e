//! Facets of patches as they close cones: those near a point by themselves, those farther away together.

use crate::cpu::openness::cones::{Axes, CONES, Cap, Packed, SIN, SOLID, Tint, axes, phase, smooth};
use crate::scene::facets::{Cut, quads_of};
use crate::scene::shape::Shape;
use crate::scene::source::Item;
use crate::scene::world::Scene;
use glam::Vec3;
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

/// A facet of four corners; of a triangle two are the same.
#[derive(Clone, Copy)]
pub struct Facet {
    pub corners: [Vec3; 4],
    /// Its normal by its area; of a closed surface it points outwards.
    pub area: Vec3,
    pub closed: bool,
    pub color: Packed,
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
                let (first, color) = (facets.len(), Packed::new(scene.view(*item).color));
                let quads = patches.iter().flat_map(|p| quads_of(p, Cut::even(p), to_world));
                facets.extend(quads.filter_map(|corners| facet_of(corners, color)));
                orient(&mut facets[first..]);
            }
        }
        let mut nodes = vec![];
        if !facets.is_empty() {
            build(&mut facets, 0, &mut nodes);
        }
        Facets { facets, nodes }
    }

    /// Close the cones of a point.
    pub fn close(&self, at: Vec3, normal: Vec3, shut: &mut Shut) {
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
                self.facets[node.next as usize].close(at, normal, cones, shut);
            } else {
                stack[top] = node.next;
                stack[top + 1] = k + 1;
                top += 2;
            }
        }
    }
}

/// A facet of some corners, if it has an area.
fn facet_of(corners: [Vec3; 4], color: Packed) -> Option<Facet> {
    let [a, b, c, d] = corners;
    let area = 0.5 * (c - a).cross(d - b);
    (area.length() > 0.0 && area.is_finite()).then_some(Facet { corners, area, closed: false, color })
}

/// Where the facets of an item enclose it, mark them and turn their normals outwards.
fn orient(facets: &mut [Facet]) {
    let (mut sum, mut all, mut volume) = (Vec3::ZERO, 0.0, 0.0);
    let Some(origin) = facets.first().map(|f| f.corners[0]) else { return };
    for facet in &*facets {
        (sum, all) = (sum + facet.area, all + facet.area.length());
        volume += (facet.middle() - origin).dot(facet.area);
    }
    if sum.length() < 0.02 * all && facets.len() > 3 {
        let side = if volume < 0.0 { -1.0 } else { 1.0 };
        facets.iter_mut().for_each(|facet| (facet.area, facet.closed) = (side * facet.area, true));
    }
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

    /// What it closes near by: where a cone lies within the planes through the point and its edges.
    fn close(&self, at: Vec3, normal: Vec3, cones: &Axes, shut: &mut Shut) {
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
        let edges = [0, 1, 2, 3].map(|k| (side * q[k].cross(q[(k + 1) % 4])).normalize_or_zero());
        // A cone that is wider than the facet is not covered by it whole.
        let solid = solid_angle([q[0], q[1], q[2]]) + solid_angle([q[0], q[2], q[3]]);
        let most = (1.5 * solid / SOLID).min(1.0);
        // Light comes along the way to its plane, or to its middle, whichever is more before the surface.
        let (plane, middle) = (side * self.area.dot(normal) / (size * size), (self.middle() - at).normalize_or_zero());
        shut.tint.add(self.color, solid / PI * plane.max(middle.dot(normal)).max(0.1));
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
