//! The machine's registers, masks and open loops.

use super::super::points::Message;
use crate::ir::*;
use crate::shadeop::runs::run_of;
use std::sync::Arc;

/// The cone from which a surface takes light: only these points of the grid are lit.
pub(super) struct Receiver {
    pub(super) axis: Vec<f32>,
    /// Cosine of the cone's half angle; less than -1 for all directions.
    pub(super) cos: Vec<f32>,
}

/// What a light gave, kept for the grid: later loops over the same cone take it from here.
pub(super) struct Lit {
    pub(super) light: usize,
    pub(super) position: Vec<f32>,
    pub(super) axis: Vec<f32>,
    pub(super) angle: Vec<f32>,
    pub(super) asked: Option<Vec<bool>>,
    pub(super) on: Vec<bool>,
    pub(super) l: Vec<f32>,
    pub(super) cl: Vec<f32>,
    /// Ol, 1 where the light does not set it.
    pub(super) ol: Vec<f32>,
    /// Output parameters: index and values.
    pub(super) outputs: Vec<(usize, Vec<f32>)>,
}

/// What an index is of.
#[derive(PartialEq)]
pub(super) enum Indexed {
    Array,
    Components,
}

/// An index out of its range.
pub(super) struct Beyond {
    pub(super) what: Indexed,
    pub(super) index: f32,
    /// How many there are.
    pub(super) len: u16,
    /// The byte of the source.
    pub(super) place: u32,
}

impl Beyond {
    pub(super) fn of_array(index: f32, len: u16, place: u32) -> Beyond {
        Beyond { what: Indexed::Array, index, len, place }
    }
}

/// A loop that is run, or a function's body.
#[derive(Default)]
pub(super) struct LoopFrame {
    pub(super) left: Vec<bool>,
    pub(super) skipped: Vec<bool>,
    /// A function's body, which `return` leaves.
    pub(super) inline: bool,
}

/// The grid machine.
#[derive(Default)]
pub struct Machine {
    pub(super) n: usize,
    pub(super) nu: usize,
    pub(super) orientation: f32,
    /// What points stand for, as the grid says.
    pub(super) footprints: Vec<[f32; 3]>,
    /// The register of P, if the program reads it.
    pub(super) place: Option<Reg>,
    pub(super) regs: Vec<Vec<f32>>,
    pub(super) texts: Vec<String>,
    /// The name of the space of the shader that runs, if it has one of its own.
    pub(super) own_space: Option<Arc<str>>,
    /// Active points; `None` is all.
    pub(super) mask: Option<Vec<bool>>,
    pub(super) loops: Vec<LoopFrame>,
    /// What loops may still do in this run: turns over points.
    pub(super) turns_left: usize,
    /// Tells the turns of the loops around an operation apart; 0 outside of loops.
    pub(super) loop_turn: u32,
    /// Normals of the points, if a light asks for them.
    pub(super) normals: Vec<f32>,
    /// The points, and the normals on the side that is seen, if an ambient light asks where they are.
    pub(super) places: Vec<f32>,
    pub(super) facing: Vec<f32>,
    /// The first index of this run that was in no array, or of no component.
    pub(super) beyond: Option<Beyond>,
    /// Of the loops of this run that were cut, that which had the most turns: these, and the byte of the source.
    pub(super) endless: Option<(u32, u32)>,
    /// Where a string grew too long, as a byte of the source.
    pub(super) overlong: Option<u32>,
    /// What was asked of the scene in vain: the byte of the source, and what is said.
    pub(super) refused: Vec<(u32, String)>,
    /// What shaders that ran before tell this one.
    pub(super) messages: Vec<Message>,
    pub(super) receiver: Option<Receiver>,
    /// Points that `solar` or `illuminate` reached.
    pub(super) reached: Vec<bool>,
    pub(super) lit: Vec<Lit>,
    /// The light whose turn it is, and where in `lit` it is.
    pub(super) turn: Option<(usize, usize)>,
    /// In `solar` or `illuminate`: the register of the light's ray, and whether it is a sun's.
    pub(super) ray: Option<(TripleReg, bool)>,
    /// A machine for light shaders, made at need.
    pub(super) light_machine: Option<Box<Machine>>,
}

impl Machine {
    /// A machine with no memory allocated yet.
    pub fn new() -> Machine {
        Machine::default()
    }

    pub(super) fn all_off(&self) -> bool {
        self.mask.as_ref().is_some_and(|m| !m.contains(&true))
    }

    pub(super) fn assign(&mut self, dst: Reg, a: Reg) {
        let value = std::mem::take(&mut self.regs[a.index()]);
        if dst != a {
            let repeats = dst.width() / a.width();
            if repeats == 1 {
                self.assign_value(dst, &value);
            } else {
                let spread: Vec<f32> = (0..repeats).flat_map(|_| value.iter().copied()).collect();
                self.assign_value(dst, &spread);
            }
        }
        self.regs[a.index()] = value;
    }

    /// Assign where the points are active.
    pub(super) fn assign_value(&mut self, dst: impl Into<Reg>, value: &[f32]) {
        let dst = dst.into();
        let (n, width) = (self.n, dst.width());
        let out = &mut self.regs[dst.index()];
        let Some(mask) = &self.mask else {
            out.clear();
            out.extend_from_slice(value);
            return;
        };
        // What nobody has written yet has no value to keep at the other points.
        if out.is_empty() || (out.len() == width && out == value) {
            out.clear();
            out.extend_from_slice(value);
            return;
        }
        if out.len() == width && n > 1 {
            *out = out.iter().flat_map(|x| std::iter::repeat_n(*x, n)).collect();
        }
        for c in 0..width {
            let places = out[c * n..(c + 1) * n].iter_mut().zip(mask);
            match run_of(value, width, c, n) {
                [x] => places.for_each(|(o, m)| *o = if *m { *x } else { *o }),
                run => places.zip(run).for_each(|((o, m), x)| *o = if *m { *x } else { *o }),
            }
        }
    }

    /// Points that have left a loop, or its turn, stay inactive after the `if` in which they did.
    pub(super) fn drop_left(&mut self) {
        let Some(frame) = self.loops.last() else { return };
        if frame.left.contains(&true) || frame.skipped.contains(&true) {
            let active = |i: usize| self.mask.as_ref().is_none_or(|m| m[i]);
            self.mask = Some((0..self.n).map(|i| active(i) && !frame.left[i] && !frame.skipped[i]).collect());
        }
    }
}
