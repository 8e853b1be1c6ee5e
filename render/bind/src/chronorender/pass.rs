//! The images of a job: each render pass of it, or all of it if it has none.

use super::data::{self, Table};
use super::job::{Job, Map, ROOT, elements_of, list_of, text};
use super::objects::{Drawn, Source};
use super::places::Places;
use super::scene::{Parts, scene};
use super::shaders::{self, shader};
use crate::Up;
use crate::binding::{Binding, Camera, Data, ImageFormat, Output, Overlays, Place, Shader, delimiter, some_objects};
use frame::Fault;
use frame::yaml::Document;
use serde_yaml::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Keys of a render pass.
const PASS: [&str; 14] = [
    "name",
    "type",
    "settings",
    "shader",
    "camera",
    "scene",
    "lighting",
    "renderobject",
    "resolution",
    "shadingrate",
    "pixelsamples",
    "display",
    "attribute",
    "option",
];

/// Make the binding of a job: that of its first render pass, with the other passes in [`Binding::passes`]. An error is at the place
/// of the first unknown key or bad value.
pub fn check(root: &Value, doc: Document) -> Result<Binding, Fault> {
    let job = Job { doc: &doc };
    let top = job.map(
        ROOT,
        root,
        &["rendersettings", "camera", "lighting", "scene", "renderpass", "simulation", "movie", "distributed"],
    )?;
    say_idle(&job, &top)?;
    let mut passes = Vec::new();
    for (key, value) in job.list(&top, "renderpass")? {
        let map = job.map(&key, &value, &PASS)?;
        // Whatever lights shine, shadows are traced: nothing has to be made for them first.
        if map.get("type").map(text).as_deref() != Some("shadow") {
            passes.push((key, map));
        }
    }
    let mut all = Vec::new();
    for (k, pass) in passes.iter().map(Some).chain(passes.is_empty().then_some(None)).enumerate() {
        let name = pass.and_then(|(_, map)| map.get("name")).map_or(format!("pass{k}"), text);
        // Names become folders.
        let name = guard::text::file_name(&name, "-.");
        all.push((name.trim_matches('.').to_string(), image(&job, &top, pass)?));
    }
    // All of the file is read before any of it is checked.
    let mut all =
        all.into_iter().map(|(name, image)| Ok((name, image.check(&doc)?))).collect::<Result<Vec<_>, Fault>>()?;
    let (_, mut first) = all.remove(0);
    for k in 0..all.len() {
        if all[..k].iter().any(|(name, _)| *name == all[k].0) {
            all[k].0 = format!("{}{}", all[k].0, k + 1);
        }
    }
    first.passes = all;
    Ok(first)
}

/// Warn of what a job says in vain of all its images.
fn say_idle(job: &Job<'_>, top: &Map) -> Result<(), Fault> {
    let movie = "`scree movie` makes a film of the images";
    let idle = [("movie", movie), ("distributed", "`scree submit` spreads the frames over a cluster")];
    job.no_effect(ROOT, top, &idle);
    let Some((key, value)) = job.first(top, "rendersettings")? else { return Ok(()) };
    let idle = [
        ("out", "images are written to the folder of `-o`"),
        ("fileformat", "an `output` of a `display` that ends in .exr makes EXR files, any other PNG files"),
        ("padding", "files are named by the number of the frame, with six digits or more"),
        ("renderer", "scree draws the images itself"),
        ("verbosity", "`--verbose` says more"),
        ("path", "files are looked for in `searchpaths`"),
    ];
    job.no_effect(&key, &job.map(&key, &value, &[])?, &idle);
    Ok(())
}

/// What a job says of an image, not checked yet.
struct Image {
    scene_file: String,
    camera: Option<String>,
    output: Output,
    table: Table,
    /// The objects, each with the key of its element.
    objects: Vec<(String, Drawn)>,
    /// The key of the settings, and that of the data.
    keys: [String; 2],
    made: Vec<(String, String)>,
    folders: Vec<PathBuf>,
}

impl Image {
    fn check(self, doc: &Document) -> Result<Binding, Fault> {
        let doc = &self.places(doc);
        self.output.check(doc)?;
        let layout = self.table.layout(delimiter(doc, self.table.delimiter)?);
        some_objects(doc, self.objects.len())?;
        let Table { pattern, derive, select, .. } = self.table;
        let place = Place::Files { pattern, layout, rename: BTreeMap::new(), time: None };
        let data = Data::compile(doc, Some(place), &derive, select.as_deref())?;
        let compile = |(i, (_, object)): (usize, (String, Drawn))| object.compile(doc, i);
        Ok(Binding {
            doc: doc.clone(),
            model: None,
            data: Some(data),
            scene: self.scene_file,
            camera: self.camera.map(Camera::File),
            lights: None,
            up: Up::Z,
            ground_height: None,
            objects: self.objects.into_iter().enumerate().map(compile).collect::<Result<_, _>>()?,
            overlays: Overlays::default(),
            output: self.output,
            frame_rate: 24.0,
            made: self.made,
            folders: self.folders,
            passes: vec![],
        })
    }
}

