//! The scene: primitives by sources, their attributes, the options of the image, the camera, motion and lights.

pub mod area;
pub mod attached;
pub mod attributes;
pub mod camera;
pub mod channels;
pub mod emitters;
pub mod facets;
pub mod interpolation;
pub mod keys;
pub mod motion;
pub mod options;
pub mod patch;
pub mod shape;
pub mod solid;
pub mod source;
pub mod trim;
pub mod twins;
pub mod variables;
pub mod world;
