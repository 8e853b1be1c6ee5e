//! Walks over programs: the blocks of operations, and the registers that an operation reads and writes.

use super::op::Op;
use super::register::{Operand, Reg};

/// The register that a plain operation writes.
pub fn result(op: &Op) -> Option<Reg> {
    match op {
        Op::Const(r, _)
        | Op::Unary(_, r, _)
        | Op::Binary(_, r, ..)
        | Op::Select(r, ..)
        | Op::Pack(r, _)
        | Op::Load(r, ..)
        | Op::Spline(r, ..)
        | Op::Transform(_, r, ..)
        | Op::Map { dst: r, .. }
        | Op::Call(_, r, _)
        | Op::Assign(r, _) => Some(*r),
        Op::Component(r, ..) | Op::Match(r, ..) | Op::TextEqual(r, ..) | Op::Ask { dst: r, .. } => Some((*r).into()),
        Op::ColorSpace(r, ..) => Some((*r).into()),
        _ => None,
    }
}

/// The registers that an operation writes besides its result: elements of arrays, and what comes from outside the shader.
pub fn writes_besides(op: &Op, f: &mut dyn FnMut(Reg)) {
    match op {
        Op::Store(first, len, ..) | Op::Ask { out: Operand::Number(first), len, .. } => first.array(*len).for_each(f),
        Op::Illuminance { l, cl, wanted, .. } => {
            [(*l).into(), (*cl).into()].into_iter().chain(wanted.iter().map(|(_, r)| *r)).for_each(f);
        }
        Op::Gather { out, .. } => out.iter().for_each(|(_, r)| f(*r)),
        Op::Solar { l, .. } => f((*l).into()),
        Op::Illuminate { l, ps, .. } => [*l, *ps].into_iter().for_each(|r| f(r.into())),
        _ => {}
    }
}

/// Call `f` for every operation of a block, including those of inner blocks.
pub fn visit(ops: &[Op], f: &mut dyn FnMut(&Op)) {
    for op in ops {
        f(op);
        for block in blocks(op) {
            visit(block, f);
        }
    }
}

/// The inner blocks of an operation, by reference or by mutable reference as the operation is.
macro_rules! inner_blocks {
    ($op:expr) => {
        match $op {
            Op::If(_, a, b) => vec![a, b],
            Op::Loop(a, _, b, c, _) => vec![a, b, c],
            Op::Illuminance { body, .. } | Op::Solar { body, .. } | Op::Illuminate { body, .. } | Op::Inline(body) => {
                vec![body]
            }
            Op::Gather { hit, miss, .. } => vec![hit, miss],
            _ => vec![],
        }
    };
}

/// The inner blocks of an operation.
pub fn blocks(op: &Op) -> Vec<&Vec<Op>> {
    inner_blocks!(op)
}

/// The inner blocks of an operation, to be changed.
pub fn blocks_mut(op: &mut Op) -> Vec<&mut Vec<Op>> {
    inner_blocks!(op)
}

