//! The run directory: the files that a simulation writes, and from which images are rendered.
//!
//! ```text
//! run.json              index of the run and its frames, rewritten whole after every frame
//! model.yaml            the model, enough to run it again
//! frames/000042.arrow   one table per frame (or .csv)
//! report.csv            per step: contacts, iterations, residual, maximum penetration, parts, milliseconds by stage
//! metadata.yaml         geometry and shaders of every class
//! commands.txt          the commands that made the run, a line each
//! ```
//! A frame is identified by its number in `run.json`, never by its position in a listing.

use crate::{Fault, FaultKind, Frame, arrow, atomic, csv, sequence};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashSet};
use std::path::{Component, Path, PathBuf};

/// The version of the run directory's format that [`RunWriter`] writes and [`RunReader`] reads.
pub const FORMAT_VERSION: u32 = 1;

/// The file of the commands that made a run.
pub const COMMANDS: &str = "commands.txt";

/// The file format of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FrameFormat {
    /// Arrow IPC.
    #[default]
    Arrow,
    /// CSV with units in the header.
    Csv,
}

impl FrameFormat {
    /// The extension of file names: `arrow` or `csv`.
    pub fn extension(self) -> &'static str {
        match self {
            FrameFormat::Arrow => "arrow",
            FrameFormat::Csv => "csv",
        }
    }
}

/// The most frames of a run: a folder holds no more files.
pub const MAX_FRAMES: u64 = 100_000_000;

/// A column of the frames, as listed in `run.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColumnEntry {
    /// Name of the column.
    pub name: String,
    /// Type of the values: `f64`, `f32`, `i64` or `category`.
    #[serde(rename = "type")]
    pub kind: String,
    /// Unit, SI; `1` for pure numbers, empty for words and ids.
    pub unit: String,
}

/// A frame, as listed in `run.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameEntry {
    /// The frame's number.
    pub number: u64,
    /// Time, s.
    pub time: f64,
    /// Path of the file, relative to the run directory.
    pub file: String,
    /// Count of rows.
    pub rows: usize,
    /// BLAKE3 hash of the file, hexadecimal.
    pub hash: String,
}

/// The index of a run: the content of `run.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Index {
    /// Version of the format, [`FORMAT_VERSION`].
    pub format_version: u32,
    /// Name and version of the program that wrote the run.
    pub program: String,
    /// Hash of the resolved model, as [`hash_text`] gives it.
    pub model_hash: String,
    /// Seed of the random number generators.
    pub seed: u64,
    /// Step size, s.
    pub step_size: f64,
    /// Frames a second; none in runs of older programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame_rate: Option<f64>,
    /// Back end of the simulation: `cpu` or `gpu`.
    pub backend: String,
    /// Name of the processor or graphics adapter.
    pub adapter: String,
    /// The unit system of all numbers.
    pub units: String,
    /// Count of frames of the complete run.
    pub expected_frames: u64,
    /// Whether the run was completed.
    pub complete: bool,
    /// What ended it before its end; none while it goes on, or where it ended without a word, as by a power cut.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ended: Option<Ended>,
    /// The columns of the frames.
    pub columns: Vec<ColumnEntry>,
    /// Warnings about steps, by kind.
    #[serde(default)]
    pub warnings: Vec<WarningEntry>,
    /// blake3 of the files that the program wrote for the user to edit, by their names: a file that differs was edited.
    #[serde(default)]
    pub generated: BTreeMap<String, String>,
    /// The frames written so far.
    pub frames: Vec<FrameEntry>,
}

/// A warning about the steps of a run, as listed in `run.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WarningEntry {
    /// Kind of the warning: `residual`, `joint` or `energy`.
    pub kind: String,
    /// Count of steps that the warning concerns.
    pub steps: u64,
    /// Index of the first such step, from 1.
    pub first_step: u64,
    /// Time after the first such step, s.
    pub first_time: f64,
    /// Message about the first such step.
    pub message: String,
}

