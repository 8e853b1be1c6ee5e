//! Input files of several commands: the kind of a file, a run directory with its metadata, and what a metadata file needs of the
//! library.

use crate::library;
use crate::report::{Exit, Failure, Outcome};
use bind::binding::{Binding, Camera};
use bind::data::Source;
use frame::run::RunReader;
use frame::{Fault, FaultKind, foreign};
use render::Context;
use std::collections::BTreeMap;
use std::path::Path;

/// Kinds of YAML file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Yaml {
    /// A model.
    Model,
    /// A metadata file.
    Metadata,
}

/// The kind of a YAML file, told by its keys.
pub fn kind_of(path: &Path) -> Outcome<Yaml> {
    if path.is_file() && frame::sequence::is_table(path) {
        let fault = Fault::whole(
            FaultKind::Input,
            path,
            "is a table: expected a model or a metadata file, which says how it is drawn",
        );
        return Err(fault.hint(table_hint(path)).into());
    }
    if let Some(format) =
        foreign::by_ending(path).filter(|_| path.is_file() && path.extension().is_none_or(|e| e != "json"))
    {
        return Err(Fault { kind: FaultKind::Input, ..format.fault(path) }.into());
    }
    let (keys, doc): (BTreeMap<String, serde::de::IgnoredAny>, _) = frame::yaml::read(path)?;
    let has = |names: &[&str]| names.iter().any(|n| keys.contains_key(*n));
    if has(&["objects", "model", "data", "scene", bind::chronorender::ROOT]) {
        Ok(Yaml::Metadata)
    } else if has(&["bodies", "fills", "assemblies", "terrains", "base", "stages", "materials", "gravity", "step"]) {
        Ok(Yaml::Model)
    } else {
        let message =
            "is neither a model (expected `bodies`, `fills`, `materials`) nor a metadata file (expected `objects`)";
        Err(doc.fault("", message).into())
    }
}

/// How a table is rendered.
pub fn table_hint(path: &Path) -> String {
    format!(
        "write a metadata file for it and render that: scree inspect '{}' --write md.yaml; scree render md.yaml",
        path.display()
    )
}

/// Whether an input is a RIB scene by its name, `-` being standard input.
pub fn is_scene(input: &Path) -> bool {
    let name = input.to_string_lossy();
    name == "-" || [".rib", ".rib.gz", ".ribz"].iter().any(|e| name.ends_with(e))
}

/// The metadata of a run directory, bound to the run's own data.
pub fn metadata_of_run(folder: &Path) -> Outcome<(Binding, Source)> {
    let run = RunReader::open(folder)?;
    let path = folder.join("metadata.yaml");
    if !path.is_file() {
        let hint = format!("write one with `scree inspect {} --write {}`", folder.display(), path.display());
        return Err(Fault::whole(FaultKind::Data, &path, "is missing: it says what to render").hint(hint).into());
    }
    let mut binding = bind::read(&path)?;
    let source = binding.take_run(run);
    Ok((binding, source))
}

/// Check that scene, camera and lights of a binding exist, and that its shaders exist, compile and have the parameters given.
pub fn check_library(binding: &Binding) -> Outcome {
    let files = binding.files(library::files(&binding.folder()));
    let mut context = Context::new(files.clone()).map_err(|f| Failure::new(Exit::Input, f.message))?;
    let camera = match &binding.camera {
        // A moving camera has a file for each frame, which is looked for when the frame is rendered.
        Some(Camera::File(file)) if !file.contains("{frame") => Some(file),
        _ => None,
    };
    for (key, name) in [("scene", Some(&binding.scene)), ("lights", binding.lights.as_ref()), ("camera.file", camera)] {
        if let Some(name) = name {
            files.read(name, &["scenes"]).map_err(|e| binding.doc.fault(key, e))?;
        }
    }
    // In jobs of Chrono::Render the renderer's own warning tells of them.
    let is_job = binding.doc.has(bind::chronorender::ROOT);
    for (i, object) in binding.objects.iter().enumerate() {
        for (kind, shader) in [("surface", &object.surface), ("displacement", &object.displacement)] {
            let Some(shader) = shader else { continue };
            let key = format!("objects.{i}.{kind}");
            let known = context
                .shader_parameters(&shader.name, kind)
                .map_err(|f| binding.doc.fault(&format!("{key}.name"), f.message))?;
            let names: Vec<&str> = known.iter().map(String::as_str).collect();
            let unknown = shader.params.iter().map(|p| &p.decl.name).find(|p| !names.contains(&p.as_str()));
            if let Some(name) = unknown.filter(|_| !is_job) {
                let noun = format!("parameter of `{}`", shader.name);
                return Err(binding.doc.unknown(&format!("{key}.{name}"), &noun, name, &names).into());
            }
        }
    }
    Ok(())
}

/// The name of a metadata file in the folder of a model that draws it, if there is one.
pub fn metadata_beside(model: &Path) -> Option<String> {
    let path = model.with_file_name("metadata.yaml");
    let binding = bind::read(&path).ok()?;
    let named = binding.folder().join(binding.model.as_ref()?);
    let is_it = named.canonicalize().ok()? == model.canonicalize().ok()?;
    is_it.then(|| guard::text::shell_word(&path.display().to_string()))
}
