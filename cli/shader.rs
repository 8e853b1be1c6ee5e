//! `scree shader`: check a shader and say what it is: its kind, its parameters with their types and defaults, and its IR.

use crate::args::ShaderArgs;
use crate::library;
use crate::report::{Exit, Failure, Outcome};
use frame::FaultKind;
use render::ri::files::Files;
use render::sl::ir::{Kind, Program};
use render::sl::machine::{Answer, BoundShader, Lights};
use std::path::Path;
use std::sync::Arc;

/// The command.
pub fn command(args: &ShaderArgs) -> Outcome {
    let mut worst = None;
    for path in &args.files {
        match compile(path) {
            Ok(program) => print(program, args.ir),
            Err(failure) => {
                eprintln!("error: {failure}");
                worst = Some(failure.exit);
            }
        }
    }
    match worst {
        None => Ok(()),
        Some(exit) => Err(Failure::new(exit, "not every shader is sound")),
    }
}

/// Compile a file, or a shader of the library by its name.
fn compile(path: &Path) -> Outcome<Program> {
    if path.is_file() {
        return compile_file(path);
    }
    let files = library::files(path.parent().unwrap_or(Path::new(".")));
    let mut name = path.to_string_lossy().into_owned();
    if !name.ends_with(".sl") {
        name += ".sl";
    }
    let rooms = ["surface", "displacement", "light", "volume", "imager"].map(|k| format!("shaders/{k}"));
    let rooms: Vec<&str> = rooms.iter().map(String::as_str).collect();
    let (path, text) = files.read(&name, &rooms).map_err(|m| Failure::new(Exit::Input, format!("shader {m}")))?;
    compile_text(&path, &text, &files)
}

/// Compile a file.
pub fn compile_file(path: &Path) -> Outcome<Program> {
    let text = frame::read_text(FaultKind::Input, path)?;
    compile_text(path, &text, &library::files(path.parent().unwrap_or(Path::new("."))))
}

fn compile_text(path: &Path, text: &str, files: &Files) -> Outcome<Program> {
    Ok(render::sl::compile_with(path, text, &|name, from| files.include(name, from))?)
}

fn print(program: Program, ir: bool) {
    if ir {
        print!("{program}");
        return;
    }
    println!("{} \"{}\"", program.kind.name(), program.name);
    let bound = BoundShader::new(Arc::new(program), vec![], vec![], &Lights(vec![]));
    for p in &bound.program.params {
        let class = if p.varying { "varying" } else { "uniform" };
        let output = if p.output { "output " } else { "" };
        let array = p.array.map_or(String::new(), |n| format!("[{n}]"));
        let value = match bound.parameter(&p.name) {
            Some(Answer::Text(text)) => format!("{text:?}"),
            Some(Answer::Numbers(v)) => {
                let each: Vec<String> = v.chunks(p.kind.width()).map(show).collect();
                if p.array.is_some() { format!("{{{}}}", each.join(", ")) } else { each.concat() }
            }
            None => String::new(),
        };
        let kind = if p.kind == Kind::Text { "string" } else { p.kind.name() };
        println!("    \"{}\" \"{output}{class} {kind}{array}\"\n\t\tDefault value: {value}", p.name);
    }
}

fn show(v: &[f32]) -> String {
    let list: Vec<String> = v.iter().map(f32::to_string).collect();
    if v.len() == 1 { list.concat() } else { format!("[{}]", list.join(" ")) }
}
