//! How much of a frame is on the device at a time.

/// How much of a frame is on the device at a time. Images are the same to the bit whatever it is.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The most samples of a window, as far as it has more than one row of pixels.
    pub samples: usize,
    /// Points of the first wave of a window, and of the largest, about.
    pub wave: [usize; 2],
    /// Points, at all moments, after which what is visible is shaded before more is diced.
    pub points: usize,
    /// Numbers that shaders are given at a time.
    pub values: usize,
    /// The most layers whose lists are there at once, as far as one sample has no more.
    pub layers: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { samples: 1 << 22, wave: [1 << 17, 1 << 19], points: 1 << 21, values: 1 << 23, layers: 1 << 22 }
    }
}
