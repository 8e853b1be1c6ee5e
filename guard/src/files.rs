//! Opening input files: within a folder, if there is one to keep to, and noted.

use crate::memory;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};

/// The folders that files may be read from; all if there are none.
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(vec![]);
/// What the command line names.
static GIVEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
/// The files that were opened.
static SEEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// The files that were opened or looked for since the last call of [`trace`], by threads that follow no trace of their own.
static TRACE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

thread_local! {
    /// The trace that a thread follows.
    static OWN: RefCell<Option<Trace>> = const { RefCell::new(None) };
}

/// The files that the threads of some work open or look for, apart from those of other work that goes on beside it.
#[derive(Clone, Default)]
pub struct Trace(Arc<Mutex<BTreeSet<PathBuf>>>);

impl Trace {
    /// Note here what this thread opens or looks for from now on: its calls of [`trace`] take that.
    pub fn follow(&self) {
        OWN.set(Some(self.clone()));
    }
}

/// Do something with the files that this thread's trace has.
fn traced<T>(work: impl FnOnce(&mut BTreeSet<PathBuf>) -> T) -> T {
    match OWN.with_borrow(Clone::clone) {
        Some(own) => work(&mut lock(&own.0)),
        None => work(&mut lock(&TRACE)),
    }
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(|e| e.into_inner())
}

/// Read no files from now on but those in this folder and below.
pub fn confine(folder: &Path) {
    *lock(&FOLDERS) = vec![folder.into()];
}

/// Read files in this folder and below, too, as in one that the program itself writes to. It need not be there yet.
pub fn allow(folder: &Path) {
    let mut folders = lock(&FOLDERS);
    if !folders.is_empty() {
        folders.push(folder.into());
    }
}

/// Note an argument of the command line. It may be the name of a pipe; those that files name are not read.
pub fn give(argument: impl Into<PathBuf>) {
    lock(&GIVEN).insert(argument.into());
}

/// The files that were opened or noted so far, as they were named, in the order of their names.
pub fn seen() -> Vec<PathBuf> {
    lock(&SEEN).iter().cloned().collect()
}

/// Note a file that would be read.
pub fn note(path: &Path) {
    lock(&SEEN).insert(path.into());
    look_for(path);
}

/// Note that a file would be read if it were there.
pub fn look_for(path: &Path) {
    traced(|files| files.insert(path.into()));
}

/// The files that were opened, noted or looked for since the last call, as they were named: what the work in between depends on.
pub fn trace() -> BTreeSet<PathBuf> {
    traced(std::mem::take)
}

/// Where a path leads, or would lead once its folders are there: `a/../b` is `b`, whether there is an `a` or not.
pub fn place_of(path: &Path) -> PathBuf {
    let mut place = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir if place.as_os_str().is_empty() || place.ends_with("..") => place.push(".."),
            Component::ParentDir => {
                place.pop();
            }
            Component::CurDir => {}
            _ => place.push(part),
        }
        if let Ok(real) = place.canonicalize() {
            place = real;
        }
    }
    place
}

/// Whether a file is one that was opened or noted: an input, which is not to be written.
pub fn was_seen(path: &Path) -> bool {
    is_one_of(path, seen())
}

/// Whether a file that is there is one of others, by whatever names and links.
pub fn is_one_of<P: AsRef<Path>>(path: &Path, others: impl IntoIterator<Item = P>) -> bool {
    let place = place_of(path);
    let place = if place.as_os_str().is_empty() { Path::new(".") } else { &place };
    let Ok(real) = place.canonicalize() else { return false };
    others.into_iter().any(|other| other.as_ref().canonicalize().is_ok_and(|other| other == real))
}

/// Whether links lead what is written to a path out of a folder, which need not be there yet.
pub fn leads_out(path: &Path, folder: &Path) -> bool {
    let nearest = |path: &Path| {
        let real = |p: &Path| if p.as_os_str().is_empty() { Path::new(".") } else { p }.canonicalize().ok();
        path.ancestors().find_map(real)
    };
    // The folder is looked at first: what another process makes between the two looks leads nowhere else.
    let Ok(home) = folder.canonicalize() else { return false };
    nearest(path).is_some_and(|real| !real.starts_with(&home))
}

