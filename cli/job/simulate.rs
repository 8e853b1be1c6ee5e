//! The job of `scree simulate`.

use super::output::default_folder;
use super::run_folder;
use super::sweep::SweepJob;
use crate::args::{self, Backend, SimulateArgs};
use crate::report::{Exit, Failure, Outcome};
use frame::run::FrameFormat;
use sim::Quality;
use sim::model_file::{self, ModelFile, Replacement, Resolved};
use sim::run::{Computer, Span};
use std::path::PathBuf;

/// What to simulate.
pub enum SimulateJob {
    /// A model.
    Run {
        /// The run.
        run: Box<ModelRun>,
        /// Whether it is shown meanwhile.
        preview: bool,
    },
    /// A model with a sweep.
    Sweep(SweepJob),
}

/// A run of a model to simulate.
pub struct ModelRun {
    /// The model as it is written.
    pub file: ModelFile,
    /// The model ready to run.
    pub resolved: Resolved,
    /// The run directory.
    pub folder: PathBuf,
    /// The span of time to simulate.
    pub span: Span,
    /// What computes the steps.
    pub computer: Computer,
}

impl SimulateJob {
    /// Check the arguments: read the model with its values replaced.
    pub fn check(args: SimulateArgs) -> Outcome<SimulateJob> {
        let computer = computer(args.backend, args.adapter.clone())?;
        let mut set = replacements(args.set.iter().map(|a| (&a.path, &a.value)));
        if let Some(quality) = args.quality {
            if args.set.iter().any(|a| a.path == "quality") {
                return Err(Failure::new(Exit::Usage, "--quality and --set quality both choose the quality: give one"));
            }
            let value = Quality::from(quality).name().into();
            set.insert(0, Replacement { path: "quality".into(), value, written: None });
        }
        if let Some(stage) = &args.gpu_from {
            set.push(Replacement { path: "gpu_from".into(), value: stage.clone(), written: None });
        }
        let (mut file, doc) = model_file::load(&args.model, &set)?;
        if args.csv {
            file.format = FrameFormat::Csv;
        }
        let folder = args.output.clone().unwrap_or_else(|| default_folder(&args.model));
        guard::allow(&folder);
        if args.preview && !file.sweep.is_empty() {
            return Err(Failure::new(Exit::Usage, "--preview shows one run, and the model has a `sweep`"));
        }
        if !file.sweep.is_empty() {
            return Ok(SimulateJob::Sweep(SweepJob::check(args, (&file, &doc), set, (folder, computer))?));
        }
        if args.plan || args.sweep_index.is_some() {
            return Err(Failure::new(Exit::Usage, "--plan and --sweep-index are for models with a `sweep`"));
        }
        let resolved = file.resolve(&doc)?;
        let span = Span { until: args.until, resume: args.resume };
        run_folder::spare_model(&args.model, &file, &folder)?;
        run_folder::spare_linked(&folder, &folder)?;
        if !args.fresh {
            run_folder::check(&file, &folder, args.until, "scree simulate")?;
        }
        let run = Box::new(ModelRun { file, resolved, folder, span, computer });
        Ok(SimulateJob::Run { run, preview: args.preview })
    }
}

impl From<args::Quality> for Quality {
    fn from(quality: args::Quality) -> Quality {
        match quality {
            args::Quality::Draft => Quality::Draft,
            args::Quality::Normal => Quality::Normal,
            args::Quality::Tight => Quality::Tight,
        }
    }
}

/// Values of the command line in place of the model's: paths and YAML.
pub fn replacements<'a>(set: impl Iterator<Item = (&'a String, &'a String)>) -> Vec<Replacement> {
    set.map(|(path, value)| Replacement { path: path.clone(), value: value.clone(), written: None }).collect()
}

/// What computes the steps of a back end, and of an adapter, if one is chosen.
pub(super) fn computer(backend: Backend, adapter: Option<String>) -> Outcome<Computer> {
    match (backend, adapter) {
        (Backend::Gpu, adapter) => Ok(Computer::Gpu(adapter.map_or(gpu::Choice::Hardware, gpu::Choice::Named))),
        (Backend::Auto, None) => Ok(Computer::Auto),
        (Backend::Cpu, None) => Ok(Computer::Cpu),
        (Backend::Auto | Backend::Cpu, Some(_)) => Err(adapter_alone()),
    }
}

/// An adapter is chosen for another back end.
pub(super) fn adapter_alone() -> Failure {
    Failure::new(Exit::Usage, "--adapter chooses a graphics adapter: give --backend gpu with it")
}

/// Refuse the back end that a benchmark does not have.
pub(super) fn cpu_only(backend: Backend) -> Outcome {
    match backend {
        Backend::Auto | Backend::Cpu => Ok(()),
        Backend::Gpu => Err(Failure::new(
            Exit::Usage,
            "--backend gpu: this benchmark runs on the processor; `scree bench gpu` measures a graphics adapter",
        )),
    }
}
