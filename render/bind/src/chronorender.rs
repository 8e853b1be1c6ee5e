//! Metadata of Chrono::Render (Python, 2011–2014): its jobs as ours.
//!
//! What the original does differently from what it means is done as it means: matrices come from whole quaternions, angles may be
//! negative, sizes hold for every shape, and a frame's number is the last one in its file's name. Every element may be one map or a
//! list of them. Python hooks cannot be run: the message says what to use instead.

use crate::metadata::{
    ArchiveSpec, BoxSpec, CameraSpec, Checked, Color, Data, Derive, Geometry, Metadata, Object, Output, Parameter,
    PlaneSpec, Quantity, RoundSpec, Shader, SphereSpec,
};
use frame::Fault;
use frame::yaml::Document;
use serde_yaml::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The key that makes a file one of these.
pub const ROOT: &str = "chronorender";

/// Keys of a render pass.
const PASS: [&str; 8] = ["name", "type", "settings", "shader", "camera", "scene", "lighting", "renderobject"];

/// Translate a file that was read: the first render pass, and the others as further pictures of the same data.
pub fn translate(root: &Value, doc: Document) -> Result<Checked, Fault> {
    let job = Job { doc: &doc, folder: folder_of(&doc.path) };
    let top = job.map(
        ROOT,
        root,
        &["rendersettings", "camera", "lighting", "scene", "renderpass", "simulation", "movie", "distributed"],
    )?;
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
        let name: String =
            name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
        all.push((name.trim_matches('.').to_string(), job.picture(&top, pass)?));
    }
    let (_, mut first) = all.remove(0);
    for k in 0..all.len() {
        if all[k].0.is_empty() || all[..k].iter().any(|(name, _)| *name == all[k].0) {
            all[k].0 = format!("{}{}", all[k].0, k + 1);
        }
    }
    first.passes = all;
    Ok(first)
}

struct Job<'a> {
    doc: &'a Document,
    folder: PathBuf,
}

type Map = BTreeMap<String, Value>;

