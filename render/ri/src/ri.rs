//! The trait: one method a call of the RenderMan Interface (RISpec 3.2), and the instance array, which is ours.
//!
//! A method that a renderer leaves out answers "not supported yet" with the call's name; the reader adds file and line.

use crate::instances::{Fit, InstanceShape, Instances};
use crate::params::{Class, Declaration, Param, Params, Type};
use crate::table::requests;
use glam::{Mat4, Quat, Vec3};
use std::path::{Path, PathBuf};

/// Order, knots and range of a NURBS patch along one parameter (`NuPatch`, RISpec 5.3).
#[derive(Clone, Debug, PartialEq)]
pub struct Knots {
    /// Count of control points.
    pub n: i32,
    /// Order: the degree plus one.
    pub order: i32,
    /// Knots; `[n + order]`.
    pub knots: Vec<f32>,
    /// Minimum and maximum parameter.
    pub range: [f32; 2],
}

/// Trim curves (`TrimCurve`, RISpec 5.3): closed loops of NURBS curves in the parameter plane of a patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrimCurves {
    /// Count of curves in each loop; `[n_loops]`.
    pub n_curves: Vec<i32>,
    /// Order of each curve; one entry for each curve of all loops.
    pub order: Vec<i32>,
    /// Knots of the curves, one curve after the other; n + order for each.
    pub knot: Vec<f32>,
    /// Minimum parameter of each curve.
    pub min: Vec<f32>,
    /// Maximum parameter of each curve.
    pub max: Vec<f32>,
    /// Count of control points of each curve.
    pub n: Vec<i32>,
    /// Homogeneous u of all control points, one curve after the other.
    pub u: Vec<f32>,
    /// Homogeneous v of all control points.
    pub v: Vec<f32>,
    /// Weight of all control points.
    pub w: Vec<f32>,
}

/// Tags of a subdivision mesh (`SubdivisionMesh`, RISpec 5.4), such as `crease`, with their arguments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tags {
    /// Names of the tags; `[n_tags]`.
    pub names: Vec<String>,
    /// Counts of integer and of float arguments of each tag; `[2 n_tags]`.
    pub n_args: Vec<i32>,
    /// Integer arguments of all tags, one tag after the other.
    pub integers: Vec<i32>,
    /// Float arguments of all tags, one tag after the other.
    pub floats: Vec<f32>,
}

/// The error of a call of [`Ri`]. Mostly it has no place in a file: the caller adds that.
#[derive(Clone, Debug, PartialEq)]
pub struct Fail {
    /// The error message.
    pub message: String,
    /// The file, line and column, from 1, of an earlier call that it lies in.
    pub at: Option<(PathBuf, (usize, usize))>,
}

impl Fail {
    /// An error with this message.
    pub fn new(message: impl Into<String>) -> Fail {
        Fail { message: message.into(), at: None }
    }

    /// The same of a call that stands there.
    pub fn at(self, at: Option<(PathBuf, (usize, usize))>) -> Fail {
        Fail { at, ..self }
    }
}

impl std::fmt::Display for Fail {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Fail {}

/// The result of a call of [`Ri`].
pub type RiResult = Result<(), Fail>;

macro_rules! calls {
    ($(#[doc = $doc:literal] $name:ident [$($where:ident)+]
       $(=> $method:ident($($kind:ident $($what:literal)? ($($arg:ident: $ty:ty),+))*))?;)*) => {
        /// The RenderMan Interface (RISpec 3.2): one method per request, and the instance array, an extension.
        ///
        /// Matrices are row-major for row vectors; angles are in degrees; bounds are x_min, x_max, y_min, y_max, z_min, z_max. A method
        /// that is not implemented returns an error that names the request as unsupported.
        #[allow(unused_variables)]
        pub trait Ri {
            $($(
                #[doc = concat!("`", stringify!($name), "`:", $doc)]
                fn $method(&mut self, $($($arg: $ty),+),*) -> RiResult {
                    Err(unsupported(stringify!($name)))
                }
            )?)*

            /// `ArchiveRecord`: write a comment into an archive; `kind` is `comment` or `structure`.
            fn archive_record(&mut self, kind: &str, text: &str) -> RiResult {
                Err(unsupported("ArchiveRecord"))
            }

            /// Take a warning of the reader; by default it goes to the standard error.
            fn warn(&mut self, message: String) {
                eprintln!("warning: {message}");
            }

            /// Take the place of the request whose call follows, its file, line and column; none once that is done.
            fn stands_at(&mut self, place: Option<(&Path, (usize, usize))>) {}

            /// The area of a bound (object space) on the raster, square pixels: the level of detail that `Procedural` programs are
            /// given.
            fn detail(&self, bound: [f32; 6]) -> f32 {
                1e6
            }

            /// Draw many instances of one shape, an extension of the interface; by default each instance becomes standard calls in
            /// an attribute block.
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

/// Say where a shape stands in its object space, for what is drawn next, unless it is that space's own.
fn request_fit(fit: Fit, ri: &mut (impl Ri + ?Sized)) -> RiResult {
    let triple = |name: &str, v: Vec3| {
        let mut param = Param::floats(name, Class::Uniform, Type::Float, v.to_array());
        param.decl.array = 3;
        param
    };
    let parts = [("size", fit.size, Vec3::ONE), ("offset", fit.offset, Vec3::ZERO)];
    let params: Vec<Param> = parts.into_iter().filter(|(_, v, none)| v != none).map(|(n, v, _)| triple(n, v)).collect();
    if params.is_empty() { Ok(()) } else { ri.attribute("shape", params) }
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
        // The transformation has the scale, which other renderers take for a part of object space.
        let mut fit = all.fit(i);
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
                fit.size = Vec3::ONE;
                request_fit(fit, ri)?;
                ri.sphere(radius, -radius, radius, 360.0, on_shape)?;
            }
            (InstanceShape::Sphere, None) => {
                ri.concat_transform(all.matrix(i).to_cols_array())?;
                request_fit(fit, ri)?;
                ri.sphere(1.0, -1.0, 1.0, 360.0, on_shape)?;
            }
            (InstanceShape::Object(handle), _) => {
                ri.concat_transform(all.matrix(i).to_cols_array())?;
                request_fit(fit, ri)?;
                ri.object_instance(handle)?;
            }
        }
        ri.attribute_end()?;
    }
    Ok(())
}
