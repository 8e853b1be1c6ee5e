//! Operations on single numbers, as WGSL expressions.

use crate::ir::{Binary, Unary};

/// An operation on one number.
pub(super) fn unary(f: Unary, x: &str) -> String {
    let call = match f {
        Unary::Copy => return x.into(),
        Unary::Negate => return format!("-{x}"),
        Unary::Not => return format!("f32({x} == 0.0)"),
        Unary::Radians => return format!("({x} * 0.017453293)"),
        Unary::Degrees => return format!("({x} * 57.29578)"),
        Unary::Abs => "abs",
        Unary::Sign => "sign",
        Unary::Sqrt => "sl_sqrt",
        Unary::InverseSqrt => "sl_inverse_sqrt",
        Unary::Sin => "sl_sin",
        Unary::Cos => "sl_cos",
        Unary::Tan => "sl_tan",
        Unary::Asin => "sl_asin",
        Unary::Acos => "sl_acos",
        Unary::Atan => "sl_atan",
        Unary::Exp => "exp",
        Unary::Log => "sl_log",
        Unary::Floor => "floor",
        Unary::Ceil => "ceil",
        Unary::Round => "sl_round",
    };
    format!("{call}({x})")
}

/// Whether WGSL has an operation for triples in the same form as for numbers.
pub(super) fn is_for_triples(f: Unary) -> bool {
    matches!(f, Unary::Copy | Unary::Negate | Unary::Abs | Unary::Floor | Unary::Ceil)
}

/// An operation on two numbers.
pub(super) fn binary(f: Binary, a: &str, b: &str) -> String {
    match f {
        Binary::Add => format!("{a} + {b}"),
        Binary::Sub => format!("{a} - {b}"),
        Binary::Mul => format!("{a} * {b}"),
        Binary::Div => format!("sl_divide({a}, {b})"),
        Binary::Min => format!("select({b}, {a}, {a} < {b})"),
        Binary::Max => format!("select({b}, {a}, {a} > {b})"),
        Binary::Pow => format!("sl_power({a}, {b})"),
        Binary::Mod => format!("sl_mod({a}, {b})"),
        Binary::Atan2 => format!("sl_atan2({a}, {b})"),
        Binary::Step => format!("f32({b} >= {a})"),
        Binary::Less => format!("f32({a} < {b})"),
        Binary::LessEqual => format!("f32({a} <= {b})"),
        Binary::Equal => format!("f32({a} == {b})"),
        Binary::And => format!("f32({a} != 0.0 && {b} != 0.0)"),
        Binary::Or => format!("f32({a} != 0.0 || {b} != 0.0)"),
    }
}