/// An error if a file or folder is outside of the folders to keep to, wherever its links lead.
pub fn permit(path: &Path) -> Result<()> {
    let folders = lock(&FOLDERS);
    let Some(first) = folders.first() else { return Ok(()) };
    // What is not there is not read, either.
    let Ok(real) = path.canonicalize() else { return Ok(()) };
    if folders.iter().any(|folder| folder.canonicalize().is_ok_and(|folder| real.starts_with(folder))) {
        return Ok(());
    }
    let message = format!("it is outside of {}, where --root keeps reading", first.display());
    Err(Error::new(ErrorKind::PermissionDenied, message))
}

/// Open an input file. An error if it cannot be read or may not be, if it is a device, or larger than the memory that is left.
pub fn open(path: &Path) -> Result<File> {
    permit(path)?;
    let kind = std::fs::metadata(path)?;
    if kind.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "it is a folder"));
    }
    // Pipes are named by shells alone: a name in a scene that leads to one would be waited for.
    let is_pipe = ["/dev/fd", "/dev/stdin", "/proc/self/fd"].iter().any(|folder| path.starts_with(folder));
    let is_readable = if is_pipe { lock(&GIVEN).contains(path) } else { kind.is_file() && is_stored(path) };
    if !is_readable {
        return Err(Error::new(ErrorKind::InvalidInput, "it is a device, a pipe or a socket"));
    }
    if kind.len() > memory::room() {
        return Err(too_large());
    }
    let file = File::open(path)?;
    note(path);
    memory::doing("reading", path);
    Ok(file)
}

/// Whether a file stands on a disk: those in which the system tells of itself may be waited for, and look like any other.
fn is_stored(path: &Path) -> bool {
    path.canonicalize().is_ok_and(|real| !["/proc", "/sys"].iter().any(|folder| real.starts_with(folder)))
}

/// Read an input file whole, as [`open`] opens it.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    let file = open(path)?;
    let size = file.metadata().map_or(0, |m| m.len());
    whole(file, size as usize)
}

/// Read the standard input whole. An error if it is larger than the memory that is left.
pub fn read_stdin() -> Result<Vec<u8>> {
    memory::doing("reading", Path::new("the standard input"));
    if let Ok(file) = Path::new("/dev/stdin").canonicalize()
        && file.is_file()
    {
        note(&file);
    }
    whole(std::io::stdin().lock(), 0)
}

/// Read a stream whole, of which a number of bytes is expected.
fn whole(mut stream: impl Read, expected: usize) -> Result<Vec<u8>> {
    /// Bytes that are read at once, beyond those that are expected.
    const PART: u64 = 1 << 20;
    let mut bytes = Vec::with_capacity(expected);
    loop {
        // A vector that grows is there twice for a moment.
        if bytes.len() > expected && memory::room() < bytes.len() as u64 {
            return Err(too_large());
        }
        let part = PART + (expected as u64).saturating_sub(bytes.len() as u64);
        if stream.by_ref().take(part).read_to_end(&mut bytes)? == 0 {
            return Ok(bytes);
        }
    }
}

/// Read an input file whole as text, as [`open`] opens it. An error, too, if it is not UTF-8.
pub fn read_to_string(path: &Path) -> Result<String> {
    String::from_utf8(read(path)?).map_err(|_| Error::new(ErrorKind::InvalidData, "it is not UTF-8 text"))
}

fn too_large() -> Error {
    Error::new(ErrorKind::OutOfMemory, memory::Full.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_that_follow_traces_note_files_apart() {
        let traces = [Trace::default(), Trace::default()];
        let names = ["one", "other"];
        std::thread::scope(|scope| {
            for (trace, name) in traces.iter().zip(names) {
                // Two threads of each.
                (0..2).for_each(|k| {
                    scope.spawn(move || {
                        trace.follow();
                        look_for(&Path::new(name).join(k.to_string()));
                    });
                });
            }
        });
        let of = |trace: &Trace| {
            let trace = trace.clone();
            let take = move || {
                trace.follow();
                super::trace()
            };
            std::thread::spawn(take).join().unwrap()
        };
        for (trace, name) in traces.iter().zip(names) {
            let own: Vec<PathBuf> = of(trace).into_iter().collect();
            assert_eq!(own, [Path::new(name).join("0"), Path::new(name).join("1")]);
            assert!(of(trace).is_empty());
        }
        assert!(!super::trace().iter().any(|path| names.iter().any(|name| path.starts_with(name))));
    }
}
