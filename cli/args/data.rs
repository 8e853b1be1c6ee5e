//! Arguments of the commands that look at data: `inspect` and `plot`.

use super::value::{Interval, index, interval};
use clap::Args;
use std::path::PathBuf;

const INSPECT_EXAMPLES: &str = "\
Examples:
  scree inspect runs/pour --frame 12
  scree inspect 'p_*.csv' --write p.yaml";

/// Arguments of `scree inspect`.
#[derive(Args, Debug)]
#[command(after_help = INSPECT_EXAMPLES)]
pub struct InspectArgs {
    /// Run directory, CSV file, or pattern of CSV files, as 'p_*.csv'.
    #[arg(value_name = "DATA")]
    pub data: PathBuf,
    /// Column of times, where the rows of a CSV file are of different times: a
    /// frame is made of each.
    #[arg(long, value_name = "TEXT")]
    pub time: Option<String>,
    /// Metadata file to write for the data, ready for `scree render`.
    #[arg(long, value_name = "FILE")]
    pub write: Option<PathBuf>,
    /// Frame to inspect [default: the first].
    #[arg(short, long, value_name = "FRAME", value_parser = index::<u64>())]
    pub frame: Option<u64>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

const PLOT_EXAMPLES: &str = "\
A folder of runs, as a sweep makes it, or runs of --with give one plot for each
column, with a curve for each run. The vertical range leaves out the first
instant of a run where this would flatten the rest; a note then says so.

Examples:
  scree plot runs/pendulums 'hinge.*' --times 0.5-2
  scree plot runs/sweep 'hinge.f*'
  scree plot runs/a hinge.fx_world --with runs/b --with runs/c";

/// Arguments of `scree plot`.
#[derive(Args, Debug)]
#[command(after_help = PLOT_EXAMPLES)]
pub struct PlotArgs {
    /// Run directory, folder of run directories, or CSV file with a column
    /// `time`.
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Columns of probes.csv or report.csv, as hinge.angle; a name without its
    /// last part, as hinge, stands for hinge.*, and `*` for any characters
    /// [default: all columns].
    #[arg(value_name = "COLUMN")]
    pub columns: Vec<String>,
    /// Overlay another run, or a folder of runs; may be given several times.
    #[arg(long, value_name = "DIR")]
    pub with: Vec<PathBuf>,
    /// Folder of the plots [default: plots/ in RUN, or beside a CSV file].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Interval of time to plot, s, as 0.5-2 [default: the whole run].
    #[arg(long, value_name = "FROM-TO", value_parser = interval, allow_hyphen_values = true)]
    pub times: Option<Interval>,
    /// Extend the vertical range to the first instant of every run.
    #[arg(long)]
    pub full_range: bool,
}
