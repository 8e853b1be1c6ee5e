//! The back end on the processor: buckets, sampling, shading at visible points, and rays.

pub mod blur;
pub mod bucket;
pub mod bvh;
pub mod imager;
pub mod lanes;
pub mod samples;
pub mod shade;
pub mod still;
pub mod view;
pub mod visible;
