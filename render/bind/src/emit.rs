//! Emission of a frame: its table and a binding → RenderMan calls, injected into a scene.
//!
//! A scene is an ordinary RIB file, which any renderer reads; comments mark where the data goes:
//! ```text
//! #scree inject camera              the binding's camera
//! #scree inject lights              the binding's lights, or the default ones
//! #scree inject objects [NAME…]     the objects of these names, or all
//! #scree inject floor               a floor under data that brings none, if the binding has a height for it
//! #scree inject pebbles             small stones on the ground
//! #scree inject levels              the levels of the film: what becomes black and what white
//! #scree override Format            the binding's resolution; likewise Display, PixelSamples, PixelFilter, ShadingRate
//! #scree ground                     a shift of what follows, the scene's own ground, to the binding's height; objects marked as
//!                                   `ground` are left out then
//! #scree unit, #scree decade        a scale of what follows by a round length that suits the view
//! ```

mod archive;
mod arrows;
mod camera;
mod directive;
mod group;
mod instances;
mod keys;
mod missing;
mod open;
mod pebbles;
mod rows;
mod shapes;
mod trails;
mod wrong;

use crate::binding::{Binding, Camera, Color, ImageFormat, Object, Output, Quality, Shader, Shape};
use crate::moment::Moment;
pub use camera::Stand;
pub use directive::take_alone;
use directive::{OVERRIDES, unknown};
use frame::{Fault, Frame};
pub use group::Group;
pub use instances::Prepared;
pub use missing::{Lack, Missing};
use open::takes_levels;
pub use open::{levels_are_open, open_keys};
use ri::files::Files;
use ri::reader::{self, RibError};
use ri::{Class, Fail, Param, Ri, RiResult, Type};
use std::path::PathBuf;
use wrong::{Origin, Wrong, key_of_shader};

/// An error in emitting a frame.
#[derive(Debug)]
pub enum EmitError {
    /// A fault in the metadata file or job, or in the data.
    Fault(Fault),
    /// An error in a RIB file, and the metadata file or job that draws with it.
    Rib(RibError, PathBuf),
}

impl From<Fault> for EmitError {
    fn from(fault: Fault) -> EmitError {
        EmitError::Fault(fault)
    }
}

/// How much larger micropolygons of planes are than others.
const SLANT: f32 = 3.0;

/// Emit a frame to `ri`: read the binding's scene through the search path `files`, and make the calls of its directives. `image` is
/// the path of the image file. Returns the values that the rows lack. An error if the scene lacks a directive that the binding needs,
/// if a column is missing, or if a RIB file is bad.
pub fn frame(
    binding: &Binding,
    moment: &Moment,
    image: &str,
    files: &Files,
    ri: &mut dyn Ri,
) -> Result<Missing, EmitError> {
    let frame = moment.frame;
    let (prepared, missing) = prepare(binding, moment)?;
    let stand = camera::stand(binding, frame)?;
    let (path, text) =
        files.read(&binding.scene, &["scenes"]).map_err(|e| binding.doc.fault("scene", format!("scene {e}")))?;
    check_overrides(binding, &text)?;
    let has_own_ground = text.lines().any(|line| line.trim() == "#scree ground");
    let has_ground = text.lines().any(|line| matches!(line.trim(), "#scree ground" | "#scree floor"));
    let (mut drawn, mut wrong) = (Drawn::default(), None);
    if binding.output.shutter > 0.0 {
        ri.shutter(0.0, binding.output.shutter as f32).map_err(|f| binding.doc.fault("output.shutter", f.message))?;
    }
    set_quality(&binding.output, ri).map_err(|f| binding.doc.fault("output.quality", f.message))?;
    let done = reader::read(&path, text.as_bytes(), files, ri, &mut |ri, directive| {
        let mut words = directive.split_whitespace();
        let done = match (words.next(), words.next()) {
            (Some("inject"), Some("camera")) => {
                return taken(camera::inject(binding, frame.number, stand, files, ri), &mut wrong);
            }
            (Some("inject"), Some("lights")) => return taken(inject_lights(binding, files, ri), &mut wrong),
            (Some("inject"), Some("objects")) => {
                let names: Vec<&str> = words.collect();
                drawn.add(&names);
                return taken(inject_objects(binding, &prepared, &names, has_ground, files, ri), &mut wrong);
            }
            (Some("override"), Some("ShadingRate")) if words.next() == Some("floor") => {
                ri.shading_rate(floor_rate(&binding.output))
            }
            (Some("override"), Some(what)) if OVERRIDES.contains(&what) => {
                override_setting(what, &binding.output, image, ri)
            }
            (Some("inject"), Some("floor")) => inject_floor(binding, stand, ri),
            (Some("inject"), Some("pebbles")) => pebbles::inject(binding, &prepared, stand, has_own_ground, ri),
            (Some("inject"), Some("levels")) => inject_levels(&binding.output, ri),
            (Some("ground"), None) => match binding.ground_height {
                None | Some(0.0) => Ok(()),
                Some(z) => ri.translate([0.0, 0.0, z]),
            },
            (Some("floor"), None) => lower_floor(binding.ground_height.unwrap_or(0.0), stand, ri),
            (Some("unit"), None) => ri.scale([camera::unit(binding, &[5.0, 2.0, 1.0], 0.9); 3]),
            (Some("decade"), None) => ri.scale([camera::unit(binding, &[1.0], 1.0); 3]),
            _ => Err(unknown(directive)),
        };
        done.map(|()| None)
    });
    if let Some(fault) = wrong {
        return Err(EmitError::Fault(fault));
    }
    done.map_err(|e| EmitError::Rib(e, binding.doc.path.clone()))?;
    drawn.check(binding, &path, has_ground)?;
    Ok(missing)
}

