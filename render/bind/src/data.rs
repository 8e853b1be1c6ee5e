//! Sources of frames: a run directory, or tables of other programs found by a pattern.

use crate::formula::{Formula, unknown_column};
use frame::csv::Layout;
use frame::run::RunReader;
use frame::table::{self, Stored};
use frame::yaml::Document;
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
    pub derive: Vec<(String, Formula)>,
    /// Condition on the rows to keep; all rows if not given.
    pub select: Option<Formula>,
    /// The file that says what is renamed, derived and selected, for the places of faults.
    doc: Option<Document>,
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
        Source { store, derive: vec![], select: None, doc: None, recent: Recent::default() }
    }
}

impl Source {
    /// A source of stored frames, with what is derived and selected of each, as a file says.
    pub fn new(store: Store, derive: Vec<(String, Formula)>, select: Option<Formula>, doc: Document) -> Source {
        Source { store, derive, select, doc: Some(doc), recent: Recent::default() }
    }

    /// The same source of a run that has more frames by now; the tables that were read stay.
    pub fn grown(&self, run: RunReader) -> Source {
        let recent = Recent(self.recent.0.clone());
        Source { store: Store::Run(run), recent, ..self.clone() }
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

    /// Read a frame, rename its columns, compute the derived ones and select its rows. An error if the file is bad, or, at its key, if a
    /// column that is renamed is missing, or an expression cannot be evaluated. Panics if tables of other programs have no frame of
    /// this number.
    pub fn read(&self, number: u64) -> Result<Frame, Fault> {
        let mut frame = match &self.store {
            Store::Run(run) => run.read_frame(number)?,
            Store::Files { files, layout, rename } => {
                let mut frame = files[&number].read(number, layout)?;
                self.rename(&mut frame, &files[&number].path, rename)?;
                frame
            }
        };
        if frame.rows() == 0 {
            return Ok(frame);
        }
        for (name, formula) in &self.derive {
            let rows: Vec<usize> = (0..frame.rows()).collect();
            let values = formula.expr.numbers(&frame, &rows).map_err(|m| self.fault(formula, &frame, m))?;
            frame.columns.retain(|(f, _)| f.name != *name);
            frame.push(name, "", Column::F64(values));
        }
        if let Some(formula) = &self.select {
            let rows = formula.expr.select(&frame).map_err(|m| self.fault(formula, &frame, m))?;
            frame.keep(&rows);
        }
        Ok(frame)
    }

    /// Give the columns of a table their new names. One that has its new name already stays.
    fn rename(&self, frame: &mut Frame, path: &Path, rename: &BTreeMap<String, String>) -> Result<(), Fault> {
        let names = frame.names();
        // Writers of empty tables leave columns out.
        let is_missing = |old: &&String| !names.contains(&old.as_str()) && !names.contains(&rename[*old].as_str());
        if let Some(old) = rename.keys().find(is_missing).filter(|_| frame.rows() > 0) {
            return Err(self.lacks(&format!("data.rename.{old}"), old, frame));
        }
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
        Ok(())
    }

    /// The fault of a column that a frame lacks. What the first frame does not have is wrong in the file, what others lack is missing in the data.
    fn lacks(&self, key: &str, column: &str, frame: &Frame) -> Fault {
        let is_first = self.numbers().first() == Some(&frame.number);
        let kind = if is_first { FaultKind::Input } else { FaultKind::Data };
        match &self.doc {
            Some(doc) => Fault { kind, ..unknown_column(doc, key, column, frame) },
            None => Fault::whole(kind, Path::new(key), format!("there is no column `{column}`")),
        }
    }

    /// The fault of an expression that cannot be evaluated: of the data if it can be in other rows, else of the expression.
    fn fault(&self, formula: &Formula, frame: &Frame, message: String) -> Fault {
        let names = frame.names();
        if let Some(column) = formula.expr.columns().iter().find(|column| !names.contains(&column.as_str())) {
            return self.lacks(&formula.key, column, frame);
        }
        let holds = |row: usize| formula.expr.numbers(frame, &[row]).is_ok();
        let bad = (0..frame.rows()).find(|row| !holds(*row)).filter(|_| (0..frame.rows()).any(holds));
        let (kind, message) = match bad {
            Some(row) => (FaultKind::Data, format!("row {} of frame {}: {message}", row + 1, frame.number)),
            None => (FaultKind::Input, message),
        };
        match &self.doc {
            Some(doc) => Fault { kind, ..doc.fault(&formula.key, message) },
            None => Fault::whole(kind, Path::new(&formula.key), message),
        }
    }
}
