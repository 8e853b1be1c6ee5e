//! A compiled shader.

use super::globals::Global;
use super::op::Op;
use super::register::{Operand, Reg};
use super::types::{Kind, ShaderKind};

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
    /// Its register; an array's elements follow each other.
    pub reg: Operand,
    /// Computes the default.
    pub default: Vec<Op>,
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
    pub globals: Vec<(Global, Reg)>,
    /// What it does.
    pub body: Vec<Op>,
    /// A light without `solar` and `illuminate`.
    pub is_ambient: bool,
    /// It leaves Oi as Os, so that what is opaque stays opaque.
    pub keeps_opacity: bool,
    /// What it does at a point depends on the points beside it in the grid: by derivatives, or maps, whose filters go by them.
    pub reads_neighbours: bool,
}

impl Program {
    /// The register of a global, if the program uses it.
    pub fn global(&self, global: Global) -> Option<Reg> {
        self.globals.iter().find(|(g, _)| *g == global).map(|(_, r)| *r)
    }
}
