//! Patches as triangles: for rays, and for the surfaces of area lights.

use crate::scene::interpolation::{bernstein, lerp4};
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
    /// Segments of the edges where v is 0 and 1, and where u is 0 and 1, as far as these are bent: an edge alone says how it is cut, so that
    /// patches that share it have the same points on it, and no ray gets through between them.
    edges: [Option<usize>; 4],
    /// How near the start of a ray a facet may be in its own way along u and v, in parts of its width: as far as it stands off the
    /// surface, and nothing along what is straight.
    pub room: [f32; 2],
}

impl Cut {
    /// Facets along u and v as the patch bends along each, or is twisted.
    pub(crate) fn of(patch: &Patch) -> Cut {
        if patch.flat {
            return Cut { n: [1, 1], edges: [None; 4], room: [0.0, 0.0] };
        }
        let p = &patch.p;
        let [a, b, c, d] = [p[0], p[3], p[12], p[15]];
        let across = (d - a).cross(c - b).normalize_or_zero();
        let twist = (a - b - c + d).dot(across).abs() / 3.0 / (d - a).length().max((c - b).length());
        let [u, v] = [(1, 4), (4, 1)].map(|(step, row)| bend(p, step, row));
        let bends = [u, v].map(|(bend, _)| bend.max(if twist > 0.0 { twist } else { 0.0 }));
        let n = bends.map(segments);
        // The boxes around what is much longer than wide hold little of it.
        let width = (u.1 / n[0]).min(v.1 / n[1]);
        let n = [(n[0], u.1), (n[1], v.1)].map(|(n, long)| n.max((long / (SLIM * width)).min(FACETS)) as usize);
        let edges = EDGES.map(|edge| {
            let bend = bend_of(edge.map(|k| p[k]));
            (bend > 0.0).then(|| segments(bend) as usize)
        });
        let most = |a: Option<usize>, b: Option<usize>, n: usize| n.max(a.unwrap_or(1)).max(b.unwrap_or(1));
        let n = [most(edges[0], edges[1], n[0]), most(edges[2], edges[3], n[1])];
        // A cubic leaves its chord by three quarters of what its control points do; a sixty-fourth of the way counts for nothing.
        // Nor does what is nearly flat stand off farther than its control points lie out of its plane, however its edges bend.
        let off = p.iter().map(|q| (*q - a).dot(across).abs()).fold(0.0, f32::max) / u.1.max(v.1);
        let off = if off > 1e-6 || across == Vec3::ZERO { off } else { 0.0 };
        let most = |bend: f32| if off < NEARLY_FLAT && across != Vec3::ZERO { bend.min(off) } else { bend };
        let room = [0, 1].map(|k| (48.0 * most(bends[k]) / n[k] as f32).min(1.0));
        Cut { n, edges, room }
    }

    /// As many facets along both directions, as the control points leave the bilinear patch of the corners: for sums over the surface.
    pub(crate) fn even(patch: &Patch) -> Cut {
        let corners = [0, 3, 12, 15].map(|k| patch.p[k]);
        let size = (corners[3] - corners[0]).length().max((corners[2] - corners[1]).length());
        let off = (0..16).map(|k| (patch.p[k] - lerp4(corners, (k % 4) as f32 / 3.0, (k / 4) as f32 / 3.0)).length());
        let bend = off.fold(0.0, f32::max) / size.max(f32::MIN_POSITIVE);
        let n = if patch.flat { 1 } else { (1.0 + (FACETS - 1.0) * (bend / 0.07).sqrt()).min(FACETS) as usize };
        Cut { n: [n, n], edges: [None; 4], room: [1.0, 1.0] }
    }

    /// Corners of the facets: u and v of the lower corner.
    fn corners(self) -> impl Iterator<Item = [f32; 2]> {
        let [nu, nv] = self.n;
        let [wu, wv] = self.widths();
        (0..nu * nv).map(move |k| [(k % nu) as f32 * wu, (k / nu) as f32 * wv])
    }

    /// The parameters of the facets, in the order of [`quads_of`]: u and v in the middle, and half the widths.
    pub(crate) fn pieces(self) -> impl Iterator<Item = [[f32; 2]; 2]> {
        let half = self.widths().map(|w| 0.5 * w);
        self.corners().map(move |[u, v]| [[u + half[0], v + half[1]], half])
    }

    /// A facet's width in u and v.
    fn widths(self) -> [f32; 2] {
        self.n.map(|n| 1.0 / n as f32)
    }
}

/// The control points of the edges of a patch where v is 0 and 1, and where u is 0 and 1.
const EDGES: [[usize; 4]; 4] = [[0, 1, 2, 3], [12, 13, 14, 15], [0, 4, 8, 12], [3, 7, 11, 15]];

