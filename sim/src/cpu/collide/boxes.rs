//! Two boxes, by the separating axis theorem: the axis of minimum overlap is either a face's normal (then the other box's face is clipped to it)
//! or a cross product of edges (then the two edges' nearest points touch; boxes that are fast, or whose faces are hardly inclined to each other,
//! have the points of these as well, by which they will meet next). Boxes that are apart, and nearest elsewhere than in front of that face or where
//! those edges cross, have the nearest points of any two convex shapes.

use super::convex::Axis;
use super::manifold::{OF_SECOND, cut_id, feature_id};
use super::point::{MAX_POINTS, Placed, Point, Points, longest_axis, swap_shapes};
use super::solids::convex_convex;
use glam::{DMat3, DVec3};

/// What a separation is more than another one, over the least half length, to be clearly greater.
const CLEARLY: f64 = 1e-3;

/// The axis between two boxes along which they are farthest apart, or overlap least.
struct Separations {
    /// Separation along a face's normal, m, and its index: those of A, then those of B.
    face: (f64, usize),
    /// The greatest separation along a cross product of edges, m, and the edges' indices on A and B, where it is clearly greater than that
    /// along the face's normal.
    edge: Option<(f64, usize, usize)>,
}

impl Separations {
    /// The separations of boxes with these rotations, or the axis of one that is beyond `reach`, m.
    fn of([a, b]: [&Placed; 2], [ra, rb]: [&DMat3; 2], reach: f64) -> Result<Separations, (DVec3, f64)> {
        /// The least squared sine of the angle between edges of which a cross product is taken.
        const PARALLEL: f64 = 1e-8;
        // B in the frame of A: its rotation, and the place of its middle.
        let into_a = ra.transpose();
        let r = into_a * *rb;
        let middle = into_a * (b.position - a.position);
        let abs = DMat3::from_cols(r.x_axis.abs(), r.y_axis.abs(), r.z_axis.abs());
        let of_a = middle.abs() - a.size - abs * b.size;
        let of_b = (r.transpose() * middle).abs() - b.size - abs.transpose() * a.size;
        let mut best = [(f64::NEG_INFINITY, 0); 2];
        for (i, s) in [of_a.x, of_a.y, of_a.z, of_b.x, of_b.y, of_b.z].into_iter().enumerate() {
            if s > reach {
                return Err((towards(face_axis([ra, rb], i), a, b), s));
            }
            let best = &mut best[i / 3];
            if s > best.0 {
                *best = (s, i);
            }
        }
        // A face of the first box is kept unless the second's is clearly better: where two faces lie on each other either may be, and points that change
        // from one to the other in each step would never rest.
        let [first, second] = best;
        let clearly = CLEARLY * a.size.min_element().min(b.size.min_element());
        let face = if second.0 > first.0 + clearly { second } else { first };
        let than = first.0.max(second.0) + clearly;
        // Along the cross products of edges, times the sines of the angles between these.
        let (m, size_a, size_b) = (middle.to_array(), a.size.to_array(), b.size.to_array());
        let (r, abs) = (r.to_cols_array_2d(), abs.to_cols_array_2d());
        let scaled: [[f64; 3]; 3] = std::array::from_fn(|i| {
            let (k, l) = ((i + 1) % 3, (i + 2) % 3);
            std::array::from_fn(|j| {
                let (n, o) = ((j + 1) % 3, (j + 2) % 3);
                let reach_a = size_a[k] * abs[j][l] + size_a[l] * abs[j][k];
                let reach_b = size_b[n] * abs[o][i] + size_b[o] * abs[n][i];
                (m[l] * r[j][k] - m[k] * r[j][l]).abs() - reach_a - reach_b
            })
        });
        // What is negative is less without the sine.
        let least = than.min(0.0);
        if scaled.as_flattened().iter().fold(f64::NEG_INFINITY, |most, s| most.max(*s)) <= least {
            return Ok(Separations { face, edge: None });
        }
        let mut edge: Option<(f64, usize, usize)> = None;
        for (i, j) in (0..9).map(|k| (k / 3, k % 3)).filter(|(i, j)| scaled[*i][*j] > least) {
            let sine2 = 1.0 - r[j][i] * r[j][i];
            if sine2 < PARALLEL {
                continue;
            }
            let s = scaled[i][j] / sine2.sqrt();
            if s > reach {
                return Err((towards(edge_axis([ra, rb], i, j), a, b), s));
            }
            if s > edge.map_or(than, |(greatest, ..)| greatest) {
                edge = Some((s, i, j));
            }
        }
        Ok(Separations { face, edge })
    }
}

