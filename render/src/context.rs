//! The renderer's side of the RenderMan Interface: calls become the scene; `WorldEnd` makes the image.

pub mod attributes;
pub mod blobbies;
pub mod blobby_call;
pub mod calls;
pub mod copies;
pub mod curves;
pub mod geometry;
pub mod motion_block;
pub mod moving;
pub mod new;
pub mod objects;
pub mod open_object;
pub mod open_solid;
pub mod options;
pub mod primitives;
pub mod programs;
pub mod projected;
pub mod quadrics;
pub mod rational;
pub mod result;
pub mod shaders;
pub mod solids;
pub mod state;
pub mod transforms;
pub mod world;
