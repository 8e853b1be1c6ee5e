//! The table of shading functions: the built-in functions that shaders call, and those that operators are lowered to.
//!
//! A row is one form of a function: its name, its arguments, its result and how it is computed. Lowering finds a call's row here,
//! [`super::validate()`] checks the registers of [`super::Op::Call`] against it, the optimiser reads what it depends on, and a back
//! end finds its evaluator in it. A function that is a few lines of the language itself needs no row: it goes into the prelude.
//!
//! Source: RISpec section 15.

use super::op::{Ask, Builtin, Lookup, Transform};
use super::types::Kind;
use crate::shadeop::call::Evaluator;
use crate::shadeop::number::{Binary, Unary};
use crate::shadeop::{grid, matrix, numbers, pattern, triple};

/// The types that an argument of a shading function may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arg {
    /// A number.
    Float,
    /// Any triple.
    Triple,
    /// A point, a vector or a normal.
    Direction,
    /// A number or a triple.
    Any,
    /// A matrix, or a number, which becomes the diagonal of a matrix.
    Matrix,
    /// A number, a triple or a matrix.
    Value,
}

impl Arg {
    /// Whether a register of this width may be the argument.
    pub fn takes_width(self, width: usize) -> bool {
        match self {
            Arg::Float => width == 1,
            Arg::Triple | Arg::Direction => width == 3,
            Arg::Any => width == 1 || width == 3,
            Arg::Matrix => width == 16,
            Arg::Value => true,
        }
    }
}

/// The type of a shading function's result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gives {
    /// A value of this type.
    Is(Kind),
    /// A value of the first argument's type.
    First,
    /// A triple where one is expected, otherwise a number.
    TripleOrFloat,
    /// A number where one is expected, otherwise a colour.
    FloatOrColor,
}

impl Gives {
    /// Whether a register of this width may hold the result, if the first argument has width `first`.
    pub fn has_width(self, width: usize, first: usize) -> bool {
        match self {
            Gives::Is(kind) => width == kind.width(),
            Gives::First => width == first,
            Gives::TripleOrFloat | Gives::FloatOrColor => width == 1 || width == 3,
        }
    }
}

/// A shading function that the back end computes from queries of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneCall {
    /// `ambient`: the sum of the ambient lights.
    Ambient,
    /// `transmission`: the fraction of light, by colour channel, that passes from one point to another.
    Transmission,
    /// `trace(P, R)`: the colour that a ray brings back, or, as a float, the distance to its hit.
    Trace,
    /// `occlusion(P, N, samples)`: the fraction of the hemisphere about N that surfaces hide.
    Occlusion,
    /// `openness(P, N, up)`: the parts of the sky's light that get to P.
    Openness,
    /// `surroundings(P, N, up, sun)`: the same, and what light the bodies around send on.
    Surroundings,
    /// `indirectdiffuse(P, N, samples)`: the mean colour of the surfaces that the hemisphere about N sees.
    IndirectDiffuse,
}

/// A shading function with a lowering rule of its own, since no row describes its arguments or it becomes several operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `snoise` and its kin: noise from −1 to 1.
    SignedNoise,
    /// `random`: a random number, one per point, or one per grid where it is assigned to a uniform variable.
    Random,
    /// `mix`
    Mix,
    /// `clamp`
    Clamp,
    /// `faceforward`, with and without a reference.
    FaceForward,
    /// `Du`
    Du,
    /// `Dv`
    Dv,
    /// `Deriv`
    Deriv,
    /// `comp`
    Component,
    /// `setcomp`, or `setxcomp`, `setycomp` and `setzcomp` with their component.
    SetComponent(Option<u8>),
    /// `transform`, `vtransform` and `ntransform`.
    Transform(Transform),
    /// `mtransform`
    MatrixTransform,
    /// `ctransform`
    ColorTransform,
    /// `spline`
    Spline,
    /// `concat`
    Concat,
    /// `format`
    Format,
    /// `printf`
    Print,
    /// `match`
    Match,
    /// `shadername`, of the shader itself or of another type.
    ShaderName,
    /// A query by name, such as `attribute` or `rayinfo`.
    Ask(Ask),
    /// A lookup in a map: `texture`, `environment` or `shadow`.
    Map(Lookup),
    /// `bake` and its kin, which have no effect: baked values are not kept.
    Bake,
}

