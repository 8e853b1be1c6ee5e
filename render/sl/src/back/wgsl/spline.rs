//! Splines: a function for each basis, count of knots and type.

use super::registers::{literal, type_of};
use super::writer::{Done, Writer};
use crate::ir::{Reg, TextReg};
use crate::shadeop::spline::basis;

impl Writer<'_, '_> {
    pub fn spline(&mut self, dst: Reg, name: TextReg, args: &[Reg]) -> Done {
        let name = self.text(name, "the basis of a spline")?;
        let (x, knots) = (self.registers.value(args[0]), &args[1..]);
        let solved = name.strip_prefix("solve");
        let width = if solved.is_some() { 1 } else { dst.width() };
        if width == 16 || knots.iter().any(|r| r.width() != width) || (solved.is_some() && dst.width() != 1) {
            return self.refuse("has a spline of values of several types");
        }
        let list: Vec<String> = knots.iter().map(|r| self.registers.value(*r)).collect();
        let Some(room) = knots.len().checked_sub(4) else { return self.set(dst, list[0].clone()) };
        let (matrix, step) = basis(solved.unwrap_or(&name));
        let stem = solved.unwrap_or(&name).replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        let (n, ty) = (knots.len(), type_of(width));
        let function = format!("spline_{stem}_{n}_{width}");
        self.define(&function, spline_function(&function, ty, n, &matrix, step, room / step + 1));
        let function = match solved {
            Some(_) => {
                let solve = format!("solve_{function}");
                self.define(&solve, solve_function(&solve, &function, n));
                solve
            }
            None => function,
        };
        self.set(dst, format!("{function}({x}, array<{ty}, {n}>({}))", list.join(", ")))
    }

    /// Add a function to the kernel, once.
    pub fn define(&mut self, name: &str, text: String) {
        if !self.module.functions.contains(&format!("fn {name}(")) {
            self.module.functions += &text;
        }
    }
}

fn spline_function(name: &str, ty: &str, n: usize, matrix: &[[f32; 4]; 4], step: usize, segments: usize) -> String {
    let power = |row: &[f32; 4]| {
        let terms: Vec<String> =
            row.iter().enumerate().map(|(i, m)| format!("{} * k[first + {i}u]", literal(*m))).collect();
        terms.join(" + ")
    };
    let [a, b, c, d] = [0, 1, 2, 3].map(|row| power(&matrix[row]));
    format!(
        "
fn {name}(x: f32, knots: array<{ty}, {n}>) -> {ty} {{
    var k = knots;
    let along = clamp(x, 0.0, 1.0) * {segments}.0;
    let segment = min(u32(along), {}u);
    let t = along - f32(segment);
    let first = segment * {step}u;
    return ((({a}) * t + ({b})) * t + ({c})) * t + ({d});
}}
",
        segments - 1
    )
}

/// The parameter at which a spline has a value, by bisection.
fn solve_function(name: &str, spline: &str, n: usize) -> String {
    format!(
        "
fn {name}(x: f32, knots: array<f32, {n}>) -> f32 {{
    var low = 0.0;
    var high = 1.0;
    let rises = {spline}(1.0, knots) >= {spline}(0.0, knots);
    for (var i = 0u; i < 32u; i += 1u) {{
        let middle = 0.5 * (low + high);
        if ({spline}(middle, knots) < x) == rises {{
            low = middle;
        }} else {{
            high = middle;
        }}
    }}
    return 0.5 * (low + high);
}}
"
    )
}
