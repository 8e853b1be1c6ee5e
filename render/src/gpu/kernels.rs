//! The kernels of a frame, compiled once for a device.

use crate::gprim::sphere::tile::eighths;
use gpu::{Buffer, Commands, Device, GpuError, Kernel, Kernels, Part, Work};

/// Parts that kernels import.
const PARTS: &[Part<'static>] = &[
    ("exact", include_str!("exact.wgsl")),
    ("cap", include_str!("cap.wgsl")),
    ("triangle", include_str!("triangle.wgsl")),
    ("raster", include_str!("raster.wgsl")),
    ("layer_ids", include_str!("layer_ids.wgsl")),
    ("layer_edges", include_str!("layer_edges.wgsl")),
    ("choice", include_str!("choice.wgsl")),
    ("layer_choice", include_str!("layer_choice.wgsl")),
    ("layer_slack", include_str!("layer_slack.wgsl")),
    ("blur_choice", include_str!("blur_choice.wgsl")),
    ("blur_layer_choice", include_str!("blur_layer_choice.wgsl")),
    ("blur_layer_slack", include_str!("blur_layer_slack.wgsl")),
    ("sampling", include_str!("sampling.wgsl")),
    ("blocks", include_str!("blocks.wgsl")),
    ("takes", include_str!("takes.wgsl")),
    ("mixed", include_str!("mixed.wgsl")),
    ("blur", include_str!("blur.wgsl")),
    ("blur_sampling", include_str!("blur_sampling.wgsl")),
    ("weights", include_str!("weights.wgsl")),
    ("blur_weights", include_str!("blur_weights.wgsl")),
    ("want", include_str!("want.wgsl")),
    ("wanted", include_str!("wanted.wgsl")),
    ("within", include_str!("within.wgsl")),
    ("layered", include_str!("layered.wgsl")),
    ("layer_takes", include_str!("layer_takes.wgsl")),
    ("layer_lists", include_str!("layer_lists.wgsl")),
    ("layer_repeats", include_str!("layer_repeats.wgsl")),
    ("join", include_str!("join.wgsl")),
    ("compose", include_str!("compose.wgsl")),
    ("no_outputs", include_str!("no_outputs.wgsl")),
    ("layer_outputs", include_str!("layer_outputs.wgsl")),
    ("seen_outputs", include_str!("seen_outputs.wgsl")),
    ("limited", include_str!("limited.wgsl")),
    ("filter_weight", include_str!("filter_weight.wgsl")),
];

/// Kernels by the stems of their files.
macro_rules! kernels {
    ($struct:ident, $device:ident $kernels:ident: $($name:ident),* $(; $($field:ident: $value:expr),*)?) => {{
        let texts = [$((stringify!($name), include_str!(concat!(stringify!($name), ".wgsl")))),*];
        $kernels.compile_all($device, &texts, PARTS)?;
        let mut texts = texts.into_iter();
        let mut next = || {
            let (name, text) = texts.next().expect("a text a kernel");
            $kernels.get($device, name, text, PARTS)
        };
        $struct { $($($field: $value,)*)? $($name: next()?),* }
    }};
}

/// The kernels of a frame, but for those of shaders, and what they read in every frame.
pub struct FrameKernels {
    /// Points of an eighth of each ring of a disk, for caps of spheres.
    pub disk: Buffer<[f32; 2]>,
    pub clear_samples: Kernel,
    pub cap_dice: Kernel,
    pub cap_points: Kernel,
    pub sampling: Sampling,
    pub visible_points: Kernel,
    pub point_colors: Kernel,
    pub relay: Kernel,
    pub sample_colors: Kernel,
    pub blur_colors: Kernel,
    pub filter: Kernel,
}

/// How micropolygons are sampled.
pub enum Sampling {
    /// In one pass, by atomics of 64 bits.
    Wide(NearestKernels),
    /// In two: the least depth, then the first that has it.
    Twice(DepthKernels),
}

