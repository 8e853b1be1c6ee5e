//! Rays: `gather`, and the functions that send some.

use super::super::scene::Scene;
use super::state::Machine;
use crate::ir::builtins::SceneCall;
use crate::ir::*;
use crate::shadeop::direction::{in_cone, in_hemisphere};
use crate::shadeop::runs::{at, dot, put, triple};

impl Machine {
    /// A function that asks the scene.
    pub(super) fn scene_call(&mut self, call: SceneCall, dst: Reg, args: &[Reg], scene: &dyn Scene) {
        let mut out = std::mem::take(&mut self.regs[dst.index()]);
        out.clear();
        let width = dst.width();
        match call {
            SceneCall::Ambient => self.ambient(&mut out, scene),
            SceneCall::Transmission => self.transmission(&mut out, args, scene),
            SceneCall::Trace => self.trace(&mut out, args, width, scene),
            SceneCall::Occlusion | SceneCall::IndirectDiffuse => {
                self.hemisphere(&mut out, args, width, call == SceneCall::Occlusion, scene)
            }
        }
        self.regs[dst.index()] = out;
    }

    /// How much light gets from one point to another.
    fn transmission(&self, out: &mut Vec<f32>, args: &[Reg], scene: &dyn Scene) {
        let n = self.n;
        let [from, to] = [0, 1].map(|k| &self.regs[args[k].index()][..]);
        out.resize(3 * n, 1.0);
        for k in 0..n {
            if self.mask.as_ref().is_none_or(|m| m[k]) {
                put(out, k, n, scene.transmission(triple(from, k, n), triple(to, k, n)));
            }
        }
    }

    /// What a ray from every point brings back: its colour, or its length.
    fn trace(&self, out: &mut Vec<f32>, args: &[Reg], width: usize, scene: &dyn Scene) {
        let n = self.n;
        let [p, way] = [0, 1].map(|k| &self.regs[args[k].index()][..]);
        out.resize(width * n, 0.0);
        for k in (0..n).filter(|k| self.mask.as_ref().is_none_or(|m| m[*k])) {
            let (from, about) = (triple(p, k, n), unit(triple(way, k, n)));
            let found = if width == 3 {
                scene.trace(from, about, false)
            } else {
                [scene.hit(from, about).unwrap_or(f32::INFINITY).min(1e30); 3]
            };
            (0..width).for_each(|c| out[c * n + k] = found[c]);
        }
    }

    /// Rays over the hemisphere of every point: how many of them are hidden, or the mean of what they bring back.
    fn hemisphere(&self, out: &mut Vec<f32>, args: &[Reg], width: usize, hidden: bool, scene: &dyn Scene) {
        let n = self.n;
        let [p, way, samples] = [0, 1, 2].map(|k| &self.regs[args[k].index()][..]);
        let samples = at(samples, 0).clamp(1.0, 4096.0) as usize;
        out.resize(width * n, 0.0);
        let blind = !hidden && !scene.traces(true);
        for k in (0..n).filter(|k| !blind && self.mask.as_ref().is_none_or(|m| m[*k])) {
            let (from, about) = (triple(p, k, n), unit(triple(way, k, n)));
            let mut sum = [0.0f32; 3];
            for i in 0..samples {
                let to = in_hemisphere(about, i, from);
                let found =
                    if hidden { [scene.hit(from, to).is_some() as u8 as f32; 3] } else { scene.trace(from, to, true) };
                (0..3).for_each(|c| sum[c] += found[c] / samples as f32);
            }
            (0..width).for_each(|c| out[c * n + k] = sum[c]);
        }
    }

    /// Rays from a place about an axis.
    pub(super) fn gather(&mut self, op: &Op, scene: &dyn Scene) {
        let Op::Gather { position, axis, angle, samples, out, hit, miss } = op else { return };
        let n = self.n;
        let [p, axis] = [position, axis].map(|r| self.regs[r.index()].clone());
        let [angle, samples] = [angle, samples].map(|r| self.regs[r.index()].clone());
        let samples = at(&samples, 0).clamp(1.0, 1024.0) as usize;
        let outer = self.mask.clone();
        for i in 0..samples {
            let mut ways = vec![0.0; 3 * n];
            let mut lengths = vec![0.0; n];
            let (mut hits, mut misses) = (vec![false; n], vec![false; n]);
            for k in (0..n).filter(|k| outer.as_ref().is_none_or(|m| m[*k])) {
                let (from, about) = (triple(&p, k, n), triple(&axis, k, n));
                let way = in_cone(about, at(&angle, k), i, samples, from);
                put(&mut ways, k, n, way);
                match scene.hit(from, way) {
                    Some(distance) => (lengths[k], hits[k]) = (distance, true),
                    None => misses[k] = true,
                }
            }
            for (name, reg) in out {
                let w = reg.width();
                match name.as_str() {
                    "ray:direction" if w == 3 => self.assign_value(*reg, &ways),
                    "ray:origin" if w == 3 => self.assign_value(*reg, &p),
                    "ray:length" if w == 1 => self.assign_value(*reg, &lengths),
                    _ if w == 3 && name.ends_with(":Ci") => {
                        let mut colors = vec![0.0; 3 * n];
                        for k in (0..n).filter(|k| hits[*k]) {
                            let color = scene.trace(triple(&p, k, n), triple(&ways, k, n), samples > 1);
                            put(&mut colors, k, n, color);
                        }
                        self.assign_value(*reg, &colors);
                    }
                    _ => {}
                }
            }
            for (mask, ops) in [(hits, hit), (misses, miss)] {
                if mask.contains(&true) {
                    self.mask = Some(mask);
                    self.block(ops, scene);
                }
            }
            self.mask.clone_from(&outer);
            self.drop_left();
            if self.all_off() {
                break;
            }
        }
    }
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let l = dot(v, v).sqrt();
    if l > 0.0 { v.map(|x| x / l) } else { v }
}
