//! `scree shader`: the kind of a shader and its parameters with their types and defaults, or its intermediate representation.

use crate::job::{ShaderFile, ShaderJob};
use crate::report::{Failure, Outcome};
use render::sl::ir::{Kind, Program};
use render::sl::machine::{Answer, BoundShader, Lights};
use std::sync::Arc;

/// Run `scree shader`.
pub fn run(job: ShaderJob) -> Outcome {
    let mut last_exit = None;
    for shader in job.shaders {
        match shader.and_then(|shader| compile(&shader)) {
            Ok(program) if job.ir => print!("{program}"),
            Ok(program) => print(program),
            Err(failure) => {
                eprintln!("error: {failure}");
                last_exit = Some(failure.exit);
            }
        }
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

fn print(program: Program) {
    println!("{} \"{}\"", program.kind.name(), program.name);
    let bound = BoundShader::new(Arc::new(program), vec![], vec![], &Lights(vec![]));
    for p in &bound.program.params {
        let class = if p.varying { "varying" } else { "uniform" };
        let output = if p.output { "output " } else { "" };
        let array = p.array.map_or(String::new(), |n| format!("[{n}]"));
        let value = match bound.parameter(&p.name) {
            Some(Answer::Text(text)) => format!("{text:?}"),
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
