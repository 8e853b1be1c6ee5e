//! Lights: `illuminance` in surfaces, `solar` and `illuminate` in lights, `ambient`.

use super::super::bound::{Answer, BoundShader};
use super::super::points::Points;
use super::super::scene::Scene;
use super::super::slots::VariableSlots;
use super::control::turn_of;
use super::state::{Lit, Machine, Receiver};
use crate::ir::*;
use crate::shadeop::runs::{at, dot, run_of, triple};

/// Cosines of the half angles of cones; less than -1 for those of all directions.
pub(super) fn cosines(angle: &[f32]) -> Vec<f32> {
    angle.iter().map(|a| if *a < std::f32::consts::PI { a.cos() } else { -2.0 }).collect()
}

impl Machine {
    /// A parameter of a light: what it gave to the grid if it is an output.
    pub(super) fn light_parameter(&self, light: &BoundShader, lit: usize, name: &str) -> Option<Answer> {
        let i = light.program.params.iter().position(|p| p.name == name)?;
        match self.lit[lit].outputs.iter().find(|(k, _)| *k == i) {
            Some((_, v)) => Some(Answer::Numbers(v.clone())),
            None => light.parameter(name),
        }
    }

    /// What a light's `solar` or `illuminate` does: only for points in its cone and in the receiver's.
    pub(super) fn light_body(
        &mut self,
        l: TripleReg,
        cone: Option<(Vec<f32>, Vec<f32>)>,
        body: &[Op],
        scene: &dyn Scene,
    ) {
        let n = self.n;
        let inside = {
            let l = &self.regs[l.index()][..];
            let reaches = |k: usize| {
                let l = triple(l, k, n);
                let length = dot(l, l).sqrt();
                let in_cone = cone.as_ref().is_none_or(|(axis, cos)| {
                    let axis = triple(axis, k, n);
                    let cos = at(cos, k);
                    cos < -1.0 || dot(l, axis) >= cos * length * dot(axis, axis).sqrt()
                });
                in_cone
                    && self.receiver.as_ref().is_none_or(|r| {
                        let axis = triple(&r.axis, k, n);
                        let cos = at(&r.cos, k);
                        cos < -1.0 || -dot(l, axis) > cos * length * dot(axis, axis).sqrt()
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
        self.block(body, scene);
        self.mask = outer;
        self.drop_left();
    }

    pub(super) fn illuminance(&mut self, op: &Op, scene: &dyn Scene) {
        let Op::Illuminance { position, axis, angle, l, cl, category, wanted, body } = op else { return };
        let (l, cl) = (*l, *cl);
        let [position, axis] = [position, axis].map(|r| self.regs[r.index()].clone());
        let angle = self.regs[angle.index()].clone();
        for (i, light) in scene.lights().iter().enumerate() {
            if light.program.is_ambient || !category.is_none_or(|c| light.in_category(&self.texts[c.index()])) {
                continue;
            }
            let k = self.light(i, light, &position, &axis, &angle, scene);
            let outer_turn = self.loop_turn;
            self.loop_turn = turn_of(outer_turn, i as u32 + 1);
            let outer = self.mask.take();
            let on = &self.lit[k].on;
            self.mask = Some(on.iter().enumerate().map(|(p, on)| *on && outer.as_ref().is_none_or(|m| m[p])).collect());
            if !self.all_off() {
                // L points from the surface to the light; where the light does not reach, neither value is read.
                let mut towards = std::mem::take(&mut self.regs[l.index()]);
                towards.clear();
                towards.extend(self.lit[k].l.iter().map(|x| -x));
                self.regs[l.index()] = towards;
                self.regs[cl.index()].clone_from(&self.lit[k].cl);
                let before = self.turn.replace((i, k));
                for (name, reg) in wanted {
                    let of_light = if name == Global::Ol.name() {
                        Some(Answer::Numbers(self.lit[k].ol.clone()))
                    } else {
                        self.light_parameter(light, k, name)
                    };
                    if let Some(Answer::Numbers(v)) = of_light {
                        let w = reg.width();
                        if v.len() == w || v.len() == w * self.n {
                            self.assign_value(*reg, &v);
                        }
                    }
                }
                self.block(body, scene);
                self.turn = before;
            }
            self.loop_turn = outer_turn;
            self.mask = outer;
            self.drop_left();
        }
    }

    /// What light `i` gives over a cone: kept from an earlier loop, or by running its shader.
    pub(super) fn light(
        &mut self,
        i: usize,
        light: &BoundShader,
        position: &[f32],
        axis: &[f32],
        angle: &[f32],
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
        let mut points = Points::new(self.nu, self.n / self.nu.max(1), self.orientation);
        points.set(Global::Ps, position.to_vec());
        if light.program.global(Global::Ns).is_some() {
            points.set(Global::Ns, if self.normals.is_empty() { axis.to_vec() } else { self.normals.clone() });
        }
        points.set(Global::L, vec![0.0; 3]);
        points.set(Global::Cl, vec![0.0; 3]);
        points.set(Global::Ol, vec![1.0; 3]);
        let emitter = scene.emitter(i, self.n, &|k| triple(position, k, self.n));
        if let Some(emitter) = &emitter {
            points.set(Global::P, emitter.points.clone());
            points.set(Global::N, emitter.normals.clone());
            points.set(Global::Ng, emitter.normals.clone());
        }
        let is_cone = angle.iter().any(|a| *a < std::f32::consts::PI);
        machine.receiver = is_cone.then(|| Receiver { axis: axis.to_vec(), cos: cosines(angle) });
        machine.run_where(light, &VariableSlots::default(), &mut points, scene, self.mask.clone());
        let mut take = |global| points.get_mut(global).map(std::mem::take).unwrap_or_default();
        let (l, mut cl, ol) = (take(Global::L), take(Global::Cl), take(Global::Ol));
        if let Some(emitter) = emitter {
            cl.iter_mut().for_each(|x| *x *= emitter.part);
        }
        let on = std::mem::take(&mut machine.reached);
        let params = light.program.params.iter().enumerate().filter(|(_, p)| p.output);
        let outputs = params.filter_map(|(i, p)| match p.reg {
            Operand::Number(r) => Some((i, machine.regs[r.index()].clone())),
            Operand::Text(_) => None,
        });
        let outputs = outputs.collect();
        let entry = Lit {
            light: i,
            position: position.to_vec(),
            axis: axis.to_vec(),
            angle: angle.to_vec(),
            asked: self.mask.clone(),
            on,
            l,
            cl,
            ol,
            outputs,
        };
        self.lit.push(entry);
        self.light_machine = Some(machine);
        self.lit.len() - 1
    }

    /// The sum of the ambient lights.
    pub(super) fn ambient(&mut self, out: &mut Vec<f32>, scene: &dyn Scene) {
        let n = self.n;
        out.resize(3 * n, 0.0);
        for light in scene.lights().iter().filter(|l| l.program.is_ambient) {
            let mut machine = self.light_machine.take().unwrap_or_default();
            let mut points = Points::new(self.nu, n / self.nu.max(1), self.orientation);
            points.set(Global::Cl, vec![0.0; 3]);
            points.set(Global::Ps, self.places.clone());
            points.set(Global::Ns, self.facing.clone());
            machine.receiver = None;
            machine.run_where(light, &VariableSlots::default(), &mut points, scene, None);
            let cl = points.get(Global::Cl).unwrap_or(&[0.0; 3]);
            for c in 0..3 {
                let run = run_of(cl, 3, c, n);
                (0..n).for_each(|k| out[c * n + k] += at(run, k));
            }
            self.light_machine = Some(machine);
        }
    }
}