/// The way a shading function is computed.
#[derive(Clone, Copy, Debug)]
pub enum How {
    /// By a unary operation of the IR, component by component.
    Unary(Unary),
    /// By a binary operation of the IR, component by component.
    Binary(Binary),
    /// By taking this component of a triple.
    Component(u8),
    /// By an evaluator, over a whole grid at once.
    Grid(Evaluator),
    /// By queries of the scene.
    Scene(SceneCall),
    /// By a lowering rule.
    Form(Form),
    /// By the function of the prelude with this name, for calls with this count of arguments.
    Prelude(&'static str, usize),
}

/// One form of a shading function: one list of argument types and its result.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The function's name in shaders; empty for functions that only operators and lowering rules produce.
    pub name: &'static str,
    /// The function's name in the IR.
    pub ir: &'static str,
    /// Types of the arguments.
    pub takes: &'static [Arg],
    /// Type of the result.
    pub gives: Gives,
    /// The way the function is computed.
    pub how: How,
    /// The form of calls, for messages. Where empty, messages name the types in `takes`, and the arguments of a call are checked
    /// against these.
    pub usage: &'static str,
    /// Whether the value at a point depends on neighbouring points of the grid.
    pub neighbours: bool,
    /// Whether the value differs from point to point even for uniform arguments.
    pub varying: bool,
}

impl Row {
    const fn new(name: &'static str, takes: &'static [Arg], gives: Gives, how: How) -> Row {
        Row { name, ir: name, takes, gives, how, usage: "", neighbours: false, varying: false }
    }

    const fn ir(self, ir: &'static str) -> Row {
        Row { ir, ..self }
    }

    const fn usage(self, usage: &'static str) -> Row {
        Row { usage, ..self }
    }

    const fn neighbours(self) -> Row {
        Row { neighbours: true, ..self }
    }

    const fn varying(self) -> Row {
        Row { varying: true, ..self }
    }
}

/// The functions that operators and lowering rules become.
impl Builtin {
    /// Dot product, a · b.
    pub const DOT: Builtin = Builtin::named("dot", 2);
    /// Cross product, a × b.
    pub const CROSS: Builtin = Builtin::named("cross", 2);
    /// Linear interpolation.
    pub const MIX: Builtin = Builtin::named("mix", 3);
    /// A normal, flipped to face against a direction.
    pub const FACE_FORWARD: Builtin = Builtin::named("faceforward", 3);
    /// Component of a triple by index.
    pub const COMPONENT: Builtin = Builtin::named("comp", 2);
    /// Component of a matrix by row and column.
    pub const MATRIX_COMPONENT: Builtin = Builtin::named("comp", 3);
    /// A triple with one component replaced.
    pub const SET_COMPONENT: Builtin = Builtin::named("setcomp", 3);
    /// A matrix with one component replaced.
    pub const SET_MATRIX_COMPONENT: Builtin = Builtin::named("setcomp", 4);
    /// A matrix with a number on its diagonal.
    pub const DIAGONAL: Builtin = Builtin::named("diagonal", 1);
    /// Product of two matrices.
    pub const MATRIX_MULTIPLY: Builtin = Builtin::named("matrixmultiply", 2);
    /// Product of a matrix with the inverse of another.
    pub const MATRIX_DIVIDE: Builtin = Builtin::named("matrixdivide", 2);
    /// Whether two matrices are equal, 1 or 0.
    pub const MATRIX_EQUAL: Builtin = Builtin::named("matrixequal", 2);
    /// A point transformed by a matrix.
    pub const MATRIX_POINT: Builtin = Builtin::named("matrixpoint", 2);
    /// A vector transformed by a matrix.
    pub const MATRIX_VECTOR: Builtin = Builtin::named("matrixvector", 2);
    /// A normal transformed by a matrix.
    pub const MATRIX_NORMAL: Builtin = Builtin::named("matrixnormal", 2);
    /// A random number per point.
    pub const RANDOM: Builtin = Builtin::named("random", 2);
    /// A random number per grid.
    pub const RANDOM_OF_GRID: Builtin = Builtin::named("random", 1);
    /// Derivative along u.
    pub const DU: Builtin = Builtin::named("du", 3);
    /// Derivative along v.
    pub const DV: Builtin = Builtin::named("dv", 3);
    /// Filter width: the change of a value from one point of the grid to the next.
    pub const WIDTH: Builtin = Builtin::named("width", 1);

