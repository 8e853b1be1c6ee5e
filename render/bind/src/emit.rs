//! A frame's table and its metadata → RenderMan calls, injected into a scene.
//!
//! A scene is an ordinary RIB file; structured comments say where the data goes, so that any renderer still opens it:
//! ```text
//! #scree inject camera              the metadata's camera
//! #scree inject lights              the metadata's lights, or the default ones
//! #scree inject objects [NAME…]     the objects of these names, or all
//! #scree override Format            the metadata's resolution; likewise Display, PixelSamples, PixelFilter, ShadingRate
//! ```

use crate::colormap;
use crate::expr::Expr;
use crate::metadata::{Checked, Color, Geometry, ImageFormat, Object, Output, Parameter, Quantity, Shader};
use frame::{Fault, FaultKind, Frame};
use glam::{Mat4, Quat, Vec3};
use ri::files::Files;
use ri::reader::{self, RibError};
use ri::{Class, Declaration, Fail, InstanceShape, Instances, Param, Params, Ri, RiResult, Type, Values};
use std::path::Path;

/// Why a frame could not be emitted.
#[derive(Debug)]
pub enum EmitError {
    /// Something in the metadata or the data.
    Fault(Fault),
    /// Something in a RIB file.
    Rib(RibError),
}

impl From<Fault> for EmitError {
    fn from(fault: Fault) -> EmitError {
        EmitError::Fault(fault)
    }
}

/// An object's instances, made before the scene is read, so that a fault in the data stops nothing half way.
struct Prepared<'a> {
    object: &'a Object,
    /// One set, but three for a capsule: its middle and its ends.
    instances: Vec<Instances>,
    handle: Option<String>,
}

/// What is left of settings that no directive has placed yet.
const OVERRIDES: [&str; 5] = ["Format", "Display", "PixelSamples", "PixelFilter", "ShadingRate"];

/// Emit a frame: read the scene, and make the calls of its directives. `image` is the picture's file.
pub fn frame(checked: &Checked, frame: &Frame, image: &str, files: &Files, ri: &mut dyn Ri) -> Result<(), EmitError> {
    let m = &checked.metadata;
    let mut prepared = Vec::new();
    for (i, object) in m.objects.iter().enumerate() {
        prepared.push(prepare(checked, i, object, frame)?);
    }
    let (path, text) =
        files.read(&m.scene, &["scenes"]).map_err(|e| checked.doc.fault("scene", format!("scene {e}")))?;
    check_overrides(checked, &text)?;
    let mut drawn = false;
    if m.output.shutter > 0.0 {
        ri.shutter(0.0, m.output.shutter as f32).map_err(|f| checked.doc.fault("output.shutter", f.message))?;
    }
    let done = reader::read(&path, text.as_bytes(), files, ri, &mut |ri, directive| {
        let mut words = directive.split_whitespace();
        match (words.next(), words.next()) {
            (Some("inject"), Some("camera")) => inject_camera(checked, frame, files, ri),
            (Some("inject"), Some("lights")) => inject_lights(checked, files, ri),
            (Some("inject"), Some("objects")) => {
                drawn = true;
                inject_objects(&prepared, &words.collect::<Vec<_>>(), files, ri)
            }
            (Some("override"), Some(what)) if OVERRIDES.contains(&what) => override_setting(what, &m.output, image, ri),
            (Some("override"), what) => Err(Fail::new(format!(
                "`#scree override {}` is unknown, expected one of {}",
                what.unwrap_or(""),
                OVERRIDES.join(", ")
            ))),
            (Some("inject"), what) => Err(Fail::new(format!(
                "`#scree inject {}` is unknown, expected camera, lights or objects",
                what.unwrap_or("")
            ))),
            _ => Err(Fail::new(format!("`#scree {directive}` is unknown, expected `inject` or `override`"))),
        }
    });
    done.map_err(EmitError::Rib)?;
    if !drawn {
        let message = format!("scene {} has no `#scree inject objects`: the data would not be drawn", path.display());
        return Err(checked.doc.fault("scene", message).into());
    }
    Ok(())
}

