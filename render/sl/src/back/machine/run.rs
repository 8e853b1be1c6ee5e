//! A shader run over points: globals and parameters in, operations in turn, globals out.

use super::super::bound::{Answer, BoundShader};
use super::super::points::{Message, Points};
use super::super::scene::{Scene, unset};
use super::super::slots::VariableSlots;
use super::light::cosines;
use super::state::{Beyond, Indexed, LoopFrame, Machine};
use crate::ir::*;
use crate::shadeop::color::{SPACES, convert};
use crate::shadeop::format::LONGEST;
use crate::shadeop::matrix::triple16;
use crate::shadeop::runs::{dot, put, triple};
use crate::shadeop::spline;

/// What all loops of a run may do: turns over points. A shader whose loops do not end must not hang the render.
const MAX_TURNS: usize = 1 << 25;

impl Machine {
    /// Run a shader over points: reads the global variables that it uses and writes those that it changed.
    pub fn run(&mut self, shader: &BoundShader, points: &mut Points, scene: &dyn Scene) {
        self.run_with(shader, &VariableSlots::default(), points, scene);
    }

    /// Run a shader over points whose primitive variables, as assigned by `slots`, override the parameters of the same names.
    pub fn run_with(&mut self, shader: &BoundShader, slots: &VariableSlots, points: &mut Points, scene: &dyn Scene) {
        self.run_where(shader, slots, points, scene, None);
    }

    /// Run a shader over the points of a mask.
    pub(super) fn run_where(
        &mut self,
        shader: &BoundShader,
        slots: &VariableSlots,
        points: &mut Points,
        scene: &dyn Scene,
        mask: Option<Vec<bool>>,
    ) {
        let program = &*shader.program;
        self.load(shader, points);
        for (global, reg) in &program.globals {
            let width = reg.width();
            let reg = &mut self.regs[reg.index()];
            match points.get(*global) {
                Some(values) => reg.extend_from_slice(values),
                None => {
                    reg.extend(unset(*global, scene));
                    reg.resize(width, 0.0);
                }
            }
        }
        self.messages.clone_from(&points.messages);
        self.normals.clear();
        if scene.lights().iter().any(|light| light.program.global(Global::Ns).is_some()) {
            self.normals.extend_from_slice(points.get(Global::N).unwrap_or(&[]));
        }
        self.note_places(points, scene);
        self.defaults(shader, slots, points, scene);
        self.mask = mask;
        self.block(&program.body, scene);
        self.mask = None;
        self.say_faults(program, scene);
        for (global, reg) in &program.globals {
            if let Some(values) = points.get_mut(*global) {
                std::mem::swap(values, &mut self.regs[reg.index()]);
            }
        }
    }

    /// Say what went wrong in a run: loops that do not end, an index out of its range, what the scene has not.
    pub(super) fn say_faults(&mut self, program: &Program, scene: &dyn Scene) {
        if let Some((_, place)) = self.endless.take() {
            scene.stop(&format!("the loops of the shader `{}` do not end, in {}", program.name, program.place(place)));
        }
        if let Some(place) = self.overlong.take() {
            let (name, place) = (&program.name, program.place(place));
            scene.stop(&format!("a string of the shader `{name}` grows beyond 64 KiB, in {place}"));
        }
        for (place, message) in std::mem::take(&mut self.refused) {
            scene.warn(program.placed(place, &message));
        }
        if let Some(Beyond { what, index, len, place }) = self.beyond.take() {
            let (most, place, name) = (len - 1, program.place(place), &program.name);
            let what = if what == Indexed::Array {
                format!("element {index} of an array")
            } else {
                format!("component {index}")
            };
            let message = format!(
                "{place}: the shader `{name}` uses {what}, expected 0 to {most}: it is read as 0 and not written"
            );
            scene.outside(place, index, message);
        }
    }

    /// Where the points are and how their surface is turned, if an ambient light asks for that.
    fn note_places(&mut self, points: &Points, scene: &dyn Scene) {
        self.places.clear();
        self.facing.clear();
        let asks = |light: &BoundShader| {
            light.program.is_ambient && [Global::Ps, Global::Ns].iter().any(|g| light.program.global(*g).is_some())
        };
        if !scene.lights().iter().any(|light| asks(light)) {
            return;
        }
        let of = |global| points.get(global).unwrap_or(&[]);
        let (p, normals, incident) = (of(Global::P), of(Global::N), of(Global::I));
        self.places.extend_from_slice(p);
        self.facing.resize(3 * self.n, 0.0);
        if normals.len() < 3 {
            return;
        }
        for k in 0..self.n {
            let normal = triple(normals, k, self.n);
            let away = incident.len() >= 3 && dot(normal, triple(incident, k, self.n)) > 0.0;
            put(&mut self.facing, k, self.n, if away { normal.map(|x| -x) } else { normal });
        }
    }

