//! Primitives: the calls of RISpec section 5 as patches, spheres and instances.

use crate::context::motion_block::PolygonCut;
use crate::context::state::Context;
use crate::gprim::basis::BEZIER;
use crate::gprim::basis::to_bezier;
use crate::gprim::nurbs::{nurbs, nurbs_variable, span_of};
use crate::gprim::patch_mesh::patch_mesh;
use crate::gprim::polygon::{Cut, MOST_CROSSED, polygon_cut, polygon_patches, turns};
use crate::gprim::subdivision;
use crate::gprim::teapot::teapot;
use crate::gprim::variables::{
    Counts, Places, attach_variables, corner_columns, corner_variables, names_of, note_varying, patch_variables,
    positions, set_varying, too_few, weighted,
};
use crate::scene::patch::Patch;
use crate::scene::source::{SourceShape, instance_variables};
use crate::scene::variables::{VariableName, VariableNames, Varying};
use glam::{Vec3, Vec4};
use ri::{Class, Fail, InstanceShape, Instances, Knots, Param, Params, RiResult, Tags, Type, Values};

impl Context {
    /// The parameters of a primitive, with points by their weights.
    pub(super) fn variables(&self, params: Params) -> Result<Params, Fail> {
        self.say_texts(&params);
        weighted(params)
    }

    /// Say that strings of a primitive do not reach shaders.
    pub(super) fn say_texts(&self, params: &Params) {
        for param in params.iter().filter(|param| matches!(param.values, Values::Strings(_))) {
            let name = &param.decl.name;
            self.scene
                .warn(format!("the string `{name}` of a primitive does not reach its shaders: set their parameter"));
        }
        for param in params.iter().filter(|param| param.decl.class == Class::Constant) {
            let (name, n, width) = (&param.decl.name, param.numbers().len(), param.decl.width());
            if n > width {
                self.scene.warn(format!("`{name}` of class constant has {} values: the first holds", n / width.max(1)));
            }
        }
    }

    /// Say which variables of a primitive have more values than it takes.
    pub(super) fn say_surplus(&self, params: &Params, counts: Counts) {
        params.iter().filter_map(|param| counts.surplus(param)).for_each(|said| self.scene.warn(said));
    }

    /// The same of polygons with a number of faces and of corners, and say if corners are left over.
    fn say_surplus_of_faces(&self, params: &Params, [faces, corners]: [usize; 2], vertices: &[i32]) {
        let points = params.iter().find(|p| p.decl.name == "P").map_or(0, |p| p.numbers().len() / 3);
        let counts = Counts { uniform: faces, varying: points, vertex: points, facevarying: corners };
        self.say_surplus(params, counts);
        self.say_vertices_beyond(vertices.len(), corners);
    }

    /// Say if a list of vertices has more than those of the faces.
    fn say_vertices_beyond(&self, given: usize, corners: usize) {
        if given > corners {
            self.scene.warn(format!(
                "the vertex list has {given} numbers, and the faces have {corners} vertices: those beyond are not used"
            ));
        }
    }

    pub(super) fn draw_polygon(&mut self, params: Params) -> RiResult {
        let n = params.iter().find(|p| p.decl.name == "P").map_or(0, |p| p.numbers().len() / 3);
        if n < 3 {
            return Err(Fail::new(format!("a polygon has {n} vertices in \"P\", expected at least 3")));
        }
        self.say_surplus_of_faces(&params, [1, n], &[]);
        let patches = self.polygon(&[(0..n).collect::<Vec<_>>()], &params, 0, 0)?;
        self.add_patches(patches, names_of(&params))
    }