/// A setting that the metadata makes and the scene does not take would be lost silently: that is an error.
fn check_overrides(checked: &Checked, scene: &str) -> Result<(), Fault> {
    let places = [
        ("Format", "resolution"),
        ("PixelSamples", "samples"),
        ("PixelFilter", "filter"),
        ("ShadingRate", "shading_rate"),
    ];
    for (call, key) in places {
        let set = checked.doc.place(&format!("output.{key}")) != checked.doc.place("output");
        if set && !scene.contains(&format!("#scree override {call}")) {
            let message = format!("the scene does not take it: `#scree override {call}` is missing there");
            return Err(checked.doc.fault(&format!("output.{key}"), message));
        }
    }
    if !scene.contains("#scree override Display") {
        return Err(checked
            .doc
            .fault("scene", "the scene has no `#scree override Display`: its picture would go elsewhere"));
    }
    if checked.metadata.camera.is_some() && !scene.contains("#scree inject camera") {
        return Err(checked
            .doc
            .fault("camera", "the scene does not take a camera: `#scree inject camera` is missing there"));
    }
    Ok(())
}

fn override_setting(what: &str, o: &Output, image: &str, ri: &mut dyn Ri) -> RiResult {
    match what {
        "Format" => ri.format(o.resolution[0] as i32, o.resolution[1] as i32, 1.0),
        "PixelSamples" => ri.pixel_samples(o.samples[0] as f32, o.samples[1] as f32),
        "PixelFilter" => ri.pixel_filter(&o.filter.name, o.filter.width, o.filter.width),
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
            // What goes over other pictures needs its coverage.
            ri.display(image, kind, if o.channels.is_empty() { "rgb" } else { "rgba" }, half())?;
            o.channels.iter().try_for_each(|mode| ri.display(&format!("+{image}"), kind, mode, half()))
        }
    }
}

/// Projection and world-to-camera matrix.
fn inject_camera(checked: &Checked, frame: &Frame, files: &Files, ri: &mut dyn Ri) -> RiResult {
    let Some(camera) = &checked.metadata.camera else {
        return Err(Fail::new(
            "the scene wants a camera, but the metadata has none: add `camera: {eye: …, look_at: …}`",
        ));
    };
    if let Some(file) = &camera.file {
        return include(&numbered(file, frame.number), files, ri);
    }
    match camera.orthographic {
        Some(height) => {
            let [w, h] = checked.metadata.output.resolution.map(|n| n as f32);
            let (x, y) =
                if w >= h { (0.5 * height * w / h, 0.5 * height) } else { (0.5 * height, 0.5 * height * h / w) };
            ri.screen_window(-x, x, -y, y)?;
            ri.projection("orthographic", vec![])?;
        }
        None => ri.projection("perspective", vec![Param::floats("fov", Class::Uniform, Type::Float, [camera.fov])])?,
    }
    let (mut eye, mut at, up) = camera.place();
    if let Some(degrees) = camera.orbit {
        // About the direction that is up, counter-clockwise as seen from there.
        let angle = (degrees as f64 * frame.number as f64 % 360.0).to_radians() as f32;
        let turn = Quat::from_axis_angle(Vec3::from(up).normalize(), angle);
        eye = (Vec3::from(at) + turn * (Vec3::from(eye) - Vec3::from(at))).into();
    }
    if let Some(condition) = checked.followed().map_err(|f| Fail::new(f.to_string()))? {
        let rows = condition.select(frame).map_err(Fail::new)?;
        if rows.is_empty() {
            return Err(Fail::new(format!("the camera follows `{}`, which no row is", condition.text)));
        }
        for (k, name) in ["pos_x", "pos_y", "pos_z"].into_iter().enumerate() {
            let column = Expr::parse(name).map_err(|e| Fail::new(e.message))?;
            let values = column.numbers(frame, &rows).map_err(Fail::new)?;
            let middle = values.iter().sum::<f64>() / rows.len() as f64;
            eye[k] += middle as f32;
            at[k] += middle as f32;
        }
    }
    if let Some(lens) = &camera.lens {
        let focus = lens.focus.unwrap_or((Vec3::from(at) - Vec3::from(eye)).length());
        ri.depth_of_field(lens.f_stop, lens.focal_length, focus)?;
    }
    ri.concat_transform(look_at(eye, at, up).to_cols_array())
}

