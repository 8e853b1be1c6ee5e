//! The renderer's side of the RenderMan Interface: calls become the scene; `WorldEnd` makes the picture.

mod moving;
mod primitives;
mod shaders;

use self::moving::{Keys, MotionBlock, Moving, Place};
use crate::cpu::render::render;
use crate::film::bucket::Shard;
use crate::film::display::Display;
use crate::film::filter::FilterKind;
use crate::film::image::Image;
use crate::gprim::blobby::Field;
use crate::gprim::surfaces::{self, Profile};
use crate::gprim::trim::trim;
use crate::gprim::variables::{BEZIER, dress};
use crate::scene::area::{self, Area, AreaLight};
use crate::scene::attributes::Attributes;
use crate::scene::camera::Camera;
use crate::scene::emitters;
use crate::scene::motion;
use crate::scene::options::{Hider, Options};
use crate::scene::patch::Patch;
use crate::scene::shape::Shape;
use crate::scene::source::{Source, SourceShape};
use crate::scene::trim::Trim;
use crate::scene::world::Scene;
use crate::stats::Stats;
use crate::texture::{self, Textures, Wrap};
use glam::{Mat4, Vec3};
use ri::files::Files;
use ri::{Fail, InstanceShape, Instances, Knots, Params, Ri, RiResult, Tags, TrimCurves, Values};
use sl::ir::{Kind, Program};
use sl::machine::{Answer, BoundShader};
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

