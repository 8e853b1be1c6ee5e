//! Tables of one instant, the run directory, and the readers and writers of both.
//!
//! A [`Frame`] is a list of named, typed, unit-carrying columns of equal length. Simulations write frames into a
//! [`run`] directory; images, previews and plots read them back, or read a [`sequence`] of somebody else's files.
//! Every file is written whole and then renamed ([`atomic`]), except [`series`], which grow. Every reader reports bad input as a
//! [`Fault`] that names file, line and column.

pub mod arrow;
pub mod atomic;
pub mod chrono;
mod column;
pub mod csv;
pub mod dump;
pub mod export;
mod fault;
pub mod foreign;
mod gzip;
pub mod history;
pub mod list;
pub mod mercury;
pub mod mesh;
mod obj;
pub mod parquet;
pub mod part;
pub mod ply;
mod rows;
pub mod run;
pub mod sequence;
pub mod series;
pub mod table;
mod text;
pub mod vtk;
pub mod xyz;
pub mod yaml;

pub use column::{Column, Field, Frame, listed, repeated};
pub use fault::{Fault, FaultKind, nearest, read_bytes, read_text};
