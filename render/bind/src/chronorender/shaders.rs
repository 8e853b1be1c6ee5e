//! Shaders of a job: their names and parameters, as values and as RIB.

use super::job::{Job, list_of, text};
use crate::binding::Shader;
use frame::Fault;
use ri::{Class, Param, Params, Type, Values};
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
        traced: true,
        params: params.into_values().collect(),
    })
}

/// Attributes or options of a job by their groups: each has a `name`, and values under their types and names, as `int diffuse: 1`.
pub(super) fn settings(job: &Job<'_>, key: &str, value: Option<&Value>) -> Result<Vec<(String, Params)>, Fault> {
    let mut all = Vec::new();
    for (at, value) in list_of(key, value) {
        let map = job.map(&at, &value, &[])?;
        let Some(group) = map.get("name").map(text) else {
            job.warn(&at, "has no `name` and is left out: expected the group that it belongs to, as `visibility`");
            continue;
        };
        let params = map.iter().filter(|(name, _)| *name != "name").filter_map(|(name, value)| typed(name, value));
        all.push((group, params.collect()));
    }
    Ok(all)
}

/// A value under its type and name; without a type it is a number or a text.
fn typed(name: &str, value: &Value) -> Option<Param> {
    let (ty, name) = name.rsplit_once(' ').unwrap_or(("", name));
    let words = text(value);
    let numbers: Option<Vec<f32>> = words.split_whitespace().map(|word| word.parse().ok()).collect();
    let ty = match (ty.split_whitespace().last(), &numbers) {
        (Some("int" | "integer"), _) => Type::Integer,
        (Some("color"), _) => Type::Color,
        (Some("point"), _) => Type::Point,
        (Some("string"), _) | (None, None) => Type::String,
        _ => Type::Float,
    };
    match numbers {
        _ if ty == Type::String => Some(Param::string(name, &words)),
        Some(numbers) if numbers.len() == ty.width() => Some(Param::floats(name, Class::Uniform, ty, numbers)),
        _ => None,
    }
}

/// Settings as requests of RIB.
pub(super) fn requests(request: &str, settings: &[(String, Params)]) -> String {
    let line = |(group, params): &(String, Params)| format!("{request} \"{group}\"{}\n", in_rib(params));
    settings.iter().map(line).collect()
}

/// A shader's parameters in RIB.
pub(super) fn arguments(shader: &Shader) -> String {
    in_rib(&shader.params)
}

/// Parameters in RIB.
fn in_rib(params: &Params) -> String {
    let one = |param: &Param| {
        let values = match &param.values {
            Values::Floats(v) => v.iter().map(f32::to_string).collect::<Vec<_>>().join(" "),
            Values::Strings(v) => format!("\"{}\"", v.join(" ")),
        };
        format!(" \"{}\" [{values}]", param.decl.inline())
    };
    params.iter().map(one).collect()
}
