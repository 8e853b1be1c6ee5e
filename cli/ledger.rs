//! The ledger of a folder of images: of each image, what was written and what it was made of, in a file of its own in `.ledger/`, so that
//! any number of writers never contend. An image is done if its file is there and is what was written, and it is stale once anything
//! that it was made of is another.

mod claim;

pub use claim::{Claim, Claims};

use crate::report::in_one_line;
use frame::Fault;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Version of the entries.
const VERSION: u32 = 2;
/// The folder of the entries, in that of the images.
const FOLDER: &str = ".ledger";
/// The file that says what the images were last made of, without its ending.
const MADE: &str = "made_of";

/// The ledger of a folder of images.
#[derive(Clone, Debug)]
pub struct Ledger {
    /// The folder of the images.
    pub images: PathBuf,
    /// The folder of what they are made of, where that is known: that of the metadata.
    base: Option<PathBuf>,
}

/// What is known of an image, or of a shard of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Version of the format.
    ledger: u32,
    /// Name of the image's file.
    pub file: String,
    /// Size of the file, bytes.
    pub bytes: u64,
    /// blake3 hash of the file, hexadecimal.
    pub blake3: String,
    /// Hash of what was drawn: the program's version and all calls to the renderer.
    pub imprint: String,
    /// Hash of the list of files that it depends on, which all images that were made of the same share.
    pub depends_on: String,
    /// The folder that relative paths of these files start from, seen from the images where these lie within it: a project that is moved
    /// or copied as a whole keeps what is up to date.
    from: PathBuf,
    /// Time that the image took, s.
    pub seconds: f64,
}

/// Hashes of the files that were read, and none of those that were looked for and not there.
type Files = BTreeMap<PathBuf, Option<String>>;

/// How an image stands.
#[derive(Clone, Debug, PartialEq)]
pub enum Standing {
    /// Its file is what would be drawn again.
    Done,
    /// There is no file.
    Missing,
    /// There is a file, and no entry that can be read.
    Unknown,
    /// The data has no frame of its number.
    Gone,
    /// The file is not what was written: truncated or edited.
    Damaged,
    /// What is drawn has changed: the data, the metadata, the scene, or the program.
    Changed,
    /// A file that it was made of has changed.
    Depends(PathBuf),
    /// A file that it was made of is not there any more.
    Lacks(PathBuf),
    /// It cannot be drawn of what is there now.
    Undrawable(String),
}

impl fmt::Display for Standing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Standing::Done => f.write_str("up to date"),
            Standing::Missing => f.write_str("not there"),
            Standing::Unknown => f.write_str("not in the ledger: what it was made of is not known"),
            Standing::Gone => f.write_str("of a frame that the data does not have"),
            Standing::Damaged => f.write_str("not as it was written"),
            Standing::Changed => f.write_str("stale: data, metadata, scene or program have changed"),
            Standing::Depends(path) => write!(f, "stale: {} has changed", path.display()),
            Standing::Lacks(path) => write!(f, "stale: {} is not there any more", path.display()),
            Standing::Undrawable(why) => write!(f, "stale: it cannot be drawn again: {}", in_one_line(why)),
        }
    }
}

/// Hashes of files, each read once as long as it is not written again, and lists of files that images depend on.
#[derive(Default)]
pub struct Hashes {
    files: HashMap<PathBuf, ((u64, Option<SystemTime>), Option<String>)>,
    lists: HashMap<String, Option<Arc<Files>>>,
}

impl Hashes {
    /// The blake3 hash of a file; none if it is not there or cannot be read.
    pub fn of(&mut self, path: &Path) -> Option<String> {
        let stamp = path.metadata().map(|m| (m.len(), m.modified().ok())).unwrap_or_default();
        if let Some((known, hash)) = self.files.get(path)
            && *known == stamp
        {
            return hash.clone();
        }
        let hash = hash_of(path);
        self.files.insert(path.into(), (stamp, hash.clone()));
        hash
    }
}

