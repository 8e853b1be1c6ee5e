//! Shapes that pass each other within a step. What is nearest at its start is not what they will meet: a block that slides from slab to slab has
//! the next one's edge before it, and one that falls past a ledge the ledge's corner below it. A contact there would stop what moves on
//! freely. Where the way of the step keeps two shapes apart along some other axis, they have that one.

use super::convex::{Axis, Convex, Overlap, search, separation};
use super::manifold::{OF_SECOND, feature, feature_id};
use super::point::{MAX_POINTS, Placed, Point, Points, swap_shapes};
use super::rolling::{face_near, has_face};
use crate::ShapeKind;
use crate::manifolds::Corner;
use glam::{DMat3, DVec3};

/// Overlap, over the least half length, up to which shapes pass each other, where they move by more in the step: those that rest or slide overlap by
/// less.
const GRAZING: f64 = 2e-3;

/// What shapes come too near by on their way, over that overlap, from which on another axis is looked for.
const CLOSING: f64 = 1e-3;

/// Cosine of the angle from which on two axes are the same.
const SAME: f64 = 1.0 - 1e-6;

/// All places of a shape on its way, without turning; the shape is somewhat smaller.
struct Swept<'a> {
    shape: &'a Placed<'a>,
    way: DVec3,
    scale: f64,
}

impl Convex for Swept<'_> {
    fn support(&self, direction: DVec3) -> (DVec3, Corner) {
        let centre = self.shape.position;
        let point = centre + (self.shape.support(direction).0 - centre) * self.scale;
        (if direction.dot(self.way) > 0.0 { point + self.way } else { point }, 0)
    }

    fn corner(&self, _: Corner) -> Option<DVec3> {
        None
    }

    fn centre(&self) -> DVec3 {
        self.shape.position + self.way * 0.5
    }

    fn radius(&self) -> f64 {
        self.shape.radius() * self.scale
    }
}

/// How two shapes move in a step.
#[derive(Default)]
pub struct Way {
    /// Velocities of their centres, m/s.
    pub velocity: [DVec3; 2],
    /// How they turn, rad/s; of curved shapes, which may roll, zero.
    pub spin: [DVec3; 2],
    /// What gravity adds to the velocities, m/s.
    pub fall: [DVec3; 2],
    /// Step size, s.
    pub step: f64,
}

/// The ways of the second of two shapes against the first, as they move now, and with what gravity adds, at places with a normal, along which turning
/// counts.
struct Ways {
    normal: DVec3,
    /// The ways of their centres, m.
    of_centres: [DVec3; 2],
    /// What these are along the normal, m.
    along: [f64; 2],
    /// Gradients, over the place, of what turning adds along the normal, and what that is at the origin, m.
    of_turning: (DVec3, f64),
}

impl Ways {
    fn new(way: &Way, shapes: [&Placed; 2], normal: DVec3) -> Ways {
        let ([a, b], [fall_a, fall_b]) = (way.velocity, way.fall);
        let of_centres = [b - a, b - a + fall_b - fall_a].map(|v| v * way.step);
        let [a, b] = way.spin.map(|spin| normal.cross(spin) * way.step);
        let at_origin = a.dot(shapes[0].position) - b.dot(shapes[1].position);
        Ways { normal, of_centres, along: of_centres.map(|way| way.dot(normal)), of_turning: (b - a, at_origin) }
    }

    /// What turning adds along the normal at a place, m.
    fn turned(&self, place: DVec3) -> f64 {
        self.of_turning.0.dot(place) + self.of_turning.1
    }
}

/// Replace the `n` points of two convex shapes by those along the axis that keeps them apart on their way, if there is one. Points have a gap of
/// at most `reach`, m; shapes come to rest at a gap of `rest_gap`, m. Returns their count, and leaves the axis in `axis`.
pub fn pass(
    [a, b]: [&Placed; 2],
    way: impl FnOnce() -> Way,
    (reach, rest_gap): (f64, f64),
    (axis, n): (&mut Axis, usize),
    out: &mut Points,
) -> usize {
    use ShapeKind::{Box, Capsule, Ellipsoid, Sphere};
    let size = a.size.min_element().min(b.size.min_element());
    let grazing = GRAZING * size;
    let has_no_faces = |shape: &Placed| matches!(shape.kind, Sphere | Ellipsoid | Capsule);
    if n == 0 || [a, b].into_iter().all(has_no_faces) || out[..n].iter().any(|p| p.gap < -grazing) {
        return n;
    }
    let way = way();
    // What comes too near as it moves now; else as it falls.
    let mut worst = [(CLOSING * grazing, DVec3::ZERO, DVec3::ZERO); 2];
    // Most points have one normal.
    let mut ways = Ways::new(&way, [a, b], out[0].normal);
    for p in &out[..n] {
        if p.normal != ways.normal {
            ways = Ways::new(&way, [a, b], p.normal);
        }
        let turned = ways.turned(0.5 * (p.on_first + p.on_second));
        for (k, worst) in worst.iter_mut().enumerate() {
            let too_near = -(ways.along[k] + turned) - (p.gap - rest_gap).max(0.0);
            if too_near > worst.0 {
                *worst = (too_near, ways.of_centres[k] + p.normal * turned, p.normal);
            }
        }
    }
    let Some((_, way, normal)) = worst.into_iter().find(|(_, way, _)| *way != DVec3::ZERO) else { return n };
    // What rests on an edge would else be taken for what grazes a face, and be pushed off it.
    let scale = 1.0 - grazing.min(way.length()) / size;
    let found = match (a.kind, b.kind) {
        (Box, Box) => box_axis([a, b], way, scale),
        _ => any_axis([a, b], way, scale),
    };
    let Some(apart) = found.filter(|axis| axis.dot(normal) <= SAME) else { return n };
    let gap = separation(a, b, apart);
    *axis = Axis { direction: apart, apart: gap, ..Axis::default() };
    if gap > reach {
        return 0;
    }
    // They overlap by no more than along the axis that they had.
    let least = out[..n].iter().fold(0.0, |least: f64, p| least.min(p.gap));
    let lift = (least - gap).max(0.0);
    if has_face(a, a.local(apart)) {
        return over([a, b], apart, (reach, lift), out);
    }
    let n = over([b, a], -apart, (reach, lift), out);
    swap_shapes(out, n);
    out[..n].iter_mut().for_each(|p| p.feature |= OF_SECOND);
    n
}

