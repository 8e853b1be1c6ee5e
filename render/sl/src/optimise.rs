//! What the IR sheds before a back end sees it: operations on constants are done here, and those whose result nobody reads
//! are dropped. (Uniform values need no hoisting out of the points: an operation on uniform operands is done once a grid, see
//! [`crate::ir`].)

use crate::ir::*;
use crate::machine::{binary_value, unary_value};
use std::collections::HashMap;

/// Fold and drop until nothing changes.
pub fn optimise(program: &mut Program) {
    let variables = assigned(program);
    for _ in 0..8 {
        let mut known = HashMap::new();
        let mut changed = fold(&mut program.body, &mut known, &variables);
        changed |= drop_copies(program);
        let (read, text_read) = read_anywhere(program);
        changed |= drop_dead(&mut program.body, &read, &text_read);
        for param in &mut program.params {
            changed |= drop_dead(&mut param.default, &read, &text_read);
        }
        if !changed {
            break;
        }
    }
    (program.keeps_opacity, program.reads_neighbours) = (keeps_opacity(program), reads_neighbours(program));
}

fn keeps_opacity(program: &Program) -> bool {
    let Some(oi) = program.global("Oi") else { return true };
    let os = program.global("Os");
    let mut keeps = true;
    visit(&program.body, &mut |op| {
        keeps &= !matches!(op, Op::Assign(dst, src) if *dst == oi && Some(*src) != os);
        writes_besides(op, &mut |r| keeps &= r != oi);
    });
    keeps
}

fn reads_neighbours(program: &Program) -> bool {
    use Builtin::{Area, CalculateNormal, Du, Dv, Random, Width};
    let mut reads = false;
    for block in program.params.iter().map(|p| &p.default).chain([&program.body]) {
        visit(block, &mut |op| {
            reads |= matches!(op, Op::Map { .. } | Op::Call(Du | Dv | CalculateNormal | Area | Width, ..));
            // Without a place, the grid's first point stands for all.
            reads |= matches!(op, Op::Call(Random, _, args) if args.len() < 2);
        });
    }
    reads
}

/// Registers that may be written more than once: they are variables, not values.
fn assigned(program: &Program) -> Vec<bool> {
    let mut found = vec![false; program.widths.len()];
    let mut mark = |r: Reg| found[r as usize] = true;
    program.globals.iter().for_each(|(_, r)| mark(*r));
    let blocks = program.params.iter().map(|p| &p.default).chain([&program.body]);
    for block in blocks {
        visit(block, &mut |op| {
            if let Op::Assign(r, _) = op {
                mark(*r);
            }
            writes_besides(op, &mut mark);
        });
    }
    found
}

