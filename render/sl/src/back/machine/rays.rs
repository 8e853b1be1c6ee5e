//! Rays: `gather`, and the functions that send some.

use super::super::scene::{Open, OpenPlace, Ray, Scene, Segment};
use super::control::turn_of;
use super::state::Machine;
use crate::ir::builtins::SceneCall;
use crate::ir::*;
use crate::shadeop::direction::{in_cone, in_hemisphere};
use crate::shadeop::runs::{at, dot, put, triple};

/// Rays that are asked about at once, but for those of one point.
const MAX_RAYS: usize = 1 << 14;

/// Rays over a hemisphere if a shader asks for none.
const SAMPLES: usize = 64;

impl Machine {
    /// A function that asks the scene.
    pub(super) fn scene_call(&mut self, call: SceneCall, dst: Reg, args: &[Reg], scene: &dyn Scene) {
        let mut out = std::mem::take(&mut self.regs[dst.index()]);
        out.clear();
        let width = dst.width();
        match call {
            SceneCall::Ambient => self.ambient(&mut out, scene),
            SceneCall::Transmission => self.transmission(&mut out, args, scene),
            SceneCall::Openness | SceneCall::Surroundings => self.openness(&mut out, args, width, scene),
            SceneCall::Trace => self.trace(&mut out, args, width, scene),
            SceneCall::Occlusion | SceneCall::IndirectDiffuse => {
                self.hemisphere(&mut out, args, width, call == SceneCall::Occlusion, scene)
            }
        }
        self.regs[dst.index()] = out;
    }

    /// The active points.
    fn active(&self) -> Vec<usize> {
        (0..self.n).filter(|k| self.mask.as_ref().is_none_or(|m| m[*k])).collect()
    }

    /// How much light gets from one point to another.
    fn transmission(&self, out: &mut Vec<f32>, args: &[Reg], scene: &dyn Scene) {
        let n = self.n;
        let [from, to] = [0, 1].map(|k| &self.regs[args[k].index()][..]);
        out.resize(3 * n, 1.0);
        let points = self.active();
        let segment = |k: &usize| Segment { from: triple(from, *k, n), to: triple(to, *k, n) };
        let segments: Vec<Segment> = points.iter().map(segment).collect();
        let mut light = vec![[1.0; 3]; segments.len()];
        scene.transmission(&segments, &mut light);
        points.iter().zip(light).for_each(|(k, light)| put(out, *k, n, light));
    }

    /// How open every point is to the sky, and as a matrix what is around it.
    fn openness(&self, out: &mut Vec<f32>, args: &[Reg], width: usize, scene: &dyn Scene) {
        let n = self.n;
        let of = |k: usize, i: usize| args.get(k).map_or([0.0; 3], |reg| triple(&self.regs[reg.index()], i, n));
        out.resize(width * n, 0.0);
        let points = self.active();
        let place = |i: &usize| OpenPlace {
            at: of(0, *i),
            normal: unit(of(1, *i)),
            up: unit(of(2, *i)),
            sun: if args.len() > 3 { unit(of(3, *i)) } else { [0.0; 3] },
        };
        let places: Vec<OpenPlace> = points.iter().map(place).collect();
        let mut open = vec![Open::default(); places.len()];
        scene.openness(&places, &mut open);
        for (k, Open { sky, low, closed, color, lit }) in points.iter().zip(open) {
            if width == 3 {
                put(out, *k, n, sky);
            } else {
                let [[a, b, _], [r, g, c]] = [sky, color];
                let numbers = [a, b, low, closed, r, g, c, lit];
                numbers.iter().enumerate().for_each(|(i, x)| out[i * n + k] = *x);
            }
        }
    }

    /// What a ray from every point brings back: its colour, or its length.
    fn trace(&self, out: &mut Vec<f32>, args: &[Reg], width: usize, scene: &dyn Scene) {
        let n = self.n;
        let [p, way] = [0, 1].map(|k| &self.regs[args[k].index()][..]);
        out.resize(width * n, 0.0);
        let points = self.active();
        let ray = |k: &usize| Ray { from: triple(p, *k, n), direction: unit(triple(way, *k, n)) };
        let rays: Vec<Ray> = points.iter().map(ray).collect();
        if width == 3 {
            let mut colors = vec![[0.0; 3]; rays.len()];
            scene.trace(&rays, false, &mut colors);
            points.iter().zip(colors).for_each(|(k, color)| put(out, *k, n, color));
        } else {
            let mut distances = vec![None; rays.len()];
            scene.hit(&rays, &mut distances);
            points.iter().zip(distances).for_each(|(k, d)| out[*k] = d.unwrap_or(f32::INFINITY).min(1e30));
        }
    }

