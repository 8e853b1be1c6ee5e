//! The inner loop of the descent methods over a piece of blocks: pull the gradient, step, project.
//!
//! Plain contacts go four at a time through straight-line code that the compiler turns into vector instructions; the sums are
//! made in one order whatever the machine, so that all machines agree.

use super::bodies::BodyOperator;
use super::lanes::{Lane3, each, project};
use super::{Extrapolated, Image, Operator};
use glam::DVec3;

/// Contacts that go side by side.
const LANES: usize = 4;

/// For any blocks of any operator.
pub fn any(
    op: &(impl Operator + ?Sized),
    first: usize,
    next: &mut [DVec3],
    from: &Extrapolated,
    step: f64,
) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (k, z) in next.iter_mut().enumerate() {
        let i = first + k;
        let eta = op.eta(i);
        let y = from.x[i] + (from.x[i] - from.previous[i]) * from.beta;
        let gradient = op.pull(from.image, i);
        *z = op.project(i, y - gradient * (step * eta), from.x);
        sums[0] += (*z - y).length_squared() / eta;
        sums[1] += gradient.dot(*z - from.x[i]);
    }
    sums
}

/// The image of `next`, of the point extrapolated from it, and the curvature, one after the other.
pub fn advance(
    op: &mut (impl Operator + ?Sized),
    next: &[DVec3],
    beta: f64,
    [x, y]: [&Image; 2],
    [to, to_y]: [&mut Image; 2],
) -> f64 {
    op.image(next, to);
    to_y.extrapolate(to, x, beta);
    op.curvature(to, y)
}

/// For contacts with friction alone.
pub fn run(op: &BodyOperator, first: usize, next: &mut [DVec3], from: &Extrapolated, step: f64) -> [f64; 2] {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2.
        return unsafe { run_avx2(op, first, next, from, step) };
    }
    run_lanes(op, first, next, from, step)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn run_avx2(op: &BodyOperator, first: usize, next: &mut [DVec3], from: &Extrapolated, step: f64) -> [f64; 2] {
    run_lanes(op, first, next, from, step)
}

#[inline(always)]
fn run_lanes(op: &BodyOperator, first: usize, next: &mut [DVec3], from: &Extrapolated, step: f64) -> [f64; 2] {
    let n = next.len();
    let range = first..first + n;
    let c = op.contacts;
    // Slices of one length: the loop below checks no bounds.
    let (bodies, normal) = (&c.bodies[range.clone()], &c.normal[range.clone()]);
    let (arm_a, arm_b) = (&c.arm_a[range.clone()], &c.arm_b[range.clone()]);
    let (offset, eta, friction) = (&op.offset[range.clone()], &op.eta[range.clone()], &op.friction[range.clone()]);
    let (x, previous) = (&from.x[range.clone()], &from.previous[range]);
    let twist = &from.image.twist[..];
    let mut sums = [[0.0; LANES]; 2];
    let whole = n - n % LANES;
    for k in (0..whole).step_by(LANES) {
        let at = |v: &[DVec3]| Lane3::load([&v[k], &v[k + 1], &v[k + 2], &v[k + 3]]);
        let number = |v: &[f64]| [v[k], v[k + 1], v[k + 2], v[k + 3]];
        let body = |l: usize, side: usize| &twist[bodies[k + l][side] as usize];
        let (a, b) =
            ([body(0, 0), body(1, 0), body(2, 0), body(3, 0)], [body(0, 1), body(1, 1), body(2, 1), body(3, 1)]);
        let nrm = at(normal);
        let va = Lane3::linear(a).plus(Lane3::angular(a).cross(at(arm_a)));
        let vb = Lane3::linear(b).plus(Lane3::angular(b).cross(at(arm_b)));
        let gradient = vb.minus(va).plus(nrm.times(number(offset)));
        let (x_now, eta) = (at(x), number(eta));
        let y = x_now.plus(x_now.minus(at(previous)).times([from.beta; LANES]));
        let z = y.minus(gradient.times(each(|l| eta[l] * step)));
        let z = project(z, nrm, number(friction));
        for l in 0..LANES {
            next[k + l] = DVec3::new(z.x[l], z.y[l], z.z[l]);
        }
        let d = z.minus(y);
        let (moved, slope) = (d.dot(d), gradient.dot(z.minus(x_now)));
        for l in 0..LANES {
            sums[0][l] += moved[l] / eta[l];
            sums[1][l] += slope[l];
        }
    }
    let rest = any(op, first + whole, &mut next[whole..], from, step);
    [0, 1].map(|k| sums[k][0] + sums[k][1] + sums[k][2] + sums[k][3] + rest[k])
}
