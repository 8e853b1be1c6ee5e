//! Functions of several numbers.

use super::call::Call;
use super::matrix::one16;
use super::number::{Unary, unary_value};
use super::runs::{at, run_of};

/// Logarithm to a base: log(x, base).
pub fn log_base(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| {
        let base = unary_value(Unary::Log, v[1][0]);
        one16(if base != 0.0 { unary_value(Unary::Log, v[0][0]) / base } else { 0.0 })
    });
}

/// smoothstep(lo, hi, x)
pub fn smooth_step(call: &Call<'_>, out: &mut Vec<f32>) {
    let (lo, hi, x) = (call.arg(0), call.arg(1), call.arg(2));
    out.extend((0..call.lanes()).map(|k| {
        let (lo, hi, x) = (at(lo, k), at(hi, k), at(x, k));
        if x < lo || hi <= lo {
            return (x >= lo) as u8 as f32;
        }
        let t = ((x - lo) / (hi - lo)).min(1.0);
        t * t * (3.0 - 2.0 * t)
    }));
}

/// a (1 − t) + b t
pub fn mix(call: &Call<'_>, out: &mut Vec<f32>) {
    let (a, b, t) = (call.arg(0), call.arg(1), call.arg(2));
    let (n, width, lanes) = (call.n, call.width, call.lanes());
    for c in 0..width {
        let (a, b) = (run_of(a, width, c, n), run_of(b, width, c, n));
        out.extend((0..lanes).map(|k| at(a, k) * (1.0 - at(t, k)) + at(b, k) * at(t, k)));
    }
}
