//! The RIB scene of an image: camera, lights and scene of the job, and the data in its place.

use super::job::{Job, Map, elements_of, text};
use super::places::Places;
use super::shaders::{arguments, shader};
use crate::binding::Shader;
use frame::Fault;
use serde_yaml::Value;
use std::path::Path;

/// Elements of one kind, with their keys.
type Elements = Vec<(String, Value)>;

/// The parts of a scene.
pub(super) struct Parts {
    pub(super) camera: Elements,
    pub(super) lighting: Elements,
    pub(super) scene: Elements,
    /// A surface that is put on everything.
    pub(super) surface: Option<Shader>,
    /// Options and attributes of the pass, as requests of RIB.
    pub(super) requests: [String; 2],
}

/// The RIB of a scene, and the file of its camera if that moves.
pub(super) fn scene(job: &Job<'_>, parts: &Parts, places: &Places) -> Result<(String, Option<String>), Fault> {
    let mut scene =
        String::from("##RenderMan RIB-Structure 1.1\n#scree override PixelSamples\n#scree override PixelFilter\n");
    scene += &parts.requests[0];
    let mut camera = None;
    for (key, value) in &parts.camera {
        let element = element(job, key, value)?;
        if element.get("moving_camera").is_some_and(|v| text(v) == "true") {
            if camera.is_some() {
                return Err(job.doc.fault(key, "is a second camera that moves: an image has one"));
            }
            camera = Some(moving_camera(job, key, &element, places)?);
            scene += "#scree inject camera\n";
        } else {
            scene += &archives(job, key, &element, places)?;
        }
    }
    scene += "#scree override Format\n#scree override Display\nWorldBegin\n#scree override ShadingRate\n";
    scene += &parts.requests[1];
    for (key, value) in &parts.lighting {
        scene += &archives(job, key, &element(job, key, value)?, places)?;
    }
    if let Some(surface) = &parts.surface {
        scene += &format!("Surface \"{}\"{}\n", surface.name, arguments(surface));
    }
    for (key, value) in &parts.scene {
        scene += &archives(job, key, &element(job, key, value)?, places)?;
    }
    scene += "#scree inject objects\nWorldEnd\n";
    Ok((scene, camera))
}

/// A camera, a light or a scene: a file's name, or a map.
fn element(job: &Job<'_>, key: &str, value: &Value) -> Result<Map, Fault> {
    if let Value::String(_) = value {
        return Ok(Map::from([("filename".into(), value.clone())]));
    }
    let map = job.map(key, value, &["name", "filename", "script", "shader", "moving_camera"])?;
    if map.contains_key("script") {
        job.no_python(&format!("{key}.script"), "write a RIB file and name it as `filename`");
    }
    Ok(map)
}

/// The lines that read an element's file, and those of its lights.
fn archives(job: &Job<'_>, key: &str, element: &Map, places: &Places) -> Result<String, Fault> {
    let mut lines = String::new();
    if let Some(all) = element.get("shader") {
        for (k, one) in elements_of(all).into_iter().enumerate() {
            let shader = shader(job, &format!("{key}.shader"), one)?;
            lines += &format!("LightSource \"{}\" {}{}\n", shader.name, 900 + k, arguments(&shader));
        }
    }
    if let Some(file) = element.get("filename").map(text) {
        let found = places.locate(Path::new(&file)).ok_or_else(|| {
            job.doc.fault(&format!("{key}.filename"), format!("there is no file `{file}` in the search paths"))
        })?;
        lines += &format!("ReadArchive \"{}\"\n", found.display());
    }
    Ok(lines)
}

/// A camera that has a file a frame: `cam.rib` stands for `cam_0.rib`, `cam_1.rib` …
fn moving_camera(job: &Job<'_>, key: &str, element: &Map, places: &Places) -> Result<String, Fault> {
    let file = element.get("filename").map(text).unwrap_or_default();
    let file = Path::new(&file);
    let stem = file.file_stem().and_then(|s| s.to_str()).unwrap_or_default();
    let ending = file.extension().and_then(|s| s.to_str()).unwrap_or("rib");
    // As many digits as the numbers are padded to with zeros; 0 if they are not.
    let digits = |room: &Path| {
        let names = std::fs::read_dir(room).ok()?.flatten().filter_map(|e| e.file_name().into_string().ok());
        let digits = |name: String| {
            let digits = name.strip_prefix(stem)?.strip_prefix('_')?.strip_suffix(ending)?.strip_suffix('.')?;
            let number = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
            number.then(|| if digits.len() > 1 && digits.starts_with('0') { digits.len() } else { 0 })
        };
        names.filter_map(digits).max()
    };
    let folder = file.parent().unwrap_or(Path::new(""));
    let found = places.rooms().into_iter().map(|r| r.join(folder)).find_map(|r| Some((digits(&r)?, r)));
    let Some((digits, room)) = found else {
        let message = format!("there is no file `{stem}_0.{ending}`, or of another frame, in the search paths");
        return Err(job.doc.fault(&format!("{key}.filename"), message));
    };
    let room = std::fs::canonicalize(&room).unwrap_or(room);
    let number = if digits > 0 { format!("{{frame:0{digits}}}") } else { "{frame}".into() };
    Ok(room.join(format!("{stem}_{number}.{ending}")).to_string_lossy().into_owned())
}
