//! What reading files of others may take: which files, and how much memory.
//!
//! Scenes, shaders, tables, models and runs come by mail and from the net. Every reader of them opens files here ([`read`], [`open`]),
//! so that one place knows what was read ([`seen`]), keeps within a folder ([`confine`]) and within the memory that reading may take
//! ([`memory`]). What of their text is printed, or becomes a name or a part of a script, goes through [`text`]. What it is that was
//! named wrongly, and where, the reader knows: errors here are those of reading a file.

mod decode;
mod files;
pub mod memory;
pub mod text;

pub use decode::{Gray, check_image, read_gray, read_image};
pub use files::{
    Trace, allow, confine, give, is_one_of, leads_out, look_for, note, open, permit, place_of, read, read_stdin,
    read_to_string, seen, trace, was_seen,
};
