//! The grid machine: runs a program over a whole grid of points, an operation at a time.
//!
//! A register holds one value (uniform) or one a point (varying), a triple as three runs: all x, all y, all z. Temporaries are
//! computed at every point; only assignments to variables look at which points are active, and costly calls skip the others.
//! One machine serves one thread and is used again for grid after grid, so that its memory is taken once.

use crate::ir::*;
use crate::lanes::{at, cross, dot, power, put, refract, run_of, triple, triples2, zip};
use crate::noise::{cell_noise, noise, noise4, periodic_noise};
use std::sync::Arc;

/// A shader with its parameters given.
#[derive(Clone, Debug)]
pub struct BoundShader {
    /// The program.
    pub program: Arc<Program>,
    /// Values given for parameters, by their index; numbers in the current space.
    pub numbers: Vec<(usize, Vec<f32>)>,
    /// Strings given for parameters, by their index.
    pub texts: Vec<(usize, String)>,
}

impl BoundShader {
    /// The values of a parameter, by its name: of the whole shader, not of a point.
    pub fn parameter(&self, name: &str) -> Option<Answer> {
        let i = self.program.params.iter().position(|p| p.name == name)?;
        let number = self.numbers.iter().find(|(k, _)| *k == i).map(|(_, v)| Answer::Numbers(v.clone()));
        number.or_else(|| self.texts.iter().find(|(k, _)| *k == i).map(|(_, t)| Answer::Text(t.clone())))
    }

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

/// What a shader asks of the scene around the grid.
pub trait Scene {
    /// The lights that shine on the grid.
    fn lights(&self) -> &[Arc<BoundShader>];
    /// The matrix from one named space to another, 16 numbers column after column for column vectors.
    fn matrix(&self, from: &str, to: &str) -> Option<[f32; 16]>;
    /// How much light gets from one point to another: 1 all, 0 none.
    fn transmission(&self, from: [f32; 3], to: [f32; 3]) -> [f32; 3];
    /// Where on an area light its light of a number in [`Scene::lights`] is, for `n` places that it lights.
    fn emitter(&self, _light: usize, _n: usize, _place: &dyn Fn(usize) -> [f32; 3]) -> Option<Emitter> {
        None
    }
    /// What the scene knows under some names.
    fn ask(&self, _what: Ask, _names: &[&str]) -> Option<Answer> {
        None
    }
    /// Four channels of a map.
    fn map(&self, _query: &MapQuery) -> [f32; 4] {
        [0.0; 4]
    }
    /// How far along a direction (of unit length) the nearest surface is.
    fn hit(&self, _from: [f32; 3], _direction: [f32; 3]) -> Option<f32> {
        None
    }
    /// Whether rays from here are followed at all: not where they have come too deep.
    fn traces(&self, _many: bool) -> bool {
        false
    }
    /// The colour that a ray brings back; `many` says that it is one of many from its point, as for light from all around.
    fn trace(&self, _from: [f32; 3], _direction: [f32; 3], _many: bool) -> [f32; 3] {
        [0.0; 3]
    }
    /// Take what `printf` prints.
    fn print(&self, text: &str) {
        eprint!("{text}");
    }
}

/// Points of an area light, one for each place that it lights.
pub struct Emitter {
    /// The points, as three runs.
    pub points: Vec<f32>,
    /// The normals there, likewise.
    pub normals: Vec<f32>,
    /// The part of the light that they stand for.
    pub part: f32,
}

/// A scene of lights alone: every space is the world, nothing is in the way, and what is printed is dropped.
pub struct Lights(pub Vec<Arc<BoundShader>>);

impl Scene for Lights {
    fn lights(&self) -> &[Arc<BoundShader>] {
        &self.0
    }
    fn matrix(&self, _: &str, _: &str) -> Option<[f32; 16]> {
        None
    }
    fn transmission(&self, _: [f32; 3], _: [f32; 3]) -> [f32; 3] {
        [1.0; 3]
    }
    fn print(&self, _: &str) {}
}

/// An answer of the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// Numbers, in the current space.
    Numbers(Vec<f32>),
    /// Text.
    Text(String),
}

/// A question for a map.
#[derive(Clone, Debug)]
pub struct MapQuery<'a> {
    /// How it is looked up.
    pub how: Lookup,
    /// Its name.
    pub name: &'a str,
    /// The first channel.
    pub channel: usize,
    /// s and t, a direction, or a place.
    pub at: [f32; 3],
    /// How that changes to the next point of the grid, along its rows and its columns.
    pub change: [[f32; 3]; 2],
    /// Factor of the filter's width.
    pub width: f32,
    /// Blur, a part of the whole map.
    pub blur: f32,
    /// Samples, where the map is sampled.
    pub samples: f32,
    /// Bias of a shadow map.
    pub bias: f32,
    /// In a light shader: where the light comes from.
    pub light: Option<[f32; 3]>,
}

/// The points to be shaded: `n = nu · nv`, in rows of `nu`.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// Points in a row.
    pub nu: usize,
    /// Rows.
    pub nv: usize,
    /// 1, or −1 where the rows' cross product points into the surface.
    pub orientation: f32,
    /// Globals: name and values, one or one a point, a triple as three runs.
    pub globals: Vec<(&'static str, Vec<f32>)>,
    /// Primitive variables, which go before parameters of the same name.
    pub inputs: Vec<(String, Vec<f32>)>,
}

impl Points {
    /// Number of points.
    pub fn n(&self) -> usize {
        self.nu * self.nv
    }

    /// A global's values.
    pub fn get(&self, name: &str) -> Option<&[f32]> {
        self.globals.iter().find(|(n, _)| *n == name).map(|(_, v)| v.as_slice())
    }

    /// A global's buffer, emptied, for new values.
    pub fn refill(&mut self, name: &'static str) -> &mut Vec<f32> {
        let i = self.globals.iter().position(|(n, _)| *n == name).unwrap_or_else(|| {
            self.globals.push((name, Vec::new()));
            self.globals.len() - 1
        });
        let buffer = &mut self.globals[i].1;
        buffer.clear();
        buffer
    }
}

/// The cone from which a surface takes light: only these points of the grid are lit.
struct Receiver {
    axis: Vec<f32>,
    cos: f32,
}

/// What a light gave, kept for the grid: later loops over the same cone take it from here.
struct Lit {
    light: usize,
    position: Vec<f32>,
    axis: Vec<f32>,
    angle: f32,
    asked: Option<Vec<bool>>,
    on: Vec<bool>,
    l: Vec<f32>,
    cl: Vec<f32>,
    /// Output parameters: index and values.
    outputs: Vec<(usize, Vec<f32>)>,
}

/// A loop that is run, or a function's body.
#[derive(Default)]
struct LoopFrame {
    left: Vec<bool>,
    skipped: Vec<bool>,
    /// A function's body, which `return` leaves.
    inline: bool,
}

/// Runs programs. See the module's head.
#[derive(Default)]
pub struct Machine {
    n: usize,
    nu: usize,
    orientation: f32,
    regs: Vec<Vec<f32>>,
    texts: Vec<String>,
    /// Active points; `None` is all.
    mask: Option<Vec<bool>>,
    loops: Vec<LoopFrame>,
    receiver: Option<Receiver>,
    /// Points that `solar` or `illuminate` reached.
    reached: Vec<bool>,
    lit: Vec<Lit>,
    /// The light whose turn it is, and where in `lit` it is.
    turn: Option<(usize, usize)>,
    /// In `solar` or `illuminate`: the register of the light's ray, and whether it is a sun's.
    ray: Option<(Reg, bool)>,
    /// A machine for light shaders, made at need.
    light_machine: Option<Box<Machine>>,
}