/// The registers that an operation reads, those of its inner blocks aside. Variables that it changes in part count. Long,
/// because it has an arm for each operation.
pub fn reads(op: &Op, f: &mut dyn FnMut(Operand)) {
    use Operand::{Number, Text};
    /// All of some registers of numbers.
    fn numbers<R: Copy + Into<Reg>>(list: &[R], f: &mut dyn FnMut(Operand)) {
        list.iter().for_each(|r| f(Number((*r).into())));
    }
    match op {
        Op::Const(..) | Op::TextConst(..) | Op::Break(_) | Op::Continue(_) | Op::Return | Op::Inline(_) => {}
        // A variable is kept with what is assigned to it.
        Op::TextCopy(r, a) => [*r, *a].into_iter().for_each(|r| f(Text(r))),
        Op::Assign(r, a) => numbers(&[*r, *a], f),
        Op::TextEqual(_, a, b) | Op::Match(_, a, b) => [*a, *b].into_iter().for_each(|r| f(Text(r))),
        Op::Within(i, ..) => numbers(&[*i], f),
        Op::Unary(_, _, a) => f(Number(*a)),
        Op::Component(_, a, _) => numbers(&[*a], f),
        Op::Binary(_, _, a, b) => numbers(&[*a, *b], f),
        Op::Select(_, c, a, b) => numbers(&[(*c).into(), *a, *b], f),
        Op::Pack(_, list) => numbers(list, f),
        Op::Call(_, _, list) => numbers(list, f),
        Op::Load(_, first, len, i, _) => {
            first.array(*len).for_each(|r| f(Number(r)));
            numbers(&[*i], f);
        }
        Op::Store(first, len, i, v, _) => {
            first.array(*len).for_each(|r| f(Number(r)));
            numbers(&[(*i).into(), *v], f);
        }
        Op::TextLoad(_, first, len, i, _) => {
            first.array(*len).for_each(|r| f(Text(r)));
            numbers(&[*i], f);
        }
        Op::TextStore(first, len, i, v, _) => {
            first.array(*len).chain([*v]).for_each(|r| f(Text(r)));
            numbers(&[*i], f);
        }
        Op::Transform(_, _, a, from, to, _) => {
            f(Number(*a));
            [*from, *to].into_iter().for_each(|r| f(Text(r)));
        }
        Op::ColorSpace(_, a, from, to, _) => {
            numbers(&[*a], f);
            [*from, *to].into_iter().for_each(|r| f(Text(r)));
        }
        Op::Spline(_, basis, list) => {
            f(Text(*basis));
            numbers(list, f);
        }
        Op::Format(_, list, _) | Op::Print(list) => list.iter().for_each(|o| f(*o)),
        Op::Ask { names, out, len, .. } => {
            names.iter().for_each(|r| f(Text(*r)));
            out.array(*len).for_each(f);
        }
        Op::Map { name, channel, at, options, .. } => {
            f(Text(*name));
            numbers(at, f);
            numbers(&[*channel], f);
            options.iter().for_each(|(key, value)| {
                f(Text(*key));
                f(*value);
            });
        }
        Op::If(c, ..) | Op::Loop(_, c, ..) => numbers(&[*c], f),
        Op::Gather { position, axis, angle, samples, out, .. } => {
            numbers(&[*position, *axis], f);
            numbers(&[*angle, *samples], f);
            out.iter().for_each(|(_, r)| f(Number(*r)));
        }
        Op::Illuminance { position, axis, angle, l, cl, category, wanted, .. } => {
            numbers(&[*position, *axis, *l, *cl], f);
            numbers(&[*angle], f);
            wanted.iter().for_each(|(_, r)| f(Number(*r)));
            category.iter().for_each(|r| f(Text(*r)));
        }
        Op::Solar { axis, angle, l, .. } => {
            numbers(&[*axis, *l], f);
            numbers(&[*angle], f);
        }
        Op::Illuminate { position, axis, angle, l, ps, .. } => {
            numbers(&[*position, *axis, *l, *ps], f);
            numbers(&[*angle], f);
        }
    }
}

/// The single registers of numbers that an operation reads, to be changed to others of the same width; those of ranges, results
/// and variables are not among them.
pub fn operands_mut(op: &mut Op, f: &mut dyn FnMut(&mut Reg)) {
    fn each<'r, R: Copy + Into<Reg> + TryFrom<Reg> + 'r>(
        list: impl IntoIterator<Item = &'r mut R>,
        f: &mut dyn FnMut(&mut Reg),
    ) {
        for r in list {
            let mut reg = (*r).into();
            f(&mut reg);
            // Of another width it would be no operand.
            *r = R::try_from(reg).unwrap_or(*r);
        }
    }
    let operand = |o: &mut Operand, f: &mut dyn FnMut(&mut Reg)| {
        if let Operand::Number(r) = o {
            f(r);
        }
    };
    match op {
        Op::Assign(_, a) | Op::Unary(_, _, a) => f(a),
        Op::Component(_, a, _) => each([a], f),
        Op::Within(i, ..) => each([i], f),
        Op::Binary(_, _, a, b) => [a, b].into_iter().for_each(f),
        Op::Select(_, c, a, b) => {
            each([c], f);
            each([a, b], f);
        }
        Op::Pack(_, list) => each(list, f),
        Op::Call(_, _, list) | Op::Spline(_, _, list) => list.iter_mut().for_each(f),
        Op::Load(_, _, _, i, _) | Op::TextLoad(_, _, _, i, _) | Op::TextStore(_, _, i, _, _) => each([i], f),
        Op::Store(_, _, i, v, _) => {
            each([i], f);
            f(v);
        }
        Op::Transform(_, _, a, ..) => f(a),
        Op::ColorSpace(_, a, ..) => each([a], f),
        Op::Format(_, list, _) | Op::Print(list) => list.iter_mut().for_each(|o| operand(o, f)),
        Op::Map { channel, at, options, .. } => {
            at.iter_mut().for_each(&mut *f);
            each([channel], f);
            options.iter_mut().for_each(|(_, value)| operand(value, f));
        }
        Op::If(c, ..) | Op::Loop(_, c, ..) => each([c], f),
        Op::Gather { position, axis, angle, samples, .. } => {
            each([position, axis], f);
            each([angle, samples], f);
        }
        Op::Solar { axis, angle, .. } => {
            each([axis], f);
            each([angle], f);
        }
        Op::Illuminate { position, axis, angle, .. } | Op::Illuminance { position, axis, angle, .. } => {
            each([position, axis], f);
            each([angle], f);
        }
        Op::Const(..) | Op::Inline(_) | Op::Break(_) | Op::Continue(_) | Op::Return => {}
        Op::TextConst(..) | Op::TextCopy(..) | Op::TextEqual(..) | Op::Match(..) | Op::Ask { .. } => {}
    }
}
