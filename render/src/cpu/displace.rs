//! Displacement of a grid, by its item's displacement shader.

use crate::cpu::globals::{fill_geometric_normal, fill_incident, fill_velocity, spread};
use crate::cpu::rays::Rays;
use crate::cpu::view::View;
use crate::gprim::grid::{Grid, Subject};
use crate::scene::shape::Shape;
use crate::scene::world::Scene;
use glam::Vec3;
use sl::Global;
use sl::ir::Ask;
use sl::machine::{Machine, Points};

/// How far beyond a right angle to the way from the eye a normal is turned, in parts of what it was off.
const LEAST_TURN: f32 = 1e-3;

/// The sine to the way from the eye from which on a micropolygon is known to show one side of it.
const LEAST_SINE: f32 = 1e-6;

/// The cosine of a micropolygon's normal to that of its first point from which on it is known which side is which.
const LEAST_COSINE: f32 = 0.1;

/// Displace a grid, drop its apron and put its edges where those of its neighbours are; `rays` have what its shader meets.
pub fn displace(scene: &Scene, rays: &Rays<'_>, subject: &Subject<'_>, grid: &mut Grid, machine: &mut Machine) {
    let Subject { item, view, camera, .. } = *subject;
    let points = &mut grid.points;
    let moment = subject.instants.get(1).map(|instant| instant.time);
    let deformed = grid.deformed.first().map(Vec::as_slice);
    if let Some(displacement) = &view.attributes.displacement {
        let mut seen = View::new(scene, rays, item, view, [0.0; 2]);
        seen.shader_to_world = view.attributes.displacement_space;
        fill_incident(points, camera);
        fill_velocity(points, view, moment, deformed, scene.shutter);
        if subject.needs_geometric_normal() {
            fill_geometric_normal(points);
        }
        let before = &mut grid.undisplaced;
        before.clear();
        before.extend_from_slice(points.get(Global::P).unwrap_or(&[]));
        machine.run_with(displacement, &view.attached.displacement, points, &seen);
        machine.tell(Ask::Displacement, displacement, points);
        spread(points);
        let after = points.get(Global::P).unwrap_or(&[]);
        let n = points.n();
        let moved =
            |k: usize| (0..3).map(|c| (after[c * n + k] as f64 - before[c * n + k] as f64).powi(2)).sum::<f64>();
        let farthest = (0..n).map(moved).fold(0.0, f64::max).sqrt() as f32;
        let is_finite = after.iter().all(|x| x.is_finite());
        if farthest > 0.0 && subject.needs_geometric_normal() {
            geometric_normals(points);
        }
        if !is_finite {
            let (name, file) = (&displacement.program.name, &displacement.program.file);
            scene.loses_points(format!("{file}: displacement `{name}`"), item.source);
        }
        if farthest > grid.reach * 1.001 && farthest.is_finite() {
            let scale = view.object_to_world.x_axis.truncate().length();
            scene.needs_bound(&displacement.program.name, farthest / scale.max(f32::MIN_POSITIVE), item.source);
        }
    }
    if grid.apron {
        strip_apron(points, view.attached.n_uniform);
    }
    if grid.keep != [u32::MAX; 4] {
        let (nu, nv) = (points.nu, points.nv);
        let p = points.get_mut(Global::P).into_iter();
        p.chain(&mut grid.deformed).for_each(|p| snap_edges(p, nu, nv, grid.keep));
    }
    fill_velocity(points, view, moment, grid.deformed.first().map(Vec::as_slice), scene.shutter);
}

