//! The documentation: every example of the README and of `docs/` runs, links and images are there, and the tables have every key,
//! flag, function, request, shader and scene that the program has, and no other.

mod examples;
pub mod pages;
mod reference;