/// The blake3 hash of a file; none if it is not there or cannot be read.
pub fn hash_of(path: &Path) -> Option<String> {
    let mut hasher = blake3::Hasher::new();
    if !path.is_file() {
        return None;
    }
    std::io::copy(&mut std::fs::File::open(path).ok()?, &mut hasher).ok()?;
    Some(hasher.finalize().to_hex().to_string())
}

impl Ledger {
    /// The ledger of a folder of images.
    pub fn of(images: &Path) -> Ledger {
        Ledger { images: images.into(), base: None }
    }

    /// The ledger of a folder of images that are made from files in the folder `base`.
    pub fn made_from(images: &Path, base: &Path) -> Ledger {
        let base = std::path::absolute(base).unwrap_or_else(|_| base.into());
        Ledger { images: images.into(), base: Some(base) }
    }

    /// The folder of its files.
    pub fn folder(&self) -> PathBuf {
        self.images.join(FOLDER)
    }

    /// The claims on its images.
    pub fn claims(&self) -> Claims {
        Claims::open(&self.folder().join("lock"))
    }

    fn path(&self, file: &str, ending: &str) -> PathBuf {
        self.folder().join(format!("{file}.{ending}"))
    }

    /// The file of a list of files.
    fn list(&self, hash: &str) -> PathBuf {
        self.folder().join("depends_on").join(format!("{hash}.json"))
    }

