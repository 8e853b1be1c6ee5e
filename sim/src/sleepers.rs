//! Bodies that sleep, by islands: the data of `sleep`, a part of the state.

use crate::contacts::Contacts;

/// The island of a body that does not sleep.
pub const AWAKE: u32 = u32::MAX;

/// The bodies that sleep, and how long the others have been still.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Sleepers {
    /// Number of steps for which each body has been still (n_bodies; empty where no body may sleep).
    pub still: Vec<u32>,
    /// Island of each body, the lowest id of its bodies; `AWAKE` for a body that does not sleep (n_bodies; empty while none has slept).
    pub island: Vec<u32>,
    /// The contacts of the bodies that sleep, with the impulses of the step after which they fell asleep.
    pub contacts: Contacts,
}

impl Sleepers {
    /// Number of bodies that sleep.
    pub fn n(&self) -> usize {
        self.island.iter().filter(|island| **island != AWAKE).count()
    }

    /// Whether no body sleeps.
    pub fn are_none(&self) -> bool {
        self.island.iter().all(|island| *island == AWAKE)
    }

    /// Check that sleepers, as a file gives them, are bodies of a model with these counts.
    ///
    /// # Errors
    /// What does not fit, for a message.
    pub(crate) fn fit(&self, n_bodies: usize, n_shapes: usize, n_laws: usize) -> Result<(), String> {
        let (still, island) = (self.still.len(), self.island.len());
        let is_sound = |length: usize| length == 0 || length == n_bodies;
        if !is_sound(still) || !is_sound(island) || island > still || (island == 0 && !self.contacts.is_empty()) {
            return Err("has columns of sleeping bodies of other lengths than the model".into());
        }
        self.contacts.fit(n_bodies, n_shapes, n_laws)
    }
}