impl Machine {
    /// A machine.
    pub fn new() -> Machine {
        Machine::default()
    }

    /// Run a shader over points: reads the globals that it uses, writes back those that it changed.
    pub fn run(&mut self, shader: &BoundShader, points: &mut Points, scene: &dyn Scene) {
        self.run_where(shader, points, scene, None);
    }

    /// Run a shader over the points of a mask.
    fn run_where(&mut self, shader: &BoundShader, points: &mut Points, scene: &dyn Scene, mask: Option<Vec<bool>>) {
        let program = &*shader.program;
        self.load(shader, points);
        for (name, reg) in &program.globals {
            let width = program.widths[*reg as usize] as usize;
            let reg = &mut self.regs[*reg as usize];
            match points.get(name) {
                Some(values) => reg.extend_from_slice(values),
                None => reg.resize(width, 0.0),
            }
        }
        self.defaults(shader, points, scene);
        self.mask = mask;
        self.block(program, &program.body, scene);
        self.mask = None;
        for (name, reg) in &program.globals {
            if let Some((_, values)) = points.globals.iter_mut().find(|(n, _)| n == name) {
                std::mem::swap(values, &mut self.regs[*reg as usize]);
            }
        }
    }

    /// The numbers of an output parameter of the shader that ran last: one value, or one a point.
    pub fn output(&self, shader: &BoundShader, name: &str) -> Option<&[f32]> {
        let param = shader.program.params.iter().find(|p| p.output && p.name == name && p.kind != Kind::Text)?;
        Some(&self.regs[param.reg as usize])
    }

    fn load(&mut self, shader: &BoundShader, points: &Points) {
        let program = &*shader.program;
        self.n = points.n();
        self.nu = points.nu;
        self.orientation = points.orientation;
        self.mask = None;
        self.loops.clear();
        self.lit.clear();
        self.reached.clear();
        self.reached.resize(self.n, false);
        // Nothing of the last grid is left, whose points were others.
        self.regs.iter_mut().for_each(Vec::clear);
        if self.regs.len() < program.widths.len() {
            self.regs.resize_with(program.widths.len(), Vec::new);
        }
        if self.texts.len() < program.n_texts {
            self.texts.resize(program.n_texts, String::new());
        }
    }

    /// Parameters: a primitive variable, else what was given, else the default.
    fn defaults(&mut self, shader: &BoundShader, points: &Points, scene: &dyn Scene) {
        let program = &*shader.program;
        for (i, param) in program.params.iter().enumerate() {
            if param.kind == Kind::Text {
                match shader.texts.iter().find(|(k, _)| *k == i) {
                    Some((_, text)) => self.texts[param.reg as usize].clone_from(text),
                    None => self.block(program, &param.default, scene),
                }
                continue;
            }
            let given = points.inputs.iter().find(|(n, _)| *n == param.name).map(|(_, v)| v);
            match given.or(shader.numbers.iter().find(|(k, _)| *k == i).map(|(_, v)| v)) {
                Some(values) => {
                    let len = param.array.unwrap_or(1) as usize;
                    let each = values.len() / len;
                    for (k, value) in values.chunks_exact(each.max(1)).take(len).enumerate() {
                        let reg = &mut self.regs[param.reg as usize + k];
                        reg.clear();
                        reg.extend_from_slice(value);
                    }
                }
                None => self.block(program, &param.default, scene),
            }
        }
    }

    fn all_off(&self) -> bool {
        self.mask.as_ref().is_some_and(|m| !m.contains(&true))
    }

    fn block(&mut self, program: &Program, ops: &[Op], scene: &dyn Scene) {
        for op in ops {
            if self.all_off() {
                return;
            }
            self.op(program, op, scene);
        }
    }

    fn op(&mut self, program: &Program, op: &Op, scene: &dyn Scene) {
        let width = |r: Reg| program.widths[r as usize] as usize;
        match op {
            Op::Const(dst, v) => {
                let w = width(*dst);
                let reg = &mut self.regs[*dst as usize];
                reg.clear();
                reg.resize(w, *v);
            }
            Op::TextConst(dst, text) => self.texts[*dst as usize].clone_from(text),
            Op::TextCopy(dst, a) => self.texts[*dst as usize] = self.texts[*a as usize].clone(),
            Op::TextEqual(dst, a, b) => {
                let same = self.texts[*a as usize] == self.texts[*b as usize];
                self.regs[*dst as usize] = vec![same as u8 as f32];
            }
            Op::Unary(f, dst, a) => self.unary(*f, *dst, *a, width(*dst), width(*a)),
            Op::Binary(f, dst, a, b) => self.binary(*f, *dst, (*a, width(*a)), (*b, width(*b)), width(*dst)),
            Op::Select(dst, c, a, b) => {
                self.select(*dst, (*c, width(*c)), (*a, width(*a)), (*b, width(*b)), width(*dst))
            }
            Op::Pack(dst, parts) => {
                let varying = parts.iter().any(|r| self.regs[*r as usize].len() != 1);
                debug_assert_eq!(parts.len(), width(*dst));
                let mut out = std::mem::take(&mut self.regs[*dst as usize]);
                out.clear();
                for r in parts {
                    match (&self.regs[*r as usize], varying) {
                        (v, true) if v.len() == 1 => out.extend(std::iter::repeat_n(v[0], self.n)),
                        (v, _) => out.extend_from_slice(v),
                    }
                }
                self.regs[*dst as usize] = out;
            }
            Op::Component(dst, a, c) => {
                let mut out = std::mem::take(&mut self.regs[*dst as usize]);
                let a = &self.regs[*a as usize];
                let run = a.len() / 3;
                out.clear();
                out.extend_from_slice(&a[*c as usize * run..(*c as usize + 1) * run]);
                self.regs[*dst as usize] = out;
            }
            Op::Assign(dst, a) => self.assign(*dst, *a, width(*dst), width(*a)),
            Op::Call(f, dst, args) => {
                let first = args.first().map_or(1, |r| width(*r));
                self.call(program, *f, *dst, args, first, width(*dst), scene);
            }
            Op::Load(dst, first, len, index) => self.load_element(*dst, *first, *len, *index, width(*dst)),
            Op::Store(first, len, index, value) => self.store_element(*first, *len, *index, *value, width(*value)),
            Op::TextLoad(dst, first, len, index) => {
                let k = element(at(&self.regs[*index as usize], 0), *len);
                self.texts[*dst as usize] = k.map_or(String::new(), |k| self.texts[*first as usize + k].clone());
            }
            Op::TextStore(first, len, index, value) => {
                if let Some(k) = element(at(&self.regs[*index as usize], 0), *len) {
                    self.texts[*first as usize + k] = self.texts[*value as usize].clone();
                }
            }
            Op::ColorSpace(dst, a, from, to) => {
                let (from, to) = (self.texts[*from as usize].clone(), self.texts[*to as usize].clone());
                self.pointwise(program, *dst, &[*a], |v| {
                    triple16(crate::color::convert(&from, &to, [v[0][0], v[0][1], v[0][2]]))
                });
            }
            Op::Spline(dst, basis, args) => {
                let basis = self.texts[*basis as usize].clone();
                let w = width(*dst);
                self.pointwise(program, *dst, args, |v| crate::spline::value(&basis, v[0][0], &v[1..], w));
            }
            Op::Match(dst, pattern, text) => {
                let found = crate::text::matches(&self.texts[*pattern as usize], &self.texts[*text as usize]);
                self.regs[*dst as usize] = vec![found as u8 as f32];
            }
            Op::Format(dst, args) => {
                let k = self.mask.as_ref().and_then(|m| m.iter().position(|m| *m)).unwrap_or(0);
                self.texts[*dst as usize] = self.format(program, args, k);
            }
            Op::Print(args) => {
                let varies = |o: &Operand| matches!(o, Operand::Number(r) if self.regs[*r as usize].len() != width(*r));
                let lanes = if args.iter().any(varies) { self.n } else { 1 };
                for k in (0..lanes).filter(|k| lanes == 1 || self.mask.as_ref().is_none_or(|m| m[*k])) {
                    scene.print(&self.format(program, args, k));
                }
            }
            Op::Ask { dst, what, names, out, len } => self.ask(program, *dst, *what, names, *out, *len, scene),
            Op::Map { .. } => self.map(program, op, scene),
            Op::Transform(how, dst, a, from, to) => self.transform(program, *how, *dst, *a, *from, *to, scene),
            Op::If(c, then, otherwise) => self.branch(program, *c, then, otherwise, scene),
            Op::Loop(head, c, body, step) => self.repeat(program, head, *c, body, step, scene),
            Op::Break(levels) => self.leave(*levels as usize, true),
            Op::Continue(levels) => self.leave(*levels as usize, false),
            Op::Inline(body) => {
                let outer = self.mask.clone();
                self.loops.push(LoopFrame { left: vec![false; self.n], skipped: vec![false; self.n], inline: true });
                self.block(program, body, scene);
                self.loops.pop();
                self.mask = outer;
            }
            Op::Return => {
                let inner = self.loops.iter().rev().position(|f| f.inline).map_or(self.loops.len(), |k| k + 1);
                self.leave(inner, true);
            }
            Op::Gather { args, out, hit, miss } => self.gather(program, *args, out, hit, miss, scene),
            Op::Illuminance { .. } => self.illuminance(program, op, scene),
            Op::Solar { args, l, body } => {
                // The axis is the way that light travels.
                let axis = self.regs[args[0] as usize].clone();
                self.assign_value(*l, &axis, 3);
                self.ray = Some((*l, true));
                self.light_body(program, *l, None, body, scene);
                self.ray = None;
            }
            Op::Illuminate { args, l, ps, body } => {
                self.binary(Binary::Sub, *l, (*ps, 3), (args[0], 3), 3);
                let cone = (self.regs[args[1] as usize].clone(), self.regs[args[2] as usize][0]);
                self.ray = Some((*l, false));
                self.light_body(program, *l, Some(cone), body, scene);
                self.ray = None;
            }
        }
    }

