//! The command line.

use clap::Parser;
use frame::list::FrameList;
use std::net::IpAddr;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  scree preview runs/quickstart
  scree preview runs/quickstart --web
  scree preview 'post/dump_*.liggghts' -o dumps.rrd";

/// Look at a run or any table in the Rerun viewer: while it is simulated, in a
/// browser, or saved to a file.
///
/// A run that is still being simulated is followed until it is complete or
/// Ctrl-C is pressed.
#[derive(Parser, Debug)]
#[command(name = "scree preview", bin_name = "scree preview", version, max_term_width = 80, after_help = EXAMPLES)]
pub struct Args {
    /// Run directory, metadata file, or tables: a file, or a pattern in quotes.
    #[arg(value_name = "INPUT")]
    pub input: PathBuf,
    /// Save a recording (.rrd) in place of opening a viewer.
    #[arg(short, long, value_name = "FILE", conflicts_with_all = ["web", "connect"])]
    pub output: Option<PathBuf>,
    /// Serve the viewer to a web browser; the address is printed.
    #[arg(long, conflicts_with = "connect")]
    pub web: bool,
    /// Send to a viewer that runs already, as rerun+http://HOST:9876/proxy.
    #[arg(long, value_name = "URL")]
    pub connect: Option<String>,
    /// Address to serve at, with --web; any but this machine's own lets others
    /// of the network look at the data.
    #[arg(long, default_value = "127.0.0.1", value_name = "ADDRESS", requires = "web")]
    pub bind: IpAddr,
    /// Port of the data, with --web.
    #[arg(long, default_value_t = 9876, value_name = "PORT", value_parser = clap::value_parser!(u16).range(1..), requires = "web")]
    pub port: u16,
    /// Port of the web page, with --web.
    #[arg(long, default_value_t = 9090, value_name = "PORT", value_parser = clap::value_parser!(u16).range(1..), requires = "web")]
    pub web_port: u16,
    /// Frames to show, as 0-99, 0-999x10 or 5,7 [default: all].
    #[arg(short, long, value_name = "LIST")]
    pub frames: Option<FrameList>,
    /// Show what is there now, and do not wait for more frames.
    #[arg(long)]
    pub no_follow: bool,
    /// Wait for a run directory that is not there yet.
    #[arg(long, conflicts_with = "no_follow")]
    pub wait: bool,
    /// Velocities as arrows, as long as the way of this many seconds.
    #[arg(long, value_name = "SECONDS", value_parser = above_zero)]
    pub velocities: Option<f32>,
    /// Contact forces as arrows, this many metres for each newton (runs with
    /// `contact_tables`).
    #[arg(long, value_name = "M/N", value_parser = above_zero)]
    pub contacts: Option<f32>,
    /// Bodies of an object at most; of more, evenly spread ones are shown.
    #[arg(long, default_value_t = 1_000_000, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub most: u32,
}

/// A number above zero.
fn above_zero(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("expected a number above 0".into()),
    }
}
