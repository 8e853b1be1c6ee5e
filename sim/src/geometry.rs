//! Convex hulls, triangle meshes and height fields; mass properties of solids.

use crate::ShapeKind;
use crate::farthest::Columns;
use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::PI;

/// A convex polyhedron about its centroid.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    /// Vertices, relative to the centroid, m.
    pub vertices: Vec<DVec3>,
    /// Faces: polygons of indices into `vertices`, anticlockwise seen from outside (n_faces).
    pub faces: Vec<Vec<u32>>,
    /// Outward unit normals of the faces (n_faces).
    pub normals: Vec<DVec3>,
    /// Greatest distance of a vertex from the centroid, m.
    pub radius: f64,
    /// The vertices and the normals, in columns.
    columns: [Columns; 2],
}

impl Hull {
    /// The convex hull of points, m, relative to its centroid, and the centroid. `None` if the points lie in a plane.
    pub fn of_points(points: &[DVec3]) -> Option<(Hull, DVec3)> {
        let triangles = hull_triangles(points)?;
        let mut hull = merge_coplanar(points, &triangles);
        let centre = solid(&hull.triangles().map(|t| t.map(|v| hull.vertices[v as usize])).collect::<Vec<_>>()).centre;
        hull.vertices.iter_mut().for_each(|v| *v -= centre);
        hull.radius = hull.vertices.iter().fold(0.0, |most, v| most.max(v.length()));
        hull.columns = [&hull.vertices, &hull.normals].map(|points| Columns::of(points));
        Some((hull, centre))
    }

    /// The triangles of the faces: indices into `vertices`, anticlockwise seen from outside.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.faces.iter().flat_map(|f| (1..f.len() - 1).map(move |k| [f[0], f[k], f[k + 1]]))
    }

    /// The vertex that is farthest in a direction, m.
    pub fn support(&self, direction: DVec3) -> DVec3 {
        self.vertices[self.columns[0].farthest(direction)]
    }

    /// The face whose normal is closest to a direction.
    pub fn facing(&self, direction: DVec3) -> &[u32] {
        &self.faces[self.columns[1].farthest(direction)]
    }

    /// Half lengths of the box about the centroid that contains all vertices, m.
    pub fn half_extent(&self) -> DVec3 {
        self.vertices.iter().fold(DVec3::ZERO, |h, v| h.max(v.abs()))
    }
}

/// The triangles of the convex hull of points, facing outwards, by an incremental construction from a tetrahedron.
fn hull_triangles(points: &[DVec3]) -> Option<Vec<[u32; 3]>> {
    let extent = points.iter().fold(DVec3::ZERO, |h, p| h.max((*p - points[0]).abs())).length();
    let tiny = 1e-10 * extent;
    let farthest = |f: &dyn Fn(DVec3) -> f64| {
        (0..points.len()).max_by(|a, b| f(points[*a]).total_cmp(&f(points[*b]))).filter(|i| f(points[*i]) > tiny)
    };
    let a = 0;
    let b = farthest(&|p| (p - points[a]).length())?;
    let along = (points[b] - points[a]).normalize();
    let c = farthest(&|p| (p - points[a]).reject_from(along).length())?;
    let normal = (points[b] - points[a]).cross(points[c] - points[a]).normalize();
    let d = farthest(&|p| (p - points[a]).dot(normal).abs())?;
    let (b, c) = if (points[d] - points[a]).dot(normal) > 0.0 { (c, b) } else { (b, c) };
    // Each face with its outward unit normal and a point on it.
    let on_plane = |f: [u32; 3]| (f, normal_of(points, &f), points[f[0] as usize]);
    let mut faces = [[a, b, c], [a, d, b], [b, d, c], [c, d, a]].map(|f| on_plane(f.map(|v| v as u32))).to_vec();
    let mut seen = vec![];
    for (i, point) in points.iter().enumerate() {
        seen.clear();
        faces.retain(|(f, n, p)| {
            let is_seen = (*point - *p).dot(*n) > tiny;
            seen.extend(is_seen.then_some(*f));
            !is_seen
        });
        faces.extend(rim(&seen).into_iter().map(|[u, v]| on_plane([u, v, i as u32])));
    }
    Some(faces.into_iter().map(|(f, ..)| f).collect())
}