    /// The function's row in [`TABLE`].
    pub fn row(self) -> &'static Row {
        &TABLE[self.index()]
    }

    /// The function with an evaluator that has this name in the IR and takes `n_args` arguments. Panics if there is none: meant for
    /// constants.
    pub const fn named(ir: &str, n_args: usize) -> Builtin {
        let mut k = 0;
        while k < TABLE.len() {
            if same(TABLE[k].ir, ir) && TABLE[k].takes.len() == n_args && matches!(TABLE[k].how, How::Grid(_)) {
                return Builtin::of_index(k);
            }
            k += 1;
        }
        panic!("no such shading function")
    }
}

/// The rows of the shading function `name`, one per form, with their handles in the IR.
pub fn rows(name: &str) -> impl Iterator<Item = (Builtin, &'static Row)> + Clone {
    let named = TABLE.iter().enumerate().filter(move |(_, row)| row.name == name && !name.is_empty());
    named.map(|(k, row)| (Builtin::of_index(k), row))
}

const fn same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut k = 0;
    while k < a.len() && k < b.len() && a[k] == b[k] {
        k += 1;
    }
    k == a.len() && k == b.len()
}

use Arg::{Any, Direction as D, Float as F, Matrix as M, Triple as T, Value as V};
use Gives::{First, FloatOrColor, Is, TripleOrFloat};
use Kind::{Color, Float, Matrix, Normal, Point, Vector};

/// A function of one number.
const fn unary(name: &'static str, f: Unary) -> Row {
    Row::new(name, &[Any], First, How::Unary(f))
}

/// A function of two numbers.
const fn binary(name: &'static str, f: Binary) -> Row {
    Row::new(name, &[Any, Any], First, How::Binary(f))
}

/// A function with an evaluator.
const fn grid(name: &'static str, takes: &'static [Arg], gives: Gives, f: Evaluator) -> Row {
    Row::new(name, takes, gives, How::Grid(f))
}

/// What an operator or a rule of lowering becomes.
const fn inner(ir: &'static str, takes: &'static [Arg], gives: Gives, f: Evaluator) -> Row {
    grid("", takes, gives, f).ir(ir)
}

/// A function that asks the scene.
const fn scene(name: &'static str, takes: &'static [Arg], gives: Gives, call: SceneCall) -> Row {
    Row::new(name, takes, gives, How::Scene(call)).varying()
}

/// A function that lowering has a rule for.
const fn form(name: &'static str, form: Form, usage: &'static str) -> Row {
    Row::new(name, &[], First, How::Form(form)).usage(usage)
}

/// A function of the prelude, of which there are several by the number of arguments.
const fn prelude(name: &'static str, n_args: usize, function: &'static str) -> Row {
    Row::new(name, &[], First, How::Prelude(function, n_args))
}

const NOISE: &str = "noise(float), noise(float, float), noise(point) or noise(point, float)";
const CELL_NOISE: &str = "cellnoise(float), cellnoise(float, float), cellnoise(point) or cellnoise(point, float)";
const SIGNED_NOISE: &str = "snoise(float), snoise(float, float), snoise(point) or snoise(point, float)";
const PERIODIC_NOISE: &str =
    "pnoise(float, period), pnoise(x, y, periods), pnoise(point, period) or of point and float";

