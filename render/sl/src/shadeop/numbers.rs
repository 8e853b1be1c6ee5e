//! Functions of several numbers.

use super::call::Call;
use super::matrix::one16;
use super::number::{Unary, unary_value};
use super::runs::{run_of, zip3};
use super::wide::wide;

/// Logarithm to a base: log(x, base).
pub fn log_base(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| {
        let base = unary_value(Unary::Log, v[1][0]);
        one16(if base != 0.0 { unary_value(Unary::Log, v[0][0]) / base } else { 0.0 })
    });
}

/// smoothstep(lo, hi, x)
pub fn smooth_step(call: &Call<'_>, out: &mut Vec<f32>) {
    out.resize(call.lanes(), 0.0);
    smooth_run(out, call.arg(0), call.arg(1), call.arg(2));
}

wide! {
    fn smooth_run(out: &mut [f32], lo: &[f32], hi: &[f32], x: &[f32]) = smooth_loop;
}

#[inline(always)]
fn smooth_loop(out: &mut [f32], lo: &[f32], hi: &[f32], x: &[f32]) {
    zip3(out, [lo, hi, x], |lo, hi, x| {
        let t = ((x - lo) / (hi - lo)).min(1.0);
        let between = t * t * (3.0 - 2.0 * t);
        if x < lo || hi <= lo { (x >= lo) as u8 as f32 } else { between }
    });
}

/// a (1 − t) + b t
pub fn mix(call: &Call<'_>, out: &mut Vec<f32>) {
    let (a, b, t) = (call.arg(0), call.arg(1), call.arg(2));
    let (n, width, lanes) = (call.n, call.width, call.lanes());
    out.resize(width * lanes, 0.0);
    for (c, out) in out.chunks_exact_mut(lanes.max(1)).enumerate() {
        mix_run(out, run_of(a, width, c, n), run_of(b, width, c, n), t);
    }
}

wide! {
    fn mix_run(out: &mut [f32], a: &[f32], b: &[f32], t: &[f32]) = mix_loop;
}

#[inline(always)]
fn mix_loop(out: &mut [f32], a: &[f32], b: &[f32], t: &[f32]) {
    zip3(out, [a, b, t], |a, b, t| a * (1.0 - t) + b * t);
}
