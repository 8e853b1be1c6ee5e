//! Buckets: the rectangles that an image is rendered by, and the shards that they are dealt out to.

/// One of several equal parts of a picture's buckets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1.
    pub part: usize,
    /// How many there are.
    pub parts: usize,
}

/// The pixels of a bucket.
#[derive(Clone, Copy, Debug)]
pub struct Tile {
    /// The first.
    pub x: usize,
    /// The first.
    pub y: usize,
    /// How many along x.
    pub width: usize,
    /// How many along y.
    pub height: usize,
    /// The bucket's number, row by row.
    pub(crate) bucket: usize,
}

/// The buckets of a picture, or of a share of it: every so many-th, so that shares take about as long.
pub fn tiles(width: usize, height: usize, size: usize, share: Option<Shard>) -> impl Iterator<Item = Tile> {
    let (columns, rows) = (width.div_ceil(size), height.div_ceil(size));
    let (first, step) = share.map_or((0, 1), |s| (s.part - 1, s.parts));
    (first..columns * rows).step_by(step).map(move |bucket| {
        let (x, y) = (bucket % columns * size, bucket / columns * size);
        Tile { x, y, width: size.min(width - x), height: size.min(height - y), bucket }
    })
}