/// The unit normal of a triangle of points, or zero.
fn normal_of(points: &[DVec3], triangle: &[u32; 3]) -> DVec3 {
    let [p, q, r] = triangle.map(|v| points[v as usize]);
    (q - p).cross(r - p).normalize_or_zero()
}

/// The rim of triangles: edges whose twins are not among theirs.
fn rim(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let edges: Vec<[u32; 2]> = triangles.iter().flat_map(|f| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]]).collect();
    edges.iter().copied().filter(|[u, v]| !edges.contains(&[*v, *u])).collect()
}

/// The polygon that coplanar triangles make, from its smallest vertex on.
fn outline(triangles: &[[u32; 3]]) -> Vec<u32> {
    if let [[a, b, c]] = *triangles {
        return if a < b.min(c) {
            vec![a, b, c]
        } else if b < c {
            vec![b, c, a]
        } else {
            vec![c, a, b]
        };
    }
    let rim = rim(triangles);
    let first = rim.iter().map(|[u, _]| *u).min().expect("a face has a rim");
    let (mut at, mut polygon) = (first, vec![]);
    loop {
        polygon.push(at);
        // Of several edges that begin here, where the face touches itself, the last.
        at = rim.iter().rev().find(|[u, _]| *u == at).expect("the rim is closed")[1];
        if at == first || polygon.len() > rim.len() {
            return polygon;
        }
    }
}

/// Merge coplanar triangles to polygons, and renumber the vertices in use.
fn merge_coplanar(points: &[DVec3], triangles: &[[u32; 3]]) -> Hull {
    let extent = points.iter().fold(0f64, |h, p| h.max((*p - points[0]).length()));
    let mut groups: Vec<(DVec3, f64, Vec<[u32; 3]>)> = Vec::with_capacity(triangles.len());
    for t in triangles {
        let n = normal_of(points, t);
        let d = n.dot(points[t[0] as usize]);
        match groups.iter_mut().find(|(m, e, _)| m.dot(n) > 1.0 - 1e-8 && (e - d).abs() < 1e-6 * extent) {
            Some(group) => group.2.push(*t),
            None => groups.push((n, d, vec![*t])),
        }
    }
    let mut index_of: Vec<Option<u32>> = vec![None; points.len()];
    let mut hull = Hull { vertices: vec![], faces: vec![], normals: vec![], radius: 0.0, columns: Default::default() };
    for (n, _, members) in groups {
        let face = outline(&members).into_iter().map(|at| {
            *index_of[at as usize].get_or_insert_with(|| {
                hull.vertices.push(points[at as usize]);
                hull.vertices.len() as u32 - 1
            })
        });
        hull.faces.push(face.collect());
        hull.normals.push(n);
    }
    hull
}

/// A static surface of triangles, solid below (behind) them.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Vertices, local, m.
    pub vertices: Vec<DVec3>,
    /// Triangles: indices into `vertices`, anticlockwise seen from outside (n_triangles).
    pub triangles: Vec<[u32; 3]>,
    /// Convex edges and corners of each triangle, as bits (n_triangles): bit e, from 0 to 2, is set if the edge from corner e to
    /// corner e+1 is convex or a border, and belongs to this triangle rather than to its neighbour; bit 3+k says the same of corner k.
    pub sharp: Vec<u8>,
    /// Spatial index of the triangles.
    index: Index,
}

