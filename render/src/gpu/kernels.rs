//! The kernels of a frame, compiled once for a device.

use gpu::{Device, GpuError, Kernel, Kernels, Part, Work};

/// Parts that kernels import.
const PARTS: &[Part<'static>] = &[
    ("exact", include_str!("exact.wgsl")),
    ("triangle", include_str!("triangle.wgsl")),
    ("raster", include_str!("raster.wgsl")),
    ("sampling", include_str!("sampling.wgsl")),
    ("takes", include_str!("takes.wgsl")),
    ("mixed", include_str!("mixed.wgsl")),
    ("blur", include_str!("blur.wgsl")),
    ("blur_sampling", include_str!("blur_sampling.wgsl")),
];

/// A kernel by the stem of its file.
macro_rules! kernels {
    ($device:ident $kernels:ident: $($name:ident),*) => {
        FrameKernels { $($name: $kernels.get(
            $device,
            stringify!($name),
            include_str!(concat!(stringify!($name), ".wgsl")),
            PARTS,
        )?),* }
    };
}

/// The kernels of a frame, but for those of shaders.
pub struct FrameKernels {
    pub clear_samples: Kernel,
    pub sample_depth: Kernel,
    pub uncover: Kernel,
    pub sample_id: Kernel,
    pub block_depth: Kernel,
    pub visible_points: Kernel,
    pub point_colors: Kernel,
    pub relay: Kernel,
    pub sample_colors: Kernel,
    pub blur_depth: Kernel,
    pub blur_id: Kernel,
    pub blur_colors: Kernel,
    pub filter: Kernel,
}

impl FrameKernels {
    /// Compile them.
    ///
    /// # Errors
    /// Those of [`Kernels::get`].
    pub fn new(device: &Device, kernels: &Kernels) -> Result<FrameKernels, GpuError> {
        Ok(
            kernels!(device kernels: clear_samples, sample_depth, uncover, sample_id, block_depth, visible_points, point_colors, relay,
            sample_colors, blur_depth, blur_id, blur_colors, filter),
        )
    }
}

/// Workgroups of `size` invocations for `n` of them.
pub fn groups(n: usize, size: usize) -> Work<'static> {
    Work::Groups(n.div_ceil(size) as u32)
}