    pub(super) fn draw_general_polygon(&mut self, n_vertices: Vec<i32>, params: Params) -> RiResult {
        let total: i64 = n_vertices.iter().map(|n| i64::from(*n).max(0)).sum();
        let given = params.iter().find(|p| p.decl.name == "P").map_or(0, |p| p.numbers().len() / 3);
        if total > given as i64 {
            return Err(Fail::new(format!("the loops have {total} vertices, and \"P\" has {given}")));
        }
        if total < given as i64 {
            let message = format!("the loops have {total} vertices, and \"P\" has {given}: those beyond are not used");
            self.scene.warn(message);
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
            patches.extend(self.polygon(&loops, &params, face, first)?);
        }
        self.say_surplus_of_faces(&params, [n_loops.len(), at], &vertices);
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
            patches.extend(self.polygon(&[corners], &params, face, first)?);
            first += n;
        }
        self.say_surplus_of_faces(&params, [n_vertices.len(), first], &vertices);
        self.add_patches(patches, names_of(&params))
    }

    /// The patches of a polygon; within a motion block it is cut as the same one was at the first time.
    fn polygon(
        &mut self,
        loops: &[Vec<usize>],
        params: &Params,
        face: usize,
        first: usize,
    ) -> Result<Vec<Patch>, Fail> {
        let sizes = || loops.iter().map(Vec::len);
        let known = self.motion.as_ref().filter(|block| !block.calls.is_empty());
        if let Some(cut) = known.and_then(|block| block.cuts.get(face)) {
            // One of other vertices is another polygon: that the patches are not as many tells it.
            let quads = if sizes().eq(cut.loops.iter().copied()) { &cut.quads[..] } else { &[] };
            return polygon_patches(loops, params, [face, first], quads);
        }
        let Cut { quads, crosses } = polygon_cut(loops, params)?;
        let n: usize = sizes().sum();
        if crosses && n > MOST_CROSSED {
            self.scene.warn(format!(
                "a polygon of {n} vertices whose edges cross is not drawn: such a one has at most {MOST_CROSSED}"
            ));
        } else if crosses && !quads.is_empty() {
            self.scene.warn("the edges of a polygon cross: parts of it may be missing".into());
        } else if quads.is_empty() && turns(loops, params) {
            self.scene.warn("a polygon that crosses itself, as much one way as the other, is not drawn".into());
        } else if self.motion.is_none() && (quads.is_empty() || n <= 4) && !turns(loops, params) {
            self.scene.warn("a polygon whose vertices lie in a row has no area and is not seen".into());
        }
        let patches = polygon_patches(loops, params, [face, first], &quads)?;
        if let Some(block) = self.motion.as_mut().filter(|block| block.calls.is_empty()) {
            block.cuts.push(PolygonCut { loops: sizes().collect(), quads });
        }
        Ok(patches)
    }

    pub(super) fn draw_patch(&mut self, kind: &str, params: Params) -> RiResult {
        if matches!(kind, "bilinear" | "bicubic") && is_rational(&params) {
            return self.draw_rational_patch(kind == "bicubic", params);
        }
        let n = if kind == "bicubic" { 4 } else { 2 };
        let params = self.with_heights(weighted(params)?, kind, [n; 2])?;
        let points = positions(&params)?;
        let wrong = |n: usize| Fail::new(format!("a {kind} patch has {} points, expected {n}", points.len()));
        let is_cubic = kind == "bicubic";
        let mut patch = match kind {
            "bilinear" => Patch::bilinear(points.clone().try_into().map_err(|_| wrong(4))?),
            "bicubic" => {
                let points: [Vec3; 16] = points.clone().try_into().map_err(|_| wrong(16))?;
                Patch::smooth(to_bezier(points, &self.geometry.bases), [0.0, 1.0], [0.0, 1.0])
            }
            other => return Err(Fail::new(format!("unknown patch type `{other}`, expected bilinear or bicubic"))),
        };
        let vertex = is_cubic.then(|| (std::array::from_fn(|k| k), &self.geometry.bases));
        let places = Places { varying: [0, 1, 2, 3], corner: [0, 1, 2, 3], face: 0, vertex };
        self.say_surplus(&params, Counts { vertex: points.len(), ..Counts::FOUR });
        patch_variables(&mut patch, &params, &places)?;
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
        if is_rational(&params) {
            return self.draw_rational_mesh(kind == "bicubic", sizes, wraps, params);
        }
        let params = self.with_heights(weighted(params)?, kind, sizes)?;
        let points = positions(&params)?;
        let mesh = patch_mesh(kind == "bicubic", &points, sizes, wraps, &self.geometry.bases, self.geometry.steps)?;
        let n_corners = mesh.iter().flat_map(|(_, varying, _)| varying).max().map_or(0, |k| k + 1);
        let counts =
            Counts { uniform: mesh.len(), varying: n_corners, vertex: points.len(), facevarying: 4 * mesh.len() };
        self.say_surplus(&params, counts);
        let mut patches = Vec::new();
        for (face, (mut patch, varying, controls)) in mesh.into_iter().enumerate() {
            let vertex = controls.map(|controls| (controls, &self.geometry.bases));
            let corner = [0, 1, 2, 3].map(|k| 4 * face + k);
            patch_variables(&mut patch, &params, &Places { varying, corner, face, vertex })?;
            patches.push(patch);
        }
        self.add_patches(patches, names_of(&params))
    }

    /// Heights of a patch or a mesh, "Pz", as "P": x and y of the surface are its parameters (RISpec 5).
    fn with_heights(&self, mut params: Params, kind: &str, [nu, nv]: [usize; 2]) -> Result<Params, Fail> {
        let is_given = |name: &str| params.iter().position(|p| p.decl.name == name);
        let (None, Some(k)) = (is_given("P"), is_given("Pz")) else { return Ok(params) };
        let heights = params[k].numbers();
        if heights.len() != nu * nv {
            return Err(Fail::new(format!(
                "a {kind} patch of {nu} × {nv} points has {} heights in \"Pz\"",
                heights.len()
            )));
        }
        let place = |axis: usize, i: usize, n: usize| -> Result<f32, Fail> {
            let basis = if axis == 0 { &self.geometry.bases.0 } else { &self.geometry.bases.1 };
            match self.geometry.steps[axis] {
                _ if kind == "bilinear" => Ok(i as f32 / (n as f32 - 1.0)),
                3 if *basis == BEZIER => Ok(i as f32 / (n as f32 - 1.0)),
                1 if *basis != BEZIER => Ok((i as f32 - 1.0) / (n as f32 - 3.0)),
                _ => {
                    Err(Fail::new("\"Pz\" needs the basis bezier with step 3, or b-spline or catmull-rom with step 1"))
                }
            }
        };
        let mut points = Vec::with_capacity(3 * heights.len());
        for (k, z) in heights.iter().enumerate() {
            points.extend([place(0, k % nu, nu)?, place(1, k / nu, nv)?, *z]);
        }
        params[k] = Param::floats("P", Class::Vertex, Type::Point, points);
        Ok(params)
    }

    pub(super) fn draw_nu_patch(&mut self, u: Knots, v: Knots, params: Params) -> RiResult {
        let (patches, names) = self.nu_patches(u, v, params)?;
        self.add_patches(patches, names)
    }

    /// The patches of a NURBS patch, and the names of their variables.
    pub(super) fn nu_patches(&self, u: Knots, v: Knots, params: Params) -> Result<(Vec<Patch>, VariableNames), Fail> {
        let points: Vec<Vec4> = match params.iter().find(|p| p.decl.name == "Pw") {
            Some(p) => p.numbers().chunks_exact(4).map(Vec4::from_slice).collect(),
            None => positions(&params)?.into_iter().map(|p| p.extend(1.0)).collect(),
        };
        let mut patches = nurbs(&points, &u, &v)?;
        if let Some(k) = points.iter().position(|p| p.w <= 0.0) {
            let weight = points[k].w;
            self.scene
                .warn(format!("point {k} of \"Pw\" has the weight {weight}: the patch may reach beyond all bounds"));
        }
        // Texture coordinates go from 0 to 1 over the patch (RISpec 5.3).
        for patch in &mut patches {
            let unit = |x: f32, r: [f32; 2]| (x - r[0]) / (r[1] - r[0]);
            patch.st = patch.uv.map(|[s, t]| [unit(s, u.range), unit(t, v.range)]);
        }
        let (mut others, mut names, mut of_spans) = (Params::new(), VariableNames::default(), vec![]);
        for param in params {
            let (width, values) = (param.decl.width(), param.numbers());
            if param.decl.class == Class::Uniform && values.len() > width {
                // One value a span.
                for patch in &mut patches {
                    let [span, n] = span_of(patch, &u, &v);
                    let own = values.get(span * width..(span + 1) * width).filter(|_| values.len() == n * width);
                    let Some(own) = own else {
                        let (name, given) = (&param.decl.name, values.len() / width);
                        return Err(Fail::new(format!(
                            "`{name}` has {given} values, expected one for each of {n} spans"
                        )));
                    };
                    patch.uniform.push(own.to_vec());
                }
                of_spans.push(VariableName::of(&param.decl));
                continue;
            }
            if param.decl.class == Class::Uniform && !matches!(param.decl.name.as_str(), "P" | "Pw") {
                let n = patches.first().map_or(1, |patch| span_of(patch, &u, &v)[1]);
                if n > 1 && !values.is_empty() {
                    let name = &param.decl.name;
                    self.scene.warn(format!(
                        "`{name}` of class uniform has one value, expected {n}, one a span: it is that of all"
                    ));
                }
            }
            let own = !param.decl.class.is_whole()
                && (values.len() > 4 * width || param.decl.class == Class::Vertex)
                && !matches!(param.decl.name.as_str(), "P" | "Pw");
            if !own {
                others.push(param);
                continue;
            }
            for patch in &mut patches {
                let Some(values) = nurbs_variable(&param, &points, &u, &v, patch) else {
                    let (name, n) = (&param.decl.name, values.len() / width);
                    return Err(Fail::new(format!("`{name}` has {n} values, one for no point of the patch")));
                };
                set_varying(patch, &param.decl.name, values);
            }
            note_varying(&mut names, &param.decl);
        }
        let VariableNames { uniform, varying } = attach_variables(&mut patches, &others)?;
        names.uniform = of_spans.into_iter().chain(uniform).collect();
        names.varying.extend(varying);
        Ok((patches, names))
    }

    pub(super) fn draw_points(&mut self, params: Params) -> RiResult {
        let points = positions(&params)?;
        let n = points.len();
        let widths = params.iter().find(|p| matches!(p.decl.name.as_str(), "width" | "constantwidth"));
        let width = |i: usize| match widths.map(|p| p.numbers()) {
            Some([one]) => *one,
            Some(all) => all[i],
            None => 1.0,
        };
        if let Some(param) =
            widths.filter(|p| p.numbers().len() > 1 && p.numbers().len() != n || p.numbers().is_empty())
        {
            let (name, given) = (&param.decl.name, param.numbers().len());
            return Err(Fail::new(format!("`{name}` has {given} values for {n} points")));
        }
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
        check_widths(widths)?;
        let instances = Instances {
            shape: InstanceShape::Sphere,
            position: points.iter().map(|p| p.to_array()).collect(),
            orientation: vec![],
            scale: (0..n).map(|i| [0.5 * width(i); 3]).collect(),
            offset: vec![],
            params: columns,
            moved: None,
        };
        self.add_spheres(instances, vec![], true)
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
        let known = ["hole", "crease", "corner", "interpolateboundary"];
        for name in tags.names.iter().filter(|name| !known.contains(&name.as_str())) {
            self.scene.warn(format!("tag `{name}` of a subdivision mesh has no effect, expected {}", known.join(", ")));
        }
        let corners: usize = n_vertices.iter().map(|n| (*n).max(0) as usize).sum();
        // What is of class vertex is subdivided as the points are (RISpec 5.6).
        let is_smooth = |p: &Param| p.decl.class == Class::Vertex && !matches!(p.decl.name.as_str(), "P" | "N");
        let (smooth, others): (Params, Params) =
            params.iter().filter(|p| !p.numbers().is_empty()).cloned().partition(is_smooth);
        let (n_faces, n_points) = (n_vertices.len(), points.len());
        let counts = Counts { uniform: n_faces, varying: n_points, vertex: n_points, facevarying: corners };
        self.say_surplus(&params, counts);
        self.say_vertices_beyond(vertices.len(), corners);
        let (columns, values, width) = corner_columns(&others, &vertices, corners)?;
        let mesh = subdivision::Mesh::new(points, &n_vertices, &vertices, &tags, &values, width)?;
        // Fewer steps where there are many faces already, or many patches of other meshes.
        let of_faces = match n_vertices.len() {
            0..=200 => 4,
            201..=3000 => 3,
            3001..=30000 => 2,
            _ => 1,
        };
        let levels = match self.scene.n_subdivided {
            0..100_000 => of_faces,
            100_000..150_000 => of_faces.min(3),
            150_000..250_000 => of_faces.min(2),
            _ => 1,
        };
        let whole: Params = params.iter().filter(|p| p.decl.class.is_whole()).cloned().collect();
        let mut names = names_of(&whole);
        columns.iter().chain(smooth.iter().map(|p| &p.decl)).for_each(|declared| note_varying(&mut names, declared));
        let parts = mesh.patches(levels);
        if parts.is_empty() && n_faces > 0 && !tags.names.iter().any(|name| name == "interpolateboundary") {
            let message = "a subdivision mesh whose faces all touch its boundary is not seen without the tag `interpolateboundary`";
            self.scene.warn(message.into());
        }
        self.scene.n_subdivided += parts.len();
        let mut patches = Vec::with_capacity(parts.len());
        for part in parts {
            let mut patch = part.patch;
            corner_variables(&mut patch, &columns, &part.values, width);
            patch_variables(&mut patch, &whole, &Places { face: part.face, ..Places::default() })?;
            patches.push(patch);
        }
        for param in smooth {
            let width = param.decl.width();
            if param.numbers().len() < n_points * width {
                return Err(too_few(&param));
            }
            let mut all = vec![vec![0.0; 16 * width]; patches.len()];
            // Three numbers at a time are points of a mesh of their own.
            for first in (0..width).step_by(3) {
                let number =
                    |v: usize, c: usize| if first + c < width { param.numbers()[v * width + first + c] } else { 0.0 };
                let values = (0..n_points).map(|v| Vec3::new(number(v, 0), number(v, 1), number(v, 2))).collect();
                let mesh = subdivision::Mesh::new(values, &n_vertices, &vertices, &tags, &[], 0)?;
                for (all, part) in all.iter_mut().zip(mesh.patches(levels)) {
                    for (k, value) in part.patch.p.iter().enumerate() {
                        (first..width.min(first + 3)).for_each(|c| all[k * width + c] = value[c - first]);
                    }
                }
            }
            patches.iter_mut().zip(all).for_each(|(p, all)| set_varying(p, &param.decl.name, Varying::new(width, all)));
        }
        self.add_patches(patches, names)
    }

    pub(super) fn draw_geometry(&mut self, name: &str, params: Params) -> RiResult {
        if name != "teapot" {
            self.scene.warn(format!("geometry `{name}` is passed over: `teapot` alone is known"));
            return Ok(());
        }
        let mut patches = teapot();
        let (whole, others): (Params, Params) = params.into_iter().partition(|p| p.decl.class.is_whole());
        for Param { decl, .. } in others {
            let (name, class) = (decl.name, decl.class.name());
            self.scene
                .warn(format!("`{name}` of class {class} has no effect on a teapot, expected constant or uniform"));
        }
        self.say_surplus(&whole, Counts::FOUR);
        let names = attach_variables(&mut patches, &whole)?;
        self.add_patches(patches, names)
    }

    /// One instance of an object.
    pub(super) fn draw_object(&mut self, handle: &str) -> RiResult {
        let place = Instances {
            shape: InstanceShape::Object(handle.into()),
            position: vec![[0.0; 3]],
            orientation: vec![],
            scale: vec![],
            offset: vec![],
            params: vec![],
            moved: None,
        };
        self.draw_instances(place)
    }

    /// Instances by columns.
    pub(super) fn draw_instances(&mut self, instances: Instances) -> RiResult {
        let own: Vec<VariableName> = instance_variables(&instances).map(|p| VariableName::of(&p.decl)).collect();
        match &instances.shape {
            InstanceShape::Sphere => {
                let attached = vec![self.attach(&own, &VariableNames::default())];
                self.push(SourceShape::Spheres(instances), vec![], attached)
            }
            InstanceShape::Object(handle) => {
                let handle = handle.clone();
                self.draw_object_instances(instances, &handle)
            }
        }
    }
}

/// Whether points are given as "Pw" with unequal weights.
fn is_rational(params: &Params) -> bool {
    let is_there = |name: &str| params.iter().find(|p| p.decl.name == name);
    is_there("P").is_none()
        && is_there("Pw").is_some_and(|p| p.numbers().chunks_exact(4).any(|q| q[3] != p.numbers()[3]))
}

/// An error if a width of points or curves is below 0.
pub(super) fn check_widths(widths: Option<&Param>) -> RiResult {
    match widths.and_then(|param| param.numbers().iter().find(|width| !(**width >= 0.0))) {
        Some(width) => Err(Fail::new(format!("a width is {width}, expected 0 or more"))),
        None => Ok(()),
    }
}