    fn unary(&mut self, f: Unary, dst: Reg, a: Reg, wd: usize, wa: usize) {
        let mut out = std::mem::take(&mut self.regs[dst as usize]);
        let a = &self.regs[a as usize];
        out.clear();
        macro_rules! run {
            ($($f:ident)*) => {
                match f {
                    Unary::Copy => out.extend_from_slice(a),
                    $(Unary::$f => out.extend(a.iter().map(|x| unary_value(Unary::$f, *x))),)*
                }
            };
        }
        for _ in 0..wd / wa {
            run!(Negate Not Abs Sign Sqrt InverseSqrt Sin Cos Tan Asin Acos Atan Exp Log Floor Ceil Round Radians Degrees);
        }
        self.regs[dst as usize] = out;
    }

    fn binary(&mut self, f: Binary, dst: Reg, (a, wa): (Reg, usize), (b, wb): (Reg, usize), wd: usize) {
        let mut out = std::mem::take(&mut self.regs[dst as usize]);
        let (a, b) = (&self.regs[a as usize][..], &self.regs[b as usize][..]);
        out.clear();
        let varying = a.len() != wa || b.len() != wb;
        macro_rules! run {
            ($n:ident, $a:ident, $b:ident, $($f:ident)*) => {
                match f {
                    $(Binary::$f => zip(&mut out, $a, $b, $n, |x, y| binary_value(Binary::$f, x, y)),)*
                }
            };
        }
        for c in 0..wd {
            let (a, b) = (run_of(a, wa, c, self.n), run_of(b, wb, c, self.n));
            let n = if varying { self.n } else { 1 };
            run!(n, a, b, Add Sub Mul Div Min Max Pow Mod Atan2 Step Less LessEqual Equal And Or);
        }
        self.regs[dst as usize] = out;
    }

    fn select(&mut self, dst: Reg, c: (Reg, usize), a: (Reg, usize), b: (Reg, usize), wd: usize) {
        let mut out = std::mem::take(&mut self.regs[dst as usize]);
        let view = |(r, w): (Reg, usize)| (&self.regs[r as usize][..], w);
        let (c, a, b) = (view(c), view(a), view(b));
        let varying = [c, a, b].iter().any(|(v, w)| v.len() != *w);
        let n = if varying { self.n } else { 1 };
        out.clear();
        for k in 0..wd {
            let [c, a, b] = [c, a, b].map(|(v, w)| run_of(v, w, k, self.n));
            out.extend((0..n).map(|i| if at(c, i) != 0.0 { at(a, i) } else { at(b, i) }));
        }
        self.regs[dst as usize] = out;
    }

    fn assign(&mut self, dst: Reg, a: Reg, wd: usize, wa: usize) {
        let value = std::mem::take(&mut self.regs[a as usize]);
        if dst != a {
            if wa == wd {
                self.assign_value(dst, &value, wd);
            } else {
                let spread: Vec<f32> = (0..wd / wa).flat_map(|_| value.iter().copied()).collect();
                self.assign_value(dst, &spread, wd);
            }
        }
        self.regs[a as usize] = value;
    }

