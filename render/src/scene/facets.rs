//! Patches as triangles: for rays, and for the surfaces of area lights.

use crate::scene::interpolation::lerp4;
use crate::scene::patch::Patch;
use glam::{Mat4, Vec3};

/// The most segments along a curved patch's edge.
const FACETS: f32 = 12.0;

/// The bend, as [`bend`] measures it, from which on a patch has the most segments: that of a quarter of a circle.
const MOST_BENT: f32 = 0.28;

/// Widths of a facet beyond which it is cut along its length, as far as there are segments.
const SLIM: f32 = 16.0;

/// How far control points lie out of the plane of what is nearly flat, in parts of its size.
const NEARLY_FLAT: f32 = 0.02;

/// How a patch is cut to facets.
#[derive(Clone, Copy)]
pub(crate) struct Cut {
    /// Segments along u and v.
    pub n: [usize; 2],
    /// How near the start of a ray a facet may be in its own way along u and v, in parts of its width: as far as it stands off the
    /// surface, and nothing along what is straight.
    pub room: [f32; 2],
}

impl Cut {
    /// Facets along u and v as the patch bends along each, or is twisted.
    pub(crate) fn of(patch: &Patch) -> Cut {
        if patch.flat {
            return Cut { n: [1, 1], room: [0.0, 0.0] };
        }
        let p = &patch.p;
        let [a, b, c, d] = [p[0], p[3], p[12], p[15]];
        let across = (d - a).cross(c - b).normalize_or_zero();
        let twist = (a - b - c + d).dot(across).abs() / 3.0 / (d - a).length().max((c - b).length());
        let [u, v] = [(1, 4), (4, 1)].map(|(step, row)| bend(p, step, row));
        let bends = [u, v].map(|(bend, _)| bend.max(if twist > 0.0 { twist } else { 0.0 }));
        let n = bends.map(|bend| (1.0 + (FACETS - 1.0) * (bend / MOST_BENT).sqrt()).min(FACETS));
        // The boxes around what is much longer than wide hold little of it.
        let width = (u.1 / n[0]).min(v.1 / n[1]);
        let n = [(n[0], u.1), (n[1], v.1)].map(|(n, long)| n.max((long / (SLIM * width)).min(FACETS)) as usize);
        // A cubic leaves its chord by three quarters of what its control points do; a sixty-fourth of the way counts for nothing.
        // Nor does what is nearly flat stand off farther than its control points lie out of its plane, however its edges bend.
        let off = p.iter().map(|q| (*q - a).dot(across).abs()).fold(0.0, f32::max) / u.1.max(v.1);
        let off = if off > 1e-6 || across == Vec3::ZERO { off } else { 0.0 };
        let most = |bend: f32| if off < NEARLY_FLAT && across != Vec3::ZERO { bend.min(off) } else { bend };
        let room = [0, 1].map(|k| (48.0 * most(bends[k]) / n[k] as f32).min(1.0));
        Cut { n, room }
    }

    /// As many facets along both directions, as the control points leave the bilinear patch of the corners: for sums over the surface.
    pub(crate) fn even(patch: &Patch) -> Cut {
        let corners = [0, 3, 12, 15].map(|k| patch.p[k]);
        let size = (corners[3] - corners[0]).length().max((corners[2] - corners[1]).length());
        let off = (0..16).map(|k| (patch.p[k] - lerp4(corners, (k % 4) as f32 / 3.0, (k / 4) as f32 / 3.0)).length());
        let bend = off.fold(0.0, f32::max) / size.max(f32::MIN_POSITIVE);
        let n = if patch.flat { 1 } else { (1.0 + (FACETS - 1.0) * (bend / 0.07).sqrt()).min(FACETS) as usize };
        Cut { n: [n, n], room: [1.0, 1.0] }
    }

    /// Corners of the facets: u and v of the lower corner.
    fn corners(self) -> impl Iterator<Item = [f32; 2]> {
        let [nu, nv] = self.n;
        let [wu, wv] = self.widths();
        (0..nu * nv).map(move |k| [(k % nu) as f32 * wu, (k / nu) as f32 * wv])
    }

    /// A facet's width in u and v.
    fn widths(self) -> [f32; 2] {
        self.n.map(|n| 1.0 / n as f32)
    }
}

/// How far control points leave the straight lines between the ends of their rows, in parts of the longest of these, and its length.
fn bend(p: &[Vec3; 16], step: usize, row: usize) -> (f32, f32) {
    let (mut off, mut longest) = (0.0f32, 0.0f32);
    for r in 0..4 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| p[r * row + k * step]);
        off = off.max((b - a.lerp(d, 1.0 / 3.0)).length()).max((c - a.lerp(d, 2.0 / 3.0)).length());
        longest = longest.max((d - a).length());
    }
    // What rounding makes of a straight row is no bend.
    (if off > 1e-6 * longest { off / longest.max(f32::MIN_POSITIVE) } else { 0.0 }, longest)
}

/// The four corners of each of a patch's facets, around it, in world space.
pub(crate) fn quads_of(patch: &Patch, cut: Cut, to_world: Mat4) -> impl Iterator<Item = [Vec3; 4]> + '_ {
    let at = move |u: f32, v: f32| to_world.transform_point3(patch.at(u, v));
    let [wu, wv] = cut.widths();
    cut.corners().map(move |[u, v]| [at(u, v), at(u + wu, v), at(u + wu, v + wv), at(u, v + wv)])
}

/// The triangles of a patch's facets, corners in world space.
pub(crate) fn facets_of(patch: &Patch, cut: Cut, to_world: Mat4) -> impl Iterator<Item = [Vec3; 3]> + '_ {
    quads_of(patch, cut, to_world).flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
}

/// Where a ray, in the space of a patch, meets its facets nearest to a place: the distance from the place squared, and u, v.
pub(crate) fn place_on(patch: &Patch, from: Vec3, dir: Vec3, at: Vec3) -> Option<(f32, [f32; 2])> {
    let mut best: Option<(f32, [f32; 2])> = None;
    let cut = Cut::of(patch);
    let [wu, wv] = cut.widths();
    for [u, v] in cut.corners() {
        let corners = [(u, v), (u + wu, v), (u + wu, v + wv), (u, v + wv)];
        let [a, b, c, d] = corners.map(|(u, v)| patch.at(u, v));
        for (p, q, first) in [(b, c, true), (c, d, false)] {
            let Some((t, [x, y])) = meet_triangle(from, dir, a, [p - a, q - a], 0.0) else { continue };
            let off = (from + dir * t - at).length_squared();
            if best.is_none_or(|(least, _)| off < least) {
                let uv = if first { [u + wu * (x + y), v + wv * y] } else { [u + wu * x, v + wv * (x + y)] };
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