/// The result of a directive for the reader of the scene; a fault that is not the scene's is kept.
fn taken(done: Result<(), Wrong>, wrong: &mut Option<Fault>) -> Result<Option<String>, Fail> {
    match done {
        Ok(()) => Ok(None),
        Err(Wrong::Scene(fail)) => Err(fail),
        Err(Wrong::File(fault)) => {
            let fail = Fail::new(fault.message.clone());
            *wrong = Some(*fault);
            Err(fail)
        }
    }
}

/// The objects that a scene has injected.
#[derive(Default)]
struct Drawn {
    /// A directive has taken all.
    all: bool,
    names: Vec<String>,
}

impl Drawn {
    /// Note a directive for the objects of these names, or for all.
    fn add(&mut self, names: &[&str]) {
        self.all |= names.is_empty();
        self.names.extend(names.iter().map(|name| name.to_string()));
    }

    /// An error if an object would be lost: all, or one that the scene does not name.
    fn check(&self, binding: &Binding, scene: &std::path::Path, has_ground: bool) -> Result<(), Fault> {
        let scene = scene.display();
        if !self.all && self.names.is_empty() {
            let message = format!("scene {scene} has no `#scree inject objects`: the data would not be drawn");
            return Err(binding.doc.fault("scene", message));
        }
        let is_taken =
            |object: &Object| self.all || self.names.contains(&object.name) || has_ground && object.is_ground;
        let Some(i) = binding.objects.iter().position(|object| !is_taken(object)) else { return Ok(()) };
        let name = &binding.objects[i].name;
        let message = format!(
            "the scene {scene} does not take the object `{name}`: it injects {} alone",
            frame::listed(&self.names.iter().map(String::as_str).collect::<Vec<_>>())
        );
        let hint = format!(
            "write `#scree inject objects {name}` there, or `#scree inject objects` for all; or remove the object"
        );
        Err(binding.doc.fault(&format!("objects.{i}.name"), message).hint(hint))
    }
}

/// Tell the library's shaders the quality of the image, and whether it is data: then no film is in the way.
fn set_quality(output: &Output, ri: &mut dyn Ri) -> RiResult {
    let number = |name: &str, x: f32| Param::floats(name, Class::Uniform, Type::Float, [x]);
    ri.option("limits", vec![number("bucketsize", output.quality.bucket_size())])?;
    let [sky, sun] = output.quality.light();
    ri.option("quality", vec![number("sky", sky), number("sun", sun)])?;
    if output.format == ImageFormat::Exr { ri.option("film", vec![number("view", 0.0)]) } else { Ok(()) }
}

/// Check the values of a frame that the objects are drawn from; gives those that the rows lack. An error if a column is missing, or if a
/// value is no number.
pub fn check(binding: &Binding, moment: &Moment) -> Result<Missing, Fault> {
    prepare(binding, moment).map(|(_, missing)| missing)
}

/// The range of the values that each object of a binding is coloured by, in a frame; none of an object of one colour, without rows,
/// or whose values cannot be computed.
pub fn color_ranges(binding: &Binding, moment: &Moment) -> Vec<Option<[f64; 2]>> {
    let range = |(i, object)| instances::color_range(binding, i, object, moment).ok().flatten();
    binding.objects.iter().enumerate().map(range).collect()
}

