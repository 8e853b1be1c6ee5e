//! Two boxes, by the separating axis theorem: the axis of minimum overlap is either a face's normal (then the other box's face
//! is clipped to it) or a cross product of edges (then the two edges' nearest points touch). Boxes that are apart and have no faces in front of
//! each other have the nearest points of any two convex shapes.

use super::manifold::{OF_SECOND, clip, convex_convex, feature};
use super::point::{Placed, Point, Points, swap_shapes};
use glam::{DMat3, DVec3};

/// Separation of two boxes along a unit axis, m; negative in overlap.
fn separation(axis: DVec3, ra: &DMat3, a: &Placed, rb: &DMat3, b: &Placed) -> f64 {
    let reach_a = (ra.transpose() * axis).abs().dot(a.size);
    let reach_b = (rb.transpose() * axis).abs().dot(b.size);
    (b.position - a.position).dot(axis).abs() - reach_a - reach_b
}

pub fn box_box(a: &Placed, b: &Placed, reach: f64, out: &mut Points) -> usize {
    let (ra, rb) = (DMat3::from_quat(a.orientation), DMat3::from_quat(b.orientation));
    let mut best_face = (f64::NEG_INFINITY, 0usize);
    for i in 0..6 {
        let axis = if i < 3 { ra.col(i) } else { rb.col(i - 3) };
        let s = separation(axis, &ra, a, &rb, b);
        if s > reach {
            return 0;
        }
        // A face of the first box is kept unless the second's is clearly better, so that the choice is stable.
        if s > best_face.0 + if i == 3 { 1e-9 } else { 0.0 } {
            best_face = (s, i);
        }
    }
    let mut best_edge = (f64::NEG_INFINITY, 0, 0, DVec3::ZERO);
    for i in 0..3 {
        for j in 0..3 {
            let cross = ra.col(i).cross(rb.col(j));
            if cross.length_squared() < 1e-8 {
                continue;
            }
            let axis = cross.normalize();
            let s = separation(axis, &ra, a, &rb, b);
            if s > reach {
                return 0;
            }
            if s > best_edge.0 {
                best_edge = (s, i, j, axis);
            }
        }
    }
    let size = a.size.min_element().min(b.size.min_element());
    if best_edge.0 > best_face.0 + 1e-3 * size {
        return edge_edge(a, &ra, b, &rb, best_edge, out);
    }
    let axis = if best_face.1 < 3 { ra.col(best_face.1) } else { rb.col(best_face.1 - 3) };
    let normal = if axis.dot(b.position - a.position) < 0.0 { -axis } else { axis };
    let n = if best_face.1 < 3 {
        clip(&feature(a, normal), &feature(b, -normal), normal, reach, out)
    } else {
        let n = clip(&feature(b, -normal), &feature(a, normal), -normal, reach, out);
        swap_shapes(out, n);
        out[..n].iter_mut().for_each(|p| p.feature |= OF_SECOND);
        n
    };
    // Faces that are not in front of each other: the boxes are nearest at edges or corners, by which fast ones will meet.
    if n == 0 && best_face.0 > 0.0 { convex_convex(a, b, reach, out) } else { n }
}

fn edge_edge(
    a: &Placed,
    ra: &DMat3,
    b: &Placed,
    rb: &DMat3,
    (gap, i, j, axis): (f64, usize, usize, DVec3),
    out: &mut Points,
) -> usize {
    let normal = if axis.dot(b.position - a.position) < 0.0 { -axis } else { axis };
    // The middle of the edge of each box that is farthest towards the other.
    let support = |placed: &Placed, r: &DMat3, along: usize, towards: DVec3| {
        let local = r.transpose() * towards;
        let mut p = DVec3::ZERO;
        for k in (0..3).filter(|k| *k != along) {
            p[k] = placed.size[k].copysign(local[k]);
        }
        placed.position + *r * p
    };
    let (pa, pb) = (support(a, ra, i, normal), support(b, rb, j, -normal));
    let (da, db) = (ra.col(i), rb.col(j));
    // Nearest points of the two lines pa + s da and pb + t db.
    let (d, w) = (da.dot(db), pb - pa);
    let det = 1.0 - d * d;
    let s = (w.dot(da) - d * w.dot(db)) / det;
    let t = (d * w.dot(da) - w.dot(db)) / det;
    let on_first = pa + da * s.clamp(-a.size[i], a.size[i]);
    let on_second = pb + db * t.clamp(-b.size[j], b.size[j]);
    out[0] = Point { normal, on_first, on_second, gap, feature: 1 << 16 | (i * 3 + j) as u32 };
    1
}
