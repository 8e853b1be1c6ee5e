//! The renderer's side of the RenderMan Interface: calls become the scene; `WorldEnd` makes the image.

pub mod attributes;
pub mod calls;
pub mod motion_block;
pub mod moving;
pub mod new;
pub mod options;
pub mod primitives;
pub mod result;
pub mod shaders;
pub mod state;
pub mod transforms;
pub mod world;