/// All shading functions.
pub const TABLE: &[Row] = &[
    // Numbers.
    unary("abs", Unary::Abs),
    unary("sign", Unary::Sign),
    unary("floor", Unary::Floor),
    unary("ceil", Unary::Ceil),
    unary("round", Unary::Round),
    unary("sqrt", Unary::Sqrt),
    unary("inversesqrt", Unary::InverseSqrt),
    unary("sin", Unary::Sin),
    unary("cos", Unary::Cos),
    unary("tan", Unary::Tan),
    unary("asin", Unary::Asin),
    unary("acos", Unary::Acos),
    unary("atan", Unary::Atan),
    Row::new("atan", &[F, F], Is(Float), How::Binary(Binary::Atan2)),
    unary("exp", Unary::Exp),
    unary("log", Unary::Log),
    grid("log", &[F, F], Is(Float), numbers::log_base).ir("logbase"),
    unary("radians", Unary::Radians),
    unary("degrees", Unary::Degrees),
    binary("pow", Binary::Pow),
    binary("mod", Binary::Mod),
    binary("min", Binary::Min),
    binary("max", Binary::Max),
    binary("step", Binary::Step),
    grid("smoothstep", &[F, F, F], Is(Float), numbers::smooth_step),
    form("clamp", Form::Clamp, "clamp(value, low, high)"),
    form("mix", Form::Mix, "mix(a, b, float), or mix of three colours"),
    inner("mix", &[V, V, F], First, numbers::mix),
    form("spline", Form::Spline, "other arguments of `spline`"),
    prelude("filterstep", 2, "filterstep2_"),
    prelude("filterstep", 3, "filterstep3_"),
    // Triples.
    inner("dot", &[T, T], Is(Float), triple::dot_product),
    inner("cross", &[T, T], Is(Vector), triple::cross_product),
    grid("length", &[T], Is(Float), triple::length),
    grid("normalize", &[T], First, triple::normalize),
    form("faceforward", Form::FaceForward, "faceforward(N, I) or faceforward(N, I, Nref)"),
    inner("faceforward", &[T, T, T], Is(Normal), triple::face_forward),
    grid("reflect", &[T, T], Is(Vector), triple::reflected),
    grid("refract", &[T, T, F], Is(Vector), triple::refracted),
    prelude("fresnel", 5, "fresnel5_"),
    prelude("fresnel", 7, "fresnel7_"),
    prelude("rotate", 4, "rotate_"),
    Row::new("xcomp", &[T], Is(Float), How::Component(0)),
    Row::new("ycomp", &[T], Is(Float), How::Component(1)),
    Row::new("zcomp", &[T], Is(Float), How::Component(2)),
    form("comp", Form::Component, "comp(triple, index) or comp(matrix, row, column)"),
    inner("comp", &[T, F], Is(Float), matrix::component),
    inner("comp", &[M, F, F], Is(Float), matrix::component),
    form("setcomp", Form::SetComponent(None), ""),
    form("setxcomp", Form::SetComponent(Some(0)), ""),
    form("setycomp", Form::SetComponent(Some(1)), ""),
    form("setzcomp", Form::SetComponent(Some(2)), ""),
    inner("setcomp", &[T, F, F], First, matrix::with_component),
    inner("setcomp", &[M, F, F, F], First, matrix::with_component),
    form("ctransform", Form::ColorTransform, "ctransform(to, colour) or ctransform(from, to, colour)"),
    // Matrices and spaces.
    inner("diagonal", &[F], Is(Matrix), matrix::diagonal),
    inner("matrixmultiply", &[M, M], Is(Matrix), matrix::multiply),
    inner("matrixdivide", &[M, M], Is(Matrix), matrix::divide),
    inner("matrixequal", &[M, M], Is(Float), matrix::equal),
    inner("matrixpoint", &[M, T], Is(Point), matrix::point),
    inner("matrixvector", &[M, T], Is(Vector), matrix::vector),
    inner("matrixnormal", &[M, T], Is(Normal), matrix::normal),
    grid("determinant", &[M], Is(Float), matrix::determinant),
    grid("translate", &[M, T], Is(Matrix), matrix::translate),
    grid("rotate", &[M, F, T], Is(Matrix), matrix::rotate),
    grid("scale", &[M, T], Is(Matrix), matrix::scale),
    form("transform", Form::Transform(Transform::Point), "transform(to, value) or transform(from, to, value)"),
    form("vtransform", Form::Transform(Transform::Vector), "vtransform(to, value) or vtransform(from, to, value)"),
    form("ntransform", Form::Transform(Transform::Normal), "ntransform(to, value) or ntransform(from, to, value)"),
    form("mtransform", Form::MatrixTransform, "mtransform(to, matrix) or mtransform(from, to, matrix)"),
    // Patterns.
    grid("noise", &[F], TripleOrFloat, pattern::noise).usage(NOISE),
    grid("noise", &[F, F], TripleOrFloat, pattern::noise).usage(NOISE),
    grid("noise", &[T], TripleOrFloat, pattern::noise).usage(NOISE),
    grid("noise", &[D, F], TripleOrFloat, pattern::noise_in_time).usage(NOISE),
    grid("cellnoise", &[F], TripleOrFloat, pattern::cell_noise).usage(CELL_NOISE),
    grid("cellnoise", &[F, F], TripleOrFloat, pattern::cell_noise).usage(CELL_NOISE),
    grid("cellnoise", &[T], TripleOrFloat, pattern::cell_noise).usage(CELL_NOISE),
    grid("cellnoise", &[D, F], TripleOrFloat, pattern::cell_noise_in_time).usage(CELL_NOISE),
    grid("pnoise", &[F, F], TripleOrFloat, pattern::periodic_noise).ir("periodicnoise").usage(PERIODIC_NOISE),
    grid("pnoise", &[F, F, F, F], TripleOrFloat, pattern::periodic_noise).ir("periodicnoise").usage(PERIODIC_NOISE),
    grid("pnoise", &[D, T], TripleOrFloat, pattern::periodic_noise).ir("periodicnoise").usage(PERIODIC_NOISE),
    grid("pnoise", &[D, F, D, F], TripleOrFloat, pattern::periodic_noise).ir("periodicnoise").usage(PERIODIC_NOISE),
    form("snoise", Form::SignedNoise, SIGNED_NOISE),
    form("random", Form::Random, "random()"),
    inner("random", &[F, T], TripleOrFloat, pattern::random),
    // Without a place, the grid's first point stands for all.
    inner("random", &[F], TripleOrFloat, pattern::random).neighbours(),
    // The grid.
    form("Du", Form::Du, "Du of numbers or triples"),
    form("Dv", Form::Dv, "Dv of numbers or triples"),
    form("Deriv", Form::Deriv, "Deriv of numbers or triples"),
    inner("du", &[V, F, F], First, grid::along_u).neighbours(),
    inner("dv", &[V, F, F], First, grid::along_v).neighbours(),
    grid("area", &[T], Is(Float), grid::area).neighbours().varying(),
    grid("calculatenormal", &[T], Is(Normal), grid::normal).neighbours().varying(),
    grid("filterwidth", &[F], Is(Float), grid::width).ir("width").neighbours(),
    // Light and rays.
    scene("ambient", &[], Is(Color), SceneCall::Ambient),
    scene("transmission", &[T, T], Is(Color), SceneCall::Transmission),
    scene("visibility", &[T, T], Is(Color), SceneCall::Transmission),
    scene("trace", &[T, T], FloatOrColor, SceneCall::Trace),
    scene("occlusion", &[T, T, F], Is(Float), SceneCall::Occlusion),
    scene("openness", &[T, T, T], Is(Vector), SceneCall::Openness),
    scene("surroundings", &[T, T, T, T], Is(Matrix), SceneCall::Surroundings),
    scene("indirectdiffuse", &[T, T, F], Is(Color), SceneCall::IndirectDiffuse),
    // Maps.
    form("texture", Form::Map(Lookup::Texture), ""),
    form("environment", Form::Map(Lookup::Environment), ""),
    form("shadow", Form::Map(Lookup::Shadow), ""),
    form("bake", Form::Bake, ""),
    form("bake3d", Form::Bake, ""),
    form("texture3d", Form::Bake, ""),
    // Strings.
    form("concat", Form::Concat, "concat of strings"),
    form("format", Form::Format, "format(pattern, values …)"),
    form("printf", Form::Print, "printf(pattern, values …)"),
    form("match", Form::Match, "match(pattern, text)"),
    // Messages.
    form("surface", Form::Ask(Ask::Surface), ""),
    form("displacement", Form::Ask(Ask::Displacement), ""),
    form("atmosphere", Form::Ask(Ask::Atmosphere), ""),
    form("lightsource", Form::Ask(Ask::LightSource), ""),
    form("incident", Form::Ask(Ask::Incident), ""),
    form("opposite", Form::Ask(Ask::Opposite), ""),
    form("shadername", Form::ShaderName, "shadername() or shadername(type)"),
    form("attribute", Form::Ask(Ask::Attribute), ""),
    form("option", Form::Ask(Ask::Option), ""),
    form("rendererinfo", Form::Ask(Ask::RendererInfo), ""),
    form("rayinfo", Form::Ask(Ask::RayInfo), ""),
    form("textureinfo", Form::Ask(Ask::TextureInfo), ""),
];
