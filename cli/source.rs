//! Where a command's frames come from: a run directory, a metadata file's data, or the run of its model, simulated at need.

use crate::job::{self, Yaml};
use crate::report::{Exit, Failure, Outcome};
use crate::simulate;
use bind::Binding;
use bind::data::{Source, Store};
use frame::run::RunReader;
use frame::{Fault, FaultKind};
use sim::model_file;
use sim::run::{self, Span};
use std::path::{Path, PathBuf};

/// Simulate a model into `folder`, unless the finished run of just this model is there.
pub fn ensure_run(model: &Path, folder: &Path, fresh: bool) -> Outcome {
    let (file, resolved) = model_file::read(model)?;
    if !file.sweep.is_empty() {
        let message =
            format!("{} has a `sweep`: simulate it with `scree simulate`, then render its runs", model.display());
        return Err(Failure::new(Exit::Usage, message));
    }
    if !fresh && run::is_done(&file, folder) {
        eprintln!("simulation: {} holds the run of this model already", folder.display());
        return Ok(());
    }
    simulate::simulate(&file, resolved, folder, &Span::default())
}

/// The data of a metadata file: what it names, or the run of its model, simulated if it is not there.
pub fn data_of(checked: &Binding, home: &Path, fresh: bool) -> Outcome<Source> {
    match (&checked.data, &checked.model) {
        (Some(_), _) => Ok(checked.open_data()?),
        (None, Some(model)) => {
            let path = checked.folder().join(model);
            if !path.is_file() {
                return Err(checked.doc.fault("model", format!("the model {} does not exist", path.display())).into());
            }
            ensure_run(&path, home, fresh)?;
            Ok(Store::Run(RunReader::open(home)?).into())
        }
        (None, None) => {
            Err(checked.doc.fault("data", "has neither `data` nor `model`: there is nothing to draw").into())
        }
    }
}

/// Open what `scree render` and `scree rib` are given: a run directory or a metadata file; and where its results go.
pub fn open(input: &Path) -> Outcome<(Binding, Source, PathBuf)> {
    if !input.exists() {
        return Err(Fault::whole(FaultKind::Input, input, "does not exist").into());
    }
    if input.is_dir() {
        if !RunReader::is_run(input) {
            let fault = Fault::whole(FaultKind::Data, input, "is not a run directory: it has no run.json");
            return Err(fault.into());
        }
        let (checked, source) = job::metadata_of_run(input)?;
        return Ok((checked, source, input.into()));
    }
    let home = job::default_output(input);
    match job::kind_of(input)? {
        Yaml::Model => Err(Failure::new(
            Exit::Usage,
            format!("{} is a model: simulate it first, or give it to `scree run`", input.display()),
        )),
        Yaml::Metadata => {
            let checked = bind::read(input)?;
            let source = data_of(&checked, &home, false)?;
            Ok((checked, source, home))
        }
    }
}
