//! Geometric primitives of RIB as patches: polygons, patches of any basis, and their primitive variables.

use crate::scene::patch::Patch;
use glam::{Mat4, Vec3};
use ri::{Class, Fail, Params, RiResult, Values};

/// The Bézier basis, rows by falling powers (RISpec 5.3).
pub const BEZIER: [f32; 16] = [-1.0, 3.0, -3.0, 1.0, 3.0, -6.0, 3.0, 0.0, -3.0, 3.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

/// The points of "P".
pub fn positions(params: &Params) -> Result<Vec<Vec3>, Fail> {
    let p = params.iter().find(|p| p.decl.name == "P").ok_or(Fail::new("the primitive needs \"P\""))?;
    let points: Vec<Vec3> = p.numbers().chunks_exact(3).map(Vec3::from_slice).collect();
    match points.iter().position(|p| !p.is_finite()) {
        Some(i) => Err(Fail::new(format!("vertex {i} of \"P\" is not a finite number"))),
        None => Ok(points),
    }
}

/// A polygon as patches: its outline, then its holes, as indices into "P". `face` is its uniform index, `first` that of its first
/// corner in facevarying values. Four corners that make a convex face become one bilinear patch, others triangles.
pub fn polygon_patches(loops: &[Vec<usize>], params: &Params, face: usize, first: usize) -> Result<Vec<Patch>, Fail> {
    let p = params.iter().find(|p| p.decl.name == "P").ok_or(Fail::new("a polygon needs \"P\""))?.numbers();
    let all: Vec<usize> = loops.concat();
    let mut points = Vec::with_capacity(all.len());
    for i in &all {
        let c = p.get(3 * i..3 * i + 3).ok_or(Fail::new(format!("vertex {i} is not in \"P\"")))?;
        points.push([c[0], c[1], c[2]]);
    }
    if points.as_flattened().iter().any(|x| !x.is_finite()) {
        return Err(Fail::new("a polygon has a vertex that is not a finite number"));
    }
    let n_outer = loops.first().map_or(0, Vec::len);
    let at = |i: usize| Vec3::from(points[i]);
    // Corners of a patch: (0,0), (1,0), (0,1), (1,1); a triangle has its last corner twice.
    let mut quads: Vec<[usize; 4]> = Vec::new();
    let normal = |a: usize, b: usize, c: usize| (at(b) - at(a)).cross(at(c) - at(a));
    let convex = |n: usize| {
        let first = normal(0, 1, 2);
        (0..n).all(|k| {
            let corner = (at((k + 1) % n) - at(k)).cross(at((k + 2) % n) - at((k + 1) % n));
            corner.dot(first) > 0.0
        })
    };
    if loops.len() == 1 && n_outer == 4 && convex(4) {
        quads.push([0, 1, 3, 2]);
    } else if n_outer == 3 && loops.len() == 1 {
        quads.push([0, 1, 2, 2]);
    } else {
        let mut flat = Vec::new();
        let mut triangles: Vec<usize> = Vec::new();
        if earcut::utils3d::project3d_to_2d(&points, n_outer, &mut flat) {
            let holes: Vec<usize> = loops[..loops.len() - 1]
                .iter()
                .scan(0, |sum, l| {
                    *sum += l.len();
                    Some(*sum)
                })
                .collect();
            earcut::Earcut::new().earcut(flat.iter().copied(), &holes, &mut triangles);
        }
        // The plane that they are cut in may be seen from behind.
        let whole: Vec3 = (0..n_outer).map(|k| at(k).cross(at((k + 1) % n_outer))).sum();
        for t in triangles.chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]];
            if normal(a, b, c).dot(whole) < 0.0 { quads.push([a, c, b, b]) } else { quads.push([a, b, c, c]) }
        }
    }
    let mut patches = Vec::new();
    for quad in quads {
        let c = quad.map(at);
        let mut patch = Patch::bilinear(c);
        // A polygon's parameters are its x and y in object space (RISpec 5.2).
        patch.uv = c.map(|c| [c.x, c.y]);
        patch.st = patch.uv;
        patch_variables(&mut patch, params, quad.map(|k| all[k]), quad.map(|k| first + k), face)?;
        patches.push(patch);
    }
    Ok(patches)
}