/// Ng of points that were displaced: of the surface that they make, where they make one.
fn geometric_normals(points: &mut Points) {
    let (n, nu, nv, side) = (points.n(), points.nu, points.nv, points.orientation);
    let mut geometric = points.get_mut(Global::Ng).map(std::mem::take).unwrap_or_default();
    if let Some(p) = points.get(Global::P).filter(|p| p.len() == 3 * n && geometric.len() == 3 * n) {
        let at = |k: usize| Vec3::new(p[k], p[n + k], p[2 * n + k]);
        for j in 0..nv {
            let rows = [j.saturating_sub(1), (j + 1).min(nv - 1)].map(|j| j * nu);
            for i in 0..nu {
                let (left, right, k) = (i.saturating_sub(1), (i + 1).min(nu - 1), j * nu + i);
                let (along, across) = (at(j * nu + right) - at(j * nu + left), at(rows[1] + i) - at(rows[0] + i));
                let normal = along.cross(across).normalize_or_zero() * side;
                if normal != Vec3::ZERO {
                    (geometric[k], geometric[n + k], geometric[2 * n + k]) = (normal.x, normal.y, normal.z);
                }
            }
        }
    }
    points.set(Global::Ng, geometric);
}

/// Turn normals to the side that is seen, as far as it takes, beside a silhouette, which runs between points: what is seen there of an opaque
/// body is its outside, and a shader that turns normals to the eye would light it from within. Where there is displacement, normals are turned to the eye where
/// they face away from it beside micropolygons that do not, wherever a shader turned the normal alone; else those of a micropolygon's first
/// point, by which it is shaded, to the side of the surface that the eye sees of that micropolygon.
pub fn face_eye(subject: &Subject<'_>, grid: &mut Grid) {
    let is_curved = || match (subject.view.shape, grid.origin) {
        (Shape::Patches(patches, _), Some(part)) => patches.get(part.patch as usize).is_some_and(|patch| !patch.flat),
        _ => false,
    };
    if subject.view.attributes.displacement.is_some() {
        turn_normals(subject, &mut grid.points, |facets, normal, way| {
            let is_before = |facet: Vec3| facet.dot(way) < -LEAST_SINE * facet.length() * way.length();
            if normal.dot(way) > 0.0 && facets.around().any(is_before) { -1.0 } else { 0.0 }
        });
    } else if is_curved() && has_both_sides(subject, &grid.points) {
        turn_normals(subject, &mut grid.points, |facets, normal, way| {
            let facet = facets.own();
            let (along, seen) = (facet.dot(normal), facet.dot(way));
            // Of what is folded nobody knows which side is which.
            let is_known = along.abs() > LEAST_COSINE * facet.length() * normal.length()
                && seen.abs() > LEAST_SINE * facet.length() * way.length();
            if is_known { seen.signum() * along.signum() } else { 0.0 }
        });
    }
}

/// Whether normals of a grid face the eye and others face away.
fn has_both_sides(subject: &Subject<'_>, points: &Points) -> bool {
    let n = points.n();
    let whole = |global: Global| points.get(global).filter(|v| v.len() == 3 * n);
    let (Some(p), Some(normals)) = (whole(Global::P), whole(Global::N)) else { return false };
    let of = |v: &[f32], k: usize| Vec3::new(v[k], v[n + k], v[2 * n + k]);
    let mut away = (0..n).map(|k| of(normals, k).dot(subject.camera.incident(of(p, k))) > 0.0);
    let first = away.next();
    away.any(|other| Some(other) != first)
}

/// The normals of the triangles of micropolygons about a point of a grid, by their areas.
struct Facets<'a> {
    points: &'a Points,
    p: &'a [f32],
    k: usize,
}

impl Facets<'_> {
    fn at(&self, k: usize) -> Vec3 {
        let n = self.points.n();
        Vec3::new(self.p[k], self.p[n + k], self.p[2 * n + k])
    }

    /// Of both triangles of the micropolygon from the point on, or of the last before it.
    fn own(&self) -> Vec3 {
        let (nu, nv) = (self.points.nu, self.points.nv);
        let first = (self.k / nu).min(nv - 2) * nu + (self.k % nu).min(nu - 2);
        let [a, b, c, d] = [first, first + 1, first + nu + 1, first + nu].map(|k| self.at(k));
        (c - a).cross(d - b)
    }

    /// Of each triangle of the micropolygons that have the point, on the side that the grid's normals face.
    fn around(&self) -> impl Iterator<Item = Vec3> {
        let (nu, nv, side) = (self.points.nu, self.points.nv, self.points.orientation);
        let (i, j) = (self.k % nu, self.k / nu);
        let around = [(i.wrapping_sub(1), j.wrapping_sub(1)), (i, j.wrapping_sub(1)), (i.wrapping_sub(1), j), (i, j)];
        around.into_iter().filter(move |(i, j)| *i < nu - 1 && *j < nv - 1).flat_map(move |(i, j)| {
            let first = j * nu + i;
            let of = |b: usize, c: usize| (self.at(b) - self.at(first)).cross(self.at(c) - self.at(first)) * side;
            [of(first + 1, first + nu + 1), of(first + nu + 1, first + nu)]
        })
    }
}

