//! Bodies and their shapes, as a model file writes them.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::LazyLock;

/// The geometry of a shape: exactly one of the fields is given.
#[derive(Clone, Debug, Default)]
pub struct ShapeFile {
    /// A sphere.
    pub sphere: Option<SphereFile>,
    /// An ellipsoid.
    pub ellipsoid: Option<EllipsoidFile>,
    /// A box.
    pub block: Option<BoxFile>,
    /// A cylinder about local z.
    pub cylinder: Option<CylinderFile>,
    /// A capsule: a cylinder about local z with hemispheres on its ends.
    pub capsule: Option<CylinderFile>,
    /// A cone about local z, tip up; the local origin is half way up.
    pub cone: Option<CylinderFile>,
    /// The convex hull of points.
    pub hull: Option<HullFile>,
    /// A half space, always fixed.
    pub plane: Option<PlaneFile>,
    /// A triangle mesh, always fixed.
    pub mesh: Option<MeshFile>,
    /// A height field, always fixed.
    pub height_field: Option<HeightFieldFile>,
}

// Common fields are repeated in each type: with flattened types an unknown key would be reported without its line.

/// A type with the fields of [`ShapeFile`] after its own.
macro_rules! with_shape {
    ($(#[$meta:meta])* pub struct $name:ident { $($own:tt)* }) => {
        $(#[$meta])*
        pub struct $name {
            $($own)*
            /// A sphere.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub sphere: Option<SphereFile>,
            /// An ellipsoid.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub ellipsoid: Option<EllipsoidFile>,
            /// A box.
            #[serde(default, rename = "box", skip_serializing_if = "Option::is_none")]
            pub block: Option<BoxFile>,
            /// A cylinder about local z.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub cylinder: Option<CylinderFile>,
            /// A capsule: a cylinder about local z with hemispheres on its ends.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub capsule: Option<CylinderFile>,
            /// A cone about local z, tip up; the local origin is half way up.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub cone: Option<CylinderFile>,
            /// The convex hull of points.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub hull: Option<HullFile>,
            /// A half space, always fixed.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub plane: Option<PlaneFile>,
            /// A triangle mesh, always fixed.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub mesh: Option<MeshFile>,
            /// A height field, always fixed.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub height_field: Option<HeightFieldFile>,
        }

        impl $name {
            /// The geometry among the keys.
            pub fn shape(&self) -> ShapeFile {
                ShapeFile {
                    sphere: self.sphere.clone(),
                    ellipsoid: self.ellipsoid.clone(),
                    block: self.block.clone(),
                    cylinder: self.cylinder.clone(),
                    capsule: self.capsule.clone(),
                    cone: self.cone.clone(),
                    hull: self.hull.clone(),
                    plane: self.plane.clone(),
                    mesh: self.mesh.clone(),
                    height_field: self.height_field.clone(),
                }
            }

            /// Set the keys of the geometry.
            pub fn set_shape(&mut self, shape: ShapeFile) {
                self.sphere = shape.sphere;
                self.ellipsoid = shape.ellipsoid;
                self.block = shape.block;
                self.cylinder = shape.cylinder;
                self.capsule = shape.capsule;
                self.cone = shape.cone;
                self.hull = shape.hull;
                self.plane = shape.plane;
                self.mesh = shape.mesh;
                self.height_field = shape.height_field;
            }
        }
    };
}

with_shape! {
    /// A body: the keys of one shape, or several shapes under `shapes`.
    #[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct BodyFile {
        /// Name.
        pub name: String,
        /// Class, by which scenes select bodies for rendering; the name if not given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub class: Option<String>,
        /// Name of the material.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub material: Option<String>,
        /// Name of the collision group.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub group: Option<String>,
        /// Shapes, if there are several; an empty list for a body without shapes.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub shapes: Option<Vec<PartFile>>,
        /// Position of the body's frame, m, world.
        #[serde(default)]
        pub position: [f64; 3],
        /// Orientation of the body's frame, as a rotation about an axis.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub rotate: Option<RotateFile>,
        /// Orientation of the body's frame, as a quaternion w, x, y, z; either this or `rotate`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub orientation: Option<[f64; 4]>,
        /// Velocity of the centre of mass at the start, m/s, world.
        #[serde(default)]
        pub velocity: [f64; 3],
        /// Angular velocity at the start, rad/s, body frame.
        #[serde(default)]
        pub angular_velocity: [f64; 3],
        /// Whether the body is fixed: a static obstacle.
        #[serde(default)]
        pub fixed: bool,
        /// Mass, kg; from the density of the materials if not given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub mass: Option<f64>,
        /// Moments of inertia about the centre of mass along the body's axes, kg m²: xx, yy, zz, and xy, xz, yz if they are not zero.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub inertia: Option<Vec<f64>>,
        /// Centre of mass in the body's frame, m; from the shapes if not given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub center: Option<[f64; 3]>,
        /// Time at which the body appears, s; the start of its stage if not given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub appears: Option<f64>,
        /// Time until which the body is held in place, s.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub held_until: Option<f64>,
    }
}

with_shape! {
    /// One of several shapes of a body.
    #[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct PartFile {
        /// Name of the material; the body's if not given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub material: Option<String>,
        /// Position in the body's frame, m.
        #[serde(default)]
        pub position: [f64; 3],
        /// Orientation in the body's frame, as a rotation about an axis.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub rotate: Option<RotateFile>,
        /// Orientation in the body's frame, as a quaternion w, x, y, z; either this or `rotate`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub orientation: Option<[f64; 4]>,
    }
}

