//! The words of the command line, as clap has them; nothing here is checked beyond their form.

use crate::render::Telling;
use clap::{Parser, Subcommand, ValueEnum};
use render::film::bucket::Shard;
use std::path::PathBuf;

/// Simulate granular material and vehicles, and turn the runs into pictures and movies.
///
/// Start with `scree run metadata/quickstart.yaml`: it simulates, renders and encodes the ready example.
/// Exit codes: 0 done, 1 a fault of the program or the machine, 2 usage, 3 bad input file, 4 bad data, 5 partly done, 130 interrupted.
#[derive(Parser, Debug)]
#[command(name = "scree", version)]
pub struct Args {
    /// Threads to work with; all processors if not given.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand, Debug)]
pub enum Command {
    /// Simulate, render and encode: the whole way from a model or a metadata file to a movie.
    Run(RunArgs),
    /// Simulate a model into a run directory.
    Simulate(SimulateArgs),
    /// Render the frames of a run directory or of a metadata file, or a RIB scene.
    Render(RenderArgs),
    /// Print a frame as RIB, for any RenderMan renderer.
    Rib(RibArgs),
    /// Join the parts of pictures that `render --bucket` has written.
    Stitch(StitchArgs),
    /// Encode the pictures of a folder to a movie.
    Movie(MovieArgs),
    /// Check models, metadata, RIB scenes and shaders, and say what is wrong with them and where.
    Check(CheckArgs),
    /// Check shaders and print what they are: kind, parameters, types and defaults.
    Shader(ShaderArgs),
    /// Print the JSON Schema of models or of metadata, for editors that complete and check.
    Schema(SchemaArgs),
    /// Show columns, ranges and frames of any data, and write a metadata file to start from.
    Inspect(InspectArgs),
    /// Plot the probes of a run: PNG and SVG.
    Plot(PlotArgs),
    /// Solve a friction problem from a file and print how well.
    Solve(SolveArgs),
    /// Measure this machine.
    Bench(BenchArgs),
    /// Say what of the machine scree can use.
    Doctor,
}

#[derive(Parser, Debug)]
pub struct SchemaArgs {
    /// Of what.
    pub of: SchemaOf,
    /// The file [default: the standard output].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// What a schema is of.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum SchemaOf {
    /// Models.
    Model,
    /// Metadata.
    Metadata,
}

#[derive(Parser, Debug)]
pub struct ShaderArgs {
    /// Shader files (.sl), or names of the library.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Print the intermediate representation instead.
    #[arg(long)]
    pub ir: bool,
}

#[derive(Parser, Debug)]
pub struct RunArgs {
    /// A model or a metadata file (YAML).
    pub input: PathBuf,
    /// Where everything goes [default: runs/NAME].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Simulate again even if the same model's run is there.
    #[arg(long)]
    pub fresh: bool,
    #[command(flatten)]
    pub pictures: PictureArgs,
}

#[derive(Parser, Debug)]
pub struct SimulateArgs {
    /// The model (YAML).
    pub model: PathBuf,
    /// The run directory [default: runs/NAME].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Stop at this time, s.
    #[arg(long, value_name = "T")]
    pub until: Option<f64>,
    /// Go on from the run's last checkpoint.
    #[arg(long)]
    pub resume: bool,
    /// Put a value in place of the model's: solver.iterations=80, bodies.block.mass=3; may be given several times.
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = assignment)]
    pub set: Vec<(String, String)>,
    /// Of a model with a `sweep`: simulate only this combination, from 0.
    #[arg(long, value_name = "I")]
    pub sweep_index: Option<usize>,
    /// Of a model with a `sweep`: print the combinations and write a Slurm job array for them, but simulate nothing.
    #[arg(long)]
    pub plan: bool,
    /// What computes.
    #[arg(long, default_value = "auto")]
    pub backend: Backend,
    /// Write frames as CSV rather than Arrow.
    #[arg(long)]
    pub csv: bool,
}

/// `path=value`
fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((path, value)) if !path.trim().is_empty() => Ok((path.trim().into(), value.trim().into())),
        _ => Err(format!("`{text}` is not an assignment: expected PATH=VALUE")),
    }
}

/// What computes.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// The best there is.
    Auto,
    /// The processor.
    Cpu,
    /// A graphics adapter.
    Gpu,
}

#[derive(Parser, Debug)]
pub struct PictureArgs {
    /// Frames: 3, 0-99, 0-99x5 (every fifth), 120x5 (every fifth from 120 on), joined by commas.
    #[arg(short, long, value_name = "LIST")]
    pub frames: Option<String>,
    /// Pixels, as 1280x720.
    #[arg(long, value_name = "WxH", value_parser = resolution)]
    pub res: Option<[u32; 2]>,
    /// Samples along a pixel's side.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub samples: Option<u32>,
    /// Draw only frames whose picture is not there yet.
    #[arg(long)]
    pub missing: bool,
}

/// `1280x720`
fn resolution(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parsed
        .filter(|r: &[u32; 2]| r.iter().all(|n| (1..=65_536).contains(n)))
        .ok_or_else(|| format!("`{text}` is not a size: expected 1280x720"))
}

/// `2/8`: the second of eight shares.
fn share(text: &str) -> Result<Shard, String> {
    let parsed = text.split_once('/').and_then(|(i, n)| Some(Shard { part: i.parse().ok()?, parts: n.parse().ok()? }));
    parsed
        .filter(|s| (1..=s.parts).contains(&s.part) && s.parts <= 100_000)
        .ok_or_else(|| format!("`{text}` is not a share: expected 2/8, from 1/8 to 8/8"))
}

