//! Curves (RISpec 5.5): ribbons along their segments, with the variables of each.

use crate::context::primitives::check_widths;
use crate::context::state::Context;
use crate::gprim::basis::BEZIER;
use crate::gprim::curves::{self, Segment, curve, n_pieces, ribbon};
use crate::gprim::variables::{Counts, Places, names_of, patch_variables, positions, too_few};
use crate::scene::interpolation::cubic_part;
use crate::scene::patch::Patch;
use glam::Vec3;
use ri::{Class, Fail, Param, Params, RiResult};

impl Context {
    /// Curves.
    pub(super) fn draw_curves(&mut self, kind: &str, n_vertices: Vec<i32>, wrap: &str, params: Params) -> RiResult {
        let (cubic, periodic) = match (kind, wrap) {
            ("linear" | "cubic", "periodic" | "nonperiodic") => (kind == "cubic", wrap == "periodic"),
            _ => {
                return Err(Fail::new(format!(
                    "curves `{kind}` `{wrap}`, expected linear or cubic, periodic or nonperiodic"
                )));
            }
        };
        let points = positions(&params)?;
        let given = |name: &str| params.iter().find(|p| p.decl.name == name).filter(|p| !p.numbers().is_empty());
        let (widths, constant, normals) = (given("width"), given("constantwidth"), given("N"));
        check_widths(widths.or(constant))?;
        let to_eye = self.transform.inverse()
            * self
                .to_camera
                .ok_or(Fail::new("`Curves` stands outside the world, expected between WorldBegin and WorldEnd"))?
                .inverse();
        let eye = match self.options.fov {
            Some(_) => Eye::At(to_eye.transform_point3(Vec3::ZERO)),
            None => Eye::Along(to_eye.transform_vector3(Vec3::Z)),
        };
        let is_own = |p: &&Param| !matches!(p.decl.name.as_str(), "N" | "width" | "constantwidth");
        let own: Params = params.iter().filter(is_own).cloned().collect();
        let (mut at, mut value) = (0, 0);
        let mut patches = Vec::new();
        for (face, n) in n_vertices.iter().enumerate() {
            let vertices = points.get(at..at + (*n).max(0) as usize);
            let vertices = vertices.ok_or(Fail::new(format!("curve {face} has more vertices than \"P\"")))?;
            let first = at;
            at += vertices.len();
            let curve = curve(vertices, cubic, periodic, &self.geometry.bases.1, self.geometry.steps[1])?;
            let count = curve.segments.len() as f32;
            for (k, Segment { control, ends, vertices }) in curve.segments.iter().enumerate() {
                let ends = ends.map(|e| value + e);
                let vertices = vertices.map(|i| first + i);
                // Values of a parameter at the control points of the segment.
                let values = |param: &Param, c: usize| -> Result<[f32; 4], Fail> {
                    let (v, w) = (param.numbers(), param.decl.width());
                    let at = |i: usize| v.get(i * w + c).copied().ok_or(too_few(param));
                    if param.decl.class.is_whole() || v.len() == w {
                        let own = if v.len() > w { face } else { 0 };
                        return Ok([at(own)?; 4]);
                    }
                    if cubic && param.decl.class == Class::Vertex {
                        let [p, q, r, s] = vertices.map(at);
                        return Ok(curves::along([p?, q?, r?, s?], &self.geometry.bases.1));
                    }
                    let (a, b) = (at(ends[0])?, at(ends[1])?);
                    Ok([0.0, 1.0, 2.0, 3.0].map(|k| a + (b - a) * k / 3.0))
                };
                let width = match widths.or(constant) {
                    Some(param) => values(param, 0)?,
                    None => [1.0; 4],
                };
                let normals = normals.map(|n| Ok([values(n, 0)?, values(n, 1)?, values(n, 2)?])).transpose()?;
                let range = [k as f32 / count, (k + 1) as f32 / count];
                let varying = [ends[0], ends[0], ends[1], ends[1]];
                // Along the curve its own basis holds, across it what is the same there stays so.
                let bases = (BEZIER, self.geometry.bases.1);
                let vertex = cubic.then(|| (std::array::from_fn(|k| vertices[k / 4]), &bases));
                let mut whole = Patch::smooth([Vec3::ZERO; 16], [0.0, 1.0], range);
                patch_variables(&mut whole, &own, &Places { varying, corner: varying, face, vertex })?;
                let n = if cubic { n_pieces(control, self.motion.is_some()) } else { 1 };
                let ribbon = Ribbon { control, width, normals, neighbours: curve.beside(k, (cubic, periodic)), eye };
                patches.extend(ribbon.pieces(n, &whole));
            }
            value += curve.n_varying;
        }
        self.say_surplus(&params, Counts { uniform: n_vertices.len(), varying: value, vertex: at, facevarying: value });
        if at < points.len() {
            let n = points.len();
            self.scene.warn(format!("\"P\" has {n} points, and the curves {at} vertices: those beyond are not used"));
        }
        self.add_patches(patches, names_of(&own))
    }
}

/// Where the camera is, in object space, m: at a point, or beyond all along a direction.
#[derive(Clone, Copy)]
enum Eye {
    At(Vec3),
    Along(Vec3),
}

/// A segment of a curve that becomes a ribbon.
struct Ribbon<'a> {
    control: &'a [Vec3; 4],
    /// Widths and components of the normals at its control points.
    width: [f32; 4],
    normals: Option<[[f32; 4]; 3]>,
    neighbours: [Option<Vec3>; 2],
    eye: Eye,
}

impl Ribbon<'_> {
    /// Its patches, `n` pieces, with the values that `whole` has there.
    fn pieces(&self, n: usize, whole: &Patch) -> impl Iterator<Item = Patch> {
        (0..n).map(move |piece| {
            let part = [piece, piece + 1].map(|end| end as f32 / n as f32);
            let normals = self.normals.map(|normals| normals.map(|c| cubic_part(c, part)));
            let facing = |p: Vec3, weights: [f32; 4]| match (&normals, self.eye) {
                // A ribbon lies across its normals; others face the eye.
                (Some(n), _) => Vec3::from_array([0, 1, 2].map(|c| (0..4).map(|k| weights[k] * n[c][k]).sum())),
                (None, Eye::At(eye)) => eye - p,
                (None, Eye::Along(along)) => -along,
            };
            let (control, width) = (cubic_part(*self.control, part), cubic_part(self.width, part));
            whole.part(ribbon(&control, self.neighbours, width, facing), part)
        })
    }
}
