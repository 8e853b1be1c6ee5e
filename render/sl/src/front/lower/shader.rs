//! A whole shader.

use super::super::ast::{File, Function};
use super::super::diagnostic::{Error, error_with};
use super::state::Lower;
use crate::ir::{Program, ShaderKind};
use std::collections::HashMap;

/// Lower the shader of a file; its functions go before those of the prelude.
pub fn lower(file: &File, prelude: &[Function]) -> Result<Program, Error> {
    let Some(shader) = &file.shader else {
        let hint = "a file of functions alone is for `#include`";
        return error_with(file.end, "the file has no shader: expected surface, displacement, light …", hint);
    };
    let mut l = Lower { kind: Some(shader.kind), name: shader.name.clone(), ..Lower::default() };
    for function in prelude {
        l.functions.insert(&function.name, function);
    }
    for (k, function) in file.functions.iter().enumerate() {
        let name = &function.name;
        if file.functions[..k].iter().any(|before| before.name == *name) {
            l.unsupported.push(format!("has two functions `{name}`, of which the last alone is called"));
        }
        l.functions.insert(name, function);
    }
    l.scopes.push(HashMap::new());
    let mut params = Vec::new();
    for param in &shader.params {
        params.push(l.parameter(param)?);
    }
    for statement in &shader.body {
        l.statement(statement)?;
    }
    l.unsupported.sort();
    l.unsupported.dedup();
    Ok(Program {
        unsupported: l.unsupported,
        kind: shader.kind,
        name: shader.name.clone(),
        file: String::new(),
        widths: l.widths,
        n_texts: l.n_texts as usize,
        params,
        globals: l.globals,
        body: l.ops,
        variables: vec![],
        is_ambient: shader.kind == ShaderKind::Light && !l.directed,
        keeps_opacity: false,
        is_opaque: false,
        reads_neighbours: true,
        asks_displacement: true,
        traces: true,
        places: vec![],
    })
}
