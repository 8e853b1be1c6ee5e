//! Arguments of the commands that look at data: `inspect`, `plot`, `report`, `export` and `preview`.

use super::value::{Axis, Interval, file_size, index, interval, whole};
use clap::{Args, ValueEnum};
use frame::list::FrameList;
use std::ffi::OsString;
use std::path::PathBuf;

const EXPORT_EXAMPLES: &str = "\
Examples:
  scree export runs/pour --to vtu
  scree export 'dump_*.liggghts' --to parquet -o tables";

/// Kinds of file that frames are exported to.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum FormatArg {
    /// VTK unstructured grids with a collection, for ParaView and VisIt.
    Vtu,
    /// Apache Parquet, for pandas, Polars and DuckDB.
    Parquet,
    /// Extended XYZ, for OVITO and ASE.
    Xyz,
    /// Binary PLY, for Blender and MeshLab.
    Ply,
    /// CSV with units in the header.
    Csv,
}

/// Arguments of `scree export`.
#[derive(Args, Debug)]
#[command(after_help = EXPORT_EXAMPLES)]
pub struct ExportArgs {
    /// Run directory, metadata file, or tables: a file, or a pattern in quotes.
    #[arg(value_name = "DATA")]
    pub data: PathBuf,
    /// Kind of file.
    #[arg(long, value_name = "FORMAT", value_enum)]
    pub to: FormatArg,
    /// Folder of the files [default: export/ in the run directory, or here].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Frames to export, as 0-99x5 [default: all].
    #[arg(short, long, value_name = "LIST")]
    pub frames: Option<FrameList>,
    /// Column of times, where the rows of a table are of different times.
    #[arg(long, value_name = "TEXT")]
    pub time: Option<String>,
}

const INSPECT_EXAMPLES: &str = "\
Examples:
  scree inspect runs/pour --frame 12
  scree inspect 'p_*.csv' --write p.yaml";

/// Arguments of `scree preview`.
#[derive(Args, Debug)]
pub struct PreviewArgs {
    /// Arguments of `scree-preview`: a run or data, and flags; its own --help
    /// lists them.
    #[arg(value_name = "ARGS", trailing_var_arg = true, allow_hyphen_values = true, required = true)]
    pub args: Vec<OsString>,
}

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
    /// Axis of the data that points up, for the metadata file: x, y, z, -x, -y or -z
    /// [default: against the gravity of a run; z of other data].
    #[arg(long, value_name = "AXIS", requires = "write", allow_hyphen_values = true, hide_possible_values = true)]
    pub up: Option<Axis>,
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

const REPORT_EXAMPLES: &str = "\
The page opens without a network: styles, script, images and data are in it. A
film above the size of --embed-film is linked, and so needs to stay where it is.

Examples:
  scree report runs/pour
  scree report runs/pour 'hinge.*' energy -o pour.html --embed-film 100MiB
  scree report runs/sweep";

/// Arguments of `scree report`.
#[derive(Args, Debug)]
#[command(after_help = REPORT_EXAMPLES)]
pub struct ReportArgs {
    /// Run directory, or folder of run directories, as a sweep makes it.
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Columns of probes.csv to plot, as hinge.angle; a name without its last
    /// part, as hinge, stands for hinge.*, and `*` for any characters
    /// [default: all columns].
    #[arg(value_name = "COLUMN")]
    pub columns: Vec<String>,
    /// Page to write [default: report.html in RUN].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Largest film that is put into the page, as 16MiB; a larger one is
    /// linked, and 0 links any.
    #[arg(long, default_value = "16MiB", value_name = "SIZE", value_parser = file_size)]
    pub embed_film: u64,
    /// Images of a run that the page shows, 0 to 60.
    #[arg(long, default_value = "6", value_name = "N", value_parser = whole::<usize>(0..=60))]
    pub images: usize,
}
