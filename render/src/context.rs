//! The renderer's side of the RenderMan Interface: calls become the scene; `WorldEnd` makes the picture.

use crate::bucket::{self, Stats};
use crate::bvh::Bvh;
use crate::camera::Camera;
use crate::filter::FilterKind;
use crate::gprim::{BEZIER, patch_variables, polygon_patches, to_bezier, uniform_numbers};
use crate::image::Image;
use crate::options::{Attributes, Display, Options};
use crate::scene::{Patch, Scene, Shape, Source, SourceShape, sphere_patches};
use glam::{Mat4, Vec3};
use ri::files::Files;
use ri::{Fail, InstanceShape, Instances, Params, Ri, RiResult, Type, Values};
use sl::ir::{Kind, Program};
use sl::machine::BoundShader;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// A finished picture and what it took.
pub struct Finished {
    /// Its number, from `FrameBegin`, or 0.
    pub frame: i32,
    /// The options that it was made with, its displays among them.
    pub options: Options,
    /// The picture, exposed.
    pub image: Image,
    /// What it took.
    pub stats: Stats,
    /// What is odd about the scene.
    pub warnings: Vec<String>,
}

/// The largest picture, pixels along a side.
const LARGEST: i32 = 65_536;

/// Told buckets done and in all.
type Progress = Box<dyn Fn(usize, usize) + Sync + Send>;

/// The renderer's state between calls.
pub struct Context {
    files: Files,
    programs: HashMap<String, Arc<Program>>,
    options: Options,
    saved_options: Option<Options>,
    frame: i32,
    attributes: Attributes,
    attribute_stack: Vec<(Attributes, Mat4)>,
    transform: Mat4,
    transform_stack: Vec<Mat4>,
    to_camera: Option<Mat4>,
    bases: ([f32; 16], [f32; 16]),
    scene: Scene,
    objects: HashMap<String, Arc<Vec<(Shape, Mat4)>>>,
    open_object: Option<(String, Vec<(Shape, Mat4)>, Mat4)>,
    progress: Progress,
    /// Take all calls but make no picture: for checking a scene.
    pub dry: bool,
    /// Pictures that are done, for the caller to take.
    pub finished: Vec<Finished>,
}

/// Evaluates parameter defaults: knows the spaces of the current point of the stream, and has no lights.
struct BindScene<'a> {
    context: &'a Context,
}

impl sl::machine::Scene for BindScene<'_> {
    fn lights(&self) -> &[Arc<BoundShader>] {
        &[]
    }
    fn matrix(&self, from: &str, to: &str) -> Option<[f32; 16]> {
        let to_world = |space: &str| match space {
            "current" | "world" => Some(Mat4::IDENTITY),
            "shader" | "object" => Some(self.context.to_world()),
            "camera" => Some(self.context.to_camera.unwrap_or(Mat4::IDENTITY).inverse()),
            named => self.context.scene.spaces.get(named).copied(),
        };
        Some((to_world(to)?.inverse() * to_world(from)?).to_cols_array())
    }
    fn transmission(&self, _: [f32; 3], _: [f32; 3]) -> [f32; 3] {
        [1.0; 3]
    }
}

impl Context {
    /// A renderer that finds shaders through `files`.
    pub fn new(files: Files) -> Result<Context, Fail> {
        let nothing = Arc::new(BoundShader {
            program: Arc::new(
                sl::compile(Path::new("constant.sl"), "surface constant() { Ci = Os * Cs; }")
                    .map_err(|e| Fail::new(e.to_string()))?,
            ),
            numbers: vec![],
            texts: vec![],
        });
        let attributes = Attributes {
            color: [1.0; 3],
            opacity: [1.0; 3],
            surface: nothing,
            surface_space: Mat4::IDENTITY,
            displacement: None,
            displacement_space: Mat4::IDENTITY,
            displacement_bound: None,
            lights: vec![],
            light_list: Arc::default(),
            shading_rate: 1.0,
            smooth: true,
            two_sided: true,
            reversed: false,
            matte: false,
            visible: true,
            casts_shadows: true,
        };
        let mut context = Context {
            files,
            programs: HashMap::new(),
            options: Options::default(),
            saved_options: None,
            frame: 0,
            attributes,
            attribute_stack: vec![],
            transform: Mat4::IDENTITY,
            transform_stack: vec![],
            to_camera: None,
            bases: (BEZIER, BEZIER),
            scene: Scene::default(),
            objects: HashMap::new(),
            open_object: None,
            progress: Box::new(|_, _| {}),
            dry: false,
            finished: vec![],
        };
        context.attributes.surface = context.shader("defaultsurface", "surface", vec![])?;
        Ok(context)
    }

