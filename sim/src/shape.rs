//! What shapes there are.

/// What a shape is; its `size` reads accordingly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum ShapeKind {
    /// Ball; size is (radius, radius, radius).
    Sphere,
    /// Ellipsoid; size is the three half axes.
    Ellipsoid,
    /// Box; size is the three half lengths.
    Box,
    /// Cylinder about local z; size is (radius, radius, half length).
    Cylinder,
    /// Cylinder about local z with half balls on its ends; size is (radius, radius, half length of the cylinder).
    Capsule,
    /// Cone about local z, its base at −z and its tip at +z; size is (radius, radius, half height).
    Cone,
    /// Convex hull of points; size is the half lengths of the box around it.
    Hull,
    /// Half space below local z = 0; size is unused.
    Plane,
    /// Static triangle mesh; size is the half lengths of the box around it.
    Mesh,
    /// Static height field; size is the half lengths of the box around it.
    HeightField,
}

impl ShapeKind {
    /// All kinds, in the order of their numbers.
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

    /// The name, as models and frame tables write it.
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

    /// Whether the shape is a surface that only static bodies carry: it is met shape by shape, not through bins.
    pub fn is_surface(self) -> bool {
        matches!(self, ShapeKind::Plane | ShapeKind::Mesh | ShapeKind::HeightField)
    }
}
