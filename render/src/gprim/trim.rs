//! Trim curves as loops of straight pieces (RISpec 5.3).

use crate::gprim::nurbs::nurbs_curve;
use crate::scene::trim::Trim;
use glam::Vec3;
use ri::{Fail, TrimCurves};

/// Straight pieces of a curve's span.
const PIECES: usize = 24;

/// How far apart the ends of curves that follow each other may be, in parts of the larger of 1 and their coordinates.
const APART: f32 = 1e-3;

/// The loops of `TrimCurve`, none of an empty one, which ends trimming; and the first of them whose curves do not join.
pub fn trim(t: &TrimCurves) -> Result<(Option<Trim>, Option<usize>), Fail> {
    let short = || Fail::new("TrimCurve: its lists do not fit each other");
    let (mut curve, mut point, mut knot) = (0, 0, 0);
    let (mut loops, mut open) = (Vec::new(), None);
    for (index, n) in t.n_curves.iter().enumerate() {
        let (mut line, mut ends): (Vec<[f32; 2]>, Vec<[[f32; 2]; 2]>) = (Vec::new(), Vec::new());
        for _ in 0..*n {
            let (Some(order), Some(n)) = (t.order.get(curve), t.n.get(curve)) else { return Err(short()) };
            let (order, n) = (*order as usize, *n as usize);
            if !(2..=32).contains(&order) || n < order || n > 1 << 20 {
                return Err(Fail::new(format!("TrimCurve: a curve of {n} points of order {order}")));
            }
            let part = |v: &[f32], from: usize, n: usize| v.get(from..from + n).map(<[f32]>::to_vec).ok_or(short());
            let (u, v, w) = (part(&t.u, point, n)?, part(&t.v, point, n)?, part(&t.w, point, n)?);
            let knots = part(&t.knot, knot, n + order)?;
            let (Some(min), Some(max)) = (t.min.get(curve), t.max.get(curve)) else { return Err(short()) };
            let points: Vec<Vec3> = (0..n).map(|i| Vec3::new(u[i], v[i], w[i])).collect();
            let total = PIECES * (n + 1 - order);
            let step = |k: usize| min + (max - min) * k as f32 / total as f32;
            line.extend((0..total).map(|k| nurbs_curve(&points, &knots, order, step(k))));
            ends.push([step(0), step(total)].map(|t| nurbs_curve(&points, &knots, order, t)));
            (curve, point, knot) = (curve + 1, point + n, knot + n + order);
        }
        let next = ends.iter().cycle().skip(1);
        if !ends.iter().zip(next).all(|(this, next)| meet(this[1], next[0])) {
            open = open.or(Some(index));
        }
        if line.len() >= 3 {
            loops.push(line);
        }
    }
    Ok(((!loops.is_empty()).then_some(Trim { loops, outside: false }), open))
}

/// Whether two ends are one.
fn meet(a: [f32; 2], b: [f32; 2]) -> bool {
    (0..2).all(|c| (a[c] - b[c]).abs() <= APART * a[c].abs().max(b[c].abs()).max(1.0))
}
