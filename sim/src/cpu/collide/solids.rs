//! Two convex solids of any kinds: their nearest points, and the manifold about these.

use super::convex::{self, Axis};
use super::manifold::{feature, points, with_nearest};
use super::point::{Placed, Points};
use super::sides::{side_by_side, side_points};

/// The contact points of two convex shapes, neither a plane nor a mesh, with the axis as [`convex::nearest`] has it. Returns their count.
pub fn convex_convex(a: &Placed, b: &Placed, reach: f64, axis: &mut Axis, out: &mut Points) -> usize {
    let nearest = side_by_side(a, b, reach, axis).unwrap_or_else(|| convex::nearest(a, b, reach, axis));
    match nearest {
        Some(nearest) => {
            let size = a.size.min_element().min(b.size.min_element());
            let (fa, fb) = (feature(a, nearest.normal), feature(b, -nearest.normal));
            match side_points([a, b], [&fa, &fb], &nearest, reach, out) {
                Some(kept) => with_nearest(&nearest, size, kept, out),
                None => points(&fa, &fb, &nearest, reach, size, out),
            }
        }
        None => 0,
    }
}
