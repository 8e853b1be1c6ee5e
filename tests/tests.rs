//! The one test binary: each file of `tests/` is a module of it.

mod analytic;
mod blur;
mod broad_phase;
mod cli;
mod corpus;
mod determinism;
mod faults;
mod friction;
mod golden;
mod hider;
mod joints;
mod lanes;
mod language;
mod light;
mod outputs;
mod parity;
mod picture;
mod pipeline;
mod properties;
mod rays;
mod sheets;
mod solver;
mod terrain;
mod tidy;
mod warm_start;
