//! Lookups in maps, which the host's function `scene_map` answers.

use super::super::scene::{OPTIONS, unknown_option};
use super::module::{Query, Refused, Slot};
use super::writer::{Done, Writer};
use crate::ir::{Lookup, Op, Operand, Reg, TextReg};
use std::collections::HashMap;

/// The options of a lookup, as expressions.
struct Options {
    blur: [String; 2],
    change: [String; 2],
    width: String,
    fill: String,
    samples: String,
    bias: String,
}

impl Writer<'_, '_> {
    pub fn map(&mut self, op: &Op) -> Done {
        let Op::Map { dst, how, name, channel, at, options, .. } = op else { return Ok(()) };
        let name = self.text(*name, "the name of a map")?;
        if !self.module.uses(Query::Map) {
            let kind = format!("{how:?}").to_lowercase();
            return self.refuse(format!("looks up the {kind} map `{name}`"));
        }
        let options = self.options(&name, options)?;
        let id = self.fresh();
        self.place(id, *how, at)?;
        let Options { blur, change: [s, t], width, fill, samples, bias } = options;
        self.line(format!("let change_{id} = vec3<f32>({s}, {t}, 1.0);"));
        let light = self.light_of_map(id);
        let slot = self.slot(Slot::Map { how: *how, name });
        let kind = *how as u32;
        let channel = format!("u32(max({}, 0.0))", self.registers.value(*channel));
        let filter =
            format!("row_{id} * change_{id}, column_{id} * change_{id}, {width}, vec2<f32>({})", blur.join(", "));
        let query = format!("Lookup({kind}u, {channel}, at_{id}, {filter}, {fill}, {samples}, {bias}, {light})");
        self.line(format!("var found_{id}: vec4<f32>;"));
        let found = format!("found_{id} = scene_map(u32(sl_read1({slot}, 0u)), {query});");
        self.line(if self.grid { format!("if on {{ {found} }}") } else { found });
        let parts = if dst.width() == 1 { "x" } else { "xyz" };
        self.set(*dst, format!("found_{id}.{parts}"))
    }

    /// The place of a lookup and how it changes along rows and columns: from neighbours, or from the four corners of the area.
    fn place(&mut self, id: usize, how: Lookup, at: &[Reg]) -> Done {
        let each = if how == Lookup::Texture { 2 } else { 1 };
        let corners: Vec<String> = at
            .chunks(each)
            .map(|at| match at {
                [s, t] => format!("vec3<f32>({}, {}, 0.0)", self.registers.value(*s), self.registers.value(*t)),
                _ => self.registers.value(at[0]),
            })
            .collect();
        if let [a, b, c, d] = &corners[..] {
            self.line(format!("let at_{id} = 0.25 * ({a} + {b} + {c} + {d});"));
            self.line(format!("let row_{id} = 0.5 * ({b} + {d} - {a} - {c});"));
            self.line(format!("let column_{id} = 0.5 * ({c} + {d} - {a} - {b});"));
            return Ok(());
        }
        if !self.grid {
            return self.refuse("looks up a map where points run alone");
        }
        self.line(format!("let at_{id} = {};", corners[0]));
        let beside = format!("sl_differences(vec4<f32>(at_{id}, 0.0))");
        let beside = if self.index > 0 { beside } else { format!("sl_over({beside})") };
        self.line(format!("let beside_{id} = {beside};"));
        self.line(format!("let row_{id} = beside_{id}.row.xyz;"));
        self.line(format!("let column_{id} = beside_{id}.column.xyz;"));
        Ok(())
    }

    /// The options by their names; others are warned of.
    fn options(&self, map: &str, given: &[(TextReg, Operand)]) -> Result<Options, Refused> {
        let mut found = HashMap::new();
        for (name, value) in given {
            let name = self.text(*name, "the name of an option of a lookup")?;
            if !OPTIONS.contains(&name.as_str()) {
                self.warn(unknown_option(map, &name));
                continue;
            }
            if let Operand::Number(r) = value
                && r.width() == 1
            {
                found.insert(name, self.registers.value(*r));
            }
        }
        let number = |name: &str, otherwise: &str| found.get(name).cloned().unwrap_or(otherwise.into());
        let blur = number("blur", "0.0");
        Ok(Options {
            blur: [number("sblur", &blur), number("tblur", &blur)],
            change: [number("swidth", "1.0"), number("twidth", "1.0")],
            width: number("width", "1.0"),
            fill: number("fill", "0.0"),
            samples: number("samples", "16.0"),
            bias: number("bias", "0.0"),
        })
    }

    /// In a light, whether it has a position and where the light of a lookup comes from: its ray ends at the place, and a sun's begins
    /// far away.
    fn light_of_map(&mut self, id: usize) -> String {
        let Some((l, is_sun)) = self.ray else { return "false, vec3<f32>()".into() };
        let l = self.registers.name(l);
        let way = if is_sun { format!("{l} * (1e6 / max(sqrt(dot({l}, {l})), 1e-20))") } else { l };
        format!("true, at_{id} - {way}")
    }
}
