//! Operations on single numbers, and on runs of them.

use super::runs::{zip, zip3};
use super::wide::wide;

/// Operations of one operand, component by component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// Copy.
    Copy,
    /// −x
    Negate,
    /// Logical not: 1 where x is 0, else 0.
    Not,
    /// |x|
    Abs,
    /// Sign of x: −1, 0 or 1.
    Sign,
    /// Square root; 0 where x is negative.
    Sqrt,
    /// Inverse square root, 1/√x; 0 where x is 0.
    InverseSqrt,
    /// Sine.
    Sin,
    /// Cosine.
    Cos,
    /// Tangent.
    Tan,
    /// Arc sine.
    Asin,
    /// Arc cosine.
    Acos,
    /// Arc tangent.
    Atan,
    /// eˣ
    Exp,
    /// ln x
    Log,
    /// Maximum integer not above x.
    Floor,
    /// Minimum integer not below x.
    Ceil,
    /// Nearest integer.
    Round,
    /// Degrees to radians.
    Radians,
    /// Radians to degrees.
    Degrees,
}

/// Operations of two operands, component by component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    /// a + b
    Add,
    /// a − b
    Sub,
    /// a b
    Mul,
    /// a / b, 0 where b is 0.
    Div,
    /// Minimum of a and b.
    Min,
    /// Maximum of a and b.
    Max,
    /// aᵇ
    Pow,
    /// a − b ⌊a/b⌋
    Mod,
    /// Angle of the direction (b, a), radians: atan(a, b).
    Atan2,
    /// step(a, b): 0 where b is below a, else 1.
    Step,
    /// a < b, 1 or 0.
    Less,
    /// a ≤ b, 1 or 0.
    LessEqual,
    /// a = b, 1 or 0.
    Equal,
    /// Logical and: 1 where both are not 0, else 0.
    And,
    /// Logical or: 1 where either is not 0, else 0.
    Or,
}

wide! {
    /// An operation on every number of a run.
    pub fn unary_run(f: Unary, out: &mut [f32], a: &[f32]) = unary_loop;
}

wide! {
    /// An operation on two runs, of one number or as many as come out each.
    pub fn binary_run(f: Binary, out: &mut [f32], a: &[f32], b: &[f32]) = binary_loop;
}

wide! {
    /// Of every number of the first run that is not 0 the second's, else the third's.
    pub fn select_run(out: &mut [f32], c: &[f32], a: &[f32], b: &[f32]) = select_loop;
}

/// A loop for each operation.
#[inline(always)]
fn unary_loop(f: Unary, out: &mut [f32], a: &[f32]) {
    let a = &a[..out.len()];
    macro_rules! run {
        ($($f:ident)*) => {
            match f {
                $(Unary::$f => {
                    for k in 0..out.len() {
                        out[k] = unary_value(Unary::$f, a[k]);
                    }
                })*
            }
        };
    }
    run!(Copy Negate Not Abs Sign Sqrt InverseSqrt Sin Cos Tan Asin Acos Atan Exp Log Floor Ceil Round Radians Degrees)
}

#[inline(always)]
fn binary_loop(f: Binary, out: &mut [f32], a: &[f32], b: &[f32]) {
    macro_rules! run {
        ($($f:ident)*) => {
            match f {
                $(Binary::$f => zip(out, a, b, |x, y| binary_value(Binary::$f, x, y)),)*
            }
        };
    }
    run!(Add Sub Mul Div Min Max Pow Mod Atan2 Step Less LessEqual Equal And Or)
}

#[inline(always)]
fn select_loop(out: &mut [f32], c: &[f32], a: &[f32], b: &[f32]) {
    zip3(out, [c, a, b], |c, a, b| if c != 0.0 { a } else { b });
}

