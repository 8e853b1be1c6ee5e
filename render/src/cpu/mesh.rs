//! A grid of a displaced surface as rays meet it: the very micropolygons that the camera sees, so that a ray that starts from one
//! of their points starts on what it could meet, and no room has to be left around it.

use crate::gprim::grid::{Grid, Origin};
use crate::scene::facets::{Sight, meet_seen};
use glam::{Vec2, Vec3, Vec3A};
use sl::Global;

/// Micropolygons along the edge of a block, whose box is tested before them.
const BLOCK: usize = 4;

/// How far, in parts of a triangle, a ray may pass it by: rays along rows of points run through edges, and nothing may get
/// through between neighbours.
const EDGE: f32 = 1e-5;

/// A displaced grid.
pub struct Mesh {
    points: Vec<Vec3>,
    normals: Vec<[i16; 2]>,
    nu: usize,
    /// Micropolygons that are cut away; none if empty.
    trimmed: Vec<bool>,
    blocks: Vec<(Vec3A, Vec3A)>,
    /// How near its start a ray meets none of it.
    room: f32,
    /// The part of a patch that it is.
    origin: Option<Origin>,
}

/// Where a ray meets a mesh.
#[derive(Clone, Copy)]
pub struct Spot {
    /// How far along the ray.
    pub t: f32,
    /// The ray's direction by the cross product of those along u and v.
    pub along: f32,
    /// The shading normal.
    pub normal: Vec3,
    /// The normal of the triangle, by the directions along u and v.
    pub facet: Vec3,
    /// Index of the patch, and where in its parameters.
    pub on: Option<(u32, [f32; 2])>,
}

impl Mesh {
    /// The mesh of a grid that was displaced; none if a point of it is nowhere.
    pub fn new(grid: &Grid) -> Option<Mesh> {
        let (n, nu) = (grid.points.n(), grid.points.nu);
        let of = |global: Global| {
            let values = grid.points.get(global).filter(|v| v.len() == 3 * n)?;
            Some((0..n).map(|k| Vec3::new(values[k], values[n + k], values[2 * n + k])).collect::<Vec<Vec3>>())
        };
        let points = of(Global::P)?;
        if nu < 2 || !points.iter().all(|p| p.is_finite()) {
            return None;
        }
        let normals = of(Global::N)?.into_iter().map(octahedral).collect();
        let mut mesh =
            Mesh { points, normals, nu, trimmed: grid.trimmed.clone(), blocks: vec![], room: 0.0, origin: grid.origin };
        mesh.blocks =
            (0..mesh.columns().div_ceil(BLOCK) * mesh.rows().div_ceil(BLOCK)).map(|b| mesh.bound(b)).collect();
        let edge = |k: usize| (mesh.points[k + nu + 1] - mesh.points[k]).length_squared();
        let longest = mesh.quads(None).map(edge).fold(0.0, f32::max).sqrt();
        let farthest = mesh.points.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        mesh.room = 1e-3 * longest + 2e-6 * farthest;
        Some(mesh)
    }

    fn columns(&self) -> usize {
        self.nu - 1
    }

    fn rows(&self) -> usize {
        self.points.len() / self.nu - 1
    }

    /// The columns and rows of micropolygons of a block.
    fn span(&self, block: usize) -> [(usize, usize); 2] {
        let across = self.columns().div_ceil(BLOCK);
        let [i, j] = [block % across * BLOCK, block / across * BLOCK];
        [(i, (i + BLOCK).min(self.columns())), (j, (j + BLOCK).min(self.rows()))]
    }

