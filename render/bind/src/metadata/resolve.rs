//! A metadata file → its binding: what belongs together is checked, names are found, formulas compiled.

use super::types;
use super::types::{CameraSpec, Metadata, Parameter, Quantity, View};
use crate::binding::{
    Archive, Arrow, Binding, Camera, Color, Data, Formula, ImageFormat, Key, Lens, Object, Output, Place, Placed,
    Projection, Quality, Reach, Shader, Shape, Trail, delimiter, some_objects,
};
use frame::Fault;
use frame::csv::Layout;
use frame::yaml::Document;
use ri::{Class, Param, Type};

/// Check a metadata file and make its binding; `doc` is the file's text. An error is at the key of the first bad value.
pub fn check(metadata: Metadata, doc: Document) -> Result<Binding, Fault> {
    let output = output(metadata.output);
    output.check(&doc)?;
    let frame_rate = metadata.movie.frame_rate;
    if !(frame_rate > 0.0 && frame_rate <= 1000.0) {
        return Err(doc.fault("movie.frame_rate", "expected a number above 0 and at most 1000"));
    }
    let delimiter = delimiter(&doc, metadata.data.as_ref().and_then(|data| data.delimiter))?;
    let mut camera = metadata.camera.as_ref().map(|spec| camera(spec, &doc)).transpose()?;
    some_objects(&doc, metadata.objects.len())?;
    let data = metadata.data.map(|data| resolve_data(data, delimiter, &doc)).transpose()?;
    let compile = |(i, object): (usize, types::Object)| resolve_object(object, i, &doc)?.compile(&doc, i);
    let objects = metadata.objects.into_iter().enumerate().map(compile).collect::<Result<Vec<Object>, _>>()?;
    if let Some(i) = frame::repeated(objects.iter().map(|object| object.name.as_str())) {
        let message = format!("two objects are named `{}`: scenes take objects by their names", objects[i].name);
        return Err(doc.fault(&format!("objects.{i}.name"), message));
    }
    let stereo = metadata.camera.as_ref().and_then(|spec| spec.stereo);
    let follow = metadata.camera.and_then(|spec| spec.follow);
    if let (Some(Camera::Placed(placed)), Some(text)) = (&mut camera, follow) {
        placed.follow = Some(Formula::compile(&doc, "camera.follow".into(), &text)?);
    }
    let mut overlays = metadata.overlays;
    overlays.check(&doc, matches!(camera, Some(Camera::Placed(_))), &objects)?;
    let (model, scene, lights, ground_height) =
        (metadata.model, metadata.scene, metadata.lights, metadata.ground_height);
    if ground_height.is_some_and(|z| !z.is_finite()) {
        return Err(doc.fault("ground_height", "expected a height in metres"));
    }
    let (made, folders, passes) = (vec![], vec![], vec![]);
    let binding = Binding {
        doc,
        model,
        data,
        up: metadata.up,
        scene,
        camera,
        lights,
        ground_height,
        objects,
        overlays,
        output,
        frame_rate,
        made,
        folders,
        passes,
    };
    Ok(match stereo {
        Some(distance) => pair(binding, distance),
        None => binding,
    })
}

/// A binding of the left eye's images, with the right eye's as a pass.
fn pair(binding: Binding, distance: f32) -> Binding {
    let eye = |aside: f32| {
        let mut one = binding.clone();
        if let Some(Camera::Placed(placed)) = &mut one.camera {
            placed.aside = aside;
        }
        one
    };
    Binding { passes: vec![("right".into(), eye(distance / 2.0))], ..eye(-distance / 2.0) }
}

fn output(o: types::Output) -> Output {
    let format = match o.format {
        types::ImageFormat::Png => ImageFormat::Png,
        types::ImageFormat::Exr => ImageFormat::Exr,
    };
    let quality = match o.quality {
        types::Quality::Draft => Quality::Draft,
        types::Quality::Normal => Quality::Normal,
        types::Quality::Final => Quality::Final,
    };
    Output {
        resolution: o.resolution,
        quality,
        samples: o.samples.unwrap_or(quality.samples()),
        shading_rate: o.shading_rate.unwrap_or(quality.shading_rate()),
        format,
        bits: o.bits,
        channels: o.channels,
        shutter: o.shutter,
        frames: o.frames,
        levels: o.levels,
        filter: (o.filter.name, o.filter.width),
    }
}