/// What ended a run before its end, as listed in `run.json`. A run that goes on has it no more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ended {
    /// The kind of its end.
    pub by: EndKind,
    /// Index of the last step, from 1.
    pub step: u64,
    /// Time after it, s.
    pub time: f64,
    /// What was wrong; empty of an interruption.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub why: String,
}

/// The kind of end that a run came to before its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EndKind {
    /// The simulation diverged: its state has no more numbers.
    Diverged,
    /// A step had a warning, and the model's `on_divergence` is `stop`.
    Stopped,
    /// Whoever watched it stopped it. It has a checkpoint to go on from.
    Interrupted,
}

/// Files of frames in a folder, whether or not it is a run directory: [`RunWriter::create`] removes them.
fn tables(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let files = std::fs::read_dir(folder.join("frames"))?.flatten().map(|entry| entry.path());
    Ok(files.filter(|path| is_table(path)).collect())
}

fn is_table(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str());
    [FrameFormat::Arrow, FrameFormat::Csv].iter().any(|format| extension == Some(format.extension()))
}

/// Whether a path, relative to a run directory, is that of a table of its frames: what a run removes is nothing else.
fn is_table_of_run(path: &Path) -> bool {
    let parts: Vec<Component> = path.components().collect();
    matches!(parts[..], [Component::Normal(folder), Component::Normal(_)] if folder == "frames") && is_table(path)
}

/// A run directory that is being written.
pub struct RunWriter {
    folder: PathBuf,
    format: FrameFormat,
    index: Index,
}

impl RunWriter {
    /// Start a run in `folder`. Frames of an earlier run there are removed, so that no stale frame can be mistaken for a new one.
    /// An error if a file cannot be written or removed.
    pub fn create(folder: &Path, format: FrameFormat, index: Index) -> Result<RunWriter, Fault> {
        let frames = folder.join("frames");
        std::fs::create_dir_all(&frames).map_err(|e| Fault::unwritable(&frames, &e))?;
        let generated = RunReader::open(folder).map_or_else(|_| BTreeMap::new(), |before| before.index.generated);
        let writer = RunWriter { folder: folder.into(), format, index: Index { generated, ..index } };
        writer.write_index()?;
        for path in tables(folder).map_err(|e| Fault::unwritable(&frames, &e))? {
            std::fs::remove_file(&path).map_err(|e| Fault::unwritable(&path, &e))?;
        }
        Ok(writer)
    }

    /// Continue the run in `folder`: frames below number `keep` stay, later ones are removed. An error if a frame that stays is
    /// damaged, or if more than the last of the `keep` frames is missing: a run that ended exactly at that frame's time has not
    /// written it.
    pub fn reopen(folder: &Path, format: FrameFormat, mut index: Index, keep: u64) -> Result<RunWriter, Fault> {
        let before = RunReader::open(folder)?;
        for entry in &before.index.frames {
            if entry.number < keep {
                before.read_frame(entry.number)?;
                index.frames.push(entry.clone());
            } else {
                let path = folder.join(&entry.file);
                std::fs::remove_file(&path).map_err(|e| Fault::unwritable(&path, &e))?;
            }
        }
        if (index.frames.len() as u64) + 1 < keep {
            let message = format!("has {} of the {keep} frames before the checkpoint", index.frames.len());
            return Err(Fault::whole(FaultKind::Data, &folder.join("run.json"), message));
        }
        index.columns = before.index.columns;
        index.generated = before.index.generated;
        let writer = RunWriter { folder: folder.into(), format, index };
        writer.write_index()?;
        Ok(writer)
    }

