//! Checkpoints: the state bit for bit, from which a run resumes as if it had never stopped.
//!
//! A file has a line `scree checkpoint VERSION`, the blake3 hash of the rest (32 bytes), and the model's hash and the state in the
//! postcard encoding. It is written under another name and then renamed, so that a checkpoint is either whole or missing.

use crate::state::State;
use frame::{Fault, FaultKind, atomic};
use std::path::{Path, PathBuf};

/// The version of the format.
const VERSION: u32 = 18;

/// The first line of a checkpoint.
fn head() -> String {
    format!("scree checkpoint {VERSION}\n")
}

/// Folder of the checkpoints of the run directory `run`.
pub fn folder(run: &Path) -> PathBuf {
    run.join("checkpoints")
}

/// File name of the checkpoint after `steps` steps.
pub fn file_name(steps: u64) -> String {
    format!("{steps:09}.state")
}

/// Write a checkpoint: a state and the hash of its model ([`model_hash`](crate::run::model_hash)).
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, state: &State, model_hash: &str) -> Result<(), Fault> {
    let body = postcard::to_stdvec(&(model_hash, state)).expect("a state is plain data");
    let mut bytes = head().into_bytes();
    bytes.extend_from_slice(blake3::hash(&body).as_bytes());
    bytes.extend_from_slice(&body);
    atomic::write(path, &bytes)
}

/// Read a checkpoint: the state and the hash of its model.
///
/// # Errors
/// A file that cannot be read, is not a checkpoint, has another version of the format, is truncated, or differs from its hash.
pub fn read(path: &Path) -> Result<(State, String), Fault> {
    let bytes = guard::read(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    let broken = |why: &str| {
        Fault::whole(FaultKind::Data, path, format!("is not a checkpoint: {why}")).hint(
            "remove it, and the run goes on from the one before, else from its start; or simulate again with --fresh",
        )
    };
    let rest = bytes.strip_prefix(head().as_bytes()).ok_or_else(|| {
        let first = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
        match first.strip_prefix(b"scree checkpoint ") {
            Some(version) => {
                let version = String::from_utf8_lossy(&version[..version.len().min(8)]).into_owned();
                Fault::whole(
                    FaultKind::Data,
                    path,
                    format!("is a checkpoint of version {version}, this program reads version {VERSION}"),
                )
                .hint("simulate again from the start, or resume with the program that wrote it")
            }
            None => broken("it lacks the first line `scree checkpoint`"),
        }
    })?;
    let (hash, body) = rest.split_at_checked(32).ok_or_else(|| broken("it is truncated"))?;
    if blake3::hash(body).as_bytes() != hash {
        return Err(broken("its hash differs from its content: it is truncated or was changed"));
    }
    let (model_hash, state): (String, State) =
        postcard::from_bytes(body).map_err(|e| broken(&format!("it cannot be decoded: {e}")))?;
    Ok((state, model_hash))
}

/// Path of the checkpoint of the run directory `run` with the most steps; none if there is no checkpoint.
///
/// # Errors
/// A folder that cannot be read.
pub fn latest(run: &Path) -> Result<Option<PathBuf>, Fault> {
    let folder = folder(run);
    if !folder.is_dir() {
        return Ok(None);
    }
    let entries = std::fs::read_dir(&folder).map_err(|e| Fault::unreadable(FaultKind::Data, &folder, &e))?;
    let steps = |p: &Path| {
        let name = p.file_name()?.to_str()?.strip_suffix(".state")?;
        name.parse::<u64>().ok()
    };
    Ok(entries.flatten().map(|e| e.path()).filter(|p| steps(p).is_some()).max_by_key(|p| steps(p)))
}
