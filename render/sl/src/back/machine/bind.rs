//! Binding: defaults of parameters are computed once.

use super::super::bound::BoundShader;
use super::super::points::Points;
use super::super::scene::Scene;
use super::state::Machine;
use crate::ir::{Kind, Program};
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
            machine.regs[*reg as usize] = vec![0.0; bound.program.widths[*reg as usize] as usize];
        }
        machine.defaults(&bound, &points, scene);
        for (i, param) in bound.program.params.iter().enumerate() {
            if param.kind == Kind::Text {
                // An array of strings keeps its defaults.
                if param.array.is_none() && !bound.texts.iter().any(|(k, _)| *k == i) {
                    bound.texts.push((i, machine.texts[param.reg as usize].clone()));
                }
            } else if !bound.numbers.iter().any(|(k, _)| *k == i) {
                let registers = param.reg as usize..(param.reg + param.array.unwrap_or(1)) as usize;
                bound.numbers.push((i, machine.regs[registers].concat()));
            }
        }
        bound
    }
}