    /// The values of an output parameter of `shader`, which must be the one that ran last: one value, or one per point, a triple as
    /// three runs.
    pub fn output(&self, shader: &BoundShader, name: &str) -> Option<&[f32]> {
        match shader.program.params.iter().find(|p| p.output && p.name == name)?.reg {
            Operand::Number(r) => Some(&self.regs[r.index()]),
            Operand::Text(_) => None,
        }
    }

    /// Add the output parameters of `shader`, which must be the one that ran last, to what is told to those that run over the
    /// points after it.
    pub fn tell(&self, from: Ask, shader: &BoundShader, points: &mut Points) {
        for param in shader.program.params.iter().filter(|p| p.output && p.array.is_none()) {
            if let Operand::Number(r) = param.reg {
                let (name, values) = (param.name.clone(), self.regs[r.index()].clone());
                points.messages.push(Message { from, name, values });
            }
        }
    }

    pub(super) fn load(&mut self, shader: &BoundShader, points: &Points) {
        let program = &*shader.program;
        self.n = points.n();
        self.nu = points.nu;
        self.orientation = points.orientation;
        self.footprints.clone_from(&points.footprints);
        self.place = program.global(Global::P);
        self.own_space = shader.own_space();
        self.mask = None;
        self.loops.clear();
        self.turns_left = MAX_TURNS;
        self.loop_turn = 0;
        self.lit.clear();
        self.reached.clear();
        self.reached.resize(self.n, false);
        // Nothing of the last grid is left, whose points were others, where a value might be kept.
        if self.regs.len() < program.widths.len() {
            self.regs.resize_with(program.widths.len(), Vec::new);
        }
        program.variables.iter().for_each(|k| self.regs[*k as usize].clear());
        if self.texts.len() < program.n_texts {
            self.texts.resize(program.n_texts, String::new());
        }
    }

    /// Parameters: a primitive variable, else what was given, else the default.
    pub(super) fn defaults(&mut self, shader: &BoundShader, slots: &VariableSlots, points: &Points, scene: &dyn Scene) {
        let program = &*shader.program;
        for (slot, param) in program.params.iter().enumerate() {
            let own = shader.value(slot);
            let register = match (param.reg, own) {
                (Operand::Number(r), _) => r,
                (Operand::Text(r), Some(Answer::Text(text))) => {
                    self.texts[r.index()].clone_from(text);
                    continue;
                }
                (Operand::Text(r), Some(Answer::Texts(texts))) => {
                    self.texts[r.index()..][..texts.len()].clone_from_slice(texts);
                    continue;
                }
                (Operand::Text(_), _) => {
                    self.block(&param.default, scene);
                    continue;
                }
            };
            let given = slots.of_parameter(slot).and_then(|k| points.variable(k));
            let own = own.and_then(|own| if let Answer::Numbers(v) = own { Some(v.as_slice()) } else { None });
            match given.or(own) {
                Some(values) => {
                    let len = param.array.unwrap_or(1) as usize;
                    let each = values.len() / len;
                    for (k, value) in values.chunks_exact(each.max(1)).take(len).enumerate() {
                        let reg = &mut self.regs[register.index() + k];
                        reg.clear();
                        reg.extend_from_slice(value);
                    }
                }
                None => self.block(&param.default, scene),
            }
        }
    }

    pub(super) fn block(&mut self, ops: &[Op], scene: &dyn Scene) {
        let mut is_off = self.all_off();
        for op in ops {
            if is_off {
                return;
            }
            // Operations on numbers are the most, and turn no point off.
            if !self.number(op) {
                self.op(op, scene);
                is_off = self.all_off();
            }
        }
    }

