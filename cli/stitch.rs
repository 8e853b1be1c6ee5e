//! `scree stitch`: shard files → whole images, bit for bit those of a single render.

use crate::image_file;
use crate::job::StitchJob;
use crate::ledger::Ledger;
use crate::report::{Exit, Failure, Outcome};
use crate::shard_file::{self, Header};
use frame::{Fault, FaultKind};
use render::film::bucket::Shard;
use render::film::image::Image;
use std::path::Path;

/// Run `scree stitch`.
pub fn run(job: StitchJob) -> Outcome {
    /// Missing shards of an image whose indices are printed.
    const PRINTED: usize = 20;
    let mut missing = Vec::new();
    for image in &job.images {
        if image.missing.is_empty() {
            join(&image.path, image.n_shards, job.keep)?;
            println!("{}", image.path.display());
        } else {
            let mut indices: Vec<String> = image.missing.iter().take(PRINTED).map(usize::to_string).collect();
            if image.missing.len() > PRINTED {
                indices.push("…".into());
            }
            missing.push(format!("{}: shard {} of {}", image.path.display(), indices.join(", "), image.n_shards));
        }
    }
    if missing.is_empty() {
        return Ok(());
    }
    Err(Failure::new(Exit::Partial, format!("shards are missing:\n  {}", missing.join("\n  "))))
}

/// Join the shards of an image, write the image, and remove the shard files unless they are kept.
pub fn join(path: &Path, n_shards: usize, keep: bool) -> Outcome {
    let ledger = Ledger::of(path.parent().unwrap_or(Path::new("")));
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let shard_path = |part: usize| shard_file::path_of(path, Shard { part, parts: n_shards });
    let mut joined: Option<(Header, Image)> = None;
    let mut entries = vec![];
    for shard in 1..=n_shards {
        let (header, pixels) = shard_file::read(&shard_path(shard))?;
        let (first, image) = joined.get_or_insert_with(|| (header.clone(), header.image()));
        if !first.is_alike(&header) {
            let message = "is of another image than shard 1: size, samples or displays differ";
            let fault = Fault::whole(FaultKind::Data, &shard_path(shard), message);
            return Err(fault.hint("render all shards with the same options").into());
        }
        header.copy_pixels(&pixels, image);
        entries.extend(ledger.entry(&name(&shard_path(shard))));
        if entries.first().zip(entries.last()).is_some_and(|(first, last)| first.imprint != last.imprint) {
            let message = "was drawn of other data, metadata or scenes than shard 1";
            return Err(Fault::whole(FaultKind::Data, &shard_path(shard), message)
                .hint("render the shards again")
                .into());
        }
    }
    let Some((header, image)) = joined else { return Ok(()) };
    let bytes = header.encode(&image).map_err(|m| Fault::whole(FaultKind::Data, path, m))?;
    image_file::spare_others(path)?;
    frame::atomic::write(path, &bytes)?;
    // Shards of a RIB scene have no entries.
    if entries.len() == n_shards {
        ledger.record_joined(&name(path), &entries)?;
    }
    if !keep {
        for shard in 1..=n_shards {
            std::fs::remove_file(shard_path(shard)).map_err(|e| Fault::unwritable(&shard_path(shard), &e))?;
            ledger.forget(&name(&shard_path(shard)));
        }
    }
    Ok(())
}
