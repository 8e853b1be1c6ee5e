//! Walks over programs: the blocks of operations, and the registers that an operation reads and writes.

use super::op::{Op, Operand, Reg};

/// The register that a plain operation writes.
pub fn result(op: &Op) -> Option<Reg> {
    match op {
        Op::Const(r, _)
        | Op::Unary(_, r, _)
        | Op::Binary(_, r, ..)
        | Op::Select(r, ..)
        | Op::Pack(r, _)
        | Op::Component(r, ..)
        | Op::Load(r, ..)
        | Op::ColorSpace(r, ..)
        | Op::Spline(r, ..)
        | Op::Match(r, ..)
        | Op::TextEqual(r, ..)
        | Op::Transform(_, r, ..)
        | Op::Map { dst: r, .. }
        | Op::Call(_, r, _)
        | Op::Ask { dst: r, .. }
        | Op::Assign(r, _) => Some(*r),
        _ => None,
    }
}

/// The registers that an operation writes besides its result: elements of arrays, and what comes from outside the shader.
pub fn writes_besides(op: &Op, f: &mut dyn FnMut(Reg)) {
    match op {
        Op::Store(first, len, ..) | Op::Ask { out: Operand::Number(first), len, .. } => {
            (*first..first + len).for_each(f);
        }
        Op::Illuminance { l, cl, wanted, .. } => {
            [*l, *cl].into_iter().chain(wanted.iter().map(|(_, r)| *r)).for_each(f);
        }
        Op::Gather { out, .. } => out.iter().for_each(|(_, r)| f(*r)),
        Op::Solar { l, .. } => f(*l),
        Op::Illuminate { l, ps, .. } => [*l, *ps].into_iter().for_each(f),
        _ => {}
    }
}

/// Visit all operations, those of inner blocks too.
pub fn visit(ops: &[Op], f: &mut dyn FnMut(&Op)) {
    for op in ops {
        f(op);
        for block in blocks(op) {
            visit(block, f);
        }
    }
}

pub fn blocks(op: &Op) -> Vec<&[Op]> {
    match op {
        Op::If(_, a, b) => vec![a, b],
        Op::Loop(a, _, b, c) => vec![a, b, c],
        Op::Illuminance { body, .. } | Op::Solar { body, .. } | Op::Illuminate { body, .. } | Op::Inline(body) => {
            vec![body]
        }
        Op::Gather { hit, miss, .. } => vec![hit, miss],
        _ => vec![],
    }
}

pub fn blocks_mut(op: &mut Op) -> Vec<&mut Vec<Op>> {
    match op {
        Op::If(_, a, b) => vec![a, b],
        Op::Loop(a, _, b, c) => vec![a, b, c],
        Op::Illuminance { body, .. } | Op::Solar { body, .. } | Op::Illuminate { body, .. } | Op::Inline(body) => {
            vec![body]
        }
        Op::Gather { hit, miss, .. } => vec![hit, miss],
        _ => vec![],
    }
}

