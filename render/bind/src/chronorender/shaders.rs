//! Shaders of a job: their names and parameters, as values and as RIB.

use super::job::{Job, text};
use crate::binding::Shader;
use frame::Fault;
use ri::{Class, Param, Type, Values};
use serde_yaml::Value;
use std::collections::BTreeMap;

/// A shader: its name and its parameters.
pub(super) fn shader(job: &Job<'_>, key: &str, value: &Value) -> Result<Shader, Fault> {
    let map = job.map(key, value, &[])?;
    let Some(name) = map.get("name") else { return Err(job.doc.fault(key, "a shader needs a `name`")) };
    let mut params = BTreeMap::new();
    for (name, value) in &map {
        if matches!(name.as_str(), "name" | "type") {
            continue;
        }
        // `int samples: 4`: the last word is the name.
        let name = name.split_whitespace().last().unwrap_or(name).to_string();
        let words = text(value);
        let numbers: Vec<f32> = words.split_whitespace().filter_map(|w| w.parse().ok()).collect();
        let param = match (numbers.as_slice(), value) {
            ([x], _) => Param::floats(&name, Class::Uniform, Type::Float, [*x]),
            ([r, g, b], _) => Param::floats(&name, Class::Uniform, Type::Color, [*r, *g, *b]),
            (_, Value::Sequence(list)) if list.len() == 3 => {
                let v = job.numbers(&format!("{key}.{name}"), value, 3)?;
                Param::floats(&name, Class::Uniform, Type::Color, [v[0] as f32, v[1] as f32, v[2] as f32])
            }
            _ => Param::string(&name, &words),
        };
        params.insert(name, param);
    }
    Ok(Shader {
        name: text(name).trim_end_matches(".sl").to_string(),
        bound: None,
        params: params.into_values().collect(),
    })
}

/// A shader's parameters in RIB.
pub(super) fn arguments(shader: &Shader) -> String {
    let one = |param: &Param| {
        let values = match &param.values {
            Values::Floats(v) => v.iter().map(f32::to_string).collect::<Vec<_>>().join(" "),
            Values::Strings(v) => format!("\"{}\"", v.join(" ")),
        };
        format!(" \"{}\" [{values}]", param.decl.inline())
    };
    shader.params.iter().map(one).collect()
}
