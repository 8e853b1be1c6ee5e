//! The back end on a graphics device: what it has no kernels for yet is refused, so that the processor draws the whole frame.
//!
//! The processor bounds, splits, dices and displaces as for its own images, in waves from front to back; the device dices caps of spheres,
//! samples the micropolygons, shades the points that are visible, composites and filters. All is within bounded memory: an image is drawn by windows, a
//! window by waves, and points that are many are shaded before the next wave.

mod caps;
mod few;
mod flight;
mod front;
mod kept;
mod kernels;
mod layers;
pub mod limits;
mod materials;
mod outputs;
mod refusal;
pub mod render;
mod samples;
mod shading;
mod supported;
mod world;
