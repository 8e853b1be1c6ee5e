//! The distance of two convex shapes (Gilbert, Johnson, Keerthi 1988) and, where they overlap, the minimum translation that
//! separates them (expanding polytope algorithm, van den Bergen 2001). Both know a shape only by its support function.
//!
//! A sphere is a point and a capsule a segment, with a radius around them: they are exact.

use super::point::Placed;
use crate::ShapeKind;
use crate::manifolds::{Corner, Corners};
use glam::{DVec2, DVec3};

/// The nearest points of two shapes.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Unit normal from the first to the second.
    pub normal: DVec3,
    /// Point on the first, m.
    pub on_first: DVec3,
    /// Point on the second, m.
    pub on_second: DVec3,
    /// Gap, m; negative in overlap.
    pub gap: f64,
}

/// A convex set: a core that is known by its support function, with a radius around it.
pub trait Convex {
    /// Support function: the farthest point of the core in a direction, world, m, and the corner that it is.
    fn support(&self, direction: DVec3) -> (DVec3, Corner);
    /// The place of a corner, world, m, if there is one of this number.
    fn corner(&self, corner: Corner) -> Option<DVec3>;
    /// A point inside, m.
    fn centre(&self) -> DVec3;
    /// Radius around the core, m.
    fn radius(&self) -> f64;
}

impl Convex for Placed<'_> {
    fn support(&self, direction: DVec3) -> (DVec3, Corner) {
        let (point, corner) = support_local(self, self.local(direction));
        (self.position + self.rotation * point, corner)
    }

    fn corner(&self, corner: Corner) -> Option<DVec3> {
        let index = (corner as usize).checked_sub(1)?;
        let local = match self.kind {
            ShapeKind::Box => box_corner(self.size, index),
            ShapeKind::Hull => *self.hull?.vertices.get(index)?,
            _ => return None,
        };
        Some(self.position + self.rotation * local)
    }

    fn centre(&self) -> DVec3 {
        self.position
    }

    fn radius(&self) -> f64 {
        if matches!(self.kind, ShapeKind::Sphere | ShapeKind::Capsule) { self.size.x } else { 0.0 }
    }
}

/// A triangle as a convex set.
impl Convex for [DVec3; 3] {
    fn support(&self, direction: DVec3) -> (DVec3, Corner) {
        let [a, b, c] = self.map(|v| v.dot(direction));
        if a >= b && a >= c {
            (self[0], 1)
        } else if b >= c {
            (self[1], 2)
        } else {
            (self[2], 3)
        }
    }

    fn corner(&self, corner: Corner) -> Option<DVec3> {
        self.get((corner as usize).checked_sub(1)?).copied()
    }

    fn centre(&self) -> DVec3 {
        (self[0] + self[1] + self[2]) / 3.0
    }

    fn radius(&self) -> f64 {
        0.0
    }
}

/// A corner of a box: bit k of the index is set where it is on the negative side of axis k.
pub fn box_corner(size: DVec3, index: usize) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|k| if index >> k & 1 == 1 { -size[k] } else { size[k] }))
}

/// Support function of a shape's core, local, m, and the corner that the point is.
pub fn support_local(shape: &Placed, d: DVec3) -> (DVec3, Corner) {
    let size = shape.size;
    let rim = |radius: f64, z: f64| {
        let across = d.truncate().length();
        if across > 0.0 { (d.truncate() * (radius / across)).extend(z) } else { DVec2::new(radius, 0.0).extend(z) }
    };
    let curved = match shape.kind {
        ShapeKind::Box => {
            let index = d.to_array().map(|d| d.is_sign_negative() as usize);
            let index = index[0] | index[1] << 1 | index[2] << 2;
            return (box_corner(size, index), index as Corner + 1);
        }
        ShapeKind::Hull => {
            let Some(hull) = shape.hull else { return (DVec3::ZERO, 0) };
            let index = hull.farthest(d);
            return (hull.vertices[index], Corner::try_from(index + 1).unwrap_or(0));
        }
        ShapeKind::Sphere => DVec3::ZERO,
        ShapeKind::Ellipsoid => {
            let scaled = size * d;
            let length = scaled.length();
            if length > 0.0 { size * scaled / length } else { DVec3::new(0.0, 0.0, size.z) }
        }
        ShapeKind::Cylinder => rim(size.x, size.z.copysign(d.z)),
        ShapeKind::Capsule => DVec3::new(0.0, 0.0, size.z.copysign(d.z)),
        ShapeKind::Cone => {
            let base = rim(size.x, -size.z);
            if d.z * size.z > base.dot(d) { DVec3::new(0.0, 0.0, size.z) } else { base }
        }
        ShapeKind::Plane | ShapeKind::Mesh | ShapeKind::HeightField => DVec3::ZERO,
    };
    (curved, 0)
}

