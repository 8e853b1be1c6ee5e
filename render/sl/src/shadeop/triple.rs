//! Functions of triples: products, lengths, reflection and refraction.

use super::call::Call;
use super::runs::{at, cross, dot, put, triple, triples2};

/// a · b
pub fn dot_product(call: &Call<'_>, out: &mut Vec<f32>) {
    triples2(out, call.arg(0), call.arg(1), call.n, 1, |a, b| [dot(a, b), 0.0, 0.0]);
}

/// a × b
pub fn cross_product(call: &Call<'_>, out: &mut Vec<f32>) {
    triples2(out, call.arg(0), call.arg(1), call.n, 3, cross);
}

/// |a|
pub fn length(call: &Call<'_>, out: &mut Vec<f32>) {
    triples2(out, call.arg(0), call.arg(0), call.n, 1, |a, _| [dot(a, a).sqrt(), 0.0, 0.0]);
}

/// a/|a|, 0 at 0.
pub fn normalize(call: &Call<'_>, out: &mut Vec<f32>) {
    triples2(out, call.arg(0), call.arg(0), call.n, 3, |a, _| {
        let l = dot(a, a).sqrt();
        if l > 0.0 { a.map(|x| x / l) } else { [0.0; 3] }
    });
}

/// N turned against I, as a reference says.
pub fn face_forward(call: &Call<'_>, out: &mut Vec<f32>) {
    let (n, lanes) = (call.n, call.lanes());
    out.resize(3 * lanes, 0.0);
    for k in 0..lanes {
        let [a, i, reference] = [0, 1, 2].map(|arg| triple(call.arg(arg), k, n));
        let sign = if dot(i, reference) > 0.0 { -1.0 } else { 1.0 };
        put(out, k, lanes, a.map(|x| x * sign));
    }
}

/// I mirrored at N.
pub fn reflected(call: &Call<'_>, out: &mut Vec<f32>) {
    triples2(out, call.arg(0), call.arg(1), call.n, 3, |i, m| {
        let d = 2.0 * dot(i, m);
        [i[0] - d * m[0], i[1] - d * m[1], i[2] - d * m[2]]
    });
}

/// I refracted at N with ratio eta.
pub fn refracted(call: &Call<'_>, out: &mut Vec<f32>) {
    let (n, lanes) = (call.n, call.lanes());
    out.resize(3 * lanes, 0.0);
    for k in 0..lanes {
        put(out, k, lanes, refract(triple(call.arg(0), k, n), triple(call.arg(1), k, n), at(call.arg(2), k)));
    }
}

fn refract(i: [f32; 3], m: [f32; 3], eta: f32) -> [f32; 3] {
    let d = dot(i, m);
    let k = 1.0 - eta * eta * (1.0 - d * d);
    if k < 0.0 {
        return [0.0; 3];
    }
    let f = eta * d + k.sqrt();
    [0, 1, 2].map(|c| eta * i[c] - f * m[c])
}