    /// Rays over the hemisphere of every point: the part of them that is hidden, or the mean of the colours that they bring back.
    fn hemisphere(&self, out: &mut Vec<f32>, args: &[Reg], width: usize, hidden: bool, scene: &dyn Scene) {
        let n = self.n;
        let [p, way, samples] = [0, 1, 2].map(|k| &self.regs[args[k].index()][..]);
        let samples = match at(samples, 0) {
            given if given >= 1.0 => given.min(4096.0) as usize,
            _ => SAMPLES,
        };
        out.resize(width * n, 0.0);
        if !hidden && !scene.traces(true) {
            return;
        }
        let (mut rays, mut parts, mut colors) = (Vec::new(), Vec::new(), Vec::new());
        for points in self.active().chunks((MAX_RAYS / samples).max(1)) {
            rays.clear();
            for k in points {
                let (from, about) = (triple(p, *k, n), unit(triple(way, *k, n)));
                rays.extend((0..samples).map(|i| Ray { from, direction: in_hemisphere(about, i, from) }));
            }
            colors.resize(rays.len(), [0.0; 3]);
            if hidden {
                parts.resize(rays.len(), 0.0);
                scene.hidden(&rays, &mut parts);
                colors.iter_mut().zip(&parts).for_each(|(c, part)| *c = [*part; 3]);
            } else {
                scene.trace(&rays, true, &mut colors);
            }
            for (k, found) in points.iter().zip(colors.chunks_exact(samples)) {
                let mut sum = [0.0f32; 3];
                found.iter().for_each(|found| (0..3).for_each(|c| sum[c] += found[c] / samples as f32));
                (0..width).for_each(|c| out[c * n + *k] = sum[c]);
            }
        }
    }

    /// Rays from a place about an axis.
    pub(super) fn gather(&mut self, op: &Op, scene: &dyn Scene) {
        let Op::Gather { position, axis, angle, samples, out, hit, miss } = op else { return };
        let n = self.n;
        let [p, axis] = [position, axis].map(|r| self.regs[r.index()].clone());
        let [angle, samples] = [angle, samples].map(|r| self.regs[r.index()].clone());
        let samples = at(&samples, 0).clamp(1.0, MAX_GATHERED) as usize;
        let outer_turn = self.loop_turn;
        for i in 0..samples {
            self.loop_turn = turn_of(outer_turn, i as u32 + 1);
            let active = self.mask.clone();
            let mut ways = vec![0.0; 3 * n];
            let mut lengths = vec![0.0; n];
            let (mut hits, mut misses) = (vec![false; n], vec![false; n]);
            let points = self.active();
            let ray = |k: &usize| {
                let (from, about) = (triple(&p, *k, n), triple(&axis, *k, n));
                Ray { from, direction: in_cone(about, at(&angle, *k), i, samples, from) }
            };
            let rays: Vec<Ray> = points.iter().map(ray).collect();
            let mut distances = vec![None; rays.len()];
            scene.hit(&rays, &mut distances);
            for ((k, ray), distance) in points.iter().zip(&rays).zip(distances) {
                put(&mut ways, *k, n, ray.direction);
                match distance {
                    Some(distance) => (lengths[*k], hits[*k]) = (distance, true),
                    None => misses[*k] = true,
                }
            }
            for (name, reg) in out {
                let w = reg.width();
                match name.as_str() {
                    "ray:direction" if w == 3 => self.assign_value(*reg, &ways),
                    "ray:origin" if w == 3 => self.assign_value(*reg, &p),
                    "ray:length" if w == 1 => self.assign_value(*reg, &lengths),
                    _ if w == 3 && name.ends_with(":Ci") => {
                        let points: Vec<usize> = (0..n).filter(|k| hits[*k]).collect();
                        let ray = |k: &usize| Ray { from: triple(&p, *k, n), direction: triple(&ways, *k, n) };
                        let rays: Vec<Ray> = points.iter().map(ray).collect();
                        let mut found = vec![[0.0; 3]; rays.len()];
                        scene.trace(&rays, samples > 1, &mut found);
                        let mut colors = vec![0.0; 3 * n];
                        points.iter().zip(found).for_each(|(k, color)| put(&mut colors, *k, n, color));
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
            // Points that left a loop around this one send no more.
            self.mask = active;
            self.drop_left();
            if self.all_off() {
                break;
            }
        }
        self.loop_turn = outer_turn;
    }
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let l = dot(v, v).sqrt();
    if l > 0.0 { v.map(|x| x / l) } else { v }
}
