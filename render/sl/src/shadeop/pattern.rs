//! Noise and random numbers over a grid.

use super::call::Call;
use super::matrix::triple16;
use super::noise as lattice;
use super::runs::{at, run_of, triple};

/// Noise in [0, 1] of 1, 2 or 3 numbers; as many values as the result has components, independent of each other.
pub fn noise(call: &Call<'_>, out: &mut Vec<f32>) {
    let (n, lanes) = (call.n, call.lanes());
    let is_sparse = |mask: &[bool]| lanes == n && 4 * mask.iter().filter(|on| **on).count() < n;
    if call.mask.is_some_and(is_sparse) {
        return at_places(call, out, lattice::noise);
    }
    out.resize(call.width * lanes, 0.0);
    let of = |c| run_of(call.arg(0), call.args[0].width, c, n);
    for (c, out) in out.chunks_exact_mut(lanes.max(1)).enumerate() {
        match call.args {
            [p] if p.width == 3 => lattice::noise_run(out, [of(0), of(1), of(2)], c as u32),
            [_] => lattice::noise_run_flat(out, of(0), &[0.0], c as u32),
            _ => lattice::noise_run_flat(out, of(0), call.arg(1), c as u32),
        }
    }
}

/// Constant noise of the cell, likewise.
pub fn cell_noise(call: &Call<'_>, out: &mut Vec<f32>) {
    at_places(call, out, lattice::cell_noise);
}

fn at_places(call: &Call<'_>, out: &mut Vec<f32>, value: impl Fn([f32; 3], u32) -> f32) {
    let (n, width, lanes) = (call.n, call.width, call.lanes());
    let (x, y) = (call.arg(0), call.args.get(1).map(|y| y.v));
    let of_triple = call.args[0].width == 3;
    out.resize(width * lanes, 0.0);
    for k in 0..lanes {
        if lanes == n && !call.active(k) {
            continue;
        }
        let p = if of_triple { triple(x, k, n) } else { [at(x, k), y.map_or(0.0, |y| at(y, k)), 0.0] };
        for c in 0..width {
            out[c * lanes + k] = value(p, c as u32);
        }
    }
}

/// Noise of a point and a number.
pub fn noise_in_time(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| {
        triple16([0, 1, 2].map(|c| lattice::noise4([v[0][0], v[0][1], v[0][2]], v[1][0], None, c)))
    });
}

/// Constant noise of the cell of a point and a number.
pub fn cell_noise_in_time(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| {
        let salt = (v[1][0].floor() as i32 as u32).wrapping_mul(0x2545_f491);
        triple16([0, 1, 2].map(|c| lattice::cell_noise([v[0][0], v[0][1], v[0][2]], salt ^ c)))
    });
}

/// Noise that repeats, of 1, 2, 3 or 4 numbers: first the place, then as many periods.
pub fn periodic_noise(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| {
        let half = v.len() / 2;
        let numbers = |first: usize| {
            let mut all = [0.0f32; 4];
            let mut k = 0;
            for (value, arg) in v[first..first + half].iter().zip(call.args) {
                all[k..k + arg.width].copy_from_slice(&value[..arg.width]);
                k += arg.width;
            }
            (all, k)
        };
        let ((at, n), (period, _)) = (numbers(0), numbers(half));
        let (p, q) = ([at[0], at[1], at[2]], [period[0], period[1], period[2]]);
        triple16([0, 1, 2].map(|c| {
            if n == 4 { lattice::noise4(p, at[3], Some(period), c) } else { lattice::periodic_noise(p, q, c) }
        }))
    });
}

/// A number in [0, 1) that depends on the place, on which call of the source it is, and on the turns of the loops around it; without a
/// place, the grid's first point stands for all.
pub fn random(call: &Call<'_>, out: &mut Vec<f32>) {
    let first = call.place.map_or([0.0; 3], |p| triple(p, 0, call.n));
    call.pointwise(out, |v| {
        let at = v.get(1).map_or(first, |v| [v[0], v[1], v[2]]);
        let cell = at.map(|x| x.to_bits() as f32 * 0.618_034);
        let seed = (v[0][0] as u32).wrapping_mul(0x9e37_79b9).wrapping_add(call.turn);
        let own = |c: u32| (c + 1).wrapping_mul(0x85eb_ca6b).wrapping_add(at[c as usize].to_bits()).wrapping_add(seed);
        triple16([0, 1, 2].map(|c| lattice::cell_noise(cell, own(c))))
    });
}
