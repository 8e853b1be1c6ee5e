//! Buckets: the rectangles that an image is rendered by, and the shards that they are dealt out to.

/// A shard of an image: one of several equal parts of its buckets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which shard, from 1.
    pub part: usize,
    /// Number of shards.
    pub parts: usize,
}

/// A bucket: a rectangle of pixels.
#[derive(Clone, Copy, Debug)]
pub struct Bucket {
    /// First pixel along x.
    pub x: usize,
    /// First pixel along y.
    pub y: usize,
    /// Pixels along x.
    pub width: usize,
    /// Pixels along y.
    pub height: usize,
    /// Its index, row by row.
    pub(crate) index: usize,
}

/// The buckets of an image, or of a shard of it: every n-th of n shards, so that shards take about as long.
pub fn buckets(width: usize, height: usize, size: usize, shard: Option<Shard>) -> impl Iterator<Item = Bucket> {
    let (columns, rows) = (width.div_ceil(size), height.div_ceil(size));
    let (first, step) = shard.map_or((0, 1), |s| (s.part - 1, s.parts));
    (first..columns * rows).step_by(step).map(move |index| {
        let (x, y) = (index % columns * size, index / columns * size);
        Bucket { x, y, width: size.min(width - x), height: size.min(height - y), index }
    })
}
