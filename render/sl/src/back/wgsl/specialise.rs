//! A program with its strings given: conditions on them are decided, and what is then never reached is dropped.

use super::super::bound::BoundShader;
use super::super::scene::Scene;
use super::registers::constants;
use super::texts::Texts;
use crate::ir::walk::blocks_mut;
use crate::ir::{Op, Program, optimise};
use std::collections::HashMap;

/// Rounds, since a condition that is decided may make strings known that stood under it.
const ROUNDS: usize = 2;

/// The program of a bound shader for the strings that are bound to it.
pub(super) fn specialised(shader: &BoundShader, scene: &dyn Scene) -> Program {
    let mut program = (*shader.program).clone();
    for _ in 0..ROUNDS {
        let constants = constants(&program);
        let mut texts = Texts::of(shader, &constants, scene);
        decide(&mut program.body, &mut texts, &constants, scene);
        optimise(&mut program);
    }
    program
}

/// Replace comparisons of known strings by their results.
fn decide(ops: &mut [Op], texts: &mut Texts, constants: &HashMap<usize, f32>, scene: &dyn Scene) {
    for op in ops {
        if let Some((dst, truth)) = texts.truth(op) {
            *op = Op::Const(dst.into(), truth as u8 as f32);
        }
        texts.step(op, constants, scene);
        match op {
            Op::If(_, then, otherwise) => {
                let mut after = texts.clone();
                decide(then, &mut after, constants, scene);
                decide(otherwise, texts, constants, scene);
                texts.merge(&after);
            }
            op => {
                let mut inner = blocks_mut(op);
                inner.iter().for_each(|block| texts.forget(block));
                inner.iter_mut().for_each(|block| decide(block, texts, constants, scene));
                inner.iter().for_each(|block| texts.forget(block));
            }
        }
    }
}