impl Job<'_> {
    /// The metadata of a render pass, or of a job without any.
    fn picture(&self, top: &Map, pass: Option<&(String, Map)>) -> Result<Checked, Fault> {
        let mut places = vec![self.folder.clone()];
        let mut frames = None;
        if let Some((key, value)) = self.first(top, "rendersettings")? {
            let known = ["out", "fileformat", "padding", "searchpaths", "framerange", "renderer", "verbosity", "path"];
            let map = self.map(&key, &value, &known)?;
            if let Some(paths) = map.get("searchpaths") {
                places.extend(text(paths).split(':').filter(|p| !p.is_empty()).map(|p| self.folder.join(p)));
            }
            if let Some(range) = map.get("framerange") {
                let ends = self.numbers(&format!("{key}.framerange"), range, 2)?;
                frames = Some(format!("{}-{}", ends[0], ends[1]));
            }
        }
        let mut output = Output { resolution: [640, 480], frames, ..Output::default() };
        let pass_surface = match pass {
            Some((key, map)) => self.pass(key, map, &mut output)?,
            None => None,
        };
        let part = |name: &str| match pass.and_then(|(key, map)| Some((key, map.get(name)?))) {
            Some((key, own)) => Ok(list_of(&format!("{key}.{name}"), Some(own))),
            None => self.list(top, name),
        };
        // The scene as it was put together: camera, lights, scene, and the data in its place.
        let mut scene =
            String::from("##RenderMan RIB-Structure 1.1\n#scree override PixelSamples\n#scree override PixelFilter\n");
        let mut camera = None;
        for (key, value) in part("camera")? {
            let element = self.element(&key, &value)?;
            if element.get("moving_camera").is_some_and(|v| text(v) == "true") {
                if camera.is_some() {
                    return Err(self.doc.fault(&key, "is a second camera that moves: a picture has one"));
                }
                camera = Some(self.moving_camera(&key, &element, &places)?);
                scene += "#scree inject camera\n";
            } else {
                scene += &self.archives(&key, &element, &places)?;
            }
        }
        scene += "#scree override Format\n#scree override Display\nWorldBegin\n#scree override ShadingRate\n";
        for (key, value) in part("lighting")? {
            scene += &self.archives(&key, &self.element(&key, &value)?, &places)?;
        }
        if let Some(surface) = &pass_surface {
            scene += &format!("Surface \"{}\"{}\n", surface.name, arguments(surface));
        }
        for (key, value) in part("scene")? {
            scene += &self.archives(&key, &self.element(&key, &value)?, &places)?;
        }
        scene += "#scree inject objects\nWorldEnd\n";
        let scene_file = match pass {
            Some((key, _)) => format!("{}.rib", key.replace('.', "_")),
            None => "chronorender.rib".into(),
        };
        let mut made = vec![(format!("scenes/{scene_file}"), scene)];

        let Some((key, simulation)) = self.first(top, "simulation")? else {
            return Err(self.doc.fault(ROOT, "has no `simulation`: there is nothing to draw"));
        };
        let simulation = self.map(&key, &simulation, &["name", "data", "renderobject", "dataprocess"])?;
        let mut data = self.data(&key, &simulation, &places)?;
        self.processes(&format!("{key}.dataprocess"), simulation.get("dataprocess"), &mut data)?;
        let mut objects = Vec::new();
        let (at, list) = match pass.and_then(|(key, map)| Some((key, map.get("renderobject")?))) {
            Some((key, own)) => (format!("{key}.renderobject"), Some(own)),
            None => (format!("{key}.renderobject"), simulation.get("renderobject")),
        };
        for (k, (key, value)) in list_of(&at, list).into_iter().enumerate() {
            self.objects(&key, k, &value, &data, &places, &mut made, &mut objects)?;
        }
        if let Some(surface) = pass_surface {
            objects.iter_mut().for_each(|o| o.surface = Some(surface.clone()));
        }
        let metadata = Metadata { data: Some(data), scene: scene_file, camera, objects, output, ..Metadata::default() };
        Ok(Checked { metadata, doc: self.doc.clone(), made, folders: places, passes: vec![] })
    }

    /// A camera, a light or a scene: a file's name, or a map.
    fn element(&self, key: &str, value: &Value) -> Result<Map, Fault> {
        if let Value::String(_) = value {
            return Ok(Map::from([("filename".into(), value.clone())]));
        }
        let map = self.map(key, value, &["name", "filename", "script", "shader", "moving_camera"])?;
        if map.contains_key("script") {
            return Err(self.no_python(&format!("{key}.script"), "write a RIB file and name it as `filename`"));
        }
        Ok(map)
    }

    /// The lines that read an element's file, and those of its lights.
    fn archives(&self, key: &str, element: &Map, places: &[PathBuf]) -> Result<String, Fault> {
        let mut lines = String::new();
        if let Some(shader) = element.get("shader") {
            for (k, one) in elements_of(shader).into_iter().enumerate() {
                let shader = self.shader(&format!("{key}.shader"), one)?;
                lines += &format!("LightSource \"{}\" {}{}\n", shader.name, 900 + k, arguments(&shader));
            }
        }
        if let Some(file) = element.get("filename").map(text) {
            let found = locate(places, Path::new(&file)).ok_or_else(|| {
                self.doc.fault(&format!("{key}.filename"), format!("there is no file `{file}` in the search paths"))
            })?;
            lines += &format!("ReadArchive \"{}\"\n", found.display());
        }
        Ok(lines)
    }

    /// A camera that has a file a frame: `cam.rib` stands for `cam_0.rib`, `cam_1.rib` …
    fn moving_camera(&self, key: &str, element: &Map, places: &[PathBuf]) -> Result<CameraSpec, Fault> {
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
        let found = rooms(places).into_iter().map(|r| r.join(folder)).find_map(|r| Some((digits(&r)?, r)));
        let Some((digits, room)) = found else {
            let message = format!("there is no file `{stem}_0.{ending}`, or of another frame, in the search paths");
            return Err(self.doc.fault(&format!("{key}.filename"), message));
        };
        let room = std::fs::canonicalize(&room).unwrap_or(room);
        let number = if digits > 0 { format!("{{frame:0{digits}}}") } else { "{frame}".into() };
        let file = room.join(format!("{stem}_{number}.{ending}")).to_string_lossy().into_owned();
        Ok(CameraSpec { file: Some(file), fov: 35.0, up: [0.0, 0.0, 1.0], ..CameraSpec::default() })
    }

    /// What is done to the data: rows are chosen, columns derived.
    fn processes(&self, key: &str, value: Option<&Value>, data: &mut Data) -> Result<(), Fault> {
        for (at, value) in list_of(key, value) {
            let map =
                self.map(&at, &value, &["type", "name", "condition", "formula", "field_name", "inputs", "args"])?;
            let need = |name: &str| {
                let found = map.get(name).map(text).filter(|t| !t.trim().is_empty());
                found.ok_or_else(|| self.doc.fault(&at, format!("needs a `{name}`")))
            };
            match map.get("type").map(text).unwrap_or_default().as_str() {
                "select" => {
                    let condition = need("condition")?;
                    data.select = Some(match data.select.take() {
                        Some(before) => format!("({before}) and ({condition})"),
                        None => condition,
                    });
                }
                "derive" => data.derive.push(Derive { column: need("field_name")?, formula: need("formula")? }),
                other => {
                    return Err(self.doc.unknown(&format!("{at}.type"), "data process", other, &["select", "derive"]));
                }
            }
        }
        Ok(())
    }

    /// A map with none but known keys; a list of one counts.
    fn map(&self, key: &str, value: &Value, known: &[&str]) -> Result<Map, Fault> {
        let value = match value {
            Value::Sequence(list) if list.len() == 1 => &list[0],
            other => other,
        };
        let Value::Mapping(map) = value else { return Err(self.doc.fault(key, "expected a map")) };
        let mut out = Map::new();
        for (name, value) in map {
            let name = text(name);
            if !known.is_empty() && !known.contains(&name.as_str()) {
                return Err(self.doc.unknown(&format!("{key}.{name}"), "key", &name, known));
            }
            out.insert(name, value.clone());
        }
        Ok(out)
    }

    fn list(&self, map: &Map, name: &str) -> Result<Vec<(String, Value)>, Fault> {
        Ok(list_of(&format!("{ROOT}.{name}"), map.get(name)))
    }

    fn first(&self, map: &Map, name: &str) -> Result<Option<(String, Value)>, Fault> {
        Ok(self.list(map, name)?.into_iter().next())
    }

    /// Numbers of a list, or of a string of them.
    fn numbers(&self, key: &str, value: &Value, n: usize) -> Result<Vec<f64>, Fault> {
        let words: Vec<String> = match value {
            Value::Sequence(list) => list.iter().map(text).collect(),
            other => text(other).replace(',', " ").split_whitespace().map(String::from).collect(),
        };
        let numbers: Option<Vec<f64>> = words.iter().map(|w| w.parse().ok()).collect();
        match numbers.filter(|v| v.len() == n) {
            Some(v) => Ok(v),
            None => Err(self.doc.fault(key, format!("expected {n} numbers, found `{}`", words.join(" ")))),
        }
    }

    fn no_python(&self, key: &str, instead: &str) -> Fault {
        self.doc.fault(key, "calls Python, which is not run").hint(instead)
    }

    /// Settings of a pass; the surface that it puts on everything, if it does.
    fn pass(&self, key: &str, map: &Map, output: &mut Output) -> Result<Option<Shader>, Fault> {
        if let Some(settings) = map.get("settings") {
            let at = format!("{key}.settings");
            let known = ["resolution", "shadingrate", "pixelsamples", "display", "searchpath", "bucket", "option"];
            let map = self.map(&at, settings, &known)?;
            if let Some(v) = map.get("resolution") {
                output.resolution = pair(&self.numbers(&format!("{at}.resolution"), v, 2)?);
            }
            if let Some(v) = map.get("pixelsamples") {
                output.samples = pair(&self.numbers(&format!("{at}.pixelsamples"), v, 2)?);
            }
            if let Some(v) = map.get("shadingrate") {
                output.shading_rate = self.numbers(&format!("{at}.shadingrate"), v, 1)?[0] as f32;
            }
            for (k, display) in list_of(&format!("{at}.display"), map.get("display")) {
                let map = self.map(&k, &display, &["output", "outtype", "mode", "name"])?;
                let name = map.get("output").map(text).unwrap_or_default();
                if name.ends_with(".exr") {
                    output.format = crate::metadata::ImageFormat::Exr;
                }
            }
        }
        let kind = map.get("type").map(text).unwrap_or_default();
        let own = match map.get("shader") {
            Some(shader) => Some(self.shader(&format!("{key}.shader"), elements_of(shader)[0])?),
            None => None,
        };
        match kind.as_str() {
            "ao" | "occlusion" | "envlight" => {
                let shader =
                    own.unwrap_or(Shader { name: "occlusionsurf".into(), bound: None, parameters: BTreeMap::new() });
                Ok(Some(shader))
            }
            "" | "raytrace" | "shadow" | "beauty" | "default" => Ok(own),
            other => Err(self.doc.unknown(
                &format!("{key}.type"),
                "type of a render pass",
                other,
                &["raytrace", "occlusion", "ao", "envlight", "shadow"],
            )),
        }
    }

    fn data(&self, key: &str, simulation: &Map, places: &[PathBuf]) -> Result<Data, Fault> {
        let at = format!("{key}.data");
        let Some(data) = simulation.get("data") else { return Err(self.doc.fault(key, "has no `data`")) };
        let map = self.map(&at, data, &["name", "datasource", "dataprocess"])?;
        let process = (format!("{at}.dataprocess"), map.get("dataprocess").cloned());
        let sources = list_of(&format!("{at}.datasource"), map.get("datasource"));
        let Some((at, source)) = sources.first() else { return Err(self.doc.fault(&at, "has no `datasource`")) };
        let known = ["type", "name", "resource", "fields", "delim", "read_header", "skip_rows", "comments", "missing"];
        let map = self.map(at, source, &known)?;
        if let Some(kind) = map.get("type").map(text).filter(|t| t != "csv") {
            return Err(self.doc.unknown(&format!("{at}.type"), "data source", &kind, &["csv"]));
        }
        let resource = map.get("resource").map(text).unwrap_or_default();
        let found = locate_pattern(places, &resource).ok_or_else(|| {
            self.doc.fault(&format!("{at}.resource"), format!("no file fits `{resource}` in the search paths"))
        })?;
        let mut columns = Vec::new();
        for field in map.get("fields").and_then(Value::as_sequence).into_iter().flatten() {
            columns.push(match field {
                Value::Sequence(pair) if !pair.is_empty() => text(&pair[0]),
                other => text(other),
            });
        }
        let delimiter = map.get("delim").map(text).and_then(|d| d.chars().next()).filter(|c| *c != ' ');
        let header = map.get("read_header").and_then(Value::as_bool);
        let mut data = Data {
            csv: Some(found),
            delimiter,
            header: header.or((!columns.is_empty()).then_some(false)),
            columns: (!columns.is_empty()).then_some(columns),
            ..Data::default()
        };
        if data.columns.is_none() && is_exported(&data) {
            data.columns = Some(EXPORTED.map(String::from).to_vec());
            (data.header, data.least_cells) = (Some(false), Some(EXPORTED_LEAST));
        }
        self.processes(&process.0, process.1.as_ref(), &mut data)?;
        Ok(data)
    }

    /// A shader: its name and its parameters.
    fn shader(&self, key: &str, value: &Value) -> Result<Shader, Fault> {
        let map = self.map(key, value, &[])?;
        let Some(name) = map.get("name") else { return Err(self.doc.fault(key, "a shader needs a `name`")) };
        let mut parameters = BTreeMap::new();
        for (name, value) in &map {
            if matches!(name.as_str(), "name" | "type") {
                continue;
            }
            // `int samples: 4`: the last word is the name.
            let name = name.split_whitespace().last().unwrap_or(name).to_string();
            let words = text(value);
            let numbers: Vec<f32> = words.split_whitespace().filter_map(|w| w.parse().ok()).collect();
            let parameter = match (numbers.as_slice(), value) {
                ([x], _) => Parameter::Number(*x),
                ([r, g, b], _) => Parameter::Triple([*r, *g, *b]),
                (_, Value::Sequence(list)) if list.len() == 3 => {
                    let v = self.numbers(&format!("{key}.{name}"), value, 3)?;
                    Parameter::Triple([v[0] as f32, v[1] as f32, v[2] as f32])
                }
                _ => Parameter::Text(words),
            };
            parameters.insert(name, parameter);
        }
        Ok(Shader { name: text(name).trim_end_matches(".sl").to_string(), bound: None, parameters })
    }

    #[allow(clippy::too_many_arguments)]
    fn objects(
        &self,
        key: &str,
        index: usize,
        value: &Value,
        data: &Data,
        places: &[PathBuf],
        made: &mut Vec<(String, String)>,
        out: &mut Vec<Object>,
    ) -> Result<(), Fault> {
        let columns = data.columns.as_deref().unwrap_or_default();
        let known = ["name", "condition", "color", "geometry", "shader", "instanced", "attribute", "script", "range"];
        let map = self.map(key, value, &known)?;
        if map.contains_key("script") {
            return Err(
                self.no_python(&format!("{key}.script"), "describe the shape as `geometry`, or make a RIB archive")
            );
        }
        let name = map.get("name").map(text).unwrap_or(format!("object{index}"));
        let select = map.get("condition").map(text).filter(|c| !c.trim().is_empty());
        let color = match map.get("color") {
            Some(v) => {
                let v = self.numbers(&format!("{key}.color"), v, 3)?;
                Color::Rgb([v[0] as f32, v[1] as f32, v[2] as f32])
            }
            None => Color::default(),
        };
        let (mut surface, mut displacement) = (None, None);
        for (k, value) in list_of(&format!("{key}.shader"), map.get("shader")) {
            let shader = self.shader(&k, &value)?;
            let kind = value.get("type").map(text).unwrap_or_default();
            if kind == "displacement" { displacement = Some(shader) } else { surface = Some(shader) }
        }
        let mut shapes = Vec::new();
        for (at, shape) in list_of(&format!("{key}.geometry"), map.get("geometry")) {
            shapes.push((None, self.geometry(&at, &shape, places, made)?));
        }
        if shapes.is_empty() && columns == EXPORTED {
            // Every row says itself what it is.
            shapes = self.exported_shapes(key, data, places)?;
        }
        if shapes.is_empty() {
            return Err(self.doc.fault(key, "has no `geometry`"));
        }
        let n = shapes.len();
        for (k, (own, geometry)) in shapes.into_iter().enumerate() {
            let select = match (&select, own) {
                (Some(a), Some(b)) => Some(format!("({a}) and {b}")),
                (a, b) => b.or(a.clone()),
            };
            out.push(Object {
                name: if n == 1 { name.clone() } else { format!("{name}{k}") },
                select,
                geometry,
                position: ["pos_x", "pos_y", "pos_z"].map(|c| Quantity::Expression(c.into())),
                orientation: orientation(columns),
                velocity: None,
                surface: surface.clone(),
                displacement: displacement.clone(),
                color: color.clone(),
                opacity: None,
            });
        }
        Ok(())
    }

    /// Conditions and geometries of the types that the rows of an exported table have.
    fn exported_shapes(
        &self,
        key: &str,
        data: &Data,
        places: &[PathBuf],
    ) -> Result<Vec<(Option<String>, Geometry)>, Fault> {
        let ep = |k: usize| Quantity::Expression(format!("ep{k}"));
        let round = RoundSpec { radius: ep(1), half: ep(2) };
        let three = BoxSpec { half: [ep(1), ep(2), ep(3)] };
        let none = Geometry::default;
        let mut shapes: Vec<(Option<String>, Geometry)> = vec![
            ("sphere", Geometry { sphere: Some(SphereSpec { radius: ep(1) }), ..none() }),
            ("cube", Geometry { block: Some(BoxSpec { half: [ep(1), ep(1), ep(1)] }), ..none() }),
            ("box", Geometry { block: Some(three.clone()), ..none() }),
            ("ellipsoid", Geometry { ellipsoid: Some(three), ..none() }),
            ("cylinder", Geometry { cylinder: Some(round.clone()), ..none() }),
            ("cone", Geometry { cone: Some(round), ..none() }),
        ]
        .into_iter()
        .map(|(kind, geometry)| (Some(format!("type == '{kind}'")), geometry))
        .collect();
        // Files of meshes are named in the rows: those of the first frame are taken for all.
        let Some(path) = first_file(data) else { return Ok(shapes) };
        let table = frame::csv::read(&path, 0, &data.layout())?;
        let mut files: Vec<String> = Vec::new();
        if let (Some(kinds), Some(sizes)) = (table.column("type"), table.column("ep1")) {
            for file in (0..table.rows()).filter(|row| kinds.text(*row) == "obj").map(|row| sizes.text(row)) {
                if !files.contains(&file) {
                    files.push(file);
                }
            }
        }
        for file in files {
            let found = locate(places, Path::new(&file))
                .ok_or_else(|| self.doc.fault(key, format!("there is no file `{file}` in the search paths")))?;
            let archive = ArchiveSpec { file: found.to_string_lossy().into_owned(), scale: Quantity::Number(1.0) };
            let geometry = Geometry { archive: Some(archive), ..none() };
            shapes.push((Some(format!("type == 'obj' and ep1 == '{file}'")), geometry));
        }
        Ok(shapes)
    }

    fn geometry(
        &self,
        key: &str,
        value: &Value,
        places: &[PathBuf],
        made: &mut Vec<(String, String)>,
    ) -> Result<Geometry, Fault> {
        let known = [
            "type",
            "name",
            "radius",
            "side",
            "xlength",
            "ylength",
            "zlength",
            "height",
            "a",
            "b",
            "c",
            "rmajor",
            "rminor",
            "filename",
            "changingparams",
            "dims",
            "script",
            "scale",
        ];
        let map = self.map(key, value, &known)?;
        if map.contains_key("script") {
            return Err(self.no_python(&format!("{key}.script"), "make a RIB archive and use `type: archive`"));
        }
        let kind = map.get("type").map(text).unwrap_or_default();
        // With `changingparams` the columns ep1, ep2 … have the sizes, in the order of the names here.
        let from_data = map.get("changingparams").is_some_and(|v| text(v) == "true");
        let size = |k: usize, name: &str| -> Result<Quantity, Fault> {
            if from_data {
                return Ok(Quantity::Expression(format!("ep{k}")));
            }
            match map.get(name) {
                Some(v) => Ok(Quantity::Number(self.numbers(&format!("{key}.{name}"), v, 1)?[0])),
                None => {
                    // As the original has it.
                    let (line, _) = self.doc.place(key);
                    eprintln!("warning: {}:{line}: the {kind} has no `{name}`: 1 is taken", self.doc.path.display());
                    Ok(Quantity::Number(1.0))
                }
            }
        };
        let mut inline = |rib: String| {
            let name = format!("chronorender_{}.rib", made.len());
            made.push((format!("scenes/{name}"), rib));
            Geometry { archive: Some(ArchiveSpec { file: name, scale: Quantity::Number(1.0) }), ..Geometry::default() }
        };
        Ok(match kind.as_str() {
            "sphere" => Geometry { sphere: Some(SphereSpec { radius: size(1, "radius")? }), ..Geometry::default() },
            "cube" => {
                let half = size(1, "side")?;
                Geometry { block: Some(BoxSpec { half: [half.clone(), half.clone(), half] }), ..Geometry::default() }
            }
            "box" => Geometry {
                block: Some(BoxSpec { half: [size(1, "xlength")?, size(2, "ylength")?, size(3, "zlength")?] }),
                ..Geometry::default()
            },
            "ellipsoid" => Geometry {
                ellipsoid: Some(BoxSpec { half: [size(1, "a")?, size(2, "b")?, size(3, "c")?] }),
                ..Geometry::default()
            },
            "cone" | "cylinder" => {
                let spec = Some(RoundSpec { radius: size(1, "radius")?, half: size(2, "height")? });
                if kind == "cone" {
                    Geometry { cone: spec, ..Geometry::default() }
                } else {
                    Geometry { cylinder: spec, ..Geometry::default() }
                }
            }
            "plane" => Geometry { plane: Some(PlaneSpec { half: size(1, "side")? }), ..Geometry::default() },
            "disk" | "torus" if from_data => {
                return Err(self.doc.fault(key, format!("a {kind} cannot take its sizes from the data")));
            }
            "disk" => inline(format!("Disk 0 {} 360\n", number(&size(1, "radius")?))),
            "torus" => {
                inline(format!("Torus {} {} 0 360 360\n", number(&size(1, "rmajor")?), number(&size(2, "rminor")?)))
            }
            "archive" | "file" | "delayedarchive" => {
                let file = map.get("filename").map(text).unwrap_or_default();
                let found = locate(places, Path::new(&file)).ok_or_else(|| {
                    self.doc.fault(&format!("{key}.filename"), format!("there is no file `{file}` in the search paths"))
                })?;
                let file = found.to_string_lossy().into_owned();
                let archive = Some(ArchiveSpec { file, scale: Quantity::Number(1.0) });
                Geometry { archive, ..Geometry::default() }
            }
            other => {
                let known =
                    ["sphere", "cube", "box", "ellipsoid", "cone", "cylinder", "disk", "torus", "archive", "plane"];
                return Err(self.doc.unknown(&format!("{key}.type"), "geometry", other, &known));
            }
        })
    }
}