    /// Write a frame and list it in `run.json`.
    pub fn write_frame(&mut self, frame: &Frame) -> Result<(), Fault> {
        let file = format!("frames/{:06}.{}", frame.number, self.format.extension());
        let bytes = match self.format {
            FrameFormat::Arrow => arrow::encode(frame),
            FrameFormat::Csv => csv::encode(frame).into_bytes(),
        };
        atomic::write(&self.folder.join(&file), &bytes)?;
        if self.index.columns.is_empty() {
            let entry = |(f, c): &(crate::Field, crate::Column)| ColumnEntry {
                name: f.name.clone(),
                kind: c.kind().into(),
                unit: f.unit.clone(),
            };
            self.index.columns = frame.columns.iter().map(entry).collect();
        }
        let hash = blake3::hash(&bytes).to_hex().to_string();
        self.index.frames.push(FrameEntry { number: frame.number, time: frame.time, file, rows: frame.rows(), hash });
        self.write_index()
    }

    /// The run directory.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Count of frames written.
    pub fn frames(&self) -> usize {
        self.index.frames.len()
    }

    /// Write another file into the run directory, such as `model.yaml`.
    pub fn write_file(&self, name: &str, text: &str) -> Result<(), Fault> {
        atomic::write(&self.folder.join(name), text.as_bytes())
    }

    /// Write a file that the user may edit afterwards, such as `metadata.yaml`. One that was edited stays as it is. Returns whether the
    /// file was written; an error if it cannot be.
    pub fn write_generated(&mut self, name: &str, text: &str) -> Result<bool, Fault> {
        let path = self.folder.join(name);
        let hash = hash_text(text);
        let is_ours = |bytes: &[u8]| {
            let there = blake3::hash(bytes).to_hex().to_string();
            there == hash || self.index.generated.get(name) == Some(&there)
        };
        match std::fs::read(&path) {
            Ok(bytes) if !is_ours(&bytes) => return Ok(false),
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(Fault::unreadable(FaultKind::Input, &path, &e));
            }
            _ => {}
        }
        self.index.generated.insert(name.into(), hash);
        self.write_index()?;
        atomic::write(&path, text.as_bytes())?;
        Ok(true)
    }

    /// Set the list of warnings, without writing `run.json`.
    pub fn set_warnings(&mut self, warnings: Vec<WarningEntry>) {
        self.index.warnings = warnings;
    }

    /// Set what ended the run, without writing `run.json`.
    pub fn set_ended(&mut self, ended: Ended) {
        self.index.ended = Some(ended);
    }

    /// Write `run.json` with the current index.
    pub fn write(&self) -> Result<(), Fault> {
        self.write_index()
    }

    /// Mark the run as complete and write `run.json`.
    pub fn finish(mut self) -> Result<(), Fault> {
        self.index.complete = true;
        self.write_index()
    }

    fn write_index(&self) -> Result<(), Fault> {
        let text = serde_json::to_string_pretty(&self.index).expect("an index is plain data");
        atomic::write(&self.folder.join("run.json"), text.as_bytes())
    }
}

/// A run directory that is being read.
#[derive(Clone, Debug)]
pub struct RunReader {
    /// Path of the run directory.
    pub folder: PathBuf,
    /// The index of the run, from `run.json`.
    pub index: Box<Index>,
    by_number: BTreeMap<u64, usize>,
}

impl RunReader {
    /// Whether a folder is a run directory: whether it has a `run.json`.
    pub fn is_run(folder: &Path) -> bool {
        folder.join("run.json").is_file()
    }

