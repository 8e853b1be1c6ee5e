//! What is expected of the pairs of a step: where they hold, the broad phase is left out.

/// Whether the pairs of a step are expected to be those of the last one.
#[derive(Default)]
pub struct Holding {
    /// Number of steps, from the start of the last one on, for which they hold if bodies go on as they did.
    lasts: f64,
    /// The same from its end on, where that is known: more than none if they hold in the next step.
    next: Option<f64>,
    /// Mask of the rounds of Gauss–Seidel that had any tiles in the last step.
    rounds: u32,
    /// Steps that are to pass before they are expected to hold again, after they did not.
    waits: u32,
    /// Whether the step was begun as if they hold.
    pub is_held: bool,
    /// Steps that were begun so although they did not.
    pub n_failed: u64,
}

impl Holding {
    /// Whether the pairs hold in the step that begins, or are likely to: bodies do not go on quite as they did.
    pub fn is_likely(&self) -> bool {
        self.waits == 0 && self.next.map_or(self.lasts >= 2.0, |next| next > 0.0)
    }

    /// The same of the step after the one that is under way.
    pub fn is_likely_after(&self) -> bool {
        // Where pairs are found, they hold for some steps.
        self.waits == 0 && self.next.map_or(self.lasts >= 3.0, |next| !self.is_held || next > 1.0)
    }

    /// Mask of the rounds that may have any tiles in the step that has begun: where pairs hold, so do tiles.
    pub fn rounds(&self) -> u32 {
        if self.is_held { self.rounds } else { u32::MAX }
    }

    /// Take note of a step, at whose start the pairs held for `lasts`, and for `next` at its end, where that is known.
    pub fn pass(&mut self, lasts: f64, next: Option<f64>, rounds: u32) {
        (self.lasts, self.next, self.rounds) = (lasts, next, rounds);
        self.waits = self.waits.saturating_sub(1);
    }

    /// Take note that there may be other pairs.
    pub fn forget(&mut self) {
        (self.lasts, self.next) = (0.0, None);
    }

    /// Take note that they did not hold: the step is to be done again. So that this costs little, it takes a while until it may happen again.
    pub fn fail(&mut self) {
        /// Steps to wait.
        const WAIT: u32 = 10;
        *self = Holding { waits: WAIT, n_failed: self.n_failed + 1, ..Holding::default() };
    }
}