fn resolve_data(data: types::Data, delimiter: Option<u8>, doc: &Document) -> Result<Data, Fault> {
    let place = match (data.run, data.files, data.csv) {
        (Some(folder), None, None) => Some(Place::Run(folder)),
        (None, Some(pattern), None) | (None, None, Some(pattern)) => {
            let layout = Layout { delimiter, header: data.header, names: data.columns, min_cells: data.least_cells };
            Some(Place::Files { pattern, layout, rename: data.rename, time: data.time })
        }
        _ => None,
    };
    let derive: Vec<_> = data.derive.into_iter().map(|d| (d.column, d.formula)).collect();
    Data::compile(doc, place, &derive, data.select.as_deref())
}

/// The camera, without the rows that it follows.
fn camera(c: &CameraSpec, doc: &Document) -> Result<Camera, Fault> {
    if c.file.is_none() && c.view.is_none() && (c.eye.is_none() || c.look_at.is_none()) {
        return Err(doc.fault("camera", "needs `eye` and `look_at`, a `view`, or a `file`"));
    }
    if c.view.is_some() && c.orthographic.is_none() {
        return Err(doc.fault("camera.view", "needs `orthographic`: metres across the shorter side of the image"));
    }
    if c.view.is_some() && c.eye.is_some() {
        return Err(doc.fault("camera.view", "stands instead of `eye`, not beside it"));
    }
    if c.view.is_some() && !c.keys.is_empty() {
        return Err(doc.fault("camera.keys", "belong to a camera with `eye` and `look_at`"));
    }
    let moves =
        c.orbit.is_some() || c.turns.is_some() || c.follow.is_some() || !c.keys.is_empty() || c.stereo.is_some();
    if c.file.is_some() && (moves || c.view.is_some()) {
        return Err(doc.fault("camera", "a camera from a file stays as the file has it"));
    }
    let lens = lens(c, doc)?;
    if c.stereo.is_some_and(|s| !(s > 0.0 && s.is_finite())) {
        return Err(doc.fault("camera.stereo", "expected the distance of the eyes in metres, more than 0"));
    }
    if c.stereo.is_some() && c.orthographic.is_some() {
        return Err(doc.fault("camera.stereo", "belongs to a camera in perspective"));
    }
    if c.orbit.is_some_and(|o| !o.is_finite()) {
        return Err(doc.fault("camera.orbit", "expected degrees a frame"));
    }
    if c.turns.is_some_and(|turns| !turns.is_finite()) {
        return Err(doc.fault("camera.turns", "expected a number of turns"));
    }
    if c.turns.is_some() && c.orbit.is_some() {
        return Err(doc.fault("camera.turns", "stands instead of `orbit`, not beside it"));
    }
    if c.damping.is_some_and(|frames| !(frames > 0.0 && frames <= 1000.0)) {
        return Err(doc.fault("camera.damping", "expected a number of frames above 0 and at most 1000"));
    }
    if c.damping.is_some() && c.follow.is_none() {
        return Err(doc.fault("camera.damping", "needs `follow`: what is followed is smoothed"));
    }
    if !(c.fov > 0.0 && c.fov < 179.0) {
        return Err(doc.fault("camera.fov", format!("is {}, expected an angle between 0 and 179 degrees", c.fov)));
    }
    if let Some(file) = &c.file {
        return Ok(Camera::File(file.clone()));
    }
    let (eye, look_at, up) = place(c);
    let way = glam::Vec3::from(look_at) - glam::Vec3::from(eye);
    if !(way.cross(up.into()).length() > 0.0) {
        return Err(doc.fault("camera", "cannot look along `up`, nor at the place where it stands"));
    }
    if let Some(lens) = lens.as_ref().filter(|_| c.keys.is_empty()) {
        lens.check(doc, way.length(), None)?;
    }
    let projection = c.orthographic.map_or(Projection::Perspective(c.fov), Projection::Parallel);
    let keys = keys(c, (eye, look_at), doc)?;
    Ok(Camera::Placed(Box::new(Placed {
        eye,
        look_at,
        up,
        projection,
        orbit: c.orbit,
        turns: c.turns,
        follow: None,
        damping: c.damping,
        way: Default::default(),
        lens,
        keys,
        aside: 0.0,
    })))
}

/// The lens of a camera in perspective, if it has one.
fn lens(c: &CameraSpec, doc: &Document) -> Result<Option<Lens>, Fault> {
    let lens = c.lens.as_ref();
    let lens = lens.map(|l| Lens { f_stop: l.f_stop, focal_length: l.focal_length, focus: l.focus });
    if let Some(lens) = &lens {
        if c.file.is_some() || c.orthographic.is_some() {
            return Err(doc.fault("camera.lens", "belongs to a camera with `eye` and `look_at` in perspective"));
        }
        let numbers =
            [("f_stop", lens.f_stop), ("focal_length", lens.focal_length), ("focus", lens.focus.unwrap_or(1.0))];
        if let Some((name, _)) = numbers.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
            return Err(doc.fault(&format!("camera.lens.{name}"), "expected a number above 0"));
        }
    }
    Ok(lens)
}

