//! Where a recording goes: a file, a viewer that runs or is started, or a web page.

use crate::args::Args;
use crate::fault::Failure;
use crate::source::Input;
use rerun::web_viewer::WebViewerConfig;
use rerun::{MemoryLimit, RecordingStream, RecordingStreamBuilder, ServerOptions, SpawnOptions};
use std::net::{IpAddr, TcpListener};
use std::path::{Path, PathBuf};

/// What recordings of Rerun begin with.
const MAGIC: &[u8] = b"RRF";

/// The name under which Rerun keeps the layout that a user made.
const APPLICATION: &str = "scree";

/// An open recording.
pub struct Sink {
    /// The recording.
    pub stream: RecordingStream,
    /// The file that is written, and the name that it gets when it is whole.
    file: Option<(PathBuf, PathBuf)>,
    /// The server of the web page, which ends with the program.
    web: Option<Box<dyn std::any::Any>>,
}

impl Sink {
    /// Whether somebody may still want to look when all has been sent: the program is what serves it.
    pub fn serves(&self) -> bool {
        self.web.is_some()
    }

    /// Send what is left; a file gets its name.
    pub fn close(self) -> Result<(), Failure> {
        if let Err(e) = self.stream.flush_blocking() {
            eprintln!("warning: the viewer did not take all of the recording: {e}");
        }
        drop(self.stream);
        if let Some((part, path)) = self.file {
            std::fs::rename(&part, &path).map_err(|e| Failure::machine(format!("{}: {e}", path.display())))?;
            println!("{}", path.display());
        }
        Ok(())
    }
}

/// Open the recording that the command line asks for.
pub fn open(args: &Args, input: &Input) -> Result<Sink, Failure> {
    let builder = RecordingStreamBuilder::new(APPLICATION).recording_name(input.name.clone());
    if let Some(path) = &args.output {
        return save(path, builder);
    }
    if let Some(url) = &args.connect {
        let stream =
            builder.connect_grpc_opts(url.clone()).map_err(|e| Failure::usage(format!("--connect {url}: {e}")))?;
        return Ok(Sink { stream, file: None, web: None });
    }
    if args.web {
        return serve(args, builder);
    }
    spawn(builder)
}

/// A file, which has its name when it is whole.
fn save(path: &Path, builder: RecordingStreamBuilder) -> Result<Sink, Failure> {
    if path.extension().is_none_or(|ending| ending != "rrd") {
        return Err(Failure::usage(format!("-o {}: a recording ends in .rrd", path.display())));
    }
    let place = guard::place_of(path);
    if place.exists() && !std::fs::read(&place).is_ok_and(|bytes| bytes.starts_with(MAGIC)) {
        return Err(Failure::usage(format!("{} exists, and is no recording: give another name", path.display())));
    }
    let part = place.with_extension(format!("rrd.part-{}", std::process::id()));
    let stream = builder.save(&part).map_err(|e| Failure::machine(format!("{}: {e}", part.display())))?;
    Ok(Sink { stream, file: Some((part, place)), web: None })
}

/// Data and viewer for a browser.
fn serve(args: &Args, builder: RecordingStreamBuilder) -> Result<Sink, Failure> {
    for (flag, port) in [("--port", args.port), ("--web-port", args.web_port)] {
        TcpListener::bind((args.bind, port))
            .map_err(|e| Failure::machine(format!("{}:{port}: {e}; {flag} takes another", args.bind)))?;
    }
    if !args.bind.is_loopback() {
        eprintln!(
            "warning: everybody who reaches {} can look at this data; on a cluster, `ssh -L` keeps it to you",
            args.bind
        );
    }
    let options = ServerOptions { memory_limit: MemoryLimit::from_fraction_of_total(0.25), ..Default::default() };
    let stream = builder.serve_grpc_opts(args.bind.to_string(), args.port, options)?;
    let web = WebViewerConfig {
        bind_ip: args.bind.to_string(),
        web_port: args.web_port.into(),
        open_browser: false,
        ..WebViewerConfig::default()
    };
    let web = web.host_web_viewer().map_err(|e| Failure::machine(format!("the web page: {e}")))?;
    let host = match args.bind {
        ip if ip.is_loopback() || ip.is_unspecified() => "localhost".to_string(),
        IpAddr::V4(ip) => ip.to_string(),
        IpAddr::V6(ip) => format!("[{ip}]"),
    };
    println!("http://{host}:{}/?url=rerun%2Bhttp%3A%2F%2F{host}%3A{}%2Fproxy", args.web_port, args.port);
    Ok(Sink { stream, file: None, web: Some(Box::new(web)) })
}

/// The viewer of this machine, started if it does not run.
fn spawn(builder: RecordingStreamBuilder) -> Result<Sink, Failure> {
    let on_path = |name: &str| {
        let folders = std::env::var_os("PATH").unwrap_or_default();
        std::env::split_paths(&folders).any(|folder| folder.join(name).is_file())
    };
    if !on_path("rerun") && !on_path("rerun.exe") {
        return Err(Failure::machine(format!(
            "the Rerun viewer is not installed: pip install rerun-sdk=={}; \
             without it, --web shows the preview in a browser and -o FILE.rrd saves it",
            rerun::build_info().version
        )));
    }
    let stream = builder.spawn_opts(&SpawnOptions::default())?;
    Ok(Sink { stream, file: None, web: None })
}
