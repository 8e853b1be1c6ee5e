//! Blobbies whose numbers change: points of the surface go along with the leaves that make it, and stay on it.

use crate::gprim::blobby::{Field, LEVEL, Node};
use glam::Vec3;

/// The parts of a way by which points are carried.
const STEPS: usize = 8;

/// How far a point's field may be from the surface's.
const NEAR: f32 = 1e-4;

/// The most steps of a point to the surface.
const MOST: usize = 16;

impl Node {
    /// Where a point of this leaf is when the leaf has become another.
    fn carry(&self, to: &Node, p: Vec3) -> Vec3 {
        match (self, to) {
            (Node::Ellipsoid(own), Node::Ellipsoid(other)) => other.inverse().transform_point3(own.transform_point3(p)),
            (
                Node::Segment { a, b, radius, into },
                Node::Segment { a: to_a, b: to_b, radius: to_radius, into: other },
            ) => {
                let q = into.transform_point3(p);
                let way = *b - *a;
                let part = ((q - *a).dot(way) / way.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
                let off = q - (*a + way * part);
                other.inverse().transform_point3(to_a.lerp(*to_b, part) + off * (to_radius / radius))
            }
            _ => p,
        }
    }
}

impl Field {
    /// The points of this surface as the field becomes others like it, one after the other, the last of which they end on; `size` is
    /// that of the net's cells.
    pub fn carried(&self, points: &[Vec3], size: f32, along: &[Field]) -> Vec<Vec3> {
        let mut scratch = vec![];
        let mut carry = |mut p: Vec3| {
            let mut from = self;
            for to in along {
                let moved = from.carried_by_leaves(p, to);
                let moved = to.settled(moved, size, &mut scratch);
                if moved.is_finite() {
                    p = moved;
                }
                from = to;
            }
            p
        };
        points.iter().map(|p| carry(*p)).collect()
    }

    /// A point moved as the leaves are that make the surface there.
    fn carried_by_leaves(&self, p: Vec3, to: &Field) -> Vec3 {
        let (mut sum, mut whole) = (Vec3::ZERO, 0.0);
        for leaf in &self.leaves {
            let (own, other) = (&self.nodes[*leaf], &to.nodes[*leaf]);
            let weight = if matches!(own, Node::Constant(_)) { 0.0 } else { self.leaf(own, p).max(0.0) };
            if weight > 0.0 {
                sum += weight * own.carry(other, p);
                whole += weight;
            }
        }
        if whole > 0.0 { sum / whole } else { p }
    }

    /// A point brought to the surface.
    fn settled(&self, mut p: Vec3, size: f32, scratch: &mut Vec<f32>) -> Vec3 {
        for _ in 0..MOST {
            if (self.at(p, scratch) - LEVEL).abs() < NEAR {
                break;
            }
            p = self.drawn_to_surface(p, size, 1, scratch).0;
        }
        p
    }
}

/// The numbers between those of two times, part by part of the way; the last are those of the second.
pub fn between<'n>(from: &'n [f32], to: &'n [f32]) -> impl Iterator<Item = Vec<f32>> + 'n {
    (1..=STEPS).map(move |k| blend(from, to, k as f32 / STEPS as f32))
}

/// Numbers at a part of the way from some to others.
pub fn blend(from: &[f32], to: &[f32], part: f32) -> Vec<f32> {
    from.iter().zip(to).map(|(a, b)| a + (b - a) * part).collect()
}