/// A file's name with the frame's number for `{frame}`, or with N digits for `{frame:0N}`.
fn numbered(file: &str, number: u64) -> String {
    let parts = file.split_once("{frame").and_then(|(before, rest)| Some((before, rest.split_once('}')?)));
    let Some((before, (format, after))) = parts else { return file.into() };
    let digits = format.strip_prefix(":0").and_then(|n| n.parse().ok()).unwrap_or(0usize).min(20);
    format!("{before}{number:0digits$}{after}")
}

/// World to camera: x right, y up, z forward.
fn look_at(eye: [f32; 3], at: [f32; 3], up: [f32; 3]) -> Mat4 {
    let (eye, at) = (Vec3::from(eye), Vec3::from(at));
    let forward = (at - eye).normalize();
    let right = forward.cross(up.into()).normalize();
    let up = right.cross(forward);
    let turn = Mat4::from_cols(right.extend(0.0), up.extend(0.0), forward.extend(0.0), glam::Vec4::W).transpose();
    turn * Mat4::from_translation(-eye)
}

/// The metadata's lights, or a sun from the left with a little light from everywhere.
fn inject_lights(checked: &Checked, files: &Files, ri: &mut dyn Ri) -> RiResult {
    if let Some(file) = &checked.metadata.lights {
        return include(file, files, ri);
    }
    let number = |name: &str, x: f32| Param::floats(name, Class::Uniform, Type::Float, [x]);
    let triple = |name: &str, ty: Type, x: [f32; 3]| Param::floats(name, Class::Uniform, ty, x);
    ri.light_source(
        "ambientlight",
        "scree:sky",
        vec![number("intensity", 0.3), triple("lightcolor", Type::Color, [0.75, 0.87, 1.0])],
    )?;
    let sun = vec![
        number("intensity", 0.95),
        triple("lightcolor", Type::Color, [1.0, 0.95, 0.87]),
        triple("from", Type::Point, [0.0; 3]),
        triple("to", Type::Point, [0.55, 0.5, -0.8]),
    ];
    ri.light_source("distantlight", "scree:sun", sun)
}

fn include(file: &str, files: &Files, ri: &mut dyn Ri) -> RiResult {
    if file.to_lowercase().ends_with(".obj") {
        return wavefront(file, files, ri);
    }
    let (path, text) = files.read(file, &["scenes"]).map_err(Fail::new)?;
    reader::read(&path, text.as_bytes(), files, ri, &mut |_, _| Ok(())).map_err(|e| Fail::new(format!("in {e}")))
}

/// The polygons of a Wavefront OBJ file, with the normals and texture coordinates that it has.
fn wavefront(file: &str, files: &Files, ri: &mut dyn Ri) -> RiResult {
    let (path, text) = files.read(file, &["scenes"]).map_err(Fail::new)?;
    // Materials are the metadata's.
    let none = |_: &Path| Ok((vec![], Default::default()));
    let options = tobj::LoadOptions { single_index: true, ..Default::default() };
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, none)
        .map_err(|e| Fail::new(format!("in {}: {e}", path.display())))?;
    for mesh in models.into_iter().map(|m| m.mesh).filter(|m| !m.indices.is_empty()) {
        let vertices: Vec<i32> = mesh.indices.iter().map(|i| *i as i32).collect();
        let faces = if mesh.face_arities.is_empty() {
            vec![3; vertices.len() / 3]
        } else {
            mesh.face_arities.iter().map(|n| *n as i32).collect()
        };
        let mut params = vec![Param::floats("P", Class::Vertex, Type::Point, mesh.positions)];
        if !mesh.normals.is_empty() {
            params.push(Param::floats("N", Class::Vertex, Type::Normal, mesh.normals));
        }
        if !mesh.texcoords.is_empty() {
            // The file's t goes up, the picture's down.
            let corner = |k: usize| mesh.texcoords.iter().skip(k).step_by(2);
            params.push(Param::floats("s", Class::Vertex, Type::Float, corner(0).copied().collect::<Vec<_>>()));
            params.push(Param::floats("t", Class::Vertex, Type::Float, corner(1).map(|t| 1.0 - t).collect::<Vec<_>>()));
        }
        ri.points_polygons(faces, vertices, params)?;
    }
    Ok(())
}