/// The normal of a face: of A for indices up to 2, of B beyond.
fn face_axis([ra, rb]: [&DMat3; 2], i: usize) -> DVec3 {
    if i < 3 { ra.col(i) } else { rb.col(i - 3) }
}

/// The cross product of an edge of A and one of B, unit.
fn edge_axis([ra, rb]: [&DMat3; 2], i: usize, j: usize) -> DVec3 {
    ra.col(i).cross(rb.col(j)).normalize()
}

/// An axis, or its opposite, that points from A to B.
fn towards(axis: DVec3, a: &Placed, b: &Placed) -> DVec3 {
    if axis.dot(b.position - a.position) < 0.0 { -axis } else { axis }
}

/// The contact points of two boxes with a gap of at most `reach`, m, with the axis along which they are farthest apart, or one along which
/// their gap is above `reach`. Returns their count.
pub fn box_box(a: &Placed, b: &Placed, reach: f64, axis: &mut Axis, out: &mut Points) -> usize {
    /// The reach, over the least half length, beyond which boxes that meet at edges may meet at their faces within the step.
    const FAST: f64 = 0.1;
    /// The overlap of faces, over the least half length, beyond which boxes that meet at edges are pushed apart by these alone: that
    /// is the shorter way.
    const DEEP: f64 = 0.2;
    /// The cosine of the angle between the normals of edges that cross and of a face from which on slower boxes, too, may meet at their faces
    /// within the step, unless these edges carry already.
    const FACING: f64 = 0.985;
    /// What the points of boxes that are apart may be farther from each other than the boxes along the axis, over the least half length.
    const NEAR: f64 = 1e-3;
    let rotations = [&a.rotation, &b.rotation];
    let Separations { face, edge } = match Separations::of([a, b], rotations, reach) {
        Ok(separations) => separations,
        Err(apart) => {
            (axis.direction, axis.apart) = apart;
            return 0;
        }
    };
    let size = a.size.min_element().min(b.size.min_element());
    let crossing = edge.map(|edge| edge_edge(a, b, rotations, edge));
    let normal = towards(face_axis(rotations, face.1), a, b);
    (axis.direction, axis.apart) = (normal, face.0);
    if let Some(point) = crossing {
        (axis.direction, axis.apart) = (point.normal, point.gap);
        if point.gap > 0.0 && point.on_first.distance(point.on_second) > point.gap + NEAR * size {
            return convex_convex(a, b, reach, axis, out);
        }
        let may_meet_at_faces = point.gap > 0.0 && point.normal.dot(normal) >= FACING;
        if reach <= FAST * size && !may_meet_at_faces {
            out[0] = point;
            return 1;
        }
    }
    let n = if face.1 < 3 {
        clip_face((a, rotations[0]), (b, rotations[1]), face.1, normal, reach, out)
    } else {
        let n = clip_face((b, rotations[1]), (a, rotations[0]), face.1 - 3, -normal, reach, out);
        swap_shapes(out, n);
        out[..n].iter_mut().for_each(|p| p.feature |= OF_SECOND);
        n
    };
    match crossing {
        Some(point) => {
            let mut kept = 0;
            for k in 0..n.min(MAX_POINTS - 1) {
                out[kept] = out[k];
                kept += (out[k].gap > -DEEP * size) as usize;
            }
            out[kept] = point;
            kept + 1
        }
        None if face.0 > 0.0 && out[..n].iter().all(|p| p.gap > face.0 + NEAR * size) => {
            convex_convex(a, b, reach, axis, out)
        }
        None => n,
    }
}

/// A corner of a clipped face: its place in the frame of the reference box, m, along the two sides of the reference face and its normal, and
/// its id.
type Corner = ([f64; 3], u32);

/// The corners of a clipped face: a face of four, which each of four sides may give one more.
struct Corners {
    corner: [Corner; 8],
    n: usize,
}

impl Corners {
    fn new() -> Corners {
        Corners { corner: [([0.0; 3], 0); 8], n: 0 }
    }

    #[inline(always)]
    fn push(&mut self, corner: Corner) {
        self.corner[self.n & 7] = corner;
        self.n += 1;
    }

