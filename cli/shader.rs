//! `scree shader`: the kind of a shader and its parameters with their types and defaults, or its intermediate representation.

use crate::job::{ShaderFile, ShaderJob};
use crate::report::{Failure, Outcome};
use render::sl::ir::{Kind, Program};
use render::sl::machine::{Answer, BoundShader, Lights};
use std::sync::Arc;

/// Run `scree shader`.
pub fn run(job: ShaderJob) -> Outcome {
    let (mut last_exit, mut described) = (None, vec![]);
    for shader in job.shaders {
        match shader.and_then(|shader| compile(&shader)) {
            Ok(program) if job.ir => print!("{program}"),
            Ok(program) if job.json => described.push(as_json(program)),
            Ok(program) => print(program),
            Err(failure) => {
                eprintln!("error: {failure}");
                last_exit = Some(failure.exit);
            }
        }
    }
    if job.json {
        println!("{}", serde_json::Value::from(described));
    }
    match last_exit {
        None => Ok(()),
        Some(exit) => Err(Failure::new(exit, "not every shader compiles")),
    }
}

/// Compile a shader.
pub fn compile(shader: &ShaderFile) -> Outcome<Program> {
    Ok(render::sl::compile_with(&shader.path, &shader.text, &|name, from| shader.files.include(name, from))?)
}

/// A shader for programs: a default is a text, a number, or a list of the numbers.
fn as_json(program: Program) -> serde_json::Value {
    let (kind, name) = (program.kind.name(), program.name.clone());
    let bound = BoundShader::new(Arc::new(program), vec![], vec![], &Lights(vec![]));
    let parameters = bound.program.params.iter().map(|p| {
        let default = match bound.parameter(&p.name) {
            Some(Answer::Text(text)) => serde_json::json!(text),
            Some(Answer::Texts(texts)) => serde_json::json!(texts),
            Some(Answer::Numbers(v)) if v.len() == 1 => serde_json::json!(v[0]),
            Some(Answer::Numbers(v)) => serde_json::json!(v),
            None => serde_json::Value::Null,
        };
        serde_json::json!({
            "name": p.name, "type": if p.kind == Kind::Text { "string" } else { p.kind.name() }, "array": p.array,
            "varying": p.varying, "output": p.output, "default": default,
        })
    });
    serde_json::json!({"kind": kind, "name": name, "parameters": parameters.collect::<Vec<_>>()})
}

fn print(program: Program) {
    println!("{} \"{}\"", program.kind.name(), program.name);
    let bound = BoundShader::new(Arc::new(program), vec![], vec![], &Lights(vec![]));
    for p in &bound.program.params {
        let class = if p.varying { "varying" } else { "uniform" };
        let output = if p.output { "output " } else { "" };
        let array = p.array.map_or(String::new(), |n| format!("[{n}]"));
        let value = match bound.parameter(&p.name) {
            Some(Answer::Text(text)) => format!("{text:?}"),
            Some(Answer::Texts(texts)) => {
                let each: Vec<String> = texts.iter().map(|text| format!("{text:?}")).collect();
                format!("{{{}}}", each.join(", "))
            }
            Some(Answer::Numbers(v)) => {
                let each: Vec<String> = v.chunks(p.kind.width()).map(tuple).collect();
                if p.array.is_some() { format!("{{{}}}", each.join(", ")) } else { each.concat() }
            }
            None => String::new(),
        };
        let kind = if p.kind == Kind::Text { "string" } else { p.kind.name() };
        println!("    \"{}\" \"{output}{class} {kind}{array}\"\n\t\tDefault value: {value}", p.name);
    }
}

/// The text of a value: a float, or the components of a point, color or matrix in brackets.
fn tuple(v: &[f32]) -> String {
    let list: Vec<String> = v.iter().map(f32::to_string).collect();
    if v.len() == 1 { list.concat() } else { format!("[{}]", list.join(" ")) }
}
