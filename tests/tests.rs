//! The one test binary: each file of `tests/` is a module of it.

mod analytic;
mod parity;