/// A point of the Minkowski difference, with the points of A and B that it is the difference of, and their corners.
#[derive(Clone, Copy, Debug, Default)]
struct Vertex {
    w: DVec3,
    a: DVec3,
    b: DVec3,
    corners: [Corner; 2],
}

impl Vertex {
    fn of((a, i): (DVec3, Corner), (b, j): (DVec3, Corner)) -> Vertex {
        Vertex { w: a - b, a, b, corners: [i, j] }
    }
}

fn vertex(a: &impl Convex, b: &impl Convex, direction: DVec3) -> Vertex {
    Vertex::of(a.support(direction), b.support(-direction))
}

/// A simplex of up to three vertices with a point between them that is nearest to the origin.
#[derive(Clone, Copy, Debug)]
struct Simplex {
    /// Its vertices, and others in between: none is moved while the search goes on.
    v: [Vertex; 4],
    part: Part,
}

/// The vertices that a simplex is made of, by index, with the barycentric weights of the point nearest to the origin, none of them zero.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    of: [usize; 3],
    weight: [f64; 3],
    n: usize,
}

impl Part {
    #[inline(always)]
    fn new<const N: usize>(of: [usize; N], weight: [f64; N]) -> Part {
        let mut part = Part::default();
        for k in 0..N {
            if weight[k] > 0.0 {
                (part.of[part.n], part.weight[part.n]) = (of[k], weight[k]);
                part.n += 1;
            }
        }
        part
    }

    fn of(&self) -> &[usize] {
        &self.of[..self.n]
    }

    /// The nearest point, or that of the two sets which it is the difference of.
    #[inline(always)]
    fn sum(&self, v: &[Vertex; 4], of: impl Fn(&Vertex) -> DVec3) -> DVec3 {
        (0..self.n).map(|i| of(&v[self.of[i]]) * self.weight[i]).sum()
    }

    /// The part of these vertices that has the point nearest to the origin; `None` if the origin is inside, which it is not where
    /// `is_apart` is known. Of four vertices the last is new.
    fn nearest(v: &[Vertex; 4], of: &[usize], is_apart: bool) -> Option<Part> {
        match *of {
            [i] => Some(Part::new([i], [1.0])),
            [i, j] => {
                let along = v[j].w - v[i].w;
                let length2 = along.length_squared();
                let t = if length2 > 0.0 { (-v[i].w.dot(along) / length2).clamp(0.0, 1.0) } else { 0.0 };
                Some(Part::new([i, j], [1.0 - t, t]))
            }
            [i, j, k] => {
                let (s, t, u) = nearest_in_triangle(DVec3::ZERO, [v[i].w, v[j].w, v[k].w]);
                Some(Part::new([i, j, k], [s, t, u]))
            }
            [i, j, k, l] => Part::of_tetrahedron(v, [i, j, k, l], is_apart),
            _ => None,
        }
    }