/// The range of the lengths of the vectors of each object's arrows, in a frame; none of an object that has none.
pub fn arrow_ranges(binding: &Binding, moment: &Moment) -> Vec<Option<[f64; 2]>> {
    let range = |(i, object)| instances::arrow_range(binding, i, object, moment).ok().flatten();
    binding.objects.iter().enumerate().map(range).collect()
}

/// The mean position of the rows that the camera follows, in a frame; none if it follows none, or the frame has no such rows.
pub fn followed(binding: &Binding, frame: &Frame) -> Option<[f64; 3]> {
    let Some(Camera::Placed(placed)) = &binding.camera else { return None };
    camera::followed(binding, placed.follow.as_ref()?, frame).ok()
}

/// Length of the arrow of a vector of length 1, m, of the `i`th object, by its longest vector. An error if the camera does not say how much
/// it sees.
pub fn arrow_scale(binding: &Binding, i: usize, longest: f64) -> Result<f64, Fault> {
    arrows::scale(binding, i, longest)
}

/// Where the camera of a frame stands, if the binding places it. An error if it follows rows that the frame does not have.
pub fn stand(binding: &Binding, frame: &Frame) -> Result<Option<Stand>, Fault> {
    camera::stand(binding, frame)
}

/// The instances of all objects, and what the rows lack. An error if a column is missing, or if a value is no number.
pub fn prepare<'a>(binding: &'a Binding, moment: &Moment) -> Result<(Vec<Prepared<'a>>, Missing), Fault> {
    let mut missing = Missing { columns: missing::columns(binding, moment.frame), ..Missing::default() };
    let mut prepared = Vec::new();
    for (i, object) in binding.objects.iter().enumerate() {
        let object = instances::prepare(binding, i, object, moment)?;
        missing.undrawn.add(&object.missing.undrawn);
        missing.uncolored.add(&object.missing.uncolored);
        missing.absent.extend(object.missing.absent.iter().cloned());
        prepared.push(object);
    }
    Ok((prepared, missing))
}

/// A setting that the file makes and the scene does not take would be lost silently: that is an error.
fn check_overrides(binding: &Binding, scene: &str) -> Result<(), Fault> {
    let places = [
        ("Format", "resolution"),
        ("PixelSamples", "samples"),
        ("PixelFilter", "filter"),
        ("ShadingRate", "shading_rate"),
    ];
    for (call, key) in places {
        let set = binding.doc.place(&format!("output.{key}")) != binding.doc.place("output");
        if set && !scene.contains(&format!("#scree override {call}")) {
            let message = format!("the scene does not take it: `#scree override {call}` is missing there");
            return Err(binding.doc.fault(&format!("output.{key}"), message));
        }
    }
    if binding.doc.place("output.levels") != binding.doc.place("output") && !takes_levels(scene) {
        let message = "the scene does not take them: `#scree inject levels` is missing there";
        return Err(binding.doc.fault("output.levels", message));
    }
    if !scene.contains("#scree override Display") {
        return Err(binding
            .doc
            .fault("scene", "the scene has no `#scree override Display`: its image would go elsewhere"));
    }
    if binding.camera.is_some() && !scene.contains("#scree inject camera") {
        return Err(binding
            .doc
            .fault("camera", "the scene does not take a camera: `#scree inject camera` is missing there"));
    }
    Ok(())
}

/// Area of a micropolygon of planes, pixels. They are mostly seen at a slant, where micropolygons are slender: longer ones are as small.
fn floor_rate(o: &Output) -> f32 {
    if o.quality == Quality::Final { o.shading_rate } else { SLANT * o.shading_rate }
}

fn override_setting(what: &str, o: &Output, image: &str, ri: &mut dyn Ri) -> RiResult {
    match what {
        "Format" => ri.format(o.resolution[0] as i32, o.resolution[1] as i32, 1.0),
        "PixelSamples" => ri.pixel_samples(o.samples[0] as f32, o.samples[1] as f32),
        "PixelFilter" => ri.pixel_filter(&o.filter.0, o.filter.1, o.filter.1),
        "ShadingRate" => ri.shading_rate(o.shading_rate),
        _ => {
            let (kind, one) = match (o.format, o.bits) {
                (ImageFormat::Exr, _) => ("exr", 0),
                (_, Some(16)) => ("png", 65_535),
                _ => ("png", 255),
            };
            ri.quantize("rgba", one, 0, one, if one == 0 { 0.0 } else { 0.5 })?;
            let half = || match (o.format, o.bits) {
                (ImageFormat::Exr, Some(16)) => vec![Param::string("type", "half")],
                _ => vec![],
            };
            // What goes over other images needs its coverage.
            ri.display(image, kind, if o.channels.is_empty() { "rgb" } else { "rgba" }, half())?;
            o.channels.iter().try_for_each(|mode| ri.display(&format!("+{image}"), kind, mode, half()))
        }
    }
}