/// The kernels of sampling in one pass.
pub struct NearestKernels {
    pub clear_nearest: Kernel,
    pub sample_nearest: Kernel,
    pub blur_nearest: Kernel,
    pub block_nearest: Kernel,
    pub part_nearest: Kernel,
}

/// The kernels of sampling in two passes.
pub struct DepthKernels {
    pub sample_depth: Kernel,
    pub uncover: Kernel,
    pub sample_id: Kernel,
    pub blur_depth: Kernel,
    pub blur_id: Kernel,
    pub block_depth: Kernel,
}

impl Sampling {
    fn new(device: &Device, kernels: &Kernels) -> Result<Sampling, GpuError> {
        Ok(if device.has_wide_atomics() {
            Sampling::Wide(
                kernels!(NearestKernels, device kernels: clear_nearest, sample_nearest, blur_nearest, block_nearest, part_nearest),
            )
        } else {
            Sampling::Twice(
                kernels!(DepthKernels, device kernels: sample_depth, uncover, sample_id, blur_depth, blur_id, block_depth),
            )
        })
    }
}

impl FrameKernels {
    /// Compile them.
    ///
    /// # Errors
    /// Those of [`Kernels::get`] and [`Buffer::of`].
    pub fn new(device: &Device, kernels: &Kernels) -> Result<FrameKernels, GpuError> {
        Ok(
            kernels!(FrameKernels, device kernels: clear_samples, cap_dice, cap_points, visible_points, point_colors, relay, sample_colors, blur_colors, filter;
            disk: Buffer::of(device, "points on a disk", &eighths())?, sampling: Sampling::new(device, kernels)?),
        )
    }
}

/// The kernels of layers, compiled for the first frame that has some.
pub struct LayerKernels {
    pub layer_count: Kernel,
    pub layer_fill: Kernel,
    pub blur_layer_count: Kernel,
    pub blur_layer_fill: Kernel,
    pub layer_total: Kernel,
    pub layer_sort: Kernel,
    pub layer_points: Kernel,
    pub layer_join: Kernel,
    pub blur_layer_join: Kernel,
    pub layer_colors: Kernel,
    pub layer_colors_outputs: Kernel,
    pub blur_layer_colors: Kernel,
    pub blur_layer_colors_outputs: Kernel,
}

impl LayerKernels {
    /// Compile them.
    ///
    /// # Errors
    /// Those of [`Kernels::get`].
    pub fn new(device: &Device, kernels: &Kernels) -> Result<LayerKernels, GpuError> {
        Ok(
            kernels!(LayerKernels, device kernels: layer_count, layer_fill, blur_layer_count, blur_layer_fill, layer_total, layer_sort,
            layer_points, layer_join, blur_layer_join, layer_colors, layer_colors_outputs, blur_layer_colors, blur_layer_colors_outputs),
        )
    }
}

/// The kernels of what displays take besides colours, compiled for the first frame whose displays do.
pub struct OutputKernels {
    pub point_outputs: Kernel,
    pub sample_outputs: Kernel,
    pub blur_outputs: Kernel,
    pub filter_outputs: Kernel,
}

impl OutputKernels {
    /// Compile them.
    ///
    /// # Errors
    /// Those of [`Kernels::get`].
    pub fn new(device: &Device, kernels: &Kernels) -> Result<OutputKernels, GpuError> {
        Ok(kernels!(OutputKernels, device kernels: point_outputs, sample_outputs, blur_outputs, filter_outputs))
    }
}

/// Workgroups of `size` invocations for `n` of them.
pub fn groups(n: usize, size: usize) -> Work<'static> {
    Work::Groups(n.div_ceil(size) as u32)
}

/// Commands of a stage of a frame, as its time on the device is told.
pub fn staged(stage: &'static str) -> Commands {
    let mut commands = Commands::new();
    commands.stage(stage);
    commands
}
