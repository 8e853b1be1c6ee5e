//! Queries of the scene, which the host's functions answer.

use super::module::Query;
use super::writer::{Done, Writer};
use crate::ir::Reg;
use crate::ir::builtins::SceneCall;

impl Writer<'_, '_> {
    pub fn query(&mut self, name: &str, call: SceneCall, dst: Reg, args: &[Reg]) -> Done {
        let a: Vec<String> = args.iter().map(|r| self.registers.value(*r)).collect();
        let list = a.join(", ");
        let (query, otherwise, value) = match call {
            SceneCall::Transmission => (Query::Transmission, "vec3<f32>(1.0)", format!("scene_transmission({list})")),
            SceneCall::Openness => {
                let value = format!("scene_openness({}, sl_unit({}), sl_unit({}))", a[0], a[1], a[2]);
                (Query::Openness, "vec3<f32>()", value)
            }
            SceneCall::Surroundings => {
                let [place, normal, up, sun] = [&a[0], &a[1], &a[2], &a[3]];
                let value = format!("scene_surroundings({place}, sl_unit({normal}), sl_unit({up}), sl_unit({sun}))");
                (Query::Openness, "mat4x4<f32>()", value)
            }
            SceneCall::Occlusion => (Query::Hit, "0.0", format!("sl_occlusion({list})")),
            SceneCall::Trace if dst.width() == 1 => (Query::Hit, "0.0", format!("sl_trace({list})")),
            SceneCall::Trace | SceneCall::IndirectDiffuse | SceneCall::Ambient => {
                return self.refuse(format!("asks for the colours of rays by `{name}`"));
            }
        };
        if !self.module.uses(query) {
            return self.refuse(format!("calls `{name}`"));
        }
        if !self.grid {
            return self.set(dst, value);
        }
        // Rays are sent from active points alone.
        self.set(dst, otherwise.into())?;
        self.open("if on");
        self.set(dst, value)?;
        self.close();
        Ok(())
    }
}
