//! The function of a shader as it is written: lines, names, open loops, blocks of operations.

use super::super::bound::BoundShader;
use super::module::{Module, Refused, Slot};
use super::registers::{Registers, constants};
use super::texts::Texts;
use crate::ir::{Global, Op, Program, Reg, TripleReg, visit};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::fmt::Display;

/// What `break`, `continue` and `return` leave, and loops over lights, which they pass through.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Leaves {
    Loop,
    Function,
    Lights,
}

/// An open loop.
pub(super) struct Frame {
    pub id: usize,
    pub leaves: Leaves,
    /// Whether all points of a grid run it together.
    pub grid: bool,
    /// Loops further out that are left from within, by their ids.
    pub exits: BTreeSet<usize>,
}

/// A value that a loop over lights has of the current light: whether it has the parameter, and the value, as variables.
pub(super) type OfLight = HashMap<(String, usize), (String, String)>;

/// The function of a shader while it is written.
pub(super) struct Writer<'w, 'a> {
    pub module: &'w mut Module<'a>,
    pub program: &'w Program,
    pub shader: &'w BoundShader,
    /// Index of the shader in the kernel.
    pub index: usize,
    pub registers: Registers,
    pub constants: HashMap<usize, f32>,
    pub texts: Texts,
    /// Whether the points of a grid run what is written now together, under a mask.
    pub grid: bool,
    pub frames: Vec<Frame>,
    /// Conditions and loops around what is written that leave points inactive.
    pub masks: usize,
    /// Of the current light of `illuminance`.
    pub of_light: Option<OfLight>,
    /// In `solar` or `illuminate`: the register of the light's ray, and whether it is a sun's.
    pub ray: Option<(TripleReg, bool)>,
    /// What is read of the host besides globals and parameters, and the byte of the source where it is first.
    pub slots: Vec<(Slot, u32)>,
    /// Byte of the source of the operation that is written, if it asks the host for something.
    pub byte: u32,
    /// Registers that have been assigned to.
    pub written: HashSet<usize>,
    pub text: String,
    depth: usize,
    n_names: usize,
    /// Whether turns of loops are counted for random numbers.
    pub counts_turns: bool,
    /// Variables of the function besides registers.
    pub variables: String,
}

pub(super) type Done = Result<(), Refused>;

impl<'w, 'a> Writer<'w, 'a> {
    pub fn new(module: &'w mut Module<'a>, program: &'w Program, shader: &'w BoundShader, index: usize) -> Self {
        let known = constants(program);
        let texts = Texts::of(shader, &known, module.host.scene);
        Writer {
            program,
            shader,
            index,
            registers: Registers::of(program),
            constants: known,
            texts,
            grid: false,
            frames: vec![],
            masks: 0,
            of_light: None,
            ray: None,
            slots: vec![],
            byte: 0,
            written: HashSet::new(),
            text: String::new(),
            depth: 1,
            n_names: 0,
            counts_turns: counts_turns(program),
            variables: String::new(),
            module,
        }
    }

    /// Why the shader has no kernel.
    pub fn refuse<T>(&self, reason: impl Display) -> Result<T, Refused> {
        Err(Refused { shader: self.program.name.clone(), reason: reason.to_string() })
    }

    pub fn line(&mut self, line: impl Display) {
        self.text += &format!("{:1$}{line}\n", "", 4 * self.depth);
    }

    /// A line that begins a block.
    pub fn open(&mut self, line: impl Display) {
        self.line(format!("{line} {{").trim_start());
        self.depth += 1;
    }

    /// The end of a block.
    pub fn close(&mut self) {
        self.depth -= 1;
        self.line("}");
    }

    /// The end of a block and the beginning of another, such as `else`.
    pub fn between(&mut self, line: &str) {
        self.depth -= 1;
        self.line(format!("}} {line} {{"));
        self.depth += 1;
    }

    /// A number for new names.
    pub fn fresh(&mut self) -> usize {
        self.n_names += 1;
        self.n_names
    }

    /// A new variable of the function.
    pub fn variable(&mut self, name: &str, ty: &str) {
        self.variables += &format!("    var {name}: {ty};\n");
    }

    /// The slot of something that is read of the host, as an expression.
    pub fn slot(&mut self, slot: Slot) -> String {
        let k = self.slots.iter().position(|(known, _)| *known == slot).unwrap_or_else(|| {
            self.slots.push((slot, self.byte));
            self.slots.len() - 1
        });
        format!("base + {}u", Global::COUNT + self.program.params.len() + k)
    }

    /// Warn of what the operation that is written asks in vain.
    pub fn warn(&self, message: String) {
        self.module.host.scene.warn(self.program.placed(self.byte, &message));
    }

    /// Assign to a variable at active points. What nobody has assigned to has no value to keep at the others.
    pub fn assign(&mut self, dst: Reg, value: &str) {
        let name = self.registers.name(dst);
        let is_first = self.written.insert(dst.index());
        if !self.grid {
            self.line(format!("{name} = {value};"));
        } else if is_first && self.masks > 0 {
            let flag = format!("is_set_{}", dst.index());
            self.variable(&flag, "bool");
            self.line(format!("if on || !{flag} {{ {name} = {value}; }}"));
            self.line(format!("{flag} = true;"));
        } else {
            self.line(format!("if on {{ {name} = {value}; }}"));
        }
    }

    /// Write a block; true if its end is not reached.
    pub fn block(&mut self, ops: &[Op]) -> Result<bool, Refused> {
        for op in ops {
            self.op(op)?;
            self.texts.step(op, &self.constants, self.module.host.scene);
            if !self.grid && matches!(op, Op::Break(_) | Op::Continue(_) | Op::Return) {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// Whether a program's random numbers depend on the turns of its loops.
fn counts_turns(program: &Program) -> bool {
    let mut found = false;
    visit(&program.body, &mut |op| found |= matches!(op, Op::Call(f, ..) if f.row().ir == "random"));
    found
}
