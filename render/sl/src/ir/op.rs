//! Operations.

use super::register::{FloatReg, Operand, Reg, TextReg, TripleReg};
use crate::shadeop::number::{Binary, Unary};

/// A shading function: the index of its row in [`super::builtins::TABLE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Builtin(u16);

impl Builtin {
    pub(super) const fn of_index(index: usize) -> Builtin {
        Builtin(index as u16)
    }

    pub(super) const fn index(self) -> usize {
        self.0 as usize
    }
}

/// What is asked of the scene by name; answers are numbers or text, or nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// A parameter of the primitive's surface shader.
    Surface,
    /// Of its displacement shader.
    Displacement,
    /// Of its atmosphere.
    Atmosphere,
    /// Of the light whose turn it is in an `illuminance` loop.
    LightSource,
    /// Of the shader at the other end of a ray.
    Incident,
    /// Of the shader on the other side of the surface.
    Opposite,
    /// An attribute.
    Attribute,
    /// An option.
    Option,
    /// What the renderer says of itself.
    RendererInfo,
    /// What is known of the ray that is followed.
    RayInfo,
    /// What is known of a texture, whose name goes before.
    TextureInfo,
}

/// How a map is looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lookup {
    /// By s and t.
    Texture,
    /// By a direction.
    Environment,
    /// By a place: how much is in shadow.
    Shadow,
}

/// Which way a triple changes with the space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transform {
    /// With translation.
    Point,
    /// Without.
    Vector,
    /// By the inverse transpose.
    Normal,
    /// The matrix from one space to the other, after a matrix.
    Matrix,
}

/// An operation.
#[derive(Clone, Debug)]
pub enum Op {
    /// A constant: one number, the same for all components.
    Const(Reg, f32),
    /// A constant string.
    TextConst(TextReg, String),
    /// Copy a string.
    TextCopy(TextReg, TextReg),
    /// Whether two strings are the same: 1 or 0.
    TextEqual(FloatReg, TextReg, TextReg),
    /// Component by component; an operand of width 1 is spread over a wider result.
    Unary(Unary, Reg, Reg),
    /// Component by component; an operand of width 1 is spread over a wider result.
    Binary(Binary, Reg, Reg, Reg),
    /// Where condition: then, else otherwise.
    Select(Reg, FloatReg, Reg, Reg),
    /// Three numbers to a triple, or sixteen to a matrix.
    Pack(Reg, Vec<FloatReg>),
    /// A component of a triple.
    Component(FloatReg, TripleReg, u8),
    /// Assign to a variable, where the points are active.
    Assign(Reg, Reg),
    /// An element of an array: result, first element, length, index.
    Load(Reg, Reg, u16, FloatReg),
    /// Assign to an element of an array: first element, length, index, value.
    Store(Reg, u16, FloatReg, Reg),
    /// The same of strings.
    TextLoad(TextReg, TextReg, u16, FloatReg),
    /// The same of strings.
    TextStore(TextReg, u16, FloatReg, TextReg),
    /// A colour from one colour space to another.
    ColorSpace(TripleReg, TripleReg, TextReg, TextReg),
    /// A spline: result, basis, the value and the knots.
    Spline(Reg, TextReg, Vec<Reg>),
    /// Whether a string matches a pattern: result, pattern, string.
    Match(FloatReg, TextReg, TextReg),
    /// Text of a format and its values.
    Format(TextReg, Vec<Operand>),
    /// Print a format and its values.
    Print(Vec<Operand>),
    /// Ask the scene: whether there is an answer, what, by which strings, and where the answer goes (an array's first, its length).
    Ask {
        /// 1 if there is an answer.
        dst: FloatReg,
        /// What.
        what: Ask,
        /// Names.
        names: Vec<TextReg>,
        /// Where the answer goes.
        out: Operand,
        /// Elements there.
        len: u16,
    },
    /// Look a map up: result, how, name, channel, where, and options by name.
    Map {
        /// The result.
        dst: Reg,
        /// How.
        how: Lookup,
        /// Name of the map.
        name: TextReg,
        /// First channel (1).
        channel: FloatReg,
        /// s and t, a direction, or a place.
        at: Vec<Reg>,
        /// `width`, `blur` and the like.
        options: Vec<(TextReg, Operand)>,
    },
    /// A built-in function.
    Call(Builtin, Reg, Vec<Reg>),
    /// Change space: result, operand, from, to (string registers).
    Transform(Transform, Reg, Reg, TextReg, TextReg),
    /// `if`
    If(FloatReg, Vec<Op>, Vec<Op>),
    /// Repeat: condition's operations, condition, body, step.
    Loop(Vec<Op>, FloatReg, Vec<Op>, Vec<Op>),
    /// Leave this number of loops.
    Break(u16),
    /// Leave all but the last of this number of loops, and go to that one's step.
    Continue(u16),
    /// A function's body in place of its call.
    Inline(Vec<Op>),
    /// Leave the function's body.
    Return,
    /// For rays from position about an axis within an angle: those that hit something, then those that do not.
    Gather {
        /// Position.
        position: TripleReg,
        /// Axis.
        axis: TripleReg,
        /// Angle.
        angle: FloatReg,
        /// Number of rays.
        samples: FloatReg,
        /// Where what is asked of a ray or a hit goes, by name.
        out: Vec<(String, Reg)>,
        /// For a hit.
        hit: Vec<Op>,
        /// For a miss.
        miss: Vec<Op>,
    },
    /// For every light that reaches position within an angle about an axis: L and Cl are set.
    Illuminance {
        /// Position.
        position: TripleReg,
        /// Axis.
        axis: TripleReg,
        /// Angle.
        angle: FloatReg,
        /// Register of L.
        l: TripleReg,
        /// Register of Cl.
        cl: TripleReg,
        /// Which lights: a category, or one with `-` before it for all others.
        category: Option<TextReg>,
        /// Parameters of the lights that are wanted, and where they go.
        wanted: Vec<(String, Reg)>,
        /// What is done for each.
        body: Vec<Op>,
    },
    /// Light from everywhere along an axis.
    Solar {
        /// Axis.
        axis: TripleReg,
        /// Angle.
        angle: FloatReg,
        /// Register of L.
        l: TripleReg,
        /// The light's doing.
        body: Vec<Op>,
    },
    /// Light from a point, within an angle about an axis.
    Illuminate {
        /// Position.
        position: TripleReg,
        /// Axis.
        axis: TripleReg,
        /// Angle.
        angle: FloatReg,
        /// Register of L.
        l: TripleReg,
        /// Register of Ps.
        ps: TripleReg,
        /// The light's doing.
        body: Vec<Op>,
    },
}
