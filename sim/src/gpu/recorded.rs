//! The recorded commands of a step, and those of the next that are encoded ahead.

use super::contact_solve;
use gpu::{Commands, Device, Prepared};

/// The recorded commands of a step.
pub struct Recorded {
    /// The stages up to the contacts with their starting point.
    pub find: Commands,
    /// The same for pairs that hold, where the device finds them.
    pub held: Option<Commands>,
    /// The one or, if so told, the other, encoded for the next step.
    pub ahead: Option<(bool, Prepared)>,
    /// What follows by the method, and by Gauss–Seidel where it may take over.
    pub own: Solving,
    pub landing: Option<Solving>,
    /// In one of how many steps overlaps are recovered.
    pub period: u64,
}

/// The recorded commands of a step from its contacts on.
#[derive(Default)]
pub struct Solving {
    pub start: Commands,
    pub solve: contact_solve::Recorded,
    /// What the contacts do to the bodies that joints act on.
    pub measure: Commands,
    pub end: Commands,
    /// The end of a step that recovers overlaps.
    pub recovery: Commands,
}

impl Recorded {
    pub fn empty() -> Recorded {
        let (find, own) = (Commands::new(), Solving::default());
        Recorded { find, held: None, ahead: None, own, landing: None, period: 1 }
    }

    /// Encode the stages up to the contacts, for pairs that hold if it is likely and there are commands for these. Returns whether it is so.
    pub fn prepare(&self, device: &Device, is_likely: bool) -> (bool, Prepared) {
        let held = self.held.as_ref().filter(|_| is_likely);
        (held.is_some(), held.unwrap_or(&self.find).prepare(device))
    }
}
