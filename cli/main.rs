//! The scree command: simulate, render, encode.
//!
//! Every command takes the same way: `args` parses its command line, `job` makes a checked job of that, and the command's own file
//! does the work of the job. `model_run` and `images` are the work that several commands share; the other files are leaves, which know neither
//! arguments nor jobs.

#[macro_use]
mod print;

mod args;
mod arrivals;
mod batch;
mod bench;
mod check;
mod device;
mod displays;
mod doctor;
mod drawing;
mod export;
mod failed;
mod geometry;
mod image_file;
mod images;
mod init;
mod inspect;
mod interrupt;
mod job;
mod ledger;
mod levels;
mod library;
mod machine;
mod model_run;
mod movie;
mod overlay;
mod page;
mod plan;
mod plot;
mod preview;
mod progress;
mod ranges;
mod render;
mod report;
mod rib;
mod run;
mod schema;
mod shader;
mod shard_file;
mod shell;
mod simulate;
mod solve;
mod source;
mod status;
mod stitch;
mod submit;
mod task;

use args::{Args, Command};
use clap::Parser;
use job::{
    BenchJob, CheckJob, DoctorJob, ExportJob, FilmJob, InitJob, InspectJob, MovieJob, PlanJob, PlotJob, PreviewJob,
    RenderJob, ReportJob, RibJob, RunJob, SchemaJob, ShaderJob, ShellJob, SimulateJob, SolveJob, StatusJob, StitchJob,
    TaskJob,
};
use report::Exit;
use std::process::ExitCode;

#[global_allocator]
static MEMORY: guard::memory::Counting = guard::memory::Counting;

fn main() -> ExitCode {
    if let Err(e) = interrupt::handle() {
        eprintln!("warning: signals end the program without a message: {e}");
    }
    let args = Args::parse();
    reuse_large_blocks(!args.command.simulates());
    std::env::args_os().for_each(guard::give);
    if let Some(threads) = args.threads
        && let Err(e) = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()
    {
        eprintln!("error: cannot start {threads} threads: {e}");
        return ExitCode::from(1);
    }
    machine::limit_memory(args.memory);
    if let Some(root) = &args.root {
        if !root.is_dir() {
            eprintln!("error: --root {}: there is no such folder", root.display());
            return ExitCode::from(Exit::Usage as u8);
        }
        guard::confine(root);
    }
    let outcome = match args.command {
        Command::Init(args) => InitJob::check(args).and_then(init::run),
        Command::Run(args) => RunJob::check(args).and_then(run::run),
        Command::Simulate(args) => SimulateJob::check(args).and_then(simulate::run),
        Command::Render(args) => RenderJob::check(args).and_then(render::run),
        Command::Plan(args) => PlanJob::check(args).and_then(plan::run),
        Command::Submit(args) => FilmJob::check(args).and_then(submit::run),
        Command::Status(args) => StatusJob::check(args).and_then(status::run),
        Command::Verify(args) => StatusJob::verify(args).and_then(status::verify),
        Command::Resume(args) => FilmJob::resume(args).and_then(submit::run),
        Command::Task(args) => TaskJob::check(args).and_then(task::run),
        Command::Movie(args) => MovieJob::check(args).and_then(movie::run),
        Command::Plot(args) => PlotJob::check(args).and_then(plot::run),
        Command::Preview(args) => PreviewJob::check(args).and_then(preview::run),
        Command::Report(args) => ReportJob::check(args).and_then(page::run),
        Command::Inspect(args) => InspectJob::check(args).and_then(inspect::run),
        Command::Export(args) => ExportJob::check(args).and_then(export::run),
        Command::Check(args) => CheckJob::check(args).and_then(check::run),
        Command::Schema(args) => SchemaJob::check(args).and_then(schema::run),
        Command::Shader(args) => ShaderJob::check(args).and_then(shader::run),
        Command::Rib(args) => RibJob::check(args).and_then(rib::run),
        Command::Stitch(args) => StitchJob::check(args).and_then(stitch::run),
        Command::Solve(args) => SolveJob::check(args).and_then(|job| machine::with_all_memory(|| solve::run(job))),
        Command::Bench(args) => BenchJob::check(args).and_then(|job| machine::with_all_memory(|| bench::run(job))),
        Command::Doctor(args) => DoctorJob::check(args).and_then(doctor::run),
        Command::Completions(args) => ShellJob::completions(args).and_then(shell::run),
        Command::Man(args) => ShellJob::man(args).and_then(shell::run),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(failure.exit as u8)
        }
    }
}

/// Whether all columns are kept by the program once they are freed, for the next: tables that are read one after the other take none of
/// the system's time then, which gives memory page by page. A simulation keeps those of up to 8 MiB, a tenth of the time of thousands of boxes,
/// and has larger ones from the system, which gets them back: a heap of ever larger ones has holes that cost a large bed a third of its memory.
fn reuse_large_blocks(is_reused: bool) {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the options are glibc's, and no other thread allocates yet.
    unsafe {
        if is_reused {
            libc::mallopt(libc::M_MMAP_THRESHOLD, 1 << 30);
            libc::mallopt(libc::M_TRIM_THRESHOLD, 1 << 30);
        } else {
            libc::mallopt(libc::M_MMAP_THRESHOLD, 1 << 23);
            libc::mallopt(libc::M_TRIM_THRESHOLD, 1 << 27);
        }
    }
}
