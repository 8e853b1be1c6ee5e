//! Shaders with their parameters given.

use crate::ir::Program;
use std::sync::Arc;

/// A shader with its parameters given.
#[derive(Clone, Debug)]
pub struct BoundShader {
    /// The program.
    pub program: Arc<Program>,
    /// Values given for parameters, by their index; numbers in the current space.
    pub numbers: Vec<(usize, Vec<f32>)>,
    /// Strings given for parameters, by their index.
    pub texts: Vec<(usize, String)>,
}

impl BoundShader {
    /// The values of a parameter, by its name: of the whole shader, not of a point.
    pub fn parameter(&self, name: &str) -> Option<Answer> {
        let i = self.program.params.iter().position(|p| p.name == name)?;
        let number = self.numbers.iter().find(|(k, _)| *k == i).map(|(_, v)| Answer::Numbers(v.clone()));
        number.or_else(|| self.texts.iter().find(|(k, _)| *k == i).map(|(_, t)| Answer::Text(t.clone())))
    }
}

/// An answer of the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// Numbers, in the current space.
    Numbers(Vec<f32>),
    /// Text.
    Text(String),
}
