//! The syntax tree. `at` is the byte of the source where a node starts.

use crate::ir::{Kind, ShaderKind};

/// A type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ty {
    Void,
    Float,
    Color,
    Point,
    Vector,
    Normal,
    Matrix,
    Text,
}

impl From<Kind> for Ty {
    fn from(kind: Kind) -> Ty {
        match kind {
            Kind::Float => Ty::Float,
            Kind::Color => Ty::Color,
            Kind::Point => Ty::Point,
            Kind::Vector => Ty::Vector,
            Kind::Normal => Ty::Normal,
            Kind::Matrix => Ty::Matrix,
            Kind::Text => Ty::Text,
        }
    }
}

impl Ty {
    pub fn name(self) -> &'static str {
        match self {
            Ty::Void => "void",
            Ty::Float => "float",
            Ty::Color => "color",
            Ty::Point => "point",
            Ty::Vector => "vector",
            Ty::Normal => "normal",
            Ty::Matrix => "matrix",
            Ty::Text => "string",
        }
    }

    pub fn of_name(name: &str) -> Option<Ty> {
        [Ty::Void, Ty::Float, Ty::Color, Ty::Point, Ty::Vector, Ty::Normal, Ty::Matrix, Ty::Text]
            .into_iter()
            .find(|t| t.name() == name)
    }

    pub fn is_triple(self) -> bool {
        matches!(self, Ty::Color | Ty::Point | Ty::Vector | Ty::Normal)
    }
}

/// An expression.
#[derive(Clone, Debug)]
pub struct Expr {
    pub at: usize,
    pub kind: ExprKind,
}

#[derive(Clone, Debug)]
pub enum ExprKind {
    Number(f32),
    Text(String),
    Name(String),
    Unary(&'static str, Box<Expr>),
    Binary(&'static str, Box<Expr>, Box<Expr>),
    Choose(Box<Expr>, Box<Expr>, Box<Expr>),
    Call(String, Vec<Expr>),
    /// `type ["space"] expression`
    Cast(Ty, Option<String>, Box<Expr>),
    Triple(Box<[Expr; 3]>),
    /// Sixteen numbers, row after row.
    Matrix(Vec<Expr>),
    /// `array[index]`
    Index(Box<Expr>, Box<Expr>),
    /// `{a, b, …}`, what an array starts with.
    Array(Vec<Expr>),
    /// Target (a name or an element), operator (`=`, `+=` …), value; what is assigned is its value.
    Assign(Box<Expr>, &'static str, Box<Expr>),
}

/// A statement.
#[derive(Clone, Debug)]
pub struct Stmt {
    pub at: usize,
    pub kind: StmtKind,
}

#[derive(Clone, Debug)]
pub enum StmtKind {
    Declare(Vec<Variable>),
    /// Target (a name or an element), operator (`=`, `+=` …), value.
    Assign(Expr, &'static str, Expr),
    Call(Expr),
    Block(Vec<Stmt>),
    If(Expr, Box<Stmt>, Option<Box<Stmt>>),
    While(Expr, Box<Stmt>),
    For(Box<Stmt>, Expr, Box<Stmt>, Box<Stmt>),
    /// Out of this number of loops.
    Break(usize),
    Continue(usize),
    Return(Option<Expr>),
    /// `illuminance`, `illuminate` or `solar`, its arguments and its body.
    Light(&'static str, Vec<Expr>, Box<Stmt>),
    /// `gather`, its arguments, what is done for a hit and for a miss.
    Gather(Vec<Expr>, Box<Stmt>, Option<Box<Stmt>>),
    /// `extern type name, …`
    Extern(Vec<(String, usize)>),
}

/// A variable or a parameter.
#[derive(Clone, Debug)]
pub struct Variable {
    pub at: usize,
    pub name: String,
    pub ty: Ty,
    /// Elements of an array.
    pub array: Option<usize>,
    pub varying: bool,
    pub output: bool,
    pub value: Option<Expr>,
}

/// A user function.
#[derive(Clone, Debug)]
pub struct Function {
    pub name: String,
    pub ret: Ty,
    pub params: Vec<Variable>,
    pub body: Vec<Stmt>,
}

/// A shader.
#[derive(Clone, Debug)]
pub struct Shader {
    pub kind: ShaderKind,
    pub name: String,
    pub params: Vec<Variable>,
    pub body: Vec<Stmt>,
}

/// A source file.
#[derive(Clone, Debug, Default)]
pub struct File {
    pub functions: Vec<Function>,
    pub shader: Option<Shader>,
    pub end: usize,
}