/// Spatial index of triangles.
#[derive(Clone, Debug, PartialEq)]
enum Index {
    /// A tree of boxes: node i has the triangles `order[first..first+n]` if n > 0, else the nodes first and first+1.
    Tree { nodes: Vec<TreeNode>, order: Vec<u32> },
    /// A grid of cells in x and y, two triangles each.
    Cells { origin: [f64; 2], spacing: [f64; 2], n: [usize; 2] },
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct TreeNode {
    min: DVec3,
    max: DVec3,
    first: u32,
    n: u32,
}

impl Surface {
    /// A triangle mesh from vertices, m, and triangles that face outwards.
    pub fn mesh(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Surface {
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut nodes = vec![];
        let bounds = |t: u32| {
            let corners = triangles[t as usize].map(|v| vertices[v as usize]);
            (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]))
        };
        nodes.push(TreeNode { min: DVec3::ZERO, max: DVec3::ZERO, first: 0, n: order.len() as u32 });
        let mut open = vec![0usize];
        while let Some(i) = open.pop() {
            let TreeNode { first, n, .. } = nodes[i];
            let range = first as usize..(first + n) as usize;
            let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for t in &order[range.clone()] {
                let (lo, hi) = bounds(*t);
                (min, max) = (min.min(lo), max.max(hi));
            }
            (nodes[i].min, nodes[i].max) = (min, max);
            if n <= 4 {
                continue;
            }
            let extent = max - min;
            let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
            let middle = |t: u32| bounds(t).0[axis] + bounds(t).1[axis];
            order[range].sort_by(|a, b| middle(*a).total_cmp(&middle(*b)));
            let half = n / 2;
            let child = nodes.len() as u32;
            for (first, n) in [(first, half), (first + half, n - half)] {
                open.push(nodes.len());
                nodes.push(TreeNode { min, max, first, n });
            }
            (nodes[i].first, nodes[i].n) = (child, 0);
        }
        let sharp = sharp_edges(&vertices, &triangles);
        Surface { vertices, triangles, sharp, index: Index::Tree { nodes, order } }
    }

    /// A height field, m: `heights[j n_x + i]` at x = origin_x + i spacing_x, y = origin_y + j spacing_y, with n_x, n_y ≥ 2.
    pub fn height_field(heights: &[f64], n: [usize; 2], origin: [f64; 2], spacing: [f64; 2]) -> Surface {
        let vertices: Vec<DVec3> = (0..n[0] * n[1])
            .map(|k| {
                let (i, j) = ((k % n[0]) as f64, (k / n[0]) as f64);
                DVec3::new(origin[0] + i * spacing[0], origin[1] + j * spacing[1], heights[k])
            })
            .collect();
        let mut triangles = Vec::with_capacity(2 * (n[0] - 1) * (n[1] - 1));
        for j in 0..n[1] - 1 {
            for i in 0..n[0] - 1 {
                let v = |di: usize, dj: usize| ((j + dj) * n[0] + i + di) as u32;
                triangles.push([v(0, 0), v(1, 0), v(1, 1)]);
                triangles.push([v(0, 0), v(1, 1), v(0, 1)]);
            }
        }
        let sharp = sharp_edges(&vertices, &triangles);
        Surface { vertices, triangles, sharp, index: Index::Cells { origin, spacing, n: [n[0] - 1, n[1] - 1] } }
    }

    /// The corners of a triangle, local, m.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|v| self.vertices[v as usize])
    }

    /// Visit the triangles that a shape in the box from `min` to `max`, local, m, may touch, in a fixed order. In a mesh they are those
    /// whose boxes overlap the box; in a height field also the triangles above it, since a shape below the ground is pushed out.
    pub fn visit(&self, min: DVec3, max: DVec3, found: &mut dyn FnMut(u32)) {
        match &self.index {
            Index::Tree { nodes, order } => {
                let mut open = vec![0u32];
                while let Some(i) = open.pop() {
                    let node = &nodes[i as usize];
                    if !(node.min.cmple(max).all() && min.cmple(node.max).all()) {
                        continue;
                    }
                    if node.n == 0 {
                        open.extend([node.first + 1, node.first]);
                    } else {
                        order[node.first as usize..(node.first + node.n) as usize].iter().for_each(|t| found(*t));
                    }
                }
            }
            Index::Cells { origin, spacing, n } => {
                let cell = |x: f64, axis: usize| ((x - origin[axis]) / spacing[axis]).floor();
                let range = |axis: usize| {
                    let (lo, hi) = (cell(min[axis], axis), cell(max[axis], axis));
                    (hi >= 0.0 && lo < n[axis] as f64)
                        .then(|| (lo.max(0.0) as usize, (hi.max(0.0) as usize).min(n[axis] - 1)))
                };
                let (Some((i0, i1)), Some((j0, j1))) = (range(0), range(1)) else { return };
                for j in j0..=j1 {
                    for i in i0..=i1 {
                        for t in [0, 1] {
                            let triangle = (2 * (j * n[0] + i) + t) as u32;
                            // A shape below the ground is still to be pushed out of it.
                            if self.corners(triangle).iter().any(|c| c.z >= min.z) {
                                found(triangle);
                            }
                        }
                    }
                }
            }
        }
    }

    /// Minimum and maximum corner of the box that contains all vertices, local, m.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.vertices.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), v| (lo.min(*v), hi.max(*v)))
    }
}

