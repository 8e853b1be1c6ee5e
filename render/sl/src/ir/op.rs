//! Operations.

use super::register::{FloatReg, Operand, Reg, TextReg, TripleReg};
use crate::shadeop::number::{Binary, Unary};

/// Handle of a shading function: the index of its row in [`super::builtins::TABLE`].
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

/// The kind of a query by name (message passing and information functions, RISpec 15.8).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// `surface`: a parameter of the primitive's surface shader.
    Surface,
    /// `displacement`: a parameter of the primitive's displacement shader.
    Displacement,
    /// `atmosphere`: a parameter of the primitive's atmosphere shader.
    Atmosphere,
    /// `lightsource`: a parameter of the current light of an `illuminance` loop.
    LightSource,
    /// `incident`: a parameter of the volume shader on the side that the incident ray comes from.
    Incident,
    /// `opposite`: a parameter of the volume shader on the opposite side of the surface.
    Opposite,
    /// `shadername`: the name of the primitive's shader of a type.
    ShaderName,
    /// `attribute`: an attribute of the primitive.
    Attribute,
    /// `option`: an option of the image.
    Option,
    /// `rendererinfo`: name and version of the renderer.
    RendererInfo,
    /// `rayinfo`: type and depth of the ray that is shaded.
    RayInfo,
    /// `textureinfo`: a property of a texture; two names, the texture and the property.
    TextureInfo,
}

/// The kind of a map lookup (RISpec 15.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lookup {
    /// `texture`: by s and t.
    Texture,
    /// `environment`: by a direction.
    Environment,
    /// `shadow`: by a position; the value is the fraction in shadow, 0 to 1.
    Shadow,
}

/// The rule by which a value changes with the coordinate system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transform {
    /// A point: with translation.
    Point,
    /// A vector: without translation.
    Vector,
    /// A normal: by the inverse transpose.
    Normal,
    /// A matrix: the transformation is applied after it.
    Matrix,
}