    /// Clip at the plane `sign` · coordinate ALONG = `limit`, m, the side `id` of the reference face, by way of `spare`: the corners beyond it
    /// are cut off. They follow each other, so that there is one way out and one back, and the rest is copied.
    #[inline(always)]
    fn clip<'a, const ALONG: usize>(
        face: &mut &'a mut Corners,
        spare: &mut &'a mut Corners,
        (sign, limit): (f64, f64),
        id: u32,
    ) {
        let n = face.n;
        let beyond = face.corner.map(|p| sign * p.0[ALONG] - limit);
        let out = (0..n).fold(0u32, |out, k| out | ((beyond[k] > 0.0) as u32) << k);
        if out == 0 {
            return;
        }
        let inside = !out & ((1 << n) - 1);
        let last = |mask: u32| 31 - mask.leading_zeros() as usize;
        let cut = |k: usize| {
            let next = if k + 1 < n { k + 1 } else { 0 };
            let (p, q) = (&face.corner[k], &face.corner[next]);
            let share = beyond[k] / (beyond[k] - beyond[next]);
            ([0, 1, 2].map(|x| p.0[x] + (q.0[x] - p.0[x]) * share), cut_id(p.1, q.1, id))
        };
        spare.n = 0;
        if out & 1 == 0 {
            let (first, last) = (out.trailing_zeros() as usize, last(out));
            face.corner[..first].iter().for_each(|p| spare.push(*p));
            spare.push(cut(first - 1));
            spare.push(cut(last));
            face.corner[last + 1..n].iter().for_each(|p| spare.push(*p));
        } else if inside != 0 {
            let (first, last) = (inside.trailing_zeros() as usize, last(inside));
            spare.push(cut(first - 1));
            face.corner[first..=last].iter().for_each(|p| spare.push(*p));
            spare.push(cut(last));
        }
        std::mem::swap(face, spare);
    }
}

/// What [`clip`](super::manifold::clip) does of the faces of two boxes, in the frame of the reference box: the face across `axis` that looks
/// along `normal`, and the face of the other that looks against it most. Each box comes with its rotation. Returns the number of points.
fn clip_face(
    (of, rotation): (&Placed, &DMat3),
    (other, turned): (&Placed, &DMat3),
    axis: usize,
    normal: DVec3,
    reach: f64,
    out: &mut Points,
) -> usize {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let frame = [rotation.col(i), rotation.col(j), rotation.col(axis)];
    let into = |v: DVec3| DVec3::from_array(frame.map(|along| along.dot(v)));
    let towards = turned.transpose() * -normal;
    let facing = longest_axis(towards);
    let (one, two) = ((facing + 1) % 3, (facing + 2) % 3);
    let out_of = turned.col(facing) * other.size[facing].copysign(towards[facing]);
    let centre = into(other.position - of.position + out_of);
    let (u, v) = (into(turned.col(one) * other.size[one]), into(turned.col(two) * other.size[two]));
    let first = (8 * facing + if towards[facing] < 0.0 { 4 } else { 0 } + 1) as u32;
    let (mut face, mut spare) = (Corners::new(), Corners::new());
    let (mut face, mut spare) = (&mut face, &mut spare);
    for (p, id) in [centre + u + v, centre - u + v, centre - u - v, centre + u - v].into_iter().zip(first..) {
        face.push((p.to_array(), id));
    }
    // The sides of the reference face, between its corners in the same order.
    Corners::clip::<1>(&mut face, &mut spare, (1.0, of.size[j]), 1);
    Corners::clip::<0>(&mut face, &mut spare, (-1.0, of.size[i]), 2);
    Corners::clip::<1>(&mut face, &mut spare, (-1.0, of.size[j]), 3);
    Corners::clip::<0>(&mut face, &mut spare, (1.0, of.size[i]), 4);
    let (sign, height) = (if normal.dot(rotation.col(axis)) < 0.0 { -1.0 } else { 1.0 }, of.size[axis]);
    let mut n = 0;
    for ([x, y, z], id) in &face.corner[..face.n] {
        let gap = sign * z - height;
        if gap <= reach {
            let on_second = of.position + frame[0] * *x + frame[1] * *y + frame[2] * *z;
            out[n] = Point { normal, on_first: on_second - normal * gap, on_second, gap, feature: feature_id(*id) };
            n += 1;
        }
    }
    n
}

/// The contact point of two edges that cross, with the gap along their cross product, m.
fn edge_edge(a: &Placed, b: &Placed, [ra, rb]: [&DMat3; 2], (gap, i, j): (f64, usize, usize)) -> Point {
    let normal = towards(edge_axis([ra, rb], i, j), a, b);
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
    Point { normal, on_first, on_second, gap, feature: 1 << 16 | (i * 3 + j) as u32 }
}