/// The edges of triangles, in the direction in which each triangle goes about itself.
struct Edges {
    /// Where the edges from a vertex begin (n_vertices + 1).
    first: Vec<u32>,
    /// The other vertex and the triangle of each edge, ordered by them within a vertex (3 n_triangles).
    ends: Vec<[u32; 2]>,
}

impl Edges {
    fn of(n_vertices: usize, triangles: &[[u32; 3]]) -> Edges {
        let mut first = vec![0u32; n_vertices + 1];
        for v in triangles.as_flattened() {
            first[*v as usize + 1] += 1;
        }
        for v in 0..n_vertices {
            first[v + 1] += first[v];
        }
        let mut next = first.clone();
        let mut ends = vec![[0u32; 2]; 3 * triangles.len()];
        for (i, t) in triangles.iter().enumerate() {
            for e in 0..3 {
                let at = &mut next[t[e] as usize];
                ends[*at as usize] = [t[(e + 1) % 3], i as u32];
                *at += 1;
            }
        }
        first.windows(2).for_each(|range| ends[range[0] as usize..range[1] as usize].sort_unstable());
        Edges { first, ends }
    }

    /// The triangle that has an edge, the last of several.
    fn triangle(&self, from: u32, to: u32) -> Option<usize> {
        let ends = &self.ends[self.first[from as usize] as usize..self.first[from as usize + 1] as usize];
        let beyond = ends.partition_point(|[end, _]| *end <= to);
        ends[..beyond].last().filter(|[end, _]| *end == to).map(|[_, triangle]| *triangle as usize)
    }
}