fn inject_objects(prepared: &[Prepared<'_>], names: &[&str], files: &Files, ri: &mut dyn Ri) -> RiResult {
    for name in names {
        if !prepared.iter().any(|p| p.object.name == *name) {
            return Err(Fail::new(format!("the scene wants the object `{name}`, which the metadata does not have")));
        }
    }
    for p in prepared.iter().filter(|p| names.is_empty() || names.contains(&p.object.name.as_str())) {
        ri.attribute_begin()?;
        if let Color::Rgb(color) = p.object.color {
            ri.color(color)?;
        }
        if let Some(o) = p.object.opacity {
            ri.opacity([o; 3])?;
        }
        match &p.object.surface {
            Some(surface) => ri.surface(&surface.name, shader_params(surface))?,
            None => ri.surface("matte", vec![])?,
        }
        if let Some(displacement) = &p.object.displacement {
            if let Some(bound) = displacement.bound {
                ri.attribute("displacementbound", vec![Param::floats("sphere", Class::Uniform, Type::Float, [bound])])?;
            }
            ri.displacement(&displacement.name, shader_params(displacement))?;
        }
        if let Some(handle) = &p.handle {
            ri.object_begin(handle)?;
            define(&p.object.geometry, files, ri)?;
            ri.object_end()?;
        }
        for instances in &p.instances {
            ri.instances(instances.clone())?;
        }
        ri.attribute_end()?;
    }
    Ok(())
}

fn shader_params(shader: &Shader) -> Params {
    let param = |(name, value): (&String, &Parameter)| match value {
        Parameter::Number(x) => Param::floats(name, Class::Uniform, Type::Float, [*x]),
        Parameter::Triple(x) => Param::floats(name, Class::Uniform, Type::Color, *x),
        Parameter::Text(text) => Param::string(name, text),
    };
    shader.parameters.iter().map(param).collect()
}

/// The retained object of a geometry that is not a sphere: a unit cube, a unit square, an archive.
fn define(geometry: &Geometry, files: &Files, ri: &mut dyn Ri) -> RiResult {
    if let Some(archive) = &geometry.archive {
        return include(&archive.file, files, ri);
    }
    let polygon = |corners: [[f32; 3]; 4]| {
        let decl = Declaration::new("P", Class::Vertex, Type::Point);
        vec![Param { decl, values: Values::Floats(corners.concat()) }]
    };
    if geometry.plane.is_some() {
        return ri.polygon(polygon([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]));
    }
    if geometry.cylinder.is_some() || geometry.capsule.is_some() || geometry.cone.is_some() {
        let top = if geometry.cone.is_some() { 0.0 } else { 1.0 };
        return turned(top, geometry.capsule.is_none(), ri);
    }
    for axis in 0..3 {
        for side in [-1.0f32, 1.0] {
            // Around the face, so that its normal points outwards.
            let corner = |s: f32, t: f32| {
                let mut p = [0.0; 3];
                p[axis] = side;
                p[(axis + 1) % 3] = s * side;
                p[(axis + 2) % 3] = t;
                p
            };
            ri.polygon(polygon([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]))?;
        }
    }
    Ok(())
}

/// A cylinder (`top` 1) or a cone (`top` 0) of radius 1 from z = −1 to 1 as four bicubic patches, with flat ends if `closed`.
fn turned(top: f32, closed: bool, ri: &mut dyn Ri) -> RiResult {
    /// The distance of a Bézier curve's inner points from its ends that makes a quarter circle.
    const ARC: f32 = 0.552_284_8;
    let points = |p: Vec<f32>| {
        vec![Param { decl: Declaration::new("P", Class::Vertex, Type::Point), values: Values::Floats(p) }]
    };
    for quarter in 0..4 {
        let (s, c) = (quarter as f32 * std::f32::consts::FRAC_PI_2).sin_cos();
        let arc = [[1.0, 0.0], [1.0, ARC], [ARC, 1.0], [0.0, 1.0]].map(|[x, y]| [c * x - s * y, s * x + c * y]);
        let row = |z: f32, r: f32| arc.iter().flat_map(move |[x, y]| [r * x, r * y, z]);
        // Straight along z: the inner rows divide it by three.
        let rows = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|t: f32| (2.0 * t - 1.0, 1.0 + t * (top - 1.0)));
        ri.patch("bicubic", points(rows.iter().flat_map(|(z, r)| row(*z, *r)).collect()))?;
        for (z, r) in [(-1.0, 1.0), (1.0, top)] {
            if closed && r > 0.0 {
                // A sector of the end: the same arc drawn in to the middle, outwards up or down.
                let rings = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|t: f32| if z > 0.0 { r * (1.0 - t) } else { r * t });
                ri.patch("bicubic", points(rings.iter().flat_map(|r| row(z, *r)).collect()))?;
            }
        }
    }
    Ok(())
}

