//! The job of `scree stitch`.

use crate::args::StitchArgs;
use crate::report::{Exit, Failure, Outcome};
use crate::shard_file;
use frame::{Fault, FaultKind};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Images to stitch.
pub struct StitchJob {
    /// The images.
    pub images: Vec<ShardedImage>,
    /// Whether the shard files are kept.
    pub keep: bool,
}

/// An image of which shard files were found.
pub struct ShardedImage {
    /// The image's file.
    pub path: PathBuf,
    /// The number of its shards.
    pub n_shards: usize,
    /// The indices of the missing shards, from 1.
    pub missing: Vec<usize>,
}

impl StitchJob {
    /// Check the arguments: find the shard files of every image in the folder.
    pub fn check(args: StitchArgs) -> Outcome<StitchJob> {
        let unreadable = |e: std::io::Error| Fault::unreadable(FaultKind::Data, &args.folder, &e);
        // The shards found of each image: their indices by the number of shards.
        let mut found: BTreeMap<PathBuf, BTreeMap<usize, Vec<usize>>> = BTreeMap::new();
        for entry in std::fs::read_dir(&args.folder).map_err(unreadable)? {
            let path = entry.map_err(unreadable)?.path();
            if let Some((image, shard)) = shard_file::parse_path(&path) {
                found.entry(image).or_default().entry(shard.parts).or_default().push(shard.part);
            }
        }
        if found.is_empty() {
            return Err(Failure::new(Exit::Data, format!("there are no shard files in {}", args.folder.display())));
        }
        let images = found.into_iter().map(|(path, shards)| sharded_image(path, &shards)).collect::<Outcome<_>>()?;
        Ok(StitchJob { images, keep: args.keep })
    }
}

fn sharded_image(path: PathBuf, shards: &BTreeMap<usize, Vec<usize>>) -> Outcome<ShardedImage> {
    if shards.len() > 1 {
        let numbers: Vec<String> = shards.keys().map(usize::to_string).collect();
        let message = format!("has shard files of different numbers of shards: {}", numbers.join(", "));
        return Err(Fault::whole(FaultKind::Data, &path, message).hint("remove those that are not wanted").into());
    }
    let (n_shards, indices) = shards.iter().next().expect("an image is found with its shards");
    let indices: BTreeSet<usize> = indices.iter().copied().collect();
    let missing = (1..=*n_shards).filter(|i| !indices.contains(i)).collect();
    Ok(ShardedImage { path, n_shards: *n_shards, missing })
}