/// The bits of convex edges and corners, each of which belongs to one triangle.
fn sharp_edges(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Vec<u8> {
    let at = |v: u32| vertices[v as usize];
    let normal = |t: &[u32; 3]| (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).normalize_or_zero();
    let edges = Edges::of(vertices.len(), triangles);
    let mut sharp = vec![0u8; triangles.len()];
    let mut corner_taken = vec![false; vertices.len()];
    for (i, t) in triangles.iter().enumerate() {
        for e in 0..3 {
            let is_convex = match edges.triangle(t[(e + 1) % 3], t[e]) {
                None => true,
                Some(j) => {
                    let other = triangles[j].iter().find(|v| **v != t[e] && **v != t[(e + 1) % 3]);
                    let beyond = other.map_or(DVec3::ZERO, |v| at(*v) - at(t[e]));
                    i < j && beyond.dot(normal(t)) < -1e-6 * beyond.length()
                }
            };
            if is_convex {
                sharp[i] |= 1 << e;
                for k in [e, (e + 1) % 3] {
                    if !std::mem::replace(&mut corner_taken[t[k] as usize], true) {
                        sharp[i] |= 8 << k;
                    }
                }
            }
        }
    }
    sharp
}

/// Mass properties of a solid of unit density.
#[derive(Clone, Copy, Debug)]
pub struct Solid {
    /// Volume, m³.
    pub volume: f64,
    /// Centroid, m.
    pub centre: DVec3,
    /// Inertia tensor about the centroid, for unit density, m⁵.
    pub inertia: DMat3,
}

/// Mass properties of the solid inside a closed surface of triangles that face outwards (corners, m), by signed tetrahedra from the origin.
pub fn solid(triangles: &[[DVec3; 3]]) -> Solid {
    let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    for [a, b, c] in triangles {
        let v = a.dot(b.cross(*c)) / 6.0;
        let sum = *a + *b + *c;
        volume += v;
        first += sum * (v / 4.0);
        second += (outer(*a, *a) + outer(*b, *b) + outer(*c, *c) + outer(sum, sum)) * (v / 20.0);
    }
    let centre = if volume != 0.0 { first / volume } else { DVec3::ZERO };
    let about = second - outer(centre, centre) * volume;
    let trace = about.x_axis.x + about.y_axis.y + about.z_axis.z;
    Solid { volume, centre, inertia: DMat3::from_diagonal(DVec3::splat(trace)) - about }
}

/// Mass properties of a shape, relative to the shape's origin; `size`, m, has the meaning of the [`ShapeKind`], and `hull` is given for a
/// hull. A surface has no volume.
pub fn solid_of(kind: ShapeKind, size: DVec3, hull: Option<&Hull>) -> Solid {
    let (r, h) = (size.x, size.z);
    let diagonal = |volume: f64, per_volume: DVec3| Solid {
        volume,
        centre: DVec3::ZERO,
        inertia: DMat3::from_diagonal(per_volume * volume),
    };
    match kind {
        ShapeKind::Sphere | ShapeKind::Ellipsoid => {
            let s = size * size;
            let volume = 4.0 / 3.0 * PI * size.element_product();
            diagonal(volume, DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y) / 5.0)
        }
        ShapeKind::Box => {
            let s = size * size;
            diagonal(8.0 * size.element_product(), DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y) / 3.0)
        }
        ShapeKind::Cylinder => {
            let across = r * r / 4.0 + h * h / 3.0;
            diagonal(2.0 * PI * r * r * h, DVec3::new(across, across, r * r / 2.0))
        }
        ShapeKind::Capsule => {
            let (cylinder, sphere) = (2.0 * PI * r * r * h, 4.0 / 3.0 * PI * r.powi(3));
            let across = cylinder * (r * r / 4.0 + h * h / 3.0) + sphere * (0.4 * r * r + h * h + 0.75 * h * r);
            let about = cylinder * r * r / 2.0 + sphere * 0.4 * r * r;
            Solid {
                volume: cylinder + sphere,
                centre: DVec3::ZERO,
                inertia: DMat3::from_diagonal(DVec3::new(across, across, about)),
            }
        }
        ShapeKind::Cone => {
            // The full height is 2h; the centre is a quarter of it above the base.
            let volume = 2.0 / 3.0 * PI * r * r * h;
            let across = 0.15 * r * r + 0.0375 * 4.0 * h * h;
            Solid {
                centre: DVec3::new(0.0, 0.0, -0.5 * h),
                ..diagonal(volume, DVec3::new(across, across, 0.3 * r * r))
            }
        }
        ShapeKind::Hull => {
            let hull = hull.expect("a hull shape has its hull");
            solid(&hull.triangles().map(|t| t.map(|v| hull.vertices[v as usize])).collect::<Vec<_>>())
        }
        ShapeKind::Plane | ShapeKind::Mesh | ShapeKind::HeightField => diagonal(0.0, DVec3::ZERO),
    }
}

