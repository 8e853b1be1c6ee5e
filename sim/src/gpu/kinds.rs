//! The kinds of shapes, as kernels know them (`fixture.wgsl`, `solid.wgsl`).

/// A plane; its normal is the third axis of its frame.
pub const PLANE: u32 = 0;
/// A box.
pub const BOX: u32 = 1;
/// A capsule; its radius is the first, its half height the third of its half lengths, as of the kinds below.
pub const CAPSULE: u32 = 2;
/// A cylinder.
pub const CYLINDER: u32 = 3;
/// A cone.
pub const CONE: u32 = 4;
/// A sphere about its body's centre of mass.
pub const BALL: u32 = 5;
/// A sphere elsewhere.
pub const SPHERE: u32 = 6;
/// An ellipsoid.
pub const ELLIPSOID: u32 = 7;
/// A convex hull.
pub const HULL: u32 = 8;
/// A mesh or a height field, whose triangles are fixtures, too.
pub const SURFACE: u32 = 9;
/// A triangle of one.
pub const TRIANGLE: u32 = 10;
