//! The intermediate representation: registers and structured operations.
//!
//! Invariants, which [`validate`] holds:
//! 1. Every register that an operation names exists, and numbers and strings are not confused.
//! 2. Operands have the widths that the operation asks for: 1 (float), 3 (triple) or 16 (matrix).
//! 3. Every register is written before it is read, on every path; globals and parameters count as written.
//! 4. `Break` and `Continue` stand inside a `Loop`, `Return` inside an `Inline`, `Solar` and `Illuminate` only in light shaders, `Illuminance` only outside.
//!
//! Whether a register is uniform (one value) or varying (one a point) is settled while running: an operation on uniform
//! operands gives a uniform result, so nothing uniform is computed twice.

/// What a shader is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShaderKind {
    /// Colour and opacity of a surface.
    Surface,
    /// Moves the surface.
    Displacement,
    /// A source of light.
    Light,
    /// What fills space.
    Volume,
    /// A last step on pixels.
    Imager,
}

impl ShaderKind {
    /// The keyword.
    pub fn name(self) -> &'static str {
        match self {
            ShaderKind::Surface => "surface",
            ShaderKind::Displacement => "displacement",
            ShaderKind::Light => "light",
            ShaderKind::Volume => "volume",
            ShaderKind::Imager => "imager",
        }
    }

    pub(crate) fn of_name(name: &str) -> Option<ShaderKind> {
        use ShaderKind::*;
        [Surface, Displacement, Light, Volume, Imager].into_iter().find(|k| k.name() == name)
    }
}

/// Index of a number register.
pub type Reg = u16;

/// Index of a string register.
pub type TextReg = u16;

/// What a value means, for parameters and globals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number.
    Float,
    /// A colour.
    Color,
    /// A position.
    Point,
    /// A direction.
    Vector,
    /// A normal.
    Normal,
    /// A matrix.
    Matrix,
    /// Text.
    Text,
}

impl Kind {
    /// The keyword.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Float => "float",
            Kind::Color => "color",
            Kind::Point => "point",
            Kind::Vector => "vector",
            Kind::Normal => "normal",
            Kind::Matrix => "matrix",
            Kind::Text => "string",
        }
    }

    /// Numbers in a value.
    pub fn width(self) -> usize {
        match self {
            Kind::Float | Kind::Text => 1,
            Kind::Color | Kind::Point | Kind::Vector | Kind::Normal => 3,
            Kind::Matrix => 16,
        }
    }
}

/// A shader parameter.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name.
    pub name: String,
    /// Type.
    pub kind: Kind,
    /// Declared varying.
    pub varying: bool,
    /// Declared an output.
    pub output: bool,
    /// Elements of an array.
    pub array: Option<u16>,
    /// Its register: of numbers, or of strings for [`Kind::Text`]; an array's elements follow each other.
    pub reg: u16,
    /// Computes the default.
    pub default: Vec<Op>,
}

/// Operations of one operand, number by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// Copy.
    Copy,
    /// −x
    Negate,
    /// 1 where x is 0, else 0.
    Not,
    /// |x|
    Abs,
    /// −1, 0 or 1.
    Sign,
    /// Square root, 0 below 0.
    Sqrt,
    /// 1/√x, 0 at 0.
    InverseSqrt,
    /// Sine.
    Sin,
    /// Cosine.
    Cos,
    /// Tangent.
    Tan,
    /// Arc sine.
    Asin,
    /// Arc cosine.
    Acos,
    /// Arc tangent.
    Atan,
    /// eˣ
    Exp,
    /// ln x
    Log,
    /// Greatest whole number not above x.
    Floor,
    /// Least whole number not below x.
    Ceil,
    /// Nearest whole number.
    Round,
    /// Degrees to radians.
    Radians,
    /// Radians to degrees.
    Degrees,
}

/// Operations of two operands, number by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    /// a + b
    Add,
    /// a − b
    Sub,
    /// a b
    Mul,
    /// a / b, 0 where b is 0.
    Div,
    /// Lesser.
    Min,
    /// Greater.
    Max,
    /// aᵇ
    Pow,
    /// a − b ⌊a/b⌋
    Mod,
    /// Angle of (b, a).
    Atan2,
    /// 0 below a, 1 from it on: step(a, b).
    Step,
    /// a < b
    Less,
    /// a ≤ b
    LessEqual,
    /// a = b
    Equal,
    /// Both not 0.
    And,
    /// Either not 0.
    Or,
}

