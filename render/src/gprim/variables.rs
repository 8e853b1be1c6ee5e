//! Primitive variables: read from parameter lists and attached to patches.

use crate::gprim::basis::to_bezier;
use crate::scene::patch::Patch;
use crate::scene::variables::{VariableName, VariableNames, Varying};
use glam::Vec3;
use ri::{Class, Declaration, Fail, Param, Params, RiResult, Type, Values};

/// Points given as "Pw" as "P": homogeneous points by their weight, of which none may be 0 (RISpec 5).
pub fn weighted(mut params: Params) -> Result<Params, Fail> {
    let is_given = |name: &str| params.iter().position(|p| p.decl.name == name);
    let (None, Some(k)) = (is_given("P"), is_given("Pw")) else { return Ok(params) };
    let points = params[k].numbers().chunks_exact(4);
    if let Some(i) = points.clone().position(|p| p[3] == 0.0) {
        return Err(Fail::new(format!("vertex {i} of \"Pw\" has the weight 0")));
    }
    let values: Vec<f32> = points.flat_map(|p| [0, 1, 2].map(|c| p[c] / p[3])).collect();
    params[k] = Param::floats("P", params[k].decl.class, Type::Point, values);
    Ok(params)
}

/// The points of "P".
pub fn positions(params: &Params) -> Result<Vec<Vec3>, Fail> {
    let p = params.iter().find(|p| p.decl.name == "P").ok_or(Fail::new("the primitive needs \"P\""))?;
    let points: Vec<Vec3> = p.numbers().chunks_exact(3).map(Vec3::from_slice).collect();
    match points.iter().position(|p| !p.is_finite()) {
        Some(i) => Err(Fail::new(format!("vertex {i} of \"P\" is not a finite number"))),
        None => Ok(points),
    }
}

/// Whether a variable is a part of the patch itself, and none for shaders to find.
fn is_of_patch(name: &str) -> bool {
    matches!(name, "s" | "t" | "st" | "N")
}

/// Parameters that [`patch_variables`] attaches.
fn attachable<'a>(params: impl IntoIterator<Item = &'a Param>) -> impl Iterator<Item = &'a Param> {
    let has_values = |p: &&Param| !p.numbers().is_empty();
    params.into_iter().filter(|p| !matches!(p.decl.name.as_str(), "P" | "Np" | "Pw" | "Pz")).filter(has_values)
}

/// The names of the variables that [`patch_variables`] attaches.
pub fn names_of<'a>(params: impl IntoIterator<Item = &'a Param>) -> VariableNames {
    let mut names = VariableNames::default();
    for param in attachable(params) {
        if !param.decl.class.is_whole() {
            note_varying(&mut names, &param.decl);
        } else if !is_of_patch(&param.decl.name) {
            names.uniform.push(VariableName::of(&param.decl));
        }
    }
    names
}

/// Add the name of a variable that [`set_varying`] attaches.
pub fn note_varying(names: &mut VariableNames, declared: &Declaration) {
    if !is_of_patch(&declared.name) {
        names.varying.push(VariableName::of(declared));
    }
}

/// Where a patch has its values in parameter lists.
#[derive(Clone, Copy, Default)]
pub struct Places<'a> {
    /// The indices of its corners in varying values.
    pub varying: [usize; 4],
    /// In facevarying ones.
    pub corner: [usize; 4],
    /// Its index in uniform ones.
    pub face: usize,
    /// The indices of its control points in vertex values, and the bases of these along u and v; as the varying ones if not given.
    pub vertex: Option<([usize; 16], &'a ([f32; 16], [f32; 16]))>,
}

/// How many values a primitive takes of each class of variables, but constant.
#[derive(Clone, Copy)]
pub struct Counts {
    pub uniform: usize,
    pub varying: usize,
    pub vertex: usize,
    pub facevarying: usize,
}

impl Counts {
    /// Those of a primitive of one face with four corners.
    pub const FOUR: Counts = Counts { uniform: 1, varying: 4, vertex: 4, facevarying: 4 };

    /// What is said of a parameter that has more.
    pub fn surplus(&self, param: &Param) -> Option<String> {
        let (n, class) = (param.numbers().len() / param.decl.width().max(1), param.decl.class);
        let expected = match class {
            Class::Constant => return None,
            Class::Uniform => self.uniform,
            Class::Varying => self.varying,
            Class::Vertex => self.vertex,
            Class::FaceVarying => self.facevarying,
        };
        let name = &param.decl.name;
        (n > expected && !matches!(name.as_str(), "P" | "Pw" | "Pz")).then(|| {
            format!("`{name}` of class {} has {n} values, expected {expected}: those beyond are not used", class.name())
        })
    }
}

/// What is said of a parameter that does not reach.
pub fn too_few(param: &Param) -> Fail {
    let n = param.numbers().len() / param.decl.width();
    Fail::new(format!("`{}` has too few values: {n} of class {}", param.decl.name, param.decl.class.name()))
}

