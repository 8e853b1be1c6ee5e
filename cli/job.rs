//! What the words of the command line come to: which data, which pictures, where they go; all checked before work starts.

use crate::args::PictureArgs;
use crate::library;
use crate::report::{Exit, Failure, Outcome};
use bind::binding::{Binding, Camera, Data, ImageFormat, Place};
use bind::data::{Source, Store};
use frame::Fault;
use frame::FaultKind;
use frame::run::RunReader;
use render::Context;
use render::ri::files::Files;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What a YAML file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Yaml {
    /// A model.
    Model,
    /// A metadata file.
    Metadata,
}

/// Tell a model from a metadata file by its keys.
pub fn kind_of(path: &Path) -> Outcome<Yaml> {
    let (keys, doc): (BTreeMap<String, serde::de::IgnoredAny>, _) = frame::yaml::read(path)?;
    let has = |names: &[&str]| names.iter().any(|n| keys.contains_key(*n));
    if has(&["objects", "model", "data", "scene", bind::chronorender::ROOT]) {
        Ok(Yaml::Metadata)
    } else if has(&["bodies", "fills", "assemblies", "terrains", "base", "stages", "materials", "gravity", "step"]) {
        Ok(Yaml::Model)
    } else {
        Err(doc
            .fault(
                "",
                "is neither a model (expected `bodies`, `fills`, `materials`) nor a metadata file (expected `objects`)",
            )
            .into())
    }
}

/// The name that a file's results go by: its stem.
pub fn stem(path: &Path) -> String {
    path.file_stem().and_then(|s| s.to_str()).filter(|s| !s.is_empty()).unwrap_or("run").into()
}

/// Where the results of an input go if nothing else is said.
pub fn default_output(input: &Path) -> PathBuf {
    Path::new("runs").join(stem(input))
}

/// Pictures to be made.
pub struct Pictures {
    /// The metadata.
    pub checked: Binding,
    /// The data.
    pub source: Source,
    /// Scenes and shaders.
    pub files: Files,
    /// Frames, in order.
    pub frames: Vec<u64>,
    /// The folder that they go to.
    pub folder: PathBuf,
    /// Other pictures of the same frames, in folders of their own.
    pub passes: Vec<Pictures>,
}

impl Pictures {
    /// Resolve metadata, its data and the options of the command line.
    pub fn resolve(mut checked: Binding, source: Source, folder: PathBuf, args: &PictureArgs) -> Outcome<Pictures> {
        let output = &mut checked.output;
        if let Some(res) = args.res {
            output.resolution = res;
        }
        if let Some(n) = args.samples {
            output.samples = [n; 2];
        }
        let existing = source.numbers();
        if existing.is_empty() {
            return Err(Failure::new(Exit::Data, "the data has no frames yet"));
        }
        let frames = match (&args.frames, &checked.output.frames) {
            (Some(list), _) => {
                bind::frames::parse(list, &existing).map_err(|m| Failure::new(Exit::Usage, format!("--frames: {m}")))?
            }
            (None, Some(list)) => {
                bind::frames::parse(list, &existing).map_err(|m| checked.doc.fault("output.frames", m))?
            }
            (None, None) => existing,
        };
        let files = checked.files(library::files(&checked.folder()));
        checked.check_columns(&source.read(frames[0])?)?;
        check_library(&checked, &files)?;
        let passes = std::mem::take(&mut checked.passes).into_iter();
        let passes = passes.map(|(name, pass)| Pictures::resolve(pass, source.clone(), folder.join(name), args));
        let passes = passes.collect::<Outcome<_>>()?;
        Ok(Pictures { checked, source, files, frames, folder, passes })
    }

    /// The picture of a frame.
    pub fn image(&self, frame: u64) -> PathBuf {
        let ending = match self.checked.output.format {
            ImageFormat::Png => "png",
            ImageFormat::Exr => "exr",
        };
        self.folder.join(format!("{frame:06}.{ending}"))
    }
}

/// Scene, camera and lights are there; shaders are, compile, and have the parameters that the metadata gives them.
pub fn check_library(checked: &Binding, files: &Files) -> Outcome {
    let mut context = Context::new(files.clone()).map_err(|f| Failure::new(Exit::Fault, f.message))?;
    let camera = match &checked.camera {
        // A camera that moves has a file a frame: each is looked for when its frame is drawn.
        Some(Camera::File(file)) if !file.contains("{frame") => Some(file),
        _ => None,
    };
    for (key, name) in [("scene", Some(&checked.scene)), ("lights", checked.lights.as_ref()), ("camera.file", camera)] {
        if let Some(name) = name {
            files.read(name, &["scenes"]).map_err(|e| checked.doc.fault(key, e))?;
        }
    }
    for (i, object) in checked.objects.iter().enumerate() {
        for (kind, shader) in [("surface", &object.surface), ("displacement", &object.displacement)] {
            let Some(shader) = shader else { continue };
            let key = format!("objects.{i}.{kind}");
            let known = context
                .shader_parameters(&shader.name, kind)
                .map_err(|f| checked.doc.fault(&format!("{key}.name"), f.message))?;
            let names: Vec<&str> = known.iter().map(String::as_str).collect();
            if let Some(name) = shader.params.iter().map(|p| &p.decl.name).find(|p| !names.contains(&p.as_str())) {
                return Err(checked
                    .doc
                    .unknown(&format!("{key}.{name}"), &format!("parameter of `{}`", shader.name), name, &names)
                    .into());
            }
        }
    }
    Ok(())
}

/// The metadata of a run directory: its own, with its own data.
pub fn metadata_of_run(folder: &Path) -> Outcome<(Binding, Source)> {
    let run = RunReader::open(folder)?;
    let path = folder.join("metadata.yaml");
    if !path.is_file() {
        let hint = format!("write one with `scree inspect {} --write {}`", folder.display(), path.display());
        return Err(Fault::whole(FaultKind::Data, &path, "is missing: it says what to draw").hint(hint).into());
    }
    let mut checked = bind::read(&path)?;
    checked.data = Some(Data { place: Some(Place::Run(".".into())), derive: vec![], select: None });
    Ok((checked, Store::Run(run).into()))
}