    /// Run an operation. Long, because it has an arm for each but those on numbers.
    pub(super) fn op(&mut self, op: &Op, scene: &dyn Scene) {
        match op {
            Op::TextConst(dst, text) => self.texts[dst.index()].clone_from(text),
            Op::TextCopy(dst, a) => self.texts[dst.index()] = self.texts[a.index()].clone(),
            Op::TextEqual(dst, a, b) => {
                let same = self.texts[a.index()] == self.texts[b.index()];
                self.regs[dst.index()] = vec![same as u8 as f32];
            }
            Op::Const(..)
            | Op::Unary(..)
            | Op::Binary(..)
            | Op::Select(..)
            | Op::Pack(..)
            | Op::Component(..)
            | Op::Assign(..) => _ = self.number(op),
            Op::Call(f, dst, args) => {
                self.call(*f, *dst, args, scene);
            }
            Op::Within(index, len, place) => self.note_index(*index, *len, *place),
            Op::Load(dst, first, len, index, place) => self.load_element(*dst, *first, *len, *index, *place),
            Op::Store(first, len, index, value, place) => self.store_element(*first, *len, *index, *value, *place),
            Op::TextLoad(dst, first, len, index, place) => {
                let k = self.text_element(*index, *len, *place);
                self.texts[dst.index()] = k.map_or(String::new(), |k| self.texts[first.index() + k].clone());
            }
            Op::TextStore(first, len, index, value, place) => {
                if let Some(k) = self.text_element(*index, *len, *place) {
                    self.texts[first.index() + k] = self.texts[value.index()].clone();
                }
            }
            Op::ColorSpace(dst, a, from, to, place) => {
                let (from, to) = (self.texts[from.index()].clone(), self.texts[to.index()].clone());
                if let Some(lost) = [&from, &to].into_iter().find(|space| !SPACES.contains(&space.as_str())) {
                    let known = SPACES.join(", ");
                    let message = format!("unknown colour space `{lost}`, expected one of {known}: it counts as rgb");
                    self.refuse(*place, message);
                }
                self.evaluate((*dst).into(), &[(*a).into()], |call, out| {
                    call.pointwise(out, |v| triple16(convert(&from, &to, [v[0][0], v[0][1], v[0][2]])))
                });
            }
            Op::Spline(dst, basis, args) => {
                let basis = self.texts[basis.index()].clone();
                let w = dst.width();
                self.evaluate(*dst, args, |call, out| {
                    call.pointwise(out, |v| spline::value(&basis, v[0][0], &v[1..], w))
                });
            }
            Op::Match(dst, pattern, text) => {
                let found = crate::shadeop::format::matches(&self.texts[pattern.index()], &self.texts[text.index()]);
                self.regs[dst.index()] = vec![found as u8 as f32];
            }
            Op::Format(dst, args, place) => {
                let k = self.mask.as_ref().and_then(|m| m.iter().position(|m| *m)).unwrap_or(0);
                let text = self.format(args, k);
                // It is cut at the end of a character, of four bytes at most.
                if text.len() + 4 > LONGEST {
                    self.overlong = self.overlong.or(Some(*place));
                }
                self.texts[dst.index()] = text;
            }
            Op::Print(args) => {
                let varies = |o: &Operand| matches!(o, Operand::Number(r) if self.regs[r.index()].len() != r.width());
                let lanes = if args.iter().any(varies) { self.n } else { 1 };
                for k in (0..lanes).filter(|k| lanes == 1 || self.mask.as_ref().is_none_or(|m| m[*k])) {
                    scene.print(&self.format(args, k));
                }
            }
            Op::Ask { dst, what, names, out, len, place } => self.ask(*dst, *what, names, (*out, *len), *place, scene),
            Op::Map { .. } => self.map(op, scene),
            Op::Transform(how, dst, a, from, to, place) => {
                self.transform(*how, (*dst, *a), [*from, *to], *place, scene)
            }
            Op::If(c, then, otherwise) => self.branch(*c, then, otherwise, scene),
            Op::Loop(head, c, body, step, place) => self.repeat(head, *c, body, step, *place, scene),
            Op::Break(levels) => self.leave(*levels as usize, true),
            Op::Continue(levels) => self.leave(*levels as usize, false),
            Op::Inline(body) => {
                let outer = self.mask.clone();
                self.loops.push(LoopFrame { left: vec![false; self.n], skipped: vec![false; self.n], inline: true });
                self.block(body, scene);
                self.loops.pop();
                self.mask = outer;
            }
            Op::Return => {
                let inner = self.loops.iter().rev().position(|f| f.inline).map_or(self.loops.len(), |k| k + 1);
                self.leave(inner, true);
            }
            Op::Gather { .. } => self.gather(op, scene),
            Op::Illuminance { .. } => self.illuminance(op, scene),
            Op::Solar { axis, l, body, .. } => {
                // The axis is the way that light travels.
                let axis = self.regs[axis.index()].clone();
                self.assign_value(*l, &axis);
                self.ray = Some((*l, true));
                self.light_body(*l, None, body, scene);
                self.ray = None;
            }
            Op::Illuminate { position, axis, angle, l, ps, body } => {
                self.binary(Binary::Sub, (*l).into(), (*ps).into(), (*position).into());
                let cone = (self.regs[axis.index()].clone(), cosines(&self.regs[angle.index()]));
                self.ray = Some((*l, false));
                self.light_body(*l, Some(cone), body, scene);
                self.ray = None;
            }
        }
    }
}