/// Built-in functions of whole triples, of the scene, or of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Builtin {
    /// a · b
    Dot,
    /// a × b
    Cross,
    /// |a|
    Length,
    /// a/|a|, 0 at 0.
    Normalize,
    /// N turned against I.
    FaceForward,
    /// I mirrored at N.
    Reflect,
    /// I refracted at N with ratio eta.
    Refract,
    /// smoothstep(lo, hi, x)
    SmoothStep,
    /// a (1 − t) + b t
    Mix,
    /// Noise in [0, 1] of 1, 2, 3 or 4 numbers; the result's width says how many come out.
    Noise,
    /// The same, repeating: the places first, then as many periods.
    PeriodicNoise,
    /// Constant noise of the cell.
    CellNoise,
    /// Derivative along u.
    Du,
    /// Derivative along v.
    Dv,
    /// Normal of the surface that points make.
    CalculateNormal,
    /// Area of a point's micropolygon.
    Area,
    /// Sum of the lights that have no direction.
    Ambient,
    /// How much light gets from one point to another.
    Transmission,
    /// How much a value changes from point to point of the grid.
    Width,
    /// A number in [0, 1) that hangs on the place.
    Random,
    /// Component of a triple, or of a matrix (row, column), by number.
    Comp,
    /// A triple or matrix with one component replaced.
    SetComp,
    /// A number on the diagonal.
    Diagonal,
    /// a b
    MatrixMultiply,
    /// a b⁻¹
    MatrixDivide,
    /// Whether two matrices are equal: 1 or 0.
    MatrixEqual,
    /// Logarithm to a base: log(x, base).
    LogBase,
    /// Determinant.
    Determinant,
    /// A point by a matrix.
    MatrixPoint,
    /// A vector by a matrix.
    MatrixVector,
    /// A normal by a matrix.
    MatrixNormal,
    /// A translation before a matrix.
    Translate,
    /// A rotation (angle, axis) before a matrix.
    Rotate,
    /// A scale before a matrix.
    Scale,
    /// Colour of the light that a ray meets: trace(P, R).
    Trace,
    /// Part of the hemisphere about N that is hidden: occlusion(P, N, samples).
    Occlusion,
    /// Light that surfaces around send: indirectdiffuse(P, N, samples).
    IndirectDiffuse,
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

