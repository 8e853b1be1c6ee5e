//! Convex hulls, surfaces of triangles; mass properties of solids.

mod surface;

use crate::ShapeKind;
use crate::farthest::Columns;
use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::PI;

pub use surface::Surface;

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
    /// The most corners of a face that contacts are made of, as in `gpu/clip.wgsl`.
    pub const MOST_CORNERS: usize = 16;

    /// The convex hull of points, m, relative to its centroid, and the centroid. `None` if the points lie in a plane, or so nearly that faces merge.
    pub fn of_points(points: &[DVec3]) -> Option<(Hull, DVec3)> {
        let points = &distinct(points);
        let triangles = hull_triangles(points)?;
        let mut hull = merge_coplanar(points, &triangles);
        if hull.faces.len() < 4 {
            return None;
        }
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

    /// Index of the vertex that is farthest in a direction.
    pub fn farthest(&self, direction: DVec3) -> usize {
        self.columns[0].farthest(direction)
    }

    /// The face whose normal is closest to a direction.
    pub fn facing(&self, direction: DVec3) -> &[u32] {
        &self.faces[self.columns[1].farthest(direction)]
    }

    /// The normal of that face.
    pub fn normal_facing(&self, direction: DVec3) -> DVec3 {
        self.normals[self.columns[1].farthest(direction)]
    }

    /// The corners of a face that contacts are made of: all, or of more than [`Hull::MOST_CORNERS`] some all around it.
    pub fn corners_of(face: &[u32]) -> impl Iterator<Item = u32> {
        let n = face.len().min(Self::MOST_CORNERS);
        (0..n).map(move |k| face[k * face.len() / n])
    }

    /// Half lengths of the box about the centroid that contains all vertices, m.
    pub fn half_extent(&self) -> DVec3 {
        self.vertices.iter().fold(DVec3::ZERO, |h, v| h.max(v.abs()))
    }
}

/// The points without those that nearly coincide with one before them, which faces between would tear the hull.
fn distinct(points: &[DVec3]) -> Vec<DVec3> {
    /// What points are apart, over the extent of all.
    const APART: f64 = 1e-7;
    let Some(first) = points.first() else { return vec![] };
    let apart = APART * points.iter().fold(DVec3::ZERO, |h, p| h.max((*p - *first).abs())).length();
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|i, j| points[*i].x.total_cmp(&points[*j].x));
    let mut is_kept = vec![true; points.len()];
    for (place, &i) in order.iter().enumerate() {
        let near = order[place + 1..].iter().take_while(|j| points[**j].x - points[i].x <= apart);
        for &j in near.filter(|j| points[**j].distance(points[i]) <= apart) {
            if is_kept[i.min(j)] {
                is_kept[i.max(j)] = false;
            }
        }
    }
    points.iter().zip(is_kept).filter(|(_, is_kept)| *is_kept).map(|(p, _)| *p).collect()
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
            let (cylinder, sphere) = (2.0 * PI * r * r * h, 4.0 / 3.0 * PI * (r * r * r));
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
        for height in [0.0, 1e-9] {
            let fourth = DVec3::new(1.0, 1.0, height);
            assert!(Hull::of_points(&[DVec3::ZERO, DVec3::X, DVec3::Y, fourth]).is_none(), "{height}");
        }
    }

    #[test]
    fn points_that_nearly_coincide_are_one_corner() {
        let mut random = crate::fill::SplitMix64(7);
        for k in 0..300 {
            let off = 10f64.powf(-13.0 + 0.02 * k as f64);
            let mut points = cube_corners(0.06, DVec3::ZERO);
            for _ in 0..3 {
                let near =
                    points[..8].iter().map(|p| *p + off * DVec3::from([0; 3].map(|_| random.between(-1.0, 1.0))));
                points.extend(near.collect::<Vec<_>>());
            }
            let (hull, _) = Hull::of_points(&points).unwrap();
            let volume = solid_of(ShapeKind::Hull, DVec3::ZERO, Some(&hull)).volume;
            assert!((volume / 0.12f64.powi(3) - 1.0).abs() < 60.0 * off + 1e-12, "{off:.1e}: {volume}");
        }
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