    /// On a tetrahedron, of which the last vertex is new: where the origin is not inside, the nearest point is on a face with it.
    fn of_tetrahedron(v: &[Vertex; 4], of: [usize; 4], is_apart: bool) -> Option<Part> {
        let mut best: Option<(f64, [usize; 3], [f64; 3])> = None;
        let faces = [[0, 3, 1, 2], [0, 2, 3, 1], [1, 3, 2, 0], [0, 1, 2, 3]];
        for face in &faces[..if is_apart { 3 } else { 4 }] {
            let [i, j, k, other] = face.map(|corner| of[corner]);
            let [p, q, r] = [v[i].w, v[j].w, v[k].w];
            let is_beyond = || {
                let normal = (q - p).cross(r - p);
                let (here, there) = (-p.dot(normal), (v[other].w - p).dot(normal));
                // The origin is beyond this face, or the tetrahedron is flat, so that round-off may hide which face that is.
                here * there <= 0.0 || there.abs() <= 1e-14 * normal.length() * v[other].w.length()
            };
            if is_apart || is_beyond() {
                let (s, t, u) = nearest_in_triangle(DVec3::ZERO, [p, q, r]);
                let distance = (p * s + q * t + r * u).length_squared();
                if best.is_none_or(|(least, ..)| distance < least) {
                    best = Some((distance, [i, j, k], [s, t, u]));
                }
            }
        }
        best.map(|(_, of, weight)| Part::new(of, weight))
    }
}

impl Simplex {
    fn of(v: Vertex) -> Simplex {
        Simplex { v: [v; 4], part: Part::new([0], [1.0]) }
    }

    /// That of corners which two sets have.
    fn of_corners(a: &impl Convex, b: &impl Convex, corners: &Corners) -> Option<Simplex> {
        if *corners == Corners::default() {
            return None;
        }
        let mut v = [Vertex::default(); 4];
        let mut n = 0;
        for [i, j] in corners {
            let (Some(of_a), Some(of_b)) = (a.corner(*i), b.corner(*j)) else { break };
            v[n] = Vertex::of((of_a, *i), (of_b, *j));
            n += 1;
        }
        Some(Simplex { v, part: Part::nearest(&v, &[0, 1, 2][..n], false)? })
    }

    /// The pairs of corners that it is made of.
    fn corners(&self) -> Corners {
        let mut corners = Corners::default();
        for (to, k) in corners.iter_mut().zip(self.part.of()) {
            *to = self.v[*k].corners;
        }
        corners
    }

    fn nearest(&self) -> DVec3 {
        self.part.sum(&self.v, |v| v.w)
    }

    /// A place for a vertex among those that it is not made of.
    fn free(&self) -> usize {
        let used = self.part.of().iter().fold(0u32, |used, k| used | 1 << k);
        used.trailing_ones() as usize
    }

    /// The part of it and of the vertex at `new` that is nearest to the origin, as [`Part::nearest`] has it.
    fn with(&self, new: usize, is_apart: bool) -> Option<Part> {
        let mut of = [new; 4];
        of[..self.part.n].copy_from_slice(self.part.of());
        Part::nearest(&self.v, &of[..=self.part.n], is_apart)
    }

    fn vertices(&self) -> Vec<Vertex> {
        self.part.of().iter().map(|k| self.v[*k]).collect()
    }
}

/// Barycentric weights of the point of a triangle nearest to `p` (Ericson 2005, §5.1.5).
pub fn nearest_in_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> (f64, f64, f64) {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (1.0, 0.0, 0.0);
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return (0.0, 1.0, 0.0);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return (1.0 - t, t, 0.0);
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return (0.0, 0.0, 1.0);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return (1.0 - t, 0.0, t);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (0.0, 1.0 - t, t);
    }
    let sum = va + vb + vc;
    if !(sum > 0.0) {
        return (1.0, 0.0, 0.0);
    }
    (va / sum, vb / sum, vc / sum)
}

/// Where the search for the nearest points of two shapes begins, and where it has ended.
#[derive(Clone, Copy, Debug, Default)]
pub struct Axis {
    /// Unit direction from the first to the second along which the shapes are apart, world; zero where none is known.
    pub direction: DVec3,
    /// Separation along it, m: at most the gap.
    pub apart: f64,
    /// The corners of the simplex that had the nearest points, of shapes that have corners: most likely it has them again.
    pub corners: Corners,
}