    /// The list of files of a hash; none if it is not there, or not what it was.
    fn depends_on(&self, hash: &str, hashes: &mut Hashes) -> Option<Arc<Files>> {
        let read = || {
            // It becomes a name of a file.
            let is_hash = hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit());
            let bytes = std::fs::read(self.list(hash)).ok().filter(|_| is_hash)?;
            let is_whole = blake3::hash(&bytes).to_hex().as_str() == hash;
            serde_json::from_slice(&bytes).ok().filter(|_| is_whole).map(Arc::new)
        };
        hashes.lists.entry(hash.into()).or_insert_with(read).clone()
    }

    /// The entry of a file; none if there is none, or it is not whole.
    pub fn entry(&self, file: &str) -> Option<Entry> {
        let bytes = std::fs::read(self.path(file, "json")).ok()?;
        let entry: Entry = serde_json::from_slice(&bytes).ok()?;
        (entry.ledger == VERSION && entry.file == file).then_some(entry)
    }

    /// Record a file that has been written, which took `seconds`: what it hangs on, by the imprint of what was drawn and the files that
    /// were read or looked for.
    pub fn record(
        &self,
        file: &str,
        imprint: &str,
        read: BTreeSet<PathBuf>,
        seconds: f64,
        hashes: &mut Hashes,
    ) -> Result<(), Fault> {
        let depend = |path: PathBuf| {
            let path = std::path::absolute(&path).unwrap_or(path);
            let hash = hashes.of(&path);
            let inside = self.base.as_ref().and_then(|base| path.strip_prefix(base).ok().map(Path::to_path_buf));
            (inside.unwrap_or(path), hash)
        };
        let files: Files = read.into_iter().map(depend).collect();
        self.write(&self.seal(file, imprint, (&files, self.from()), seconds)?)
    }

    /// Where relative paths of entries start: seen from the images where these lie within it.
    fn from(&self) -> PathBuf {
        let base = self.base.clone().unwrap_or_default();
        let images = std::path::absolute(&self.images).unwrap_or_else(|_| self.images.clone());
        match images.strip_prefix(&base) {
            Ok(inner) => inner.components().map(|_| "..").collect(),
            Err(_) => base,
        }
    }

    /// The entry of a file as it is, which depends on others.
    fn seal(
        &self,
        file: &str,
        imprint: &str,
        (depends_on, from): (&Files, PathBuf),
        seconds: f64,
    ) -> Result<Entry, Fault> {
        let path = self.images.join(file);
        let bytes = path.metadata().map(|m| m.len()).unwrap_or(0);
        let gone = || Fault::whole(frame::FaultKind::Data, &path, "was removed while it was being written");
        let blake3 = hash_of(&path).ok_or_else(gone)?;
        let list = serde_json::to_vec(depends_on).unwrap_or_default();
        let depends_on = blake3::hash(&list).to_hex().to_string();
        let there = self.list(&depends_on);
        if std::fs::read(&there).ok().as_ref() != Some(&list) {
            frame::atomic::write(&there, &list)?;
        }
        let (file, imprint) = (file.into(), imprint.into());
        Ok(Entry { ledger: VERSION, file, bytes, blake3, imprint, depends_on, from, seconds })
    }

    /// Record a file that was joined from parts, with their entries.
    pub fn record_joined(&self, file: &str, parts: &[Entry]) -> Result<(), Fault> {
        let Some(first) = parts.first() else { return Ok(()) };
        let seconds = parts.iter().map(|part| part.seconds).sum();
        let mut hashes = Hashes::default();
        let lists = parts.iter().filter_map(|part| self.depends_on(&part.depends_on, &mut hashes));
        let files = lists.flat_map(|list| list.as_ref().clone()).collect();
        self.write(&self.seal(file, &first.imprint, (&files, first.from.clone()), seconds)?)
    }

    fn write(&self, entry: &Entry) -> Result<(), Fault> {
        let bytes = serde_json::to_vec(entry).unwrap_or_default();
        frame::atomic::write(&self.path(&entry.file, "json"), &bytes)?;
        self.forget_failure(&entry.file);
        Ok(())
    }

    /// Forget that a file could not be made.
    pub fn forget_failure(&self, file: &str) {
        let _ = std::fs::remove_file(self.path(file, "failed"));
    }

    /// The file that says what the images were last made of.
    pub fn made_of(&self) -> PathBuf {
        self.folder().join(format!("{MADE}.json"))
    }

    /// Note why a file could not be made.
    pub fn note_failure(&self, file: &str, why: &str) -> Result<(), Fault> {
        frame::atomic::write(&self.path(file, "failed"), why.as_bytes())
    }

    /// Why a file could not be made, if that is so.
    pub fn failure(&self, file: &str) -> Option<String> {
        std::fs::read_to_string(self.path(file, "failed")).ok()
    }

    /// Names of the files that have entries, in order.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder()).into_iter().flatten().flatten();
        let name =
            |entry: std::fs::DirEntry| entry.file_name().to_string_lossy().strip_suffix(".json").map(String::from);
        let mut files: Vec<String> =
            entries.filter_map(name).filter(|name| !["ranges", MADE].contains(&name.as_str())).collect();
        files.sort();
        files
    }

    /// Forget the entry of a file.
    pub fn forget(&self, file: &str) {
        let _ = std::fs::remove_file(self.path(file, "json"));
    }

    /// How a file stands, of which `imprint` would be drawn now; whatever was drawn is taken where that is not known.
    pub fn standing(&self, file: &str, imprint: Option<&str>, hashes: &mut Hashes) -> Standing {
        let path = self.images.join(file);
        if !path.is_file() {
            return Standing::Missing;
        }
        let Some(entry) = self.entry(file) else { return Standing::Unknown };
        let Some(list) = self.depends_on(&entry.depends_on, hashes) else { return Standing::Unknown };
        let base = self.base.clone().unwrap_or_else(|| self.images.join(&entry.from));
        let changed = list.iter().find(|(path, hash)| hashes.of(&base.join(path)) != **hash);
        if let Some((path, _)) = changed {
            let is_there = base.join(path).exists();
            return if is_there { Standing::Depends(path.clone()) } else { Standing::Lacks(path.clone()) };
        }
        // What has changed in one of its files has been named.
        if imprint.is_some_and(|imprint| imprint != entry.imprint) {
            return Standing::Changed;
        }
        let size = path.metadata().map(|m| m.len()).ok();
        if size != Some(entry.bytes) || hash_of(&path).as_ref() != Some(&entry.blake3) {
            return Standing::Damaged;
        }
        Standing::Done
    }
}