/// Segments of what bends so far.
fn segments(bend: f32) -> f32 {
    (1.0 + (FACETS - 1.0) * (bend / MOST_BENT).sqrt()).min(FACETS)
}

/// How far an edge leaves the straight line between its ends, in parts of its length; the same whichever end is first.
fn bend_of(q: [Vec3; 4]) -> f32 {
    let [a, b, c, d] = in_order(q).0;
    let (off, long) = ((b - a.lerp(d, 1.0 / 3.0)).length().max((c - a.lerp(d, 2.0 / 3.0)).length()), (d - a).length());
    if off > 1e-6 * long { off / long.max(f32::MIN_POSITIVE) } else { 0.0 }
}

/// The control points of an edge in an order that does not depend on which end is first, and whether they were in the other.
fn in_order(q: [Vec3; 4]) -> ([Vec3; 4], bool) {
    let [a, b, c, d] = q;
    let (key, other) = ([a, b].map(|p| p.to_array()), [d, c].map(|p| p.to_array()));
    if key <= other { (q, false) } else { ([d, c, b, a], true) }
}

/// Point `k` of `n` segments of an edge.
fn on_edge(q: [Vec3; 4], k: usize, n: usize) -> Vec3 {
    let (q, is_turned) = in_order(q);
    let k = if is_turned { n - k } else { k };
    if k == 0 || k == n {
        return q[3 * k / n];
    }
    // A pole is one point, and not several beside it as rounding has them: between these were needles, of any direction.
    if q.iter().all(|p| *p == q[0]) {
        return q[0];
    }
    let b = bernstein(k as f32 / n as f32);
    q[0] * b[0] + q[1] * b[1] + q[2] * b[2] + q[3] * b[3]
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

/// The four corners of each of a patch's facets, around it, in world space. Along an edge with fewer segments than the patch some are the same.
pub(crate) fn quads_of(patch: &Patch, cut: Cut, to_world: Mat4) -> impl Iterator<Item = [Vec3; 4]> + '_ {
    let [nu, nv] = cut.n;
    let [wu, wv] = cut.widths();
    let edges = EDGES.map(|edge| edge.map(|k| to_world.transform_point3(patch.p[k])));
    let at = move |i: usize, j: usize| {
        let edge = match (i, j) {
            (_, 0) => Some((0, i, nu)),
            (_, j) if j == nv => Some((1, i, nu)),
            (0, _) => Some((2, j, nv)),
            (i, _) if i == nu => Some((3, j, nv)),
            _ => None,
        };
        match edge {
            Some((edge, k, n)) => match cut.edges[edge] {
                Some(own) => on_edge(edges[edge], (2 * k * own + n) / (2 * n), own),
                None => on_edge(edges[edge], k, n),
            },
            None => to_world.transform_point3(patch.at(i as f32 * wu, j as f32 * wv)),
        }
    };
    (0..nu * nv).map(move |k| {
        let (i, j) = (k % nu, k / nu);
        [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
    })
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
    let sight = Sight::new(from, dir);
    for [u, v] in cut.corners() {
        let corners = [(u, v), (u + wu, v), (u + wu, v + wv), (u, v + wv)];
        let [a, b, c, d] = corners.map(|(u, v)| patch.at(u, v));
        for (p, q, first) in [(b, c, true), (c, d, false)] {
            let Some((t, [x, y])) = meet_triangle(&sight, [a, p, q], 0.0) else { continue };
            let off = (from + dir * t - at).length_squared();
            if best.is_none_or(|(least, _)| off < least) {
                let uv = if first { [u + wu * (x + y), v + wv * y] } else { [u + wu * x, v + wv * (x + y)] };
                best = Some((off, uv));
            }
        }
    }
    best
}

/// A ray of unit direction, and two directions across it.
#[derive(Clone, Copy)]
pub(crate) struct Sight {
    pub from: Vec3,
    pub dir: Vec3,
    across: [Vec3; 2],
}

impl Sight {
    #[inline(always)]
    pub fn new(from: Vec3, dir: Vec3) -> Sight {
        let (right, up) = dir.any_orthonormal_pair();
        Sight { from, dir, across: [right, up] }
    }

    /// A place as seen along the ray: how far across it, and along it.
    #[inline(always)]
    pub fn seen(&self, p: Vec3) -> [f32; 3] {
        let p = p - self.from;
        [p.dot(self.across[0]), p.dot(self.across[1]), p.dot(self.dir)]
    }
}

/// How far along a ray it meets a triangle, and where: parts of the edges from the first corner. A ray that passes it by at most
/// `beside`, in parts of the triangle, meets it.
#[inline(always)]
pub(crate) fn meet_triangle(sight: &Sight, [a, b, c]: [Vec3; 3], beside: f32) -> Option<(f32, [f32; 2])> {
    meet_seen([a, b, c].map(|p| sight.seen(p)), beside)
}

/// The same of its corners as they are seen along the ray (Woop, Benthin and Wald 2013). On which side of an edge the ray passes is the
/// sign of a number that depends on the ends of the edge alone, with the other sign for the triangle beyond it: a ray meets one of them at least.
#[inline(always)]
pub(crate) fn meet_seen([a, b, c]: [[f32; 3]; 3], beside: f32) -> Option<(f32, [f32; 2])> {
    let part = |p: [f32; 3], q: [f32; 3]| p[0] * q[1] - p[1] * q[0];
    let (w, u, v) = (part(b, c), part(c, a), part(a, b));
    let size = w + u + v;
    let (w, u, v, size) = if size < 0.0 { (-w, -u, -v, -size) } else { (w, u, v, size) };
    let least = -beside * size;
    if !(w >= least && u >= least && v >= least && size > 0.0) {
        return None;
    }
    let (u, v) = (u / size, v / size);
    Some((a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]), [u, v]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Patches that share an edge have the same points on it, whichever way their parameters run and however they are cut otherwise.
    #[test]
    fn patches_have_the_same_points_on_an_edge_that_they_share() {
        // Both are bent more within than along the edge.
        let point = |k: usize| {
            let (column, row) = (k % 7, k / 7);
            let off = if column == 3 { 0.02 * ((row * row) % 3) as f32 } else { 0.5 * ((k * k) % 5) as f32 };
            Vec3::new(column as f32, off, row as f32)
        };
        let grid = |first: usize| std::array::from_fn(|k| point(first + k % 4 + 7 * (k / 4)));
        let turned = |p: [Vec3; 16]| std::array::from_fn(|k| p[15 - k]);
        let (one, other) =
            (Patch::smooth(grid(0), [0.0, 1.0], [0.0, 1.0]), Patch::smooth(turned(grid(3)), [0.0, 1.0], [0.0, 1.0]));
        let to_world = Mat4::from_rotation_y(0.3) * Mat4::from_translation(Vec3::new(0.1, 7.3, 2.0));
        let points = |patch: &Patch| {
            let corners = quads_of(patch, Cut::of(patch), to_world).flatten();
            corners.map(|p| p.to_array().map(f32::to_bits)).collect::<std::collections::BTreeSet<_>>()
        };
        let shared = points(&one).intersection(&points(&other)).count();
        let n = Cut::of(&one).edges[3].expect("a bent edge");
        assert!(n > 1 && Cut::of(&one).n[1] > n, "{n} of {:?}", Cut::of(&one).n);
        assert_eq!(shared, n + 1);
    }

    /// About a pole are triangles of the surface alone, and no needles between what rounding makes of it.
    #[test]
    fn a_pole_is_one_point() {
        let arc = [Vec3::X, Vec3::new(1.0, 0.55, 0.0), Vec3::new(0.55, 1.0, 0.0), Vec3::Y];
        let middle = Vec3::new(0.1, 0.2, 1.5);
        let p = std::array::from_fn(|k| middle + arc[k % 4] * (1.0 - (k / 4) as f32 / 3.0));
        let disk = Patch::smooth(p, [0.0, 1.0], [0.0, 1.0]);
        let cut = Cut::of(&disk);
        assert!(cut.n[0] > 6, "{:?}", cut.n);
        let at_pole: Vec<Vec3> = quads_of(&disk, cut, Mat4::IDENTITY)
            .skip(cut.n[0] * (cut.n[1] - 1))
            .flat_map(|[_, _, c, d]| [c, d])
            .collect();
        assert!(at_pole.len() == 2 * cut.n[0] && at_pole.iter().all(|p| *p == middle), "{at_pole:?}");
    }

    /// Rays through the edges and corners of a fan of triangles, from near and far: none gets through.
    #[test]
    fn no_ray_passes_between_triangles_that_share_an_edge() {
        let middle = Vec3::new(0.31, -0.17, 0.05);
        let on_rim = |k: usize| {
            let turn = std::f32::consts::TAU * k as f32 / 8.0;
            Vec3::new(turn.cos(), turn.sin(), 0.1 * (k % 3) as f32)
        };
        let rim: Vec<Vec3> = (0..9).map(|k| on_rim(k % 8)).collect();
        for k in 0..40_000usize {
            let (spoke, part, far) = (rim[k % 8], (k / 8 % 50) as f32 / 60.0, 10f32.powi((k / 400 % 5) as i32));
            let target = middle + (spoke - middle) * part;
            let from = target + Vec3::new(0.3 * (k / 2000) as f32 - 2.0, 0.7, 3.0) * far;
            let sight = Sight::new(from, (target - from).normalize());
            let met = rim.windows(2).filter(|w| meet_triangle(&sight, [middle, w[0], w[1]], 0.0).is_some()).count();
            assert!(met > 0, "ray {k}");
        }
    }
}
