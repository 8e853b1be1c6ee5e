//! The grid machine: runs a program over a whole grid of points, an operation at a time.
//!
//! A register holds one value (uniform) or one a point (varying), a triple as three runs: all x, all y, all z. Temporaries are
//! computed at every point; only assignments to variables look at which points are active, and costly calls skip the others.
//! One machine serves one thread and is used again for grid after grid, so that its memory is taken once.

use crate::ir::*;
use crate::lanes::{at, cross, dot, power, put, refract, run_of, triple, triples2, zip};
use crate::noise::{cell_noise, noise};
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
                if !bound.texts.iter().any(|(k, _)| *k == i) {
                    bound.texts.push((i, machine.texts[param.reg as usize].clone()));
                }
            } else if !bound.numbers.iter().any(|(k, _)| *k == i) {
                bound.numbers.push((i, machine.regs[param.reg as usize].clone()));
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
}

#[derive(Default)]
struct LoopFrame {
    left: Vec<bool>,
    skipped: Vec<bool>,
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
                    let reg = &mut self.regs[param.reg as usize];
                    reg.clear();
                    reg.extend_from_slice(values);
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
                reg.extend_from_slice(&v[..w]);
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
                self.call(*f, *dst, args, first, width(*dst), scene);
            }
            Op::Transform(how, dst, a, from, to) => self.transform(*how, *dst, *a, *from, *to, scene),
            Op::If(c, then, otherwise) => self.branch(program, *c, then, otherwise, scene),
            Op::Loop(head, c, body, step) => self.repeat(program, head, *c, body, step, scene),
            Op::Break => self.leave(true),
            Op::Continue => self.leave(false),
            Op::Illuminance { args, l, cl, body } => self.illuminance(program, *args, *l, *cl, body, scene),
            Op::Solar { args, l, body } => {
                // The axis is the way that light travels.
                let axis = self.regs[args[0] as usize].clone();
                self.assign_value(*l, &axis, 3);
                self.light_body(program, *l, None, body, scene);
            }
            Op::Illuminate { args, l, ps, body } => {
                self.binary(Binary::Sub, *l, (*ps, 3), (args[0], 3), 3);
                let cone = (self.regs[args[1] as usize].clone(), self.regs[args[2] as usize][0]);
                self.light_body(program, *l, Some(cone), body, scene);
            }
        }
    }

    fn unary(&mut self, f: Unary, dst: Reg, a: Reg, wd: usize, wa: usize) {
        let mut out = std::mem::take(&mut self.regs[dst as usize]);
        let a = &self.regs[a as usize];
        out.clear();
        for _ in 0..wd / wa {
            match f {
                Unary::Copy => out.extend_from_slice(a),
                Unary::Negate => out.extend(a.iter().map(|x| -x)),
                Unary::Not => out.extend(a.iter().map(|x| (*x == 0.0) as u8 as f32)),
                Unary::Abs => out.extend(a.iter().map(|x| x.abs())),
                Unary::Sign => out.extend(a.iter().map(|x| {
                    if *x > 0.0 {
                        1.0
                    } else if *x < 0.0 {
                        -1.0
                    } else {
                        0.0
                    }
                })),
                Unary::Sqrt => out.extend(a.iter().map(|x| x.max(0.0).sqrt())),
                Unary::InverseSqrt => out.extend(a.iter().map(|x| if *x > 0.0 { 1.0 / x.sqrt() } else { 0.0 })),
                Unary::Sin => out.extend(a.iter().map(|x| x.sin())),
                Unary::Cos => out.extend(a.iter().map(|x| x.cos())),
                Unary::Tan => out.extend(a.iter().map(|x| x.tan())),
                Unary::Asin => out.extend(a.iter().map(|x| x.clamp(-1.0, 1.0).asin())),
                Unary::Acos => out.extend(a.iter().map(|x| x.clamp(-1.0, 1.0).acos())),
                Unary::Atan => out.extend(a.iter().map(|x| x.atan())),
                Unary::Exp => out.extend(a.iter().map(|x| x.exp())),
                Unary::Log => out.extend(a.iter().map(|x| x.max(f32::MIN_POSITIVE).ln())),
                Unary::Floor => out.extend(a.iter().map(|x| x.floor())),
                Unary::Ceil => out.extend(a.iter().map(|x| x.ceil())),
                Unary::Round => out.extend(a.iter().map(|x| x.round())),
                Unary::Radians => out.extend(a.iter().map(|x| x.to_radians())),
                Unary::Degrees => out.extend(a.iter().map(|x| x.to_degrees())),
            }
        }
        self.regs[dst as usize] = out;
    }

    fn binary(&mut self, f: Binary, dst: Reg, (a, wa): (Reg, usize), (b, wb): (Reg, usize), wd: usize) {
        let mut out = std::mem::take(&mut self.regs[dst as usize]);
        let (a, b) = (&self.regs[a as usize][..], &self.regs[b as usize][..]);
        out.clear();
        let varying = a.len() != wa || b.len() != wb;
        for c in 0..wd {
            let (a, b) = (run_of(a, wa, c, self.n), run_of(b, wb, c, self.n));
            let n = if varying { self.n } else { 1 };
            match f {
                Binary::Add => zip(&mut out, a, b, n, |x, y| x + y),
                Binary::Sub => zip(&mut out, a, b, n, |x, y| x - y),
                Binary::Mul => zip(&mut out, a, b, n, |x, y| x * y),
                Binary::Div => zip(&mut out, a, b, n, |x, y| if y != 0.0 { x / y } else { 0.0 }),
                Binary::Min => zip(&mut out, a, b, n, |x, y| if x < y { x } else { y }),
                Binary::Max => zip(&mut out, a, b, n, |x, y| if x > y { x } else { y }),
                Binary::Pow => zip(&mut out, a, b, n, power),
                Binary::Mod => zip(&mut out, a, b, n, |x, y| if y != 0.0 { x - y * (x / y).floor() } else { 0.0 }),
                Binary::Atan2 => zip(&mut out, a, b, n, |x, y| x.atan2(y)),
                Binary::Step => zip(&mut out, a, b, n, |x, y| (y >= x) as u8 as f32),
                Binary::Less => zip(&mut out, a, b, n, |x, y| (x < y) as u8 as f32),
                Binary::LessEqual => zip(&mut out, a, b, n, |x, y| (x <= y) as u8 as f32),
                Binary::Equal => zip(&mut out, a, b, n, |x, y| (x == y) as u8 as f32),
                Binary::And => zip(&mut out, a, b, n, |x, y| (x != 0.0 && y != 0.0) as u8 as f32),
                Binary::Or => zip(&mut out, a, b, n, |x, y| (x != 0.0 || y != 0.0) as u8 as f32),
            }
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
        if out.is_empty() {
            out.resize(width, 0.0);
        }
        if out.len() == width && n > 1 {
            *out = out.iter().flat_map(|x| std::iter::repeat_n(*x, n)).collect();
        }
        for c in 0..width {
            let run = run_of(value, width, c, n);
            for i in 0..n {
                if mask[i] {
                    out[c * n + i] = at(run, i);
                }
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

    /// `break` or `continue`.
    fn leave(&mut self, for_good: bool) {
        let n = self.n;
        let mask = self.mask.take().unwrap_or_else(|| vec![true; n]);
        if let Some(frame) = self.loops.last_mut() {
            let gone = if for_good { &mut frame.left } else { &mut frame.skipped };
            gone.iter_mut().zip(&mask).for_each(|(g, m)| *g |= m);
        }
        self.mask = Some(vec![false; n]);
    }

    fn repeat(&mut self, program: &Program, head: &[Op], c: Reg, body: &[Op], step: &[Op], scene: &dyn Scene) {
        /// A shader whose loop does not end must not hang the picture.
        const MAX_TURNS: usize = 1_000_000;
        let n = self.n;
        let outer = self.mask.clone();
        self.loops.push(LoopFrame { left: vec![false; n], skipped: vec![false; n] });
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
    }

    fn call(&mut self, f: Builtin, dst: Reg, args: &[Reg], first: usize, wd: usize, scene: &dyn Scene) {
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

    fn transform(&mut self, how: Transform, dst: Reg, a: Reg, from: TextReg, to: TextReg, scene: &dyn Scene) {
        let matrix = scene.matrix(&self.texts[from as usize], &self.texts[to as usize]);
        let m = glam::Mat4::from_cols_array(&matrix.unwrap_or(glam::Mat4::IDENTITY.to_cols_array()));
        let normal = glam::Mat3::from_mat4(m).inverse().transpose();
        let mut out = std::mem::take(&mut self.regs[dst as usize]);
        out.clear();
        let a = &self.regs[a as usize][..];
        triples2(&mut out, a, a, self.n, 3, |p, _| {
            let p = glam::Vec3::from_array(p);
            match how {
                Transform::Point => m.project_point3(p),
                Transform::Vector => m.transform_vector3(p),
                Transform::Normal => normal * p,
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

    fn illuminance(&mut self, program: &Program, args: [Reg; 3], l: Reg, cl: Reg, body: &[Op], scene: &dyn Scene) {
        let (position, axis) = (self.regs[args[0] as usize].clone(), self.regs[args[1] as usize].clone());
        let angle = self.regs[args[2] as usize][0];
        for (i, light) in scene.lights().iter().enumerate() {
            if light.program.is_ambient {
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
                self.block(program, body, scene);
            }
            self.mask = outer;
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
        machine.receiver =
            Some(Receiver { axis: axis.to_vec(), cos: angle.cos() }).filter(|_| angle < std::f32::consts::PI);
        machine.run_where(light, &mut points, scene, self.mask.clone());
        let mut take = |name: &str| {
            points.globals.iter_mut().find(|(n, _)| *n == name).map(|(_, v)| std::mem::take(v)).unwrap_or_default()
        };
        let (l, cl) = (take("L"), take("Cl"));
        let on = std::mem::take(&mut machine.reached);
        let entry = Lit {
            light: i,
            position: position.to_vec(),
            axis: axis.to_vec(),
            angle,
            asked: self.mask.clone(),
            on,
            l,
            cl,
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
