//! Frames to render, and where they come from: a run directory, the data of a metadata file, or a model's run, simulated if it does
//! not exist yet.

use super::output::default_folder;
use super::run_folder;
use super::simulate::ModelRun;
use crate::report::{Exit, Failure, Outcome};
use crate::source::{self, Yaml};
use bind::Binding;
use bind::data::Source;
use frame::run::RunReader;
use frame::{Fault, FaultKind};
use sim::model_file;
use sim::run::{self, Span};
use std::path::{Path, PathBuf};

/// Frames to render, as far as they are known before a simulation.
pub struct FramesJob {
    /// The run directory, metadata file or model.
    pub input: PathBuf,
    /// What to render of the frames; the metadata that the simulation writes beside its run if not given.
    pub binding: Option<Binding>,
    /// Where the frames come from.
    pub origin: Origin,
    /// The folder of the results.
    pub home: PathBuf,
}

/// Where frames come from.
pub enum Origin {
    /// Data that exists.
    Data(Box<Source>),
    /// The finished run of a model, in the folder of the results; frames of it may have been lost or damaged since.
    Finished(Box<RunReader>),
    /// A model to simulate into that folder.
    Model(Box<ModelRun>),
}

impl FramesJob {
    /// The frames of an input of `scree render` or `scree rib`: a run directory or a metadata file.
    pub fn open(input: &Path) -> Outcome<FramesJob> {
        if !input.exists() {
            let fault = Fault::whole(FaultKind::Input, input, "does not exist");
            let is_pattern = input.to_string_lossy().contains('*');
            return Err(if is_pattern { fault.hint(source::table_hint(input)) } else { fault }.into());
        }
        if input.is_dir() {
            if !RunReader::is_run(input) {
                return Err(frame::sequence::not_a_run(input).into());
            }
            let (binding, source) = source::metadata_of_run(input)?;
            return Ok(FramesJob {
                input: input.into(),
                binding: Some(binding),
                origin: Origin::Data(Box::new(source)),
                home: input.into(),
            });
        }
        match source::kind_of(input)? {
            Yaml::Model => Err(Failure::new(
                Exit::Usage,
                format!("{} is a model: simulate it first, or give it to `scree run`", input.display()),
            )),
            Yaml::Metadata => FramesJob::of_metadata(input, default_folder(input), false),
        }
    }

    /// The frames of a model or a metadata file, with the results in `home`; `fresh` simulates again.
    pub fn of_yaml(input: &Path, home: PathBuf, fresh: bool) -> Outcome<FramesJob> {
        match source::kind_of(input)? {
            Yaml::Model => {
                let origin = Origin::of_model(input, &home, fresh)?;
                Ok(FramesJob { input: input.into(), binding: None, origin, home })
            }
            Yaml::Metadata => FramesJob::of_metadata(input, home, fresh),
        }
    }

    fn of_metadata(input: &Path, home: PathBuf, fresh: bool) -> Outcome<FramesJob> {
        let binding = bind::read(input)?;
        // All that can be checked before hours of simulation is checked before.
        source::check_library(&binding)?;
        let origin = match (&binding.data, &binding.model) {
            (Some(_), _) => Origin::Data(Box::new(binding.open_data()?)),
            (None, Some(model)) => {
                let path = binding.folder().join(model);
                if !path.is_file() {
                    let message = format!("the model {} does not exist", path.display());
                    return Err(binding.doc.fault("model", message).into());
                }
                Origin::of_model(&path, &home, fresh)?
            }
            (None, None) => {
                let message = "neither `data` nor `model` is given: there is nothing to render";
                return Err(binding.doc.fault("data", message).into());
            }
        };
        Ok(FramesJob { input: input.into(), binding: Some(binding), origin, home })
    }
}

impl Origin {
    /// The run of a model in `folder`: the finished one, unless `fresh`, or one to simulate.
    fn of_model(model: &Path, folder: &Path, fresh: bool) -> Outcome<Origin> {
        let (file, resolved) = model_file::read(model)?;
        if !file.sweep.is_empty() {
            let message =
                format!("{} has a `sweep`: simulate it with `scree simulate`, then render its runs", model.display());
            return Err(Failure::new(Exit::Usage, message));
        }
        guard::allow(folder);
        run_folder::spare_model(model, &file, folder)?;
        run_folder::spare_linked(folder, folder)?;
        if !fresh && let Some(run) = run::finished(&file, folder) {
            return Ok(Origin::Finished(Box::new(run)));
        }
        // An unfinished run of the same model continues from its last checkpoint.
        let resume = !fresh && RunReader::is_run(folder);
        if !fresh {
            run_folder::check(&file, folder, None, "scree run")?;
        }
        let span = Span { until: None, resume };
        Ok(Origin::Model(Box::new(ModelRun {
            file,
            resolved,
            folder: folder.into(),
            span,
            computer: Default::default(),
        })))
    }
}
