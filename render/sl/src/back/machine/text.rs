//! Strings: formats, and what the scene is asked by name.

use super::super::bound::Answer;
use super::super::scene::{Scene, asked_in_vain};
use super::state::Machine;
use crate::ir::*;
use crate::shadeop::runs::{at, run_of};

impl Machine {
    /// The text of a format at a point.
    pub(super) fn format(&self, args: &[Operand], k: usize) -> String {
        let values: Vec<crate::shadeop::format::Value> = args
            .iter()
            .map(|o| match o {
                Operand::Text(r) => crate::shadeop::format::Value::Text(&self.texts[r.index()]),
                Operand::Number(r) => {
                    let w = r.width();
                    let value = |c: usize| at(run_of(&self.regs[r.index()], w, c, self.n), k);
                    crate::shadeop::format::Value::Numbers((0..w).map(value).collect())
                }
            })
            .collect();
        crate::shadeop::format::format(&values)
    }

    pub(super) fn ask(
        &mut self,
        dst: FloatReg,
        what: Ask,
        names: &[TextReg],
        (out, len): (Operand, u16),
        place: u32,
        scene: &dyn Scene,
    ) {
        let names: Vec<&str> = names.iter().map(|r| self.texts[r.index()].as_str()).collect();
        let answer = match (what, names[0]) {
            (Ask::LightSource, name) => {
                self.turn.and_then(|(light, lit)| self.light_parameter(scene.lights().get(light)?, lit, name))
            }
            (Ask::ShaderName, "lightsource") => {
                let light = self.turn.and_then(|(light, _)| scene.lights().get(light));
                light.map(|light| Answer::Text(light.program.name.clone()))
            }
            (Ask::RendererInfo, "renderer") => Some(Answer::Text("scree".into())),
            (Ask::RendererInfo, "versionstring") => Some(Answer::Text(env!("CARGO_PKG_VERSION").into())),
            (Ask::RendererInfo, "version") => {
                let parts = env!("CARGO_PKG_VERSION").split('.').map(|p| p.parse().unwrap_or(0.0));
                Some(Answer::Numbers(parts.chain([0.0]).collect()))
            }
            _ => {
                let told = self.messages.iter().find(|told| told.from == what && told.name == names[0]);
                told.map(|told| Answer::Numbers(told.values.clone())).or_else(|| scene.ask(what, &names))
            }
        };
        let fault = if answer.is_none() { asked_in_vain(what, &names, scene) } else { None };
        let mut found = 0.0;
        match (answer, out) {
            (Some(Answer::Text(text)), Operand::Text(r)) => {
                self.texts[r.index()] = text;
                found = 1.0;
            }
            (Some(Answer::Texts(texts)), Operand::Text(r)) if texts.len() >= len as usize => {
                let own = &mut self.texts[r.index()..][..len as usize];
                own.clone_from_slice(&texts[..len as usize]);
                found = 1.0;
            }
            (Some(Answer::Numbers(v)), Operand::Number(r)) => {
                let w = r.width();
                let varying = v.len() == w * self.n && len == 1;
                if varying || v.len() >= w * len as usize {
                    let each = if varying { v.len() } else { w };
                    for k in 0..len as usize {
                        self.assign_value(r.element(k as u16), &v[k * each..(k + 1) * each]);
                    }
                    found = 1.0;
                }
            }
            _ => {}
        }
        self.regs[dst.index()] = vec![found];
        fault.into_iter().for_each(|message| self.refuse(place, message));
    }
}