#[derive(Parser, Debug)]
pub struct StitchArgs {
    /// The folder of the parts; the pictures go there too.
    pub folder: PathBuf,
    /// Keep the parts.
    #[arg(long)]
    pub keep: bool,
}

#[derive(Parser, Debug)]
pub struct RenderArgs {
    /// A run directory, a metadata file (YAML) or a scene (.rib).
    pub input: PathBuf,
    /// The folder for the pictures [default: images/ in the run directory, or runs/NAME/images].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub pictures: PictureArgs,
    /// Draw one share of each picture's buckets to a part file, such as 2/8, for `scree stitch` to join.
    #[arg(long, value_name = "I/N", value_parser = share)]
    pub bucket: Option<Shard>,
    /// Say what every picture took.
    #[arg(short, long)]
    pub verbose: bool,
    /// Write what every picture took beside it, as NAME.stats.json.
    #[arg(long)]
    pub stats: bool,
}

impl RenderArgs {
    /// How what pictures take is told.
    pub fn telling(&self) -> Telling {
        Telling { aloud: self.verbose, as_file: self.stats }
    }
}

#[derive(Parser, Debug)]
pub struct RibArgs {
    /// A run directory or a metadata file (YAML).
    pub input: PathBuf,
    /// The frame.
    #[arg(short, long, value_name = "N")]
    pub frame: u64,
    /// The file to write rather than standard output.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

#[derive(Parser, Debug)]
pub struct MovieArgs {
    /// The folder of pictures (PNG).
    pub images: PathBuf,
    /// The movie [default: movie.mp4 beside the folder].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Pictures a second.
    #[arg(long, default_value_t = 24.0, value_name = "N")]
    pub frame_rate: f64,
}

#[derive(Parser, Debug)]
pub struct CheckArgs {
    /// Models and metadata (.yaml), scenes (.rib), shaders (.sl).
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
}

#[derive(Parser, Debug)]
pub struct InspectArgs {
    /// A run directory, or a file or pattern of CSV files, as 'p_*.csv'.
    pub data: PathBuf,
    /// Write a metadata file to start from.
    #[arg(long, value_name = "FILE")]
    pub write: Option<PathBuf>,
    /// The frame to look at; the first if not given.
    #[arg(short, long, value_name = "N")]
    pub frame: Option<u64>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

#[derive(Parser, Debug)]
pub struct PlotArgs {
    /// A run directory.
    pub run: PathBuf,
    /// Columns of probes.csv or report.csv, `*` standing for any characters; everything if none is given.
    #[arg(value_name = "COLUMN")]
    pub columns: Vec<String>,
    /// The folder for the plots [default: plots/ in the run directory].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Times to plot, as 0.5-2 (s).
    #[arg(long, value_name = "FROM-TO")]
    pub times: Option<String>,
}

#[derive(Parser, Debug)]
pub struct SolveArgs {
    /// The problem: number of dimensions and contacts, W as blocks or dense, q, friction.
    pub file: PathBuf,
    /// The law of friction: relaxed or exact.
    #[arg(long, default_value = "exact")]
    pub friction: String,
    /// Stop when the error is below this.
    #[arg(long, default_value_t = 1e-4)]
    pub tolerance: f64,
    /// The most iterations.
    #[arg(long, default_value_t = 1_000_000)]
    pub iterations: u32,
    /// apgd, barzilai_borwein, gauss_seidel, jacobi; the best for the problem if not given.
    #[arg(long)]
    pub method: Option<String>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

#[derive(Parser, Debug)]
pub struct BenchArgs {
    #[command(subcommand)]
    pub what: BenchCommand,
}

#[derive(Subcommand, Debug)]
pub enum BenchCommand {
    /// Spheres that settle in a box.
    Sim {
        /// s: spheres of 0.075 m; a: small spheres of mixed size, as in the anchor's bed.
        #[arg(long, default_value = "s")]
        workload: String,
        /// How many.
        #[arg(long, default_value_t = 8000)]
        n: usize,
        #[arg(long, default_value = "cpu")]
        backend: Backend,
        /// Steps to take; a whole simulated second if not given.
        #[arg(long)]
        steps: Option<u64>,
        /// Step size, s.
        #[arg(long, default_value_t = 1.5e-3)]
        step: f64,
        /// Solver iterations a step.
        #[arg(long, default_value_t = 24)]
        iterations: u32,
        /// apgd, barzilai_borwein, gauss_seidel or jacobi.
        #[arg(long, default_value = "gauss_seidel")]
        method: String,
        /// The law of friction, exact or relaxed; if not given, exact for gauss_seidel, which solves it contact by contact, and
        /// relaxed for the others.
        #[arg(long)]
        friction: Option<String>,
        /// Greatest speed at which overlaps are pushed apart, m/s.
        #[arg(long, default_value_t = 0.03)]
        recovery_speed: f64,
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// A bed of shaded spheres under one light with shadows, 1280×720, 16 samples.
    Render {
        /// How many.
        #[arg(long, default_value_t = 84_000)]
        n: usize,
        #[arg(long, default_value = "cpu")]
        backend: Backend,
        /// The spheres move while the shutter is open: by about a third of their radius.
        #[arg(long)]
        motion: bool,
        /// A lens of this f-stop, sharp in the middle of the picture.
        #[arg(long, value_name = "F")]
        f_stop: Option<f32>,
        /// Pixels a micropolygon.
        #[arg(long, default_value_t = 1.0)]
        shading_rate: f32,
        /// Pixels.
        #[arg(long, value_name = "WxH", value_parser = resolution, default_value = "1280x720")]
        res: [u32; 2],
        /// Keep the picture.
        #[arg(long, value_name = "FILE")]
        image: Option<PathBuf>,
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
}
