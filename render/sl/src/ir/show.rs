//! A program as text: what `scree shader --ir` prints, and what snapshots are made of.

use super::op::{Op, Operand, Reg};
use super::program::Program;
use super::types::Kind;
use std::fmt::{Display, Formatter, Result, Write};

impl Display for Program {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "{} {}", self.kind.name(), self.name)?;
        for (name, reg) in &self.globals {
            writeln!(f, "global {name} r{reg}")?;
        }
        for p in &self.params {
            let class = if p.varying { "varying" } else { "uniform" };
            let array = p.array.map_or(String::new(), |n| format!("[{n}]"));
            let output = if p.output { "output " } else { "" };
            let letter = if p.kind == Kind::Text { 't' } else { 'r' };
            writeln!(f, "parameter {output}{class} {} {}{array} {letter}{}", p.kind.name(), p.name, p.reg)?;
            block(f, &p.default, 1)?;
        }
        block(f, &self.body, 0)
    }
}

fn block(f: &mut Formatter<'_>, ops: &[Op], depth: usize) -> Result {
    for op in ops {
        write!(f, "{:1$}", "", 2 * depth)?;
        one(f, op, depth)?;
    }
    Ok(())
}

/// A block under a heading, left out if it is empty.
fn under(f: &mut Formatter<'_>, heading: &str, ops: &[Op], depth: usize) -> Result {
    if ops.is_empty() {
        return Ok(());
    }
    writeln!(f, "{:1$}{heading}", "", 2 * depth)?;
    block(f, ops, depth + 1)
}

fn regs(list: &[Reg]) -> String {
    list.iter().map(|r| format!(" r{r}")).collect()
}

fn operand(o: &Operand) -> String {
    match o {
        Operand::Number(r) => format!("r{r}"),
        Operand::Text(r) => format!("t{r}"),
    }
}

fn operands(list: &[Operand]) -> String {
    list.iter().map(|o| format!(" {}", operand(o))).collect()
}

/// An enumerator's name in lower case.
fn name(x: impl std::fmt::Debug) -> String {
    format!("{x:?}").to_lowercase()
}

fn one(f: &mut Formatter<'_>, op: &Op, depth: usize) -> Result {
    match op {
        Op::Const(r, x) => writeln!(f, "r{r} = {x}"),
        Op::TextConst(t, text) => writeln!(f, "t{t} = {text:?}"),
        Op::TextCopy(t, a) => writeln!(f, "t{t} := t{a}"),
        Op::TextEqual(r, a, b) => writeln!(f, "r{r} = t{a} == t{b}"),
        Op::Unary(u, r, a) => writeln!(f, "r{r} = {} r{a}", name(u)),
        Op::Binary(u, r, a, b) => writeln!(f, "r{r} = {} r{a} r{b}", name(u)),
        Op::Select(r, c, a, b) => writeln!(f, "r{r} = r{c} ? r{a} : r{b}"),
        Op::Pack(r, parts) => writeln!(f, "r{r} = pack{}", regs(parts)),
        Op::Component(r, a, c) => writeln!(f, "r{r} = r{a}[{c}]"),
        Op::Assign(r, a) => writeln!(f, "r{r} := r{a}"),
        Op::Load(r, first, n, i) => writeln!(f, "r{r} = r{first}..{}[r{i}]", first + n),
        Op::Store(first, n, i, v) => writeln!(f, "r{first}..{}[r{i}] := r{v}", first + n),
        Op::TextLoad(t, first, n, i) => writeln!(f, "t{t} = t{first}..{}[r{i}]", first + n),
        Op::TextStore(first, n, i, v) => writeln!(f, "t{first}..{}[r{i}] := t{v}", first + n),
        Op::ColorSpace(r, a, from, to) => writeln!(f, "r{r} = colour r{a} t{from} t{to}"),
        Op::Spline(r, basis, list) => writeln!(f, "r{r} = spline t{basis}{}", regs(list)),
        Op::Match(r, a, b) => writeln!(f, "r{r} = match t{a} t{b}"),
        Op::Format(t, list) => writeln!(f, "t{t} = format{}", operands(list)),
        Op::Print(list) => writeln!(f, "print{}", operands(list)),
        Op::Ask { dst, what, names, out, len } => {
            let names: String = names.iter().map(|t| format!(" t{t}")).collect();
            let len = if *len > 1 { format!("[{len}]") } else { String::new() };
            writeln!(f, "r{dst} = ask {}{names} -> {}{len}", name(what), operand(out))
        }
        Op::Map { dst, how, name: map, channel, at, options } => {
            let options: String = options.iter().map(|(k, v)| format!(" t{k}={}", operand(v))).collect();
            writeln!(f, "r{dst} = {} t{map}[r{channel}]{}{options}", name(how), regs(at))
        }
        Op::Call(b, r, list) => writeln!(f, "r{r} = {}{}", b.row().ir, regs(list)),
        Op::Transform(how, r, a, from, to) => writeln!(f, "r{r} = transform {} r{a} t{from} t{to}", name(how)),
        Op::If(c, then, otherwise) => {
            writeln!(f, "if r{c}")?;
            block(f, then, depth + 1)?;
            under(f, "else", otherwise, depth)
        }
        Op::Loop(head, c, body, step) => {
            writeln!(f, "loop")?;
            block(f, head, depth + 1)?;
            writeln!(f, "{:1$}while r{c}", "", 2 * depth)?;
            block(f, body, depth + 1)?;
            under(f, "step", step, depth)
        }
        Op::Break(n) => writeln!(f, "break {n}"),
        Op::Continue(n) => writeln!(f, "continue {n}"),
        Op::Inline(body) => {
            writeln!(f, "inline")?;
            block(f, body, depth + 1)
        }
        Op::Return => writeln!(f, "return"),
        Op::Illuminance { args, l, cl, category, wanted, body } => {
            let mut extra = category.map_or(String::new(), |t| format!(" t{t}"));
            for (name, r) in wanted {
                write!(extra, " {name}->r{r}")?;
            }
            writeln!(f, "illuminance{} L r{l} Cl r{cl}{extra}", regs(args))?;
            block(f, body, depth + 1)
        }
        Op::Solar { args, l, body } => {
            writeln!(f, "solar{} L r{l}", regs(args))?;
            block(f, body, depth + 1)
        }
        Op::Illuminate { args, l, ps, body } => {
            writeln!(f, "illuminate{} L r{l} Ps r{ps}", regs(args))?;
            block(f, body, depth + 1)
        }
        Op::Gather { args, out, hit, miss } => {
            let out: String = out.iter().map(|(n, r)| format!(" {n}->r{r}")).collect();
            writeln!(f, "gather{}{out}", regs(args))?;
            block(f, hit, depth + 1)?;
            under(f, "miss", miss, depth)
        }
    }
}
