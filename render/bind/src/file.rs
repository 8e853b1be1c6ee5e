//! Reading of a file, a metadata file or a job of Chrono::Render → its binding.

use crate::binding::Binding;
use crate::{chronorender, metadata};
use frame::Fault;
use frame::yaml::Document;
use std::path::Path;

/// Read and check a metadata file or a job of Chrono::Render. An error has its place in the file.
pub fn read(path: &Path) -> Result<Binding, Fault> {
    let (any, doc): (serde_yaml::Value, Document) = frame::yaml::read(path)?;
    if let Some(job) = any.get(chronorender::ROOT) {
        return chronorender::check(job, doc);
    }
    let (metadata, doc) = frame::yaml::read(path)?;
    metadata::check(metadata, doc)
}
