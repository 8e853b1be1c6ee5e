//! The back end on the processor: buckets, sampling, shading at visible points, and rays.

pub mod blur;
pub mod bucket;
pub mod bvh;
pub mod deferred;
pub mod displace;
pub mod displaced;
pub mod footprint;
pub mod frame;
pub mod globals;
pub mod imager;
pub mod known;
pub mod lanes;
pub mod mesh;
pub mod met;
pub mod micropolygon;
pub mod openness;
pub mod raster;
pub mod rays;
pub mod render;
pub mod samples;
pub mod shade;
pub mod sort;
pub mod still;
pub mod tree;
pub mod view;
pub mod volumes;
