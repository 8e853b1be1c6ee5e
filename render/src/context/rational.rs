//! Patches and meshes of homogeneous points of unequal weights: each patch as a NURBS patch of one span (RISpec 5.3).

use crate::context::state::Context;
use crate::gprim::basis::to_bezier;
use crate::gprim::patch_mesh::patch_mesh;
use crate::gprim::variables::{Counts, positions, too_few, weighted};
use crate::scene::variables::VariableNames;
use ri::{Class, Fail, Knots, Param, Params, RiResult, Type, Values};

/// Where a patch of a mesh has its values.
struct Part {
    face: usize,
    corners: [usize; 4],
    /// None if it is bilinear: its control points are its corners.
    controls: Option<[usize; 16]>,
}

impl Part {
    /// Its part of a variable of the mesh, vertex ones as they are at the control points of Bézier curves.
    fn of(&self, param: &Param, bases: &([f32; 16], [f32; 16])) -> Result<Param, Fail> {
        let (width, v) = (param.decl.width(), param.numbers());
        let pick = |places: &[usize]| -> Result<Vec<f32>, Fail> {
            let value = |i: &usize| v.get(i * width..(i + 1) * width).ok_or_else(|| too_few(param));
            Ok(places.iter().map(value).collect::<Result<Vec<_>, Fail>>()?.concat())
        };
        let mut decl = param.decl.clone();
        let values = match decl.class {
            _ if v.is_empty() => return Ok(param.clone()),
            Class::Constant => return Ok(param.clone()),
            Class::Uniform => pick(&[if v.len() > width { self.face } else { 0 }])?,
            Class::Varying => pick(&self.corners)?,
            Class::FaceVarying => {
                decl.class = Class::Varying;
                pick(&[0, 1, 2, 3].map(|k| 4 * self.face + k))?
            }
            Class::Vertex => match &self.controls {
                Some(controls) => bezier_net(&pick(controls)?, width, bases),
                None => pick(&self.corners)?,
            },
        };
        Ok(Param { decl, values: Values::Floats(values) })
    }
}

/// The values of `width` numbers at the 16 control points of a patch, as they are at those of Bézier curves.
fn bezier_net(values: &[f32], width: usize, bases: &([f32; 16], [f32; 16])) -> Vec<f32> {
    let mut all = vec![0.0; 16 * width];
    for c in 0..width {
        let net: [f32; 16] = std::array::from_fn(|k| values[k * width + c]);
        to_bezier(net, bases).iter().enumerate().for_each(|(k, x)| all[k * width + c] = *x);
    }
    all
}

impl Context {
    /// A mesh of points "Pw".
    pub(super) fn draw_rational_mesh(
        &mut self,
        bicubic: bool,
        sizes: [usize; 2],
        wraps: [bool; 2],
        params: Params,
    ) -> RiResult {
        let bases = self.geometry.bases;
        let points = positions(&weighted(params.clone())?)?;
        let mesh = patch_mesh(bicubic, &points, sizes, wraps, &bases, self.geometry.steps)?;
        let n_corners = mesh.iter().flat_map(|(_, corners, _)| corners).max().map_or(0, |k| k + 1);
        let (faces, vertex) = (mesh.len(), points.len());
        let counts = Counts { uniform: faces, varying: n_corners, vertex, facevarying: 4 * faces };
        self.say_surplus(&params, counts);
        let (mut all, mut names) = (vec![], VariableNames::default());
        for (face, (patch, corners, controls)) in mesh.into_iter().enumerate() {
            let part = Part { face, corners, controls };
            // Parameters go over the mesh, and so do texture coordinates unless they are given.
            let [from, until] = [patch.uv[0], patch.uv[3]];
            let coordinate = |name: &str, k: usize| {
                let ends = [from[k], until[k]];
                let values = [0, 1, 2, 3].map(|corner| ends[corner >> k & 1]);
                Param::floats(name, Class::Varying, Type::Float, values)
            };
            let mut own = vec![coordinate("s", 0), coordinate("t", 1)];
            for param in &params {
                own.push(part.of(param, &bases)?);
            }
            let knots = |k: usize| one_span(bicubic, [from[k], until[k]]);
            let (patches, own) = self.nu_patches(knots(0), knots(1), own)?;
            all.extend(patches);
            names = own;
        }
        self.add_patches(all, names)
    }

    /// A patch of homogeneous points of unequal weights: as a NURBS patch of one span.
    pub(super) fn draw_rational_patch(&mut self, bicubic: bool, params: Params) -> RiResult {
        let bases = self.geometry.bases;
        let n = if bicubic { 16 } else { 4 };
        let as_bezier = |param: Param| -> Result<Param, Fail> {
            let (width, v) = (param.decl.width(), param.numbers());
            if param.decl.class != Class::Vertex {
                return Ok(param);
            }
            if v.len() != n * width {
                return Err(too_few(&param));
            }
            if !bicubic {
                return Ok(param);
            }
            let values = Values::Floats(bezier_net(v, width, &bases));
            Ok(Param { decl: param.decl, values })
        };
        let params = params.into_iter().map(as_bezier).collect::<Result<Params, Fail>>()?;
        if !bicubic {
            positions(&weighted(params.clone())?)?;
        }
        let knots = || one_span(bicubic, [0.0, 1.0]);
        self.draw_nu_patch(knots(), knots(), params)
    }
}

/// The knots of one span, cubic or linear, over a range of the parameter.
fn one_span(cubic: bool, range: [f32; 2]) -> Knots {
    let order = if cubic { 4 } else { 2 };
    let knots = range.iter().flat_map(|end| vec![*end; order as usize]).collect();
    Knots { n: order, order, knots, range }
}
