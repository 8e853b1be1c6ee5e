//! The arguments of a request as ASCII RIB: a method for each kind of the table, which appends to the request's line.

use crate::params::{Params, Values};
use crate::ri::{Knots, Tags, TrimCurves};
use std::fmt::{Display, Write};

/// A request's line under way.
pub(crate) struct Line<'a>(pub(crate) &'a mut String);

/// Numbers that stand in a row.
pub(crate) trait InRow {
    /// Append them, each after a blank.
    fn append(&self, line: &mut String);
}

impl InRow for f32 {
    fn append(&self, line: &mut String) {
        let _ = write!(line, " {self}");
    }
}

impl InRow for i32 {
    fn append(&self, line: &mut String) {
        let _ = write!(line, " {self}");
    }
}

impl<const N: usize> InRow for [f32; N] {
    fn append(&self, line: &mut String) {
        self.iter().for_each(|x| x.append(line));
    }
}

impl Line<'_> {
    /// A word as it is.
    pub(crate) fn word(&mut self, word: &str) {
        self.0.push(' ');
        self.0.push_str(word);
    }

    /// A quoted string.
    pub(crate) fn text(&mut self, text: &str) {
        self.word(&quote(text));
    }

    /// A number.
    pub(crate) fn number(&mut self, x: f32) {
        x.append(self.0);
    }

    /// A whole number.
    pub(crate) fn whole(&mut self, x: i32) {
        x.append(self.0);
    }

    /// A frame's number.
    pub(crate) fn frame(&mut self, number: i32) {
        self.whole(number);
    }

    /// A switch: 0 or 1.
    pub(crate) fn flag(&mut self, on: bool) {
        self.whole(on as i32);
    }

    /// Numbers in a row, in brackets.
    pub(crate) fn bracketed(&mut self, append: impl FnOnce(&mut String)) {
        let blank = self.0.len();
        append(self.0);
        self.0.insert(blank + 1, '[');
        self.0.push(']');
    }

    /// A list in brackets.
    fn list<T: Display>(&mut self, values: impl IntoIterator<Item = T>) {
        self.0.push_str(" [");
        for (i, x) in values.into_iter().enumerate() {
            let _ = write!(self.0, "{}{x}", if i > 0 { " " } else { "" });
        }
        self.0.push(']');
    }

    /// A list of numbers.
    pub(crate) fn floats(&mut self, values: Vec<f32>) {
        self.list(values);
    }

    /// A list of whole numbers.
    pub(crate) fn wholes(&mut self, values: Vec<i32>) {
        self.list(values);
    }

    /// A list of strings.
    pub(crate) fn texts(&mut self, values: Vec<String>) {
        self.list(values.iter().map(|t| quote(t)));
    }

    /// A parameter list.
    pub(crate) fn params(&mut self, params: Params) {
        for param in params {
            self.text(&param.decl.inline());
            match param.values {
                Values::Floats(v) => self.floats(v),
                Values::Strings(v) => self.texts(v),
            }
        }
    }

    /// A lens; a pinhole has no numbers.
    pub(crate) fn lens(&mut self, lens: [f32; 3]) {
        if !lens[0].is_infinite() {
            lens.append(self.0);
        }
    }

    /// Two strings.
    pub(crate) fn text_pair(&mut self, texts: [&str; 2]) {
        texts.into_iter().for_each(|t| self.text(t));
    }

    /// Six strings.
    pub(crate) fn six_texts(&mut self, texts: Vec<String>) {
        texts.iter().for_each(|t| self.text(t));
    }

    /// A basis as a matrix.
    pub(crate) fn basis(&mut self, matrix: [f32; 16]) {
        self.list(matrix);
    }

    /// Points, order, knots and range of a NURBS patch along one parameter.
    pub(crate) fn knots(&mut self, k: Knots) {
        self.whole(k.n);
        self.whole(k.order);
        self.floats(k.knots);
        k.range.append(self.0);
    }

    /// The nine lists of `TrimCurve`.
    pub(crate) fn trim_curves(&mut self, t: TrimCurves) {
        self.wholes(t.n_curves);
        self.wholes(t.order);
        [t.knot, t.min, t.max].into_iter().for_each(|v| self.floats(v));
        self.wholes(t.n);
        [t.u, t.v, t.w].into_iter().for_each(|v| self.floats(v));
    }

    /// Names, argument counts, integers and floats of tags.
    pub(crate) fn tags(&mut self, tags: Tags) {
        self.texts(tags.names);
        self.wholes(tags.n_args);
        self.wholes(tags.integers);
        self.floats(tags.floats);
    }
}

fn quote(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n"))
}