    /// Be told of buckets done and in all.
    pub fn on_progress(&mut self, progress: impl Fn(usize, usize) + Sync + Send + 'static) {
        self.progress = Box::new(progress);
    }

    /// The names of a shader's parameters.
    pub fn shader_parameters(&mut self, name: &str, kind: &str) -> Result<Vec<String>, Fail> {
        Ok(self.shader(name, kind, vec![])?.program.params.iter().map(|p| p.name.clone()).collect())
    }

    /// Object to world: the current transformation after `WorldBegin`.
    fn to_world(&self) -> Mat4 {
        self.transform
    }

    /// Load, compile and bind a shader.
    fn shader(&mut self, name: &str, kind: &str, params: Params) -> Result<Arc<BoundShader>, Fail> {
        let file = if name.ends_with(".sl") { name.to_string() } else { format!("{name}.sl") };
        let program = match self.programs.get(&file) {
            Some(program) => program.clone(),
            None => {
                let rooms = [format!("shaders/{kind}"), "shaders".into()];
                let rooms: Vec<&str> = rooms.iter().map(String::as_str).collect();
                let (path, source) =
                    self.files.read(&file, &rooms).map_err(|m| Fail::new(format!("{kind} shader {m}")))?;
                let program = sl::compile_with(&path, &source, &|name, from| self.files.include(name, from))
                    .map_err(|d| Fail::new(format!("in shader {d}")))?;
                self.programs.entry(file).or_insert(Arc::new(program)).clone()
            }
        };
        if program.kind.name() != kind {
            return Err(Fail::new(format!("`{name}` is a {} shader, expected a {kind} shader", program.kind.name())));
        }
        let (mut numbers, mut texts) = (Vec::new(), Vec::new());
        for param in params {
            let Some(i) = program.params.iter().position(|p| p.name == param.decl.name) else {
                self.scene.warn(format!("{kind} shader `{name}` has no parameter `{}`", param.decl.name));
                continue;
            };
            let wanted = program.params[i].kind;
            match param.values {
                Values::Strings(v) if wanted == Kind::Text => texts.push((i, v[0].clone())),
                Values::Floats(v) if wanted != Kind::Text => {
                    let array = program.params[i].array;
                    numbers.push((i, self.to_current(wanted, array, &v, &param.decl.name)?))
                }
                _ => {
                    return Err(Fail::new(format!(
                        "parameter `{}` of `{name}` has the wrong type, expected {wanted:?}",
                        param.decl.name
                    )));
                }
            }
        }
        Ok(Arc::new(BoundShader::new(program, numbers, texts, &BindScene { context: self })))
    }

    /// A parameter's numbers in world space; points and directions are given in the current one.
    fn to_current(&self, kind: Kind, array: Option<u16>, v: &[f32], name: &str) -> Result<Vec<f32>, Fail> {
        let width = kind.width() * array.unwrap_or(1) as usize;
        // An array may be given in part.
        if v.len() != width && (array.is_none() || v.len() > width || v.len() % kind.width() != 0) {
            return Err(Fail::new(format!("parameter `{name}` has {} numbers, expected {width}", v.len())));
        }
        let m = self.to_world();
        let normals = glam::Mat3::from_mat4(m).inverse().transpose();
        let mut out = Vec::with_capacity(width);
        for v in v.chunks_exact(kind.width()) {
            match kind {
                Kind::Point => out.extend(m.transform_point3(Vec3::new(v[0], v[1], v[2])).to_array()),
                Kind::Vector => out.extend(m.transform_vector3(Vec3::new(v[0], v[1], v[2])).to_array()),
                Kind::Normal => out.extend((normals * Vec3::new(v[0], v[1], v[2])).to_array()),
                _ => out.extend(v),
            }
        }
        out.resize(width, 0.0);
        Ok(out)
    }

