//! Render statistics: counts of every stage, and its time.

/// Render statistics.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct Stats {
    /// Primitives in the scene.
    pub items: u64,
    /// Pieces of patches that were split, in all buckets.
    pub splits: u64,
    /// Grids diced.
    pub grids: u64,
    /// Grids found hidden or outside after dicing.
    pub grids_hidden: u64,
    /// Points shaded.
    pub shaded_points: u64,
    /// Micropolygons sampled.
    pub micropolygons: u64,
    /// Samples tried against micropolygons.
    pub samples: u64,
    /// Time by stage.
    pub seconds: Seconds,
}

/// Time by stage, seconds: of all threads together, or of the clock.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct Seconds {
    /// Building the hierarchy for rays; of the clock, since several threads share it.
    pub hierarchy: f64,
    /// Bounding primitives and sorting them to buckets; of the clock.
    pub bound: f64,
    /// Splitting, dicing and displacing.
    pub dice: f64,
    /// Sampling.
    pub sample: f64,
    /// Shading, rays included.
    pub shade: f64,
    /// Compositing and filtering, the imager included.
    pub filter: f64,
}

impl Stats {
    /// The sums over two sets of buckets; `items`, and the seconds of the clock, are of the first.
    pub(crate) fn add(mut self, o: Stats) -> Stats {
        self.splits += o.splits;
        self.grids += o.grids;
        self.grids_hidden += o.grids_hidden;
        self.shaded_points += o.shaded_points;
        self.micropolygons += o.micropolygons;
        self.samples += o.samples;
        self.seconds.dice += o.seconds.dice;
        self.seconds.sample += o.seconds.sample;
        self.seconds.shade += o.seconds.shade;
        self.seconds.filter += o.seconds.filter;
        self
    }
}