/// The binding's lights, or a sun from the left with a little light from everywhere.
fn inject_lights(binding: &Binding, files: &Files, ri: &mut dyn Ri) -> Result<(), Wrong> {
    if let Some(file) = &binding.lights {
        return archive::include(file, files, Origin { binding, key: "lights", object: None }, ri);
    }
    let number = |name: &str, x: f32| Param::floats(name, Class::Uniform, Type::Float, [x]);
    let triple = |name: &str, ty: Type, x: [f32; 3]| Param::floats(name, Class::Uniform, ty, x);
    let sky = vec![
        triple("zenith", Type::Color, [0.46, 0.52, 0.59]),
        triple("horizon", Type::Color, [0.28, 0.31, 0.35]),
        triple("beneath", Type::Color, [0.22, 0.21, 0.2]),
        triple("sun", Type::Vector, [-0.55, -0.5, 0.8]),
        triple("sunshine", Type::Color, [1.25, 1.19, 1.09]),
    ];
    ri.light_source("skylight", "scree:sky", sky)?;
    let sun = vec![
        number("intensity", 1.25),
        number("angle", 5.0),
        number("samples", 16.0),
        triple("lightcolor", Type::Color, [1.0, 0.95, 0.87]),
        triple("from", Type::Point, [0.0; 3]),
        triple("to", Type::Point, [0.55, 0.5, -0.8]),
    ];
    Ok(ri.light_source("distantlight", "scree:sun", sun)?)
}

/// The levels of the film, if they are given or measured.
fn inject_levels(output: &Output, ri: &mut dyn Ri) -> RiResult {
    let Some(levels) = output.levels else { return Ok(()) };
    let mut param = Param::floats("levels", Class::Uniform, Type::Float, levels.map(|x| x as f32));
    param.decl.array = 2;
    ri.option("film", vec![param])
}

/// Go to a height under what the camera looks at, with its distance as unit.
fn lower_floor(height: f32, stand: Option<Stand>, ri: &mut dyn Ri) -> RiResult {
    let ([x, y], size) = stand.map_or(([0.0; 2], 1.0), |stand| stand.floor());
    ri.translate([x, y, height])?;
    ri.scale([size; 3])
}

/// A floor under the data, with the attributes that the scene has there, if the file gives its height and no object is the ground.
fn inject_floor(binding: &Binding, stand: Option<Stand>, ri: &mut dyn Ri) -> RiResult {
    /// Half its edge, in distances of the camera.
    const HALF: f32 = 60.0;
    let is_ground = |object: &Object| {
        let by_surface = object.surface.as_ref().is_some_and(|surface| surface.name == "ground");
        object.is_ground || by_surface || matches!(object.shape, Shape::Plane(_))
    };
    let Some(z) = binding.ground_height.filter(|_| !binding.objects.iter().any(is_ground)) else { return Ok(()) };
    let points = [[-HALF, -HALF, 0.0], [HALF, -HALF, 0.0], [HALF, HALF, 0.0], [-HALF, HALF, 0.0]].concat();
    ri.transform_begin()?;
    lower_floor(z, stand, ri)?;
    ri.polygon(vec![Param::floats("P", Class::Vertex, Type::Point, points)])?;
    ri.transform_end()
}

/// The number by which shaders know a shape that has edges.
fn kind_of(shape: &Shape) -> Option<f32> {
    match shape {
        Shape::Box(_) => Some(1.0),
        Shape::Cylinder(_) => Some(2.0),
        _ => None,
    }
}

/// The attributes of an object, whose key is that of `at`.
fn set_attributes(object: &Object, at: Origin<'_>, ri: &mut dyn Ri) -> Result<(), Wrong> {
    set_look(object, &at.binding.output, ri).map_err(|fail| at.wrong(fail))?;
    set_shaders(object, at, ri)
}

