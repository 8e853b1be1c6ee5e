//! The scene: primitives by sources, their attributes, the options of the image, the camera, motion and lights.

pub mod area;
pub mod camera;
pub mod motion;
pub mod options;
pub mod world;
