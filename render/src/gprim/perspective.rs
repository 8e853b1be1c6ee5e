//! Patches under a transformation with a perspective, which is no longer affine: they are put where it leads (RISpec 5.2).

use crate::gprim::nurbs::control_points;
use crate::scene::interpolation::bilinear;
use crate::scene::patch::Patch;
use crate::scene::variables::Varying;
use glam::{Mat4, Vec3, Vec4Swizzles};

/// Pieces along a curved patch's edge, each of which is exact at 16 points.
const PIECES: usize = 6;

/// Whether a transformation has a perspective.
pub fn is_projective(m: &Mat4) -> bool {
    let last = m.row(3);
    last.xyz() != Vec3::ZERO || last.w <= 0.0
}

/// A patch where a transformation leads it; none where some of it goes behind the eye.
pub fn projected(patch: &Patch, m: &Mat4) -> Option<Vec<Patch>> {
    if patch.p.iter().any(|p| !(m.row(3).dot(p.extend(1.0)) > 1e-6)) {
        return None;
    }
    let at = |u: f32, v: f32| m.project_point3(patch.at(u, v));
    if patch.flat {
        let corners = Patch::bilinear([at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)]);
        return Some(vec![Patch { p: corners.p, flat: corners.flat, normals: None, moves: vec![], ..patch.clone() }]);
    }
    let range = |k: usize| [k as f32 / PIECES as f32, (k + 1) as f32 / PIECES as f32];
    let piece = |k: usize| {
        part(patch, control_points(at, range(k % PIECES), range(k / PIECES)), [range(k % PIECES), range(k / PIECES)])
    };
    Some((0..PIECES * PIECES).map(piece).collect())
}

/// A part of a patch over ranges of u and v, with other control points.
fn part(whole: &Patch, p: [Vec3; 16], [u, v]: [[f32; 2]; 2]) -> Patch {
    let corners = [[u[0], v[0]], [u[1], v[0]], [u[0], v[1]], [u[1], v[1]]];
    let uv = corners.map(|[s, t]| [0, 1].map(|axis| bilinear(whole.uv.map(|c| c[axis]), s, t)));
    let st = corners.map(|[s, t]| [0, 1].map(|axis| whole.st_at(axis, s, t)));
    let varying = whole.varying.iter().map(|values| {
        let at = |[s, t]: [f32; 2]| (0..values.width()).map(move |c| values.at(c, s, t));
        Varying::new(values.width(), corners.into_iter().flat_map(at).collect())
    });
    let varying = varying.collect();
    Patch { p, uv, st, varying, curved_st: None, normals: None, moves: vec![], ..whole.clone() }
}