/// The keyframes: what one does not give is as before.
fn keys(c: &CameraSpec, (mut eye, mut look_at): ([f32; 3], [f32; 3]), doc: &Document) -> Result<Vec<Key>, Fault> {
    let mut fov = c.orthographic.unwrap_or(c.fov);
    let mut keys: Vec<Key> = vec![];
    for (k, spec) in c.keys.iter().enumerate() {
        let fault = |name: &str, message: &str| Err(doc.fault(&format!("camera.keys.{k}.{name}"), message));
        if !spec.frame.is_finite() || keys.last().is_some_and(|last| last.frame >= spec.frame) {
            return fault("frame", "expected a frame after that of the key before");
        }
        if spec.fov.is_some() && c.orthographic.is_some() {
            return fault("fov", "belongs to a camera in perspective");
        }
        (eye, look_at, fov) = (spec.eye.unwrap_or(eye), spec.look_at.unwrap_or(look_at), spec.fov.unwrap_or(fov));
        if c.orthographic.is_none() && !(fov > 0.0 && fov < 179.0) {
            return fault("fov", "expected an angle between 0 and 179 degrees");
        }
        if !(glam::Vec3::from(look_at) - glam::Vec3::from(eye)).cross(c.up.into()).length().is_normal() {
            return fault("eye", "cannot look along `up`, nor at the place where it stands");
        }
        keys.push(Key { frame: spec.frame, eye, look_at, fov, cut: spec.cut });
    }
    Ok(keys)
}

