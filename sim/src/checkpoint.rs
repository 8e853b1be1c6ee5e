//! Checkpoints: a state to the last bit, from which a run goes on as if it had never stopped.
//!
//! A file has a line `scree checkpoint 5`, the blake3 hash of what follows, and the state with the model's hash, encoded by
//! postcard. It is written whole and then renamed.

use crate::state::State;
use frame::{Fault, FaultKind, atomic};
use std::path::{Path, PathBuf};

const HEAD: &[u8] = b"scree checkpoint 5\n";

/// The folder of a run's checkpoints.
pub fn folder(run: &Path) -> PathBuf {
    run.join("checkpoints")
}

/// The name of the checkpoint after so many steps.
pub fn file_name(steps: u64) -> String {
    format!("{steps:09}.state")
}

/// Write a checkpoint.
pub fn write(path: &Path, state: &State, model_hash: &str) -> Result<(), Fault> {
    let body = postcard::to_stdvec(&(model_hash, state)).expect("a state is plain data");
    let mut bytes = HEAD.to_vec();
    bytes.extend_from_slice(blake3::hash(&body).as_bytes());
    bytes.extend_from_slice(&body);
    atomic::write(path, &bytes)
}

/// Read a checkpoint: the state and the hash of its model.
pub fn read(path: &Path) -> Result<(State, String), Fault> {
    let bytes = std::fs::read(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    let broken = |why: &str| Fault::whole(FaultKind::Data, path, format!("is not a checkpoint: {why}"));
    let rest = bytes.strip_prefix(HEAD).ok_or_else(|| {
        let first = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
        match first.strip_prefix(b"scree checkpoint ") {
            Some(version) => {
                let version = String::from_utf8_lossy(&version[..version.len().min(8)]).into_owned();
                Fault::whole(
                    FaultKind::Data,
                    path,
                    format!("is a checkpoint of version {version}, this program reads 4"),
                )
                .hint("simulate again from the start, or go on with the program that wrote it")
            }
            None => broken("it does not begin as one"),
        }
    })?;
    let (hash, body) = rest.split_at_checked(32).ok_or_else(|| broken("it is cut off"))?;
    if blake3::hash(body).as_bytes() != hash {
        return Err(broken("its hash differs from its content; it is cut off or was changed"));
    }
    let (model_hash, state): (String, State) =
        postcard::from_bytes(body).map_err(|e| broken(&format!("it cannot be decoded: {e}")))?;
    Ok((state, model_hash))
}

/// The latest checkpoint of a run, by its steps.
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