/// Colour, opacity and what else goes by the shape.
fn set_look(object: &Object, output: &Output, ri: &mut dyn Ri) -> RiResult {
    if let Color::Rgb(color) = object.color {
        ri.color(color)?;
    }
    if let Some(o) = object.opacity {
        ri.opacity([o; 3])?;
    }
    for (name, params) in &object.attributes {
        ri.attribute(name, params.clone())?;
    }
    if let Some(kind) = kind_of(&object.shape) {
        // For edges and marks of the library's materials.
        ri.attribute("shape", vec![Param::floats("kind", Class::Uniform, Type::Float, [kind])])?;
    }
    if let Shape::Plane(_) = object.shape {
        ri.shading_rate(floor_rate(output))?;
    }
    if matches!(object.shape, Shape::Plane(_) | Shape::Box(_)) {
        // What is flat has no silhouette within a micropolygon: shadows on it have smooth edges.
        ri.shading_interpolation("smooth")?;
    }
    if is_mark(object) {
        // Marks are no bodies: they cast no shadows.
        let no = vec![Param::floats("transmission", Class::Uniform, Type::Float, [0.0])];
        ri.attribute("visibility", no)?;
    }
    Ok(())
}

/// Whether an object is drawn as marks, which are no bodies.
fn is_mark(object: &Object) -> bool {
    matches!(object.shape, Shape::Arrow(_) | Shape::Trail(_))
}

/// The shaders of an object.
fn set_shaders(object: &Object, at: Origin<'_>, ri: &mut dyn Ri) -> Result<(), Wrong> {
    let wrong = |kind: &str, shader: Option<&Shader>, fail: Fail| {
        let key = format!("{}.{kind}", at.key);
        let key = shader.map_or(key.clone(), |shader| key_of_shader(&key, shader, &fail.message));
        at.key(&key).wrong(fail)
    };
    let bound = match &object.surface {
        Some(surface) => ri.surface(&surface.name, surface.params.clone()),
        None if is_mark(object) => ri.surface("mark", vec![]),
        None => ri.surface("matte", vec![]),
    };
    bound.map_err(|fail| wrong("surface", object.surface.as_ref(), fail))?;
    match &object.displacement {
        Some(displacement) => set_displacement(displacement, at.binding.output.quality, ri)
            .map_err(|fail| wrong("displacement", Some(displacement), fail)),
        None => Ok(()),
    }
}

/// A displacement shader and its bound.
fn set_displacement(displacement: &Shader, quality: Quality, ri: &mut dyn Ri) -> RiResult {
    if let Some(bound) = displacement.bound {
        ri.attribute("displacementbound", vec![Param::floats("sphere", Class::Uniform, Type::Float, [bound])])?;
    }
    if !displacement.traced || quality == Quality::Draft {
        let no = vec![Param::floats("displacements", Class::Uniform, Type::Float, [0.0])];
        ri.attribute("trace", no)?;
    }
    ri.displacement(&displacement.name, displacement.params.clone())
}

/// The objects of the given names, or all but those for which the scene has a ground of its own.
fn inject_objects(
    binding: &Binding,
    prepared: &[Prepared<'_>],
    names: &[&str],
    has_ground: bool,
    files: &Files,
    ri: &mut dyn Ri,
) -> Result<(), Wrong> {
    for name in names {
        if !prepared.iter().any(|p| p.object.name == *name) {
            let message = format!("the scene wants the object `{name}`, which the metadata does not have");
            return Err(Fail::new(message).into());
        }
    }
    let is_drawn = |p: &Prepared<'_>| match names {
        [] => !(has_ground && p.object.is_ground),
        names => names.contains(&p.object.name.as_str()),
    };
    for (i, p) in prepared.iter().enumerate().filter(|(_, p)| is_drawn(p)) {
        let key = format!("objects.{i}");
        let at = Origin { binding, key: &key, object: Some(&p.object.name) };
        let place = Some((binding.doc.path.as_path(), binding.doc.place(&key)));
        ri.stands_at(place);
        ri.attribute_begin()?;
        set_attributes(p.object, at, ri)?;
        for group in &p.groups {
            if let Some(handle) = &group.handle {
                ri.object_begin(handle)?;
                shapes::define(&p.object.shape, group, files, at, ri)?;
                ri.object_end()?;
            }
            ri.stands_at(place);
            for instances in &group.instances {
                ri.instances(instances.clone()).map_err(|fail| at.wrong(fail))?;
            }
        }
        if !p.trails.is_empty() {
            p.trails.draw(p.object.opacity.unwrap_or(1.0), ri).map_err(|fail| at.wrong(fail))?;
        }
        ri.attribute_end()?;
        ri.stands_at(None);
    }
    Ok(())
}
