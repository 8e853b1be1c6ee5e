//! Compilation: source text to a validated program.

use super::ast;
use super::diagnostic::{Diagnostic, Error, error};
use super::lex::lex;
use super::lower::lower;
use super::parse::parse;
use super::prelude::PRELUDE;
use super::preprocess::{Include, preprocess};
use super::source::Sources;
use crate::ir::{self, Program};
use std::path::Path;

/// Compile the shader in the text `source`, read from `path`; `#include` is an error. The program is optimised and valid.
pub fn compile(path: &Path, source: &str) -> Result<Program, Diagnostic> {
    compile_with(path, source, &|name, _| Err(format!("`{name}` was not found: nothing is looked up here")))
}

/// Compile the shader in the text `source`, read from `path`; `include` finds the files that `#include` names.
pub fn compile_with(path: &Path, source: &str, include: &Include<'_>) -> Result<Program, Diagnostic> {
    let mut sources = Sources::default();
    let mut program = front(path, source, include, &mut sources).map_err(|e| sources.place(e))?;
    program.file = path.display().to_string();
    program.places = places(&program, &sources);
    ir::validate(&program).map_err(|m| sources.place(Error::new(0, format!("internal: {m}"))))?;
    Ok(program)
}

/// The places of operations that have one.
fn places(program: &Program, sources: &Sources) -> Vec<(u32, String)> {
    let mut found = vec![];
    let mut note = |op: &ir::Op| match op {
        ir::Op::Loop(.., at)
        | ir::Op::Within(.., at)
        | ir::Op::Load(.., at)
        | ir::Op::Store(.., at)
        | ir::Op::TextLoad(.., at)
        | ir::Op::TextStore(.., at)
        | ir::Op::ColorSpace(.., at)
        | ir::Op::Transform(.., at)
        | ir::Op::Ask { what: ir::Ask::TextureInfo, place: at, .. }
        | ir::Op::Map { place: at, .. }
        | ir::Op::Format(.., at) => found.push(*at),
        _ => {}
    };
    program.params.iter().map(|p| &p.default).chain([&program.body]).for_each(|ops| ir::visit(ops, &mut note));
    found.sort_unstable();
    found.dedup();
    let place = |at: u32| {
        let d = sources.place(Error::new(at as usize, ""));
        (at, format!("{}:{}:{}", d.file.display(), d.line, d.column))
    };
    found.into_iter().map(place).collect()
}

fn front(path: &Path, source: &str, include: &Include<'_>, sources: &mut Sources) -> Result<Program, Error> {
    static PARSED: std::sync::OnceLock<ast::File> = std::sync::OnceLock::new();
    let prelude =
        PARSED.get_or_init(|| parse(&lex(PRELUDE).expect("the prelude is sound")).expect("the prelude is sound"));
    let tokens = preprocess(path, source, sources, include)?;
    if source.trim().is_empty() {
        return error(0, "is empty, expected a shader");
    }
    let file = parse(&tokens)?;
    let mut program = lower(&file, &prelude.functions)?;
    ir::optimise(&mut program);
    Ok(program)
}
