//! Primitives: the calls of RISpec section 5 as patches, spheres and instances.

use crate::context::state::Context;
use crate::gprim::basis::to_bezier;
use crate::gprim::blobby::Field;
use crate::gprim::curves::{curve, ribbon};
use crate::gprim::nurbs::{nurbs, nurbs_variable};
use crate::gprim::patch_mesh::patch_mesh;
use crate::gprim::polygon::polygon_patches;
use crate::gprim::quadric::{self, Profile};
use crate::gprim::subdivision;
use crate::gprim::teapot::teapot;
use crate::gprim::variables::{
    attach_variables, corner_columns, corner_variables, names_of, note_varying, patch_variables, positions,
    set_varying, uniform_numbers,
};
use crate::scene::attached::Attached;
use crate::scene::patch::Patch;
use crate::scene::shape::Shape;
use crate::scene::source::{SourceShape, instance_variables};
use crate::scene::variables::VariableNames;
use glam::{Mat4, Vec3, Vec4};
use ri::{Fail, InstanceShape, Instances, Knots, Param, Params, RiResult, Tags, Values};
use std::sync::Arc;

impl Context {
    pub(super) fn draw_polygon(&mut self, params: Params) -> RiResult {
        let n = params.iter().find(|p| p.decl.name == "P").map_or(0, |p| p.numbers().len() / 3);
        if n < 3 {
            return Err(Fail::new(format!("a polygon has {n} vertices in \"P\", expected at least 3")));
        }
        let patches = polygon_patches(&[(0..n).collect::<Vec<_>>()], &params, 0, 0)?;
        self.add_patches(patches, names_of(&params))
    }

    pub(super) fn draw_general_polygon(&mut self, n_vertices: Vec<i32>, params: Params) -> RiResult {
        let total: i64 = n_vertices.iter().map(|n| i64::from(*n).max(0)).sum();
        let given = params.iter().find(|p| p.decl.name == "P").map_or(0, |p| p.numbers().len() / 3);
        if total > given as i64 {
            return Err(Fail::new(format!("the loops have {total} vertices, and \"P\" has {given}")));
        }
        self.draw_points_general_polygons(
            vec![n_vertices.len() as i32],
            n_vertices,
            (0..total as i32).collect(),
            params,
        )
    }

    pub(super) fn draw_points_general_polygons(
        &mut self,
        n_loops: Vec<i32>,
        n_vertices: Vec<i32>,
        vertices: Vec<i32>,
        params: Params,
    ) -> RiResult {
        let mut patches = Vec::new();
        let (mut at_loop, mut at) = (0, 0);
        for (face, n) in n_loops.iter().enumerate() {
            let first = at;
            let mut loops = Vec::new();
            for _ in 0..*n {
                let n = n_vertices.get(at_loop).copied().filter(|n| *n >= 3);
                let n = n.ok_or(Fail::new(format!("a loop of face {face} has fewer than 3 vertices")))? as usize;
                let own = vertices.get(at..at + n).ok_or(Fail::new(format!("the vertex list ends in face {face}")))?;
                let own: Option<Vec<usize>> = own.iter().map(|i| usize::try_from(*i).ok()).collect();
                loops.push(own.ok_or(Fail::new(format!("face {face} has a negative vertex")))?);
                (at_loop, at) = (at_loop + 1, at + n);
            }
            patches.extend(polygon_patches(&loops, &params, face, first)?);
        }
        self.add_patches(patches, names_of(&params))
    }