/// Principal moments of a symmetric inertia tensor, in the tensor's unit, and the rotation from the principal frame to the tensor's
/// frame, by Jacobi rotations.
pub fn principal(tensor: DMat3) -> (DVec3, DQuat) {
    let largest = tensor.to_cols_array().iter().fold(0f64, |m, x| m.max(x.abs()));
    let (mut a, mut v) = (tensor, DMat3::IDENTITY);
    let off = |a: &DMat3| [(0, 1), (0, 2), (1, 2)].map(|(i, j)| (i, j, a.col(j)[i]));
    for _ in 0..60 {
        let (i, j, x) = off(&a).into_iter().max_by(|p, q| p.2.abs().total_cmp(&q.2.abs())).unwrap_or((0, 1, 0.0));
        if x.abs() <= 1e-14 * largest {
            break;
        }
        let angle = 0.5 * (2.0 * x).atan2(a.col(j)[j] - a.col(i)[i]);
        let (s, c) = angle.sin_cos();
        let mut rotation = DMat3::IDENTITY;
        rotation.col_mut(i)[i] = c;
        rotation.col_mut(j)[j] = c;
        rotation.col_mut(j)[i] = s;
        rotation.col_mut(i)[j] = -s;
        a = rotation.transpose() * a * rotation;
        v *= rotation;
    }
    if v.determinant() < 0.0 {
        v.z_axis = -v.z_axis;
    }
    (DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z), DQuat::from_mat3(&v).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube_corners(half: f64, at: DVec3) -> Vec<DVec3> {
        (0..8)
            .map(|k| at + half * DVec3::new([-1.0, 1.0][k & 1], [-1.0, 1.0][k >> 1 & 1], [-1.0, 1.0][k >> 2]))
            .collect()
    }

    #[test]
    fn the_hull_of_a_cube_has_six_faces_and_its_mass() {
        let mut points = cube_corners(0.5, DVec3::new(1.0, 2.0, 3.0));
        points.push(DVec3::new(1.1, 2.1, 3.1));
        let (hull, centre) = Hull::of_points(&points).unwrap();
        assert_eq!((hull.vertices.len(), hull.faces.len()), (8, 6));
        assert!((centre - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-12);
        let s = solid_of(ShapeKind::Hull, DVec3::ZERO, Some(&hull));
        assert!((s.volume - 1.0).abs() < 1e-12 && (s.inertia.x_axis.x - 1.0 / 6.0).abs() < 1e-12);
        assert!(Hull::of_points(&points[..2]).is_none());
        assert!(Hull::of_points(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y]).is_none());
    }

    /// A solid of revolution about z as many thin triangles.
    fn revolved(profile: &[[f64; 2]]) -> Solid {
        let n = 720;
        let at = |k: usize, [r, z]: [f64; 2]| {
            let (s, c) = (k as f64 * std::f64::consts::TAU / n as f64).sin_cos();
            DVec3::new(r * c, r * s, z)
        };
        let mut triangles = vec![];
        for k in 0..n {
            for pair in profile.windows(2) {
                let (a, b, c, d) = (at(k, pair[0]), at(k + 1, pair[0]), at(k + 1, pair[1]), at(k, pair[1]));
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        solid(&triangles)
    }

    #[test]
    fn solids_of_revolution_agree_with_their_triangles() {
        let (r, h) = (0.3, 0.7);
        let arc: Vec<[f64; 2]> =
            (0..=180).map(|k| (k as f64 - 90.0).to_radians()).map(|a| [r * a.cos(), r * a.sin()]).collect();
        let capsule: Vec<[f64; 2]> = arc.iter().map(|[x, z]| [*x, z + if *z < 0.0 { -h } else { h }]).collect();
        let cases = [
            (ShapeKind::Sphere, DVec3::splat(r), arc.clone()),
            (ShapeKind::Cylinder, DVec3::new(r, r, h), vec![[0.0, -h], [r, -h], [r, h], [0.0, h]]),
            (ShapeKind::Cone, DVec3::new(r, r, h), vec![[0.0, -h], [r, -h], [0.0, h]]),
            (ShapeKind::Capsule, DVec3::new(r, r, h), capsule),
        ];
        for (kind, size, profile) in cases {
            let (exact, measured) = (solid_of(kind, size, None), revolved(&profile));
            assert!((exact.volume / measured.volume - 1.0).abs() < 1e-3, "{kind:?}");
            assert!((exact.centre - measured.centre).length() < 1e-3, "{kind:?}");
            for axis in 0..3 {
                let (a, b) = (exact.inertia.col(axis)[axis], measured.inertia.col(axis)[axis]);
                assert!((a / b - 1.0).abs() < 2e-3, "{kind:?} {axis}: {a} {b}");
            }
        }
    }

    #[test]
    fn principal_axes_rebuild_the_tensor() {
        let q = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
        let r = DMat3::from_quat(q);
        let tensor = r * DMat3::from_diagonal(DVec3::new(3.0, 1.0, 2.0)) * r.transpose();
        let (moments, rotation) = principal(tensor);
        let m = DMat3::from_quat(rotation);
        let again = m * DMat3::from_diagonal(moments) * m.transpose();
        assert!((again - tensor).to_cols_array().iter().all(|x| x.abs() < 1e-12));
    }
}