/// Give a patch its primitive variables.
pub fn patch_variables(patch: &mut Patch, params: &Params, places: &Places<'_>) -> RiResult {
    for param in attachable(params) {
        let width = param.decl.width();
        let v = param.numbers();
        let value = |i: usize| v.get(i * width..(i + 1) * width).ok_or_else(|| too_few(param));
        let corners = match (param.decl.class, &places.vertex) {
            (Class::Constant | Class::Uniform, _) => {
                let is_of_face = param.decl.class == Class::Uniform;
                let own = value(if is_of_face { places.face } else { 0 })?;
                if is_of_patch(&param.decl.name) {
                    set_varying(patch, &param.decl.name, Varying::new(width, own.repeat(4)));
                } else {
                    patch.uniform.push(own.to_vec());
                }
                continue;
            }
            (Class::Vertex, Some((controls, bases))) => {
                let mut all = vec![0.0; 16 * width];
                for c in 0..width {
                    let mut net = [0.0; 16];
                    for (net, i) in net.iter_mut().zip(controls) {
                        *net = value(*i)?[c];
                    }
                    to_bezier(net, bases).iter().enumerate().for_each(|(k, x)| all[k * width + c] = *x);
                }
                set_varying(patch, &param.decl.name, Varying::new(width, all));
                continue;
            }
            (Class::FaceVarying, _) => places.corner,
            (Class::Varying | Class::Vertex, _) => places.varying,
        };
        let mut all = Vec::with_capacity(4 * width);
        for i in corners {
            all.extend_from_slice(value(i)?);
        }
        set_varying(patch, &param.decl.name, Varying::new(width, all));
    }
    face_normal(patch, params, places.face)
}

/// Give a patch without normals that of its face, "Np" (RISpec 5.2).
fn face_normal(patch: &mut Patch, params: &Params, face: usize) -> RiResult {
    let Some(param) = params.iter().find(|p| p.decl.name == "Np" && p.decl.width() == 3) else { return Ok(()) };
    let all = param.numbers();
    let own = all.get(if all.len() > 3 { 3 * face..3 * face + 3 } else { 0..3 }).ok_or_else(|| too_few(param))?;
    patch.normals.get_or_insert_with(|| Box::new(Varying::new(3, own.repeat(4))));
    Ok(())
}

/// Set a variable of a patch; of two normals the first counts, and those that are no triples are dropped.
pub fn set_varying(patch: &mut Patch, name: &str, values: Varying) {
    match name {
        "s" => set_coordinate(patch, 0, values),
        "t" => set_coordinate(patch, 1, values),
        "st" if values.width() == 2 => {
            [0, 1].into_iter().for_each(|axis| set_coordinate(patch, axis, values.component(axis)))
        }
        "N" if values.width() == 3 => {
            patch.normals.get_or_insert_with(|| Box::new(values));
        }
        "st" | "N" => {}
        _ => patch.varying.push(values),
    }
}

/// Set s (axis 0) or t (axis 1) of a patch.
fn set_coordinate(patch: &mut Patch, axis: usize, values: Varying) {
    patch.own_st[axis] = true;
    values.corners(0).into_iter().enumerate().for_each(|(k, x)| patch.st[k][axis] = x);
    let is_curved = values.is_curved();
    if is_curved || patch.curved_st.is_some() {
        patch.curved_st.get_or_insert_default()[axis] = is_curved.then_some(values);
    }
}

/// Give the patches of one primitive with four corners its variables: varying ones are bilinear over all of it. Gives their names.
pub fn attach_variables(patches: &mut [Patch], params: &Params) -> Result<VariableNames, Fail> {
    let (min, max) =
        patches.iter().flat_map(|p| p.uv).fold(([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]), |(a, b), uv| {
            ([a[0].min(uv[0]), a[1].min(uv[1])], [b[0].max(uv[0]), b[1].max(uv[1])])
        });
    let whole: Params = params.iter().filter(|p| p.decl.class.is_whole()).cloned().collect();
    for patch in patches.iter_mut() {
        patch_variables(patch, &whole, &Places::default())?;
    }
    let mut names = names_of(&whole);
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
            set_varying(patch, &param.decl.name, Varying::new(width, all));
        }
        note_varying(&mut names, &param.decl);
    }
    Ok(names)
}

/// Values at the corners of the faces of a mesh, all variables in a row: their declarations, the values, numbers a corner.
pub type CornerColumns = (Vec<Declaration>, Vec<f32>, usize);

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
            values.extend(own.ok_or_else(|| too_few(param))?);
        }
    }
    Ok((varying.iter().map(|p| p.decl.clone()).collect(), values, width))
}

/// Give a patch such values, `width` numbers at each of its four corners.
pub fn corner_variables(patch: &mut Patch, columns: &[Declaration], values: &[f32], width: usize) {
    let mut first = 0;
    for declared in columns {
        let w = declared.width();
        let all = (0..4).flat_map(|k| values[k * width + first..k * width + first + w].iter().copied()).collect();
        set_varying(patch, &declared.name, Varying::new(w, all));
        first += w;
    }
}

/// Uniform numbers of a quadric's parameter list.
pub fn uniform_numbers(params: Params) -> Result<Vec<(VariableName, Vec<f32>)>, Fail> {
    let mut out = Vec::new();
    for param in params {
        match (&param.values, param.decl.class) {
            (Values::Floats(v), Class::Constant | Class::Uniform) => {
                out.push((VariableName::of(&param.decl), v[..param.decl.width().min(v.len())].to_vec()))
            }
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