/// Separation of two shapes along a unit direction from the first to the second, m.
pub fn separation(a: &impl Convex, b: &impl Convex, direction: DVec3) -> f64 {
    -vertex(a, b, direction).w.dot(direction) - a.radius() - b.radius()
}

/// The nearest points of two shapes; `None` if their gap is above `reach`, m, with `axis` along which it is. The search begins with the
/// corners of `axis`, or along it, which becomes the normal.
pub fn nearest(a: &impl Convex, b: &impl Convex, reach: f64, axis: &mut Axis) -> Option<Nearest> {
    match search(a, b, reach, axis) {
        Ok(nearest) => nearest,
        Err(Overlap { vertices, .. }) => overlapping(a, b, vertices, reach, axis),
    }
}

/// Two shapes that overlap, or that round-off does not tell from such.
pub struct Overlap {
    /// The vertices of a simplex around the origin.
    vertices: Vec<Vertex>,
    /// The nearest points where they may be apart.
    pub near: Option<Nearest>,
}

/// [`nearest`] of shapes that do not overlap.
pub fn search(a: &impl Convex, b: &impl Convex, reach: f64, axis: &mut Axis) -> Result<Option<Nearest>, Overlap> {
    const ROUNDS: usize = 80;
    /// Distance over the scale of the shapes up to which the direction is checked.
    const NEAR: f64 = 1e-3;
    /// How often the search starts again where round-off ends it early, and the width of the bounds of the squared distance, over it, above which it is early.
    const RESTARTS: usize = 3;
    const EARLY: f64 = 1e-9;
    let round = a.radius() + b.radius();
    let known = Simplex::of_corners(a, b, &axis.corners);
    let mut simplex = known.unwrap_or_else(|| {
        let is_known = axis.direction != DVec3::ZERO;
        let start = if is_known { axis.direction } else { b.centre() - a.centre() + DVec3::splat(1e-12) };
        Simplex::of(vertex(a, b, start))
    });
    let scale = simplex.v[0].a.distance(a.centre()) + simplex.v[0].b.distance(b.centre()) + round;
    let mut v = simplex.nearest();
    let (mut restarts, mut is_early, mut best) = (0, false, None::<Simplex>);
    for _ in 0..ROUNDS {
        let distance2 = v.length_squared();
        if distance2 <= 1e-20 * scale * scale {
            return Err(Overlap { vertices: simplex.vertices(), near: None });
        }
        let next = vertex(a, b, -v);
        // v·w bounds the distance from below.
        let lower = v.dot(next.w);
        if lower > 0.0 && lower * lower > distance2 * (round + reach).powi(2) {
            let distance = distance2.sqrt();
            *axis = Axis { direction: -v / distance, apart: lower / distance - round, corners: simplex.corners() };
            return Ok(None);
        }
        if distance2 - lower <= 1e-12 * distance2 {
            break;
        }
        let new = simplex.free();
        let is_known = simplex.part.of().iter().any(|k| simplex.v[*k].w == next.w);
        simplex.v[new] = next;
        let part = if is_known { Some(simplex.part) } else { simplex.with(new, lower > 0.0) };
        let Some(part) = part else {
            let mut around = simplex.vertices();
            around.push(next);
            return Err(Overlap { vertices: around, near: None });
        };
        let nearer = part.sum(&simplex.v, |v| v.w);
        if nearer.length_squared() < distance2 {
            (simplex.part, v) = (part, nearer);
            continue;
        }
        // Round-off ends the search. Where that is early, it starts again from where it has come to.
        if best.is_none_or(|b| distance2 < b.nearest().length_squared()) {
            best = Some(simplex);
        }
        is_early = distance2 - lower > EARLY * distance2;
        if !is_early || restarts == RESTARTS {
            break;
        }
        restarts += 1;
        (simplex, v) = (Simplex::of(next), next.w);
    }
    if let Some(best) = best.filter(|b| b.nearest().length_squared() < v.length_squared()) {
        (simplex, v) = (best, best.nearest());
    }
    let distance = v.length();
    let normal = -v / distance;
    let gap = distance - round;
    let nearest = Nearest {
        normal,
        on_first: simplex.part.sum(&simplex.v, |v| v.a) + normal * a.radius(),
        on_second: simplex.part.sum(&simplex.v, |v| v.b) - normal * b.radius(),
        gap,
    };
    // Where the shapes nearly touch, round-off may be all of the direction; the shapes are then less far apart along it.
    let is_near = distance < if is_early { 10.0 * NEAR } else { NEAR } * scale;
    if is_near && distance + vertex(a, b, normal).w.dot(normal) > 1e-7 * scale {
        return Err(Overlap { vertices: simplex.vertices(), near: Some(nearest) });
    }
    *axis = Axis { direction: normal, apart: gap, corners: simplex.corners() };
    Ok((gap <= reach).then_some(nearest))
}