/// Columns of a table that Chrono::Render's exporter for Blender has written; the last ones as far as the row's type has sizes.
const EXPORTED: [&str; 13] =
    ["group", "id", "pos_x", "pos_y", "pos_z", "quat_w", "quat_x", "quat_y", "quat_z", "type", "ep1", "ep2", "ep3"];

/// As many cells its rows have at least.
const EXPORTED_LEAST: usize = 11;

fn first_file(data: &Data) -> Option<PathBuf> {
    frame::sequence::find(data.csv.as_ref()?).ok()?.into_values().next()
}

/// Whether files without a header look as the exporter writes them: the tenth cell is the name of a shape.
fn is_exported(data: &Data) -> bool {
    let Some(text) = first_file(data).and_then(|path| std::fs::read_to_string(path).ok()) else { return false };
    let line = text.lines().find(|l| !l.trim().is_empty() && !l.starts_with('#')).unwrap_or_default();
    let cells: Vec<&str> = line.split(data.delimiter.unwrap_or(',')).map(str::trim).collect();
    let shapes = ["sphere", "cube", "box", "ellipsoid", "cylinder", "cone", "obj"];
    cells.len() >= EXPORTED_LEAST && shapes.contains(&cells[9])
}

/// The quaternion of a row: its own columns, or the angles that the original turns by about x, then y, then z, degrees.
fn orientation(columns: &[String]) -> Option<[Quantity; 4]> {
    let has = |names: &[&str]| names.iter().all(|n| columns.iter().any(|c| c == n));
    if has(&["quat_w", "quat_x", "quat_y", "quat_z"]) || !has(&["euler_x", "euler_y", "euler_z"]) {
        return None;
    }
    let half = |f: &str, axis: &str| format!("{f}(euler_{axis} * {})", std::f64::consts::PI / 360.0);
    let product =
        |fs: [&str; 3]| ["x", "y", "z"].iter().zip(fs).map(|(a, f)| half(f, a)).collect::<Vec<_>>().join(" * ");
    let (c, s) = ("cos", "sin");
    let part =
        |a: [&str; 3], sign: &str, b: [&str; 3]| Quantity::Expression(format!("{} {sign} {}", product(a), product(b)));
    Some([
        part([c, c, c], "-", [s, s, s]),
        part([s, c, c], "+", [c, s, s]),
        part([c, s, c], "-", [s, c, s]),
        part([c, c, s], "+", [s, s, c]),
    ])
}