#[cfg(test)]
mod tests {
    use super::super::manifold::{clip, feature};
    use super::*;
    use crate::ShapeKind;
    use crate::fill::SplitMix64;
    use crate::pose::Pose;
    use glam::DQuat;

    #[test]
    fn faces_that_lie_on_each_other_have_one_reference() {
        let size = DVec3::new(0.1, 0.08, 0.05);
        let mut random = SplitMix64(5);
        for k in 0..1000 {
            let mut small = || DVec3::from([0; 3].map(|_| random.between(-1e-5, 1e-5)));
            let mut placed = |position: DVec3| {
                let orientation = DQuat::from_scaled_axis(small());
                Placed::new(ShapeKind::Box, size, Pose { position: position + small(), orientation }, None)
            };
            let (a, b) = (placed(DVec3::ZERO), placed(DVec3::new(0.03, 0.02, 0.1)));
            let (mut axis, mut out) = (Axis::default(), Points::default());
            let n = box_box(&a, &b, 1e-3, &mut axis, &mut out);
            assert!(n == 4 && out[..n].iter().all(|p| p.feature & OF_SECOND == 0), "{k}: {n} points");
        }
    }

    /// Boxes that are turned by half a degree against each other and meet at two edges: corners that the face below comes to next have points.
    #[test]
    fn boxes_that_meet_at_edges_have_the_corners_that_meet_next() {
        const REACH: f64 = 5e-3;
        let size = DVec3::splat(0.1);
        let mut random = SplitMix64(7);
        let mut met = 0;
        for k in 0..20_000 {
            let mut vector = |most: f64| DVec3::from([0; 3].map(|_| random.between(-most, most)));
            let mut placed = |position: DVec3| {
                let orientation = DQuat::from_scaled_axis(vector(1.0) * DVec3::Z + vector(0.01));
                Placed::new(ShapeKind::Box, size, Pose { position: position + vector(0.05), orientation }, None)
            };
            let (a, b) = (placed(DVec3::ZERO), placed(DVec3::new(0.1, 0.0, 0.2)));
            let (mut axis, mut out) = (Axis::default(), Points::default());
            let n = box_box(&a, &b, REACH, &mut axis, &mut out);
            let is_edge = |p: &Point| p.feature >> 16 == 1;
            if n == 0 || !is_edge(&out[n - 1]) || out[n - 1].gap < 0.0 {
                continue;
            }
            let top = a.rotation.z_axis;
            for corner in (0..4).map(|k| DVec3::new([-0.1, 0.1][k & 1], [-0.1, 0.1][k >> 1], -0.1)) {
                let corner = b.position + b.rotation * corner;
                let (local, gap) = (a.local(corner - a.position), (corner - a.position).dot(top) - 0.1);
                if local.x.abs().max(local.y.abs()) < 0.09 && gap > 1e-4 && gap < 0.8 * REACH {
                    met += 1;
                    let is_there = |p: &Point| p.on_first.distance(corner).min(p.on_second.distance(corner)) < REACH;
                    assert!(out[..n].iter().any(is_there), "{k}: {:?}", &out[..n]);
                }
            }
        }
        assert!(met > 100, "{met}");
    }

    #[test]
    fn faces_of_boxes_are_clipped_as_any_faces_are() {
        let mut random = SplitMix64(3);
        let mut several = 0;
        for k in 0..20_000 {
            let mut placed = |position: DVec3| {
                let size = DVec3::from([0; 3].map(|_| random.between(0.1, 0.3)));
                Placed::new(ShapeKind::Box, size, Pose { position, orientation: random.rotation() }, None)
            };
            let (a, b) = (placed(DVec3::new(0.3, -0.2, 0.1)), placed(DVec3::ZERO));
            let rotations = [a, b].map(|p| p.rotation);
            let normal = towards(rotations[0].col(k % 3), &a, &b);
            let [mut own, mut any] = [Points::default(); 2];
            let n = clip_face((&a, &rotations[0]), (&b, &rotations[1]), k % 3, normal, 0.2, &mut own);
            assert_eq!(n, clip(&feature(&a, normal), &feature(&b, -normal), normal, 0.2, &mut any), "{k}");
            for (p, q) in own[..n].iter().zip(&any) {
                let error = p.on_first.distance(q.on_first) + p.on_second.distance(q.on_second) + (p.gap - q.gap).abs();
                assert!(p.feature == q.feature && error < 1e-10, "{k}: {p:?} {q:?}");
            }
            several += (n > 2) as usize;
        }
        assert!(several > 5_000, "{several}");
    }
}