    fn in_world(&self, call: &str) -> RiResult {
        if self.to_camera.is_some() {
            Ok(())
        } else {
            Err(Fail::new(format!("`{call}` stands between WorldBegin and WorldEnd")))
        }
    }

    fn lights_changed(&mut self) {
        self.attributes.light_list = Arc::new(self.attributes.lights.iter().map(|(_, l)| l.clone()).collect());
    }

    fn concat(&mut self, m: Mat4) -> RiResult {
        if !m.is_finite() {
            return Err(Fail::new("the transformation is not finite"));
        }
        self.transform *= m;
        Ok(())
    }

    fn add(&mut self, shape: Shape, uniform: Vec<(String, Vec<f32>)>) -> RiResult {
        if let Some((_, parts, base)) = &mut self.open_object {
            parts.push((shape, base.inverse() * self.transform));
            return Ok(());
        }
        self.push(SourceShape::One(shape), uniform)
    }

    fn push(&mut self, shape: SourceShape, uniform: Vec<(String, Vec<f32>)>) -> RiResult {
        self.in_world("a primitive")?;
        let attributes = Arc::new(self.attributes.clone());
        self.scene.sources.push(Source { shape, to_world: self.transform, attributes, uniform });
        Ok(())
    }
}

fn positive(value: f32, what: &str) -> RiResult {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Fail::new(format!("{what} is {value}, expected a number above 0")))
    }
}

