//! The invariants of programs, which hold before any back end sees them.

use super::op::{Builtin, Op, Operand, Reg, TextReg, Transform};
use super::program::Program;
use super::types::{Kind, ShaderKind};

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

    /// A call agrees with its function's row.
    fn call(&mut self, f: Builtin, dst: Reg, args: &[Reg]) -> Result<(), String> {
        let row = f.row();
        if args.len() != row.takes.len() {
            return Err(format!("{} takes {} arguments, found {}", row.ir, row.takes.len(), args.len()));
        }
        let width = |r: Reg| self.program.widths[r as usize] as usize;
        for (r, arg) in args.iter().zip(row.takes) {
            self.read(*r)?;
            if !arg.takes_width(width(*r)) {
                return Err(format!("{} does not take register {r} of width {}", row.ir, width(*r)));
            }
        }
        self.write(dst)?;
        if !row.gives.has_width(width(dst), args.first().map_or(1, |r| width(*r))) {
            return Err(format!("{} does not give register {dst} of width {}", row.ir, width(dst)));
        }
        Ok(())
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
            Op::Call(f, dst, args) => self.call(*f, *dst, args),
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
