//! The strings that are known before a shader runs: those of its parameters and what it makes of them.

use super::super::bound::{Answer, BoundShader};
use super::super::scene::Scene;
use crate::ir::walk::visit;
use crate::ir::{Ask, FloatReg, Op, Operand, TextReg};
use crate::shadeop::format::{Value, format, matches};
use crate::shadeop::matrix::element;
use std::collections::HashMap;

/// What is known where an operation stands.
#[derive(Clone, Default)]
pub(super) struct Texts {
    known: HashMap<usize, String>,
}

impl Texts {
    /// The strings of a shader's parameters.
    pub fn of(shader: &BoundShader, constants: &HashMap<usize, f32>, scene: &dyn Scene) -> Texts {
        let mut texts = Texts::default();
        for (slot, param) in shader.program.params.iter().enumerate() {
            match (param.reg, shader.value(slot)) {
                (Operand::Text(r), Some(Answer::Text(text))) => texts.set(r, text.clone()),
                (Operand::Text(r), Some(Answer::Texts(own))) => texts.set_all(r, own),
                (Operand::Text(_), _) => param.default.iter().for_each(|op| texts.step(op, constants, scene)),
                _ => {}
            }
        }
        texts
    }

    /// A string, if it is known.
    pub fn get(&self, r: TextReg) -> Option<&str> {
        self.known.get(&r.index()).map(String::as_str)
    }

    fn set(&mut self, r: TextReg, text: String) {
        self.known.insert(r.index(), text);
    }

    fn set_all(&mut self, first: TextReg, texts: &[String]) {
        (0u16..).zip(texts).for_each(|(k, text)| self.set(first.element(k), text.clone()));
    }

    /// Set a string to one that may not be known.
    fn put(&mut self, r: TextReg, text: Option<String>) {
        match text {
            Some(text) => self.set(r, text),
            None => _ = self.known.remove(&r.index()),
        }
    }

    /// What a plain operation makes of strings.
    pub fn step(&mut self, op: &Op, constants: &HashMap<usize, f32>, scene: &dyn Scene) {
        let element_of = |first: TextReg, len: u16, index: FloatReg| {
            let k = element(*constants.get(&index.index())?, len)?;
            Some(first.element(k as u16))
        };
        match op {
            Op::TextConst(r, text) => self.set(*r, text.clone()),
            Op::TextCopy(r, a) => self.put(*r, self.get(*a).map(String::from)),
            Op::TextLoad(r, first, len, index, _) => {
                let found = element_of(*first, *len, *index).and_then(|a| self.get(a));
                self.put(*r, found.map(String::from));
            }
            Op::TextStore(first, len, index, value, _) => match element_of(*first, *len, *index) {
                Some(r) => self.put(r, self.get(*value).map(String::from)),
                None => first.array(*len).for_each(|r| self.put(r, None)),
            },
            Op::Format(r, args, _) => self.put(*r, self.format(args, constants)),
            Op::Ask { what, names, out: Operand::Text(r), len, .. } => {
                let names: Option<Vec<&str>> = names.iter().map(|r| self.get(*r)).collect();
                match names.and_then(|names| ask(*what, &names, scene)) {
                    Some(Answer::Text(text)) => self.set(*r, text),
                    Some(Answer::Texts(texts)) if texts.len() >= *len as usize => {
                        self.set_all(*r, &texts[..*len as usize]);
                    }
                    _ => {}
                }
            }
            _ => {}
        }
    }

    /// The text of a format whose values are all known.
    fn format(&self, args: &[Operand], constants: &HashMap<usize, f32>) -> Option<String> {
        let value = |o: &Operand| match o {
            Operand::Text(r) => self.get(*r).map(Value::Text),
            Operand::Number(r) => constants.get(&r.index()).map(|x| Value::Numbers(vec![*x; r.width()])),
        };
        args.iter().map(value).collect::<Option<Vec<_>>>().map(|values| format(&values))
    }

    /// Whether two strings are equal, or one matches a pattern, if both are known.
    pub fn truth(&self, op: &Op) -> Option<(FloatReg, bool)> {
        match op {
            Op::TextEqual(dst, a, b) => Some((*dst, self.get(*a)? == self.get(*b)?)),
            Op::Match(dst, pattern, text) => Some((*dst, matches(self.get(*pattern)?, self.get(*text)?))),
            _ => None,
        }
    }

    /// Keep only what is also known by another way to the same place.
    pub fn merge(&mut self, other: &Texts) {
        self.known.retain(|r, text| other.known.get(r) == Some(text));
    }

    /// Forget variables that a block assigns to, which may run any number of times.
    pub fn forget(&mut self, ops: &[Op]) {
        visit(ops, &mut |op| match op {
            Op::TextCopy(r, _) | Op::TextLoad(r, ..) | Op::Format(r, ..) => self.put(*r, None),
            Op::TextStore(first, len, ..) | Op::Ask { out: Operand::Text(first), len, .. } => {
                first.array(*len).for_each(|r| self.put(r, None))
            }
            _ => {}
        });
    }
}

/// The answer to a query for a string, where it is the same for all points and rays.
pub(super) fn ask(what: Ask, names: &[&str], scene: &dyn Scene) -> Option<Answer> {
    match (what, names) {
        (Ask::RendererInfo, ["renderer"]) => Some(Answer::Text("scree".into())),
        (Ask::RendererInfo, ["versionstring"]) => Some(Answer::Text(env!("CARGO_PKG_VERSION").into())),
        (Ask::LightSource | Ask::RayInfo, _) | (Ask::ShaderName, ["lightsource"]) => None,
        _ => scene.ask(what, names),
    }
}
