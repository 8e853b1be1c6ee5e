//! The command `scree-preview`: runs and tables in the Rerun viewer, live, served to a browser, or saved.
//!
//! It reads what lies on the disk, and follows a run directory while frames appear there: a viewer that is slow, lost or absent never
//! holds up a simulation.

mod args;
mod blueprint;
mod bodies;
mod curves;
mod fault;
mod follow;
mod mesh;
mod sink;
mod source;

use args::Args;
use clap::Parser;
use fault::Failure;
use std::process::ExitCode;

fn main() -> ExitCode {
    let args = Args::parse();
    match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(failure.exit)
        }
    }
}

fn run(args: &Args) -> Result<(), Failure> {
    let mut input = source::open(args)?;
    let sink = sink::open(args, &input)?;
    follow::show(args, &mut input, &sink)?;
    sink.close()
}