/// Numbers of one operation on one number.
#[inline(always)]
pub fn unary_value(f: Unary, x: f32) -> f32 {
    match f {
        Unary::Copy => x,
        Unary::Negate => -x,
        Unary::Not => (x == 0.0) as u8 as f32,
        Unary::Abs => x.abs(),
        Unary::Sign => (x > 0.0) as u8 as f32 - (x < 0.0) as u8 as f32,
        Unary::Sqrt => x.max(0.0).sqrt(),
        Unary::InverseSqrt => {
            if x > 0.0 {
                1.0 / x.sqrt()
            } else {
                0.0
            }
        }
        Unary::Sin => x.sin(),
        Unary::Cos => x.cos(),
        Unary::Tan => x.tan(),
        Unary::Asin => x.clamp(-1.0, 1.0).asin(),
        Unary::Acos => x.clamp(-1.0, 1.0).acos(),
        Unary::Atan => x.atan(),
        Unary::Exp => x.exp(),
        Unary::Log => x.max(f32::MIN_POSITIVE).ln(),
        Unary::Floor => x.floor(),
        Unary::Ceil => x.ceil(),
        Unary::Round => x.round(),
        Unary::Radians => x.to_radians(),
        Unary::Degrees => x.to_degrees(),
    }
}

/// The number of one operation on two numbers.
#[inline(always)]
pub fn binary_value(f: Binary, x: f32, y: f32) -> f32 {
    let truth = |x: bool| x as u8 as f32;
    match f {
        Binary::Add => x + y,
        Binary::Sub => x - y,
        Binary::Mul => x * y,
        Binary::Div => {
            if y != 0.0 {
                x / y
            } else {
                0.0
            }
        }
        Binary::Min => {
            if x < y {
                x
            } else {
                y
            }
        }
        Binary::Max => {
            if x > y {
                x
            } else {
                y
            }
        }
        Binary::Pow => power(x, y),
        Binary::Mod => {
            if y != 0.0 {
                x - y * (x / y).floor()
            } else {
                0.0
            }
        }
        Binary::Atan2 => x.atan2(y),
        Binary::Step => truth(y >= x),
        Binary::Less => truth(x < y),
        Binary::LessEqual => truth(x <= y),
        Binary::Equal => truth(x == y),
        Binary::And => truth(x != 0.0 && y != 0.0),
        Binary::Or => truth(x != 0.0 || y != 0.0),
    }
}

/// xʸ, 0 where it is not a number.
pub(crate) fn power(x: f32, y: f32) -> f32 {
    let p = x.powf(y);
    if p.is_nan() { 0.0 } else { p }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_have_the_bits_of_single_numbers_whichever_are_uniform() {
        let n = 37;
        let run = |first: f32, step: f32| (0..n).map(|k| first + step * (k % 9) as f32).collect::<Vec<f32>>();
        let (a, b, c) = (run(-2.0, 0.5), run(1.25, -0.31), run(0.0, 0.125));
        let runs = |v: &[f32]| [v.to_vec(), v[3..4].to_vec()];
        let at = |v: &[f32], k: usize| if v.len() == 1 { v[0] } else { v[k] };
        let mut out = vec![f32::NAN; n];
        for (a, b) in runs(&a).into_iter().flat_map(|a| runs(&b).map(|b| (a.clone(), b))) {
            for f in [Binary::Add, Binary::Div, Binary::Max, Binary::Pow, Binary::Mod, Binary::Step, Binary::Or] {
                binary_run(f, &mut out, &a, &b);
                (0..n).for_each(|k| {
                    assert_eq!(out[k].to_bits(), binary_value(f, at(&a, k), at(&b, k)).to_bits(), "{f:?}")
                });
            }
            for c in runs(&c) {
                select_run(&mut out, &c, &a, &b);
                (0..n).for_each(|k| assert_eq!(out[k], if at(&c, k) != 0.0 { at(&a, k) } else { at(&b, k) }));
            }
        }
        for f in [Unary::Copy, Unary::Sqrt, Unary::Floor, Unary::Exp, Unary::InverseSqrt, Unary::Sign] {
            unary_run(f, &mut out, &a);
            (0..n).for_each(|k| assert_eq!(out[k].to_bits(), unary_value(f, a[k]).to_bits(), "{f:?}"));
        }
    }
}
