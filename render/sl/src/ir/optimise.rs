//! Optimisation of the IR before a back end sees it: operations on constants are done here, and those whose result nobody reads
//! are dropped. (Uniform values need no hoisting out of the points: an operation on uniform operands is done once a grid, see
//! [`crate::ir`].)

use super::builtins::{How, SceneCall};
use super::globals::Global;
use super::op::{Lookup, Op};
use super::program::Program;
use super::register::{Operand, Reg};
use super::walk::{blocks, blocks_mut, operands_mut, reads, result, visit, writes_besides};
use crate::shadeop::number::{binary_value, unary_value};
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
    program.variables = variables_of(program);
    (program.keeps_opacity, program.reads_neighbours) = (keeps_opacity(program), reads_neighbours(program));
    program.is_opaque = is_opaque(program);
    program.asks_displacement = any(program, |op| matches!(op, Op::Ask { what: crate::ir::Ask::Displacement, .. }));
    program.traces = any(program, |op| match op {
        Op::Gather { .. } => true,
        Op::Map { how, .. } => matches!(how, Lookup::Shadow),
        Op::Call(f, ..) => {
            matches!(f.row().how, How::Scene(call) if !matches!(call, SceneCall::Ambient | SceneCall::Openness | SceneCall::Surroundings))
        }
        _ => false,
    });
}

fn keeps_opacity(program: &Program) -> bool {
    let Some(oi) = program.global(Global::Oi) else { return true };
    let os = program.global(Global::Os);
    let mut keeps = true;
    visit(&program.body, &mut |op| {
        keeps &= !matches!(op, Op::Assign(dst, src) if *dst == oi && Some(*src) != os);
        writes_besides(op, &mut |r| keeps &= r != oi);
    });
    keeps
}

/// Whether Oi is 1 wherever the shader ends: it is set to that on the way that all points go, and to nothing else anywhere.
fn is_opaque(program: &Program) -> bool {
    let Some(oi) = program.global(Global::Oi) else { return false };
    let variables = assigned(program);
    let (mut ones, mut sets_other) = (vec![false; program.widths.len()], false);
    visit(&program.body, &mut |op| {
        if let Op::Const(r, 1.0) = op {
            ones[r.index()] = !variables[r.index()];
        }
    });
    let sets_one = |op: &Op| matches!(op, Op::Assign(dst, src) if *dst == oi && ones[src.index()]);
    visit(&program.body, &mut |op| {
        sets_other |= matches!(op, Op::Assign(dst, _) if *dst == oi) && !sets_one(op);
        writes_besides(op, &mut |r| sets_other |= r == oi);
    });
    let before = program.body.iter().take_while(|op| !sets_one(op)).count();
    !sets_other && before < program.body.len() && !program.body[..before].iter().any(may_return)
}

/// Whether an operation may leave the shader: what returns from a function called there does not.
fn may_return(op: &Op) -> bool {
    match op {
        Op::Return => true,
        Op::Inline(_) => false,
        op => blocks(op).into_iter().flatten().any(may_return),
    }
}

fn reads_neighbours(program: &Program) -> bool {
    any(program, |op| match op {
        Op::Map { .. } => true,
        Op::Call(f, ..) => f.row().neighbours,
        _ => false,
    })
}

/// Whether any operation of a program is such.
fn any(program: &Program, is_such: impl Fn(&Op) -> bool) -> bool {
    let mut found = false;
    let blocks = program.params.iter().map(|p| &p.default).chain([&program.body]);
    blocks.for_each(|block| visit(block, &mut |op| found |= is_such(op)));
    found
}