/// The axis, unit, across a face of one of two shapes, that keeps them apart on their way, if there is one; the second is scaled.
fn any_axis([a, b]: [&Placed; 2], way: DVec3, scale: f64) -> Option<DVec3> {
    let swept = Swept { shape: b, way, scale };
    let near = match search(a, &swept, f64::INFINITY, &mut Axis::default()) {
        Ok(near) => near,
        Err(Overlap { near, .. }) => near,
    };
    let normal = near?.normal;
    let facing = |shape: &Placed, d: DVec3| face_near(shape, shape.local(d)).map(|face| shape.rotation * face);
    let faces = [facing(a, normal), facing(b, -normal).map(|face| -face)];
    faces.into_iter().flatten().find(|face| separation(a, &swept, *face) > 0.0)
}

/// [`any_axis`] of two boxes, across one of their faces.
fn box_axis([a, b]: [&Placed; 2], way: DVec3, scale: f64) -> Option<DVec3> {
    let turned = a.rotation.transpose() * b.rotation;
    let size = b.size * scale;
    let abs = |m: DMat3| DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
    let reach_a = a.size + abs(turned) * size;
    let reach_b = size + abs(turned.transpose()) * a.size;
    let [middles, ways] = [b.position - a.position, way].map(|v| [a.local(v), b.local(v)]);
    let mut best = (0.0, DVec3::ZERO);
    for (side, (reach, rotation)) in [(reach_a, &a.rotation), (reach_b, &b.rotation)].into_iter().enumerate() {
        for k in 0..3 {
            let (at, way) = (middles[side][k], ways[side][k]);
            let sign = 1.0f64.copysign(at);
            // The nearer of the start and the end.
            let apart = at.abs() + (sign * way).min(0.0) - reach[k];
            if apart > best.0 {
                best = (apart, rotation.col(k) * sign);
            }
        }
    }
    (best.0 > 0.0).then_some(best.1)
}

/// The points of a shape over the plane across a direction that touches another one, or is `lift`, m, below that, which goes on as far as the way does:
/// the corners that face it. Returns their count.
fn over([of, other]: [&Placed; 2], normal: DVec3, (reach, lift): (f64, f64), out: &mut Points) -> usize {
    let height = of.support(normal).0.dot(normal) + of.radius() - lift;
    let mut n = 0;
    for (corner, id) in feature(other, -normal).corners() {
        let gap = corner.dot(normal) - height;
        if gap <= reach && n < MAX_POINTS {
            let on_first = *corner - normal * gap;
            out[n] = Point { normal, on_first, on_second: *corner, gap, feature: feature_id(*id) };
            n += 1;
        }
    }
    n
}

#[cfg(test)]
mod tests {
    use super::super::boxes::box_box;
    use super::*;
    use crate::fill::SplitMix64;
    use crate::pose::Pose;

    #[test]
    fn edges_that_rest_on_each_other_do_not_pass_by_a_face() {
        /// Gap of the edges, and what they come nearer by in the step, m.
        const GAP: f64 = 5e-5;
        const NEARER: f64 = 2e-5;
        let mut random = SplitMix64(9);
        let mut several = 0;
        for k in 0..200_000 {
            let size = DVec3::from([0; 3].map(|_| random.between(0.1, 0.2)));
            let mut at = |position: DVec3| Pose { position, orientation: random.rotation() };
            let (first, mut second) = (at(DVec3::ZERO), at(DVec3::new(0.3, 0.1, -0.2)));
            let placed = |pose: Pose| Placed::new(ShapeKind::Box, size, pose, None);
            let a = placed(first);
            let (mut axis, mut out) = (Axis::default(), Points::default());
            box_box(&a, &placed(second), 0.5, &mut axis, &mut out);
            second.position -= axis.direction * (axis.apart - GAP);
            let b = placed(second);
            let n = box_box(&a, &b, 2.0 * GAP, &mut axis, &mut out);
            let faces = (0..6).map(|i| if i < 3 { a.rotation.col(i) } else { b.rotation.col(i - 3) });
            let apart = faces.map(|d| separation(&a, &b, d * d.dot(b.position - a.position).signum()));
            let nearest = apart.fold(f64::NEG_INFINITY, f64::max);
            if n != 1 || out[0].feature < 1 << 16 || !(-GRAZING * 0.1..-NEARER).contains(&nearest) {
                continue;
            }
            several += 1;
            let (edges, velocity) = (axis.direction, [DVec3::ZERO, -axis.direction * NEARER]);
            let way = || Way { velocity, step: 1.0, ..Way::default() };
            let n = pass([&a, &b], way, (2.0 * GAP, 2.0 * GAP), (&mut axis, n), &mut out);
            assert!(n == 1 && axis.direction == edges, "{k}: {:?}", out[0]);
        }
        assert!(several > 20, "{several}");
    }
}
