//! Binding: defaults of parameters are computed once.

use super::super::bound::BoundShader;
use super::super::points::Points;
use super::super::scene::Scene;
use super::state::Machine;
use crate::ir::{Operand, Program};
use std::sync::Arc;

impl BoundShader {
    /// Bind a program: the values given, and for every other parameter its default, computed once in `scene`.
    pub fn new(
        program: Arc<Program>,
        numbers: Vec<(usize, Vec<f32>)>,
        texts: Vec<(usize, String)>,
        scene: &dyn Scene,
    ) -> BoundShader {
        let mut bound = BoundShader { program, numbers, texts };
        let points = Points { nu: 1, nv: 1, orientation: 1.0, ..Points::default() };
        let mut machine = Machine::new();
        machine.load(&bound, &points);
        for (_, reg) in &bound.program.globals {
            machine.regs[reg.index()] = vec![0.0; reg.width()];
        }
        machine.defaults(&bound, &points, scene);
        for (i, param) in bound.program.params.iter().enumerate() {
            match param.reg {
                // An array of strings keeps its defaults.
                Operand::Text(r) => {
                    if param.array.is_none() && !bound.texts.iter().any(|(k, _)| *k == i) {
                        bound.texts.push((i, machine.texts[r.index()].clone()));
                    }
                }
                Operand::Number(r) => {
                    if !bound.numbers.iter().any(|(k, _)| *k == i) {
                        let registers = r.index()..r.index() + param.array.unwrap_or(1) as usize;
                        bound.numbers.push((i, machine.regs[registers].concat()));
                    }
                }
            }
        }
        bound
    }
}
