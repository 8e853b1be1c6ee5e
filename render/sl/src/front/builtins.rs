//! What shaders can call, and the global variables.

use super::ast::Ty;
use crate::ir::{Binary, Builtin, Unary};

/// How a built-in is lowered.
#[derive(Clone, Copy, Debug)]
pub enum How {
    /// Number by number.
    Unary(Unary),
    /// Number by number.
    Binary(Binary),
    /// As a call.
    Call(Builtin),
    /// A component.
    Component(u8),
}

/// A built-in: name, result, arguments, how. A result of `None` is that of the first argument.
pub type Signature = (&'static str, Option<Ty>, &'static [Arg], How);

/// What an argument may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arg {
    /// A number.
    Float,
    /// Any triple.
    Triple,
    /// A number or a triple.
    Any,
    /// A matrix.
    Matrix,
}

use Arg::{Any, Float as F, Matrix as M, Triple as T};

/// The table of built-ins with plain argument lists; `lower` knows the few others.
pub const SIGNATURES: &[Signature] = &[
    ("abs", None, &[Any], How::Unary(Unary::Abs)),
    ("sign", None, &[Any], How::Unary(Unary::Sign)),
    ("floor", None, &[Any], How::Unary(Unary::Floor)),
    ("ceil", None, &[Any], How::Unary(Unary::Ceil)),
    ("round", None, &[Any], How::Unary(Unary::Round)),
    ("sqrt", None, &[Any], How::Unary(Unary::Sqrt)),
    ("inversesqrt", None, &[Any], How::Unary(Unary::InverseSqrt)),
    ("sin", None, &[Any], How::Unary(Unary::Sin)),
    ("cos", None, &[Any], How::Unary(Unary::Cos)),
    ("tan", None, &[Any], How::Unary(Unary::Tan)),
    ("asin", None, &[Any], How::Unary(Unary::Asin)),
    ("acos", None, &[Any], How::Unary(Unary::Acos)),
    ("atan", None, &[Any], How::Unary(Unary::Atan)),
    ("atan", Some(Ty::Float), &[F, F], How::Binary(Binary::Atan2)),
    ("exp", None, &[Any], How::Unary(Unary::Exp)),
    ("log", None, &[Any], How::Unary(Unary::Log)),
    ("radians", None, &[Any], How::Unary(Unary::Radians)),
    ("degrees", None, &[Any], How::Unary(Unary::Degrees)),
    ("pow", None, &[Any, Any], How::Binary(Binary::Pow)),
    ("mod", None, &[Any, Any], How::Binary(Binary::Mod)),
    ("min", None, &[Any, Any], How::Binary(Binary::Min)),
    ("max", None, &[Any, Any], How::Binary(Binary::Max)),
    ("step", None, &[Any, Any], How::Binary(Binary::Step)),
    ("smoothstep", Some(Ty::Float), &[F, F, F], How::Call(Builtin::SmoothStep)),
    ("length", Some(Ty::Float), &[T], How::Call(Builtin::Length)),
    ("normalize", None, &[T], How::Call(Builtin::Normalize)),
    ("reflect", Some(Ty::Vector), &[T, T], How::Call(Builtin::Reflect)),
    ("refract", Some(Ty::Vector), &[T, T, F], How::Call(Builtin::Refract)),
    ("xcomp", Some(Ty::Float), &[T], How::Component(0)),
    ("ycomp", Some(Ty::Float), &[T], How::Component(1)),
    ("zcomp", Some(Ty::Float), &[T], How::Component(2)),
    ("ambient", Some(Ty::Color), &[], How::Call(Builtin::Ambient)),
    ("transmission", Some(Ty::Color), &[T, T], How::Call(Builtin::Transmission)),
    ("area", Some(Ty::Float), &[T], How::Call(Builtin::Area)),
    ("calculatenormal", Some(Ty::Normal), &[T], How::Call(Builtin::CalculateNormal)),
    ("filterwidth", Some(Ty::Float), &[F], How::Call(Builtin::Width)),
    ("determinant", Some(Ty::Float), &[M], How::Call(Builtin::Determinant)),
    ("translate", Some(Ty::Matrix), &[M, T], How::Call(Builtin::Translate)),
    ("rotate", Some(Ty::Matrix), &[M, F, T], How::Call(Builtin::Rotate)),
    ("scale", Some(Ty::Matrix), &[M, T], How::Call(Builtin::Scale)),
    ("trace", Some(Ty::Color), &[T, T], How::Call(Builtin::Trace)),
    ("occlusion", Some(Ty::Float), &[T, T, F], How::Call(Builtin::Occlusion)),
    ("indirectdiffuse", Some(Ty::Color), &[T, T, F], How::Call(Builtin::IndirectDiffuse)),
    ("log", Some(Ty::Float), &[F, F], How::Call(Builtin::LogBase)),
];

/// Built-ins that `lower` treats on its own.
pub const SPECIAL: &[&str] = &[
    "noise",
    "cellnoise",
    "mix",
    "clamp",
    "faceforward",
    "Du",
    "Dv",
    "Deriv",
    "transform",
    "vtransform",
    "ntransform",
    "comp",
    "snoise",
    "pnoise",
    "random",
    "spline",
    "ctransform",
    "mtransform",
    "concat",
    "format",
    "printf",
    "match",
];

/// Global variables: name and type. The grid supplies those that a shader uses.
pub const GLOBALS: &[(&str, Ty)] = &[
    ("P", Ty::Point),
    ("N", Ty::Normal),
    ("Ng", Ty::Normal),
    ("I", Ty::Vector),
    ("E", Ty::Point),
    ("Cs", Ty::Color),
    ("Os", Ty::Color),
    ("Ci", Ty::Color),
    ("Oi", Ty::Color),
    ("s", Ty::Float),
    ("t", Ty::Float),
    ("u", Ty::Float),
    ("v", Ty::Float),
    ("L", Ty::Vector),
    ("Cl", Ty::Color),
    ("Ol", Ty::Color),
    ("Ps", Ty::Point),
    ("time", Ty::Float),
    ("dtime", Ty::Float),
    ("dPdtime", Ty::Vector),
    ("alpha", Ty::Float),
    ("ncomps", Ty::Float),
];
