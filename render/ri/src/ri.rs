//! The trait: one method a call of the RenderMan Interface (RISpec 3.2), and the instance array, which is ours.
//!
//! A method that a renderer leaves out answers "not supported yet" with the call's name; the reader adds file and line.

use crate::instances::{InstanceShape, Instances};
use crate::params::{Class, Declaration, Param, Params, Type};
use crate::table::requests;
use glam::{Mat4, Quat, Vec3};

/// Numbers of a NURBS patch along one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Knots {
    /// Control points.
    pub n: i32,
    /// Order: degree plus one.
    pub order: i32,
    /// Knots (n + order).
    pub knots: Vec<f32>,
    /// Minimum and maximum parameter.
    pub range: [f32; 2],
}

/// Loops of NURBS curves in u, v, w. Columns but the last three have a row a curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrimCurves {
    /// Curves of each loop.
    pub n_curves: Vec<i32>,
    /// Orders.
    pub order: Vec<i32>,
    /// Knots, one curve after the other.
    pub knot: Vec<f32>,
    /// Minimum parameters.
    pub min: Vec<f32>,
    /// Maximum parameters.
    pub max: Vec<f32>,
    /// Control points.
    pub n: Vec<i32>,
    /// Their u.
    pub u: Vec<f32>,
    /// Their v.
    pub v: Vec<f32>,
    /// Their weights.
    pub w: Vec<f32>,
}

/// Tags of a subdivision mesh: names, and for each its numbers of integers and of floats.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tags {
    /// Names.
    pub names: Vec<String>,
    /// Two numbers for each.
    pub n_args: Vec<i32>,
    /// All integers.
    pub integers: Vec<i32>,
    /// All floats.
    pub floats: Vec<f32>,
}

/// Why a call failed; who made it adds the place.
#[derive(Clone, Debug, PartialEq)]
pub struct Fail {
    /// What is wrong.
    pub message: String,
}

impl Fail {
    /// A failure with its message.
    pub fn new(message: impl Into<String>) -> Fail {
        Fail { message: message.into() }
    }
}

impl std::fmt::Display for Fail {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Fail {}

/// The result of a call.
pub type RiResult = Result<(), Fail>;

macro_rules! calls {
    ($(#[doc = $doc:literal] $name:ident [$($where:ident)+]
       $(=> $method:ident($($kind:ident $($what:literal)? ($($arg:ident: $ty:ty),+))*))?;)*) => {
        /// The RenderMan Interface. Matrices are 16 numbers, row after row, for row vectors.
        #[allow(unused_variables)]
        pub trait Ri {
            $($(
                #[doc = concat!("`", stringify!($name), "`:", $doc)]
                fn $method(&mut self, $($($arg: $ty),+),*) -> RiResult {
                    Err(unsupported(stringify!($name)))
                }
            )?)*

            /// A structured comment or any other record: kind `comment` or `structure`, and its text.
            fn archive_record(&mut self, kind: &str, text: &str) -> RiResult {
                Err(unsupported("ArchiveRecord"))
            }

            /// Be told of something odd that does not stop the reading.
            fn warn(&mut self, message: String) {
                eprintln!("warning: {message}");
            }

            /// How large a bound is on the raster, square pixels: what programs that make geometry are told.
            fn detail(&self, bound: [f32; 6]) -> f32 {
                1e6
            }

            /// Many instances of one shape; by default as standard calls.
            fn instances(&mut self, instances: Instances) -> RiResult {
                expand(&instances, self)
            }
        }
    };
}
requests!(calls);

fn unsupported(call: &str) -> Fail {
    Fail::new(format!("`{call}` is not supported yet"))
}

/// An instance array by standard calls: an attribute block for each instance.
fn expand(all: &Instances, ri: &mut (impl Ri + ?Sized)) -> RiResult {
    for i in 0..all.len() {
        ri.attribute_begin()?;
        let mut on_shape = Vec::new();
        for param in &all.params {
            let own = all.param_of(param, i);
            if own.decl.name == "Cs" && own.decl.ty == Type::Color {
                ri.color([own.numbers()[0], own.numbers()[1], own.numbers()[2]])?;
            } else {
                on_shape.push(Param { decl: Declaration { class: Class::Constant, ..own.decl }, values: own.values });
            }
        }
        if let Some((times, to)) = &all.moved {
            ri.motion_begin(times.to_vec())?;
            ri.translate([0.0; 3])?;
            ri.translate([0, 1, 2].map(|c| to[i][c] - all.position[i][c]))?;
            ri.motion_end()?;
        }
        let uniform = all.scale.get(i).filter(|s| s[0] == s[1] && s[1] == s[2]).map(|s| s[0]);
        match (&all.shape, uniform) {
            // A sphere of its own radius reads better than a scaled one, and its object space is not scaled.
            (InstanceShape::Sphere, Some(radius)) => {
                let place = Mat4::from_scale_rotation_translation(
                    Vec3::ONE,
                    all.orientation.get(i).map_or(Quat::IDENTITY, |q| Quat::from_array(*q)),
                    Vec3::from(all.position[i]),
                );
                ri.concat_transform(place.to_cols_array())?;
                ri.sphere(radius, -radius, radius, 360.0, on_shape)?;
            }
            (InstanceShape::Sphere, None) => {
                ri.concat_transform(all.matrix(i).to_cols_array())?;
                ri.sphere(1.0, -1.0, 1.0, 360.0, on_shape)?;
            }
            (InstanceShape::Object(handle), _) => {
                ri.concat_transform(all.matrix(i).to_cols_array())?;
                ri.object_instance(handle)?;
            }
        }
        ri.attribute_end()?;
    }
    Ok(())
}