/// Evaluate an object's rows into columns of instances.
fn prepare<'a>(checked: &Checked, i: usize, object: &'a Object, frame: &Frame) -> Result<Prepared<'a>, Fault> {
    let key = format!("objects.{i}");
    let fail = |part: &str, message: String| checked.doc.fault(&format!("{key}.{part}"), message);
    let expr = |part: &str, q: &Quantity| -> Result<Expr, Fault> { q.expr().map_err(|e| fail(part, e.message)) };
    let rows = match &object.select {
        Some(select) => {
            let condition = expr("select", &Quantity::Expression(select.clone()))?;
            condition.select(frame).map_err(|m| fail("select", m))?
        }
        None => (0..frame.rows()).collect(),
    };
    let numbers = |part: &str, q: &Quantity| -> Result<Vec<f64>, Fault> {
        let values = expr(part, q)?.numbers(frame, &rows).map_err(|m| fail(part, m))?;
        match values.iter().position(|x| !x.is_finite()) {
            Some(k) => {
                let message = format!("row {} has {} in `{}`", rows[k] + 1, values[k], expr(part, q)?.text);
                let place = fail(part, message);
                Err(Fault { kind: FaultKind::Data, ..place })
            }
            None => Ok(values),
        }
    };
    let three = |part: &str, q: &[Quantity; 3]| -> Result<Vec<[f32; 3]>, Fault> {
        let columns = [numbers(part, &q[0])?, numbers(part, &q[1])?, numbers(part, &q[2])?];
        Ok((0..rows.len()).map(|r| [0, 1, 2].map(|c| columns[c][r] as f32)).collect())
    };
    let single = |part: &str, q: &Quantity| -> Result<Vec<[f32; 3]>, Fault> {
        Ok(numbers(part, q)?.into_iter().map(|x| [x as f32; 3]).collect())
    };
    let g = &object.geometry;
    let scale = if let Some(s) = &g.sphere {
        single("geometry", &s.radius)?
    } else if let Some(s) = g.block.as_ref().or(g.ellipsoid.as_ref()) {
        three("geometry", &s.half)?
    } else if let Some(s) = g.cylinder.as_ref().or(g.capsule.as_ref()).or(g.cone.as_ref()) {
        three("geometry", &[s.radius.clone(), s.radius.clone(), s.half.clone()])?
    } else if let Some(s) = &g.plane {
        single("geometry", &s.half)?
    } else {
        single("geometry", g.archive.as_ref().map_or(&Quantity::Number(1.0), |a| &a.scale))?
    };
    if let Some(k) = scale.iter().position(|s| s.iter().any(|x| !(*x > 0.0))) {
        let place = fail("geometry", format!("row {} has a size that is not above 0", rows[k] + 1));
        return Err(Fault { kind: FaultKind::Data, ..place });
    }
    let handle = (g.sphere.is_none() && g.ellipsoid.is_none()).then(|| format!("scree:{}", object.name));
    let mut instances = Instances {
        shape: handle.clone().map_or(InstanceShape::Sphere, InstanceShape::Object),
        position: three("position", &object.position)?,
        orientation: orientation(object, frame, &numbers)?,
        scale,
        params: vec![],
        moved: None,
    };
    if let Color::Column(by) = &object.color {
        let values = numbers("color", &by.column)?;
        let (lo, hi) = by.range.map(|[a, b]| (a, b)).unwrap_or_else(|| range_of(&values));
        let width = if hi > lo { hi - lo } else { 1.0 };
        let colors = values.iter().flat_map(|x| colormap::color(&by.map, (x - lo) / width).unwrap_or([1.0; 3]));
        instances.params.push(Param::floats("Cs", Class::Uniform, Type::Color, colors.collect::<Vec<f32>>()));
    }
    if let Some(velocity) = velocity(object, frame).filter(|_| checked.metadata.output.shutter > 0.0) {
        let shutter = checked.metadata.output.shutter as f32;
        let steps = three("velocity", &velocity)?;
        let to = instances.position.iter().zip(steps).map(|(p, v)| [0, 1, 2].map(|c| p[c] + v[c] * shutter));
        instances.moved = Some(([0.0, shutter], to.collect()));
    }
    let ends = if g.capsule.is_some() { capsule_ends(&instances) } else { vec![] };
    let instances = std::iter::once(instances).chain(ends).collect();
    Ok(Prepared { object, instances, handle })
}

