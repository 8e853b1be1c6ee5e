//! Control flow: as WGSL's own where a point runs alone; by masks where the points of a grid run together, because values of
//! neighbours are wanted within.

use super::writer::{Done, Frame, Leaves, Writer};
use crate::ir::walk::{blocks, visit};
use crate::ir::{FloatReg, Op, builtins::How, builtins::SceneCall};
use std::collections::BTreeSet;

impl Writer<'_, '_> {
    /// Whether all points of a grid must run an operation together: it or one within it looks at neighbours, or leaves a loop that they
    /// run together.
    pub fn is_together(&self, op: &Op) -> bool {
        let mut found = self.leaves_together(op, 0);
        let light = self.module.has_grid_light();
        visit(std::slice::from_ref(op), &mut |op| {
            found |= match op {
                Op::Call(f, ..) => {
                    f.row().neighbours || (light && matches!(f.row().how, How::Scene(SceneCall::Ambient)))
                }
                Op::Illuminance { .. } => light,
                // The filter's area follows from the neighbours.
                Op::Map { .. } => true,
                _ => false,
            }
        });
        found
    }

    /// Whether an operation, within this count of inner loops, leaves a loop or function that all points run together.
    fn leaves_together(&self, op: &Op, inner: usize) -> bool {
        let mut open = self.frames.iter().rev().filter(|f| f.leaves == Leaves::Loop);
        let mut functions = self.frames.iter().rev().filter(|f| f.leaves == Leaves::Function);
        match op {
            Op::Break(n) | Op::Continue(n) => {
                (*n as usize).checked_sub(inner + 1).and_then(|k| open.nth(k)).is_some_and(|f| f.grid)
            }
            Op::Return => functions.next().is_some_and(|f| f.grid),
            // What it leaves is within it.
            Op::Inline(_) => false,
            _ => {
                let inner = inner + matches!(op, Op::Loop(..)) as usize;
                blocks(op).into_iter().flatten().any(|op| self.leaves_together(op, inner))
            }
        }
    }

    /// Write an operation with blocks: by masks if all points run it together, else by WGSL's own control flow.
    pub fn alone(&mut self, together: bool, write: impl FnOnce(&mut Self) -> Done) -> Done {
        if !self.grid || together {
            return write(self);
        }
        self.grid = false;
        self.open("if on");
        let done = write(self);
        self.close();
        self.grid = true;
        done
    }

    /// Write a condition, a loop or a function's body.
    pub fn control(&mut self, op: &Op) -> Done {
        let together = self.grid && self.is_together(op);
        match op {
            Op::If(c, then, otherwise) => self.branch(together, *c, then, otherwise),
            Op::Loop(head, c, body, step, place) => self.repeat(together, [head, body, step], *c, *place),
            Op::Inline(body) => self.inline(together, body),
            _ => Ok(()),
        }
    }

    fn branch(&mut self, together: bool, c: FloatReg, then: &[Op], otherwise: &[Op]) -> Done {
        if let Some(c) = self.registers.constant(c) {
            self.open("");
            self.block(if c != 0.0 { then } else { otherwise })?;
            self.close();
            return Ok(());
        }
        self.alone(together, |w| {
            if together { w.branch_by_masks(c, then, otherwise) } else { w.plain_branch(c, then, otherwise) }
        })
    }

    fn plain_branch(&mut self, c: FloatReg, then: &[Op], otherwise: &[Op]) -> Done {
        let c = self.registers.value(c);
        let before = self.texts.clone();
        self.open(format!("if {c} != 0.0"));
        self.block(then)?;
        let after = std::mem::replace(&mut self.texts, before);
        if !otherwise.is_empty() {
            self.between("else");
            self.block(otherwise)?;
        }
        self.close();
        self.texts.merge(&after);
        Ok(())
    }