/// The nearest points of two shapes that overlap, of the vertices of a simplex that contains the origin. What a search from known corners
/// has found is not taken on trust: they may make a flat simplex by now, and it begins again without them.
fn overlapping(
    a: &impl Convex,
    b: &impl Convex,
    vertices: Vec<Vertex>,
    reach: f64,
    axis: &mut Axis,
) -> Option<Nearest> {
    if std::mem::take(&mut axis.corners) != Corners::default() {
        return nearest(a, b, reach, axis);
    }
    let nearest = expand(a, b, vertices, a.radius() + b.radius());
    *axis = Axis { direction: nearest.normal, apart: nearest.gap, corners: Corners::default() };
    Some(nearest)
}

/// A face of the expanding polytope.
#[derive(Clone, Copy)]
struct Face {
    v: [usize; 3],
    normal: DVec3,
    distance: f64,
}

/// The minimum translation that separates two overlapping shapes.
fn expand(a: &impl Convex, b: &impl Convex, mut points: Vec<Vertex>, round: f64) -> Nearest {
    const ROUNDS: usize = 96;
    /// Height above a face, over the scale, from which on a point is beyond it, in order of preference.
    const ABOVE: [f64; 4] = [1e-14, 1e-10, -1e-10, 1e-7];
    /// The most faces: a polytope that round-off has torn would grow without end.
    const MOST: usize = 400;
    extend_to_tetrahedron(a, b, &mut points);
    let finish = |normal: DVec3, distance: f64, pa: DVec3, pb: DVec3| Nearest {
        normal,
        on_first: pa + normal * a.radius(),
        on_second: pb - normal * b.radius(),
        gap: -distance - round,
    };
    if points.len() < 4 {
        // A flat difference (two segments, say): out along the line between the centres, or up.
        let away = (b.centre() - a.centre()).try_normalize().unwrap_or(DVec3::Z);
        return finish(away, 0.0, points[0].a, points[0].b);
    }
    let face = |points: &[Vertex], v: [usize; 3]| {
        let [p, q, r] = v.map(|i| points[i].w);
        let normal = (q - p).cross(r - p).normalize_or_zero();
        Face { v, normal, distance: normal.dot(p) }
    };
    let mut faces: Vec<Face> = Vec::with_capacity(64);
    for [i, j, k, other] in [[0, 1, 2, 3], [0, 3, 1, 2], [0, 2, 3, 1], [1, 3, 2, 0]] {
        let mut f = face(&points, [i, j, k]);
        if (points[other].w - points[i].w).dot(f.normal) > 0.0 {
            f = face(&points, [i, k, j]);
        }
        faces.push(f);
    }
    let mut best = faces[0];
    // The face along whose normal the shapes overlap least, which bounds the depth whatever round-off has made of the polytope.
    let mut least = f64::INFINITY;
    for _ in 0..ROUNDS {
        let Some(nearest) =
            faces.iter().filter(|f| f.normal != DVec3::ZERO).min_by(|p, q| p.distance.total_cmp(&q.distance))
        else {
            break;
        };
        let nearest = *nearest;
        let next = vertex(a, b, nearest.normal);
        let far = next.w.dot(nearest.normal);
        let scale = next.a.distance(a.centre()) + next.b.distance(b.centre()) + round;
        if far <= least + 1e-9 * scale {
            (least, best) = (far.min(least), nearest);
        }
        if far - nearest.distance <= 1e-9 * scale || points.iter().any(|p| p.w == next.w) {
            break;
        }
        let height = |f: &Face| (next.w - points[f.v[0]].w).dot(f.normal);
        let of = |above: f64| (above * scale, rim(&faces, |f| height(f) > above * scale));
        let whole = ABOVE.iter().map(|above| of(*above)).find(|(_, rim)| is_path(rim));
        let (above, rim) = whole.unwrap_or_else(|| of(ABOVE[0]));
        if rim.len() < 3 || faces.len() + rim.len() > MOST {
            break;
        }
        faces.retain(|f| height(f) <= above);
        points.push(next);
        let last = points.len() - 1;
        faces.extend(rim.iter().map(|[i, j]| face(&points, [*i, *j, last])));
    }
    let on = best.normal * best.distance;
    let (u, v, w) = nearest_in_triangle(on, best.v.map(|i| points[i].w));
    let sum = |part: &dyn Fn(&Vertex) -> DVec3| {
        part(&points[best.v[0]]) * u + part(&points[best.v[1]]) * v + part(&points[best.v[2]]) * w
    };
    // The difference is A − B: moving B along the normal by the distance separates them.
    finish(best.normal, best.distance, sum(&|p| p.a), sum(&|p| p.b))
}