impl Image {
    /// The document, in which the keys of a metadata file, by which faults of a binding are found, stand where the job says the same.
    fn places(&self, doc: &Document) -> Document {
        let mut doc = doc.clone();
        let [settings, data] = &self.keys;
        let parts = [("resolution", "resolution"), ("samples", "pixelsamples"), ("shading_rate", "shadingrate")];
        for (key, own) in parts {
            doc.stand(&format!("output.{key}"), &format!("{settings}.{own}"));
        }
        for (key, own) in [("output", settings.as_str()), ("data", data.as_str()), ("scene", ROOT), ("objects", ROOT)] {
            doc.stand(key, own);
        }
        let parts = [
            ("select", "condition"),
            ("color", "color"),
            ("geometry", "geometry"),
            ("surface", "shader"),
            ("displacement", "shader"),
        ];
        for (i, (own, _)) in self.objects.iter().enumerate() {
            doc.stand(&format!("objects.{i}"), own);
            doc.stand(&format!("objects.{i}.position"), data);
            for (key, part) in parts {
                doc.stand(&format!("objects.{i}.{key}"), &format!("{own}.{part}"));
            }
        }
        doc
    }
}

/// What the job says of the image of a render pass, or of the one image of a job without any.
fn image(job: &Job<'_>, top: &Map, pass: Option<&(String, Map)>) -> Result<Image, Fault> {
    let folder = folder_of(&job.doc.path);
    let mut folders = vec![folder.clone()];
    let mut frames = None;
    if let Some((key, value)) = job.first(top, "rendersettings")? {
        let known = ["out", "fileformat", "padding", "searchpaths", "framerange", "renderer", "verbosity", "path"];
        let map = job.map(&key, &value, &known)?;
        if let Some(paths) = map.get("searchpaths") {
            folders.extend(text(paths).split(':').filter(|p| !p.is_empty()).map(|p| folder.join(p)));
        }
        if let Some(range) = map.get("framerange") {
            let ends = job.numbers(&format!("{key}.framerange"), range, 2)?;
            frames = Some(format!("{}-{}", ends[0], ends[1]));
        }
    }
    let places = Places(folders);
    let mut output = Output { resolution: [640, 480], frames, ..Output::default() };
    let surface = match pass {
        Some((key, map)) => settings(job, key, map, &mut output)?,
        None => None,
    };
    let part = |name: &str| match pass.and_then(|(key, map)| Some((key, map.get(name)?))) {
        Some((key, own)) => Ok(list_of(&format!("{key}.{name}"), Some(own))),
        None => job.list(top, name),
    };
    let (camera, lighting) = (part("camera")?, part("lighting")?);
    // Options and attributes may stand in the pass or in its settings.
    let requests = |request: &str, name: &str| -> Result<String, Fault> {
        let Some((key, map)) = pass else { return Ok(String::new()) };
        let inner = map.get("settings").and_then(|settings| settings.get(name));
        let places = [(format!("{key}.{name}"), map.get(name)), (format!("{key}.settings.{name}"), inner)];
        let all =
            places.iter().map(|(key, value)| Ok(shaders::requests(request, &shaders::settings(job, key, *value)?)));
        all.collect()
    };
    let requests = [requests("Option", "option")?, requests("Attribute", "attribute")?];
    let parts = Parts { camera, lighting, scene: part("scene")?, surface, requests };
    let (scene, camera) = scene(job, &parts, &places)?;
    let scene_file = match pass {
        Some((key, _)) => format!("{}.rib", key.replace('.', "_")),
        None => "chronorender.rib".into(),
    };
    let mut made = vec![(format!("scenes/{scene_file}"), scene)];

    let Some((key, simulation)) = job.first(top, "simulation")? else {
        return Err(job.doc.fault(ROOT, "has no `simulation`: there is nothing to draw"));
    };
    let simulation = job.map(&key, &simulation, &["name", "data", "renderobject", "dataprocess"])?;
    let mut table = data::table(job, &key, &simulation, &places)?;
    data::processes(job, &format!("{key}.dataprocess"), simulation.get("dataprocess"), &mut table)?;
    let data_key = format!("{key}.data");
    let (at, list) = match pass.and_then(|(key, map)| Some((key, map.get("renderobject")?))) {
        Some((key, own)) => (format!("{key}.renderobject"), Some(own)),
        None => (format!("{key}.renderobject"), simulation.get("renderobject")),
    };
    let mut objects = Vec::new();
    let mut source = Source { job, table: &table, places: &places, made: &mut made };
    for (k, (key, value)) in list_of(&at, list).into_iter().enumerate() {
        objects.extend(source.objects(&key, k, &value)?.into_iter().map(|object| (key.clone(), object)));
    }
    if let Some(surface) = parts.surface {
        objects.iter_mut().for_each(|(_, o)| o.surface = Some(surface.clone()));
    }
    let settings = pass.map_or(ROOT.into(), |(key, _)| format!("{key}.settings"));
    let keys = [settings, data_key];
    Ok(Image { scene_file, camera, output, table, objects, keys, made, folders: places.0 })
}