/// The registers that an operation writes besides its result: elements of arrays, and what comes from outside the shader.
fn writes_besides(op: &Op, f: &mut dyn FnMut(Reg)) {
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

/// Where a variable is but another name for a value, its readers read the value: such are the parameters of inlined functions.
/// A copy made where some points are inactive would otherwise turn one value for all into one a point.
fn drop_copies(program: &mut Program) -> bool {
    let n = program.widths.len();
    // Of every register: how often it is written, and the places (operations counted from the first) where it is first and
    // last written and read. What is not written by one plain operation counts as written twice.
    let (mut writes, mut written_at) = (vec![0u32; n], vec![0usize; n]);
    let (mut first_read, mut last_read) = (vec![usize::MAX; n], vec![0usize; n]);
    let variables = assigned(program);
    let mut at = 0;
    visit(&program.body, &mut |op| {
        at += 1;
        if let Some(r) = result(op) {
            writes[r as usize] += 1;
            written_at[r as usize] = at;
        }
        let mut mark = |r: Reg| writes[r as usize] = 2;
        if let Op::Load(_, first, len, _) = op {
            (*first..first + len).for_each(&mut mark);
        }
        writes_besides(op, &mut mark);
        let own = if let Op::Assign(dst, _) = op { Some(*dst) } else { None };
        reads(op, &mut |o| {
            if let Operand::Number(r) = o
                && own != Some(r)
            {
                first_read[r as usize] = first_read[r as usize].min(at);
                last_read[r as usize] = at;
            }
        });
    });
    let outside: Vec<Reg> =
        program.globals.iter().map(|(_, r)| *r).chain(program.params.iter().map(|p| p.reg)).collect();
    let mut values: HashMap<Reg, Reg> = HashMap::new();
    let mut look = |dst: Reg, src: Reg, here: usize, end: usize| {
        let (d, s) = (dst as usize, src as usize);
        let one_name = writes[d] == 1 && !outside.contains(&dst) && program.widths[d] == program.widths[s];
        let read_after = first_read[d] > here && last_read[d] <= end;
        // The value: made once, before, or given from outside and never changed.
        let lasting = match writes[s] {
            0 => outside.contains(&src) && program.params.iter().any(|p| p.reg == src && p.array.is_none()),
            1 => written_at[s] < here && (!variables[s] || !outside.contains(&src)),
            _ => false,
        };
        if one_name && read_after && lasting && first_read[d] != usize::MAX {
            values.insert(dst, src);
        }
    };
    let mut at = 0;
    copies(&program.body, &mut at, &mut look);
    if values.is_empty() {
        return false;
    }
    let last = |mut r: Reg| {
        while let Some(next) = values.get(&r) {
            r = *next;
        }
        r
    };
    rename(&mut program.body, &last, &values);
    true
}

/// Tell `found` of every copy from one register to another: both, its place, and the last place of the block it stands in.
fn copies(ops: &[Op], at: &mut usize, found: &mut dyn FnMut(Reg, Reg, usize, usize)) {
    let mut own = Vec::new();
    for op in ops {
        *at += 1;
        if let Op::Assign(dst, src) = op {
            own.push((*dst, *src, *at));
        }
        blocks(op).into_iter().for_each(|block| copies(block, at, found));
    }
    own.into_iter().for_each(|(dst, src, here)| found(dst, src, here, *at));
}

/// Let readers of `gone` registers read others, and drop their copies.
fn rename(ops: &mut Vec<Op>, to: &dyn Fn(Reg) -> Reg, gone: &HashMap<Reg, Reg>) {
    ops.retain(|op| !matches!(op, Op::Assign(dst, _) if gone.contains_key(dst)));
    for op in ops {
        operands_mut(op, &mut |r| *r = to(*r));
        blocks_mut(op).into_iter().for_each(|block| rename(block, to, gone));
    }
}

/// The register that a plain operation writes.
fn result(op: &Op) -> Option<Reg> {
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

/// Do what is known: constants take the place of the operations that make them.
fn fold(ops: &mut [Op], known: &mut HashMap<Reg, f32>, variables: &[bool]) -> bool {
    let mut changed = false;
    for op in ops.iter_mut() {
        let value = |r: &Reg| known.get(r).copied();
        let result = match op {
            Op::Const(r, x) => Some((*r, *x)),
            Op::Unary(f, dst, a) => value(a).map(|a| (*dst, unary_value(*f, a))),
            Op::Binary(f, dst, a, b) => value(a).zip(value(b)).map(|(a, b)| (*dst, binary_value(*f, a, b))),
            Op::Select(dst, c, a, b) => match (value(c), value(a), value(b)) {
                (Some(c), Some(a), Some(b)) => Some((*dst, if c != 0.0 { a } else { b })),
                _ => None,
            },
            // Only triples whose three numbers are the same are known by one.
            Op::Pack(dst, parts) if parts.len() == 3 => match (value(&parts[0]), value(&parts[1]), value(&parts[2])) {
                (Some(a), Some(b), Some(c)) if a == b && b == c => Some((*dst, a)),
                _ => None,
            },
            Op::Component(dst, a, _) => value(a).map(|a| (*dst, a)),
            _ => None,
        };
        if let Some((dst, x)) = result {
            if !variables[dst as usize] {
                known.insert(dst, x);
            }
            if !matches!(op, Op::Const(..)) && x.is_finite() {
                *op = Op::Const(dst, x);
                changed = true;
            }
        }
        // A condition that is known leaves one branch.
        if let Op::If(c, then, otherwise) = op
            && let Some(c) = known.get(c)
        {
            let dead = if *c != 0.0 { otherwise } else { then };
            changed |= !dead.is_empty();
            dead.clear();
        }
        for block in blocks_mut(op) {
            // What a block that may not run defines is known in it alone.
            let mut inner = known.clone();
            changed |= fold(block, &mut inner, variables);
        }
    }
    changed
}

/// Drop operations without effect whose results are not read.
fn drop_dead(ops: &mut Vec<Op>, read: &[bool], text_read: &[bool]) -> bool {
    let before = ops.len();
    ops.retain(|op| match op {
        // These change more than their result.
        Op::Assign(..) | Op::Ask { .. } => true,
        Op::TextConst(r, _) | Op::TextLoad(r, ..) | Op::Format(r, _) => text_read[*r as usize],
        Op::If(_, a, b) => !(a.is_empty() && b.is_empty()),
        other => result(other).is_none_or(|r| read[r as usize]),
    });
    let mut changed = ops.len() != before;
    for op in ops.iter_mut() {
        for block in blocks_mut(op) {
            changed |= drop_dead(block, read, text_read);
        }
    }
    changed
}

/// Which registers are read anywhere; globals, outputs and parameters count.
fn read_anywhere(program: &Program) -> (Vec<bool>, Vec<bool>) {
    let mut numbers = vec![false; program.widths.len()];
    let mut texts = vec![false; program.n_texts];
    program.globals.iter().for_each(|(_, r)| numbers[*r as usize] = true);
    for param in &program.params {
        for k in 0..param.array.unwrap_or(1) {
            match param.kind {
                Kind::Text => texts[(param.reg + k) as usize] = true,
                _ => numbers[(param.reg + k) as usize] = true,
            }
        }
    }
    let blocks = program.params.iter().map(|p| &p.default).chain([&program.body]);
    for block in blocks {
        visit(block, &mut |op| {
            reads(op, &mut |o| match o {
                Operand::Number(r) => numbers[r as usize] = true,
                Operand::Text(r) => texts[r as usize] = true,
            })
        });
    }
    (numbers, texts)
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

fn blocks(op: &Op) -> Vec<&[Op]> {
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

fn blocks_mut(op: &mut Op) -> Vec<&mut Vec<Op>> {
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
fn reads(op: &Op, f: &mut dyn FnMut(Operand)) {
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
fn operands_mut(op: &mut Op, f: &mut dyn FnMut(&mut Reg)) {
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