/// The rim of the faces that are beyond it, as edges.
fn rim(faces: &[Face], is_beyond: impl Fn(&Face) -> bool) -> Vec<[usize; 2]> {
    let around = |f: &Face| [[f.v[0], f.v[1]], [f.v[1], f.v[2]], [f.v[2], f.v[0]]];
    let edges: Vec<[usize; 2]> = faces.iter().filter(|f| is_beyond(f)).flat_map(around).collect();
    edges.iter().copied().filter(|[i, j]| !edges.contains(&[*j, *i])).collect()
}

/// Whether a rim is one closed path. Round-off on flat parts may tear it, and the polytope with it.
fn is_path(rim: &[[usize; 2]]) -> bool {
    let once = |k: usize| rim.iter().all(|e| rim.iter().filter(|other| other[k] == e[k]).count() == 1);
    rim.len() >= 3 && once(0) && once(1)
}

/// Extend a simplex that contains the origin to a tetrahedron.
fn extend_to_tetrahedron(a: &impl Convex, b: &impl Convex, points: &mut Vec<Vertex>) {
    let tries = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let volume = |p: &[Vertex], w: DVec3| match p.len() {
        0 => 1.0,
        1 => (w - p[0].w).length(),
        2 => (p[1].w - p[0].w).normalize_or_zero().cross(w - p[0].w).length(),
        _ => (p[1].w - p[0].w).cross(p[2].w - p[0].w).normalize_or_zero().dot(w - p[0].w).abs(),
    };
    let size = a.support(DVec3::X).0.distance(a.centre()) + b.support(DVec3::X).0.distance(b.centre()) + 1e-300;
    while points.len() < 4 {
        let mut directions: Vec<DVec3> = tries.to_vec();
        if points.len() == 3 {
            let n = (points[1].w - points[0].w).cross(points[2].w - points[0].w).normalize_or_zero();
            directions.splice(0..0, [n, -n]);
        }
        let grown = directions
            .into_iter()
            .map(|d| vertex(a, b, d))
            .map(|v| (volume(points, v.w), v))
            .max_by(|p, q| p.0.total_cmp(&q.0));
        match grown {
            Some((far, v)) if far > 1e-10 * size => points.push(v),
            _ => return,
        }
    }
}
