//! The inner loop of the descent methods over contacts: read the gradient, step, project.
//!
//! Contacts without cohesion go four at a time through lanes; the order of the sums is the same on all machines.

use super::bodies::BodyOperator;
use super::cells::Cells;
use super::operator::any;
use super::response::Extrapolated;
use crate::contacts::Arms;
use crate::lanes::{LaneLoop, Lanes4, four, four_mut, project, widest};
use crate::rows::{SERIAL_LIMIT, add, cut, reduce_chunks, reduce_tasks};
use crate::twist::Twist;
use glam::DVec3;
use rayon::prelude::*;

/// Number of contacts side by side.
const LANES: usize = 4;

/// A projected step of contacts without cohesion, as [`Operator::descend`](super::operator::Operator::descend); their impulses are
/// added to the `sums` of their bodies, those of each tile while its bodies are in the cache.
pub fn contacts(
    op: &BodyOperator,
    next: &mut [DVec3],
    from: &Extrapolated,
    step: f64,
    sums: &Cells<Twist>,
) -> [f64; 2] {
    let n = next.len();
    if n == 0 {
        return [0.0; 2];
    }
    let (mut done, mut rest) = ([0.0; 2], next);
    for starts in op.contacts.tiles.rounds() {
        let lengths = starts.windows(2).map(|ends| (ends[1] - ends[0]) as usize);
        let (own, after) = rest.split_at_mut(lengths.clone().sum());
        rest = after;
        let tiles = cut(own, lengths).into_par_iter().zip(starts).with_max_len(1);
        // The tiles of a round have no moving body in common.
        let visit = |(next, first): (&mut [DVec3], &u32)| {
            widest(Chunk { op, first: *first as usize, next, from, step, sums: Some(sums) })
        };
        done = add(done, reduce_tasks(tiles, n <= SERIAL_LIMIT, visit));
    }
    let first = n - rest.len();
    done =
        add(done, reduce_chunks(rest, |k, next| widest(Chunk { op, first: first + k, next, from, step, sums: None })));
    // SAFETY: no other thread is at work.
    rest.iter().enumerate().for_each(|(k, z)| unsafe { op.add_block(first + k, *z, sums) });
    done
}

/// A chunk of consecutive contacts, whose impulses are added to `sums`, if given. No other thread touches the entries of these contacts'
/// moving bodies meanwhile.
struct Chunk<'a> {
    op: &'a BodyOperator<'a>,
    first: usize,
    next: &'a mut [DVec3],
    from: &'a Extrapolated<'a>,
    step: f64,
    sums: Option<&'a Cells<'a, Twist>>,
}

impl LaneLoop for Chunk<'_> {
    type Out = [f64; 2];

    #[inline(always)]
    fn run<V: Lanes4>(self) -> [f64; 2] {
        match self.op.contacts.arms {
            Arms::Any(_) => run::<V, false>(self),
            Arms::Along(_) => run::<V, true>(self),
        }
    }
}

#[inline(always)]
fn run<V: Lanes4, const SPHERES: bool>(Chunk { op, first, next, from, step, sums }: Chunk) -> [f64; 2] {
    let n = next.len();
    let range = first..first + n;
    let c = op.contacts;
    let (bodies, normal, law) = (&c.bodies[range.clone()], &c.normal[range.clone()], &c.law[range.clone()]);
    let (arms, reach): (&[[DVec3; 2]], &[[f64; 2]]) = match &c.arms {
        Arms::Any(arms) => (&arms[range.clone()], &[]),
        Arms::Along(reach) => (&[], &reach[range.clone()]),
    };
    let (gap, eta) = (&c.gap[range.clone()], &op.eta[range.clone()]);
    let offset = op.offset.column(range.clone());
    let (h, zero) = (V::splat(op.recovery.step), V::splat(0.0));
    let (x, previous) = (&from.x[range.clone()], &from.previous[range]);
    let twist = &from.response.twist[..];
    let (beta, step_v) = (V::splat(from.beta), V::splat(step));
    let mut done = [V::splat(0.0); 2];
    let whole = n - n % LANES;
    for k in (0..whole).step_by(LANES) {
        let [p, q, r, s] = four(bodies, k);
        let [va, wa] =
            V::twists([&twist[p[0] as usize], &twist[q[0] as usize], &twist[r[0] as usize], &twist[s[0] as usize]]);
        let [vb, wb] =
            V::twists([&twist[p[1] as usize], &twist[q[1] as usize], &twist[r[1] as usize], &twist[s[1] as usize]]);
        let normals = V::load3(four(normal, k));
        let offset = match offset {
            Some(offset) => V::load(four(offset, k)),
            None => {
                let gap = V::load(four(gap, k));
                gap.select_le(zero, zero, gap) / h
            }
        };
        let rotational = if SPHERES {
            let [reach_a, reach_b] = V::load2(four(reach, k));
            normals.cross(wa.times(reach_a).plus(wb.times(reach_b)))
        } else {
            let [p, q, r, s] = four(arms, k);
            wb.cross(V::load3(&[p[1], q[1], r[1], s[1]])).minus(wa.cross(V::load3(&[p[0], q[0], r[0], s[0]])))
        };
        let gradient = vb.minus(va).plus(rotational).plus(normals.times(offset));
        let (x, eta) = (V::load3(four(x, k)), V::load(four(eta, k)));
        let y = x.plus(x.minus(V::load3(four(previous, k))).times(beta));
        let [p, q, r, s] = four(law, k);
        let mu = V::load(&[
            op.laws[*p as usize].friction,
            op.laws[*q as usize].friction,
            op.laws[*r as usize].friction,
            op.laws[*s as usize].friction,
        ]);
        let z = project(y.minus(gradient.times(eta * step_v)), normals, mu);
        let next = four_mut(next, k);
        V::store3(z, next);
        let d = z.minus(y);
        done = [done[0] + d.dot(d) / eta, done[1] + gradient.dot(z.minus(x))];
        // SAFETY: what `Chunk` says of `sums`, here and below.
        let Some(sums) = sums else { continue };
        if SPHERES {
            let ([reach_a, reach_b], torque) = (V::load2(four(reach, k)), z.cross(normals));
            let to_a = V::to_twists(z.times(V::splat(-1.0)), torque.times(reach_a));
            let to_b = V::to_twists(z, torque.times(reach_b));
            for l in 0..LANES {
                unsafe {
                    op.add_impulse(sums, bodies[k + l][0], &to_a[l]);
                    op.add_impulse(sums, bodies[k + l][1], &to_b[l]);
                }
            }
        } else {
            (0..LANES).for_each(|l| unsafe { op.add_block(first + k + l, next[l], sums) });
        }
    }
    let rest = any(op, first + whole, &mut next[whole..], from, step);
    if let Some(sums) = sums {
        (whole..next.len()).for_each(|k| unsafe { op.add_block(first + k, next[k], sums) });
    }
    let (moved, slope) = (done[0].to_array(), done[1].to_array());
    [moved[0] + moved[1] + moved[2] + moved[3] + rest[0], slope[0] + slope[1] + slope[2] + slope[3] + rest[1]]
}
