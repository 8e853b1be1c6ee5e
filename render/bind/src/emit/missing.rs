//! What the rows of a frame lack of what is drawn of them.

/// Rows of a frame that lack values of what is drawn of them.
#[derive(Clone, Debug, Default)]
pub struct Missing {
    /// Rows without a place or a size, or with a size that is not above 0, which are not drawn.
    pub undrawn: Lack,
    /// Rows without a value of their colour, which are magenta.
    pub uncolored: Lack,
    /// Names of the objects that no row of the frame is of.
    pub absent: Vec<String>,
}

/// Rows that lack a value.
#[derive(Clone, Debug, Default)]
pub struct Lack {
    /// Number of rows.
    pub rows: usize,
    /// The first of them, from 1, and the expression that has no value.
    pub first: Option<(usize, String)>,
}

impl Lack {
    /// Add the rows of another object or frame.
    pub fn add(&mut self, other: &Lack) {
        self.rows += other.rows;
        self.first = self.first.take().or(other.first.clone());
    }
}
