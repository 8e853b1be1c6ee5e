//! Binding: defaults of parameters are computed once.

use super::super::bound::{Answer, BoundShader};
use super::super::points::Points;
use super::super::scene::Scene;
use super::super::slots::VariableSlots;
use super::state::Machine;
use crate::ir::walk::{reads, visit};
use crate::ir::{Op, Operand, Program};
use std::sync::Arc;

impl BoundShader {
    /// Bind a program: the values given, by parameter slot, and for every other parameter its default, computed once in `scene`
    /// unless it depends on the points.
    pub fn new(
        program: Arc<Program>,
        numbers: Vec<(usize, Vec<f32>)>,
        texts: Vec<(usize, Vec<String>)>,
        scene: &dyn Scene,
    ) -> BoundShader {
        let mut bound = BoundShader::given(program, numbers, texts);
        let points = Points::new(1, 1, 1.0);
        let mut machine = Machine::new();
        machine.load(&bound, &points);
        for (_, reg) in &bound.program.globals {
            machine.regs[reg.index()] = vec![0.0; reg.width()];
        }
        machine.defaults(&bound, &VariableSlots::default(), &points, scene);
        let program = bound.program.clone();
        machine.say_faults(&program, scene);
        let unset: Vec<bool> = (0..program.params.len()).map(|slot| bound.value(slot).is_none()).collect();
        let reads_globals = |ops: &[Op]| {
            let mut found = false;
            let mut note = |of: Operand| found |= program.globals.iter().any(|(_, reg)| of == Operand::Number(*reg));
            visit(ops, &mut |op| reads(op, &mut note));
            found
        };
        for (slot, param) in program.params.iter().enumerate().filter(|(slot, _)| unset[*slot]) {
            if reads_globals(&param.default) {
                continue;
            }
            match param.reg {
                Operand::Text(r) if param.array.is_some() => {
                    let own = r.index()..r.index() + param.array.unwrap_or(1) as usize;
                    bound.set(slot, Answer::Texts(machine.texts[own].to_vec()));
                }
                Operand::Text(r) => bound.set(slot, Answer::Text(machine.texts[r.index()].clone())),
                Operand::Number(r) => {
                    let registers = r.index()..r.index() + param.array.unwrap_or(1) as usize;
                    bound.set(slot, Answer::Numbers(machine.regs[registers].concat()));
                }
            }
        }
        bound
    }
}
