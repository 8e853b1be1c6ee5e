//! A program as text: what `scree shader --ir` prints, and what snapshots are made of.

use super::op::Op;
use super::program::Program;
use std::fmt::{Display, Formatter, Result, Write};

impl Display for Program {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "{} {}", self.kind.name(), self.name)?;
        for (global, reg) in &self.globals {
            writeln!(f, "global {} {reg}", global.name())?;
        }
        for p in &self.params {
            let class = if p.varying { "varying" } else { "uniform" };
            let array = p.array.map_or(String::new(), |n| format!("[{n}]"));
            let output = if p.output { "output " } else { "" };
            writeln!(f, "parameter {output}{class} {} {}{array} {}", p.kind.name(), p.name, p.reg)?;
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

fn list<T: Display>(list: &[T]) -> String {
    list.iter().map(|r| format!(" {r}")).collect()
}

/// An enumerator's name in lower case.
fn name(x: impl std::fmt::Debug) -> String {
    format!("{x:?}").to_lowercase()
}

fn one(f: &mut Formatter<'_>, op: &Op, depth: usize) -> Result {
    match op {
        Op::Const(r, x) => writeln!(f, "{r} = {x}"),
        Op::TextConst(t, text) => writeln!(f, "{t} = {text:?}"),
        Op::TextCopy(t, a) => writeln!(f, "{t} := {a}"),
        Op::TextEqual(r, a, b) => writeln!(f, "{r} = {a} == {b}"),
        Op::Unary(u, r, a) => writeln!(f, "{r} = {} {a}", name(u)),
        Op::Binary(u, r, a, b) => writeln!(f, "{r} = {} {a} {b}", name(u)),
        Op::Select(r, c, a, b) => writeln!(f, "{r} = {c} ? {a} : {b}"),
        Op::Pack(r, parts) => writeln!(f, "{r} = pack{}", list(parts)),
        Op::Component(r, a, c) => writeln!(f, "{r} = {a}[{c}]"),
        Op::Assign(r, a) => writeln!(f, "{r} := {a}"),
        Op::Within(i, n, _) => writeln!(f, "within {i} {n}"),
        Op::Load(r, first, n, i, _) => writeln!(f, "{r} = {first}..{}[{i}]", first.index() + *n as usize),
        Op::Store(first, n, i, v, _) => writeln!(f, "{first}..{}[{i}] := {v}", first.index() + *n as usize),
        Op::TextLoad(t, first, n, i, _) => writeln!(f, "{t} = {first}..{}[{i}]", first.index() + *n as usize),
        Op::TextStore(first, n, i, v, _) => writeln!(f, "{first}..{}[{i}] := {v}", first.index() + *n as usize),
        Op::ColorSpace(r, a, from, to, _) => writeln!(f, "{r} = colour {a} {from} {to}"),
        Op::Spline(r, basis, args) => writeln!(f, "{r} = spline {basis}{}", list(args)),
        Op::Match(r, a, b) => writeln!(f, "{r} = match {a} {b}"),
        Op::Format(t, args, _) => writeln!(f, "{t} = format{}", list(args)),
        Op::Print(args) => writeln!(f, "print{}", list(args)),
        Op::Ask { dst, what, names, out, len, .. } => {
            let names: String = names.iter().map(|t| format!(" {t}")).collect();
            let len = if *len > 1 { format!("[{len}]") } else { String::new() };
            writeln!(f, "{dst} = ask {}{names} -> {out}{len}", name(what))
        }
        Op::Map { dst, how, name: map, channel, at, options, .. } => {
            let options: String = options.iter().map(|(k, v)| format!(" {k}={v}")).collect();
            writeln!(f, "{dst} = {} {map}[{channel}]{}{options}", name(how), list(at))
        }
        Op::Call(b, r, args) => writeln!(f, "{r} = {}{}", b.row().ir, list(args)),
        Op::Transform(how, r, a, from, to, _) => writeln!(f, "{r} = transform {} {a} {from} {to}", name(how)),
        Op::If(c, then, otherwise) => {
            writeln!(f, "if {c}")?;
            block(f, then, depth + 1)?;
            under(f, "else", otherwise, depth)
        }
        Op::Loop(head, c, body, step, _) => {
            writeln!(f, "loop")?;
            block(f, head, depth + 1)?;
            writeln!(f, "{:1$}while {c}", "", 2 * depth)?;
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
        Op::Illuminance { position, axis, angle, l, cl, category, wanted, body } => {
            let mut extra = category.map_or(String::new(), |t| format!(" {t}"));
            for (name, r) in wanted {
                write!(extra, " {name}->{r}")?;
            }
            writeln!(f, "illuminance {position} {axis} {angle} L {l} Cl {cl}{extra}")?;
            block(f, body, depth + 1)
        }
        Op::Solar { axis, angle, l, body } => {
            writeln!(f, "solar {axis} {angle} L {l}")?;
            block(f, body, depth + 1)
        }
        Op::Illuminate { position, axis, angle, l, ps, body } => {
            writeln!(f, "illuminate {position} {axis} {angle} L {l} Ps {ps}")?;
            block(f, body, depth + 1)
        }
        Op::Gather { position, axis, angle, samples, out, hit, miss } => {
            let out: String = out.iter().map(|(n, r)| format!(" {n}->{r}")).collect();
            writeln!(f, "gather {position} {axis} {angle} {samples}{out}")?;
            block(f, hit, depth + 1)?;
            under(f, "miss", miss, depth)
        }
    }
}