/// A number or a string register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// Numbers.
    Number(Reg),
    /// Text.
    Text(TextReg),
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
    TextEqual(Reg, TextReg, TextReg),
    /// Number by number; a width-1 operand is spread over a triple result.
    Unary(Unary, Reg, Reg),
    /// Number by number; a width-1 operand is spread over a triple result.
    Binary(Binary, Reg, Reg, Reg),
    /// Where condition: then, else otherwise.
    Select(Reg, Reg, Reg, Reg),
    /// Three numbers to a triple, or sixteen to a matrix.
    Pack(Reg, Vec<Reg>),
    /// A component of a triple.
    Component(Reg, Reg, u8),
    /// Assign to a variable, where the points are active.
    Assign(Reg, Reg),
    /// An element of an array: result, first element, length, index.
    Load(Reg, Reg, u16, Reg),
    /// Assign to an element of an array: first element, length, index, value.
    Store(Reg, u16, Reg, Reg),
    /// The same of strings.
    TextLoad(TextReg, TextReg, u16, Reg),
    /// The same of strings.
    TextStore(TextReg, u16, Reg, TextReg),
    /// A colour from one colour space to another.
    ColorSpace(Reg, Reg, TextReg, TextReg),
    /// A spline: result, basis, the value and the knots.
    Spline(Reg, TextReg, Vec<Reg>),
    /// Whether a string matches a pattern: result, pattern, string.
    Match(Reg, TextReg, TextReg),
    /// Text of a format and its values.
    Format(TextReg, Vec<Operand>),
    /// Print a format and its values.
    Print(Vec<Operand>),
    /// Ask the scene: whether there is an answer, what, by which strings, and where the answer goes (an array's first, its length).
    Ask {
        /// 1 if there is an answer.
        dst: Reg,
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
        channel: Reg,
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
    If(Reg, Vec<Op>, Vec<Op>),
    /// Repeat: condition's operations, condition, body, step.
    Loop(Vec<Op>, Reg, Vec<Op>, Vec<Op>),
    /// Leave so many loops.
    Break(u16),
    /// Leave all but the last of so many loops, and go to that one's step.
    Continue(u16),
    /// A function's body in place of its call.
    Inline(Vec<Op>),
    /// Leave the function's body.
    Return,
    /// For rays from position about an axis within an angle: those that hit something, then those that do not.
    Gather {
        /// Position (3), axis (3), angle (1), samples (1).
        args: [Reg; 4],
        /// Where what is asked of a ray or a hit goes, by name.
        out: Vec<(String, Reg)>,
        /// For a hit.
        hit: Vec<Op>,
        /// For a miss.
        miss: Vec<Op>,
    },
    /// For every light that reaches position within an angle about an axis: L and Cl are set.
    Illuminance {
        /// Position (3), axis (3) and angle (1).
        args: [Reg; 3],
        /// Register of L.
        l: Reg,
        /// Register of Cl.
        cl: Reg,
        /// Which lights: a category, or one with `-` before it for all others.
        category: Option<TextReg>,
        /// Parameters of the lights that are wanted, and where they go.
        wanted: Vec<(String, Reg)>,
        /// What is done for each.
        body: Vec<Op>,
    },
    /// Light from everywhere along an axis.
    Solar {
        /// Axis (3) and angle (1).
        args: [Reg; 2],
        /// Register of L.
        l: Reg,
        /// The light's doing.
        body: Vec<Op>,
    },
    /// Light from a point, within an angle about an axis.
    Illuminate {
        /// Position (3), axis (3) and angle (1).
        args: [Reg; 3],
        /// Register of L.
        l: Reg,
        /// Register of Ps.
        ps: Reg,
        /// The light's doing.
        body: Vec<Op>,
    },
}

/// A compiled shader.
#[derive(Clone, Debug)]
pub struct Program {
    /// What it is for.
    pub kind: ShaderKind,
    /// Its name.
    pub name: String,
    /// Width (1, 3 or 16) of each number register.
    pub widths: Vec<u8>,
    /// Number of string registers.
    pub n_texts: usize,
    /// Parameters, in their order.
    pub params: Vec<Parameter>,
    /// The globals that it reads or writes, with their registers.
    pub globals: Vec<(String, Reg)>,
    /// What it does.
    pub body: Vec<Op>,
    /// A light without `solar` and `illuminate`.
    pub is_ambient: bool,
    /// It leaves Oi as Os, so that what is opaque stays opaque.
    pub keeps_opacity: bool,
    /// What it does at a point hangs on the points beside it in the grid: by derivatives, or maps, whose filters go by them.
    pub reads_neighbours: bool,
}

impl Program {
    /// The register of a global, if the program uses it.
    pub fn global(&self, name: &str) -> Option<Reg> {
        self.globals.iter().find(|(n, _)| n == name).map(|(_, r)| *r)
    }
}

/// Hold a program to the invariants at the top of this file.
pub fn validate(program: &Program) -> Result<(), String> {
    let mut written = vec![false; program.widths.len()];
    let text_written = vec![false; program.n_texts];
    for (name, reg) in &program.globals {
        *written.get_mut(*reg as usize).ok_or(format!("global {name} has no register"))? = true;
    }
    let mut check = Check { program, written, text_written, loops: 0, inlines: 0 };
    for param in &program.params {
        check.block(&param.default)?;
        for k in 0..param.array.unwrap_or(1) {
            match param.kind {
                Kind::Text => check.read_text(param.reg + k)?,
                _ => check.read(param.reg + k)?,
            }
        }
    }
    check.block(&program.body)
}

struct Check<'a> {
    program: &'a Program,
    written: Vec<bool>,
    text_written: Vec<bool>,
    loops: usize,
    inlines: usize,
}

