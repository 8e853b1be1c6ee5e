//! The parts that the kernels of the stages import, and their compilation.

use crate::plan::Narrow;
use gpu::{Device, GpuError, Kernel, Kernels, Part, Work};

/// Parts by name, with the end of their files' names.
macro_rules! parts {
    ($end:literal: $($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!($name, $end, ".wgsl")))),*]
    };
}

/// The parts of kernels.
const PARTS: &[Part<'static>] = parts!(
    "":
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
    "impulse",
    "body_impulse",
    "body_spin",
    "spin",
    "body_state",
    "leave_spin",
    "body_response",
    "joint_solve",
    "partial",
    "parts_total",
    "both_totals",
    "turn",
    "contact_hash",
    "scalars",
    "visit",
    "tile_bodies",
    "tile_spheres",
    "settling",
    "tile_listed",
    "tile_decided",
    "tile_visit",
    "tile_most",
    "manifold",
    "tensor",
    "row",
    "inertia",
    "contact_row",
    "shape_box",
    "push",
    "displaced",
    "spun",
    "solid",
    "kinds",
    "placed",
    "side",
    "point",
    "put_contact",
    "clip",
    "support",
    "feature",
    "nearest",
    "ordered",
    "creep",
    "begin_solve",
    "rolls",
    "roll",
    "hulls",
    "node",
    "surfaces",
    "triangle",
    "triangle_id",
);

/// Those that stand in their stead for shapes of any kind.
const ANY_PARTS: &[Part<'static>] =
    parts!("_any": "row", "inertia", "contact_row", "shape_box", "push", "displaced", "spun", "spin", "leave_spin");

/// The part that stands in for its own for contacts with rolling friction.
const ROLL_PARTS: &[Part<'static>] = parts!("_with": "rolls");

/// The part that stands in for its own where some shapes are hulls.
const HULL_PARTS: &[Part<'static>] = parts!("_with": "hulls");

/// Those that stand in for their own where some fixtures are surfaces.
const SURFACE_PARTS: &[Part<'static>] = parts!("_with": "surfaces", "triangle");

/// What kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// The shapes that move.
    pub narrow: Narrow,
    /// Whether contacts have rolling and spinning friction.
    pub rolls: bool,
    /// Whether some shapes are convex hulls.
    pub hulls: bool,
    /// Whether some fixtures are meshes or height fields.
    pub surfaces: bool,
}

/// Rows of a workgroup.
pub const ROWS: usize = 256;

/// A kernel of a stage.
pub fn kernel(device: &Device, kernels: &Kernels, name: &'static str, text: &str) -> Result<Kernel, GpuError> {
    kernels.get(device, name, text, PARTS)
}

/// A kernel for what a model has.
pub fn kernel_of(
    layout: Layout,
    device: &Device,
    kernels: &Kernels,
    text: (&'static str, &str),
) -> Result<Kernel, GpuError> {
    kernel_with(layout, device, kernels, text, &[])
}

/// The same with more parts.
pub fn kernel_with(
    layout: Layout,
    device: &Device,
    kernels: &Kernels,
    (name, text): (&'static str, &str),
    more: &[Part<'static>],
) -> Result<Kernel, GpuError> {
    let of = |has: bool, parts: &'static [Part<'static>]| if has { parts } else { &[] };
    let own = [
        of(layout.narrow == Narrow::Any, ANY_PARTS),
        of(layout.rolls, ROLL_PARTS),
        of(layout.hulls, HULL_PARTS),
        of(layout.surfaces, SURFACE_PARTS),
    ];
    let parts: Vec<Part> = own.into_iter().flatten().chain(PARTS).chain(more).copied().collect();
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
