//! What is expected of the pairs of a step: where they hold, the broad phase is left out.

/// Whether the pairs of a step are expected to be those of the last one.
#[derive(Default)]
pub struct Holding {
    /// Number of steps, from the start of the last one on, for which they hold if bodies go on as they did.
    lasts: f64,
    /// Steps that are to pass before they are expected to hold again, after they did not.
    waits: u32,
    /// Whether the step was begun as if they hold.
    pub is_held: bool,
    /// Steps that were begun so although they did not.
    pub n_failed: u64,
}

impl Holding {
    /// Whether the pairs are likely to hold in the step that begins after this many: bodies do not go on quite as they did.
    pub fn is_likely(&self, steps: f64) -> bool {
        self.waits == 0 && self.lasts >= steps + 1.0
    }

    /// Take note of a step, at whose start the pairs held for this many.
    pub fn pass(&mut self, lasts: f64) {
        self.lasts = lasts;
        self.waits = self.waits.saturating_sub(1);
    }

    /// Take note that there may be other pairs.
    pub fn forget(&mut self) {
        self.lasts = 0.0;
    }

    /// Take note that they did not hold: the step is to be done again. So that this costs little, it takes a while until it may happen again.
    pub fn fail(&mut self) {
        /// Steps to wait.
        const WAIT: u32 = 10;
        *self = Holding { lasts: 0.0, waits: WAIT, is_held: false, n_failed: self.n_failed + 1 };
    }
}
