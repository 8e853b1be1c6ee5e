//! Conditions and loops, by masks.

use super::super::scene::Scene;
use super::state::LoopFrame;
use super::state::Machine;
use crate::ir::*;

/// Tells the turn of a loop, and that of those around it, apart from others.
pub(super) fn turn_of(outer: u32, turn: u32) -> u32 {
    (outer ^ turn).wrapping_mul(0xc2b2_ae35).rotate_left(13).wrapping_add(turn)
}

impl Machine {
    pub(super) fn branch(&mut self, c: FloatReg, then: &[Op], otherwise: &[Op], scene: &dyn Scene) {
        if self.regs[c.index()].len() == 1 {
            let taken = if self.regs[c.index()][0] != 0.0 { then } else { otherwise };
            return self.block(taken, scene);
        }
        let c = self.regs[c.index()].clone();
        let outer = self.mask.take();
        for (ops, wanted) in [(then, true), (otherwise, false)] {
            if !ops.is_empty() {
                let holds = c.iter().map(|c| (*c != 0.0) == wanted);
                self.mask = Some(match &outer {
                    Some(outer) => outer.iter().zip(holds).map(|(on, holds)| on & holds).collect(),
                    None => holds.collect(),
                });
                self.block(ops, scene);
            }
        }
        self.mask = outer;
        self.drop_left();
    }

    /// `break` out of `levels` loops, or `continue` the last of them.
    pub(super) fn leave(&mut self, levels: usize, for_good: bool) {
        let n = self.n;
        let mask = self.mask.take().unwrap_or_else(|| vec![true; n]);
        for (k, frame) in self.loops.iter_mut().rev().take(levels).enumerate() {
            let gone = if for_good || k + 1 < levels { &mut frame.left } else { &mut frame.skipped };
            gone.iter_mut().zip(&mask).for_each(|(g, m)| *g |= m);
        }
        self.mask = Some(vec![false; n]);
    }

    pub(super) fn repeat(&mut self, head: &[Op], c: FloatReg, body: &[Op], step: &[Op], place: u32, scene: &dyn Scene) {
        /// Points that a turn counts for at least.
        const LEAST: usize = 128;
        let n = self.n;
        if scene.is_stopped() {
            return;
        }
        let outer = self.mask.clone();
        self.loops.push(LoopFrame { left: vec![false; n], skipped: vec![false; n], inline: false });
        let outer_turn = self.loop_turn;
        let mut turns = 0u32;
        loop {
            turns = turns.wrapping_add(1);
            self.loop_turn = turn_of(outer_turn, turns);
            self.turns_left = self.turns_left.saturating_sub(n.max(LEAST));
            if self.turns_left == 0 {
                self.endless = self.endless.max(Some((turns, place)));
                break;
            }
            self.block(head, scene);
            let condition = &self.regs[c.index()];
            if condition.len() == 1 {
                if condition[0] == 0.0 {
                    break;
                }
            } else {
                let active = |i: usize| self.mask.as_ref().is_none_or(|m| m[i]);
                self.mask = Some((0..n).map(|i| active(i) && condition[i] != 0.0).collect());
            }
            if self.all_off() {
                break;
            }
            let turn = self.mask.clone();
            self.block(body, scene);
            // Those that went on to the step are active again; those that left are not.
            let frame = self.loops.last_mut().expect("a loop is open");
            frame.skipped.fill(false);
            self.mask = turn;
            self.drop_left();
            self.block(step, scene);
        }
        self.loop_turn = outer_turn;
        self.loops.pop();
        self.mask = outer;
        // Who left a loop further out, or the function, within this one.
        self.drop_left();
    }
}