fn folder_of(path: &Path) -> PathBuf {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")).into()
}

/// An element's own text.
fn text(value: &Value) -> String {
    match value {
        Value::String(s) => s.clone(),
        Value::Number(n) => n.to_string(),
        Value::Bool(b) => b.to_string(),
        Value::Sequence(list) => list.iter().map(text).collect::<Vec<_>>().join(" "),
        _ => String::new(),
    }
}

fn elements_of(value: &Value) -> Vec<&Value> {
    match value {
        Value::Sequence(list) => list.iter().collect(),
        one => vec![one],
    }
}

/// One element or a list of them, with their keys.
fn list_of(key: &str, value: Option<&Value>) -> Vec<(String, Value)> {
    match value {
        None | Some(Value::Null) => vec![],
        Some(Value::Sequence(list)) => {
            list.iter().enumerate().map(|(k, v)| (format!("{key}.{k}"), v.clone())).collect()
        }
        Some(one) => vec![(key.into(), one.clone())],
    }
}

fn pair(v: &[f64]) -> [u32; 2] {
    [v[0].max(0.0) as u32, v[1].max(0.0) as u32]
}

fn number(q: &Quantity) -> f64 {
    match q {
        Quantity::Number(x) => *x,
        Quantity::Expression(_) => 0.0,
    }
}

