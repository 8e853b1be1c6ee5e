//! Patches as triangles: for rays, and for the surfaces of area lights.

use crate::scene::interpolation::lerp4;
use crate::scene::patch::Patch;
use glam::{Mat4, Vec3};

/// The most segments along a curved patch's edge.
const FACETS: f32 = 12.0;

/// Segments along a patch's edge: as its control points leave the bilinear patch of its corners.
fn facets(patch: &Patch) -> usize {
    let corners = [0, 3, 12, 15].map(|k| patch.p[k]);
    let size = (corners[3] - corners[0]).length().max((corners[2] - corners[1]).length());
    let off = (0..16).map(|k| (patch.p[k] - lerp4(corners, (k % 4) as f32 / 3.0, (k / 4) as f32 / 3.0)).length());
    let bend = off.fold(0.0, f32::max) / size.max(f32::MIN_POSITIVE);
    if patch.flat { 1 } else { (1.0 + (FACETS - 1.0) * (bend / 0.07).sqrt()).min(FACETS) as usize }
}

/// Corners of a patch's facets: u and v of the lower corner, and a facet's width in them.
fn facet_corners(patch: &Patch) -> impl Iterator<Item = ([f32; 2], f32)> + use<> {
    let n = facets(patch);
    let step = 1.0 / n as f32;
    (0..n * n).map(move |k| ([(k % n) as f32 * step, (k / n) as f32 * step], step))
}

/// The four corners of each of a patch's facets, around it, in world space.
pub(crate) fn quads_of(patch: &Patch, to_world: Mat4) -> impl Iterator<Item = [Vec3; 4]> + '_ {
    let at = move |u: f32, v: f32| to_world.transform_point3(patch.at(u, v));
    facet_corners(patch).map(move |([u, v], w)| [at(u, v), at(u + w, v), at(u + w, v + w), at(u, v + w)])
}

/// The triangles of a patch's facets, corners in world space.
pub(crate) fn facets_of(patch: &Patch, to_world: Mat4) -> impl Iterator<Item = [Vec3; 3]> + '_ {
    quads_of(patch, to_world).flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
}

/// Where a ray, in the space of a patch, meets its facets nearest to a place: the distance from the place squared, and u, v.
pub(crate) fn place_on(patch: &Patch, from: Vec3, dir: Vec3, at: Vec3) -> Option<(f32, [f32; 2])> {
    let mut best: Option<(f32, [f32; 2])> = None;
    for ([u, v], w) in facet_corners(patch) {
        let corners = [(u, v), (u + w, v), (u + w, v + w), (u, v + w)];
        let [a, b, c, d] = corners.map(|(u, v)| patch.at(u, v));
        for (p, q, first) in [(b, c, true), (c, d, false)] {
            let Some((t, [x, y])) = meet_triangle(from, dir, a, [p - a, q - a], 0.0) else { continue };
            let off = (from + dir * t - at).length_squared();
            if best.is_none_or(|(least, _)| off < least) {
                let uv = if first { [u + w * (x + y), v + w * y] } else { [u + w * x, v + w * (x + y)] };
                best = Some((off, uv));
            }
        }
    }
    best
}

/// How far along a ray it meets a triangle, given by a corner and the edges from it, and where: parts of the edges (Möller and
/// Trumbore 1997). A ray that passes it by at most `beside`, in parts of the triangle, meets it.
#[inline(always)]
pub(crate) fn meet_triangle(
    from: Vec3,
    dir: Vec3,
    a: Vec3,
    [ab, ac]: [Vec3; 2],
    beside: f32,
) -> Option<(f32, [f32; 2])> {
    let p = dir.cross(ac);
    let det = ab.dot(p);
    if det == 0.0 {
        return None;
    }
    let inv = 1.0 / det;
    let s = from - a;
    let u = s.dot(p) * inv;
    let q = s.cross(ab);
    let v = dir.dot(q) * inv;
    (u >= -beside && v >= -beside && u + v <= 1.0 + beside).then(|| (ac.dot(q) * inv, [u, v]))
}