    /// The first points of the micropolygons of a block, or of all.
    fn quads(&self, block: Option<usize>) -> impl Iterator<Item = usize> + '_ {
        let [i, j] = block.map_or([(0, self.columns()), (0, self.rows())], |block| self.span(block));
        let [i, j] = [i, j].map(|(from, to)| from..to);
        let is_there = move |i: usize, j: usize| self.trimmed.get(j * self.columns() + i) != Some(&true);
        j.flat_map(move |j| i.clone().filter(move |i| is_there(*i, j)).map(move |i| j * self.nu + i))
    }

    fn bound(&self, block: usize) -> (Vec3A, Vec3A) {
        let corners = self.quads(Some(block)).flat_map(|k| [k, k + 1, k + self.nu, k + self.nu + 1]);
        let (lo, hi) = corners.fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(lo, hi), k| {
            let p = Vec3A::from(self.points[k]);
            (lo.min(p), hi.max(p))
        });
        // A ray along the side of a box may miss it by a not-a-number.
        let room = 1e-6 * lo.abs().max(hi.abs()).max_element();
        if room.is_finite() { (lo - room, hi + room) } else { (lo, hi) }
    }

    /// The box around it.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let (lo, hi) = self
            .blocks
            .iter()
            .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(lo, hi), (a, b)| (lo.min(*a), hi.max(*b)));
        (lo.into(), hi.into())
    }

    /// Corners of the two triangles of a micropolygon.
    fn triangles(&self, k: usize) -> [[usize; 3]; 2] {
        [[k, k + 1, k + self.nu + 1], [k, k + self.nu + 1, k + self.nu]]
    }

    /// Its triangles, whose corners turn from the direction along u to that along v.
    pub fn facets(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        self.quads(None).flat_map(|k| self.triangles(k)).map(|corners| corners.map(|k| self.points[k]))
    }

    /// How near its start a ray meets none of it.
    pub fn room(&self) -> f32 {
        self.room
    }

    /// Visit the triangles that a ray of unit direction meets, from `least` on and no farther than a length: how far, which, and
    /// where in it. The visitor answers how much of the length still counts.
    #[inline]
    fn meet(
        &self,
        from: Vec3,
        dir: Vec3,
        least: f32,
        mut length: f32,
        mut visit: impl FnMut(f32, [usize; 3], [f32; 2]) -> f32,
    ) {
        let (origin, inv) = (Vec3A::from(from), Vec3A::from(dir).recip());
        let sight = Sight::new(from, dir);
        let near = least.max(self.room);
        for (block, (min, max)) in self.blocks.iter().enumerate() {
            let (t0, t1) = ((*min - origin) * inv, (*max - origin) * inv);
            if t0.min(t1).max_element().max(0.0) > t0.max(t1).min_element().min(length) {
                continue;
            }
            // Its points as seen along the ray, and how far along.
            let [(i0, i1), (j0, j1)] = self.span(block);
            let mut seen = [[0.0f32; 3]; (BLOCK + 1) * (BLOCK + 1)];
            for j in j0..=j1 {
                for i in i0..=i1 {
                    seen[(j - j0) * (BLOCK + 1) + i - i0] = sight.seen(self.points[j * self.nu + i]);
                }
            }
            for (i, j) in (j0..j1).flat_map(|j| (i0..i1).map(move |i| (i, j))) {
                let first = (j - j0) * (BLOCK + 1) + i - i0;
                if passes_by(&seen, first) {
                    continue;
                }
                let [a, b, c, d] = [first, first + 1, first + BLOCK + 2, first + BLOCK + 1].map(|k| seen[k]);
                for (half, triangle) in [[a, b, c], [a, c, d]].into_iter().enumerate() {
                    let Some((t, at)) = meet_seen(triangle, EDGE).filter(|(t, _)| *t > near && *t < length) else {
                        continue;
                    };
                    if self.trimmed.get(j * self.columns() + i) != Some(&true) {
                        length = visit(t, self.triangles(j * self.nu + i)[half], at);
                    }
                }
            }
        }
    }

    /// Whether a ray meets it within a length.
    pub fn blocks(&self, from: Vec3, dir: Vec3, length: f32) -> bool {
        let mut blocked = false;
        self.meet(from, dir, 0.0, length, |_, _, _| {
            blocked = true;
            0.0
        });
        blocked
    }

    /// How far along a ray it is met first, from `least` on.
    pub fn nearest(&self, from: Vec3, dir: Vec3, least: f32, length: f32) -> Option<f32> {
        let mut best = None;
        self.meet(from, dir, least, length, |t, _, _| {
            best = Some(t);
            t
        });
        best
    }

    /// Add all places where a ray meets it.
    pub fn spots(&self, from: Vec3, dir: Vec3, least: f32, out: &mut Vec<Spot>) {
        self.meet(from, dir, least, f32::INFINITY, |t, corners, at| {
            out.push(self.spot(dir, t, corners, at));
            f32::INFINITY
        });
    }

    fn spot(&self, dir: Vec3, t: f32, corners: [usize; 3], [x, y]: [f32; 2]) -> Spot {
        let [a, b, c] = corners.map(|k| self.points[k]);
        let [m, n, o] = corners.map(|k| direction(self.normals[k]));
        let place = |k: usize| Vec2::new((k % self.nu) as f32, (k / self.nu) as f32);
        let at = place(corners[0]) * (1.0 - x - y) + place(corners[1]) * x + place(corners[2]) * y;
        let part = at / Vec2::new(self.columns() as f32, self.rows() as f32);
        Spot {
            t,
            along: dir.dot((b - a).cross(c - a)),
            facet: (b - a).cross(c - a).normalize_or_zero(),
            normal: (m * (1.0 - x - y) + n * x + o * y).normalize_or_zero(),
            on: self.origin.map(|o| {
                let between = |r: [f32; 2], part: f32| r[0] + (r[1] - r[0]) * part;
                (o.patch, [between(o.u, part.x), between(o.v, part.y)])
            }),
        }
    }
}

/// Whether a ray passes by the box around a micropolygon, by more than it may pass triangles by.
#[inline(always)]
fn passes_by(seen: &[[f32; 3]; (BLOCK + 1) * (BLOCK + 1)], first: usize) -> bool {
    let beside = |axis: usize| {
        let [a, b] = [seen[first][axis], seen[first + 1][axis]];
        let [c, d] = [seen[first + BLOCK + 2][axis], seen[first + BLOCK + 1][axis]];
        let (lo, hi) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
        let room = 8.0 * EDGE * (hi - lo);
        lo > room || hi < -room
    };
    beside(0) || beside(1)
}

/// A direction in four bytes: its place on an octahedron.
fn octahedral(n: Vec3) -> [i16; 2] {
    let n = n / n.abs().element_sum().max(f32::MIN_POSITIVE);
    let folded = |a: f32, b: f32| (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 };
    let [x, y] = if n.z >= 0.0 { [n.x, n.y] } else { [folded(n.x, n.y), folded(n.y, n.x)] };
    [x, y].map(|x| (x * 32767.0).round() as i16)
}

/// The direction of [`octahedral`].
fn direction(packed: [i16; 2]) -> Vec3 {
    let [x, y] = packed.map(|x| x as f32 / 32767.0);
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    let bent = |x: f32| if x >= 0.0 { x - fold } else { x + fold };
    Vec3::new(bent(x), bent(y), z).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_keep_four_digits() {
        for k in 0..1000 {
            let (turn, z) = (k as f32 * 2.4, 1.0 - 0.002 * k as f32);
            let n = (Vec2::from_angle(turn) * (1.0 - z * z).max(0.0).sqrt()).extend(z);
            assert!((direction(octahedral(n)) - n).length() < 1e-4, "{n}");
        }
    }
}
