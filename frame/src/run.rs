//! The run directory: where a simulation and its images meet.
//!
//! ```text
//! run.json              what was run and which frames are there, rewritten whole after every frame
//! model.yaml            the model, enough to run it again
//! frames/000042.arrow   one table a frame (or .csv)
//! report.csv            per step: contacts, iterations, residual, worst penetration, milliseconds by stage
//! metadata.yaml         what to draw for every class
//! ```
//! A frame is identified by its number in `run.json`, never its place in a listing.

use crate::{Fault, FaultKind, Frame, arrow, atomic, csv, sequence};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The version of the run directory's format that this program writes and reads.
pub const FORMAT_VERSION: u32 = 1;

/// How frames are stored.
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
    /// The file name's ending.
    pub fn extension(self) -> &'static str {
        match self {
            FrameFormat::Arrow => "arrow",
            FrameFormat::Csv => "csv",
        }
    }
}

/// A column of the frames, as `run.json` lists it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColumnEntry {
    /// Name.
    pub name: String,
    /// `f64`, `f32`, `i64` or `category`.
    #[serde(rename = "type")]
    pub kind: String,
    /// SI unit; empty for pure numbers and words.
    pub unit: String,
}

/// A frame, as `run.json` lists it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameEntry {
    /// The frame's number.
    pub number: u64,
    /// Time, s.
    pub time: f64,
    /// The file, from the run directory.
    pub file: String,
    /// Rows.
    pub rows: usize,
    /// blake3 of the file, hexadecimal.
    pub hash: String,
}

/// The content of `run.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Index {
    /// [`FORMAT_VERSION`].
    pub format_version: u32,
    /// Program and version that wrote it.
    pub program: String,
    /// blake3 of the resolved model.
    pub model_hash: String,
    /// Seed of the generators.
    pub seed: u64,
    /// Step size, s.
    pub step_size: f64,
    /// `cpu` or `gpu`.
    pub backend: String,
    /// The processor or graphics adapter.
    pub adapter: String,
    /// The unit system of all numbers.
    pub units: String,
    /// Frames that the whole run has.
    pub expected_frames: u64,
    /// Whether the run came to its end.
    pub complete: bool,
    /// The frames' columns.
    pub columns: Vec<ColumnEntry>,
    /// What went wrong in its steps, by kind.
    #[serde(default)]
    pub warnings: Vec<WarningEntry>,
    /// The frames written so far.
    pub frames: Vec<FrameEntry>,
}

/// Steps that went wrong in one way, as `run.json` lists them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WarningEntry {
    /// `residual`, `joint` or `energy`.
    pub kind: String,
    /// Number of steps.
    pub steps: u64,
    /// The first of them, from 1.
    pub first_step: u64,
    /// Time after it, s.
    pub first_time: f64,
    /// What went wrong in it.
    pub message: String,
}

/// A run directory that is being written.
pub struct RunWriter {
    folder: PathBuf,
    format: FrameFormat,
    index: Index,
}

impl RunWriter {
    /// Start a run in `folder`. Frames of an earlier run there are removed, so that no stale frame can be taken for a new one.
    pub fn create(folder: &Path, format: FrameFormat, index: Index) -> Result<RunWriter, Fault> {
        let frames = folder.join("frames");
        std::fs::create_dir_all(&frames).map_err(|e| Fault::unwritable(&frames, &e))?;
        let writer = RunWriter { folder: folder.into(), format, index };
        writer.write_index()?;
        for entry in std::fs::read_dir(&frames).map_err(|e| Fault::unwritable(&frames, &e))?.flatten() {
            let path = entry.path();
            if matches!(path.extension().and_then(|e| e.to_str()), Some("arrow" | "csv")) {
                std::fs::remove_file(&path).map_err(|e| Fault::unwritable(&path, &e))?;
            }
        }
        Ok(writer)
    }

    /// Go on with a run: its first `keep` frames stay if they are whole, all later ones are removed. The last of them may be
    /// missing still: a run that was to end at just its time did not write it.
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
        let writer = RunWriter { folder: folder.into(), format, index };
        writer.write_index()?;
        Ok(writer)
    }

    /// Write a frame and list it.
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

    /// Number of frames that are there.
    pub fn frames(&self) -> usize {
        self.index.frames.len()
    }

    /// Write a file of the run's own, such as `model.yaml`, whole.
    pub fn write_file(&self, name: &str, text: &str) -> Result<(), Fault> {
        atomic::write(&self.folder.join(name), text.as_bytes())
    }

    /// List what went wrong; `run.json` has it from the next time that it is written.
    pub fn set_warnings(&mut self, warnings: Vec<WarningEntry>) {
        self.index.warnings = warnings;
    }

    /// Write `run.json` as it is.
    pub fn write(&self) -> Result<(), Fault> {
        self.write_index()
    }

    /// Mark the run complete.
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
    /// The folder.
    pub folder: PathBuf,
    /// What `run.json` says.
    pub index: Index,
    by_number: BTreeMap<u64, usize>,
}

impl RunReader {
    /// Whether a folder is a run directory.
    pub fn is_run(folder: &Path) -> bool {
        folder.join("run.json").is_file()
    }

    /// Open a run directory.
    pub fn open(folder: &Path) -> Result<RunReader, Fault> {
        if folder.is_dir() && !RunReader::is_run(folder) {
            return Err(sequence::not_a_run(folder));
        }
        let path = folder.join("run.json");
        let text = std::fs::read_to_string(&path).map_err(|e| Fault::unreadable(FaultKind::Data, &path, &e))?;
        let index: Index = serde_json::from_str(&text).map_err(|e| {
            Fault::at(FaultKind::Data, &path, &text, e.line(), e.column(), format!("is not a run's index: {e}"))
        })?;
        if index.format_version != FORMAT_VERSION {
            let message = format!("has format version {}, this program reads {FORMAT_VERSION}", index.format_version);
            return Err(Fault::whole(FaultKind::Data, &path, message));
        }
        let by_number = index.frames.iter().enumerate().map(|(i, f)| (f.number, i)).collect();
        Ok(RunReader { folder: folder.into(), index, by_number })
    }

    /// Numbers of the frames that are there.
    pub fn numbers(&self) -> Vec<u64> {
        self.by_number.keys().copied().collect()
    }

    /// Read a frame, checked against its hash: a truncated or swapped file is a fault, never an image.
    pub fn read_frame(&self, number: u64) -> Result<Frame, Fault> {
        let Some(&i) = self.by_number.get(&number) else {
            let path = self.folder.join("run.json");
            return Err(Fault::whole(FaultKind::Data, &path, format!("the run has no frame {number}")));
        };
        let entry = &self.index.frames[i];
        let path = self.folder.join(&entry.file);
        let bytes = std::fs::read(&path).map_err(|e| Fault::unreadable(FaultKind::Data, &path, &e))?;
        if blake3::hash(&bytes).to_hex().as_str() != entry.hash {
            return Err(Fault::whole(
                FaultKind::Data,
                &path,
                "is not the file that the run wrote (its hash differs from run.json)",
            )
            .hint("it is cut off or was replaced: simulate again"));
        }
        let mut frame = match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => csv::read(&path, number, &csv::Layout::default())?,
            _ => arrow::decode(&path, bytes, number)?,
        };
        frame.time = entry.time;
        Ok(frame)
    }
}

/// blake3 of a text, hexadecimal: the identity of a model.
pub fn hash_text(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex().to_string()
}