/// Registers that may be written more than once: they are variables, not values.
fn assigned(program: &Program) -> Vec<bool> {
    let mut found = vec![false; program.widths.len()];
    let mut mark = |r: Reg| found[r.index()] = true;
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

/// The registers of [`Program::variables`]: those and parameters.
fn variables_of(program: &Program) -> Vec<u16> {
    let mut found = assigned(program);
    for param in &program.params {
        param.reg.array(param.array.unwrap_or(1)).for_each(|o| match o {
            Operand::Number(r) => found[r.index()] = true,
            Operand::Text(_) => {}
        });
    }
    (0..found.len()).filter(|k| found[*k]).map(|k| k as u16).collect()
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
            writes[r.index()] += 1;
            written_at[r.index()] = at;
        }
        let mut mark = |r: Reg| writes[r.index()] = 2;
        if let Op::Load(_, first, len, _, _) = op {
            first.array(*len).for_each(&mut mark);
        }
        writes_besides(op, &mut mark);
        let own = if let Op::Assign(dst, _) = op { Some(*dst) } else { None };
        reads(op, &mut |o| {
            if let Operand::Number(r) = o
                && own != Some(r)
            {
                first_read[r.index()] = first_read[r.index()].min(at);
                last_read[r.index()] = at;
            }
        });
    });
    let parameters = program.params.iter().filter_map(|p| match p.reg {
        Operand::Number(r) => Some(r),
        Operand::Text(_) => None,
    });
    let outside: Vec<Reg> = program.globals.iter().map(|(_, r)| *r).chain(parameters).collect();
    let mut values: HashMap<Reg, Reg> = HashMap::new();
    let mut find = |dst: Reg, src: Reg, here: usize, end: usize| {
        let (d, s) = (dst.index(), src.index());
        let one_name = writes[d] == 1 && !outside.contains(&dst) && dst.width() == src.width();
        let read_after = first_read[d] > here && last_read[d] <= end;
        // The value: made once, before, or given from outside and never changed.
        let lasting = match writes[s] {
            0 => {
                outside.contains(&src)
                    && program.params.iter().any(|p| p.reg == Operand::Number(src) && p.array.is_none())
            }
            1 => written_at[s] < here && (!variables[s] || !outside.contains(&src)),
            _ => false,
        };
        if one_name && read_after && lasting && first_read[d] != usize::MAX {
            values.insert(dst, src);
        }
    };
    let mut at = 0;
    copies(&program.body, &mut at, &mut find);
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

/// Do what is known: constants take the place of the operations that make them.
fn fold(ops: &mut [Op], known: &mut HashMap<Reg, f32>, variables: &[bool]) -> bool {
    let mut changed = false;
    for op in ops.iter_mut() {
        let value = |r: Reg| known.get(&r).copied();
        let result = match op {
            Op::Const(r, x) => Some((*r, *x)),
            Op::Unary(f, dst, a) => value(*a).map(|a| (*dst, unary_value(*f, a))),
            Op::Binary(f, dst, a, b) => value(*a).zip(value(*b)).map(|(a, b)| (*dst, binary_value(*f, a, b))),
            Op::Select(dst, c, a, b) => match (value((*c).into()), value(*a), value(*b)) {
                (Some(c), Some(a), Some(b)) => Some((*dst, if c != 0.0 { a } else { b })),
                _ => None,
            },
            // Only triples whose three numbers are the same are known by one.
            Op::Pack(dst, parts) if parts.len() == 3 => match [0, 1, 2].map(|k| value(parts[k].into())) {
                [Some(a), Some(b), Some(c)] if a == b && b == c => Some((*dst, a)),
                _ => None,
            },
            Op::Component(dst, a, _) => value((*a).into()).map(|a| ((*dst).into(), a)),
            _ => None,
        };
        if let Some((dst, x)) = result {
            if !variables[dst.index()] {
                known.insert(dst, x);
            }
            if !matches!(op, Op::Const(..)) && x.is_finite() {
                *op = Op::Const(dst, x);
                changed = true;
            }
        }
        // A condition that is known leaves one branch.
        if let Op::If(c, then, otherwise) = op
            && let Some(c) = known.get(&(*c).into())
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
        Op::TextConst(r, _) | Op::TextLoad(r, ..) | Op::Format(r, ..) => text_read[r.index()],
        Op::If(_, a, b) => !(a.is_empty() && b.is_empty()),
        other => result(other).is_none_or(|r| read[r.index()]),
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
    program.globals.iter().for_each(|(_, r)| numbers[r.index()] = true);
    for param in &program.params {
        param.reg.array(param.array.unwrap_or(1)).for_each(|o| match o {
            Operand::Number(r) => numbers[r.index()] = true,
            Operand::Text(r) => texts[r.index()] = true,
        });
    }
    let blocks = program.params.iter().map(|p| &p.default).chain([&program.body]);
    for block in blocks {
        visit(block, &mut |op| {
            reads(op, &mut |o| match o {
                Operand::Number(r) => numbers[r.index()] = true,
                Operand::Text(r) => texts[r.index()] = true,
            })
        });
    }
    (numbers, texts)
}