/// Turn N and Ng of points, as far as it takes, so that they make a cosine of a sign with the way from the eye: `sign_of` has that by the
/// facets about a point, a normal there and the way; 0 if the normal stays.
fn turn_normals(subject: &Subject<'_>, points: &mut Points, sign_of: impl Fn(&Facets<'_>, Vec3, Vec3) -> f32) {
    let n = points.n();
    let of = |v: &[f32], k: usize| Vec3::new(v[k], v[n + k], v[2 * n + k]);
    let whole = |global: Global| points.get(global).filter(|v| v.len() == 3 * n);
    let Some(p) = whole(Global::P).filter(|_| points.nu > 1 && points.nv > 1) else { return };
    let mut turned = vec![];
    for global in [Global::N, Global::Ng] {
        let Some(normals) = whole(global) else { continue };
        for k in 0..n {
            let (normal, way) = (of(normals, k), subject.camera.incident(of(p, k)));
            let away = normal.dot(way);
            let sign = sign_of(&Facets { points, p, k }, normal, way);
            if away * sign < 0.0 {
                let bent = normal - way * (away * (1.0 + LEAST_TURN) / way.length_squared());
                turned.push((global, k, bent.normalize_or_zero() * normal.length()));
            }
        }
    }
    for (global, k, normal) in turned {
        if let Some(normals) = points.get_mut(global) {
            (normals[k], normals[n + k], normals[2 * n + k]) = (normal.x, normal.y, normal.z);
        }
    }
}

/// Drop the ring of points around the grid; the first `n_uniform` of its primitive variables are the same all over.
fn strip_apron(points: &mut Points, n_uniform: usize) {
    let (nu, nv, n) = (points.nu, points.nv, points.n());
    let inner = |v: &mut Vec<f32>| {
        let mut end = 0;
        for c in 0..v.len() / n {
            for j in 1..nv - 1 {
                let row = c * n + j * nu;
                v.copy_within(row + 1..row + nu - 1, end);
                end += nu - 2;
            }
        }
        v.truncate(end);
    };
    points
        .messages
        .iter_mut()
        .map(|told| &mut told.values)
        .filter(|v| v.len() >= n && v.len() % n == 0)
        .for_each(inner);
    points.globals_mut().filter(|v| v.len() >= n && v.len() % n == 0).for_each(inner);
    (n_uniform..points.variables().len()).for_each(|slot| points.variable_mut(slot).map_or((), inner));
    points.nu -= 2;
    points.nv -= 2;
}

/// Put the points of an edge that its neighbour does not have onto the line between those that it has.
fn snap_edges(p: &mut [f32], nu: usize, nv: usize, keep: [u32; 4]) {
    let n = nu * nv;
    let edges = [(0, 1, nu), ((nv - 1) * nu, 1, nu), (0, nu, nv), (nu - 1, nu, nv)];
    for ((start, stride, count), keep) in edges.into_iter().zip(keep) {
        let kept = |i: usize| keep >> i & 1 == 1;
        for i in (1..count - 1).filter(|i| !kept(*i)) {
            let a = (0..i).rev().find(|k| kept(*k)).unwrap_or(0);
            let b = (i..count).find(|k| kept(*k)).unwrap_or(count - 1);
            let t = (i - a) as f32 / (b - a) as f32;
            for c in 0..3 {
                let at = |k: usize| c * n + start + k * stride;
                p[at(i)] = p[at(a)] * (1.0 - t) + p[at(b)] * t;
            }
        }
    }
}