    /// Open a run directory. An error if `run.json` cannot be read, is malformed, is of another format version or names a file outside of
    /// the folder.
    pub fn open(folder: &Path) -> Result<RunReader, Fault> {
        if folder.is_dir() && !RunReader::is_run(folder) {
            return Err(sequence::not_a_run(folder));
        }
        let path = folder.join("run.json");
        let text = guard::read_to_string(&path).map_err(|e| Fault::unreadable(FaultKind::Data, &path, &e))?;
        let index: Index = serde_json::from_str(&text).map_err(|e| {
            Fault::at(FaultKind::Data, &path, &text, e.line(), e.column(), format!("is not a run's index: {e}"))
                .hint("it is cut off or was replaced: simulate again with --fresh")
        })?;
        if index.format_version != FORMAT_VERSION {
            let message = format!("has format version {}, this program reads {FORMAT_VERSION}", index.format_version);
            return Err(Fault::whole(FaultKind::Data, &path, message));
        }
        if index.expected_frames > MAX_FRAMES {
            let message = format!("expects {} frames, and a run has at most {MAX_FRAMES}", index.expected_frames);
            return Err(Fault::whole(FaultKind::Data, &path, message));
        }
        if let Some(entry) = index.frames.iter().find(|entry| !is_table_of_run(Path::new(&entry.file))) {
            let message = format!(
                "names the file `{}` of frame {}, which is no table in its folder `frames`",
                entry.file.escape_debug(),
                entry.number
            );
            return Err(Fault::whole(FaultKind::Data, &path, message));
        }
        let by_number = index.frames.iter().enumerate().map(|(i, f)| (f.number, i)).collect();
        Ok(RunReader { folder: folder.into(), index: Box::new(index), by_number })
    }

    /// Numbers of the frames, ascending.
    pub fn numbers(&self) -> Vec<u64> {
        self.by_number.keys().copied().collect()
    }

    /// Whether the run has a frame of this number.
    pub fn has(&self, number: u64) -> bool {
        self.by_number.contains_key(&number)
    }

    /// Whether the files of all frames are what the run wrote; each is read.
    pub fn is_whole(&self) -> bool {
        self.index.frames.iter().all(|entry| self.is_own(entry))
    }

    /// Numbers of the frames whose files are lost, or are not what the run wrote; each is read.
    pub fn damaged(&self) -> Vec<u64> {
        self.index.frames.iter().filter(|entry| !self.is_own(entry)).map(|entry| entry.number).collect()
    }

    /// Whether the file of a frame is what the run wrote.
    fn is_own(&self, entry: &FrameEntry) -> bool {
        let bytes = guard::read(&self.folder.join(&entry.file)).unwrap_or_default();
        blake3::hash(&bytes).to_hex().as_str() == entry.hash
    }

    /// Number of frames whose files are there.
    pub fn n_there(&self) -> usize {
        let entries = std::fs::read_dir(self.folder.join("frames")).into_iter().flatten().flatten();
        let names: HashSet<std::ffi::OsString> = entries.map(|entry| entry.file_name()).collect();
        let name = |entry: &FrameEntry| Path::new(&entry.file).file_name().map(|name| name.to_os_string());
        self.index.frames.iter().filter(|entry| name(entry).is_some_and(|name| names.contains(&name))).count()
    }

    /// Read a frame. An error if the run has no frame of this number, or if its file cannot be read or differs from the hash in
    /// `run.json`, as a truncated or replaced file does.
    pub fn read_frame(&self, number: u64) -> Result<Frame, Fault> {
        let Some(&i) = self.by_number.get(&number) else {
            let path = self.folder.join("run.json");
            return Err(Fault::whole(FaultKind::Data, &path, format!("the run has no frame {number}")));
        };
        let entry = &self.index.frames[i];
        let path = self.folder.join(&entry.file);
        let bytes = guard::read(&path).map_err(|e| Fault::unreadable(FaultKind::Data, &path, &e))?;
        if blake3::hash(&bytes).to_hex().as_str() != entry.hash {
            return Err(Fault::whole(
                FaultKind::Data,
                &path,
                "is not the file that the run wrote (its hash differs from run.json)",
            )
            .hint("it is cut off or was replaced: simulate again with --fresh"));
        }
        let mut frame = match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => csv::read(&path, number, &csv::Layout::default())?,
            _ => arrow::decode(&path, bytes, number)?,
        };
        frame.time = entry.time;
        Ok(frame)
    }
}

/// BLAKE3 hash of a text, hexadecimal; of a resolved model it is the identity.
pub fn hash_text(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex().to_string()
}