    pub(super) fn draw_points_polygons(
        &mut self,
        n_vertices: Vec<i32>,
        vertices: Vec<i32>,
        params: Params,
    ) -> RiResult {
        let mut patches = Vec::new();
        let mut rest = vertices.as_slice();
        let mut first = 0;
        for (face, n) in n_vertices.iter().enumerate() {
            let n = usize::try_from(*n)
                .ok()
                .filter(|n| *n >= 3)
                .ok_or(Fail::new(format!("face {face} has {n} vertices, expected at least 3")))?;
            if rest.len() < n {
                return Err(Fail::new(format!("the vertex list ends in face {face}")));
            }
            let (own, after) = rest.split_at(n);
            rest = after;
            let corners: Option<Vec<usize>> = own.iter().map(|i| usize::try_from(*i).ok()).collect();
            let corners = corners.ok_or(Fail::new(format!("face {face} has a negative vertex")))?;
            patches.extend(polygon_patches(&[corners], &params, face, first)?);
            first += n;
        }
        self.add_patches(patches, names_of(&params))
    }

    pub(super) fn draw_patch(&mut self, kind: &str, params: Params) -> RiResult {
        let points = positions(&params)?;
        let wrong = |n: usize| Fail::new(format!("a {kind} patch has {} points, expected {n}", points.len()));
        let mut patch = match kind {
            "bilinear" => Patch::bilinear(points.clone().try_into().map_err(|_| wrong(4))?),
            "bicubic" => {
                let points: [Vec3; 16] = points.clone().try_into().map_err(|_| wrong(16))?;
                Patch::smooth(to_bezier(points, &self.bases), [0.0, 1.0], [0.0, 1.0])
            }
            other => return Err(Fail::new(format!("unknown patch type `{other}`, expected bilinear or bicubic"))),
        };
        patch_variables(&mut patch, &params, [0, 1, 2, 3], [0, 1, 2, 3], 0)?;
        self.add_patches(vec![patch], names_of(&params))
    }

    pub(super) fn draw_patch_mesh(
        &mut self,
        kind: &str,
        nu: i32,
        u_wrap: &str,
        nv: i32,
        v_wrap: &str,
        params: Params,
    ) -> RiResult {
        let periodic = |wrap: &str| match wrap {
            "periodic" => Ok(true),
            "nonperiodic" => Ok(false),
            other => Err(Fail::new(format!("unknown wrap `{other}`, expected periodic or nonperiodic"))),
        };
        if !matches!(kind, "bilinear" | "bicubic") {
            return Err(Fail::new(format!("unknown patch type `{kind}`, expected bilinear or bicubic")));
        }
        let sizes = [nu.max(0) as usize, nv.max(0) as usize];
        let wraps = [periodic(u_wrap)?, periodic(v_wrap)?];
        let points = positions(&params)?;
        let mesh = patch_mesh(kind == "bicubic", &points, sizes, wraps, &self.bases, self.steps)?;
        let mut patches = Vec::new();
        for (face, (mut patch, corners)) in mesh.into_iter().enumerate() {
            patch_variables(&mut patch, &params, corners, [4 * face, 4 * face + 1, 4 * face + 2, 4 * face + 3], face)?;
            patches.push(patch);
        }
        self.add_patches(patches, names_of(&params))
    }

    pub(super) fn draw_nu_patch(&mut self, u: Knots, v: Knots, params: Params) -> RiResult {
        let points: Vec<Vec4> = match params.iter().find(|p| p.decl.name == "Pw") {
            Some(p) => p.numbers().chunks_exact(4).map(Vec4::from_slice).collect(),
            None => positions(&params)?.into_iter().map(|p| p.extend(1.0)).collect(),
        };
        let mut patches = nurbs(&points, &u, &v)?;
        // Texture coordinates go from 0 to 1 over the patch (RISpec 5.3).
        for patch in &mut patches {
            let unit = |x: f32, r: [f32; 2]| (x - r[0]) / (r[1] - r[0]);
            patch.st = patch.uv.map(|[s, t]| [unit(s, u.range), unit(t, v.range)]);
        }
        let (mut others, mut names) = (Params::new(), VariableNames::default());
        for param in params {
            let (width, values) = (param.decl.width(), param.numbers());
            let own = !param.decl.class.is_whole()
                && values.len() > 4 * width
                && !matches!(param.decl.name.as_str(), "P" | "Pw");
            if !own {
                others.push(param);
                continue;
            }
            for patch in &mut patches {
                let corners = patch.uv.map(|[s, t]| nurbs_variable(values, width, &points, &u, &v, s, t));
                let Some(all) = corners.into_iter().collect::<Option<Vec<_>>>() else {
                    let message = format!(
                        "`{}` has {} values, one for no point of the patch",
                        param.decl.name,
                        values.len() / width
                    );
                    return Err(Fail::new(message));
                };
                set_varying(patch, &param.decl.name, all.concat());
            }
            note_varying(&mut names, &param.decl.name);
        }
        let VariableNames { uniform, varying } = attach_variables(&mut patches, &others)?;
        names.uniform = uniform;
        names.varying.extend(varying);
        self.add_patches(patches, names)
    }

