//! The intermediate representation: registers and structured operations.
//!
//! Invariants, which [`validate`] holds:
//! 1. Every register that an operation names exists, and numbers and strings are not confused.
//! 2. Operands have the widths that the operation asks for: 1 (float) or 3 (triple).
//! 3. Every register is written before it is read, on every path; globals and parameters count as written.
//! 4. `Break` and `Continue` stand inside a `Loop`, `Solar` and `Illuminate` only in light shaders, `Illuminance` only outside.
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
    /// Text.
    Text,
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
    /// Its register: of numbers, or of strings for [`Kind::Text`].
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
    /// Noise in [0, 1] of 1, 2 or 3 numbers; the result's width says which.
    Noise,
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
}

/// An operation.
#[derive(Clone, Debug)]
pub enum Op {
    /// A constant; one number or three.
    Const(Reg, [f32; 3]),
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
    /// Three numbers to a triple.
    Pack(Reg, [Reg; 3]),
    /// A component of a triple.
    Component(Reg, Reg, u8),
    /// Assign to a variable, where the points are active.
    Assign(Reg, Reg),
    /// A built-in function.
    Call(Builtin, Reg, Vec<Reg>),
    /// Change space: result, operand, from, to (string registers).
    Transform(Transform, Reg, Reg, TextReg, TextReg),
    /// `if`
    If(Reg, Vec<Op>, Vec<Op>),
    /// Repeat: condition's operations, condition, body, step.
    Loop(Vec<Op>, Reg, Vec<Op>, Vec<Op>),
    /// Leave the loop.
    Break,
    /// Go to the loop's step.
    Continue,
    /// For every light that reaches position within an angle about an axis: L and Cl are set.
    Illuminance {
        /// Position (3), axis (3) and angle (1).
        args: [Reg; 3],
        /// Register of L.
        l: Reg,
        /// Register of Cl.
        cl: Reg,
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
    /// Width (1 or 3) of each number register.
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
    let mut check = Check { program, written, text_written, loops: 0 };
    for param in &program.params {
        check.block(&param.default)?;
        match param.kind {
            Kind::Text => check.read_text(param.reg)?,
            _ => check.read(param.reg)?,
        }
    }
    check.block(&program.body)
}

struct Check<'a> {
    program: &'a Program,
    written: Vec<bool>,
    text_written: Vec<bool>,
    loops: usize,
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

    fn op(&mut self, op: &Op) -> Result<(), String> {
        let in_light = self.program.kind == ShaderKind::Light;
        match op {
            Op::Const(dst, _) => self.write(*dst),
            Op::TextConst(dst, _) => self.write_text(*dst),
            Op::TextCopy(dst, a) => {
                self.read_text(*a)?;
                self.write_text(*dst)
            }
            Op::TextEqual(dst, a, b) => {
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
                self.write(*dst)
            }
            Op::Component(dst, a, _) => {
                self.width(*a, 3)?;
                self.write(*dst)
            }
            Op::Call(_, dst, args) => {
                args.iter().try_for_each(|r| self.read(*r))?;
                self.write(*dst)
            }
            Op::Transform(_, dst, a, from, to) => {
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
            Op::Break | Op::Continue if self.loops == 0 => Err("break or continue outside a loop".into()),
            Op::Break | Op::Continue => Ok(()),
            Op::Illuminance { .. } if in_light => Err("illuminance in a light shader".into()),
            Op::Solar { .. } | Op::Illuminate { .. } if !in_light => {
                Err("solar or illuminate outside a light shader".into())
            }
            Op::Illuminance { args, body, .. } => {
                self.width(args[0], 3)?;
                self.width(args[1], 3)?;
                self.width(args[2], 1)?;
                self.maybe(body)
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
