//! Dicing of items of any shape, in memory that is kept from item to item.

use crate::gprim::grid::{Grid, Sink, Subject};
use crate::gprim::sphere;
use crate::gprim::sphere::cap::Scratch;
use crate::gprim::split::{self, Queue, Waiting};
use crate::scene::shape::Shape;

/// A dicer: its memory, and the pieces that wait for their turn.
#[derive(Default)]
pub struct Dicer {
    /// Pieces of patches that wait.
    pub queue: Queue,
    grid: Grid,
    sphere: Scratch,
}

impl Dicer {
    /// Dice an item, as far as its turn has come.
    pub fn dice(&mut self, subject: &Subject<'_>, sink: &mut impl Sink) {
        match subject.view.shape {
            Shape::Sphere => sphere::dice(subject, &mut self.sphere, &mut self.queue, &mut self.grid, sink),
            Shape::Patches(patches, _) => split::dice_all(subject, patches, &mut self.queue, &mut self.grid, sink),
        }
    }

    /// Dice a piece of an item, whose turn has come.
    pub fn dice_waiting(&mut self, subject: &Subject<'_>, waiting: &Waiting, sink: &mut impl Sink) {
        split::dice_waiting(subject, waiting, &mut self.queue, &mut self.grid, sink);
    }
}
