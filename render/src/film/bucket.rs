//! Buckets, the rectangles of pixels that are rendered one at a time, and shards, the sets of buckets that separate processes
//! render.

/// A shard of an image: every `parts`-th of its buckets, beginning with bucket `part`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Index of the shard, from 1.
    pub part: usize,
    /// Count of shards.
    pub parts: usize,
}

/// A bucket: a rectangle of pixels, of the bucket size or less at the image's right and lower edges.
#[derive(Clone, Copy, Debug)]
pub struct Bucket {
    /// First column, pixels from the image's left edge.
    pub x: usize,
    /// First row, pixels from the image's top edge.
    pub y: usize,
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// Its index, row by row.
    pub(crate) index: usize,
}

impl Bucket {
    /// Its halves: left and right of one that is as wide as it is high, or wider, else the upper and the lower.
    pub fn halves(&self) -> [Bucket; 2] {
        let (mut first, mut second) = (*self, *self);
        if self.is_wide() {
            first.width = self.width / 2;
            (second.x, second.width) = (self.x + first.width, self.width - first.width);
        } else {
            first.height = self.height / 2;
            (second.y, second.height) = (self.y + first.height, self.height - first.height);
        }
        [first, second]
    }

    /// Whether its halves lie side by side.
    pub fn is_wide(&self) -> bool {
        self.width >= self.height
    }
}

/// The buckets of an image of `width` by `height` pixels, row by row, each `size` pixels along its edges; with a shard, only its
/// buckets: of n shards every n-th bucket, so that all shards take about the same time.
pub fn buckets(width: usize, height: usize, size: usize, shard: Option<Shard>) -> impl Iterator<Item = Bucket> {
    let (columns, rows) = (width.div_ceil(size), height.div_ceil(size));
    let (first, step) = shard.map_or((0, 1), |s| (s.part - 1, s.parts));
    (first..columns * rows).step_by(step).map(move |index| {
        let (x, y) = (index % columns * size, index / columns * size);
        Bucket { x, y, width: size.min(width - x), height: size.min(height - y), index }
    })
}
