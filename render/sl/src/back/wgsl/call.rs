//! Calls of shading functions.

use super::writer::{Done, Writer};
use crate::ir::builtins::{How, SceneCall};
use crate::ir::{Builtin, Global, Reg};

impl Writer<'_, '_> {
    pub fn call(&mut self, f: Builtin, dst: Reg, args: &[Reg]) -> Done {
        let row = f.row();
        match row.how {
            How::Scene(SceneCall::Ambient) => self.set(dst, "sl_ambient()".into()),
            How::Scene(call) => self.query(row.name, call, dst, args),
            _ if row.neighbours && !self.grid => self.refuse(format!("calls `{}` where points run alone", row.ir)),
            _ => match self.expression(row.ir, dst, args) {
                Some(value) => self.set(dst, value),
                None => self.refuse(format!("calls `{}`", row.ir)),
            },
        }
    }

    /// The value of a call; none if its function has no form here.
    fn expression(&self, name: &str, dst: Reg, args: &[Reg]) -> Option<String> {
        let a: Vec<String> = args.iter().map(|r| self.registers.value(*r)).collect();
        let widths: Vec<usize> = args.iter().map(|r| r.width()).collect();
        let wide = if dst.width() == 1 { "1" } else { "3" };
        let list = a.join(", ");
        Some(match (name, &widths[..]) {
            ("dot" | "cross" | "determinant", _) => format!("{name}({list})"),
            ("length", _) => format!("sqrt(dot({0}, {0}))", a[0]),
            ("reflect", _) => format!("{0} - 2.0 * dot({0}, {1}) * {1}", a[0], a[1]),
            ("faceforward", _) => format!("{} * select(1.0, -1.0, dot({}, {}) > 0.0)", a[0], a[1], a[2]),
            ("normalize" | "refract" | "smoothstep" | "translate" | "scale" | "rotate" | "diagonal", _) => {
                format!("sl_{name}({list})")
            }
            ("logbase", _) => format!("sl_log_base({list})"),
            ("mix", _) => format!("{0} * (1.0 - {2}) + {1} * {2}", a[0], a[1], a[2]),
            ("comp", [width, ..]) => format!("sl_component{width}({list})"),
            ("setcomp", [width, ..]) => format!("sl_with_component{width}({list})"),
            // A matrix has its numbers row after row for row vectors: products go the other way round.
            ("matrixmultiply", _) => format!("{} * {}", a[1], a[0]),
            ("matrixdivide", _) => format!("sl_inverse({}) * {}", a[1], a[0]),
            ("matrixequal", _) => format!("sl_matrix_equal({list})"),
            ("matrixpoint", _) => format!("sl_point({list})"),
            ("matrixvector", _) => format!("sl_vector({list})"),
            ("matrixnormal", _) => format!("sl_normal({list})"),
            ("noise", [3, 1]) if wide == "1" => format!("sl_timed1({list}, 0u)"),
            ("noise", [3, 1]) => format!("sl_timed3({list})"),
            ("noise", widths) => format!("sl_noise{wide}({})", place(&a, widths)),
            ("cellnoise", [3, 1]) if wide == "1" => format!("sl_timed_cell1({list}, 0u)"),
            ("cellnoise", [3, 1]) => format!("sl_timed_cell3({list})"),
            ("cellnoise", widths) if wide == "1" => format!("sl_cell({}, 0u)", place(&a, widths)),
            ("cellnoise", widths) => format!("sl_cell3({})", place(&a, widths)),
            ("periodicnoise", [3, 1, 3, 1]) if wide == "1" => format!("sl_timed_periodic1({list}, 0u)"),
            ("periodicnoise", [3, 1, 3, 1]) => format!("sl_timed_periodic3({list})"),
            ("periodicnoise", widths) => {
                let half = widths.len() / 2;
                let (at, period) = (place(&a[..half], &widths[..half]), place(&a[half..], &widths[half..]));
                format!("sl_periodic{wide}({at}, {period})")
            }
            ("random", [1, 3]) if wide == "1" => format!("sl_random1({list}, turn, 0u)"),
            ("random", [1, 3]) => format!("sl_random3({list}, turn)"),
            ("random", [1]) => {
                // Without a place, the grid's first point stands for all.
                let p = self.program.global(Global::P).map(|p| format!("sl_first3({})", self.registers.name(p)));
                let p = p.unwrap_or("vec3<f32>()".into());
                let last = if wide == "1" { ", 0u" } else { "" };
                format!("sl_random{wide}({}, {p}, turn{last})", a[0])
            }
            // Lights have no footprints, as in the grid machine.
            ("width", _) if self.index > 0 => format!("sl_own_width({list})"),
            ("width", _) => format!("sl_width({list})"),
            ("area" | "calculatenormal", _) => format!("sl_{name}({list})"),
            ("du" | "dv", [1, ..]) => format!("sl_{name}({list})"),
            ("du" | "dv", [3, ..]) => format!("sl_{name}3({list})"),
            _ => return None,
        })
    }
}

/// The place that one or two numbers or a triple mean.
fn place(args: &[String], widths: &[usize]) -> String {
    match (args, widths) {
        ([x], [1]) => format!("vec3<f32>({x}, 0.0, 0.0)"),
        ([x, y], _) => format!("vec3<f32>({x}, {y}, 0.0)"),
        _ => args[0].clone(),
    }
}