/// The most pixels of a picture: it is held whole, 16 bytes each.
const MOST_PIXELS: i64 = 1 << 28;

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
    attribute_stack: Vec<(Attributes, Place)>,
    /// The current transformation, as the shutter opens.
    transform: Mat4,
    /// Its keys over time, by the time of motion blocks; none if it stands still.
    moves: Keys,
    transform_stack: Vec<Place>,
    to_camera: Option<Mat4>,
    camera_moves: Keys,
    bases: ([f32; 16], [f32; 16]),
    /// Lights that were made, on or off, by their handles.
    known_lights: Vec<(String, Arc<BoundShader>)>,
    /// Types of variables that `Declare` gave.
    declared: HashMap<String, Kind>,
    steps: [usize; 2],
    trim: Option<Arc<Trim>>,
    motion: Option<MotionBlock>,
    made: texture::Made,
    scene: Scene,
    objects: HashMap<String, Arc<Vec<(Shape, Mat4)>>>,
    open_object: Option<(String, Vec<(Shape, Mat4)>, Mat4)>,
    progress: Progress,
    /// The share of each picture's buckets that is drawn.
    pub share: Option<Shard>,
    /// What is written into the pictures' files, by key.
    pub about: Vec<(String, String)>,
    /// Take all calls but make no picture: for checking a scene.
    pub dry: bool,
    /// Pictures that are done, for the caller to take.
    pub finished: Vec<Finished>,
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
            atmosphere: None,
            atmosphere_space: Mat4::IDENTITY,
            user: Arc::default(),
            texture_corners: [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0],
            lights: vec![],
            light_list: Arc::default(),
            emitters: Arc::default(),
            area_light: None,
            light_samples: area::SAMPLES,
            shading_rate: 1.0,
            smooth: true,
            two_sided: true,
            reversed: false,
            matte: false,
            visible: true,
            casts_shadows: true,
            whole_shadows: false,
            detail: f32::INFINITY,
            detail_range: [0.0, 0.0, f32::INFINITY, f32::INFINITY],
            level: 1.0,
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
            moves: vec![],
            transform_stack: vec![],
            to_camera: None,
            camera_moves: vec![],
            bases: (BEZIER, BEZIER),
            known_lights: vec![],
            declared: HashMap::new(),
            steps: [3, 3],
            trim: None,
            motion: None,
            made: HashMap::new(),
            scene: Scene::default(),
            objects: HashMap::new(),
            open_object: None,
            progress: Box::new(|_, _| {}),
            share: None,
            about: vec![],
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

    /// What is odd about what was read so far.
    pub fn warnings(&self) -> Vec<String> {
        self.scene.warnings.list()
    }

    /// Object to world: the current transformation after `WorldBegin`.
    fn to_world(&self) -> Mat4 {
        self.transform
    }

    /// Back to what held before `WorldBegin`; options and warnings stay.
    fn leave_world(&mut self) -> RiResult {
        self.scene = Scene {
            options: std::mem::take(&mut self.scene.options),
            warnings: std::mem::take(&mut self.scene.warnings),
            ..Scene::default()
        };
        self.objects.clear();
        if let Some((attributes, place)) = self.attribute_stack.pop() {
            self.attributes = attributes;
            (self.transform, self.moves) = place;
        }
        Ok(())
    }

    /// When the shutter opens and closes; what blurs nothing opens it for no time.
    fn open_shutter(&self) -> [f32; 2] {
        let [open, close] = self.options.shutter;
        if self.options.hider == Hider::Depth { [open, open] } else { [open, close] }
    }

    fn in_world(&self, call: &str) -> RiResult {
        if self.to_camera.is_some() {
            Ok(())
        } else {
            Err(Fail::new(format!("`{call}` stands between WorldBegin and WorldEnd")))
        }
    }

    /// How much of the current level of detail is seen: 0 out of its range, 1 in its middle, in between in a transition (RISpec
    /// 5.6).
    fn level_changed(&mut self) {
        let ([least, lower, upper, most], detail) = (self.attributes.detail_range, self.attributes.detail);
        self.attributes.level = match detail {
            d if d < least || d > most => 0.0,
            d if d < lower => (d - least) / (lower - least),
            d if d > upper => (most - d) / (most - upper),
            _ => 1.0,
        };
    }

    fn lights_changed(&mut self) {
        self.attributes.light_list = Arc::new(self.attributes.lights.iter().map(|(_, l)| l.clone()).collect());
    }

    fn concat(&mut self, m: Mat4) -> RiResult {
        if !m.is_finite() {
            return Err(Fail::new("the transformation is not finite"));
        }
        if let Some(block) = &mut self.motion {
            block.calls.push(Moving::Concat(m));
            return Ok(());
        }
        self.transform *= m;
        self.moves.iter_mut().for_each(|(_, key)| *key *= m);
        Ok(())
    }

    /// Add patches, each a primitive of its own, so that each can be found hidden by itself.
    fn add_patches(&mut self, patches: Vec<Patch>) -> RiResult {
        if let Some(block) = &mut self.motion {
            block.calls.push(Moving::Patches(patches));
            return Ok(());
        }
        if patches.iter().any(|p| p.p.iter().any(|p| !p.is_finite())) {
            return Err(Fail::new("the primitive has a point that is not a finite number"));
        }
        let corners = self.attributes.texture_corners;
        for mut patch in patches {
            patch.trim.clone_from(&self.trim);
            if patch.st == patch.uv && corners != [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0] {
                let at = |axis: usize, [u, v]: [f32; 2]| {
                    let c = |k: usize| corners[2 * k + axis];
                    (c(0) * (1.0 - u) + c(1) * u) * (1.0 - v) + (c(2) * (1.0 - u) + c(3) * u) * v
                };
                patch.st = patch.uv.map(|uv| [at(0, uv), at(1, uv)]);
            }
            self.add(Shape::Patches(Arc::new(vec![patch])), vec![])?;
        }
        Ok(())
    }

    /// A quadric: a profile, swept.
    fn quadric(&mut self, profile: Vec<Profile>, sweep: f32, params: Params) -> RiResult {
        let sound = |p: &Profile| p.0.iter().all(|q| q.is_finite());
        if !(sweep.is_finite() && sweep != 0.0 && profile.iter().all(sound)) {
            return Err(Fail::new("the quadric's numbers make no surface"));
        }
        let mut patches = surfaces::revolve(&profile, sweep.clamp(-360.0, 360.0));
        dress(&mut patches, &params)?;
        self.add_patches(patches)
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
        if self.attributes.level <= 0.0 {
            return Ok(());
        }
        let mut attributes = self.attributes.clone();
        attributes.opacity = attributes.opacity.map(|o| o * attributes.level);
        if let Some(light) = attributes.area_light {
            // What shines does not stand in its own way.
            attributes.casts_shadows = false;
            let (area, to_world) = (&mut self.scene.area_lights[light].area, self.transform);
            match &shape {
                SourceShape::One(shape) => area.add(shape, to_world, attributes.reversed),
                SourceShape::Spheres(columns) => (0..columns.len())
                    .for_each(|i| area.add(&Shape::Sphere, to_world * columns.matrix(i), attributes.reversed)),
                SourceShape::Objects(columns, parts) => (0..columns.len()).for_each(|i| {
                    let place = to_world * columns.matrix(i);
                    parts.iter().for_each(|(shape, own)| area.add(shape, place * *own, attributes.reversed));
                }),
            }
        }
        let attributes = Arc::new(attributes);
        let shutter = self.open_shutter();
        let (to_world, moves) =
            if self.moves.is_empty() { (self.transform, vec![]) } else { motion::in_shutter(&self.moves, shutter) };
        let mut shape = shape;
        if let SourceShape::Spheres(columns) | SourceShape::Objects(columns, _) = &mut shape
            && let Some(([a, b], to)) = columns.moved.take()
        {
            let keys =
                columns.position.iter().zip(to).map(|(from, to)| motion::in_shutter(&[(a, *from), (b, to)], shutter));
            let (position, later): (Vec<_>, Vec<_>) = keys.unzip();
            columns.position = position;
            let closing = later.into_iter().filter_map(|keys| keys.last().map(|(_, p)| *p)).collect::<Vec<_>>();
            columns.moved = (closing.len() == columns.position.len()).then_some(([0.0, 1.0], closing));
        }
        self.scene.sources.push(Source { shape, to_world, moves, attributes, uniform });
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
    fn declare(&mut self, name: &str, declaration: &str) -> RiResult {
        let kinds = [Kind::Float, Kind::Color, Kind::Point, Kind::Vector, Kind::Normal];
        let kind = kinds.into_iter().find(|k| declaration.split_whitespace().any(|word| word == k.name()));
        kind.map(|kind| self.declared.insert(name.into(), kind));
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
            (self.transform, self.moves) = (Mat4::IDENTITY, vec![]);
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
            spaces: std::mem::take(&mut self.scene.spaces),
            options: std::mem::take(&mut self.scene.options),
            clipping: self.options.clipping,
            textures: Textures::new(self.files.folders.clone(), self.made.clone(), self.options.texture_memory),
            ..Scene::default()
        };
        // Spaces that were set before are in camera space.
        self.scene.spaces.values_mut().for_each(|m| *m = to_camera.inverse() * *m);
        let camera = Camera::new(&self.options, to_camera, vec![]);
        let spaces = camera.picture_spaces(&self.options).map(|(name, from_world)| (name.into(), from_world.inverse()));
        self.scene.spaces.extend(spaces);
        self.attribute_stack.push((self.attributes.clone(), self.place()));
        self.camera_moves = std::mem::take(&mut self.moves);
        self.transform = Mat4::IDENTITY;
        Ok(())
    }
    fn world_end(&mut self) -> RiResult {
        let Some(to_camera) = self.to_camera.take() else { return Err(Fail::new("WorldEnd without WorldBegin")) };
        if self.dry {
            return Ok(());
        }
        if self.options.displays.is_empty() && self.options.passed_over {
            return self.leave_world();
        }
        emitters::expand(&mut self.scene);
        if self.options.hider == Hider::Null {
            let options = Options { displays: vec![], passed_over: true, ..self.options.clone() };
            let items = self.scene.sources.iter().map(|s| s.len() as u64).sum();
            let stats = Stats { items, ..Stats::default() };
            let warnings = self.scene.take_warnings();
            let image = Image::new(0, 0, vec![]);
            self.finished.push(Finished { frame: self.frame, options, image, stats, warnings });
            return self.leave_world();
        }
        let moves = match self.camera_moves.as_slice() {
            [] => vec![],
            keys => motion::in_shutter(keys, self.open_shutter()).1,
        };
        if self.options.hider == Hider::Depth {
            self.options.samples = [1, 1];
            (self.options.filter, self.options.filter_width) = (FilterKind::Box, [1.0; 2]);
            self.options.lens = None;
        }
        let camera = Camera::new(&self.options, to_camera, moves);
        self.options.share = self.share;
        self.options.about.clone_from(&self.about);
        let (mut image, stats) = render(&self.scene, &self.options, camera, &*self.progress);
        image.expose(self.options.gain, self.options.gamma);
        let warnings = self.scene.take_warnings();
        self.finished.push(Finished { frame: self.frame, options: self.options.clone(), image, stats, warnings });
        self.leave_world()
    }
    fn attribute_begin(&mut self) -> RiResult {
        self.attribute_stack.push((self.attributes.clone(), self.place()));
        Ok(())
    }
    fn attribute_end(&mut self) -> RiResult {
        let floor = self.to_camera.is_some() as usize;
        if self.attribute_stack.len() <= floor {
            return Err(Fail::new("AttributeEnd without AttributeBegin"));
        }
        if let Some((attributes, place)) = self.attribute_stack.pop() {
            self.attributes = attributes;
            (self.transform, self.moves) = place;
        }
        Ok(())
    }
    fn transform_begin(&mut self) -> RiResult {
        self.transform_stack.push(self.place());
        Ok(())
    }
    fn transform_end(&mut self) -> RiResult {
        (self.transform, self.moves) =
            self.transform_stack.pop().ok_or(Fail::new("TransformEnd without TransformBegin"))?;
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
            moved: None,
        };
        self.instances(place)
    }
    fn format(&mut self, width: i32, height: i32, aspect: f32) -> RiResult {
        if !(1..=LARGEST).contains(&width) || !(1..=LARGEST).contains(&height) {
            return Err(Fail::new(format!("format {width}×{height}: expected 1 to {LARGEST} pixels along each side")));
        }
        if width as i64 * height as i64 > MOST_PIXELS {
            let most = MOST_PIXELS / 1_000_000;
            return Err(Fail::new(format!("format {width}×{height}: expected at most {most} million pixels")));
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
        (self.transform, self.moves) = (Mat4::IDENTITY, vec![]);
        Ok(())
    }
    fn clipping(&mut self, near: f32, far: f32) -> RiResult {
        positive(near, "the near plane")?;
        positive(far - near, "the depth from near to far")?;
        self.options.clipping = [near, far];
        Ok(())
    }
    fn shutter(&mut self, open: f32, close: f32) -> RiResult {
        if !(close >= open && open.is_finite() && close.is_finite()) {
            return Err(Fail::new(format!("the shutter opens at {open} and closes at {close}, expected rising times")));
        }
        self.options.shutter = [open, close];
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
        self.options.imager = if name == "null" { None } else { Some(self.shader(name, "imager", params)?) };
        Ok(())
    }
    fn quantize(&mut self, kind: &str, one: i32, _: i32, _: i32, dither: f32) -> RiResult {
        if kind.starts_with("rgb") {
            (self.options.quantize_one, self.options.dither) = (one, dither);
        }
        Ok(())
    }
    fn display(&mut self, name: &str, kind: &str, mode: &str, params: Params) -> RiResult {
        let further = name.starts_with('+');
        let name = name.trim_start_matches('+');
        if !further {
            self.options.displays.clear();
            self.options.passed_over = false;
        }
        let passed_over = match kind {
            "zfile" | "shadow" | "deepshad" => {
                Some(format!("the shadow map `{name}` is not made: shadows are traced, whatever map a light names"))
            }
            "framebuffer" | "it" | "x11" | "windows" if further => {
                Some(format!("`{name}` is not shown: there is no window"))
            }
            _ => None,
        };
        if let Some(message) = passed_over {
            self.scene.warn(message);
            self.options.passed_over = true;
            return Ok(());
        }
        let depth = params.iter().find(|p| matches!(p.decl.name.as_str(), "type" | "exrpixeltype"));
        let half = match depth.map(|p| p.text()) {
            None | Some(Some("float")) => false,
            Some(Some("half")) => true,
            _ => return Err(Fail::new("the display's numbers: expected \"string type\" \"half\" or \"float\"")),
        };
        let mode = Display::with_type(mode, &self.declared).map_err(Fail::new)?;
        let display = Display { name: name.into(), kind: kind.into(), mode, half };
        if display.format() != "exr" && self.options.displays.iter().any(|d| d.name == name) {
            return Err(Fail::new(format!("two displays are named `{name}`: only EXR files have layers")));
        }
        self.options.displays.push(display);
        Ok(())
    }
    fn hider(&mut self, name: &str, _: Params) -> RiResult {
        self.options.hider = match name {
            "hidden" => Hider::Hidden,
            "z" | "zbuffer" | "depth" => Hider::Depth,
            "null" => Hider::Null,
            _ => {
                self.scene.warn(format!("hider `{name}` is not known, expected hidden, z or null: `hidden` is taken"));
                Hider::Hidden
            }
        };
        Ok(())
    }
    fn option(&mut self, name: &str, params: Params) -> RiResult {
        if name == "limits"
            && let Some(size) = params.iter().find(|p| p.decl.name == "bucketsize").and_then(|p| p.numbers().first())
        {
            self.options.bucket_size = (*size as usize).clamp(8, 512);
        }
        if name == "limits"
            && let Some(kib) = params.iter().find(|p| p.decl.name == "texturememory").and_then(|p| p.numbers().first())
        {
            positive(*kib, "the texture memory")?;
            self.options.texture_memory = (*kib as usize).saturating_mul(1024);
        }
        if name == "searchpath" {
            // Folders, separated by colons; `&` and `@` stand for what is searched anyway.
            for text in params.iter().filter_map(|p| p.text()) {
                for folder in text.split(':').filter(|f| !matches!(*f, "" | "&" | "@")) {
                    let known: Vec<_> = self.files.folders.clone();
                    for base in &known {
                        let place = base.join(folder);
                        if place.is_dir() && !self.files.folders.contains(&place) {
                            self.files.folders.push(place);
                        }
                    }
                }
            }
        }
        for param in params {
            let answer = match param.values {
                Values::Floats(v) => Answer::Numbers(v),
                Values::Strings(v) => Answer::Text(v.first().cloned().unwrap_or_default()),
            };
            for key in [format!("{name}:{}", param.decl.name), param.decl.name.clone()] {
                self.scene.options.retain(|(n, _)| *n != key);
                self.scene.options.push((key, answer.clone()));
            }
        }
        Ok(())
    }
    fn attribute(&mut self, name: &str, params: Params) -> RiResult {
        for param in &params {
            let answer = match &param.values {
                Values::Floats(v) => Answer::Numbers(v.clone()),
                Values::Strings(v) => Answer::Text(v.first().cloned().unwrap_or_default()),
            };
            let key = format!("{name}:{}", param.decl.name);
            let user = Arc::make_mut(&mut self.attributes.user);
            user.retain(|(n, _)| *n != key);
            user.push((key, answer));
            let number = param.numbers().first().copied();
            match (name, param.decl.name.as_str(), number) {
                ("displacementbound", "sphere", Some(bound)) => {
                    self.attributes.displacement_bound = Some(bound.max(0.0))
                }
                ("light", "nsamples", Some(n)) => {
                    if !(1.0..=4096.0).contains(&n) {
                        return Err(Fail::new(format!("an area light of {n} samples, expected 1 to 4096")));
                    }
                    self.attributes.light_samples = n as usize;
                }
                ("visibility", "camera", Some(on)) => self.attributes.visible = on != 0.0,
                ("visibility", "transmission", Some(on)) => self.attributes.casts_shadows = on != 0.0,
                ("visibility", "transmission", None) => {
                    self.attributes.casts_shadows = param.text() != Some("transparent");
                    self.attributes.whole_shadows = param.text() == Some("opaque");
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
        let light = self.shader(name, "light", params)?;
        self.attributes.lights.retain(|(h, _)| h != handle);
        self.attributes.lights.push((handle.into(), light.clone()));
        self.known_lights.retain(|(h, _)| h != handle);
        self.known_lights.push((handle.into(), light));
        self.lights_changed();
        Ok(())
    }
    fn illuminate(&mut self, handle: &str, on: bool) -> RiResult {
        let known = |lights: &[(String, Arc<BoundShader>)]| lights.iter().find(|(h, _)| h == handle).cloned();
        let light = known(&self.known_lights);
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
    fn area_light_source(&mut self, name: &str, handle: &str, params: Params) -> RiResult {
        self.in_world("AreaLightSource")?;
        self.light_source(name, handle, params)?;
        if let Some((_, shader)) = self.known_lights.iter().find(|(h, _)| h == handle) {
            let samples = self.attributes.light_samples;
            self.attributes.area_light = Some(self.scene.area_lights.len());
            self.scene.area_lights.push(AreaLight { shader: shader.clone(), samples, area: Area::default() });
        }
        Ok(())
    }
    fn atmosphere(&mut self, name: &str, params: Params) -> RiResult {
        self.attributes.atmosphere =
            if name == "null" || name.is_empty() { None } else { Some(self.shader(name, "volume", params)?) };
        self.attributes.atmosphere_space = self.transform;
        Ok(())
    }
    fn interior(&mut self, name: &str, _: Params) -> RiResult {
        self.scene.warn(format!("interior shader `{name}` is passed over: no ray goes through surfaces yet"));
        Ok(())
    }
    fn exterior(&mut self, name: &str, _: Params) -> RiResult {
        self.scene.warn(format!("exterior shader `{name}` is passed over: no ray goes through surfaces yet"));
        Ok(())
    }
    fn solid_begin(&mut self, operation: &str) -> RiResult {
        if !matches!(operation, "primitive" | "union") {
            self.scene.warn(format!("solid `{operation}` is drawn as a union"));
        }
        self.attribute_begin()
    }
    fn solid_end(&mut self) -> RiResult {
        self.attribute_end()
    }
    fn motion_begin(&mut self, times: Vec<f32>) -> RiResult {
        if self.motion.is_some() {
            return Err(Fail::new("MotionBegin within MotionBegin"));
        }
        if times.windows(2).any(|t| !(t[0] < t[1])) {
            return Err(Fail::new("the times of a motion block must rise"));
        }
        self.motion = Some(MotionBlock { times, calls: vec![] });
        Ok(())
    }
    fn motion_end(&mut self) -> RiResult {
        let block = self.motion.take().ok_or(Fail::new("MotionEnd without MotionBegin"))?;
        self.close(block)
    }
    fn crop_window(&mut self, x_min: f32, x_max: f32, y_min: f32, y_max: f32) -> RiResult {
        positive(x_max - x_min, "the crop window's width")?;
        positive(y_max - y_min, "the crop window's height")?;
        self.options.crop = [x_min, x_max, y_min, y_max];
        Ok(())
    }
    fn depth_of_field(&mut self, f_stop: f32, length: f32, distance: f32) -> RiResult {
        self.options.lens = None;
        if f_stop.is_finite() {
            positive(f_stop, "the f-stop")?;
            positive(length, "the focal length")?;
            positive(distance, "the focal distance")?;
            self.options.lens = Some([f_stop, length, distance]);
        }
        Ok(())
    }
    fn detail(&self, [x0, x1, y0, y1, z0, z1]: [f32; 6]) -> f32 {
        let Some(to_camera) = self.to_camera else { return f32::INFINITY };
        let camera = Camera::new(&self.options, to_camera, vec![]);
        let m = to_camera * self.transform;
        let corners = (0..8).map(|k| {
            let pick = |bit: usize, a: f32, b: f32| if k >> bit & 1 == 0 { a } else { b };
            m.transform_point3(Vec3::new(pick(0, x0, x1), pick(1, y0, y1), pick(2, z0, z1)))
        });
        let (min, max) = corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)));
        camera.bound(min, max).map_or(0.0, |b| (b.max.x - b.min.x) * (b.max.y - b.min.y)) * self.options.relative_detail
    }
    fn detail_bound(&mut self, bound: [f32; 6]) -> RiResult {
        self.attributes.detail = self.detail(bound);
        self.level_changed();
        Ok(())
    }
    fn detail_range(&mut self, range: [f32; 4]) -> RiResult {
        if range.windows(2).any(|r| !(r[0] <= r[1])) {
            return Err(Fail::new(format!("DetailRange {range:?}: expected four numbers that do not fall")));
        }
        self.attributes.detail_range = range;
        self.level_changed();
        Ok(())
    }
    fn relative_detail(&mut self, factor: f32) -> RiResult {
        positive(factor, "the relative detail")?;
        self.options.relative_detail = factor;
        Ok(())
    }
    fn geometric_approximation(&mut self, _: &str, _: f32) -> RiResult {
        Ok(())
    }
    fn texture_coordinates(&mut self, corners: [f32; 8]) -> RiResult {
        self.attributes.texture_corners = corners;
        Ok(())
    }
    fn color_samples(&mut self, to_rgb: Vec<f32>, from_rgb: Vec<f32>) -> RiResult {
        if to_rgb.len() != from_rgb.len() || to_rgb.is_empty() || !to_rgb.len().is_multiple_of(3) {
            return Err(Fail::new("ColorSamples takes two lists of three numbers a sample"));
        }
        if to_rgb.len() != 9 {
            return Err(Fail::new(format!("colours of {} samples are not supported: three are", to_rgb.len() / 3)));
        }
        Ok(())
    }
    fn pixel_variance(&mut self, _: f32) -> RiResult {
        Ok(())
    }
    fn deformation(&mut self, name: &str, _: Params) -> RiResult {
        self.scene.warn(format!("deformation `{name}` is passed over"));
        Ok(())
    }
    fn error_handler(&mut self, _: &str) -> RiResult {
        Ok(())
    }
    fn make_texture(&mut self, from: &str, to: &str, wraps: [&str; 2], _: &str, _: [f32; 2], _: Params) -> RiResult {
        self.made.insert(to.into(), texture::Source::Picture(from.into(), wraps.map(Wrap::of_name)));
        Ok(())
    }
    fn make_lat_long_environment(&mut self, from: &str, to: &str, _: &str, _: [f32; 2], _: Params) -> RiResult {
        self.made.insert(to.into(), texture::Source::Picture(from.into(), [Wrap::Periodic, Wrap::Clamp]));
        Ok(())
    }
    fn make_cube_face_environment(
        &mut self,
        from: Vec<String>,
        to: &str,
        fov: f32,
        _: &str,
        _: [f32; 2],
        _: Params,
    ) -> RiResult {
        if !(fov > 0.0 && fov < 179.9) {
            return Err(Fail::new(format!("fov is {fov}, expected an angle between 0 and 179.9 degrees")));
        }
        let n = from.len();
        let faces: Result<[String; 6], _> = from.try_into();
        let faces = faces.map_err(|_| Fail::new(format!("{n} faces of a cube, expected 6")))?;
        self.made.insert(to.into(), texture::Source::CubeFaces(faces.map(Into::into), fov));
        Ok(())
    }
    fn make_shadow(&mut self, _: &str, _: &str, _: Params) -> RiResult {
        // Shadows are traced, whatever map is named.
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
        self.set_transform(Mat4::IDENTITY)
    }
    fn transform(&mut self, matrix: [f32; 16]) -> RiResult {
        let m = Mat4::from_cols_array(&matrix);
        if m.is_finite() { self.set_transform(m) } else { Err(Fail::new("the transformation is not finite")) }
    }
    fn concat_transform(&mut self, matrix: [f32; 16]) -> RiResult {
        self.concat(Mat4::from_cols_array(&matrix))
    }
    fn perspective(&mut self, fov: f32) -> RiResult {
        if !(fov > 0.0 && fov < 179.9) {
            return Err(Fail::new(format!("the angle of Perspective is {fov}, expected 0 to 179.9 degrees")));
        }
        let f = 1.0 / (0.5 * fov.to_radians()).tan();
        // x and y over z; z between 0 and 1 of the near and far plane 1 and infinity (RISpec 4.1.2).
        let m = [f, 0.0, 0.0, 0.0, 0.0, f, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, -1.0, 0.0];
        self.concat(Mat4::from_cols_array(&m))
    }
    fn skew(&mut self, angle: f32, from: [f32; 3], to: [f32; 3]) -> RiResult {
        // Points move along `to`, by as much as turns `from` by the angle towards it.
        let (a, b) = (Vec3::from(from), Vec3::from(to));
        let (Some(a), Some(b)) = (a.try_normalize(), b.try_normalize()) else {
            return Err(Fail::new("a direction of a skew is zero"));
        };
        let (along, across) = (a.dot(b), (1.0 - a.dot(b).powi(2)).max(0.0).sqrt());
        if across < 1e-6 {
            return Err(Fail::new("the directions of a skew are the same"));
        }
        let side = (b - a * along) / across;
        // What stands straight along `a` is turned by the angle: a unit along it moves by this much towards `side`.
        let turned = angle.to_radians().tan();
        let shift = side * turned;
        let m = Mat4::from_cols(
            (Vec3::X + shift * a.x).extend(0.0),
            (Vec3::Y + shift * a.y).extend(0.0),
            (Vec3::Z + shift * a.z).extend(0.0),
            glam::Vec4::W,
        );
        self.concat(m)
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
        let space = self.scene.spaces.get(name).ok_or(Fail::new(format!("there is no coordinate system `{name}`")))?;
        self.set_transform(*space)
    }
    fn polygon(&mut self, params: Params) -> RiResult {
        self.draw_polygon(params)
    }
    fn general_polygon(&mut self, n_vertices: Vec<i32>, params: Params) -> RiResult {
        self.draw_general_polygon(n_vertices, params)
    }
    fn points_general_polygons(
        &mut self,
        n_loops: Vec<i32>,
        n_vertices: Vec<i32>,
        vertices: Vec<i32>,
        params: Params,
    ) -> RiResult {
        self.draw_points_general_polygons(n_loops, n_vertices, vertices, params)
    }
    fn points_polygons(&mut self, n_vertices: Vec<i32>, vertices: Vec<i32>, params: Params) -> RiResult {
        self.draw_points_polygons(n_vertices, vertices, params)
    }
    fn basis(&mut self, u: [f32; 16], u_step: i32, v: [f32; 16], v_step: i32) -> RiResult {
        if !(1..=4).contains(&u_step) || !(1..=4).contains(&v_step) {
            return Err(Fail::new(format!("steps {u_step} and {v_step} of a basis, expected 1 to 4")));
        }
        self.bases = (u, v);
        self.steps = [u_step as usize, v_step as usize];
        Ok(())
    }
    fn patch(&mut self, kind: &str, params: Params) -> RiResult {
        self.draw_patch(kind, params)
    }
    fn patch_mesh(&mut self, kind: &str, nu: i32, u_wrap: &str, nv: i32, v_wrap: &str, params: Params) -> RiResult {
        self.draw_patch_mesh(kind, nu, u_wrap, nv, v_wrap, params)
    }
    fn nu_patch(&mut self, u: Knots, v: Knots, params: Params) -> RiResult {
        self.draw_nu_patch(u, v, params)
    }
    fn trim_curve(&mut self, curves: TrimCurves) -> RiResult {
        self.trim = trim(&curves)?.map(Arc::new);
        Ok(())
    }
    fn cone(&mut self, height: f32, radius: f32, sweep: f32, params: Params) -> RiResult {
        self.quadric(surfaces::line(Vec3::new(radius, 0.0, 0.0), Vec3::new(0.0, 0.0, height)), sweep, params)
    }
    fn cylinder(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        self.quadric(surfaces::line(Vec3::new(radius, 0.0, z_min), Vec3::new(radius, 0.0, z_max)), sweep, params)
    }
    fn hyperboloid(&mut self, from: [f32; 3], to: [f32; 3], sweep: f32, params: Params) -> RiResult {
        self.quadric(surfaces::line(from.into(), to.into()), sweep, params)
    }
    fn paraboloid(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        self.quadric(surfaces::parabola(radius, z_min, z_max), sweep, params)
    }
    fn disk(&mut self, height: f32, radius: f32, sweep: f32, params: Params) -> RiResult {
        self.quadric(surfaces::line(Vec3::new(radius, 0.0, height), Vec3::new(0.0, 0.0, height)), sweep, params)
    }
    fn torus(&mut self, major: f32, minor: f32, phi_min: f32, phi_max: f32, sweep: f32, params: Params) -> RiResult {
        let profile = surfaces::circle([major, 0.0], minor, phi_min.to_radians(), phi_max.to_radians());
        self.quadric(profile, sweep, params)
    }
    fn points(&mut self, params: Params) -> RiResult {
        self.draw_points(params)
    }
    fn curves(&mut self, kind: &str, n_vertices: Vec<i32>, wrap: &str, params: Params) -> RiResult {
        self.draw_curves(kind, n_vertices, wrap, params)
    }
    fn subdivision_mesh(
        &mut self,
        scheme: &str,
        n_vertices: Vec<i32>,
        vertices: Vec<i32>,
        tags: Tags,
        params: Params,
    ) -> RiResult {
        self.draw_subdivision_mesh(scheme, n_vertices, vertices, tags, params)
    }
    fn blobby(&mut self, leaves: i32, codes: Vec<i32>, floats: Vec<f32>, _: Vec<String>, params: Params) -> RiResult {
        let field = Field::new(leaves.max(0) as usize, &codes, &floats)?;
        let mut varying = Vec::new();
        for param in params.iter().filter(|p| !p.decl.class.is_whole() && !p.numbers().is_empty()) {
            let width = param.decl.width();
            if param.numbers().len() != width * leaves as usize {
                return Err(Fail::new(format!("`{}` needs a value for each of {leaves} leaves", param.decl.name)));
            }
            varying.push((param.decl.name.clone(), width, param.numbers().to_vec()));
        }
        let mut patches = field.patches(&varying);
        let whole: Params = params.iter().filter(|p| p.decl.class.is_whole()).cloned().collect();
        dress(&mut patches, &whole)?;
        self.add_patches(patches)
    }
    fn geometry(&mut self, name: &str, params: Params) -> RiResult {
        self.draw_geometry(name, params)
    }
    fn warn(&mut self, message: String) {
        self.scene.warn(message);
    }
    fn sphere(&mut self, radius: f32, z_min: f32, z_max: f32, sweep: f32, params: Params) -> RiResult {
        self.draw_sphere(radius, z_min, z_max, sweep, params)
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
