//! Machines that are built from a few dimensions: parametric builders that write the bodies, joints, springs and loads that an
//! engineer would have to write by hand.

mod helical_anchor;
mod parts;
mod tracked_vehicle;

pub use helical_anchor::HelicalAnchor;
pub use parts::Parts;
pub use tracked_vehicle::TrackedVehicle;
