//! Lights: `illuminance` in surfaces, `solar` and `illuminate` in lights.

use super::module::Refused;
use super::registers::type_of;
use super::writer::{Done, Leaves, OfLight, Writer};
use crate::ir::walk::blocks;
use crate::ir::{Ask, FloatReg, Global, Op, Operand, Reg, TripleReg};
use std::collections::BTreeSet;

impl Writer<'_, '_> {
    pub fn illuminance(&mut self, op: &Op) -> Done {
        let Op::Illuminance { body, category, .. } = op else { return Ok(()) };
        let category = category.map(|c| self.text(c, "a category of lights")).transpose()?.unwrap_or_default();
        let bit = match category.as_str() {
            "" => None,
            name => match self.module.category(name) {
                None => return self.refuse("asks for more than 32 categories of lights"),
                bit => bit,
            },
        };
        let together = self.grid && self.is_together(op);
        self.texts.forget(body);
        let outer = self.of_light.take();
        self.alone(together, |w| w.lights(op, together, bit))?;
        self.of_light = outer;
        self.texts.forget(body);
        Ok(())
    }

    /// The loop over lights.
    fn lights(&mut self, op: &Op, together: bool, category: Option<u32>) -> Done {
        let Op::Illuminance { position, axis, angle, l, cl, wanted, body, .. } = op else { return Ok(()) };
        if wanted.iter().any(|(name, _)| name == Global::Ol.name()) {
            return self.refuse("reads `Ol`");
        }
        let [position, axis] = [position, axis].map(|r| self.registers.value(*r));
        let angle = self.registers.value(*angle);
        let turn = self.begin_turns();
        let id = self.enter(Leaves::Lights);
        self.line(format!("let place_{id} = {position};"));
        self.line(format!("let axis_{id} = {axis};"));
        self.line(format!("let cosine_{id} = sl_cone({angle});"));
        self.next_light(id, together, category);
        if let Some(turn) = turn {
            self.line(format!("turn = sl_turn(outer_turn_{turn}, i_{id} + 1u);"));
        }
        let [l, cl] = [l, cl].map(|r| self.registers.name(*r));
        self.line(format!("{l} = -lit_{id}.l;"));
        self.line(format!("{cl} = lit_{id}.cl;"));
        self.light_parameters(id, wanted, body)?;
        self.masks += together as usize;
        self.block(body)?;
        self.masks -= together as usize;
        if together {
            self.close();
        }
        if let (Some(turn), true) = (turn, together) {
            self.line(format!("turn = outer_turn_{turn};"));
        }
        if together {
            let gone = self.gone();
            self.line(format!("on = outer_{id}{gone};"));
            self.line(format!("outer_{id} = on;"));
        }
        self.close();
        self.end_turns(turn);
        self.exit();
        Ok(())
    }

    /// Begin the loop's body: the next light, and what it gives; go on to another where it gives nothing.
    fn next_light(&mut self, id: usize, together: bool, category: Option<u32>) {
        if together {
            self.line(format!("var outer_{id} = on;"));
            self.line(format!("var next_{id} = 0u;"));
            self.open("loop");
            self.line(format!("let i_{id} = sl_uniform(next_{id});"));
            self.line(format!("if i_{id} >= work.n_lights {{ break; }}"));
            self.line(format!("next_{id} += 1u;"));
        } else {
            self.open(format!("for (var i_{id} = 0u; i_{id} < work.n_lights; i_{id} += 1u)"));
        }
        self.line(format!("let light_{id} = lights[work.first_light + i_{id}];"));
        let not_asked = category.map_or(String::new(), |bit| format!(" || (light_{id}.z >> {bit}u & 1u) == 0u"));
        self.line(format!("if light_{id}.w != 0u{not_asked} {{ continue; }}"));
        let on = if together { "on" } else { "true" };
        let given = format!("place_{id}, sl_light_normal(axis_{id}), axis_{id}, cosine_{id}");
        self.line(format!("let lit_{id} = run_light(light_{id}, {on}, {given});"));
        if together {
            self.line(format!("on = outer_{id} && lit_{id}.on;"));
            self.open("if sl_any(on)");
        } else {
            self.line(format!("if !lit_{id}.on {{ continue; }}"));
        }
    }

    /// Parameters of the current light that the loop's body asks for, as they are before it runs.
    fn light_parameters(&mut self, id: usize, wanted: &[(String, Reg)], body: &[Op]) -> Done {
        let mut asked: BTreeSet<(String, usize)> = wanted.iter().map(|(name, r)| (name.clone(), r.width())).collect();
        self.asked_of_light(body, &mut asked)?;
        let mut of_light = OfLight::new();
        for (k, (name, width)) in asked.into_iter().enumerate() {
            let function = self.light_parameter(&name, width)?;
            let (has, value) = (format!("has_{id}_{k}"), format!("of_{id}_{k}"));
            self.line(format!("var {value}: {};", type_of(width)));
            self.line(format!("let {has} = {function}(light_{id}, &{value});"));
            of_light.insert((name, width), (has, value));
        }
        for (name, r) in wanted {
            let (has, value) = of_light[&(name.clone(), r.width())].clone();
            let r = self.registers.name(*r);
            let on = if self.grid { " && on" } else { "" };
            self.line(format!("if {has}{on} {{ {r} = {value}; }}"));
        }
        self.of_light = Some(of_light);
        Ok(())
    }

