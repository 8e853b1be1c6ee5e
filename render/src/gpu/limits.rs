//! How much of a frame is on the device at a time.

/// How much of a frame is on the device at a time. Images are the same to the bit whatever it is.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The most samples of a window, as far as it has more than one row of pixels.
    pub samples: usize,
    /// The most items, and pieces of items, that are diced at a time.
    pub round: usize,
    /// Points of the first wave of a window, and of the largest, about.
    pub wave: [usize; 2],
    /// Points, at all moments, after which what is visible is shaded before more is diced.
    pub points: usize,
    /// Numbers that shaders are given at a time.
    pub values: usize,
    /// The most triangles of displaced surfaces that rays meet.
    pub facets: usize,
    /// The most layers whose lists are there at once, as far as one sample has no more.
    pub layers: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            samples: 1 << 22,
            round: 1024,
            wave: [1 << 17, 1 << 19],
            points: 1 << 21,
            values: 1 << 23,
            facets: 1 << 24,
            layers: 1 << 22,
        }
    }
}

/// The least memory that a frame may be given, bytes.
pub const LEAST_MEMORY: u64 = 64 << 20;

impl Limits {
    /// So much of a frame that it fits into so many bytes: about a quarter is for samples, a third for points and micropolygons, and what is
    /// left for shaders, layers, and the scene as they see it.
    pub fn within(bytes: u64) -> Limits {
        /// Bytes of a sample, and of a point or a moment of one with its micropolygon, while buffers grow.
        const SAMPLE: u64 = 40;
        const POINT: u64 = 240;
        let all = Limits::default();
        let part = |share: u64, each: u64, most: usize| ((bytes / share / each) as usize).min(most);
        let points = part(3, POINT, all.points);
        // An item or a piece is some hundred points.
        let round = (points / 1024).clamp(8, all.round);
        let wave = [(points / 16).min(all.wave[0]), (points / 4).min(all.wave[1])];
        let (samples, values) = (part(4, SAMPLE, all.samples), part(8, 12, all.values));
        let (facets, layers) = (part(4, 96, all.facets), part(16, 16, all.layers));
        Limits { samples, round, wave, points, values, facets, layers }
    }
}