/// Eye, what it looks at, and what is up, before the camera goes anywhere.
fn place(c: &CameraSpec) -> ([f32; 3], [f32; 3], [f32; 3]) {
    let at = c.look_at.unwrap_or_default();
    let (way, up) = match c.view {
        Some(View::Front) => ([100.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        Some(View::Side) => ([0.0, -100.0, 0.0], [0.0, 0.0, 1.0]),
        Some(View::Top) => ([0.0, 0.0, 100.0], [0.0, 1.0, 0.0]),
        None => return (c.eye.unwrap_or_default(), at, c.up),
    };
    ([0, 1, 2].map(|k| at[k] + way[k]), at, up)
}

/// The `i`th object, its geometry being one shape.
fn resolve_object(object: types::Object, i: usize, doc: &Document) -> Result<Object<String, String>, Fault> {
    let Some(shape) = shape(object.geometry, i, doc)? else {
        return Err(doc.fault(
            &format!("objects.{i}.geometry"),
            "needs exactly one of `sphere`, `box`, `ellipsoid`, `cylinder`, `capsule`, `cone`, `plane`, `archive`, `arrow` and `trail`",
        ));
    };
    let of_contacts = object.rows == types::RowsOf::Contacts;
    if of_contacts && matches!(shape, Shape::Trail(_)) {
        return Err(doc.fault(&format!("objects.{i}.rows"), "contacts have no trails: they are others in every frame"));
    }
    Ok(Object {
        name: object.name,
        of_contacts,
        select: object.select,
        shape,
        position: object.position.map(text),
        orientation: object.orientation.map(|q| q.map(text)),
        velocity: object.velocity.map(|v| v.map(text)),
        surface: object.surface.map(shader),
        displacement: object.displacement.map(shader),
        color: match object.color {
            types::Color::Rgb(rgb) => Color::Rgb(within_one(rgb, i, doc)?),
            types::Color::Column(by) => Color::By { value: text(by.column), map: by.map, range: by.range },
        },
        opacity: object.opacity,
        attributes: vec![],
        is_ground: object.ground,
    })
}

/// Check that a colour reflects no more than all light.
fn within_one(rgb: [f32; 3], i: usize, doc: &Document) -> Result<[f32; 3], Fault> {
    let Some(x) = rgb.iter().find(|x| **x < 0.0 || **x > 1.0) else { return Ok(rgb) };
    let fault = doc.fault(&format!("objects.{i}.color"), format!("has {x}, expected numbers from 0 to 1"));
    if rgb.iter().any(|x| !(0.0..=255.0).contains(x)) {
        return Err(fault);
    }
    // Linear, as colours of a metadata file are.
    let [r, g, b] = rgb.map(|x| ((x / 255.0).powf(2.2) * 1000.0).round() / 1000.0);
    Err(fault.hint(format!(
        "colours are linear: of the 8-bit colour {}, {}, {} of a screen it is [{r}, {g}, {b}]",
        rgb[0], rgb[1], rgb[2]
    )))
}

/// The one shape of a geometry of the `i`th object; none if it has several, or none.
fn shape(g: types::Geometry, i: usize, doc: &Document) -> Result<Option<Shape<String>>, Fault> {
    let round = |spec: types::RoundSpec| [text(spec.radius), text(spec.half)];
    let found = [
        g.sphere.map(|s| Shape::Sphere(text(s.radius))),
        g.block.map(|s| Shape::Box(s.half.map(text))),
        g.ellipsoid.map(|s| Shape::Ellipsoid(s.half.map(text))),
        g.cylinder.map(|s| Shape::Cylinder(round(s))),
        g.capsule.map(|s| Shape::Capsule(round(s))),
        g.cone.map(|s| Shape::Cone(round(s))),
        g.plane.map(|s| Shape::Plane(text(s.half))),
        g.archive.map(|s| archive(s, i, doc)).transpose()?,
        g.arrow.map(|s| arrow(s, i, doc)).transpose()?,
        g.trail.map(|s| trail(s, i, doc)).transpose()?,
    ];
    let mut found = found.into_iter().flatten();
    Ok(found.next().filter(|_| found.next().is_none()))
}

/// A shape of files: one, or one for each value of a column.
fn archive(spec: types::ArchiveSpec, i: usize, doc: &Document) -> Result<Shape<String>, Fault> {
    let source = match (spec.file, spec.column, spec.files) {
        (Some(file), None, files) if files.is_empty() => Archive::File(file),
        (None, Some(column), files) if !files.is_empty() => {
            Archive::ByColumn { column, files: files.into_iter().collect() }
        }
        _ => {
            let message = "needs `file`, or `column` and `files`: a file for each value of the column";
            return Err(doc.fault(&format!("objects.{i}.geometry.archive"), message));
        }
    };
    Ok(Shape::Archive(source, text(spec.scale)))
}

/// An arrow.
fn arrow(spec: types::ArrowSpec, i: usize, doc: &Document) -> Result<Shape<String>, Fault> {
    for (name, value) in [("scale", spec.scale), ("width", spec.width)] {
        above_zero(value, &format!("objects.{i}.geometry.arrow.{name}"), doc)?;
    }
    Ok(Shape::Arrow(Arrow { vector: spec.vector.map(text), scale: spec.scale, width: spec.width }))
}

/// A trail, of a time or a number of frames.
fn trail(spec: types::TrailSpec, i: usize, doc: &Document) -> Result<Shape<String>, Fault> {
    let key = format!("objects.{i}.geometry.trail");
    for (name, value) in [("length", spec.length), ("width", spec.width)] {
        above_zero(value, &format!("{key}.{name}"), doc)?;
    }
    let reach = match (spec.length, spec.frames) {
        (Some(seconds), None) => Reach::Time(seconds),
        (None, Some(0)) => return Err(doc.fault(&format!("{key}.frames"), "expected a whole number of frames above 0")),
        (None, Some(frames)) => Reach::Frames(frames),
        _ => return Err(doc.fault(&key, "needs `length`, a time in s, or `frames`, their number")),
    };
    Ok(Shape::Trail(Trail { reach, width: spec.width, fade: spec.fade }))
}

/// Check that a length, if it is given, is above 0.
fn above_zero(value: Option<f64>, key: &str, doc: &Document) -> Result<(), Fault> {
    match value {
        Some(x) if !(x > 0.0 && x.is_finite()) => Err(doc.fault(key, "expected a number above 0")),
        _ => Ok(()),
    }
}

/// A quantity as the text of an expression.
fn text(q: Quantity) -> String {
    match q {
        Quantity::Number(x) => format!("({x})"),
        Quantity::Expression(text) => text,
    }
}

fn shader(shader: types::Shader) -> Shader {
    let param = |(name, value): (String, Parameter)| match value {
        Parameter::Number(x) => Param::floats(&name, Class::Uniform, Type::Float, [x]),
        Parameter::Triple(x) => Param::floats(&name, Class::Uniform, Type::Color, x),
        Parameter::Text(text) => Param::string(&name, &text),
    };
    Shader {
        name: shader.name,
        bound: shader.bound,
        traced: shader.traced.unwrap_or(true),
        params: shader.parameters.into_iter().map(param).collect(),
    }
}