    /// What the operations of a loop over lights, but those of loops within it, ask of the light.
    fn asked_of_light(&self, ops: &[Op], found: &mut BTreeSet<(String, usize)>) -> Done {
        for op in ops {
            match op {
                Op::Ask { what: Ask::LightSource, names, out: Operand::Number(out), .. } => {
                    // Names are known from the block itself, if not from before it.
                    let mut texts = self.texts.clone();
                    ops.iter().for_each(|op| texts.step(op, &self.constants, self.module.host.scene));
                    match texts.get(names[0]) {
                        Some(name) => _ = found.insert((name.into(), out.width())),
                        None => return self.refuse("asks a light for a name that is only known while it runs"),
                    }
                }
                Op::Illuminance { .. } => {}
                _ => blocks(op).into_iter().try_for_each(|block| self.asked_of_light(block, found))?,
            }
        }
        Ok(())
    }

    /// The function that reads a parameter of any light.
    fn light_parameter(&mut self, name: &str, width: usize) -> Result<String, Refused> {
        let stem: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let function = format!("light_parameter_{stem}_{width}");
        let mut cases = String::new();
        for (k, light) in self.module.lights.iter().enumerate() {
            let Some((_, slot, own, computed)) = light.parameters.iter().find(|p| p.0 == name) else { continue };
            if *own != width {
                return self.refuse(format!("asks a light for its parameter `{name}` as another type"));
            }
            let (shader, slot) = (k + 1, slot + Global::COUNT);
            let given = format!("*value = given_{shader}_{slot}; return true;");
            let read =
                format!("*value = sl_read{width}(light.y + {slot}u, 0u); return slots[light.y + {slot}u].y != 0u;");
            cases += &format!("        case {shader}u: {{ {} }}\n", if *computed { given } else { read });
        }
        let ty = type_of(width);
        let head = format!("fn {function}(light: vec4<u32>, value: ptr<function, {ty}>) -> bool");
        let text =
            format!("\n{head} {{\n    switch light.x {{\n{cases}        default: {{ return false; }}\n    }}\n}}\n");
        self.define(&function, text);
        Ok(function)
    }

    /// `lightsource`
    pub fn ask_light(&mut self, dst: FloatReg, name: &str, out: Reg) -> Done {
        let found = self.of_light.as_ref().and_then(|of| of.get(&(name.to_string(), out.width()))).cloned();
        let Some((has, value)) = found else { return self.set(dst.into(), "0.0".into()) };
        self.set(dst.into(), format!("f32({has})"))?;
        let out = self.registers.name(out);
        let on = if self.grid { " && on" } else { "" };
        self.line(format!("if {has}{on} {{ {out} = {value}; }}"));
        Ok(())
    }

    /// `solar`: the axis is the way that light travels.
    pub fn solar(&mut self, axis: TripleReg, l: TripleReg, body: &[Op]) -> Done {
        let axis = self.registers.value(axis);
        self.assign(l.into(), &axis);
        self.reached(l, true, "vec3<f32>(), -2.0", body)
    }

    /// `illuminate`
    pub fn illuminate(&mut self, op: &Op) -> Done {
        let Op::Illuminate { position, axis, angle, l, ps, body } = op else { return Ok(()) };
        let [position, axis, ps] = [position, axis, ps].map(|r| self.registers.value(*r));
        self.set((*l).into(), format!("{ps} - {position}"))?;
        let cone = format!("{axis}, sl_cone({})", self.registers.value(*angle));
        self.reached(*l, false, &cone, body)
    }

    /// What a light does at the points in its cone and in the receiver's.
    fn reached(&mut self, l: TripleReg, is_sun: bool, cone: &str, body: &[Op]) -> Done {
        self.ray = Some((l, is_sun));
        let reaches = format!("sl_reaches({}, {cone}, receiver, receiver_cosine)", self.registers.name(l));
        let before = self.texts.clone();
        if self.grid {
            let id = self.fresh();
            self.line(format!("let outer_{id} = on;"));
            self.line(format!("on = on && {reaches};"));
            self.line("lit_on = lit_on || on;");
            self.open("if sl_any(on)");
            self.masks += 1;
            self.block(body)?;
            self.masks -= 1;
            self.close();
            let gone = self.gone();
            self.line(format!("on = outer_{id}{gone};"));
        } else {
            self.open(format!("if {reaches}"));
            self.line("lit_on = true;");
            self.block(body)?;
            self.close();
        }
        self.texts.merge(&before);
        self.ray = None;
        Ok(())
    }
}
