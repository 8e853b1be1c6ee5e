//! The parts that the kernels of the stages import, and their compilation.

use gpu::{Device, GpuError, Kernel, Kernels, Part, Work};

/// The parts, by name: the file of each has the same name.
macro_rules! parts {
    ($($name:literal),* $(,)?) => {
        const PARTS: &[Part<'static>] = &[$(($name, include_str!(concat!($name, ".wgsl")))),*];
    };
}

parts!(
    "fixed",
    "sphere",
    "fixture",
    "outline",
    "touch",
    "tight",
    "bins",
    "contact",
    "solve_row",
    "project",
    "residual_term",
    "body_response",
    "partial",
    "turn",
    "contact_hash",
    "scalars",
    "visit",
);

/// Rows of a workgroup.
pub const ROWS: usize = 256;

/// A kernel of a stage.
pub fn kernel(device: &Device, kernels: &Kernels, name: &'static str, text: &str) -> Result<Kernel, GpuError> {
    kernels.get(device, name, text, PARTS)
}

/// A kernel of a stage, with one more part.
pub fn kernel_with(
    device: &Device,
    kernels: &Kernels,
    (name, text): (&'static str, &str),
    part: Part<'static>,
) -> Result<Kernel, GpuError> {
    let parts: Vec<Part> = PARTS.iter().copied().chain([part]).collect();
    kernels.get(device, name, text, &parts)
}

/// Workgroups for `n` rows.
pub fn groups(n: usize) -> Work<'static> {
    Work::Groups(n.div_ceil(ROWS) as u32)
}

/// Words of a number of single precision, for the parameters of a kernel.
pub fn bits(x: f64) -> u32 {
    (x as f32).to_bits()
}
