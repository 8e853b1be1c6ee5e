//! Calls of shading functions: by their evaluators, or by what the scene answers.

use super::super::scene::Scene;
use super::state::Machine;
use crate::ir::builtins::How;
use crate::ir::*;
use crate::shadeop::call::{Call, Values};

/// Arguments that need no memory of their own.
const FEW: usize = 4;

impl Machine {
    pub(super) fn call(&mut self, f: Builtin, dst: Reg, args: &[Reg], scene: &dyn Scene) {
        match f.row().how {
            How::Grid(evaluator) => self.evaluate(dst, args, evaluator),
            How::Scene(call) => self.scene_call(call, dst, args, scene),
            // These are operations of their own, or have become other functions.
            How::Unary(_) | How::Binary(_) | How::Component(_) | How::Form(_) | How::Prelude(..) => {
                unreachable!("{} is not called", f.row().ir)
            }
        }
    }

    /// Compute a register from others by an evaluator.
    pub(super) fn evaluate(&mut self, dst: Reg, args: &[Reg], evaluator: impl FnOnce(&Call<'_>, &mut Vec<f32>)) {
        let mut out = std::mem::take(&mut self.regs[dst.index()]);
        out.clear();
        let values = |r: Reg| Values { v: &self.regs[r.index()], width: r.width() };
        let (mut few, many) = ([Values::default(); FEW], &mut Vec::new());
        let values = if args.len() <= FEW {
            few.iter_mut().zip(args).for_each(|(value, r)| *value = values(*r));
            &few[..args.len()]
        } else {
            many.extend(args.iter().map(|r| values(*r)));
            &many[..]
        };
        let call = Call {
            n: self.n,
            nu: self.nu,
            orientation: self.orientation,
            footprints: &self.footprints,
            mask: self.mask.as_deref(),
            place: self.place.map(|p| &self.regs[p.index()][..]),
            turn: self.loop_turn,
            args: values,
            width: dst.width(),
        };
        evaluator(&call, &mut out);
        self.regs[dst.index()] = out;
    }
}
