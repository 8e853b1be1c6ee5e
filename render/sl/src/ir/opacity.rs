//! What of a surface shader says how opaque a surface is: a ray that asks for that alone needs no colours.

use super::globals::Global;
use super::op::Op;
use super::optimise::optimise;
use super::program::Program;
use super::register::{Operand, Reg};
use super::walk::{blocks, blocks_mut, reads, result, writes_besides};

/// The operations of a shader that Oi depends on, as a shader with the same parameters. What it prints is left out, too.
pub fn of_opacity(program: &Program) -> Program {
    let mut needed = Needed { numbers: vec![false; program.widths.len()], texts: vec![false; program.n_texts] };
    program.global(Global::Oi).into_iter().for_each(|oi| needed.numbers[oi.index()] = true);
    while needed.mark(&program.body) {}
    let mut own = program.clone();
    needed.keep(&mut own.body);
    optimise(&mut own);
    own
}

/// The registers whose values Oi depends on.
struct Needed {
    numbers: Vec<bool>,
    texts: Vec<bool>,
}

impl Needed {
    /// Whether an operation is needed: it writes what is, leaves a block, or has an operation that is needed in it.
    fn has(&self, op: &Op) -> bool {
        let is_needed = |r: Reg| self.numbers[r.index()];
        let mut found = result(op).is_some_and(is_needed);
        writes_besides(op, &mut |r| found |= is_needed(r));
        found |= match op {
            Op::Break(_) | Op::Continue(_) | Op::Return => true,
            Op::TextConst(r, _) | Op::TextLoad(r, ..) | Op::TextCopy(r, _) | Op::Format(r, ..) => self.texts[r.index()],
            Op::TextStore(first, len, ..) => (0..*len as usize).any(|k| self.texts[first.index() + k]),
            Op::Ask { out: Operand::Text(first), len, .. } => (0..*len as usize).any(|k| self.texts[first.index() + k]),
            _ => false,
        };
        found || blocks(op).into_iter().flatten().any(|op| self.has(op))
    }

    /// Note what needed operations read; whether that is more than before.
    fn mark(&mut self, ops: &[Op]) -> bool {
        let mut more = false;
        for op in ops {
            if !self.has(op) {
                continue;
            }
            reads(op, &mut |of| {
                let known = match of {
                    Operand::Number(r) => &mut self.numbers[r.index()],
                    Operand::Text(r) => &mut self.texts[r.index()],
                };
                more |= !std::mem::replace(known, true);
            });
            for block in blocks(op) {
                more |= self.mark(block);
            }
        }
        more
    }

    fn keep(&self, ops: &mut Vec<Op>) {
        ops.retain(|op| self.has(op));
        for op in ops {
            blocks_mut(op).into_iter().for_each(|block| self.keep(block));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::front::compile;
    use std::path::Path;

    fn sliced(body: &str) -> (Program, String) {
        let text = format!("surface t(float n = 4;) {{ {body} }}");
        let program = compile(Path::new("t.sl"), &text).unwrap_or_else(|e| panic!("{e}"));
        let own = of_opacity(&program);
        crate::ir::validate(&own).unwrap_or_else(|e| panic!("{e}"));
        let shown = own.to_string();
        (own, shown)
    }

    #[test]
    fn what_is_set_to_one_on_every_way_is_opaque() {
        let is_opaque = |body: &str| sliced(body).0.is_opaque;
        let opaque = [
            "Oi = 1; Ci = Cs * diffuse(N);",
            "Ci = s; Oi = color(1, 1, 1);",
            "if (s > 0.5) { Ci = t; Oi = 1; } Oi = 1;",
            "float half(float x) { if (x > 1) return 1; return x / 2; } Ci = half(s); Oi = 1;",
        ];
        opaque.iter().for_each(|body| assert!(is_opaque(body), "{body}"));
        let others = [
            "Ci = s;",
            "Oi = Os; Ci = Oi * s;",
            "Oi = 0.5;",
            "Oi = color(1, 1, 0.9);",
            "if (s > 0.5) Oi = 1;",
            "float k; for (k = 0; k < n; k += 1) Oi = 1;",
            "Oi = 1; if (s > 0.5) Oi = 0;",
            "Oi = 1; setcomp(Oi, 1, t);",
            "Oi = 1; Oi *= Os;",
        ];
        others.iter().for_each(|body| assert!(!is_opaque(body), "{body}"));
    }

    #[test]
    fn what_a_colour_alone_depends_on_is_left_out() {
        let (own, shown) = sliced("Oi = 0.5; Ci = occlusion(P, N, n) + diffuse(N); printf(\"%f\", n);");
        assert!(!own.traces && !shown.contains("occlusion") && !shown.contains("illuminance"), "{shown}");
        // A colour on which it depends stays, and so does a way out of a loop.
        let (own, shown) = sliced("Ci = occlusion(P, N, n); Oi = Ci;");
        assert!(own.traces && !own.keeps_opacity, "{shown}");
        let (own, shown) = sliced(
            "float k; Oi = 0; for (k = 0; k < n; k += 1) { Ci += occlusion(P, N, 2); if (k > 2) break; Oi += 0.1; }",
        );
        assert!(!own.traces && shown.contains("break"), "{shown}");
    }
}
