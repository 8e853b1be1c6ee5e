//! `scree simulate`: a model → a run directory.

use crate::args::{Backend, SimulateArgs};
use crate::job;
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome};
use bind::metadata::Data;
use frame::run::{FORMAT_VERSION, FrameFormat, Index, RunReader, RunWriter};
use sim::model_file::{self, ModelFile};
use sim::{Model, Simulation, State, frame_of, report_header, report_line};
use std::path::Path;

/// The command.
pub fn command(args: &SimulateArgs) -> Outcome {
    if args.backend == Backend::Gpu {
        return Err(Failure::new(
            Exit::Usage,
            "--backend gpu: the simulation has no GPU back end yet; use cpu or auto",
        ));
    }
    if let Some(until) = args.until
        && !(until > 0.0 && until.is_finite())
    {
        return Err(Failure::new(Exit::Usage, format!("--until {until}: expected a time above 0")));
    }
    let (mut file, model, state) = model_file::read(&args.model)?;
    if args.csv {
        file.format = FrameFormat::Csv;
    }
    let folder = args.output.clone().unwrap_or_else(|| job::default_output(&args.model));
    simulate(&file, model, state, &folder, args.until)?;
    println!("{}", folder.display());
    Ok(())
}

/// The identity of a resolved model.
pub fn model_hash(file: &ModelFile) -> String {
    frame::run::hash_text(&file.to_yaml())
}

/// Whether a folder holds a finished run of just this model.
pub fn is_done(file: &ModelFile, folder: &Path) -> bool {
    RunReader::open(folder).is_ok_and(|run| {
        run.index.complete
            && run.index.model_hash == model_hash(file)
            && run.index.frames.len() as u64 == run.index.expected_frames
    })
}

/// Run the model into `folder`, up to `until` s or its own end.
pub fn simulate(file: &ModelFile, model: Model, state: State, folder: &Path, until: Option<f64>) -> Outcome {
    let until = until.unwrap_or(model.duration);
    let expected_frames = model.n_frames(until);
    let index = Index {
        format_version: FORMAT_VERSION,
        program: format!("scree {}", env!("CARGO_PKG_VERSION")),
        model_hash: model_hash(file),
        seed: model.seed,
        step_size: model.step,
        backend: "cpu".into(),
        adapter: "cpu".into(),
        units: "SI: m, kg, s, rad".into(),
        expected_frames,
        complete: false,
        columns: vec![],
        frames: vec![],
    };
    let mut run = RunWriter::create(folder, file.format, index)?;
    run.write_file("model.yaml", &file.to_yaml())?;
    let mut sim = Simulation::new(model, state);
    let first = frame_of(&sim.model, &sim.state, 0);
    write_metadata(&run, &first)?;
    run.write_frame(&first)?;
    let mut report = report_header();
    let progress = Progress::start("simulating", expected_frames);
    let period = 1.0 / sim.model.frame_rate;
    for number in 1..expected_frames {
        // The frame's instant is the first step's end that is not before its time.
        while sim.state.time < number as f64 * period - 0.5 * sim.model.step {
            report.push_str(&report_line(&sim.step()));
            if let Some(body) = sim.broken_body() {
                run.write_file("report.csv", &report)?;
                return Err(blown_up(&sim, body, number));
            }
        }
        run.write_frame(&frame_of(&sim.model, &sim.state, number))?;
        run.write_file("report.csv", &report)?;
        progress.at(number + 1);
    }
    run.write_file("report.csv", &report)?;
    run.finish()?;
    progress.finish();
    Ok(())
}

fn blown_up(sim: &Simulation, body: usize, frame: u64) -> Failure {
    let class = &sim.model.class_names[sim.model.class[body] as usize];
    let message = format!(
        "the simulation blew up at step {} ({:.4} s): body {body} of class `{class}` has no finite state; frames before {frame} are kept; try a shorter step",
        sim.state.steps, sim.state.time
    );
    Failure::new(Exit::Data, message)
}

/// What to draw for every class, beside the run, so that `scree render RUN` just works.
fn write_metadata(run: &RunWriter, first: &frame::Frame) -> Outcome {
    let data = Data { run: Some(".".into()), ..Data::default() };
    if let Ok(metadata) = bind::suggest::metadata(data, first) {
        run.write_file("metadata.yaml", &bind::suggest::to_yaml(&metadata, first))?;
    }
    Ok(())
}