    fn branch_by_masks(&mut self, c: FloatReg, then: &[Op], otherwise: &[Op]) -> Done {
        let (c, id) = (self.registers.value(c), self.fresh());
        self.line(format!("let outer_{id} = on;"));
        self.line(format!("let taken_{id} = {c} != 0.0;"));
        let before = self.texts.clone();
        let mut after = self.texts.clone();
        self.masks += 1;
        for (ops, wanted) in [(then, "taken"), (otherwise, "!taken")] {
            if !ops.is_empty() {
                self.texts = before.clone();
                self.line(format!("on = outer_{id} && {wanted}_{id};"));
                self.open("if sl_any(on)");
                self.block(ops)?;
                self.close();
            }
            if wanted == "taken" {
                after = self.texts.clone();
                self.texts = before.clone();
            }
        }
        self.masks -= 1;
        self.texts.merge(&after);
        let gone = self.gone();
        self.line(format!("on = outer_{id}{gone};"));
        Ok(())
    }

    /// That a point has not left the innermost loop or function, or its turn, as a part of a condition.
    pub fn gone(&self) -> String {
        let frame = self.frames.iter().rev().find(|f| f.leaves != Leaves::Lights);
        frame.map_or(String::new(), |f| format!(" && !left_{0} && !skipped_{0}", f.id))
    }

    /// Begin a loop, with what says who has left it.
    pub fn enter(&mut self, leaves: Leaves) -> usize {
        let id = self.fresh();
        if leaves != Leaves::Lights {
            if self.grid {
                self.variable(&format!("left_{id}"), "bool");
                self.variable(&format!("skipped_{id}"), "bool");
                self.line(format!("left_{id} = false;"));
                self.line(format!("skipped_{id} = false;"));
            } else {
                self.variable(&format!("exit_{id}"), "u32");
                self.line(format!("exit_{id} = 0u;"));
            }
        }
        self.frames.push(Frame { id, leaves, grid: self.grid, exits: BTreeSet::new() });
        id
    }

    /// After a loop's end: leave those around it that were left from within.
    pub fn exit(&mut self) {
        let inner = self.frames.pop().expect("a loop is open");
        if inner.grid {
            return;
        }
        for target in inner.exits {
            let Some(outer) = self.frames.last_mut().filter(|f| !f.grid) else { continue };
            let (is_target, is_loop) = (outer.id == target, outer.leaves == Leaves::Loop);
            if !is_target {
                outer.exits.insert(target);
                self.line(format!("if exit_{target} != 0u {{ break; }}"));
                continue;
            }
            self.line(format!("if exit_{target} == 1u {{ break; }}"));
            if is_loop {
                self.open(format!("if exit_{target} == 2u"));
                self.line(format!("exit_{target} = 0u;"));
                self.line("continue;");
                self.close();
            }
        }
    }

    /// `break` out of `levels` loops, or `continue` the last of them.
    pub fn leave(&mut self, levels: usize, for_good: bool) -> Done {
        let open = (0..self.frames.len()).rev().filter(|k| self.frames[*k].leaves == Leaves::Loop);
        let Some(target) = open.clone().nth(levels - 1) else { return self.refuse("leaves a loop that it is not in") };
        self.leave_frame(target, for_good)
    }

    pub fn leave_function(&mut self) -> Done {
        let Some(target) = self.frames.iter().rposition(|f| f.leaves == Leaves::Function) else {
            return self.refuse("returns from no function");
        };
        self.leave_frame(target, true)
    }

    fn leave_frame(&mut self, target: usize, for_good: bool) -> Done {
        if self.frames[target].grid {
            for k in target..self.frames.len() {
                let frame = &self.frames[k];
                if frame.leaves != Leaves::Lights {
                    let gone = if for_good || k > target { "left" } else { "skipped" };
                    let line = format!("{gone}_{0} = {gone}_{0} || on;", frame.id);
                    self.line(line);
                }
            }
            self.line("on = false;");
            return Ok(());
        }
        if target + 1 == self.frames.len() {
            self.line(if for_good { "break;" } else { "continue;" });
            return Ok(());
        }
        let id = self.frames[target].id;
        self.frames.last_mut().expect("a loop is open").exits.insert(id);
        self.line(format!("exit_{id} = {}u;", if for_good { 1 } else { 2 }));
        self.line("break;");
        Ok(())
    }

