//! The kinds of shapes.

/// Farthest that anything reaches or is, m: the single precision of collisions and images holds squares of it.
pub const FARTHEST: f64 = 1e15;

/// The kind of a shape, which defines the meaning of its size, m.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum ShapeKind {
    /// Sphere; size is (radius, radius, radius).
    Sphere,
    /// Ellipsoid; size is the three half axes.
    Ellipsoid,
    /// Box; size is the three half lengths.
    Box,
    /// Cylinder about local z; size is (radius, radius, half length).
    Cylinder,
    /// Capsule: a cylinder about local z with hemispheres on its ends; size is (radius, radius, half length of the cylinder).
    Capsule,
    /// Cone about local z, its base at −z and its tip at +z; size is (radius, radius, half height).
    Cone,
    /// Convex hull of points; size is the half lengths of the box about its origin that contains it.
    Hull,
    /// Half space below local z = 0; size is unused.
    Plane,
    /// Static triangle mesh; size is the half lengths of the box about its origin that contains it.
    Mesh,
    /// Static height field; size is the half lengths of the box about its origin that contains it.
    HeightField,
}

impl ShapeKind {
    /// All kinds, in the order of the enum.
    pub const ALL: [ShapeKind; 10] = [
        ShapeKind::Sphere,
        ShapeKind::Ellipsoid,
        ShapeKind::Box,
        ShapeKind::Cylinder,
        ShapeKind::Capsule,
        ShapeKind::Cone,
        ShapeKind::Hull,
        ShapeKind::Plane,
        ShapeKind::Mesh,
        ShapeKind::HeightField,
    ];

    /// Name, as in model files and frame tables.
    pub fn name(self) -> &'static str {
        match self {
            ShapeKind::Sphere => "sphere",
            ShapeKind::Ellipsoid => "ellipsoid",
            ShapeKind::Box => "box",
            ShapeKind::Cylinder => "cylinder",
            ShapeKind::Capsule => "capsule",
            ShapeKind::Cone => "cone",
            ShapeKind::Hull => "hull",
            ShapeKind::Plane => "plane",
            ShapeKind::Mesh => "mesh",
            ShapeKind::HeightField => "height_field",
        }
    }

    /// Whether the shape is a surface, which only fixed bodies have: it is not binned, and every shape is tested against it.
    pub fn is_surface(self) -> bool {
        matches!(self, ShapeKind::Plane | ShapeKind::Mesh | ShapeKind::HeightField)
    }
}