/// An operation. The register of the result comes first.
#[derive(Clone, Debug)]
pub enum Op {
    /// A constant: result, and the number for all its components.
    Const(Reg, f32),
    /// A constant string: result, text.
    TextConst(TextReg, String),
    /// Copy a string: result, operand.
    TextCopy(TextReg, TextReg),
    /// Whether two strings are equal: result (1 or 0), and the strings.
    TextEqual(FloatReg, TextReg, TextReg),
    /// A unary operation, component by component: operation, result, operand. An operand of width 1 is repeated for a wider result.
    Unary(Unary, Reg, Reg),
    /// A binary operation, component by component: operation, result, operands. An operand of width 1 is repeated for a wider
    /// result.
    Binary(Binary, Reg, Reg, Reg),
    /// Select by a condition: result, condition, the value where the condition is not 0, the value where it is 0.
    Select(Reg, FloatReg, Reg, Reg),
    /// A triple of three numbers, or a matrix of sixteen: result, numbers.
    Pack(Reg, Vec<FloatReg>),
    /// A component of a triple: result, triple, index of the component.
    Component(FloatReg, TripleReg, u8),
    /// Assign to a variable at active points: variable, value.
    Assign(Reg, Reg),
    /// Warn if an index at an active point is that of no component: index, count of components, byte of the source.
    Within(FloatReg, u16, u32),
    /// Load an element of an array: result, first element, length, index, byte of the source.
    Load(Reg, Reg, u16, FloatReg, u32),
    /// Assign to an element of an array at active points: first element, length, index, value, byte of the source.
    Store(Reg, u16, FloatReg, Reg, u32),
    /// Load an element of an array of strings: result, first element, length, index, byte of the source.
    TextLoad(TextReg, TextReg, u16, FloatReg, u32),
    /// Assign to an element of an array of strings: first element, length, index, value, byte of the source.
    TextStore(TextReg, u16, FloatReg, TextReg, u32),
    /// Convert a colour between colour spaces: result, colour, from, to, byte of the source.
    ColorSpace(TripleReg, TripleReg, TextReg, TextReg, u32),
    /// Evaluate a spline: result, basis, then the parameter and the knots.
    Spline(Reg, TextReg, Vec<Reg>),
    /// Whether a string matches a pattern: result, pattern, string.
    Match(FloatReg, TextReg, TextReg),
    /// `format`: result, then the format and its values, byte of the source.
    Format(TextReg, Vec<Operand>, u32),
    /// `printf`: the format and its values.
    Print(Vec<Operand>),
    /// Query the scene by name.
    Ask {
        /// Result: 1 if there is an answer, else 0.
        dst: FloatReg,
        /// The kind of the query.
        what: Ask,
        /// The names that are queried.
        names: Vec<TextReg>,
        /// The register that takes the answer; of an array its first.
        out: Operand,
        /// Count of elements of the array; 1 for a single value.
        len: u16,
        /// Byte of the source.
        place: u32,
    },
    /// Look up a map.
    Map {
        /// The result.
        dst: Reg,
        /// The kind of the lookup.
        how: Lookup,
        /// Name of the map.
        name: TextReg,
        /// The first channel, from 0.
        channel: FloatReg,
        /// s and t, a direction, or a position; or four of these, the corners of the filter's area.
        at: Vec<Reg>,
        /// Optional parameters by name, such as `width` and `blur`.
        options: Vec<(TextReg, Operand)>,
        /// Byte of the source.
        place: u32,
    },
    /// Call a shading function: function, result, arguments.
    Call(Builtin, Reg, Vec<Reg>),
    /// Change the coordinate system: rule, result, operand, name of the system it is in, name of the new one, byte
    /// of the source.
    Transform(Transform, Reg, Reg, TextReg, TextReg, u32),
    /// `if`: condition, block where it is not 0, block where it is 0.
    If(FloatReg, Vec<Op>, Vec<Op>),
    /// `for` and `while`: operations that compute the condition, condition, body, step, byte of the source.
    Loop(Vec<Op>, FloatReg, Vec<Op>, Vec<Op>, u32),
    /// `break`: leave this count of enclosing loops.
    Break(u16),
    /// `continue`: of this count of enclosing loops, leave all but the outermost, and go to the step of that one.
    Continue(u16),
    /// The inlined body of a function that the shader defines.
    Inline(Vec<Op>),
    /// `return`: leave the inlined body.
    Return,
    /// `gather`: trace rays from a position within a cone.
    Gather {
        /// Origin of the rays.
        position: TripleReg,
        /// Axis of the cone.
        axis: TripleReg,
        /// Half angle of the cone, radians.
        angle: FloatReg,
        /// Count of rays.
        samples: FloatReg,
        /// Values of a ray or hit that are wanted, such as `ray:length` or `surface:Ci`, and the registers that take them.
        out: Vec<(String, Reg)>,
        /// Block for rays that hit a surface.
        hit: Vec<Op>,
        /// Block for rays that hit no surface.
        miss: Vec<Op>,
    },
    /// `illuminance`: for every light that reaches a position from within a cone, set L and Cl and run a block.
    Illuminance {
        /// Position that is lit.
        position: TripleReg,
        /// Axis of the cone.
        axis: TripleReg,
        /// Half angle of the cone, radians.
        angle: FloatReg,
        /// Register of L.
        l: TripleReg,
        /// Register of Cl.
        cl: TripleReg,
        /// Category of the lights to take; with `-` before it, all lights but those. All lights if not given.
        category: Option<TextReg>,
        /// Parameters of the lights that are wanted, and the registers that take them.
        wanted: Vec<(String, Reg)>,
        /// Block for each light.
        body: Vec<Op>,
    },
    /// `solar`: light from infinitely far away, along directions within a cone.
    Solar {
        /// Axis of the cone.
        axis: TripleReg,
        /// Half angle of the cone, radians.
        angle: FloatReg,
        /// Register of L.
        l: TripleReg,
        /// Block at the points that the light reaches.
        body: Vec<Op>,
    },
    /// `illuminate`: light from a position, within a cone.
    Illuminate {
        /// Position of the light.
        position: TripleReg,
        /// Axis of the cone.
        axis: TripleReg,
        /// Half angle of the cone, radians.
        angle: FloatReg,
        /// Register of L.
        l: TripleReg,
        /// Register of Ps.
        ps: TripleReg,
        /// Block at the points that the light reaches.
        body: Vec<Op>,
    },
}