    fn repeat(&mut self, together: bool, blocks: [&[Op]; 3], c: FloatReg, place: u32) -> Done {
        blocks.iter().for_each(|block| self.texts.forget(block));
        self.alone(together, |w| {
            let turn = w.begin_turns();
            let id = w.enter(Leaves::Loop);
            if together {
                w.loop_by_masks(id, turn, blocks, c, place)?;
            } else {
                w.plain_loop(turn, blocks, c, place)?;
            }
            w.end_turns(turn);
            w.exit();
            if together {
                let gone = w.gone();
                w.line(format!("on = outer_{id}{gone};"));
            }
            Ok(())
        })?;
        blocks.iter().for_each(|block| self.texts.forget(block));
        Ok(())
    }

    fn plain_loop(&mut self, turn: Option<usize>, [head, body, step]: [&[Op]; 3], c: FloatReg, place: u32) -> Done {
        self.open("loop");
        self.next_turn(turn);
        self.line(format!("if !sl_turn_is_left({}u, {place}u) {{ break; }}", self.index));
        self.block(head)?;
        let c = self.registers.value(c);
        self.line(format!("if {c} == 0.0 {{ break; }}"));
        self.block(body)?;
        if !step.is_empty() {
            self.open("continuing");
            self.block(step)?;
            self.close();
        }
        self.close();
        Ok(())
    }

    fn loop_by_masks(
        &mut self,
        id: usize,
        turn: Option<usize>,
        [head, body, step]: [&[Op]; 3],
        c: FloatReg,
        place: u32,
    ) -> Done {
        self.line(format!("let outer_{id} = on;"));
        self.masks += 1;
        self.open("loop");
        self.next_turn(turn);
        self.line(format!("on = on && sl_turn_is_left({}u, {place}u);", self.index));
        self.block(head)?;
        let c = self.registers.value(c);
        self.line(format!("on = on && {c} != 0.0;"));
        self.line("if !sl_any(on) { break; }");
        self.line(format!("let turn_{id} = on;"));
        self.block(body)?;
        self.line(format!("skipped_{id} = false;"));
        self.line(format!("on = turn_{id} && !left_{id};"));
        self.block(step)?;
        self.close();
        self.masks -= 1;
        Ok(())
    }

    fn inline(&mut self, together: bool, body: &[Op]) -> Done {
        self.alone(together, |w| {
            let id = w.enter(Leaves::Function);
            if together {
                w.line(format!("let outer_{id} = on;"));
                w.masks += 1;
                w.block(body)?;
                w.masks -= 1;
                w.line(format!("on = outer_{id};"));
            } else {
                w.open("loop");
                if !w.block(body)? {
                    w.line("break;");
                }
                w.close();
            }
            w.exit();
            Ok(())
        })?;
        self.texts.forget(body);
        Ok(())
    }

    /// Before a loop: what tells its turns apart.
    pub fn begin_turns(&mut self) -> Option<usize> {
        if !self.counts_turns {
            return None;
        }
        let id = self.fresh();
        self.line(format!("let outer_turn_{id} = turn;"));
        self.line(format!("var turns_{id} = 0u;"));
        Some(id)
    }

    fn next_turn(&mut self, turn: Option<usize>) {
        if let Some(id) = turn {
            self.line(format!("turns_{id} += 1u;"));
            self.line(format!("turn = sl_turn(outer_turn_{id}, turns_{id});"));
        }
    }

    pub fn end_turns(&mut self, turn: Option<usize>) {
        if let Some(id) = turn {
            self.line(format!("turn = outer_turn_{id};"));
        }
    }
}
