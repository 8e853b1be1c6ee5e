//! A solid that is open.

use crate::scene::solid::Operation;
use crate::warnings::Spot;

/// A solid that is open.
pub struct OpenSolid {
    pub operation: Operation,
    /// Where it began.
    pub spot: Option<Spot>,
    /// Open attribute blocks around it.
    pub depth: usize,
    /// Primitives that were given, to the scene and to objects, and those that the scene has kept, before it began.
    pub before: [u64; 2],
}
