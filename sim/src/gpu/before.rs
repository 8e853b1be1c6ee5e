//! What the processor has found of a step of which it runs the first stages, as a device keeps it.

use super::collision::given::Placed;
use crate::cpu::given::Given;
use crate::stages::Stage;

/// What the processor has found, and where its contacts are on the device.
pub struct Before {
    /// The first stage of the device.
    pub from: Stage,
    /// The columns of the step.
    pub given: Given,
    /// The places of its contacts.
    pub placed: Placed,
}

impl Before {
    /// No step yet.
    pub fn new(from: Stage) -> Before {
        Before { from, given: Given::default(), placed: Placed::default() }
    }

    /// Whether the device finds contacts of its own.
    pub fn finds(&self) -> bool {
        self.from <= Stage::ContactWrite
    }
}
