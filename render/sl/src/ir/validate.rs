//! The invariants of programs, which hold before any back end sees them.

use super::op::{Builtin, Op, Transform};
use super::program::Program;
use super::register::{Operand, Reg, TextReg};
use super::types::{Kind, ShaderKind};

/// Check the invariants of [`crate::ir`]. The error describes the first violation.
pub fn validate(program: &Program) -> Result<(), String> {
    let written = vec![false; program.widths.len()];
    let text_written = vec![false; program.n_texts];
    let mut check = Check { program, written, text_written, loops: 0, inlines: 0 };
    for (global, reg) in &program.globals {
        if reg.width() != global.kind().width() {
            return Err(format!("global {} has a register of another kind", global.name()));
        }
        check.write(*reg).map_err(|e| format!("global {}: {e}", global.name()))?;
    }
    for param in &program.params {
        check.block(&param.default)?;
        let sound = match param.reg {
            Operand::Number(r) => param.kind != Kind::Text && r.width() == param.kind.width(),
            Operand::Text(_) => param.kind == Kind::Text,
        };
        if !sound {
            return Err(format!("parameter {} has a register of another kind", param.name));
        }
        param.reg.array(param.array.unwrap_or(1)).try_for_each(|o| check.operand(o))?;
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
    /// A register exists, and its handle has its width.
    fn exists(&self, r: Reg) -> Result<(), String> {
        match self.program.widths.get(r.index()) {
            Some(width) if *width as usize == r.width() => Ok(()),
            Some(width) => Err(format!("register {} has width {width}, expected {}", r.index(), r.width())),
            None => Err(format!("register {} does not exist", r.index())),
        }
    }

    fn read(&self, r: impl Into<Reg>) -> Result<(), String> {
        let r = r.into();
        self.exists(r)?;
        match self.written[r.index()] {
            true => Ok(()),
            false => Err(format!("register {} is read before it is written", r.index())),
        }
    }

    fn read_text(&self, r: TextReg) -> Result<(), String> {
        match self.text_written.get(r.index()) {
            Some(true) => Ok(()),
            _ => Err(format!("string register {} is read before it is written", r.index())),
        }
    }

    fn write(&mut self, r: impl Into<Reg>) -> Result<(), String> {
        let r = r.into();
        self.exists(r)?;
        self.written[r.index()] = true;
        Ok(())
    }

    fn write_text(&mut self, r: TextReg) -> Result<(), String> {
        let found = self.text_written.get_mut(r.index());
        *found.ok_or_else(|| format!("string register {} does not exist", r.index()))? = true;
        Ok(())
    }

    /// Operands of a number-by-number operation: as wide as the result, or of width 1.
    fn spread(&mut self, dst: Reg, operands: &[Reg]) -> Result<(), String> {
        for r in operands {
            self.read(*r)?;
            if r.width() != 1 && r.width() != dst.width() {
                return Err(format!(
                    "register {} has width {}, result {} has {}",
                    r.index(),
                    r.width(),
                    dst.index(),
                    dst.width()
                ));
            }
        }
        self.write(dst)
    }

    /// Elements of an array, and a value of their width.
    fn elements(&self, first: Reg, len: u16, value: Reg) -> Result<(), String> {
        if first.width() != value.width() {
            return Err(format!("register {} is no element of the array at {}", value.index(), first.index()));
        }
        first.array(len).try_for_each(|r| self.read(r))
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
        for (r, arg) in args.iter().zip(row.takes) {
            self.read(*r)?;
            if !arg.takes_width(r.width()) {
                return Err(format!("{} does not take register {} of width {}", row.ir, r.index(), r.width()));
            }
        }
        if !row.gives.has_width(dst.width(), args.first().map_or(1, |r| r.width())) {
            return Err(format!("{} does not give register {} of width {}", row.ir, dst.index(), dst.width()));
        }
        self.write(dst)
    }

    /// Check an operation. Long, because it has an arm for each.
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
            Op::Select(dst, c, a, b) => self.spread(*dst, &[(*c).into(), *a, *b]),
            Op::Pack(dst, parts) => {
                parts.iter().try_for_each(|r| self.read(*r))?;
                if parts.len() != dst.width() {
                    return Err(format!("{} numbers for register {} of {}", parts.len(), dst.index(), dst.width()));
                }
                self.write(*dst)
            }
            Op::Component(dst, a, _) => {
                self.read(*a)?;
                self.write(*dst)
            }
            Op::Within(index, ..) => self.read(*index),
            Op::Load(dst, first, len, index, _) => {
                self.read(*index)?;
                self.elements(*first, *len, *dst)?;
                self.write(*dst)
            }
            Op::Store(first, len, index, value, _) => {
                self.read(*index)?;
                self.read(*value)?;
                self.elements(*first, *len, *value)
            }
            Op::TextLoad(dst, first, len, index, _) => {
                self.read(*index)?;
                first.array(*len).try_for_each(|r| self.read_text(r))?;
                self.write_text(*dst)
            }
            Op::TextStore(first, len, index, value, _) => {
                self.read(*index)?;
                self.read_text(*value)?;
                first.array(*len).try_for_each(|r| self.read_text(r))
            }
            Op::Call(f, dst, args) => self.call(*f, *dst, args),
            Op::Spline(dst, basis, args) => {
                self.read_text(*basis)?;
                args.iter().try_for_each(|r| self.read(*r))?;
                self.write(*dst)
            }
            Op::Format(dst, args, _) => {
                args.iter().try_for_each(|o| self.operand(*o))?;
                self.write_text(*dst)
            }
            Op::Print(args) => args.iter().try_for_each(|o| self.operand(*o)),
            Op::Ask { dst, names, out, len, .. } => {
                names.iter().try_for_each(|r| self.read_text(*r))?;
                out.array(*len).try_for_each(|o| self.operand(o))?;
                self.write(*dst)
            }
            Op::Map { dst, name, channel, at, options, .. } => {
                self.read_text(*name)?;
                self.read(*channel)?;
                at.iter().try_for_each(|r| self.read(*r))?;
                for (name, value) in options {
                    self.read_text(*name)?;
                    self.operand(*value)?;
                }
                self.write(*dst)
            }
            Op::Transform(how, dst, a, from, to, _) => {
                let width = if *how == Transform::Matrix { 16 } else { 3 };
                if a.width() != width || dst.width() != width {
                    return Err(format!("registers {} and {} change no space", dst.index(), a.index()));
                }
                self.read(*a)?;
                self.read_text(*from)?;
                self.read_text(*to)?;
                self.write(*dst)
            }
            Op::ColorSpace(dst, a, from, to, _) => {
                self.read(*a)?;
                self.read_text(*from)?;
                self.read_text(*to)?;
                self.write(*dst)
            }
            Op::If(c, then, otherwise) => {
                self.read(*c)?;
                self.maybe(then)?;
                self.maybe(otherwise)
            }
            Op::Loop(head, c, body, step, _) => {
                self.block(head)?;
                self.read(*c)?;
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
            Op::Illuminance { position, axis, angle, l, cl, body, category, wanted } => {
                [*position, *axis].into_iter().try_for_each(|r| self.read(r))?;
                self.read(*angle)?;
                [*l, *cl].into_iter().try_for_each(|r| self.exists(r.into()))?;
                category.iter().try_for_each(|r| self.read_text(*r))?;
                wanted.iter().try_for_each(|(_, r)| self.read(*r))?;
                self.maybe(body)
            }
            Op::Gather { position, axis, angle, samples, out, hit, miss } => {
                [*position, *axis].into_iter().try_for_each(|r| self.read(r))?;
                [*angle, *samples].into_iter().try_for_each(|r| self.read(r))?;
                out.iter().try_for_each(|(_, r)| self.read(*r))?;
                self.maybe(hit)?;
                self.maybe(miss)
            }
            Op::Solar { axis, angle, l, body } => {
                self.read(*axis)?;
                self.read(*angle)?;
                self.exists((*l).into())?;
                self.maybe(body)
            }
            Op::Illuminate { position, axis, angle, l, ps, body } => {
                [*position, *axis].into_iter().try_for_each(|r| self.read(r))?;
                self.read(*angle)?;
                [*l, *ps].into_iter().try_for_each(|r| self.exists(r.into()))?;
                self.maybe(body)
            }
        }
    }
}