/// The registers that an operation reads, those of its inner blocks aside. Variables that it changes in part count.
pub fn reads(op: &Op, f: &mut dyn FnMut(Operand)) {
    use Operand::{Number, Text};
    match op {
        Op::Const(..) | Op::TextConst(..) | Op::Break(_) | Op::Continue(_) | Op::Return | Op::Inline(_) => {}
        // A variable is kept with what is assigned to it.
        Op::TextCopy(r, a) => [*r, *a].into_iter().for_each(|r| f(Text(r))),
        Op::Assign(r, a) => [*r, *a].into_iter().for_each(|r| f(Number(r))),
        Op::TextEqual(_, a, b) | Op::Match(_, a, b) => [*a, *b].into_iter().for_each(|r| f(Text(r))),
        Op::Unary(_, _, a) | Op::Component(_, a, _) => f(Number(*a)),
        Op::Binary(_, _, a, b) => [*a, *b].into_iter().for_each(|r| f(Number(r))),
        Op::Select(_, c, a, b) => [*c, *a, *b].into_iter().for_each(|r| f(Number(r))),
        Op::Pack(_, list) | Op::Call(_, _, list) => list.iter().for_each(|r| f(Number(*r))),
        Op::Load(_, first, len, i) => (*first..first + len).chain([*i]).for_each(|r| f(Number(r))),
        Op::Store(first, len, i, v) => (*first..first + len).chain([*i, *v]).for_each(|r| f(Number(r))),
        Op::TextLoad(_, first, len, i) => {
            (*first..first + len).for_each(|r| f(Text(r)));
            f(Number(*i));
        }
        Op::TextStore(first, len, i, v) => {
            (*first..first + len).chain([*v]).for_each(|r| f(Text(r)));
            f(Number(*i));
        }
        Op::Transform(_, _, a, from, to) | Op::ColorSpace(_, a, from, to) => {
            f(Number(*a));
            [*from, *to].into_iter().for_each(|r| f(Text(r)));
        }
        Op::Spline(_, basis, list) => {
            f(Text(*basis));
            list.iter().for_each(|r| f(Number(*r)));
        }
        Op::Format(_, list) | Op::Print(list) => list.iter().for_each(|o| f(*o)),
        Op::Ask { names, out, len, .. } => {
            names.iter().for_each(|r| f(Text(*r)));
            match out {
                Number(r) => (*r..r + len).for_each(|r| f(Number(r))),
                Text(r) => (*r..r + len).for_each(|r| f(Text(r))),
            }
        }
        Op::Map { name, channel, at, options, .. } => {
            f(Text(*name));
            at.iter().chain([channel]).for_each(|r| f(Number(*r)));
            options.iter().for_each(|(key, value)| {
                f(Text(*key));
                f(*value);
            });
        }
        Op::If(c, ..) | Op::Loop(_, c, ..) => f(Number(*c)),
        Op::Gather { args, out, .. } => args.iter().chain(out.iter().map(|(_, r)| r)).for_each(|r| f(Number(*r))),
        Op::Illuminance { args, l, cl, category, wanted, .. } => {
            args.iter().chain([l, cl]).chain(wanted.iter().map(|(_, r)| r)).for_each(|r| f(Number(*r)));
            category.iter().for_each(|r| f(Text(*r)));
        }
        Op::Solar { args, l, .. } => args.iter().chain([l]).for_each(|r| f(Number(*r))),
        Op::Illuminate { args, l, ps, .. } => args.iter().chain([l, ps]).for_each(|r| f(Number(*r))),
    }
}

/// The single registers of numbers that an operation reads, to be changed; those of ranges, results and variables are not
/// among them.
pub fn operands_mut(op: &mut Op, f: &mut dyn FnMut(&mut Reg)) {
    let operand = |o: &mut Operand, f: &mut dyn FnMut(&mut Reg)| {
        if let Operand::Number(r) = o {
            f(r);
        }
    };
    match op {
        Op::Assign(_, a) | Op::Unary(_, _, a) | Op::Component(_, a, _) => f(a),
        Op::Binary(_, _, a, b) => [a, b].into_iter().for_each(f),
        Op::Select(_, c, a, b) => [c, a, b].into_iter().for_each(f),
        Op::Pack(_, list) | Op::Call(_, _, list) | Op::Spline(_, _, list) => list.iter_mut().for_each(f),
        Op::Load(_, _, _, i) | Op::TextLoad(_, _, _, i) | Op::TextStore(_, _, i, _) => f(i),
        Op::Store(_, _, i, v) => [i, v].into_iter().for_each(f),
        Op::Transform(_, _, a, ..) | Op::ColorSpace(_, a, ..) => f(a),
        Op::Format(_, list) | Op::Print(list) => list.iter_mut().for_each(|o| operand(o, f)),
        Op::Map { channel, at, options, .. } => {
            at.iter_mut().chain([channel]).for_each(&mut *f);
            options.iter_mut().for_each(|(_, value)| operand(value, f));
        }
        Op::If(c, ..) | Op::Loop(_, c, ..) => f(c),
        Op::Gather { args, .. } => args.iter_mut().for_each(f),
        Op::Solar { args, .. } => args.iter_mut().for_each(f),
        Op::Illuminate { args, .. } | Op::Illuminance { args, .. } => args.iter_mut().for_each(f),
        Op::Const(..) | Op::Inline(_) | Op::Break(_) | Op::Continue(_) | Op::Return => {}
        Op::TextConst(..) | Op::TextCopy(..) | Op::TextEqual(..) | Op::Match(..) | Op::Ask { .. } => {}
    }
}
