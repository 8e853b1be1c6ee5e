//! The registers of a program as variables of a WGSL function: their names, which of them are arrays, which are constants.

use crate::ir::walk::{result, writes_besides};
use crate::ir::{Op, Operand, Program, Reg, visit};
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};

/// The registers of a program.
pub(super) struct Registers {
    /// Of a register in an array: the array's first register and its length.
    arrays: HashMap<usize, (usize, usize)>,
    /// Constants, which need no variable.
    constants: HashMap<usize, f32>,
    /// The names that were asked for, with their types.
    used: RefCell<BTreeMap<String, String>>,
}

/// The WGSL type of a width.
pub(super) fn type_of(width: usize) -> &'static str {
    match width {
        1 => "f32",
        3 => "vec3<f32>",
        _ => "mat4x4<f32>",
    }
}

/// A number as WGSL has it; what is not finite becomes the largest number of its sign.
pub(super) fn literal(x: f32) -> String {
    let x = if x.is_nan() { 0.0 } else { x.clamp(f32::MIN, f32::MAX) };
    if x.is_sign_negative() { format!("({x:?}f)") } else { format!("{x:?}f") }
}

impl Registers {
    pub fn of(program: &Program) -> Registers {
        let arrays = arrays(program);
        let constants = constants(program).into_iter().filter(|(r, _)| !arrays.contains_key(r)).collect();
        Registers { arrays, constants, used: RefCell::default() }
    }

    /// The number that a register holds wherever it is read.
    pub fn constant(&self, r: impl Into<Reg>) -> Option<f32> {
        self.constants.get(&r.into().index()).copied()
    }

    /// The variable of a register.
    pub fn name(&self, r: impl Into<Reg>) -> String {
        let r = r.into();
        let (name, ty) = match self.arrays.get(&r.index()) {
            Some((first, len)) => (format!("a{first}"), format!("array<{}, {len}>", type_of(r.width()))),
            None => (format!("r{}", r.index()), type_of(r.width()).into()),
        };
        let full = match self.arrays.get(&r.index()) {
            Some((first, _)) => format!("{name}[{}]", r.index() - first),
            None => name.clone(),
        };
        self.used.borrow_mut().insert(name, ty);
        full
    }

    /// The array that a register is in, and the register's index in it.
    pub fn array(&self, r: Reg) -> (String, usize) {
        self.name(r);
        self.arrays.get(&r.index()).map_or((self.name(r), 0), |(first, _)| (format!("a{first}"), r.index() - first))
    }

    /// The value of a register.
    pub fn value(&self, r: impl Into<Reg>) -> String {
        let r = r.into();
        match self.constant(r) {
            Some(x) => spread(&literal(x), 1, r.width()),
            None => self.name(r),
        }
    }

    /// A register's value, an operand of width 1 repeated, as wide as a result.
    pub fn spread(&self, r: Reg, width: usize) -> String {
        match self.constant(r) {
            Some(x) => spread(&literal(x), 1, width),
            None => spread(&self.name(r), r.width(), width),
        }
    }

    /// Whether either operand is a triple that is not a repeated constant.
    pub fn is_triple(&self, a: Reg, b: Reg) -> bool {
        [a, b].into_iter().any(|r| r.width() == 3 && self.constant(r).is_none())
    }

    /// A register's value, by one number if it is a repeated constant.
    pub fn shortest(&self, r: Reg) -> String {
        self.constant(r).map_or_else(|| self.name(r), literal)
    }

    /// A component of a register's value; that of a number is the number.
    pub fn component(&self, r: Reg, c: usize) -> String {
        match (self.constant(r), r.width()) {
            (Some(x), _) => literal(x),
            (None, 1) => self.name(r),
            (None, 3) => format!("{}.{}", self.name(r), ["x", "y", "z"][c]),
            (None, _) => format!("{}[{}][{}]", self.name(r), c / 4, c % 4),
        }
    }

    /// Declarations of all variables that were named.
    pub fn declarations(&self) -> String {
        self.used.borrow().iter().map(|(name, ty)| format!("    var {name}: {ty};\n")).collect()
    }
}

/// A value of one width as one of another.
fn spread(text: &str, from: usize, to: usize) -> String {
    match (from, to) {
        (1, 3) => format!("vec3<f32>({text})"),
        (1, 16) => format!("sl_filled({text})"),
        _ => text.into(),
    }
}

/// Visit all operations of a program.
fn every(program: &Program, f: &mut dyn FnMut(&Op)) {
    program.params.iter().map(|p| &p.default).chain([&program.body]).for_each(|ops| visit(ops, f));
}

/// The arrays of a program: ranges of registers, those that overlap as one.
fn arrays(program: &Program) -> HashMap<usize, (usize, usize)> {
    let mut ranges: Vec<(usize, usize)> = vec![];
    let mut add = |first: Reg, len: u16| ranges.push((first.index(), first.index() + len as usize));
    for param in &program.params {
        if let (Operand::Number(first), Some(len)) = (param.reg, param.array) {
            add(first, len);
        }
    }
    every(program, &mut |op| match op {
        Op::Load(_, first, len, ..) | Op::Store(first, len, ..) => add(*first, *len),
        Op::Ask { out: Operand::Number(first), len, .. } if *len > 1 => add(*first, *len),
        _ => {}
    });
    ranges.sort_unstable();
    let mut merged: Vec<(usize, usize)> = vec![];
    for (first, end) in ranges {
        match merged.last_mut() {
            Some((_, last)) if first < *last => *last = end.max(*last),
            _ => merged.push((first, end)),
        }
    }
    merged.into_iter().flat_map(|(first, end)| (first..end).map(move |k| (k, (first, end - first)))).collect()
}

/// Registers that one operation alone writes, which is a constant.
pub(super) fn constants(program: &Program) -> HashMap<usize, f32> {
    let mut found = HashMap::new();
    let mut writes: HashMap<usize, usize> = HashMap::new();
    let mut write = |r: Reg, times: usize| *writes.entry(r.index()).or_default() += times;
    program.globals.iter().for_each(|(_, r)| write(*r, 2));
    for param in &program.params {
        param.reg.array(param.array.unwrap_or(1)).for_each(|o| {
            if let Operand::Number(r) = o {
                write(r, 2);
            }
        });
    }
    every(program, &mut |op| {
        if let Some(r) = result(op) {
            write(r, 1);
        }
        writes_besides(op, &mut |r| write(r, 2));
        if let Op::Const(r, x) = op {
            found.insert(r.index(), *x);
        }
    });
    found.retain(|r, _| writes[r] == 1);
    found
}
