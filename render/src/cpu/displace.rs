//! Displacement of a grid, by its item's displacement shader.

use crate::cpu::globals::{fill_geometric_normal, fill_incident, fill_velocity, spread};
use crate::cpu::rays::Rays;
use crate::cpu::view::View;
use crate::gprim::grid::{Grid, Subject};
use crate::scene::world::Scene;
use glam::Vec3;
use sl::Global;
use sl::ir::Ask;
use sl::machine::{Machine, Points};

/// How far beyond a right angle to the way from the eye a normal is turned, in parts of what it was off.
const LEAST_TURN: f32 = 1e-3;

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

/// Turn normals to the eye, as far as it takes, where they face away from it beside micropolygons that do not: at a silhouette, which runs
/// between points, and where a shader turned the normal alone. What is seen there is its outside, and a shader that turns normals to
/// the eye would light it from within.
pub fn face_eye(subject: &Subject<'_>, grid: &mut Grid) {
    let Subject { view, camera, .. } = *subject;
    if view.attributes.displacement.is_none() {
        return;
    }
    let points = &mut grid.points;
    let (n, nu, nv, side) = (points.n(), points.nu, points.nv, points.orientation);
    let of = |v: &[f32], k: usize| Vec3::new(v[k], v[n + k], v[2 * n + k]);
    let whole = |global: Global| points.get(global).filter(|v| v.len() == 3 * n);
    let both = [Global::N, Global::Ng];
    let (Some(p), normals) = (whole(Global::P), both.map(whole)) else { return };
    let mut turned = vec![];
    for k in 0..n {
        let place = of(p, k);
        let way = camera.incident(place);
        let away = normals.map(|normals| normals.map_or(0.0, |normals| of(normals, k).dot(way)));
        if !(away[0] > 0.0 || away[1] > 0.0) {
            continue;
        }
        let (i, j) = (k % nu, k / nu);
        let faces = |a: usize, b: usize, c: usize| {
            let facet = (of(p, b) - of(p, a)).cross(of(p, c) - of(p, a)) * side;
            facet.dot(way) < -1e-6 * facet.length() * way.length()
        };
        let around = [(i.wrapping_sub(1), j.wrapping_sub(1)), (i, j.wrapping_sub(1)), (i.wrapping_sub(1), j), (i, j)];
        let is_seen = around.into_iter().filter(|(i, j)| *i < nu - 1 && *j < nv - 1).any(|(i, j)| {
            let first = j * nu + i;
            faces(first, first + 1, first + nu + 1) || faces(first, first + nu + 1, first + nu)
        });
        for ((global, normals), away) in
            both.into_iter().zip(normals).zip(away).filter(|(_, away)| is_seen && *away > 0.0)
        {
            let normal = normals.map_or(Vec3::ZERO, |normals| of(normals, k));
            let bent = normal - way * (away * (1.0 + LEAST_TURN) / way.length_squared());
            turned.push((global, k, bent.normalize_or_zero() * normal.length()));
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