/// Give a patch its primitive variables: `vertex` are the indices of its corners in varying values, `corner` in facevarying ones,
/// `face` its uniform index.
pub fn patch_variables(
    patch: &mut Patch,
    params: &Params,
    vertex: [usize; 4],
    corner: [usize; 4],
    face: usize,
) -> RiResult {
    for param in params.iter().filter(|p| !matches!(p.decl.name.as_str(), "P" | "Np" | "Pw" | "Pz")) {
        let width = param.decl.width();
        let v = param.numbers();
        let value = |i: usize| {
            v.get(i * width..(i + 1) * width).ok_or(Fail::new(format!("`{}` has too few values", param.decl.name)))
        };
        let corners = match param.decl.class {
            _ if v.is_empty() => continue,
            Class::Constant => {
                patch.uniform.push((param.decl.name.clone(), value(0)?.to_vec()));
                continue;
            }
            Class::Uniform => {
                let own = value(if v.len() > width { face } else { 0 })?;
                patch.uniform.push((param.decl.name.clone(), own.to_vec()));
                continue;
            }
            Class::FaceVarying => corner,
            Class::Varying | Class::Vertex => vertex,
        };
        let mut all = Vec::with_capacity(4 * width);
        for i in corners {
            all.extend_from_slice(value(i)?);
        }
        set_varying(patch, &param.decl.name, all);
    }
    Ok(())
}

/// Set values at the corners of a patch.
pub fn set_varying(patch: &mut Patch, name: &str, all: Vec<f32>) {
    match name {
        "s" => (0..4).for_each(|k| patch.st[k][0] = all[k]),
        "t" => (0..4).for_each(|k| patch.st[k][1] = all[k]),
        "st" => (0..4).for_each(|k| patch.st[k] = [all[2 * k], all[2 * k + 1]]),
        name => patch.varying.push((name.into(), all)),
    }
}

/// Give the patches of one primitive with four corners its variables: varying ones are bilinear over all of it.
pub fn dress(patches: &mut [Patch], params: &Params) -> RiResult {
    let (min, max) =
        patches.iter().flat_map(|p| p.uv).fold(([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]), |(a, b), uv| {
            ([a[0].min(uv[0]), a[1].min(uv[1])], [b[0].max(uv[0]), b[1].max(uv[1])])
        });
    let whole: Params = params.iter().filter(|p| p.decl.class.is_whole()).cloned().collect();
    for patch in patches.iter_mut() {
        patch_variables(patch, &whole, [0; 4], [0; 4], 0)?;
    }
    let four = params.iter().filter(|p| !p.decl.class.is_whole() && !matches!(p.decl.name.as_str(), "P" | "Pw"));
    for param in four {
        let (width, v) = (param.decl.width(), param.numbers());
        if v.len() != 4 * width {
            // Values at control points of a NURBS patch and the like: those of its corners are not known here.
            let message = format!("`{}` has {} values, expected 4, one a corner", param.decl.name, v.len() / width);
            return Err(Fail::new(message));
        }
        for patch in patches.iter_mut() {
            let mut all = Vec::with_capacity(4 * width);
            for uv in patch.uv {
                let unit = |k: usize| if max[k] > min[k] { (uv[k] - min[k]) / (max[k] - min[k]) } else { 0.0 };
                let (s, t) = (unit(0), unit(1));
                for c in 0..width {
                    let at = |k: usize| v[k * width + c];
                    all.push((at(0) * (1.0 - s) + at(1) * s) * (1.0 - t) + (at(2) * (1.0 - s) + at(3) * s) * t);
                }
            }
            set_varying(patch, &param.decl.name, all);
        }
    }
    Ok(())
}

/// Values at the corners of the faces of a mesh, all variables in a row: names and widths, the values, numbers a corner.
pub type CornerColumns = (Vec<(String, usize)>, Vec<f32>, usize);

/// Collect the variables of a mesh that vary over its faces.
pub fn corner_columns(params: &Params, vertices: &[i32], corners: usize) -> Result<CornerColumns, Fail> {
    let varying: Vec<_> =
        params.iter().filter(|p| !p.decl.class.is_whole() && p.decl.name != "P" && !p.numbers().is_empty()).collect();
    let width: usize = varying.iter().map(|p| p.decl.width()).sum();
    let mut values = Vec::with_capacity(width * corners);
    for k in 0..corners {
        for param in &varying {
            let w = param.decl.width();
            let i = match param.decl.class {
                Class::FaceVarying => k,
                _ => vertices.get(k).map_or(0, |v| (*v).max(0) as usize),
            };
            let own = param.numbers().get(i * w..(i + 1) * w);
            values.extend(own.ok_or(Fail::new(format!("`{}` has too few values", param.decl.name)))?);
        }
    }
    Ok((varying.iter().map(|p| (p.decl.name.clone(), p.decl.width())).collect(), values, width))
}

/// Give a patch such values, `width` numbers at each of its four corners.
pub fn corner_variables(patch: &mut Patch, columns: &[(String, usize)], values: &[f32], width: usize) {
    let mut first = 0;
    for (name, w) in columns {
        let all = (0..4).flat_map(|k| values[k * width + first..k * width + first + w].iter().copied()).collect();
        set_varying(patch, name, all);
        first += w;
    }
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