    /// Assign where the points are active.
    fn assign_value(&mut self, dst: Reg, value: &[f32], width: usize) {
        let n = self.n;
        let out = &mut self.regs[dst as usize];
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

    fn branch(&mut self, program: &Program, c: Reg, then: &[Op], otherwise: &[Op], scene: &dyn Scene) {
        if self.regs[c as usize].len() == 1 {
            let taken = if self.regs[c as usize][0] != 0.0 { then } else { otherwise };
            return self.block(program, taken, scene);
        }
        let c = self.regs[c as usize].clone();
        let outer = self.mask.take();
        for (ops, wanted) in [(then, true), (otherwise, false)] {
            if !ops.is_empty() {
                let active = |i: usize| outer.as_ref().is_none_or(|m| m[i]);
                self.mask = Some((0..self.n).map(|i| active(i) && (c[i] != 0.0) == wanted).collect());
                self.block(program, ops, scene);
            }
        }
        self.mask = outer;
        self.drop_left();
    }

    /// Points that have left a loop, or its turn, stay inactive after the `if` in which they did.
    fn drop_left(&mut self) {
        let Some(frame) = self.loops.last() else { return };
        if frame.left.contains(&true) || frame.skipped.contains(&true) {
            let active = |i: usize| self.mask.as_ref().is_none_or(|m| m[i]);
            self.mask = Some((0..self.n).map(|i| active(i) && !frame.left[i] && !frame.skipped[i]).collect());
        }
    }

    /// `break` out of so many loops, or `continue` the last of them.
    fn leave(&mut self, levels: usize, for_good: bool) {
        let n = self.n;
        let mask = self.mask.take().unwrap_or_else(|| vec![true; n]);
        for (k, frame) in self.loops.iter_mut().rev().take(levels).enumerate() {
            let gone = if for_good || k + 1 < levels { &mut frame.left } else { &mut frame.skipped };
            gone.iter_mut().zip(&mask).for_each(|(g, m)| *g |= m);
        }
        self.mask = Some(vec![false; n]);
    }

    fn repeat(&mut self, program: &Program, head: &[Op], c: Reg, body: &[Op], step: &[Op], scene: &dyn Scene) {
        /// A shader whose loop does not end must not hang the picture.
        const MAX_TURNS: usize = 1_000_000;
        let n = self.n;
        let outer = self.mask.clone();
        self.loops.push(LoopFrame { left: vec![false; n], skipped: vec![false; n], inline: false });
        for _ in 0..MAX_TURNS {
            self.block(program, head, scene);
            let condition = &self.regs[c as usize];
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
            self.block(program, body, scene);
            // Those that went on to the step are active again; those that left are not.
            let frame = self.loops.last_mut().expect("a loop is open");
            frame.skipped.fill(false);
            self.mask = turn;
            self.drop_left();
            self.block(program, step, scene);
        }
        self.loops.pop();
        self.mask = outer;
        // Who left a loop further out, or the function, within this one.
        self.drop_left();
    }

    fn load_element(&mut self, dst: Reg, first: Reg, len: u16, index: Reg, w: usize) {
        let n = self.n;
        let mut out = std::mem::take(&mut self.regs[dst as usize]);
        out.clear();
        let index = &self.regs[index as usize];
        if let [i] = index[..] {
            match element(i, len) {
                Some(k) => out.extend_from_slice(&self.regs[first as usize + k]),
                None => out.resize(w, 0.0),
            }
        } else {
            out.resize(w * n, 0.0);
            for (k, i) in index.iter().enumerate() {
                let Some(e) = element(*i, len) else { continue };
                let value = &self.regs[first as usize + e];
                (0..w).for_each(|c| out[c * n + k] = at(run_of(value, w, c, n), k));
            }
        }
        self.regs[dst as usize] = out;
    }

    fn store_element(&mut self, first: Reg, len: u16, index: Reg, value: Reg, w: usize) {
        let index = self.regs[index as usize].clone();
        let value = self.regs[value as usize].clone();
        if let [i] = index[..] {
            if let Some(k) = element(i, len) {
                self.assign_value(first + k as u16, &value, w);
            }
            return;
        }
        let outer = self.mask.take();
        for k in 0..len as usize {
            let here = |p: usize| outer.as_ref().is_none_or(|m| m[p]) && element(index[p], len) == Some(k);
            let mask: Vec<bool> = (0..self.n).map(here).collect();
            if mask.contains(&true) {
                self.mask = Some(mask);
                self.assign_value(first + k as u16, &value, w);
            }
        }
        self.mask = outer;
    }

    /// Compute `f` of the values of some registers, point by point, or once if all are uniform.
    fn pointwise(&mut self, program: &Program, dst: Reg, args: &[Reg], f: impl Fn(&[[f32; 16]]) -> [f32; 16]) {
        let n = self.n;
        let width = |r: Reg| program.widths[r as usize] as usize;
        let mut out = std::mem::take(&mut self.regs[dst as usize]);
        out.clear();
        let wd = width(dst);
        let lanes = if args.iter().all(|r| self.regs[*r as usize].len() == width(*r)) { 1 } else { n };
        out.resize(wd * lanes, 0.0);
        let mut values = vec![[0.0; 16]; args.len()];
        for k in 0..lanes {
            if self.mask.as_ref().is_some_and(|m| lanes == n && !m[k]) {
                continue;
            }
            for (value, r) in values.iter_mut().zip(args) {
                let w = width(*r);
                (0..w).for_each(|c| value[c] = at(run_of(&self.regs[*r as usize], w, c, n), k));
            }
            let result = f(&values);
            (0..wd).for_each(|c| out[c * lanes + k] = result[c]);
        }
        self.regs[dst as usize] = out;
    }

    /// The text of a format at a point.
    fn format(&self, program: &Program, args: &[Operand], k: usize) -> String {
        let values: Vec<crate::text::Value> = args
            .iter()
            .map(|o| match o {
                Operand::Text(r) => crate::text::Value::Text(&self.texts[*r as usize]),
                Operand::Number(r) => {
                    let w = program.widths[*r as usize] as usize;
                    let value = |c: usize| at(run_of(&self.regs[*r as usize], w, c, self.n), k);
                    crate::text::Value::Numbers((0..w).map(value).collect())
                }
            })
            .collect();
        crate::text::format(&values)
    }

    #[allow(clippy::too_many_arguments)]
    fn ask(
        &mut self,
        program: &Program,
        dst: Reg,
        what: Ask,
        names: &[TextReg],
        out: Operand,
        len: u16,
        scene: &dyn Scene,
    ) {
        let names: Vec<&str> = names.iter().map(|r| self.texts[*r as usize].as_str()).collect();
        let answer = match (what, names[0]) {
            (Ask::LightSource, name) => {
                self.turn.and_then(|(light, lit)| self.light_parameter(scene.lights().get(light)?, lit, name))
            }
            (Ask::RendererInfo, "renderer") => Some(Answer::Text("scree".into())),
            (Ask::RendererInfo, "versionstring") => Some(Answer::Text(env!("CARGO_PKG_VERSION").into())),
            (Ask::RendererInfo, "version") => {
                let parts = env!("CARGO_PKG_VERSION").split('.').map(|p| p.parse().unwrap_or(0.0));
                Some(Answer::Numbers(parts.chain([0.0]).collect()))
            }
            _ => scene.ask(what, &names),
        };
        let mut found = 0.0;
        match (answer, out) {
            (Some(Answer::Text(text)), Operand::Text(r)) => {
                self.texts[r as usize] = text;
                found = 1.0;
            }
            (Some(Answer::Numbers(v)), Operand::Number(r)) => {
                let w = program.widths[r as usize] as usize;
                let varying = v.len() == w * self.n && len == 1;
                if varying || v.len() >= w * len as usize {
                    let each = if varying { v.len() } else { w };
                    for k in 0..len as usize {
                        self.assign_value(r + k as u16, &v[k * each..(k + 1) * each], w);
                    }
                    found = 1.0;
                }
            }
            _ => {}
        }
        self.regs[dst as usize] = vec![found];
    }

    /// A parameter of a light: what it gave to the grid if it is an output.
    fn light_parameter(&self, light: &BoundShader, lit: usize, name: &str) -> Option<Answer> {
        let i = light.program.params.iter().position(|p| p.name == name)?;
        match self.lit[lit].outputs.iter().find(|(k, _)| *k == i) {
            Some((_, v)) => Some(Answer::Numbers(v.clone())),
            None => light.parameter(name),
        }
    }

    fn map(&mut self, program: &Program, op: &Op, scene: &dyn Scene) {
        let Op::Map { dst, how, name, channel, at: place, options } = op else { return };
        let n = self.n;
        let wd = program.widths[*dst as usize] as usize;
        let name = self.texts[*name as usize].clone();
        let number = |key: &str, otherwise: f32| {
            let found = options.iter().find(|(k, _)| self.texts[*k as usize] == key);
            match found {
                Some((_, Operand::Number(r))) => self.regs[*r as usize].first().copied().unwrap_or(otherwise),
                _ => otherwise,
            }
        };
        let width = [number("width", 1.0), number("swidth", 1.0), number("twidth", 1.0)].into_iter().product();
        let blur = number("blur", 0.0).max(number("sblur", 0.0)).max(number("tblur", 0.0));
        let mut query = MapQuery {
            how: *how,
            name: &name,
            channel: at(&self.regs[*channel as usize], 0).max(0.0) as usize,
            at: [0.0; 3],
            change: [[0.0; 3]; 2],
            width,
            blur,
            samples: number("samples", 16.0),
            bias: number("bias", 0.0),
            light: None,
        };
        let ray = self.ray.map(|(l, sun)| (self.regs[l as usize].clone(), sun));
        // One point: s and t as two numbers, others as a triple. Four: the corners of the filter's area.
        let each = if *how == Lookup::Texture { 2 } else { 1 };
        let corner = |c: usize, axis: usize, k: usize| -> f32 {
            match (each, axis) {
                (2, 2) => 0.0,
                (2, _) => at(&self.regs[place[2 * c + axis] as usize], k),
                _ => at(run_of(&self.regs[place[c] as usize], 3, axis, n), k),
            }
        };
        let uniform = place.iter().all(|r| self.regs[*r as usize].len() == program.widths[*r as usize] as usize);
        let lanes = if uniform { 1 } else { n };
        let mut out = vec![0.0; wd * lanes];
        for k in 0..lanes {
            if self.mask.as_ref().is_some_and(|m| lanes == n && !m[k]) {
                continue;
            }
            if place.len() == 4 * each {
                let all = |axis: usize| [0, 1, 2, 3].map(|c| corner(c, axis, k));
                for axis in 0..3 {
                    let [a, b, c, d] = all(axis);
                    query.at[axis] = 0.25 * (a + b + c + d);
                    query.change[0][axis] = 0.5 * (b + d - a - c);
                    query.change[1][axis] = 0.5 * (c + d - a - b);
                }
            } else {
                query.at = [0, 1, 2].map(|axis| corner(0, axis, k));
                for axis in 0..3 {
                    let r = &self.regs[place[if each == 2 { axis.min(1) } else { 0 }] as usize];
                    let run = if each == 2 { &r[..] } else { run_of(r, 3, axis, n) };
                    let d = if each == 2 && axis == 2 { [0.0; 2] } else { self.differences(run, k) };
                    (query.change[0][axis], query.change[1][axis]) = (d[0], d[1]);
                }
            }
            query.light = ray.as_ref().map(|(l, sun)| {
                // The light's ray ends at the place; a sun's begins far away.
                let (l, far) = (triple(l, k, n), if *sun { 1e6 } else { 1.0 });
                let scale = if *sun { far / dot(l, l).sqrt().max(1e-20) } else { 1.0 };
                [0, 1, 2].map(|c| query.at[c] - l[c] * scale)
            });
            let value = scene.map(&query);
            (0..wd).for_each(|c| out[c * lanes + k] = value[c]);
        }
        self.regs[*dst as usize] = out;
    }

    /// Rays from a place about an axis.
    fn gather(
        &mut self,
        program: &Program,
        args: [Reg; 4],
        out: &[(String, Reg)],
        hit: &[Op],
        miss: &[Op],
        scene: &dyn Scene,
    ) {
        let n = self.n;
        let [p, axis, angle, samples] = args.map(|r| self.regs[r as usize].clone());
        let samples = at(&samples, 0).clamp(1.0, 1024.0) as usize;
        let outer = self.mask.clone();
        for i in 0..samples {
            let mut ways = vec![0.0; 3 * n];
            let mut lengths = vec![0.0; n];
            let (mut hits, mut misses) = (vec![false; n], vec![false; n]);
            for k in (0..n).filter(|k| outer.as_ref().is_none_or(|m| m[*k])) {
                let (from, about) = (triple(&p, k, n), triple(&axis, k, n));
                let way = crate::lanes::in_cone(about, at(&angle, k), i, samples, from);
                put(&mut ways, k, n, way);
                match scene.hit(from, way) {
                    Some(distance) => (lengths[k], hits[k]) = (distance, true),
                    None => misses[k] = true,
                }
            }
            for (name, reg) in out {
                let w = program.widths[*reg as usize] as usize;
                match name.as_str() {
                    "ray:direction" if w == 3 => self.assign_value(*reg, &ways, 3),
                    "ray:origin" if w == 3 => self.assign_value(*reg, &p, 3),
                    "ray:length" if w == 1 => self.assign_value(*reg, &lengths, 1),
                    _ if w == 3 && name.ends_with(":Ci") => {
                        let mut colors = vec![0.0; 3 * n];
                        for k in (0..n).filter(|k| hits[*k]) {
                            let color = scene.trace(triple(&p, k, n), triple(&ways, k, n), samples > 1);
                            put(&mut colors, k, n, color);
                        }
                        self.assign_value(*reg, &colors, 3);
                    }
                    _ => {}
                }
            }
            for (mask, ops) in [(hits, hit), (misses, miss)] {
                if mask.contains(&true) {
                    self.mask = Some(mask);
                    self.block(program, ops, scene);
                }
            }
            self.mask.clone_from(&outer);
            self.drop_left();
            if self.all_off() {
                break;
            }
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn call(
        &mut self,
        program: &Program,
        f: Builtin,
        dst: Reg,
        args: &[Reg],
        first: usize,
        wd: usize,
        scene: &dyn Scene,
    ) {
        let matrix = |v: &[f32; 16]| glam::Mat4::from_cols_array(v);
        match f {
            Builtin::Comp if first == 16 => {
                return self.pointwise(program, dst, args, |v| {
                    one16(element(v[1][0], 4).zip(element(v[2][0], 4)).map_or(0.0, |(r, c)| v[0][4 * r + c]))
                });
            }
            Builtin::Comp => {
                return self.pointwise(program, dst, args, |v| one16(element(v[1][0], 3).map_or(0.0, |k| v[0][k])));
            }
            Builtin::SetComp => {
                return self.pointwise(program, dst, args, |v| {
                    let mut m = v[0];
                    let place = if first == 16 {
                        element(v[1][0], 4).zip(element(v[2][0], 4)).map(|(r, c)| 4 * r + c)
                    } else {
                        element(v[1][0], 3)
                    };
                    if let Some(k) = place {
                        m[k] = v[v.len() - 1][0];
                    }
                    m
                });
            }
            Builtin::Diagonal => {
                return self.pointwise(program, dst, args, |v| {
                    let mut m = [0.0; 16];
                    [0, 5, 10, 15].into_iter().for_each(|k| m[k] = v[0][0]);
                    m
                });
            }
            // Row vectors: a matrix's numbers are the columns of its transpose, and products go the other way round.
            Builtin::MatrixMultiply => {
                return self.pointwise(program, dst, args, |v| (matrix(&v[1]) * matrix(&v[0])).to_cols_array());
            }
            Builtin::MatrixDivide => {
                return self
                    .pointwise(program, dst, args, |v| (inverse(matrix(&v[1])) * matrix(&v[0])).to_cols_array());
            }
            Builtin::MatrixEqual => {
                return self.pointwise(program, dst, args, |v| one16((v[0] == v[1]) as u8 as f32));
            }
            Builtin::Determinant => {
                return self.pointwise(program, dst, args, |v| one16(matrix(&v[0]).determinant()));
            }
            Builtin::LogBase => {
                return self.pointwise(program, dst, args, |v| {
                    let base = unary_value(Unary::Log, v[1][0]);
                    one16(if base != 0.0 { unary_value(Unary::Log, v[0][0]) / base } else { 0.0 })
                });
            }
            Builtin::MatrixPoint | Builtin::MatrixVector | Builtin::MatrixNormal => {
                return self.pointwise(program, dst, args, |v| {
                    let (m, p) = (matrix(&v[0]), glam::Vec3::new(v[1][0], v[1][1], v[1][2]));
                    let q = match f {
                        Builtin::MatrixPoint => m.project_point3(p),
                        Builtin::MatrixVector => m.transform_vector3(p),
                        _ => inverse(m).transpose().transform_vector3(p),
                    };
                    triple16(q.into())
                });
            }
            Builtin::Translate | Builtin::Scale => {
                return self.pointwise(program, dst, args, |v| {
                    let by = glam::Vec3::new(v[1][0], v[1][1], v[1][2]);
                    let own = match f {
                        Builtin::Translate => glam::Mat4::from_translation(by),
                        _ => glam::Mat4::from_scale(by),
                    };
                    (matrix(&v[0]) * own).to_cols_array()
                });
            }
            Builtin::Rotate => {
                return self.pointwise(program, dst, args, |v| {
                    let axis = glam::Vec3::new(v[2][0], v[2][1], v[2][2]).normalize_or(glam::Vec3::Z);
                    (matrix(&v[0]) * glam::Mat4::from_axis_angle(axis, v[1][0])).to_cols_array()
                });
            }
            Builtin::PeriodicNoise => {
                let widths: Vec<usize> = args.iter().map(|r| program.widths[*r as usize] as usize).collect();
                return self.pointwise(program, dst, args, |v| periodic(&widths, v));
            }
            Builtin::Noise | Builtin::CellNoise if first == 3 && args.len() == 2 => {
                return self.pointwise(program, dst, args, |v| {
                    let (p, t) = ([v[0][0], v[0][1], v[0][2]], v[1][0]);
                    triple16([0, 1, 2].map(|c| match f {
                        Builtin::Noise => noise4(p, t, None, c),
                        _ => cell_noise(p, (t.floor() as i32 as u32).wrapping_mul(0x2545_f491) ^ c),
                    }))
                });
            }
            Builtin::Random => {
                // Without a place, the grid's first point stands for all.
                let p = program.global("P").map_or([0.0; 3], |p| triple(&self.regs[p as usize], 0, self.n));
                return self.pointwise(program, dst, args, |v| {
                    let at = v.get(1).map_or(p, |v| [v[0], v[1], v[2]]);
                    let cell = at.map(|x| x.to_bits() as f32 * 0.618_034 + v[0][0]);
                    triple16([0, 1, 2].map(|c| cell_noise(cell, c + at[c as usize].to_bits())))
                });
            }
            _ => {}
        }
        let mut out = std::mem::take(&mut self.regs[dst as usize]);
        out.clear();
        let n = self.n;
        let arg = |k: usize| &self.regs[args[k] as usize][..];
        match f {
            Builtin::Dot => triples2(&mut out, arg(0), arg(1), n, 1, |a, b| [dot(a, b), 0.0, 0.0]),
            Builtin::Cross => triples2(&mut out, arg(0), arg(1), n, 3, cross),
            Builtin::Length => triples2(&mut out, arg(0), arg(0), n, 1, |a, _| [dot(a, a).sqrt(), 0.0, 0.0]),
            Builtin::Normalize => triples2(&mut out, arg(0), arg(0), n, 3, |a, _| {
                let l = dot(a, a).sqrt();
                if l > 0.0 { a.map(|x| x / l) } else { [0.0; 3] }
            }),
            Builtin::FaceForward => {
                let (v, i, reference) = (arg(0), arg(1), arg(2));
                let lanes = if [v, i, reference].iter().all(|x| x.len() == 3) { 1 } else { n };
                out.resize(3 * lanes, 0.0);
                for k in 0..lanes {
                    let a = triple(v, k, n);
                    let sign = if dot(triple(i, k, n), triple(reference, k, n)) > 0.0 { -1.0 } else { 1.0 };
                    put(&mut out, k, lanes, a.map(|x| x * sign));
                }
            }
            Builtin::Reflect => triples2(&mut out, arg(0), arg(1), n, 3, |i, m| {
                let d = 2.0 * dot(i, m);
                [i[0] - d * m[0], i[1] - d * m[1], i[2] - d * m[2]]
            }),
            Builtin::Refract => {
                let eta = arg(2);
                let lanes = if arg(0).len() == 3 && arg(1).len() == 3 && eta.len() == 1 { 1 } else { n };
                out.resize(3 * lanes, 0.0);
                for k in 0..lanes {
                    put(&mut out, k, lanes, refract(triple(arg(0), k, n), triple(arg(1), k, n), at(eta, k)));
                }
            }
            Builtin::SmoothStep => {
                let (lo, hi, x) = (arg(0), arg(1), arg(2));
                let lanes = if lo.len() == 1 && hi.len() == 1 && x.len() == 1 { 1 } else { n };
                out.extend((0..lanes).map(|k| {
                    let (lo, hi, x) = (at(lo, k), at(hi, k), at(x, k));
                    if x < lo || hi <= lo {
                        return (x >= lo) as u8 as f32;
                    }
                    let t = ((x - lo) / (hi - lo)).min(1.0);
                    t * t * (3.0 - 2.0 * t)
                }));
            }
            Builtin::Mix => {
                let (a, b, t) = (arg(0), arg(1), arg(2));
                let lanes = if a.len() == wd && b.len() == wd && t.len() == 1 { 1 } else { n };
                for c in 0..wd {
                    let (a, b) = (run_of(a, wd, c, n), run_of(b, wd, c, n));
                    out.extend((0..lanes).map(|k| at(a, k) * (1.0 - at(t, k)) + at(b, k) * at(t, k)));
                }
            }
            Builtin::Noise | Builtin::CellNoise => {
                let value = if f == Builtin::Noise { noise } else { cell_noise };
                let (x, y) = (arg(0), args.get(1).map(|r| &self.regs[*r as usize][..]));
                let lanes = if x.len() > first || y.is_some_and(|y| y.len() > 1) { n } else { 1 };
                out.resize(wd * lanes, 0.0);
                for k in 0..lanes {
                    if self.mask.as_ref().is_some_and(|m| lanes == n && !m[k]) {
                        continue;
                    }
                    let p = if first == 3 { triple(x, k, n) } else { [at(x, k), y.map_or(0.0, |y| at(y, k)), 0.0] };
                    for c in 0..wd {
                        out[c * lanes + k] = value(p, c as u32);
                    }
                }
            }
            Builtin::Du | Builtin::Dv => self.parametric(&mut out, f == Builtin::Du, arg(0), arg(1), arg(2), wd),
            Builtin::CalculateNormal | Builtin::Area => {
                let p = arg(0);
                out.resize(wd * n, 0.0);
                for k in 0..n {
                    let d = [0, 1, 2].map(|c| self.differences(run_of(p, 3, c, n), k));
                    let m = cross(d.map(|d| d[0]), d.map(|d| d[1]));
                    if wd == 1 {
                        out[k] = dot(m, m).sqrt();
                    } else {
                        put(&mut out, k, n, m.map(|x| x * self.orientation));
                    }
                }
            }
            Builtin::Width => {
                let x = arg(0);
                let change = |k: usize| {
                    let [a, b] = self.differences(x, k);
                    a.abs().max(b.abs())
                };
                out.extend((0..if x.len() == 1 { 1 } else { n }).map(change));
            }
            Builtin::Trace | Builtin::Occlusion | Builtin::IndirectDiffuse => {
                let (p, way) = (arg(0), arg(1));
                let samples = args.get(2).map_or(1.0, |r| at(&self.regs[*r as usize], 0)).clamp(1.0, 4096.0) as usize;
                out.resize(wd * n, 0.0);
                let blind = f == Builtin::IndirectDiffuse && !scene.traces(true);
                for k in (0..n).filter(|k| !blind && self.mask.as_ref().is_none_or(|m| m[*k])) {
                    let (from, about) = (triple(p, k, n), unit(triple(way, k, n)));
                    let mut sum = [0.0f32; 3];
                    if f == Builtin::Trace {
                        sum = if wd == 3 {
                            scene.trace(from, about, false)
                        } else {
                            [scene.hit(from, about).unwrap_or(f32::INFINITY).min(1e30); 3]
                        };
                    } else {
                        for i in 0..samples {
                            let to = crate::lanes::in_hemisphere(about, i, from);
                            let found = match f {
                                Builtin::Occlusion => [scene.hit(from, to).is_some() as u8 as f32; 3],
                                _ => scene.trace(from, to, true),
                            };
                            (0..3).for_each(|c| sum[c] += found[c] / samples as f32);
                        }
                    }
                    (0..wd).for_each(|c| out[c * n + k] = sum[c]);
                }
            }
            Builtin::Ambient => self.ambient(&mut out, scene),
            Builtin::Transmission => {
                let (from, to) = (arg(0), arg(1));
                out.resize(3 * n, 1.0);
                for k in 0..n {
                    if self.mask.as_ref().is_none_or(|m| m[k]) {
                        put(&mut out, k, n, scene.transmission(triple(from, k, n), triple(to, k, n)));
                    }
                }
            }
            _ => unreachable!("done above"),
        }
        self.regs[dst as usize] = out;
    }

    /// Differences of a value to the next point of the row and of the column, central where there are two neighbours.
    fn differences(&self, x: &[f32], k: usize) -> [f32; 2] {
        let (nu, nv) = (self.nu, self.n / self.nu.max(1));
        if x.len() == 1 {
            return [0.0; 2];
        }
        let (i, j) = (k % nu, k / nu);
        let slope = |here: usize, count: usize, stride: usize| {
            let (lo, hi) = (here.saturating_sub(1), (here + 1).min(count - 1));
            let base = k - here * stride;
            if hi > lo { (x[base + hi * stride] - x[base + lo * stride]) / (hi - lo) as f32 } else { 0.0 }
        };
        [slope(i, nu, 1), slope(j, nv, nu)]
    }

    /// Derivative along u or v, whatever way the rows run on the surface.
    fn parametric(&self, out: &mut Vec<f32>, along_u: bool, x: &[f32], u: &[f32], v: &[f32], width: usize) {
        for c in 0..width {
            let x = run_of(x, width, c, self.n);
            out.extend((0..self.n).map(|k| {
                let ([xi, xj], [ui, uj], [vi, vj]) =
                    (self.differences(x, k), self.differences(u, k), self.differences(v, k));
                let det = ui * vj - uj * vi;
                let slope = if along_u { xi * vj - xj * vi } else { xj * ui - xi * uj };
                if det != 0.0 { slope / det } else { 0.0 }
            }));
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn transform(
        &mut self,
        program: &Program,
        how: Transform,
        dst: Reg,
        a: Reg,
        from: TextReg,
        to: TextReg,
        scene: &dyn Scene,
    ) {
        let matrix = scene.matrix(&self.texts[from as usize], &self.texts[to as usize]);
        let m = glam::Mat4::from_cols_array(&matrix.unwrap_or(glam::Mat4::IDENTITY.to_cols_array()));
        if how == Transform::Matrix {
            return self.pointwise(program, dst, &[a], |v| (m * glam::Mat4::from_cols_array(&v[0])).to_cols_array());
        }
        let normal = glam::Mat3::from_mat4(m).inverse().transpose();
        let mut out = std::mem::take(&mut self.regs[dst as usize]);
        out.clear();
        let a = &self.regs[a as usize][..];
        triples2(&mut out, a, a, self.n, 3, |p, _| {
            let p = glam::Vec3::from_array(p);
            match how {
                Transform::Point => m.project_point3(p),
                Transform::Vector => m.transform_vector3(p),
                Transform::Normal | Transform::Matrix => normal * p,
            }
            .to_array()
        });
        self.regs[dst as usize] = out;
    }

    /// What a light's `solar` or `illuminate` does: only for points in its cone and in the receiver's.
    fn light_body(&mut self, program: &Program, l: Reg, cone: Option<(Vec<f32>, f32)>, body: &[Op], scene: &dyn Scene) {
        let n = self.n;
        let inside = {
            let l = &self.regs[l as usize][..];
            let reaches = |k: usize| {
                let l = triple(l, k, n);
                let length = dot(l, l).sqrt();
                let in_cone = cone.as_ref().is_none_or(|(axis, angle)| {
                    let axis = triple(axis, k, n);
                    *angle >= std::f32::consts::PI || dot(l, axis) >= angle.cos() * length * dot(axis, axis).sqrt()
                });
                in_cone
                    && self.receiver.as_ref().is_none_or(|r| {
                        let axis = triple(&r.axis, k, n);
                        -dot(l, axis) > r.cos * length * dot(axis, axis).sqrt()
                    })
            };
            (0..n).map(|k| self.mask.as_ref().is_none_or(|m| m[k]) && reaches(k)).collect::<Vec<bool>>()
        };
        if !inside.contains(&true) {
            return;
        }
        self.reached.resize(n, false);
        self.reached.iter_mut().zip(&inside).for_each(|(r, i)| *r |= i);
        let outer = self.mask.replace(inside);
        self.block(program, body, scene);
        self.mask = outer;
    }

    fn illuminance(&mut self, program: &Program, op: &Op, scene: &dyn Scene) {
        let Op::Illuminance { args, l, cl, category, wanted, body } = op else { return };
        let (l, cl) = (*l, *cl);
        let (position, axis) = (self.regs[args[0] as usize].clone(), self.regs[args[1] as usize].clone());
        let angle = self.regs[args[2] as usize][0];
        for (i, light) in scene.lights().iter().enumerate() {
            if light.program.is_ambient || !category.is_none_or(|c| in_category(light, &self.texts[c as usize])) {
                continue;
            }
            let k = self.light(i, light, &position, &axis, angle, scene);
            let outer = self.mask.take();
            let on = &self.lit[k].on;
            self.mask = Some(on.iter().enumerate().map(|(p, on)| *on && outer.as_ref().is_none_or(|m| m[p])).collect());
            if !self.all_off() {
                // L points from the surface to the light; where the light does not reach, neither value is read.
                let mut towards = std::mem::take(&mut self.regs[l as usize]);
                towards.clear();
                towards.extend(self.lit[k].l.iter().map(|x| -x));
                self.regs[l as usize] = towards;
                self.regs[cl as usize].clone_from(&self.lit[k].cl);
                let before = self.turn.replace((i, k));
                for (name, reg) in wanted {
                    if let Some(Answer::Numbers(v)) = self.light_parameter(light, k, name) {
                        let w = program.widths[*reg as usize] as usize;
                        if v.len() == w || v.len() == w * self.n {
                            self.assign_value(*reg, &v, w);
                        }
                    }
                }
                self.block(program, body, scene);
                self.turn = before;
            }
            self.mask = outer;
            self.drop_left();
        }
    }

    /// What light `i` gives over a cone: kept from an earlier loop, or by running its shader.
    fn light(
        &mut self,
        i: usize,
        light: &BoundShader,
        position: &[f32],
        axis: &[f32],
        angle: f32,
        scene: &dyn Scene,
    ) -> usize {
        let covers = |asked: &Option<Vec<bool>>| match (asked, &self.mask) {
            (None, _) => true,
            (Some(_), None) => false,
            (Some(a), Some(m)) => m.iter().zip(a).all(|(m, a)| !m || *a),
        };
        let same =
            |x: &Lit| x.light == i && x.angle == angle && x.axis == axis && x.position == position && covers(&x.asked);
        if let Some(k) = self.lit.iter().position(same) {
            return k;
        }
        let mut machine = self.light_machine.take().unwrap_or_default();
        let mut points =
            Points { nu: self.nu, nv: self.n / self.nu.max(1), orientation: self.orientation, ..Points::default() };
        points.globals.push(("Ps", position.to_vec()));
        points.globals.push(("L", vec![0.0; 3]));
        points.globals.push(("Cl", vec![0.0; 3]));
        let emitter = scene.emitter(i, self.n, &|k| triple(position, k, self.n));
        if let Some(emitter) = &emitter {
            points.globals.push(("P", emitter.points.clone()));
            points.globals.push(("N", emitter.normals.clone()));
        }
        machine.receiver =
            Some(Receiver { axis: axis.to_vec(), cos: angle.cos() }).filter(|_| angle < std::f32::consts::PI);
        machine.run_where(light, &mut points, scene, self.mask.clone());
        let mut take = |name: &str| {
            points.globals.iter_mut().find(|(n, _)| *n == name).map(|(_, v)| std::mem::take(v)).unwrap_or_default()
        };
        let (l, mut cl) = (take("L"), take("Cl"));
        if let Some(emitter) = emitter {
            cl.iter_mut().for_each(|x| *x *= emitter.part);
        }
        let on = std::mem::take(&mut machine.reached);
        let params = light.program.params.iter().enumerate().filter(|(_, p)| p.output && p.kind != Kind::Text);
        let outputs = params.map(|(i, p)| (i, machine.regs[p.reg as usize].clone())).collect();
        let entry = Lit {
            light: i,
            position: position.to_vec(),
            axis: axis.to_vec(),
            angle,
            asked: self.mask.clone(),
            on,
            l,
            cl,
            outputs,
        };
        self.lit.push(entry);
        self.light_machine = Some(machine);
        self.lit.len() - 1
    }

    /// The sum of the ambient lights.
    fn ambient(&mut self, out: &mut Vec<f32>, scene: &dyn Scene) {
        let n = self.n;
        out.resize(3 * n, 0.0);
        for light in scene.lights().iter().filter(|l| l.program.is_ambient) {
            let mut machine = self.light_machine.take().unwrap_or_default();
            let mut points =
                Points { nu: self.nu, nv: n / self.nu.max(1), orientation: self.orientation, ..Points::default() };
            points.globals.push(("Cl", vec![0.0; 3]));
            machine.receiver = None;
            machine.run_where(light, &mut points, scene, None);
            let cl = points.get("Cl").unwrap_or(&[0.0; 3]);
            for c in 0..3 {
                let run = run_of(cl, 3, c, n);
                (0..n).for_each(|k| out[c * n + k] += at(run, k));
            }
            self.light_machine = Some(machine);
        }
    }
}

/// Numbers of one operation on one number.
#[inline(always)]
pub(crate) fn unary_value(f: Unary, x: f32) -> f32 {
    match f {
        Unary::Copy => x,
        Unary::Negate => -x,
        Unary::Not => (x == 0.0) as u8 as f32,
        Unary::Abs => x.abs(),
        Unary::Sign => (x > 0.0) as u8 as f32 - (x < 0.0) as u8 as f32,
        Unary::Sqrt => x.max(0.0).sqrt(),
        Unary::InverseSqrt => {
            if x > 0.0 {
                1.0 / x.sqrt()
            } else {
                0.0
            }
        }
        Unary::Sin => x.sin(),
        Unary::Cos => x.cos(),
        Unary::Tan => x.tan(),
        Unary::Asin => x.clamp(-1.0, 1.0).asin(),
        Unary::Acos => x.clamp(-1.0, 1.0).acos(),
        Unary::Atan => x.atan(),
        Unary::Exp => x.exp(),
        Unary::Log => x.max(f32::MIN_POSITIVE).ln(),
        Unary::Floor => x.floor(),
        Unary::Ceil => x.ceil(),
        Unary::Round => x.round(),
        Unary::Radians => x.to_radians(),
        Unary::Degrees => x.to_degrees(),
    }
}

/// The number of one operation on two numbers.
#[inline(always)]
pub(crate) fn binary_value(f: Binary, x: f32, y: f32) -> f32 {
    let truth = |x: bool| x as u8 as f32;
    match f {
        Binary::Add => x + y,
        Binary::Sub => x - y,
        Binary::Mul => x * y,
        Binary::Div => {
            if y != 0.0 {
                x / y
            } else {
                0.0
            }
        }
        Binary::Min => {
            if x < y {
                x
            } else {
                y
            }
        }
        Binary::Max => {
            if x > y {
                x
            } else {
                y
            }
        }
        Binary::Pow => power(x, y),
        Binary::Mod => {
            if y != 0.0 {
                x - y * (x / y).floor()
            } else {
                0.0
            }
        }
        Binary::Atan2 => x.atan2(y),
        Binary::Step => truth(y >= x),
        Binary::Less => truth(x < y),
        Binary::LessEqual => truth(x <= y),
        Binary::Equal => truth(x == y),
        Binary::And => truth(x != 0.0 && y != 0.0),
        Binary::Or => truth(x != 0.0 || y != 0.0),
    }
}

/// The element that a number names, if there is one.
fn element(i: f32, len: u16) -> Option<usize> {
    (i >= 0.0 && i < len as f32).then_some(i as usize)
}

fn one16(x: f32) -> [f32; 16] {
    let mut v = [0.0; 16];
    v[0] = x;
    v
}

fn triple16([x, y, z]: [f32; 3]) -> [f32; 16] {
    let mut v = [0.0; 16];
    (v[0], v[1], v[2]) = (x, y, z);
    v
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let l = dot(v, v).sqrt();
    if l > 0.0 { v.map(|x| x / l) } else { v }
}

/// The inverse; of a matrix that has none, zero.
fn inverse(m: glam::Mat4) -> glam::Mat4 {
    if m.determinant() != 0.0 { m.inverse() } else { glam::Mat4::ZERO }
}

/// Noise with periods: one, two, three or four numbers, then as many periods.
fn periodic(widths: &[usize], v: &[[f32; 16]]) -> [f32; 16] {
    let half = v.len() / 2;
    let numbers = |args: &[[f32; 16]]| {
        let mut all = [0.0f32; 4];
        let mut k = 0;
        for (value, width) in args.iter().zip(widths) {
            all[k..k + width].copy_from_slice(&value[..*width]);
            k += width;
        }
        (all, k)
    };
    let ((at, n), (period, _)) = (numbers(&v[..half]), numbers(&v[half..]));
    let (p, q) = ([at[0], at[1], at[2]], [period[0], period[1], period[2]]);
    triple16([0, 1, 2].map(|c| if n == 4 { noise4(p, at[3], Some(period), c) } else { periodic_noise(p, q, c) }))
}

/// Whether a light is of a category: its parameter `__category` names its own, separated by commas; `-` asks for all others.
fn in_category(light: &BoundShader, asked: &str) -> bool {
    let own = match light.parameter("__category") {
        Some(Answer::Text(text)) => text,
        _ => String::new(),
    };
    let has = |name: &str| own.split(',').any(|c| c.trim() == name);
    match asked.strip_prefix('-') {
        Some(not) => !has(not),
        None => asked.is_empty() || has(asked),
    }
}
