//! Where frames come from: a run directory, or CSV files found by a pattern.

use frame::csv::Layout;
use frame::run::RunReader;
use frame::{Fault, Frame, sequence};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A source of frames.
#[derive(Clone, Debug)]
pub enum Source {
    /// A run directory.
    Run(RunReader),
    /// CSV files by frame number.
    Csv {
        /// The files.
        files: BTreeMap<u64, PathBuf>,
        /// How they are laid out.
        layout: Layout,
        /// New names of columns, by their old ones.
        rename: BTreeMap<String, String>,
    },
}

impl Source {
    /// The source at a path: a run directory, or a file or pattern of CSV files.
    pub fn open(path: &Path) -> Result<Source, Fault> {
        if path.is_dir() {
            return RunReader::open(path).map(Source::Run);
        }
        Ok(Source::Csv { files: sequence::find(path)?, layout: Layout::default(), rename: BTreeMap::new() })
    }

    /// The frames that are there.
    pub fn numbers(&self) -> Vec<u64> {
        match self {
            Source::Run(run) => run.numbers(),
            Source::Csv { files, .. } => files.keys().copied().collect(),
        }
    }

    /// Frames that should be there and are not: those that an interrupted simulation did not come to.
    pub fn missing(&self) -> Vec<u64> {
        match self {
            Source::Run(run) => {
                let have = self.numbers();
                (0..run.index.expected_frames).filter(|f| have.binary_search(f).is_err()).collect()
            }
            Source::Csv { .. } => vec![],
        }
    }

    /// Read a frame.
    pub fn read(&self, number: u64) -> Result<Frame, Fault> {
        match self {
            Source::Run(run) => run.read_frame(number),
            Source::Csv { files, layout, rename } => {
                let path = &files[&number];
                let mut frame = frame::csv::read(path, number, layout)?;
                for (field, _) in &mut frame.columns {
                    if let Some(new) = rename.get(&field.name) {
                        field.name.clone_from(new);
                    }
                }
                Ok(frame)
            }
        }
    }
}
