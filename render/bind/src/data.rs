//! Sources of frames: a run directory, or tables of other programs found by a pattern.

use crate::expr::Expr;
use frame::csv::Layout;
use frame::run::RunReader;
use frame::table::{self, Stored};
use frame::{Column, Fault, FaultKind, Frame};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A source of frames, with the operations on each frame: derived columns, then the selection of rows.
#[derive(Clone, Debug)]
pub struct Source {
    /// The stored frames.
    pub store: Store,
    /// Derived columns, in order: name and expression. A derived column replaces one of the same name.
    pub derive: Vec<(String, Expr)>,
    /// Condition on the rows to keep; all rows if not given.
    pub select: Option<Expr>,
    /// Tables that the next image is likely to need again.
    recent: Recent,
}

/// The tables that trails go back to, by their frames' numbers. While one is read, others who want it wait.
#[derive(Debug, Default)]
struct Recent(Arc<Mutex<BTreeMap<u64, Place>>>);

/// A table, once it is read.
type Place = Arc<Mutex<Option<Arc<Frame>>>>;

impl Recent {
    fn tables(&self) -> MutexGuard<'_, BTreeMap<u64, Place>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Clone for Recent {
    /// Without tables: a source that is changed reads others.
    fn clone(&self) -> Recent {
        Recent::default()
    }
}

/// Stored frames: a run directory or tables of other programs.
#[derive(Clone, Debug)]
pub enum Store {
    /// A run directory.
    Run(RunReader),
    /// Tables of other programs.
    Files {
        /// The tables by frame number.
        files: BTreeMap<u64, Stored>,
        /// Layout of those that are CSV files.
        layout: Layout,
        /// New names of columns, by their old ones.
        rename: BTreeMap<String, String>,
    },
}

impl From<Store> for Source {
    fn from(store: Store) -> Source {
        Source::new(store, vec![], None)
    }
}

impl Source {
    /// A source of stored frames, with what is derived and selected of each.
    pub fn new(store: Store, derive: Vec<(String, Expr)>, select: Option<Expr>) -> Source {
        Source { store, derive, select, recent: Recent::default() }
    }

    /// The same source of a run that has more frames by now; the tables that were read stay.
    pub fn grown(&self, run: RunReader) -> Source {
        let recent = Recent(self.recent.0.clone());
        Source { store: Store::Run(run), derive: self.derive.clone(), select: self.select.clone(), recent }
    }

    /// Open the source at a path: a run directory, or a table of another program, or a pattern of such files. An error if there is none.
    /// Where the rows of a table are of different times, `time` is the column that has them.
    pub fn open(path: &Path, time: Option<&str>) -> Result<Source, Fault> {
        let store = match time {
            None if path.is_dir() => Store::Run(RunReader::open(path)?),
            None => Store::Files { files: table::find(path)?, layout: Layout::default(), rename: BTreeMap::new() },
            Some(time) => {
                let files = table::by_time(path, &Layout::default(), time)?;
                Store::Files { files, layout: Layout::default(), rename: BTreeMap::new() }
            }
        };
        Ok(store.into())
    }

    /// Numbers of the stored frames, ascending.
    pub fn numbers(&self) -> Vec<u64> {
        match &self.store {
            Store::Run(run) => run.numbers(),
            Store::Files { files, .. } => files.keys().copied().collect(),
        }
    }

    /// The files of the stored frames.
    pub fn files(&self) -> Vec<PathBuf> {
        match &self.store {
            Store::Run(run) => run.index.frames.iter().map(|frame| run.folder.join(&frame.file)).collect(),
            Store::Files { files, .. } => {
                files.values().flat_map(Stored::files).cloned().collect::<BTreeSet<_>>().into_iter().collect()
            }
        }
    }