/// A shader's parameters in RIB.
fn arguments(shader: &Shader) -> String {
    let one = |(name, value): (&String, &Parameter)| match value {
        Parameter::Number(x) => format!(" \"uniform float {name}\" [{x}]"),
        Parameter::Triple([r, g, b]) => format!(" \"uniform color {name}\" [{r} {g} {b}]"),
        Parameter::Text(text) => format!(" \"uniform string {name}\" [\"{text}\"]"),
    };
    shader.parameters.iter().map(one).collect()
}

/// Where jobs keep their parts: the search paths, and the folders beside and around the file, whose layout its author had elsewhere.
fn rooms(places: &[PathBuf]) -> Vec<PathBuf> {
    let mut out = places.to_vec();
    let folder = &places[0];
    let around = [folder.clone(), folder.join("..")];
    for base in around {
        out.push(base.clone());
        let inner = std::fs::read_dir(&base).into_iter().flatten().flatten().map(|e| e.path());
        let mut inner: Vec<PathBuf> = inner.filter(|p| p.is_dir()).collect();
        inner.sort();
        out.extend(inner);
    }
    out
}

fn locate(places: &[PathBuf], file: &Path) -> Option<PathBuf> {
    let rooms = rooms(places);
    let whole = rooms.iter().map(|room| room.join(file)).find(|p| p.is_file());
    let by_name = || file.file_name().and_then(|name| rooms.iter().map(|room| room.join(name)).find(|p| p.is_file()));
    let found = whole.or_else(by_name)?;
    Some(std::fs::canonicalize(&found).unwrap_or(found))
}

/// The first place where files fit a pattern: as it stands, then by its last parts alone.
fn locate_pattern(places: &[PathBuf], pattern: &str) -> Option<PathBuf> {
    let parts: Vec<&str> = pattern.split('/').filter(|p| !matches!(*p, "" | "." | "..")).collect();
    let fits = |p: &Path| frame::sequence::find(p).is_ok_and(|f| !f.is_empty());
    let rooms = rooms(places);
    let mut tries: Vec<PathBuf> = rooms.iter().take(places.len()).map(|r| r.join(pattern)).collect();
    for k in 0..parts.len() {
        let tail: PathBuf = parts[k..].iter().collect();
        tries.extend(rooms.iter().map(|r| r.join(&tail)));
    }
    let found = tries.into_iter().find(|p| fits(p))?;
    // Absolute, as our own metadata's folder may be another.
    let folder = found.parent().and_then(|p| std::fs::canonicalize(p).ok())?;
    Some(folder.join(found.file_name()?))
}