/// Settings of a pass; the surface that it puts on everything, if it does.
fn settings(job: &Job<'_>, key: &str, map: &Map, output: &mut Output) -> Result<Option<Shader>, Fault> {
    let known = ["resolution", "shadingrate", "pixelsamples", "display", "searchpath", "bucket", "option", "attribute"];
    let inner =
        map.get("settings").map(|settings| job.map(&format!("{key}.settings"), settings, &known)).transpose()?;
    let idle = [
        ("searchpath", "files are looked for in `searchpaths` of `rendersettings`"),
        ("bucket", "`Option \"limits\" \"bucketsize\"` in the scene says it"),
    ];
    if let Some(inner) = &inner {
        job.no_effect(&format!("{key}.settings"), inner, &idle);
    }
    // What stands in the pass itself counts as if it stood in its settings.
    for (at, map) in [(key.to_string(), Some(map)), (format!("{key}.settings"), inner.as_ref())] {
        let Some(map) = map else { continue };
        if let Some(v) = map.get("resolution") {
            output.resolution = pair(&job.numbers(&format!("{at}.resolution"), v, 2)?);
        }
        if let Some(v) = map.get("pixelsamples") {
            output.samples = pair(&job.numbers(&format!("{at}.pixelsamples"), v, 2)?);
        }
        if let Some(v) = map.get("shadingrate") {
            output.shading_rate = job.numbers(&format!("{at}.shadingrate"), v, 1)?[0] as f32;
        }
        for (k, display) in list_of(&format!("{at}.display"), map.get("display")) {
            let map = job.map(&k, &display, &["output", "outtype", "mode", "name"])?;
            let name = map.get("output").map(text).unwrap_or_default();
            if name.ends_with(".exr") {
                output.format = ImageFormat::Exr;
            } else if !name.is_empty() && !name.ends_with(".png") {
                let message =
                    format!("images are written as PNG, named by the number of the frame, and not as `{name}`");
                job.warn(&format!("{k}.output"), &message);
            }
            job.no_effect(&k, &map, &[("outtype", "the end of `output` says it: .exr or .png")]);
            if map.get("mode").is_some_and(|mode| !matches!(text(mode).as_str(), "rgb" | "rgba")) {
                job.no_effect(&k, &map, &[("mode", "colours are written, expected rgb or rgba")]);
            }
        }
    }
    let kind = map.get("type").map(text).unwrap_or_default();
    let own = map.get("shader").and_then(|all| elements_of(all).first().copied());
    let own = own.map(|one| shader(job, &format!("{key}.shader"), one)).transpose()?;
    match kind.as_str() {
        "ao" | "occlusion" | "envlight" => {
            let shader =
                own.unwrap_or(Shader { name: "occlusionsurf".into(), bound: None, traced: true, params: vec![] });
            Ok(Some(shader))
        }
        "" | "raytrace" | "shadow" | "beauty" | "default" => Ok(own),
        other => {
            let at = format!("{key}.type");
            let known = ["raytrace", "occlusion", "ao", "envlight", "photon_gi", "shadow"];
            if other != "photon_gi" {
                job.warn(&at, &job.doc.unknown(&at, "type of a render pass", other, &known).message);
            }
            job.warn(&at, &format!("a pass of type `{other}` is drawn as `raytrace`"));
            Ok(own)
        }
    }
}

/// Two counts.
fn pair(v: &[f64]) -> [u32; 2] {
    [v[0].max(0.0) as u32, v[1].max(0.0) as u32]
}

/// The folder that a file is in.
fn folder_of(path: &Path) -> PathBuf {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")).into()
}
