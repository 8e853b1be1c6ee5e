//! Shaders with their parameters given.

use crate::ir::opacity::of_opacity;
use crate::ir::{Kind, Program};
use glam::{Mat3, Mat4, Vec3};
use std::sync::{Arc, OnceLock};

/// A shader bound to values of its parameters.
#[derive(Clone, Debug)]
pub struct BoundShader {
    /// The compiled shader.
    pub program: Arc<Program>,
    /// Values of parameters by their slots, numbers in the current space; what has none is computed whenever the shader runs.
    values: Vec<Option<Answer>>,
    /// The categories that a light is of.
    categories: Vec<String>,
    /// The name of the space that it was set in, if that is none of what is shaded, but its own: of a light.
    space: Option<Arc<str>>,
    /// What of it says how opaque a surface is, once a ray has asked.
    of_opacity: OnceLock<Arc<BoundShader>>,
}

/// The name by which the scene knows a space that a shader names, whose own space, if it has one, is "shader" to it.
pub(in crate::back) fn known_as<'a>(own: Option<&'a str>, name: &'a str) -> &'a str {
    own.filter(|_| name == "shader").unwrap_or(name)
}

impl BoundShader {
    /// Bind values to some of a program's parameters, by slot (the index in [`Program::params`]). Of several values for one slot
    /// the first counts; parameters without a value are computed whenever the shader runs. Text is one string, or those of an array, of
    /// which those that are not given are empty.
    pub fn given(
        program: Arc<Program>,
        numbers: Vec<(usize, Vec<f32>)>,
        texts: Vec<(usize, Vec<String>)>,
    ) -> BoundShader {
        let mut values = vec![None; program.params.len()];
        let numbers = numbers.into_iter().map(|(slot, v)| (slot, Answer::Numbers(v)));
        let texts = texts.into_iter().map(|(slot, mut texts)| match program.params[slot].array {
            Some(n) => {
                texts.resize(n as usize, String::new());
                (slot, Answer::Texts(texts))
            }
            None => (slot, Answer::Text(texts.swap_remove(0))),
        });
        for (slot, value) in numbers.chain(texts) {
            values[slot].get_or_insert(value);
        }
        let mut bound = BoundShader { program, values, categories: vec![], space: None, of_opacity: OnceLock::new() };
        bound.find_categories();
        bound
    }

    /// What of a surface shader says how opaque a surface is, with the same values: what a ray runs that asks for that alone.
    pub fn of_opacity(&self) -> &Arc<BoundShader> {
        self.of_opacity.get_or_init(|| {
            let program = Arc::new(of_opacity(&self.program));
            Arc::new(BoundShader { program, of_opacity: OnceLock::new(), ..self.clone() })
        })
    }

    /// Whether it answers as another does wherever both run.
    pub fn is_as(&self, other: &BoundShader) -> bool {
        let same = |a: &BoundShader, b: &BoundShader| {
            Arc::ptr_eq(&a.program, &b.program) && (&a.values, &a.space) == (&b.values, &b.space)
        };
        std::ptr::eq(self, other) || same(self, other)
    }

    /// The value bound to a parameter, by slot.
    pub fn value(&self, slot: usize) -> Option<&Answer> {
        self.values[slot].as_ref()
    }

    /// Bind another value to a parameter, by slot.
    pub fn set(&mut self, slot: usize, value: Answer) {
        self.values[slot] = Some(value);
        self.of_opacity = OnceLock::new();
        self.find_categories();
    }

    /// Give it a space of its own, by the name that the scene knows it by.
    pub fn set_space(&mut self, name: &str) {
        self.space = Some(name.into());
        self.of_opacity = OnceLock::new();
    }

    /// The name of its own space, if it has one.
    pub(in crate::back) fn own_space(&self) -> Option<Arc<str>> {
        self.space.clone()
    }

    /// The name by which the scene knows a space that the shader names: its own is "shader" to it.
    pub fn space_of<'a>(&'a self, name: &'a str) -> &'a str {
        known_as(self.space.as_deref(), name)
    }

    /// Bring what is bound to parameters that are places or directions to another space.
    pub fn transform(&mut self, m: Mat4) {
        let normals = Mat3::from_mat4(m).inverse().transpose();
        self.of_opacity = OnceLock::new();
        for (param, value) in self.program.params.iter().zip(&mut self.values) {
            let Some(Answer::Numbers(v)) = value else { continue };
            for triple in v.chunks_exact_mut(3) {
                let x = Vec3::from_slice(triple);
                let there = match param.kind {
                    Kind::Point => m.transform_point3(x),
                    Kind::Vector => m.transform_vector3(x),
                    Kind::Normal => normals * x,
                    _ => break,
                };
                triple.copy_from_slice(&there.to_array());
            }
        }
    }

    /// The value bound to a parameter, by name: the shader's, not that of a point.
    pub fn parameter(&self, name: &str) -> Option<Answer> {
        self.value(self.program.params.iter().position(|p| p.name == name)?).cloned()
    }

    /// Whether a light is of the category `asked`: its parameter `__category` lists its categories, separated by commas. An empty
    /// `asked` is every category; `-name` is every light that is not of the category `name`.
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

/// The answer to a query of the scene, or the value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// Numbers, in the current space.
    Numbers(Vec<f32>),
    /// Text.
    Text(String),
    /// Those of an array.
    Texts(Vec<String>),
}