/// The balls at a capsule's ends.
fn capsule_ends(middle: &Instances) -> Vec<Instances> {
    let along = |places: &[[f32; 3]], i: usize, side: f32| {
        let q = middle.orientation.get(i).map_or(glam::Quat::IDENTITY, |q| glam::Quat::from_array(*q));
        let [_, _, half] = middle.scale[i];
        (Vec3::from(places[i]) + q * Vec3::new(0.0, 0.0, side * half)).to_array()
    };
    let all = |places: &[[f32; 3]], side: f32| (0..middle.len()).map(|i| along(places, i, side)).collect::<Vec<_>>();
    let ball = |side: f32| Instances {
        shape: InstanceShape::Sphere,
        position: all(&middle.position, side),
        moved: middle.moved.as_ref().map(|(times, to)| (*times, all(to, side))),
        scale: middle.scale.iter().map(|[r, _, _]| [*r; 3]).collect(),
        ..middle.clone()
    };
    vec![ball(-1.0), ball(1.0)]
}

fn range_of(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(*x), hi.max(*x)))
}

/// The velocities of an object's rows: its own, or those of the standard columns where the data has them.
fn velocity(object: &Object, frame: &Frame) -> Option<[Quantity; 3]> {
    let standard = ["vel_x", "vel_y", "vel_z"];
    let has = standard.iter().all(|c| frame.column(c).is_some());
    object.velocity.clone().or_else(|| has.then(|| standard.map(|c| Quantity::Expression(c.into()))))
}

/// Quaternions (x, y, z, w), made unit; none if neither the metadata nor the data has any.
fn orientation(
    object: &Object,
    frame: &Frame,
    numbers: &dyn Fn(&str, &Quantity) -> Result<Vec<f64>, Fault>,
) -> Result<Vec<[f32; 4]>, Fault> {
    let standard = ["quat_w", "quat_x", "quat_y", "quat_z"];
    let columns = match &object.orientation {
        Some(q) => q.clone(),
        None if standard.iter().all(|c| frame.column(c).is_some()) => standard.map(|c| Quantity::Expression(c.into())),
        None => return Ok(vec![]),
    };
    let [w, x, y, z] = [0, 1, 2, 3].map(|k| numbers("orientation", &columns[k]));
    let (w, x, y, z) = (w?, x?, y?, z?);
    let unit = |i: usize| glam::Quat::from_xyzw(x[i] as f32, y[i] as f32, z[i] as f32, w[i] as f32);
    Ok((0..w.len())
        .map(|i| if unit(i).length() > 0.0 { unit(i).normalize().to_array() } else { [0.0, 0.0, 0.0, 1.0] })
        .collect())
}
