//! Geometric primitives of RIB as patches: polygons, patches of any basis, and their primitive variables.

use crate::scene::Patch;
use glam::{Mat4, Vec3};
use ri::{Class, Fail, Params, RiResult, Values};

/// The Bézier basis, rows by falling powers (RISpec 5.3).
pub const BEZIER: [f32; 16] = [-1.0, 3.0, -3.0, 1.0, 3.0, -6.0, 3.0, 0.0, -3.0, 3.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

/// A convex polygon as bilinear patches: a fan of quadrilaterals and a triangle.
pub fn polygon_patches(corners: &[usize], params: &Params, face: usize) -> Result<Vec<Patch>, Fail> {
    let p = params.iter().find(|p| p.decl.name == "P").ok_or(Fail::new("a polygon needs \"P\""))?.numbers();
    let point = |i: usize| {
        p.get(3 * i..3 * i + 3)
            .map(|c| Vec3::new(c[0], c[1], c[2]))
            .ok_or(Fail::new(format!("vertex {i} is not in \"P\"")))
    };
    let n = corners.len();
    let mut patches = Vec::new();
    let mut k = 1;
    while k + 1 < n {
        let quad = [0, k, k + 1, if k + 2 < n { k + 2 } else { k + 1 }];
        k += 2;
        // Corner order of a patch: (0,0), (1,0), (0,1), (1,1).
        let order = [quad[0], quad[1], quad[3], quad[2]];
        let mut c = [Vec3::ZERO; 4];
        for (c, i) in c.iter_mut().zip(order) {
            *c = point(corners[i])?;
            if !c.is_finite() {
                return Err(Fail::new("a polygon has a vertex that is not a finite number"));
            }
        }
        let mut patch = Patch::bilinear(c);
        // A polygon's parameters are its x and y in object space (RISpec 5.2).
        patch.uv = c.map(|c| [c.x, c.y]);
        patch.st = patch.uv;
        patch_variables(&mut patch, params, order.map(|i| corners[i]), face)?;
        patches.push(patch);
    }
    Ok(patches)
}

/// Give a patch its primitive variables: `vertex` are the indices of its corners in varying values, `face` its uniform index.
pub fn patch_variables(patch: &mut Patch, params: &Params, vertex: [usize; 4], face: usize) -> RiResult {
    for param in params.iter().filter(|p| !matches!(p.decl.name.as_str(), "P" | "Np" | "Pw")) {
        let width = param.decl.width();
        let v = param.numbers();
        let value = |i: usize| {
            v.get(i * width..(i + 1) * width)
                .map(<[f32]>::to_vec)
                .ok_or(Fail::new(format!("`{}` has too few values", param.decl.name)))
        };
        match param.decl.class {
            _ if v.is_empty() => {}
            Class::Constant => patch.uniform.push((param.decl.name.clone(), value(0)?)),
            Class::Uniform => {
                patch.uniform.push((param.decl.name.clone(), value(if v.len() > width { face } else { 0 })?))
            }
            Class::FaceVarying => return Err(Fail::new("facevarying variables are not supported yet")),
            Class::Varying | Class::Vertex => {
                let mut all = Vec::new();
                for i in vertex {
                    all.extend(value(i)?);
                }
                match param.decl.name.as_str() {
                    "s" => (0..4).for_each(|k| patch.st[k][0] = all[k]),
                    "t" => (0..4).for_each(|k| patch.st[k][1] = all[k]),
                    "st" => (0..4).for_each(|k| patch.st[k] = [all[2 * k], all[2 * k + 1]]),
                    name => patch.varying.push((name.into(), all)),
                }
            }
        }
    }
    Ok(())
}

/// Uniform numbers of a quadric's parameter list.
pub fn uniform_numbers(params: Params) -> Result<Vec<(String, Vec<f32>)>, Fail> {
    let mut out = Vec::new();
    for param in params {
        match (&param.values, param.decl.class) {
            (Values::Floats(v), Class::Constant | Class::Uniform) => out.push((param.decl.name, v.clone())),
            (Values::Strings(_), _) => {}
            _ => {
                return Err(Fail::new(format!(
                    "varying variable `{}` on a quadric is not supported yet",
                    param.decl.name
                )));
            }
        }
    }
    Ok(out)
}

/// Control points of a bicubic patch of any basis as Bézier points.
pub fn to_bezier(p: [Vec3; 16], (u, v): &([f32; 16], [f32; 16])) -> [Vec3; 16] {
    // p(t) = T M G with rows of M by falling powers; Bézier points are B⁻¹ M G.
    let matrix = |m: &[f32; 16]| Mat4::from_cols_array(m).transpose();
    let change = |m: &[f32; 16]| matrix(&BEZIER).inverse() * matrix(m);
    let (cu, cv) = (change(u), change(v));
    let apply = |m: &Mat4, g: [Vec3; 4]| [0, 1, 2, 3].map(|i| (0..4).map(|k| g[k] * m.row(i)[k]).sum::<Vec3>());
    let mut out = p;
    for j in 0..4 {
        let row = apply(&cu, [out[4 * j], out[4 * j + 1], out[4 * j + 2], out[4 * j + 3]]);
        out[4 * j..4 * j + 4].copy_from_slice(&row);
    }
    for i in 0..4 {
        let column = apply(&cv, [out[i], out[4 + i], out[8 + i], out[12 + i]]);
        (0..4).for_each(|j| out[4 * j + i] = column[j]);
    }
    out
}