/// A sphere.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereFile {
    /// Radius, m.
    pub radius: f64,
}

/// An ellipsoid.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidFile {
    /// Half axes, m.
    pub radii: [f64; 3],
}

/// A box.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxFile {
    /// Edge lengths, m.
    pub size: [f64; 3],
}

/// A cylinder, a capsule or a cone about local z.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderFile {
    /// Radius, m; of a cone that of the base.
    pub radius: f64,
    /// Length along z, m; of a capsule without its hemispheres.
    pub length: f64,
}

/// A convex hull: of `points`, or of the vertices of a `file`; exactly one of the two is given.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HullFile {
    /// Points, in the unit of `scale`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<[f64; 3]>>,
    /// Path of an OBJ or STL file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Metres per unit of the points or of the file.
    #[serde(default = "one")]
    pub scale: f64,
}

/// A half space: all points below the plane through the body's position.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneFile {
    /// Normal, out of the half space; its length is of no effect.
    pub normal: [f64; 3],
}

/// A triangle mesh, solid behind its faces.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// Path of an OBJ or STL file, whose triangles face outwards.
    pub file: PathBuf,
    /// Metres per unit of the file.
    #[serde(default = "one")]
    pub scale: f64,
}

/// A height field about the body's position: from an `image` or a `grid` file; exactly one of the two is given.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeightFieldFile {
    /// Path of a PNG image; its brightness is the height.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<PathBuf>,
    /// Path of a text file: one line per row (from −y to +y), heights in m, separated by commas, semicolons, spaces or tabs; lines that
    /// begin with `#` are comments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grid: Option<PathBuf>,
    /// Lengths along x and y, m.
    pub size: [f64; 2],
    /// Heights of black and of white, m, for an `image`.
    #[serde(default = "default_height")]
    pub height: [f64; 2],
}

/// A rotation about an axis.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotateFile {
    /// Axis, of any length but zero.
    pub axis: [f64; 3],
    /// Angle, degrees.
    pub angle: f64,
}

impl BodyFile {
    /// A body with a name, and the defaults of all other keys.
    pub fn named(name: &str) -> BodyFile {
        static PLAIN: LazyLock<BodyFile> =
            LazyLock::new(|| serde_yaml::from_str("name: body").expect("all other keys of a body have defaults"));
        BodyFile { name: name.into(), ..PLAIN.clone() }
    }
}

fn default_height() -> [f64; 2] {
    [0.0, 1.0]
}

fn one() -> f64 {
    1.0
}