    /// What tells the table of a frame from any other that stood in its place: its hash, or the size and time of its file. Panics if
    /// tables of other programs have no frame of this number.
    pub fn stamp(&self, number: u64) -> String {
        match &self.store {
            Store::Run(run) => {
                let entry = run.index.frames.iter().find(|frame| frame.number == number);
                entry.map_or(String::new(), |frame| frame.hash.clone())
            }
            Store::Files { files, layout, rename } => {
                let stored = &files[&number];
                let file = stored.path.metadata().map(|m| (m.len(), m.modified().ok()));
                format!("{stored:?} {layout:?} {rename:?} {:?}", file.unwrap_or_default())
            }
        }
    }

    /// Numbers of the missing frames: those that an interrupted simulation did not reach. Empty for tables of other programs.
    pub fn missing(&self) -> Vec<u64> {
        match &self.store {
            Store::Run(run) => {
                let have = self.numbers();
                (0..run.index.expected_frames).filter(|f| have.binary_search(f).is_err()).collect()
            }
            Store::Files { .. } => vec![],
        }
    }

    /// Numbers of all frames that there will be, ascending: those that are stored, and the missing ones.
    pub fn expected(&self) -> Vec<u64> {
        let mut all = [self.numbers(), self.missing()].concat();
        all.sort_unstable();
        all
    }

    /// The hash of the model that was run; `None` for tables of other programs.
    pub fn run_hash(&self) -> Option<&str> {
        match &self.store {
            Store::Run(run) => Some(&run.index.model_hash),
            Store::Files { .. } => None,
        }
    }

    /// The table of a frame as [`Source::read`] gives it, read once for all images that [`Source::keep`] keeps it for.
    pub fn shared(&self, number: u64) -> Result<Arc<Frame>, Fault> {
        let place = self.recent.tables().entry(number).or_default().clone();
        let mut place = place.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(table) = &*place {
            return Ok(table.clone());
        }
        let table = Arc::new(self.read(number)?);
        *place = Some(table.clone());
        Ok(table)
    }

    /// Let go of all tables but those of a range of frames, and those that other images with trails are drawn of at the moment.
    pub fn keep(&self, frames: Range<u64>) {
        if frames.is_empty() {
            return self.recent.tables().clear();
        }
        let is_used = |place: &Place| match place.try_lock() {
            Ok(table) => table.as_ref().is_some_and(|table| Arc::strong_count(table) > 1),
            // It is read at the moment.
            Err(_) => true,
        };
        self.recent.tables().retain(|number, place| frames.contains(number) || is_used(place));
    }

    /// Read a frame, compute its derived columns and select its rows. An error if the file is bad or an expression cannot be
    /// evaluated. Panics if tables of other programs have no frame of this number.
    pub fn read(&self, number: u64) -> Result<Frame, Fault> {
        let (mut frame, path) = match &self.store {
            Store::Run(run) => (run.read_frame(number)?, run.folder.clone()),
            Store::Files { files, layout, rename } => {
                let path = &files[&number].path;
                let mut frame = files[&number].read(number, layout)?;
                for (field, _) in &mut frame.columns {
                    if let Some(new) = rename.get(&field.name) {
                        field.name.clone_from(new);
                    }
                }
                let names = frame.names();
                if let Some(i) = frame::repeated(names.iter().copied()) {
                    let message = format!("two columns are named `{}` once they are renamed", names[i]);
                    return Err(Fault::whole(FaultKind::Data, path, message));
                }
                (frame, path.clone())
            }
        };
        if frame.rows() == 0 {
            return Ok(frame);
        }
        let fault = |what: &str, expr: &Expr, message: String| {
            Fault::whole(FaultKind::Data, &path, format!("frame {number}: {what} `{}`: {message}", expr.text))
        };
        for (name, expr) in &self.derive {
            let rows: Vec<usize> = (0..frame.rows()).collect();
            let values = expr.numbers(&frame, &rows).map_err(|m| fault("the derived column", expr, m))?;
            frame.columns.retain(|(f, _)| f.name != *name);
            frame.push(name, "", Column::F64(values));
        }
        if let Some(expr) = &self.select {
            let rows = expr.select(&frame).map_err(|m| fault("the condition", expr, m))?;
            frame.keep(&rows);
        }
        Ok(frame)
    }
}
