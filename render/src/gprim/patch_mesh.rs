//! Patch meshes (RISpec 5.3).

use crate::gprim::basis::to_bezier;
use crate::scene::patch::Patch;
use glam::Vec3;
use ri::Fail;

/// A patch of a mesh, with the places of its corners (0,0), (1,0), (0,1), (1,1) in varying values and, if it is bicubic, of its
/// control points in vertex ones.
pub type MeshPatch = (Patch, [usize; 4], Option<[usize; 16]>);

/// A patch mesh (RISpec 5.3).
pub fn patch_mesh(
    bicubic: bool,
    points: &[Vec3],
    [nu, nv]: [usize; 2],
    periodic: [bool; 2],
    bases: &([f32; 16], [f32; 16]),
    steps: [usize; 2],
) -> Result<Vec<MeshPatch>, Fail> {
    if nu.checked_mul(nv) != Some(points.len()) {
        return Err(Fail::new(format!("a mesh of {nu} × {nv} points has {} in \"P\"", points.len())));
    }
    let step = if bicubic { steps } else { [1, 1] };
    let count = |n: usize, axis: usize| -> Result<usize, Fail> {
        let wrong = || {
            Fail::new(format!(
                "{n} points along an axis make no {} patches",
                if bicubic { "bicubic" } else { "bilinear" }
            ))
        };
        let room =
            if periodic[axis] { n } else { n.checked_sub(if bicubic { 4 } else { 2 }).ok_or_else(wrong)? + step[axis] };
        if step[axis] == 0 || room % step[axis] != 0 || room == 0 {
            return Err(wrong());
        }
        Ok(room / step[axis])
    };
    let (pu, pv) = (count(nu, 0)?, count(nv, 1)?);
    let place = |i: usize, j: usize| (j % nv) * nu + i % nu;
    let point = |i: usize, j: usize| points[place(i, j)];
    let at = |k: usize, n: usize| k as f32 / n as f32;
    // Corners of patches: one more than patches along an open axis.
    let (cu, cv) = (if periodic[0] { pu } else { pu + 1 }, if periodic[1] { pv } else { pv + 1 });
    let mut patches = Vec::new();
    for j in 0..pv {
        for i in 0..pu {
            let (u, v) = ([at(i, pu), at(i + 1, pu)], [at(j, pv), at(j + 1, pv)]);
            let controls: Option<[usize; 16]> =
                bicubic.then(|| std::array::from_fn(|k| place(i * step[0] + k % 4, j * step[1] + k / 4)));
            let patch = if let Some(controls) = controls {
                Patch::smooth(to_bezier(controls.map(|k| points[k]), bases), u, v)
            } else {
                let mut patch = Patch::bilinear([point(i, j), point(i + 1, j), point(i, j + 1), point(i + 1, j + 1)]);
                let corners = [[u[0], v[0]], [u[1], v[0]], [u[0], v[1]], [u[1], v[1]]];
                (patch.uv, patch.st) = (corners, corners);
                patch
            };
            let corner = |a: usize, b: usize| (b % cv) * cu + a % cu;
            let corners = [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)];
            patches.push((patch, corners, controls));
        }
    }
    Ok(patches)
}
