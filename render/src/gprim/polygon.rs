//! Polygons as patches, concave ones and those with holes by triangles.

mod crossing;

use crate::gprim::variables::{Places, patch_variables};
use crate::scene::patch::Patch;
use glam::{DVec2, Vec3};
use ri::{Fail, Params};

/// The most vertices of a polygon that crosses itself: it is cut in a time that grows with their square.
pub const MOST_CROSSED: usize = 1 << 14;

/// How a polygon is cut.
pub struct Cut {
    /// Corners of patches among its vertices.
    pub quads: Vec<[usize; 4]>,
    /// Whether its edges cross.
    pub crosses: bool,
}

/// The vertices of a polygon: those of its outline, then of its holes, as indices into "P".
fn vertices(loops: &[Vec<usize>], params: &Params) -> Result<Vec<[f32; 3]>, Fail> {
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
    Ok(points)
}

/// How a polygon is cut. Four corners that make a convex face become one bilinear patch, others triangles; of more than
/// [`MOST_CROSSED`] whose edges cross nothing is made.
pub fn polygon_cut(loops: &[Vec<usize>], params: &Params) -> Result<Cut, Fail> {
    let points = vertices(loops, params)?;
    let n_outer = loops.first().map_or(0, Vec::len);
    let at = |i: usize| Vec3::from(points[i]);
    // Corners of a patch: (0,0), (1,0), (0,1), (1,1); a triangle has its last corner twice.
    let mut quads: Vec<[usize; 4]> = Vec::new();
    let mut crosses = false;
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
            let firsts: Vec<usize> = loops
                .iter()
                .scan(0, |sum, l| {
                    *sum += l.len();
                    Some(*sum - l.len())
                })
                .collect();
            let plane: Vec<DVec2> = flat.iter().map(|p| DVec2::new(p[0].into(), p[1].into())).collect();
            let outlines: Vec<&[DVec2]> = firsts.iter().zip(loops).map(|(k, own)| &plane[*k..k + own.len()]).collect();
            crosses = crossing::crosses(&outlines);
            if !crosses || points.len() <= MOST_CROSSED {
                earcut::Earcut::new().earcut(flat.iter().copied(), &firsts[1..], &mut triangles);
            }
        }
        // The plane that they are cut in may be seen from behind.
        let whole: Vec3 = (0..n_outer).map(|k| at(k).cross(at((k + 1) % n_outer))).sum();
        for t in triangles.chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]];
            if normal(a, b, c).dot(whole) < 0.0 { quads.push([a, c, b, b]) } else { quads.push([a, b, c, c]) }
        }
    }
    Ok(Cut { quads, crosses })
}

/// Whether a polygon's vertices do not lie in a row.
pub fn turns(loops: &[Vec<usize>], params: &Params) -> bool {
    let Ok(points) = vertices(loops, params) else { return false };
    let at = |i: usize| Vec3::from(points[i % points.len()]);
    let size = (0..points.len()).map(|i| (at(i) - at(0)).length_squared()).fold(0.0, f32::max);
    (0..points.len()).any(|i| (at(i + 1) - at(i)).cross(at(i + 2) - at(i)).length() > 1e-5 * size)
}

/// A polygon as patches, cut so: its outline, then its holes, as indices into "P". `face` is its uniform index, `first` that of its
/// first corner in facevarying values.
pub fn polygon_patches(
    loops: &[Vec<usize>],
    params: &Params,
    [face, first]: [usize; 2],
    quads: &[[usize; 4]],
) -> Result<Vec<Patch>, Fail> {
    let points = vertices(loops, params)?;
    let all: Vec<usize> = loops.concat();
    let mut patches = Vec::new();
    for quad in quads {
        let c = quad.map(|i| Vec3::from(points[i]));
        let mut patch = Patch::bilinear(c);
        // A polygon's parameters are its x and y in object space (RISpec 5.2).
        patch.uv = c.map(|c| [c.x, c.y]);
        patch.st = patch.uv;
        let (varying, corner) = (quad.map(|k| all[k]), quad.map(|k| first + k));
        patch_variables(&mut patch, params, &Places { varying, corner, face, vertex: None })?;
        patches.push(patch);
    }
    Ok(patches)
}
