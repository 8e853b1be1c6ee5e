//! The simulation on graphics devices: so far the contacts between spheres and their solution by Jacobi and APGD, each file beside its kernels.
//!
//! Positions are in fixed point ([`fixed`]), so that gaps are right far from the origin. The stages are those of the CPU back end
//! ([`crate::stages`]), with other columns in between: a sphere is in one bin, and pairs lie in the order of bins.

mod apgd;
mod bin_emit;
mod bin_start;
mod bounds;
pub mod collision;
pub mod contact_solve;
mod contact_write;
pub mod fixed;
mod jacobi;
mod pair_write;
mod problem;
pub mod rows;
mod spheres;

#[cfg(test)]
mod tests;
