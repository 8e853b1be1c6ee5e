//! The scree command: simulate, render, encode.
//!
//! `args` holds the words of the command line, `job` checks and resolves them, and each subcommand has its file.

mod args;
mod bench;
mod check;
mod doctor;
mod geometry;
mod inspect;
mod job;
mod library;
mod movie;
mod plot;
mod progress;
mod render;
mod report;
mod rib;
mod run;
mod schema;
mod shader;
mod simulate;
mod solve;
mod source;
mod stitch;
mod sweep;

use args::{Args, Command};
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    quiet_when_nobody_reads();
    give_large_blocks_back();
    let args = Args::parse();
    if let Some(threads) = args.threads
        && let Err(e) = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()
    {
        eprintln!("error: cannot start {threads} threads: {e}");
        return ExitCode::from(1);
    }
    let done = match args.command {
        Command::Run(a) => run::run(&a),
        Command::Simulate(a) => simulate::command(&a),
        Command::Render(a) => render::command(&a),
        Command::Rib(a) => rib::command(&a),
        Command::Stitch(a) => stitch::command(&a),
        Command::Movie(a) => movie::command(&a),
        Command::Check(a) => check::command(&a),
        Command::Shader(a) => shader::command(&a),
        Command::Schema(a) => schema::command(&a),
        Command::Inspect(a) => inspect::command(&a),
        Command::Plot(a) => plot::command(&a),
        Command::Solve(a) => solve::command(&a),
        Command::Bench(a) => bench::command(&a),
        Command::Doctor => doctor::command(),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(failure.exit as u8)
        }
    }
}

/// Have large columns from the system itself, and give them back when they are let go: glibc would otherwise keep ever larger ones
/// in its heap, whose holes cost a large bed a third of its memory.
fn give_large_blocks_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the option is of glibc, and nobody else allocates yet.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, 1 << 17);
    }
}

/// Whoever reads our output may stop early, as `head` does: that is an end and no fault.
fn quiet_when_nobody_reads() {
    let otherwise = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if info.payload_as_str().is_some_and(|m| m.contains("Broken pipe")) {
            std::process::exit(0);
        }
        otherwise(info);
    }));
}
