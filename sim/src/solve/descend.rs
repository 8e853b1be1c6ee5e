//! The inner loop of the descent methods over a piece of blocks: pull the gradient, step, project.
//!
//! Plain contacts go four at a time through vector registers where there are any; the sums are made in one order whatever the
//! machine, so that all machines agree.

use super::bodies::BodyOperator;
#[cfg(target_arch = "x86_64")]
use super::lanes::Wide;
use super::lanes::{Lanes4, Plain, project};
use super::{Extrapolated, Image, Operator};
use crate::state::Arms;
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
    {
        #[target_feature(enable = "avx2")]
        unsafe fn wide(
            op: &BodyOperator,
            first: usize,
            next: &mut [DVec3],
            from: &Extrapolated,
            step: f64,
        ) -> [f64; 2] {
            run_either::<Wide<std::arch::x86_64::__m256d>>(op, first, next, from, step)
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2.
            return unsafe { wide(op, first, next, from, step) };
        }
    }
    run_either::<Plain<f64, LANES>>(op, first, next, from, step)
}

#[inline(always)]
fn run_either<V: Lanes4>(
    op: &BodyOperator,
    first: usize,
    next: &mut [DVec3],
    from: &Extrapolated,
    step: f64,
) -> [f64; 2] {
    match op.contacts.arms {
        Arms::Any(_) => run_lanes::<V, false>(op, first, next, from, step),
        Arms::Along(_) => run_lanes::<V, true>(op, first, next, from, step),
    }
}

/// The next four rows of a column.
#[inline(always)]
fn four<T>(column: &[T], k: usize) -> &[T; LANES] {
    column[k..k + LANES].try_into().expect("four rows")
}

#[inline(always)]
fn run_lanes<V: Lanes4, const BALLS: bool>(
    op: &BodyOperator,
    first: usize,
    next: &mut [DVec3],
    from: &Extrapolated,
    step: f64,
) -> [f64; 2] {
    let n = next.len();
    let range = first..first + n;
    let c = op.contacts;
    let (bodies, normal, law) = (&c.bodies[range.clone()], &c.normal[range.clone()], &c.law[range.clone()]);
    let (arms, reach): (&[[DVec3; 2]], &[[f64; 2]]) = match &c.arms {
        Arms::Any(arms) => (&arms[range.clone()], &[]),
        Arms::Along(reach) => (&[], &reach[range.clone()]),
    };
    let (gap, eta) = (&c.gap[range.clone()], &op.eta[range.clone()]);
    let offset = op.offset.get(range.clone());
    let (h, slowest) = (V::splat(op.recovery.step), V::splat(-op.recovery.speed));
    let (x, previous) = (&from.x[range.clone()], &from.previous[range]);
    let twist = &from.image.twist[..];
    let (beta, step_v) = (V::splat(from.beta), V::splat(step));
    let mut sums = [V::splat(0.0); 2];
    let whole = n - n % LANES;
    for k in (0..whole).step_by(LANES) {
        let [p, q, r, s] = four(bodies, k);
        let [va, wa] =
            V::twists([&twist[p[0] as usize], &twist[q[0] as usize], &twist[r[0] as usize], &twist[s[0] as usize]]);
        let [vb, wb] =
            V::twists([&twist[p[1] as usize], &twist[q[1] as usize], &twist[r[1] as usize], &twist[s[1] as usize]]);
        let n = V::load3(four(normal, k));
        let offset = match offset {
            Some(offset) => V::load(four(offset, k)),
            None => {
                let rate = V::load(four(gap, k)) / h;
                rate.up_to(slowest, slowest, rate)
            }
        };
        let turned = if BALLS {
            let [reach_a, reach_b] = V::load2(four(reach, k));
            n.cross(wa.times(reach_a).plus(wb.times(reach_b)))
        } else {
            let [p, q, r, s] = four(arms, k);
            wb.cross(V::load3(&[p[1], q[1], r[1], s[1]])).minus(wa.cross(V::load3(&[p[0], q[0], r[0], s[0]])))
        };
        let gradient = vb.minus(va).plus(turned).plus(n.times(offset));
        let (x, eta) = (V::load3(four(x, k)), V::load(four(eta, k)));
        let y = x.plus(x.minus(V::load3(four(previous, k))).times(beta));
        let [p, q, r, s] = four(law, k);
        let mu = V::load(&[
            op.laws[*p as usize].friction,
            op.laws[*q as usize].friction,
            op.laws[*r as usize].friction,
            op.laws[*s as usize].friction,
        ]);
        let z = project(y.minus(gradient.times(eta * step_v)), n, mu);
        V::store3(z, (&mut next[k..k + LANES]).try_into().expect("four rows"));
        let d = z.minus(y);
        sums = [sums[0] + d.dot(d) / eta, sums[1] + gradient.dot(z.minus(x))];
    }
    let rest = any(op, first + whole, &mut next[whole..], from, step);
    let (moved, slope) = (sums[0].to_array(), sums[1].to_array());
    [moved[0] + moved[1] + moved[2] + moved[3] + rest[0], slope[0] + slope[1] + slope[2] + slope[3] + rest[1]]
}
