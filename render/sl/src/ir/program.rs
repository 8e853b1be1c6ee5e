//! A compiled shader.

use super::globals::Global;
use super::op::Op;
use super::register::{Operand, Reg};
use super::types::{Kind, ShaderKind};
use super::walk::visit;

/// A shader parameter.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Name of the parameter.
    pub name: String,
    /// Type of the parameter.
    pub kind: Kind,
    /// Whether the parameter is declared `varying`.
    pub varying: bool,
    /// Whether the parameter is declared `output`.
    pub output: bool,
    /// Count of elements of an array; none for a single value.
    pub array: Option<u16>,
    /// Register of the parameter; the elements of an array are in consecutive registers from this one.
    pub reg: Operand,
    /// Operations that compute the default value.
    pub default: Vec<Op>,
}

/// A compiled shader; [`validate`](super::validate()) has the invariants.
#[derive(Clone, Debug)]
pub struct Program {
    /// Type of the shader.
    pub kind: ShaderKind,
    /// Name of the shader.
    pub name: String,
    /// The file that it is from.
    pub file: String,
    /// Width (1, 3 or 16) of each register of numbers.
    pub widths: Vec<u8>,
    /// Count of string registers.
    pub n_texts: usize,
    /// Parameters, in the order of their declaration.
    pub params: Vec<Parameter>,
    /// Global variables that the shader reads or writes, with their registers.
    pub globals: Vec<(Global, Reg)>,
    /// Operations of the shader's body.
    pub body: Vec<Op>,
    /// The registers that may be written more than once, or in part; all others are written whole before they are read.
    pub variables: Vec<u16>,
    /// Whether it is an ambient light: a light shader without `solar` and `illuminate`.
    pub is_ambient: bool,
    /// Whether the shader keeps Oi equal to Os, so that an opaque surface stays opaque.
    pub keeps_opacity: bool,
    /// Whether the shader sets Oi to 1 whatever Os is, so that no surface lets anything through.
    pub is_opaque: bool,
    /// Whether values at a point depend on neighbouring points of the grid: through derivatives, or through maps, whose filters use
    /// them.
    pub reads_neighbours: bool,
    /// Where loops and elements of arrays stand: the byte of the source, as their operations have it, with file and line.
    pub places: Vec<(u32, String)>,
    /// What the shader asks for that is not done: ends of the sentence “shader `x` …”.
    pub unsupported: Vec<String>,
    /// Whether the shader asks what a displacement shader has left.
    pub asks_displacement: bool,
    /// Whether the shader sends rays.
    pub traces: bool,
}

impl Program {
    /// The strings that stand in the shader.
    pub fn texts(&self) -> Vec<String> {
        let mut found = vec![];
        let mut take = |op: &Op| {
            if let Op::TextConst(_, text) = op {
                found.push(text.clone());
            }
        };
        self.params.iter().map(|param| &param.default).chain([&self.body]).for_each(|ops| visit(ops, &mut take));
        found
    }

    /// The file and line of an operation that has its place.
    pub fn place(&self, at: u32) -> &str {
        let found = self.places.binary_search_by_key(&at, |(at, _)| *at);
        found.map_or(&self.file, |k| &self.places[k].1)
    }

    /// What is said of what stands at a byte of its source, after the place.
    pub fn placed(&self, at: u32, message: &str) -> String {
        format!("{}: the shader `{}`: {message}", self.place(at), self.name)
    }

    /// The register of a global variable, if the program uses it.
    pub fn global(&self, global: Global) -> Option<Reg> {
        self.globals.iter().find(|(g, _)| *g == global).map(|(_, r)| *r)
    }
}
