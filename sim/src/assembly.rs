//! Assemblies: parametric machines that expand to the bodies, joints, springs and loads of a model file.

mod helical_anchor;
mod parts;
mod tracked_vehicle;

pub use helical_anchor::HelicalAnchor;
pub use tracked_vehicle::TrackedVehicle;
