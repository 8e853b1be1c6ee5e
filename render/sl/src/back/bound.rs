//! Shaders with their parameters given.

use crate::ir::Program;
use std::sync::Arc;

/// A shader with its parameters given.
#[derive(Clone, Debug)]
pub struct BoundShader {
    /// The program.
    pub program: Arc<Program>,
    /// Values of parameters by their slots, numbers in the current space; what has none is computed whenever the shader runs.
    values: Vec<Option<Answer>>,
    /// The categories that a light is of.
    categories: Vec<String>,
}

impl BoundShader {
    /// A program with values for some of its parameters, by their slots; the first that is given counts.
    pub fn given(program: Arc<Program>, numbers: Vec<(usize, Vec<f32>)>, texts: Vec<(usize, String)>) -> BoundShader {
        let mut values = vec![None; program.params.len()];
        let numbers = numbers.into_iter().map(|(slot, v)| (slot, Answer::Numbers(v)));
        for (slot, value) in numbers.chain(texts.into_iter().map(|(slot, t)| (slot, Answer::Text(t)))) {
            values[slot].get_or_insert(value);
        }
        let mut bound = BoundShader { program, values, categories: vec![] };
        bound.find_categories();
        bound
    }

    /// The value of a parameter, by its slot.
    pub fn value(&self, slot: usize) -> Option<&Answer> {
        self.values[slot].as_ref()
    }

    /// Give a parameter another value.
    pub fn set(&mut self, slot: usize, value: Answer) {
        self.values[slot] = Some(value);
        self.find_categories();
    }

    /// The values of a parameter, by its name: of the whole shader, not of a point.
    pub fn parameter(&self, name: &str) -> Option<Answer> {
        self.value(self.program.params.iter().position(|p| p.name == name)?).cloned()
    }

    /// Whether a light is of a category: its parameter `__category` names its own, separated by commas; `-` asks for all others.
    pub fn in_category(&self, asked: &str) -> bool {
        let has = |name: &str| self.categories.iter().any(|c| c == name);
        match asked.strip_prefix('-') {
            Some(not) => !has(not),
            None => asked.is_empty() || has(asked),
        }
    }

    fn find_categories(&mut self) {
        let own = match self.parameter("__category") {
            Some(Answer::Text(text)) => text,
            _ => String::new(),
        };
        self.categories = own.split(',').map(|c| c.trim().to_string()).collect();
    }
}

/// An answer of the scene, or the value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// Numbers, in the current space.
    Numbers(Vec<f32>),
    /// Text.
    Text(String),
}
