//! The job of `scree export`.

use super::run_folder::spare_link;
use crate::args::{ExportArgs, FormatArg};
use crate::report::{Exit, Failure, Outcome};
use crate::source::{self, Yaml};
use bind::data::Source;
use frame::export::Format;
use frame::list::FrameList;
use frame::run::RunReader;
use std::path::{Path, PathBuf};

/// Frames to write as files of other programs.
pub struct ExportJob {
    /// The data.
    pub source: Source,
    /// The frames, in order.
    pub frames: Vec<u64>,
    /// The kind of file.
    pub format: Format,
    /// The folder of the files.
    pub folder: PathBuf,
    /// What their names begin with.
    pub stem: String,
}

impl ExportJob {
    /// Check the arguments: open the data, and choose its frames.
    pub fn check(args: ExportArgs) -> Outcome<ExportJob> {
        let source = open(&args.data, args.time.as_deref())?;
        let existing = source.numbers();
        let select = |list: &FrameList| list.select(&existing);
        let frames = args.frames.as_ref().map_or_else(|| Ok(existing.clone()), select);
        let frames = frames.map_err(|m| Failure::new(Exit::Usage, format!("--frames: {m}")))?;
        if frames.is_empty() {
            return Err(Failure::new(Exit::Data, "the data has no frames yet"));
        }
        let is_run = args.data.is_dir();
        let is_default = args.output.is_none();
        let folder = args.output.unwrap_or_else(|| if is_run { args.data.join("export") } else { "export".into() });
        if RunReader::is_run(&folder) || folder.parent().is_some_and(RunReader::is_run) && folder.ends_with("frames") {
            let message = format!("{} has a run's own files: give another folder, -o DIR (--output)", folder.display());
            return Err(Failure::new(Exit::Usage, message));
        }
        if is_run && is_default {
            spare_link(&folder, &args.data)?;
        }
        guard::allow(&folder);
        let whole = std::path::absolute(&args.data).unwrap_or_else(|_| args.data.clone());
        let name = whole.file_stem().unwrap_or_default().to_string_lossy();
        let name = name.trim_end_matches(|c: char| c.is_ascii_digit() || "*_-.".contains(c));
        let stem = if name.is_empty() { "frame".into() } else { guard::text::file_name(name, ".-") };
        Ok(ExportJob { source, frames, format: args.to.into(), folder, stem })
    }
}

/// The data of a run directory, a metadata file, or tables.
fn open(data: &Path, time: Option<&str>) -> Outcome<Source> {
    let is_yaml = data.extension().is_some_and(|ending| ending == "yaml" || ending == "yml");
    if !is_yaml || !data.is_file() {
        return Ok(Source::open(data, time)?);
    }
    if time.is_some() {
        let message = "--time is for tables: a metadata file has `data.time`";
        return Err(Failure::new(Exit::Usage, message));
    }
    if source::kind_of(data)? == Yaml::Model {
        let message = format!("{} is a model: simulate it, and export its run", data.display());
        return Err(Failure::new(Exit::Usage, message));
    }
    let binding = bind::read(data)?;
    if binding.data.is_none() {
        let message = "has no `data`: simulate its model, and export the run";
        return Err(binding.doc.fault("model", message).into());
    }
    Ok(binding.open_data()?)
}

impl From<FormatArg> for Format {
    fn from(format: FormatArg) -> Format {
        match format {
            FormatArg::Vtu => Format::Vtu,
            FormatArg::Parquet => Format::Parquet,
            FormatArg::Xyz => Format::Xyz,
            FormatArg::Ply => Format::Ply,
            FormatArg::Csv => Format::Csv,
        }
    }
}
