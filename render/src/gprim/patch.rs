//! Dicing of bicubic patches: the points of a grid, their normals and variables.

use crate::gprim::grid::{Grid, Subject};
use crate::scene::interpolation::{bernstein, bernstein_slope, bilinear};
use crate::scene::motion::later;
use crate::scene::patch::{Patch, point_of};
use crate::scene::variables::Varying;
use glam::Vec3;
use sl::Global;

/// A piece of a patch, in its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Range of u.
    pub u: [f32; 2],
    /// Range of v.
    pub v: [f32; 2],
    /// Splits that made it.
    pub depth: u32,
}

/// Fill a grid with a piece of a patch: `nu` by `nv` micropolygons along u and v, and the grid's apron if it has one.
pub fn dice(subject: &Subject<'_>, patch: &Patch, piece: Piece, [nu, nv]: [usize; 2], grid: &mut Grid) {
    let view = subject.view;
    let ring = grid.apron as i32;
    // All points are of the whole patch at dyadic parameters, so that grids that share an edge compute the same points.
    let lines = |r: [f32; 2], n: usize| {
        (-ring..=n as i32 + ring).map(move |k| r[0] + (r[1] - r[0]) * k as f32 / n as f32).collect::<Vec<f32>>()
    };
    let (us, vs) = (lines(piece.u, nu), lines(piece.v, nv));
    let normals = glam::Mat3::from_mat4(view.to_world).inverse().transpose();
    let mirrored = view.to_world.determinant() < 0.0;
    let sign = if view.attributes.reversed { -1.0 } else { 1.0 };
    let points = &mut grid.points;
    (points.nu, points.nv) = (us.len(), vs.len());
    points.orientation = if mirrored { -sign } else { sign };
    let n = points.n();
    let mut p = std::mem::take(points.refill(Global::P));
    let mut normal = std::mem::take(points.refill(Global::N));
    p.resize(3 * n, 0.0);
    normal.resize(3 * n, 0.0);
    let along: Vec<([f32; 4], [f32; 4])> = us.iter().map(|u| (bernstein(*u), bernstein_slope(*u))).collect();
    let mix = |c: &[Vec3; 4], w: &[f32; 4]| c[0] * w[0] + c[1] * w[1] + c[2] * w[2] + c[3] * w[3];
    // What is flat has one normal, but for the tips of triangles.
    let even = (patch.flat && patch.normals.is_none()).then(|| normals * patch.normal(0.5, 0.5));
    let even = even.map(|m| m.normalize_or_zero() * sign);
    let mut geometric = std::mem::take(points.refill(Global::Ng));
    let has_own = patch.normals.is_some() && subject.needs_geometric_normal();
    geometric.resize(if has_own { 3 * n } else { 0 }, 0.0);
    for (j, v) in vs.iter().enumerate() {
        // The row as a curve along u, and its slope along v.
        let (bv, dv) = (bernstein(*v), bernstein_slope(*v));
        let column = |i: usize, w: &[f32; 4]| mix(&[0, 4, 8, 12].map(|row| patch.p[row + i]), w);
        let (row, rise) = ([0, 1, 2, 3].map(|i| column(i, &bv)), [0, 1, 2, 3].map(|i| column(i, &dv)));
        for (i, (u, (bu, du))) in us.iter().zip(&along).enumerate() {
            let k = j * us.len() + i;
            let q = view.to_world.transform_point3(mix(&row, bu));
            let turned = |own: Vec3| (normals * own).normalize_or_zero() * sign;
            let own = || patch.normal_of(mix(&row, du), mix(&rise, bu), *u, *v);
            let m = even.unwrap_or_else(|| turned(patch.given_normal(*u, *v).unwrap_or_else(own)));
            if has_own {
                let g = turned(own());
                (geometric[k], geometric[n + k], geometric[2 * n + k]) = (g.x, g.y, g.z);
            }
            (p[k], p[n + k], p[2 * n + k]) = (q.x, q.y, q.z);
            (normal[k], normal[n + k], normal[2 * n + k]) = (m.x, m.y, m.z);
        }
    }
    *points.refill(Global::P) = p;
    *points.refill(Global::N) = normal;
    *points.refill(Global::Ng) = geometric;
    deform(subject, patch, [&us, &vs], ring as usize, &mut grid.deformed);
    if subject.needs_parameters() {
        let points = &mut grid.points;
        for (global, corner, curved) in [
            (Global::U, patch.uv.map(|c| c[0]), None),
            (Global::V, patch.uv.map(|c| c[1]), None),
            (Global::S, patch.st.map(|c| c[0]), patch.curved_st.as_deref().and_then(|st| st[0].as_ref())),
            (Global::T, patch.st.map(|c| c[1]), patch.curved_st.as_deref().and_then(|st| st[1].as_ref())),
        ] {
            let at = |u: f32, v: f32| curved.map_or_else(|| bilinear(corner, u, v), |curved| curved.at(0, u, v));
            let values = vs.iter().flat_map(|v| us.iter().map(move |u| at(*u, *v)));
            points.refill(global).extend(values);
        }
    }
    trim(patch, piece, [nu, nv], &mut grid.trimmed);
    view.fill_variables(&mut grid.points);
    for values in &patch.uniform {
        grid.points.next_variable().extend_from_slice(values);
    }
    patch.varying.iter().for_each(|variable| vary(variable, [&us, &vs], grid.points.next_variable()));
    view.to_current(&mut grid.points);
}

/// Find the micropolygons of a grid that are cut away.
fn trim(patch: &Patch, piece: Piece, [nu, nv]: [usize; 2], trimmed: &mut Vec<bool>) {
    trimmed.clear();
    if let Some(trim) = &patch.trim {
        let inner = |n: usize| (0..n).map(move |k| (k as f32 + 0.5) / n as f32);
        for v in inner(nv) {
            let v = piece.v[0] + (piece.v[1] - piece.v[0]) * v;
            trimmed.extend(inner(nu).map(|u| {
                let u = piece.u[0] + (piece.u[1] - piece.u[0]) * u;
                let at = |k: usize| bilinear(patch.uv.map(|c| c[k]), u, v);
                !trim.keeps(at(0), at(1))
            }));
        }
    }
}

/// Fill the values of a variable at the points of a grid.
fn vary(variable: &Varying, [us, vs]: [&[f32]; 2], out: &mut Vec<f32>) {
    for c in 0..variable.width() {
        out.extend(vs.iter().flat_map(|v| us.iter().map(move |u| variable.at(c, *u, *v))));
    }
}

/// How far the points of the grid, without the apron, are from where they were first, at each later moment.
fn deform(subject: &Subject<'_>, patch: &Patch, [us, vs]: [&[f32]; 2], ring: usize, deformed: &mut Vec<Vec<f32>>) {
    deformed.clear();
    if patch.moves.is_empty() {
        return;
    }
    let (us, vs) = (&us[ring..us.len() - ring], &vs[ring..vs.len() - ring]);
    let n = us.len() * vs.len();
    for instant in &subject.instants[1..] {
        let moved = later(patch.p, &patch.moves, instant.time);
        let mut all = vec![0.0; 3 * n];
        for (k, (v, u)) in vs.iter().flat_map(|v| us.iter().map(move |u| (*v, *u))).enumerate() {
            let off = subject.view.to_world.transform_vector3(point_of(&moved, u, v) - patch.at(u, v));
            (all[k], all[n + k], all[2 * n + k]) = (off.x, off.y, off.z);
        }
        deformed.push(all);
    }
}