    pub(super) fn draw_points(&mut self, params: Params) -> RiResult {
        let points = positions(&params)?;
        let n = points.len();
        let widths = params.iter().find(|p| matches!(p.decl.name.as_str(), "width" | "constantwidth"));
        let width = |i: usize| match widths.map(|p| p.numbers()) {
            Some([one]) => *one,
            Some(all) => all.get(i).copied().unwrap_or(1.0),
            None => 1.0,
        };
        let columns: Vec<_> = params
            .iter()
            .filter(|p| !matches!(p.decl.name.as_str(), "P" | "width" | "constantwidth" | "N"))
            .filter(|p| matches!(p.values, Values::Floats(_)))
            .map(|p| {
                let w = p.decl.width();
                let v = p.numbers();
                // What is the same for all is repeated.
                let all = if v.len() == w { v.repeat(n) } else { v.to_vec() };
                if all.len() != n * w {
                    let message = format!("`{}` has {} values for {n} points", p.decl.name, v.len() / w);
                    return Err(Fail::new(message));
                }
                Ok(Param { decl: p.decl.clone(), values: Values::Floats(all) })
            })
            .collect::<Result<_, _>>()?;
        if n == 0 {
            return Ok(());
        }
        let instances = Instances {
            shape: InstanceShape::Sphere,
            position: points.iter().map(|p| p.to_array()).collect(),
            orientation: vec![],
            scale: (0..n).map(|i| [0.5 * width(i); 3]).collect(),
            params: columns,
            moved: None,
        };
        self.add_spheres(instances, vec![])
    }

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
        let widths = params.iter().find(|p| p.decl.name == "width").map(|p| p.numbers().to_vec());
        let constant =
            params.iter().find(|p| p.decl.name == "constantwidth").and_then(|p| p.numbers().first().copied());
        let normals = params.iter().find(|p| p.decl.name == "N").map(|p| p.numbers().to_vec());
        let to_eye = self.transform.inverse()
            * self
                .to_camera
                .ok_or(Fail::new("`Curves` stands outside the world, expected between WorldBegin and WorldEnd"))?
                .inverse();
        let eye = to_eye.transform_point3(Vec3::ZERO);
        let along = to_eye.transform_vector3(Vec3::Z);
        let perspective = self.options.fov.is_some();
        let is_own = |p: &&Param| !matches!(p.decl.name.as_str(), "N" | "width" | "constantwidth");
        let own: Params = params.iter().filter(is_own).cloned().collect();
        let (mut at, mut value) = (0, 0);
        let mut patches = Vec::new();
        for (face, n) in n_vertices.iter().enumerate() {
            let vertices = points.get(at..at + (*n).max(0) as usize);
            let vertices = vertices.ok_or(Fail::new(format!("curve {face} has more vertices than \"P\"")))?;
            at += vertices.len();
            let curve = curve(vertices, cubic, periodic, &self.bases.1, self.steps[1])?;
            let count = curve.segments.len() as f32;
            for (k, (control, ends)) in curve.segments.iter().enumerate() {
                let width = ends.map(|e| match &widths {
                    Some(w) if w.len() == 1 => w[0],
                    Some(w) => w.get(value + e).copied().unwrap_or(1.0),
                    None => constant.unwrap_or(1.0),
                });
                let facing = |p: Vec3| match &normals {
                    // A ribbon lies across its normals; others face the eye.
                    Some(n) if n.len() >= 3 => {
                        let of =
                            |e: usize| n.get(3 * (value + e)..3 * (value + e) + 3).map_or(Vec3::Z, Vec3::from_slice);
                        0.5 * (of(ends[0]) + of(ends[1]))
                    }
                    _ if perspective => eye - p,
                    _ => -along,
                };
                let range = [k as f32 / count, (k + 1) as f32 / count];
                let mut patch = ribbon(control, width, range, facing);
                let [a, b] = ends.map(|e| value + e);
                patch_variables(&mut patch, &own, [a, a, b, b], [a, a, b, b], face)?;
                patches.push(patch);
            }
            value += curve.n_varying;
        }
        self.add_patches(patches, names_of(&own))
    }

    pub(super) fn draw_subdivision_mesh(
        &mut self,
        scheme: &str,
        n_vertices: Vec<i32>,
        vertices: Vec<i32>,
        tags: Tags,
        params: Params,
    ) -> RiResult {
        if scheme != "catmull-clark" {
            return Err(Fail::new(format!("unknown subdivision scheme `{scheme}`, expected catmull-clark")));
        }
        let points = positions(&params)?;
        let corners: usize = n_vertices.iter().map(|n| (*n).max(0) as usize).sum();
        let (columns, values, width) = corner_columns(&params, &vertices, corners)?;
        let mesh = subdivision::Mesh::new(points, &n_vertices, &vertices, &tags, &values, width)?;
        // Fewer steps where there are many faces already.
        let levels = match n_vertices.len() {
            0..=200 => 4,
            201..=3000 => 3,
            3001..=30000 => 2,
            _ => 1,
        };
        let whole: Params = params.iter().filter(|p| p.decl.class.is_whole()).cloned().collect();
        let mut names = names_of(&whole);
        columns.iter().for_each(|(name, _)| note_varying(&mut names, name));
        let mut patches = Vec::new();
        for part in mesh.patches(levels) {
            let mut patch = part.patch;
            corner_variables(&mut patch, &columns, &part.values, width);
            patch_variables(&mut patch, &whole, [0; 4], [0; 4], part.face)?;
            patches.push(patch);
        }
        self.add_patches(patches, names)
    }

    pub(super) fn draw_geometry(&mut self, name: &str, params: Params) -> RiResult {
        if name != "teapot" {
            self.scene.warn(format!("geometry `{name}` is passed over: `teapot` alone is known"));
            return Ok(());
        }
        let mut patches = teapot();
        let whole: Params = params.iter().filter(|p| p.decl.class.is_whole()).cloned().collect();
        let names = attach_variables(&mut patches, &whole)?;
        self.add_patches(patches, names)
    }

    pub(super) fn draw_sphere(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        if !(radius != 0.0 && radius.is_finite() && z_min.is_finite() && z_max.is_finite() && sweep.is_finite()) {
            return Err(Fail::new(format!(
                "a sphere of radius {radius} from {z_min} to {z_max} over {sweep}° cannot be drawn"
            )));
        }
        let r = radius.abs();
        let varies = params.iter().any(|p| !p.decl.class.is_whole());
        if z_min <= -r && z_max >= r && sweep.abs() >= 360.0 && !varies {
            let uniform = uniform_numbers(params)?;
            // As an instance array of one, so that object space keeps its unit.
            let one = Instances {
                shape: InstanceShape::Sphere,
                position: vec![[0.0; 3]],
                orientation: vec![],
                scale: vec![[r; 3]],
                params: vec![],
                moved: None,
            };
            return self.add_spheres(one, uniform);
        }
        let angle = |z: f32| (z / r).clamp(-1.0, 1.0).asin();
        self.quadric(quadric::circle([0.0; 2], r, angle(z_min), angle(z_max)), sweep, params)
    }

    /// A quadric: a profile, swept.
    pub(super) fn quadric(&mut self, profile: Vec<Profile>, sweep: f32, params: Params) -> RiResult {
        let sound = |p: &Profile| p.0.iter().all(|q| q.is_finite());
        if !(sweep.is_finite() && sweep != 0.0 && profile.iter().all(sound)) {
            return Err(Fail::new("the quadric's numbers make no surface"));
        }
        let mut patches = quadric::revolve(&profile, sweep.clamp(-360.0, 360.0));
        let names = attach_variables(&mut patches, &params)?;
        self.add_patches(patches, names)
    }

    /// One instance of an object.
    pub(super) fn draw_object(&mut self, handle: &str) -> RiResult {
        let place = Instances {
            shape: InstanceShape::Object(handle.into()),
            position: vec![[0.0; 3]],
            orientation: vec![],
            scale: vec![],
            params: vec![],
            moved: None,
        };
        self.draw_instances(place)
    }

    /// A blobby.
    pub(super) fn draw_blobby(&mut self, leaves: i32, codes: Vec<i32>, floats: Vec<f32>, params: Params) -> RiResult {
        let field = Field::new(leaves.max(0) as usize, &codes, &floats)?;
        let (mut varying, mut names) = (Vec::new(), Vec::new());
        for param in params.iter().filter(|p| !p.decl.class.is_whole() && !p.numbers().is_empty()) {
            let width = param.decl.width();
            if param.numbers().len() != width * leaves as usize {
                return Err(Fail::new(format!("`{}` needs a value for each of {leaves} leaves", param.decl.name)));
            }
            // The field gives the normals.
            if param.decl.name != "N" {
                varying.push((width, param.numbers().to_vec()));
                names.push(param.decl.name.clone());
            }
        }
        let mut patches = field.patches(&varying);
        let whole: Params = params.iter().filter(|p| p.decl.class.is_whole()).cloned().collect();
        let VariableNames { uniform, .. } = attach_variables(&mut patches, &whole)?;
        self.add_patches(patches, VariableNames { uniform, varying: names })
    }

    /// Instances by columns.
    pub(super) fn draw_instances(&mut self, instances: Instances) -> RiResult {
        let own: Vec<String> = instance_variables(&instances).map(|p| p.decl.name.clone()).collect();
        match &instances.shape {
            InstanceShape::Sphere => {
                let attached = vec![Arc::new(Attached::new(&self.attributes, own, &VariableNames::default()))];
                self.push(SourceShape::Spheres(instances), vec![], attached)
            }
            InstanceShape::Object(handle) => {
                let parts =
                    self.objects.get(handle).cloned().ok_or(Fail::new(format!("there is no object `{handle}`")))?;
                let attached = self.attach_parts(&own, &parts);
                self.push(SourceShape::Objects(instances, parts), vec![], attached)
            }
        }
    }

    /// The variables of the parts of an object, attached to the current shaders; the patches of one primitive share theirs.
    fn attach_parts(&self, own: &[String], parts: &[(Shape, Mat4)]) -> Vec<Arc<Attached>> {
        let none = Arc::new(VariableNames::default());
        let mut last: Option<(&Arc<VariableNames>, Arc<Attached>)> = None;
        let mut all = Vec::with_capacity(parts.len());
        for (shape, _) in parts {
            let names = match shape {
                Shape::Sphere => &none,
                Shape::Patches(_, names) => names,
            };
            let attached = match last.take() {
                Some((before, attached)) if Arc::ptr_eq(before, names) => attached,
                _ => Arc::new(Attached::new(&self.attributes, own.to_vec(), names)),
            };
            all.push(attached.clone());
            last = Some((names, attached));
        }
        all
    }
}