impl Ri for Context {
    fn version(&mut self, _: f32) -> RiResult {
        Ok(())
    }
    fn declare(&mut self, _: &str, _: &str) -> RiResult {
        Ok(())
    }
    fn frame_begin(&mut self, number: i32) -> RiResult {
        self.frame = number;
        self.saved_options = Some(self.options.clone());
        Ok(())
    }
    fn frame_end(&mut self) -> RiResult {
        if let Some(options) = self.saved_options.take() {
            self.options = options;
            self.transform = Mat4::IDENTITY;
            return Ok(());
        }
        Err(Fail::new("FrameEnd without FrameBegin"))
    }
    fn world_begin(&mut self) -> RiResult {
        if self.to_camera.is_some() {
            return Err(Fail::new("WorldBegin within WorldBegin"));
        }
        let to_camera = self.transform;
        if !(to_camera.determinant().abs() > 0.0) {
            return Err(Fail::new("the camera's transformation cannot be inverted"));
        }
        self.to_camera = Some(to_camera);
        self.scene = Scene {
            camera_to_world: to_camera.inverse(),
            warnings: std::mem::take(&mut self.scene.warnings),
            ..Scene::default()
        };
        // Lights and spaces that were set in camera space move to world space with it.
        self.attribute_stack.push((self.attributes.clone(), self.transform));
        self.transform = Mat4::IDENTITY;
        Ok(())
    }
    fn world_end(&mut self) -> RiResult {
        let Some(to_camera) = self.to_camera.take() else { return Err(Fail::new("WorldEnd without WorldBegin")) };
        if self.dry {
            return Ok(());
        }
        self.scene.bvh = Bvh::build(&self.scene);
        let camera = Camera::new(&self.options, to_camera);
        let (mut image, stats) = bucket::render(&self.scene, &self.options, camera, &*self.progress);
        image.expose(self.options.gain, self.options.gamma);
        let warnings = std::mem::take(&mut *self.scene.warnings.lock().unwrap_or_else(|e| e.into_inner()));
        self.finished.push(Finished { frame: self.frame, options: self.options.clone(), image, stats, warnings });
        self.scene = Scene::default();
        self.objects.clear();
        if let Some((attributes, transform)) = self.attribute_stack.pop() {
            self.attributes = attributes;
            self.transform = transform;
        }
        Ok(())
    }
    fn attribute_begin(&mut self) -> RiResult {
        self.attribute_stack.push((self.attributes.clone(), self.transform));
        Ok(())
    }
    fn attribute_end(&mut self) -> RiResult {
        let floor = self.to_camera.is_some() as usize;
        if self.attribute_stack.len() <= floor {
            return Err(Fail::new("AttributeEnd without AttributeBegin"));
        }
        if let Some((attributes, transform)) = self.attribute_stack.pop() {
            self.attributes = attributes;
            self.transform = transform;
        }
        Ok(())
    }
    fn transform_begin(&mut self) -> RiResult {
        self.transform_stack.push(self.transform);
        Ok(())
    }
    fn transform_end(&mut self) -> RiResult {
        self.transform = self.transform_stack.pop().ok_or(Fail::new("TransformEnd without TransformBegin"))?;
        Ok(())
    }
    fn object_begin(&mut self, handle: &str) -> RiResult {
        if self.open_object.is_some() {
            return Err(Fail::new("ObjectBegin within ObjectBegin"));
        }
        self.open_object = Some((handle.into(), vec![], self.transform));
        Ok(())
    }
    fn object_end(&mut self) -> RiResult {
        let (handle, parts, base) = self.open_object.take().ok_or(Fail::new("ObjectEnd without ObjectBegin"))?;
        self.objects.insert(handle, Arc::new(parts));
        self.transform = base;
        Ok(())
    }
    fn object_instance(&mut self, handle: &str) -> RiResult {
        let place = Instances {
            shape: InstanceShape::Object(handle.into()),
            position: vec![[0.0; 3]],
            orientation: vec![],
            scale: vec![],
            params: vec![],
        };
        self.instances(place)
    }
    fn format(&mut self, width: i32, height: i32, aspect: f32) -> RiResult {
        if !(1..=LARGEST).contains(&width) || !(1..=LARGEST).contains(&height) {
            return Err(Fail::new(format!("format {width}×{height}: expected 1 to {LARGEST} pixels along each side")));
        }
        self.options.width = width as usize;
        self.options.height = height as usize;
        self.options.pixel_aspect = if aspect > 0.0 { aspect } else { 1.0 };
        Ok(())
    }
    fn frame_aspect_ratio(&mut self, ratio: f32) -> RiResult {
        positive(ratio, "the frame aspect ratio")?;
        self.options.screen_window =
            Some(if ratio >= 1.0 { [-ratio, ratio, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / ratio, 1.0 / ratio] });
        Ok(())
    }
    fn screen_window(&mut self, left: f32, right: f32, bottom: f32, top: f32) -> RiResult {
        positive(right - left, "the screen window's width")?;
        positive(top - bottom, "the screen window's height")?;
        self.options.screen_window = Some([left, right, bottom, top]);
        Ok(())
    }
    fn projection(&mut self, name: &str, params: Params) -> RiResult {
        match name {
            "perspective" => {
                let fov = params
                    .iter()
                    .find(|p| p.decl.name == "fov")
                    .map_or(90.0, |p| p.numbers().first().copied().unwrap_or(90.0));
                if !(fov > 0.0 && fov < 179.9) {
                    return Err(Fail::new(format!("fov is {fov}, expected an angle between 0 and 179.9 degrees")));
                }
                self.options.fov = Some(fov);
            }
            "orthographic" => self.options.fov = None,
            other => {
                return Err(Fail::new(format!("unknown projection `{other}`, expected perspective or orthographic")));
            }
        }
        // The projection starts the camera's transformation afresh (RISpec 4.1.2).
        self.transform = Mat4::IDENTITY;
        Ok(())
    }
    fn clipping(&mut self, near: f32, far: f32) -> RiResult {
        positive(near, "the near plane")?;
        positive(far - near, "the depth from near to far")?;
        self.options.clipping = [near, far];
        Ok(())
    }
    fn shutter(&mut self, open: f32, close: f32) -> RiResult {
        if open != close {
            self.scene
                .warn("motion blur is not supported yet: the picture is of the moment when the shutter opens".into());
        }
        Ok(())
    }
    fn pixel_samples(&mut self, x: f32, y: f32) -> RiResult {
        for n in [x, y] {
            if !(1.0..=64.0).contains(&n) {
                return Err(Fail::new(format!("{n} samples along a pixel, expected 1 to 64")));
            }
        }
        self.options.samples = [x as usize, y as usize];
        Ok(())
    }
    fn pixel_filter(&mut self, name: &str, x_width: f32, y_width: f32) -> RiResult {
        self.options.filter = FilterKind::of_name(name).ok_or(Fail::new(format!(
            "unknown filter `{name}`, expected box, triangle, gaussian, catmull-rom, sinc or mitchell"
        )))?;
        for width in [x_width, y_width] {
            if !(1.0..=16.0).contains(&width) {
                return Err(Fail::new(format!("filter width {width}, expected 1 to 16 pixels")));
            }
        }
        self.options.filter_width = [x_width, y_width];
        Ok(())
    }
    fn exposure(&mut self, gain: f32, gamma: f32) -> RiResult {
        positive(gain, "the gain")?;
        positive(gamma, "gamma")?;
        (self.options.gain, self.options.gamma) = (gain, gamma);
        Ok(())
    }
    fn imager(&mut self, name: &str, params: Params) -> RiResult {
        if name != "background" {
            return Err(Fail::new(format!("imager `{name}` is not supported yet; `background` is")));
        }
        let color = params
            .iter()
            .find(|p| matches!(p.decl.name.as_str(), "bgcolor" | "background") && p.decl.ty == Type::Color);
        self.options.background = Some(color.map_or([0.0; 3], |p| [p.numbers()[0], p.numbers()[1], p.numbers()[2]]));
        Ok(())
    }
    fn quantize(&mut self, kind: &str, one: i32, _: i32, _: i32, dither: f32) -> RiResult {
        if kind.starts_with("rgb") {
            (self.options.quantize_one, self.options.dither) = (one, dither);
        }
        Ok(())
    }
    fn display(&mut self, name: &str, kind: &str, mode: &str, _: Params) -> RiResult {
        if !matches!(mode, "rgb" | "rgba") {
            return Err(Fail::new(format!("display mode `{mode}` is not supported yet, expected rgb or rgba")));
        }
        let display = Display { name: name.trim_start_matches('+').into(), kind: kind.into(), mode: mode.into() };
        if !name.starts_with('+') {
            self.options.displays.clear();
        }
        self.options.displays.push(display);
        Ok(())
    }
    fn hider(&mut self, name: &str, _: Params) -> RiResult {
        if name == "hidden" { Ok(()) } else { Err(Fail::new(format!("hider `{name}` is not supported yet"))) }
    }
    fn option(&mut self, name: &str, params: Params) -> RiResult {
        if name == "limits"
            && let Some(size) = params.iter().find(|p| p.decl.name == "bucketsize").and_then(|p| p.numbers().first())
        {
            self.options.bucket_size = (*size as usize).clamp(8, 512);
        }
        Ok(())
    }
    fn attribute(&mut self, name: &str, params: Params) -> RiResult {
        for param in &params {
            let number = param.numbers().first().copied();
            match (name, param.decl.name.as_str(), number) {
                ("displacementbound", "sphere", Some(bound)) => {
                    self.attributes.displacement_bound = Some(bound.max(0.0))
                }
                ("visibility", "camera", Some(on)) => self.attributes.visible = on != 0.0,
                ("visibility", "transmission", Some(on)) => self.attributes.casts_shadows = on != 0.0,
                ("visibility", "transmission", None) => {
                    self.attributes.casts_shadows = param.text() != Some("transparent")
                }
                _ => {}
            }
        }
        Ok(())
    }
    fn color(&mut self, color: [f32; 3]) -> RiResult {
        self.attributes.color = color;
        Ok(())
    }
    fn opacity(&mut self, opacity: [f32; 3]) -> RiResult {
        self.attributes.opacity = opacity;
        Ok(())
    }
    fn light_source(&mut self, name: &str, handle: &str, params: Params) -> RiResult {
        self.in_world("LightSource")?;
        let light = self.shader(name, "light", params)?;
        self.attributes.lights.retain(|(h, _)| h != handle);
        self.attributes.lights.push((handle.into(), light));
        self.lights_changed();
        Ok(())
    }
    fn illuminate(&mut self, handle: &str, on: bool) -> RiResult {
        let known = |lights: &[(String, Arc<BoundShader>)]| lights.iter().find(|(h, _)| h == handle).cloned();
        let light = known(&self.attributes.lights)
            .or_else(|| self.attribute_stack.iter().rev().find_map(|(a, _)| known(&a.lights)));
        let Some(light) = light else { return Err(Fail::new(format!("there is no light `{handle}`"))) };
        self.attributes.lights.retain(|(h, _)| h != handle);
        if on {
            self.attributes.lights.push(light);
        }
        self.lights_changed();
        Ok(())
    }
    fn surface(&mut self, name: &str, params: Params) -> RiResult {
        self.attributes.surface = self.shader(name, "surface", params)?;
        self.attributes.surface_space = self.transform;
        Ok(())
    }
    fn displacement(&mut self, name: &str, params: Params) -> RiResult {
        self.attributes.displacement =
            if name == "null" { None } else { Some(self.shader(name, "displacement", params)?) };
        self.attributes.displacement_space = self.transform;
        Ok(())
    }
    fn shading_rate(&mut self, size: f32) -> RiResult {
        positive(size, "the shading rate")?;
        self.attributes.shading_rate = size.max(1e-3);
        Ok(())
    }
    fn shading_interpolation(&mut self, kind: &str) -> RiResult {
        self.attributes.smooth = match kind {
            "smooth" => true,
            "constant" => false,
            other => return Err(Fail::new(format!("unknown interpolation `{other}`, expected constant or smooth"))),
        };
        Ok(())
    }
    fn matte(&mut self, on: bool) -> RiResult {
        self.attributes.matte = on;
        Ok(())
    }
    fn bound(&mut self, _: [f32; 6]) -> RiResult {
        Ok(())
    }
    fn orientation(&mut self, kind: &str) -> RiResult {
        self.attributes.reversed = match kind {
            "outside" | "lh" => false,
            "inside" | "rh" => true,
            other => {
                return Err(Fail::new(format!("unknown orientation `{other}`, expected outside, inside, lh or rh")));
            }
        };
        Ok(())
    }
    fn reverse_orientation(&mut self) -> RiResult {
        self.attributes.reversed = !self.attributes.reversed;
        Ok(())
    }
    fn sides(&mut self, sides: i32) -> RiResult {
        if !matches!(sides, 1 | 2) {
            return Err(Fail::new(format!("sides is {sides}, expected 1 or 2")));
        }
        self.attributes.two_sided = sides == 2;
        Ok(())
    }
    fn identity(&mut self) -> RiResult {
        self.transform = Mat4::IDENTITY;
        Ok(())
    }
    fn transform(&mut self, matrix: [f32; 16]) -> RiResult {
        self.transform = Mat4::IDENTITY;
        self.concat(Mat4::from_cols_array(&matrix))
    }
    fn concat_transform(&mut self, matrix: [f32; 16]) -> RiResult {
        self.concat(Mat4::from_cols_array(&matrix))
    }
    fn translate(&mut self, by: [f32; 3]) -> RiResult {
        self.concat(Mat4::from_translation(by.into()))
    }
    fn rotate(&mut self, angle: f32, axis: [f32; 3]) -> RiResult {
        let axis = Vec3::from(axis).try_normalize().ok_or(Fail::new("the axis of a rotation is zero"))?;
        self.concat(Mat4::from_axis_angle(axis, angle.to_radians()))
    }
    fn scale(&mut self, by: [f32; 3]) -> RiResult {
        self.concat(Mat4::from_scale(by.into()))
    }
    fn coordinate_system(&mut self, name: &str) -> RiResult {
        self.scene.spaces.insert(name.into(), self.to_world());
        Ok(())
    }
    fn coord_sys_transform(&mut self, name: &str) -> RiResult {
        self.transform =
            *self.scene.spaces.get(name).ok_or(Fail::new(format!("there is no coordinate system `{name}`")))?;
        Ok(())
    }
    fn polygon(&mut self, params: Params) -> RiResult {
        let n = params.iter().find(|p| p.decl.name == "P").map_or(0, |p| p.numbers().len() / 3);
        if n < 3 {
            return Err(Fail::new(format!("a polygon has {n} vertices in \"P\", expected at least 3")));
        }
        let patches = polygon_patches(&(0..n).collect::<Vec<_>>(), &params, 0)?;
        self.add(Shape::Patches(Arc::new(patches)), vec![])
    }
    fn points_polygons(&mut self, n_vertices: Vec<i32>, vertices: Vec<i32>, params: Params) -> RiResult {
        let mut patches = Vec::new();
        let mut rest = vertices.as_slice();
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
            patches.extend(polygon_patches(&corners, &params, face)?);
        }
        // Faces are primitives of their own, so that each can be found hidden by itself.
        patches.into_iter().try_for_each(|patch| self.add(Shape::Patches(Arc::new(vec![patch])), vec![]))
    }
    fn basis(&mut self, u: [f32; 16], _: i32, v: [f32; 16], _: i32) -> RiResult {
        self.bases = (u, v);
        Ok(())
    }
    fn patch(&mut self, kind: &str, params: Params) -> RiResult {
        let p = params.iter().find(|p| p.decl.name == "P").ok_or(Fail::new("a patch needs \"P\""))?.numbers();
        let points: Vec<Vec3> = p.chunks_exact(3).map(|c| Vec3::new(c[0], c[1], c[2])).collect();
        if points.iter().any(|p| !p.is_finite()) {
            return Err(Fail::new("a patch has a point that is not a finite number"));
        }
        let wrong = |n: usize| Fail::new(format!("a {kind} patch has {} points, expected {n}", points.len()));
        let mut patch = match kind {
            "bilinear" => Patch::bilinear(points.clone().try_into().map_err(|_| wrong(4))?),
            "bicubic" => {
                let mut patch = Patch::bilinear([Vec3::ZERO; 4]);
                patch.flat = false;
                patch.p = to_bezier(points.clone().try_into().map_err(|_| wrong(16))?, &self.bases);
                patch
            }
            other => return Err(Fail::new(format!("unknown patch type `{other}`, expected bilinear or bicubic"))),
        };
        patch_variables(&mut patch, &params, [0, 1, 2, 3], 0)?;
        self.add(Shape::Patches(Arc::new(vec![patch])), vec![])
    }
    fn sphere(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        if !(radius != 0.0 && radius.is_finite() && z_min.is_finite() && z_max.is_finite() && sweep.is_finite()) {
            return Err(Fail::new(format!(
                "a sphere of radius {radius} from {z_min} to {z_max} over {sweep}° cannot be drawn"
            )));
        }
        let uniform = uniform_numbers(params)?;
        let r = radius.abs();
        if z_min <= -r && z_max >= r && sweep.abs() >= 360.0 {
            let outer = self.transform;
            self.transform *= Mat4::from_scale(Vec3::splat(r));
            let done = if self.open_object.is_some() {
                self.add(Shape::Sphere, uniform)
            } else {
                // As an instance array of one, so that object space keeps its unit.
                self.transform = outer;
                let one = Instances {
                    shape: InstanceShape::Sphere,
                    position: vec![[0.0; 3]],
                    orientation: vec![],
                    scale: vec![[r; 3]],
                    params: vec![],
                };
                self.push(SourceShape::Spheres(one), uniform)
            };
            self.transform = outer;
            return done;
        }
        self.add(Shape::Patches(Arc::new(sphere_patches(r, z_min, z_max, sweep))), uniform)
    }
    fn instances(&mut self, instances: Instances) -> RiResult {
        let shape = match &instances.shape {
            InstanceShape::Sphere => SourceShape::Spheres(instances),
            InstanceShape::Object(handle) => {
                let parts =
                    self.objects.get(handle).cloned().ok_or(Fail::new(format!("there is no object `{handle}`")))?;
                SourceShape::Objects(instances, parts)
            }
        };
        self.push(shape, vec![])
    }
    fn archive_record(&mut self, _: &str, _: &str) -> RiResult {
        Ok(())
    }
}