impl Check<'_> {
    fn read(&self, r: Reg) -> Result<(), String> {
        match self.written.get(r as usize) {
            Some(true) => Ok(()),
            Some(false) => Err(format!("register {r} is read before it is written")),
            None => Err(format!("register {r} does not exist")),
        }
    }

    fn read_text(&self, r: TextReg) -> Result<(), String> {
        match self.text_written.get(r as usize) {
            Some(true) => Ok(()),
            _ => Err(format!("string register {r} is read before it is written")),
        }
    }

    fn write(&mut self, r: Reg) -> Result<(), String> {
        *self.written.get_mut(r as usize).ok_or(format!("register {r} does not exist"))? = true;
        Ok(())
    }

    fn write_text(&mut self, r: TextReg) -> Result<(), String> {
        *self.text_written.get_mut(r as usize).ok_or(format!("string register {r} does not exist"))? = true;
        Ok(())
    }

    fn width(&self, r: Reg, expected: u8) -> Result<(), String> {
        self.read(r)?;
        let width = self.program.widths[r as usize];
        if width == expected { Ok(()) } else { Err(format!("register {r} has width {width}, expected {expected}")) }
    }

    /// Operands of a number-by-number operation: as wide as the result, or of width 1.
    fn spread(&mut self, dst: Reg, operands: &[Reg]) -> Result<(), String> {
        let width = *self.program.widths.get(dst as usize).ok_or(format!("register {dst} does not exist"))?;
        for r in operands {
            self.read(*r)?;
            let own = self.program.widths[*r as usize];
            if own != 1 && own != width {
                return Err(format!("register {r} has width {own}, result {dst} has {width}"));
            }
        }
        self.write(dst)
    }

    /// What is written in a block that may not run does not count afterwards.
    fn maybe(&mut self, ops: &[Op]) -> Result<(), String> {
        let before = (self.written.clone(), self.text_written.clone());
        self.block(ops)?;
        (self.written, self.text_written) = before;
        Ok(())
    }

    fn block(&mut self, ops: &[Op]) -> Result<(), String> {
        ops.iter().try_for_each(|op| self.op(op))
    }

    fn operand(&mut self, o: Operand) -> Result<(), String> {
        match o {
            Operand::Number(r) => self.read(r),
            Operand::Text(r) => self.read_text(r),
        }
    }

    fn op(&mut self, op: &Op) -> Result<(), String> {
        let in_light = self.program.kind == ShaderKind::Light;
        match op {
            Op::Const(dst, _) => self.write(*dst),
            Op::TextConst(dst, _) => self.write_text(*dst),
            Op::TextCopy(dst, a) => {
                self.read_text(*a)?;
                self.write_text(*dst)
            }
            Op::TextEqual(dst, a, b) | Op::Match(dst, a, b) => {
                self.read_text(*a)?;
                self.read_text(*b)?;
                self.write(*dst)
            }
            Op::Unary(_, dst, a) => self.spread(*dst, &[*a]),
            Op::Assign(dst, a) => self.spread(*dst, &[*a]),
            Op::Binary(_, dst, a, b) => self.spread(*dst, &[*a, *b]),
            Op::Select(dst, c, a, b) => self.spread(*dst, &[*c, *a, *b]),
            Op::Pack(dst, parts) => {
                parts.iter().try_for_each(|r| self.width(*r, 1))?;
                self.write(*dst)?;
                self.width(*dst, parts.len() as u8)
            }
            Op::Component(dst, a, _) => {
                self.width(*a, 3)?;
                self.write(*dst)
            }
            Op::Load(dst, first, len, index) => {
                self.width(*index, 1)?;
                (*first..first + len).try_for_each(|r| self.read(r))?;
                self.write(*dst)
            }
            Op::Store(first, len, index, value) => {
                self.width(*index, 1)?;
                self.read(*value)?;
                (*first..first + len).try_for_each(|r| self.read(r))
            }
            Op::TextLoad(dst, first, len, index) => {
                self.width(*index, 1)?;
                (*first..first + len).try_for_each(|r| self.read_text(r))?;
                self.write_text(*dst)
            }
            Op::TextStore(first, len, index, value) => {
                self.width(*index, 1)?;
                self.read_text(*value)?;
                (*first..first + len).try_for_each(|r| self.read_text(r))
            }
            Op::Call(_, dst, args) => {
                args.iter().try_for_each(|r| self.read(*r))?;
                self.write(*dst)
            }
            Op::Spline(dst, basis, args) => {
                self.read_text(*basis)?;
                args.iter().try_for_each(|r| self.read(*r))?;
                self.write(*dst)
            }
            Op::Format(dst, args) => {
                args.iter().try_for_each(|o| self.operand(*o))?;
                self.write_text(*dst)
            }
            Op::Print(args) => args.iter().try_for_each(|o| self.operand(*o)),
            Op::Ask { dst, names, out, len, .. } => {
                names.iter().try_for_each(|r| self.read_text(*r))?;
                match out {
                    Operand::Number(r) => (*r..r + len).try_for_each(|r| self.read(r))?,
                    Operand::Text(r) => (*r..r + len).try_for_each(|r| self.read_text(r))?,
                }
                self.write(*dst)
            }
            Op::Map { dst, name, channel, at, options, .. } => {
                self.read_text(*name)?;
                self.width(*channel, 1)?;
                at.iter().try_for_each(|r| self.read(*r))?;
                for (name, value) in options {
                    self.read_text(*name)?;
                    self.operand(*value)?;
                }
                self.write(*dst)
            }
            Op::Transform(how, dst, a, from, to) => {
                self.width(*a, if *how == Transform::Matrix { 16 } else { 3 })?;
                self.read_text(*from)?;
                self.read_text(*to)?;
                self.write(*dst)
            }
            Op::ColorSpace(dst, a, from, to) => {
                self.width(*a, 3)?;
                self.read_text(*from)?;
                self.read_text(*to)?;
                self.write(*dst)
            }
            Op::If(c, then, otherwise) => {
                self.width(*c, 1)?;
                self.maybe(then)?;
                self.maybe(otherwise)
            }
            Op::Loop(head, c, body, step) => {
                self.block(head)?;
                self.width(*c, 1)?;
                self.loops += 1;
                self.maybe(body)?;
                self.loops -= 1;
                self.maybe(step)
            }
            Op::Break(n) | Op::Continue(n) if self.loops < *n as usize || *n == 0 => {
                Err("break or continue outside a loop".into())
            }
            Op::Break(_) | Op::Continue(_) => Ok(()),
            Op::Inline(body) => {
                self.inlines += 1;
                // Loops around a call cannot be left from within it.
                let loops = std::mem::take(&mut self.loops);
                let done = self.block(body);
                self.loops = loops;
                self.inlines -= 1;
                done
            }
            Op::Return if self.inlines == 0 => Err("return outside a function".into()),
            Op::Return => Ok(()),
            Op::Illuminance { .. } if in_light => Err("illuminance in a light shader".into()),
            Op::Solar { .. } | Op::Illuminate { .. } if !in_light => {
                Err("solar or illuminate outside a light shader".into())
            }
            Op::Illuminance { args, body, category, wanted, .. } => {
                self.width(args[0], 3)?;
                self.width(args[1], 3)?;
                self.width(args[2], 1)?;
                category.iter().try_for_each(|r| self.read_text(*r))?;
                wanted.iter().try_for_each(|(_, r)| self.read(*r))?;
                self.maybe(body)
            }
            Op::Gather { args, out, hit, miss } => {
                for (reg, width) in args.iter().zip([3, 3, 1, 1]) {
                    self.width(*reg, width)?;
                }
                out.iter().try_for_each(|(_, r)| self.read(*r))?;
                self.maybe(hit)?;
                self.maybe(miss)
            }
            Op::Solar { args, body, .. } => {
                self.width(args[0], 3)?;
                self.width(args[1], 1)?;
                self.maybe(body)
            }
            Op::Illuminate { args, body, .. } => {
                self.width(args[0], 3)?;
                self.width(args[1], 3)?;
                self.width(args[2], 1)?;
                self.maybe(body)
            }
        }
    }
}
