//! The contact points of two convex shapes, found again only once the shapes have moved against each other.
//!
//! Points of faces, edges and corners are held in the frame of each shape, the normal in the frame of the shape whose face it is across. Gaps
//! are then exact where one of the shapes has a face there. A curved shape that rolls or slides on a face touches it with another point at each
//! moment, the one that looks against the normal. Where curved shapes touch without a face both normal and points change with all motion, and
//! what lags behind would drive them on: they are kept while at rest alone.
//! Relative motion is that since the points were found, so that errors do not add up. Points are looked for somewhat farther than needed,
//! and pairs without any are kept as well: what falls side by side is not collided again in every step either.

use super::by_shape::ByShape;
use super::collide::convex::{Axis, separation};
use super::collide::manifold::{OF_SECOND, is_nearest};
use super::collide::point::{Placed, Point, Points};
use super::collide::rolling::{has_face, held, is_curved, rolled};
use super::collide::{Way, collide_along, pass};
use crate::manifolds::{Kept, KeptPoint, Manifolds, PartManifolds};
use crate::shape::ShapeKind;
use glam::DVec3;

/// Share of the least gap that relative motion may be: the normal between features that are apart turns by no more.
const OF_GAP: f64 = 0.1;

/// Share of the reach by which points are looked for farther: speeds grow for a while before they are looked for again.
const FARTHER: f64 = 0.15;

/// Share of the relative motion up to which points may be carried along that is left to curved shapes which touch without a face.
const OF_CURVED: f64 = 1e-2;

/// Whether manifolds of a shape are kept: of those whose narrow phase is cheaper than keeping them, none are.
pub fn keeps(kind: ShapeKind) -> bool {
    use ShapeKind::*;
    !matches!(kind, Sphere | Plane | Mesh | HeightField)
}

/// The manifolds of the last step, by pairs.
pub struct Last<'a> {
    manifolds: &'a Manifolds,
    /// Whether the candidate pairs are those of the last step.
    pairs_hold: bool,
    /// Part and index of each manifold, where the pairs do not hold.
    known: ByShape<[u32; 2]>,
}

impl<'a> Last<'a> {
    /// The manifolds of the last step, of a model with `n_shapes` shapes; `pairs_hold` asserts that the candidate pairs are the same.
    pub fn new(manifolds: &'a Manifolds, n_shapes: usize, pairs_hold: bool) -> Last<'a> {
        if pairs_hold {
            return Last { manifolds, pairs_hold, known: ByShape::default() };
        }
        let mut all = vec![];
        for (of_part, part) in manifolds.parts.iter().zip(0..) {
            all.extend(of_part.kept.iter().zip(0..).map(|(kept, k)| (kept.shapes, [part, k])));
        }
        let known = ByShape::of(n_shapes, all.len(), |i| all[i]);
        Last { manifolds, pairs_hold, known }
    }

    /// Part and index of the manifold of the pair `pair` of a part, of two shapes; `at` is where the part's last manifold was found, for pairs
    /// that ascend.
    pub fn find(&self, part: usize, pair: u32, shapes: [u32; 2], at: &mut usize) -> Option<[u32; 2]> {
        if !self.pairs_hold {
            return self.known.find(shapes).next().copied();
        }
        let kept = &self.manifolds.parts.get(part)?.kept;
        while kept.get(*at).is_some_and(|kept| kept.pair < pair) {
            *at += 1;
        }
        (kept.get(*at)?.pair == pair).then_some([part as u32, *at as u32])
    }

    /// The manifolds of a part.
    pub fn part(&self, part: usize) -> &'a PartManifolds {
        const NONE: &PartManifolds = &PartManifolds { kept: vec![], points: vec![] };
        self.manifolds.parts.get(part).unwrap_or(NONE)
    }

    /// A manifold, and its points.
    pub fn get(&self, [part, k]: [u32; 2]) -> (&'a Kept, &'a [KeptPoint]) {
        let of_part = &self.manifolds.parts[part as usize];
        (&of_part.kept[k as usize], of_part.points_of(k as usize))
    }
}

/// The manifolds of a part of the candidate pairs while they are found, in the order of the pairs.
pub struct Keeping<'a> {
    kept: &'a mut PartManifolds,
    /// The part's manifolds of the last step.
    last: &'a PartManifolds,
    /// How many of them, from the first on, are all that has been kept so far: they are copied once another manifold follows.
    same: usize,
}

impl<'a> Keeping<'a> {
    /// Begin in the memory of `kept`; `last` has the part's manifolds of the last step.
    pub fn begin(kept: &'a mut PartManifolds, last: &'a PartManifolds) -> Keeping<'a> {
        kept.clear();
        Keeping { kept, last, same: 0 }
    }

    /// Keep a manifold of the last step, with its points, as that of the pair `pair`.
    fn go_on(&mut self, (known, points): (&Kept, &[KeptPoint]), pair: u32) {
        let is_next = |next: &Kept| std::ptr::eq(next, known) && known.pair == pair;
        if self.kept.kept.is_empty() && self.last.kept.get(self.same).is_some_and(is_next) {
            self.same += 1;
            return;
        }
        self.copy();
        self.kept.points.extend_from_slice(points);
        self.kept.kept.push(Kept { pair, end: self.kept.points.len() as u32, ..*known });
    }

    /// Keep a point of the new manifold that follows.
    fn push_point(&mut self, point: KeptPoint) {
        self.copy();
        self.kept.points.push(point);
    }

    /// Keep a new manifold, whose points have come before; its end is known here.
    fn push(&mut self, manifold: Kept) {
        self.copy();
        self.kept.kept.push(Kept { end: self.kept.points.len() as u32, ..manifold });
    }

    /// Copy what is the same as in the last step.
    fn copy(&mut self) {
        if self.same > 0 {
            let (same, end) = (&self.last.kept[..self.same], self.last.kept[self.same - 1].end);
            self.kept.kept.extend_from_slice(same);
            self.kept.points.extend_from_slice(&self.last.points[..end as usize]);
            self.same = 0;
        }
    }

    /// End. Returns whether the manifolds are all those of the last step, which are not copied.
    pub fn end(mut self) -> bool {
        let are_same = self.same > 0 && self.same == self.last.kept.len();
        if !are_same {
            self.copy();
        }
        are_same
    }
}

/// How far points of two shapes have moved against each other since those of a manifold were found, m, at most: in the frame of the larger one.
pub fn moved([a, b]: [&Placed; 2], kept: &Kept) -> f64 {
    let turned = a.orientation * kept.orientation;
    // Sine of half the angle.
    let half = (turned.inverse() * b.orientation).xyz().length();
    let between = b.position - a.position;
    let way = if a.extent < b.extent {
        b.local(between).distance(kept.orientation.inverse() * kept.position)
    } else {
        a.local(between).distance(kept.position)
    };
    way + 2.0 * half * a.extent.min(b.extent)
}

/// How far apart contact points may be, m.
#[derive(Clone, Copy)]
pub struct Reach {
    /// The gap up to which points are contacts.
    pub contacts: f64,
    /// The gap up to which they are looked for, at least.
    pub look: f64,
}

/// Find the contact points of two convex shapes within their reach, and keep their manifold: those of `last` carried along, or new ones once the shapes
/// have moved against each other by more than `slack`, m; it comes with how far that is, m. They have a gap of at least `gap`, m. Gaps up to `rest_gap`, m,
/// carry. `way` tells how they move in the step. Returns the number of points.
pub fn collide_or_recycle(
    [a, b]: [&Placed; 2],
    (pair, shapes): (u32, [u32; 2]),
    (reach, gap, slack, rest_gap): (Reach, f64, f64, f64),
    last: Option<((&Kept, &[KeptPoint]), f64)>,
    way: impl FnOnce() -> Way,
    (keeping, out): (&mut Keeping, &mut Points),
) -> usize {
    let Reach { contacts: reach, look } = reach;
    let is_beyond = gap > reach;
    let holds = |kept: &Kept, moved: f64| moved <= kept.slack && reach + moved <= kept.reach;
    if let Some((last, _)) = last.filter(|((known, _), moved)| is_beyond || holds(known, *moved)) {
        keeping.go_on(last, pair);
        return if is_beyond { 0 } else { carry([a, b], last.1, reach, out) };
    }
    if is_beyond {
        return 0;
    }
    let last = last.map(|(last, _)| last);
    let position = a.local(b.position - a.position);
    let manifold = |(axis, reach, gap, slack): (Axis, f64, f64, f64)| {
        let orientation = (a.orientation.inverse() * b.orientation).normalize();
        let (corners, axis) = (axis.corners, a.local(axis.direction).normalize_or_zero());
        Kept { pair, end: 0, shapes, position, orientation, axis, corners, reach, gap, slack }
    };
    let mut axis = last.map_or(Axis::default(), |(known, _)| Axis {
        direction: a.rotation * known.axis,
        apart: 0.0,
        corners: known.corners,
    });
    if last.is_some_and(|(_, points)| points.is_empty()) && axis.direction != DVec3::ZERO {
        axis.apart = separation(a, b, axis.direction);
        if axis.apart > reach {
            keeping.push(manifold((axis, axis.apart, axis.apart, axis.apart)));
            return 0;
        }
    }
    let farther = reach.max(look) * (1.0 + FARTHER);
    let n = collide_along(a, b, farther, &mut axis, out);
    let n = pass([a, b], way, (farther, rest_gap), (&mut axis, n), out);
    let face = face_of([a, b], &out[..n]);
    let mut least = farther;
    // Most points have one normal.
    let (mut normal, mut normals) = (DVec3::ZERO, [DVec3::ZERO; 2]);
    for p in &out[..n] {
        least = least.min(p.gap);
        if p.normal != normal {
            (normal, normals) = (p.normal, [a, b].map(|shape| shape.local(p.normal).normalize()));
        }
        let is_of_second = face.unwrap_or(p.feature & OF_SECOND != 0);
        let on_first = held(a, a.local(p.on_first - a.position), normals[0]);
        let on_second = held(b, b.local(p.on_second - b.position), -normals[1]);
        let (normal, feature) = (normals[is_of_second as usize], p.feature);
        keeping.push_point(KeptPoint { on_first, on_second, normal, feature, is_of_second });
    }
    // Of what does not carry yet the points may be behind: it carries once the gap is closed.
    let slack = match face {
        None if n > 0 && (is_curved(a.kind) || is_curved(b.kind)) => {
            OF_CURVED * slack + if least > 2.0 * rest_gap { OF_GAP * least } else { 0.0 }
        }
        _ => slack + OF_GAP * least.max(0.0),
    };
    let until = if n == 0 { axis.apart.max(farther) } else { farther };
    let (least, slack) = if n == 0 { (until, until) } else { (least, slack) };
    keeping.push(manifold((axis, until, least, slack)));
    let mut near = 0;
    for k in 0..n {
        out[near] = out[k];
        near += (out[k].gap <= reach) as usize;
    }
    near
}

/// Whether the normal of a manifold is across a face of the second shape, or of the first; `None` where it is across none. Of both that of the reference.
fn face_of([a, b]: [&Placed; 2], points: &[Point]) -> Option<bool> {
    let p = points.first()?;
    let is_across = |is_second: &bool| {
        if *is_second { has_face(b, b.local(-p.normal)) } else { has_face(a, a.local(p.normal)) }
    };
    let is_of_second = p.feature & OF_SECOND != 0;
    [is_of_second, !is_of_second].into_iter().find(is_across)
}

/// The points of a manifold where the shapes are now, those with a gap of at most `reach`, m. Returns their count.
fn carry([a, b]: [&Placed; 2], points: &[KeptPoint], reach: f64, out: &mut Points) -> usize {
    let curved = [a, b].map(|shape| is_curved(shape.kind));
    let mut n = 0;
    // Most points of a manifold have one normal.
    let (mut known, mut normal) = ((DVec3::ZERO, false), DVec3::ZERO);
    for p in points {
        if known != (p.normal, p.is_of_second) {
            known = (p.normal, p.is_of_second);
            normal = if p.is_of_second { b.rotation * p.normal } else { a.rotation * p.normal };
        }
        let of_first = curved[0].then(|| rolled(a, p.on_first, a.local(normal), p.feature)).flatten();
        let of_second = curved[1].then(|| rolled(b, p.on_second, b.local(-normal), p.feature)).flatten();
        let mut on_first = a.position + a.rotation * of_first.unwrap_or(p.on_first);
        let mut on_second = b.position + b.rotation * of_second.unwrap_or(p.on_second);
        let gap = (on_second - on_first).dot(normal);
        // What touches a face has its point there below its own.
        match (of_first.is_some(), of_second.is_some()) {
            (true, true) => {}
            (true, false) => on_second = on_first + normal * gap,
            (false, true) => on_first = on_second - normal * gap,
            (false, false) if is_nearest(p.feature) => {}
            (false, false) if p.is_of_second => on_second = on_first + normal * gap,
            (false, false) => on_first = on_second - normal * gap,
        }
        out[n] = Point { normal, on_first, on_second, gap, feature: p.feature };
        n += (gap <= reach) as usize;
        if n == out.len() {
            break;
        }
    }
    n
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::SplitMix64;
    use crate::geometry::Hull;
    use crate::pose::Pose;
    use glam::DQuat;

    /// Least gap of the points of a manifold.
    fn least(points: &[Point]) -> f64 {
        points.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min)
    }

    /// Collide two shapes that do not move, with a reach, a slack and a gap of rest, m, and maybe the manifold that they had.
    fn again(
        both: [&Placed; 2],
        (reach, slack, rest_gap): (f64, f64, f64),
        last: Option<(&Kept, &[KeptPoint])>,
        out: (&mut PartManifolds, &mut Points),
    ) -> usize {
        let reach = Reach { contacts: reach, look: reach };
        let last = last.map(|last| (last, moved(both, last.0)));
        let none = PartManifolds::default();
        let mut keeping = Keeping::begin(out.0, &none);
        let bounds = (reach, f64::NEG_INFINITY, slack, rest_gap);
        let n = collide_or_recycle(both, (0, [0, 1]), bounds, last, Way::default, (&mut keeping, out.1));
        assert!(!keeping.end(), "without a last step all are copied");
        n
    }

    #[test]
    fn carried_points_have_the_gaps_of_new_ones() {
        let mut random = SplitMix64(5);
        let corners: Vec<DVec3> = (0..20).map(|_| random.rotation() * DVec3::X).collect();
        let (hull, _) = Hull::of_points(&corners).unwrap();
        let mut carried = 0;
        for i in 0..2_000 {
            let kinds = [ShapeKind::Box, ShapeKind::Hull, ShapeKind::Cylinder];
            let mut placed = |kind: ShapeKind, position: DVec3| {
                let size = if kind == ShapeKind::Hull { DVec3::ONE } else { DVec3::new(1.0, 1.0, 0.8) };
                let hull = (kind == ShapeKind::Hull).then_some(&hull);
                Placed::new(kind, size, Pose { position, orientation: random.rotation() }, hull)
            };
            let a = placed(kinds[i % 3], DVec3::ZERO);
            let b = placed(kinds[i / 3 % 3], DVec3::new(0.0, 0.0, 1.9));
            let slack = 1e-3;
            let find = |b: &Placed, last: Option<(&Kept, &[KeptPoint])>, kept: &mut PartManifolds| {
                let mut out = Points::default();
                let n = again([&a, b], (0.2, slack, 0.0), last, (kept, &mut out));
                out[..n].to_vec()
            };
            let mut first = PartManifolds::default();
            find(&b, None, &mut first);
            let mut little = || DVec3::from([0; 3].map(|_| random.between(-1.0, 1.0))) * 1.5e-4;
            let (shift, turn) = (little(), little());
            let orientation = DQuat::from_scaled_axis(turn) * b.orientation;
            let moved = Placed::new(b.kind, b.size, Pose { position: b.position + shift, orientation }, b.hull);
            let mut second = PartManifolds::default();
            let last = first.kept.first().map(|kept| (kept, &first.points[..]));
            let (old, new) = (find(&moved, last, &mut second), find(&moved, None, &mut PartManifolds::default()));
            let Some(kept) = second.kept.first() else { continue };
            carried += (kept.position == first.kept[0].position) as usize;
            if old.is_empty() || new.is_empty() {
                // At the rim of the reach either may have it.
                assert!(least(&old).min(least(&new)) > 0.199, "{i}: {old:?} {new:?}");
                continue;
            }
            // By the square of the motion, and by the turn of the normal of two edges that overlap; by the motion where another feature is
            // nearer now.
            let by_turn = 3e-4 * -least(&old).min(0.0);
            let bound = if new.len() > 2 && old.len() == new.len() { 2e-5 + by_turn } else { 4e-4 };
            assert!((least(&old) - least(&new)).abs() < bound, "{i}: {} {}", least(&old), least(&new));
        }
        assert!(carried > 1_000, "{carried}");
    }

    /// A row of boxes on a slab: nothing is copied where all hold.
    #[test]
    fn manifolds_are_copied_once_one_of_them_changes() {
        let placed = |size: DVec3, position: DVec3| {
            Placed::new(ShapeKind::Box, size, Pose { position, orientation: DQuat::IDENTITY }, None)
        };
        let slab = placed(DVec3::new(10.0, 10.0, 0.5), DVec3::ZERO);
        let find = |kept: &mut PartManifolds, last: &PartManifolds, lifts: [f64; 3]| {
            let mut keeping = Keeping::begin(kept, last);
            for (pair, lift) in (0..).zip(lifts) {
                let block = placed(DVec3::splat(0.5), DVec3::new(2.0 * pair as f64, 0.0, 1.0 + lift));
                let both = [&slab, &block];
                let known = last.kept.get(pair as usize).map(|kept| (kept, last.points_of(pair as usize)));
                let known = known.map(|known| (known, moved(both, known.0)));
                let bounds = (Reach { contacts: 0.1, look: 0.1 }, f64::NEG_INFINITY, 1e-3, 0.0);
                let out = &mut Points::default();
                let n = collide_or_recycle(both, (pair, [0, 1]), bounds, known, Way::default, (&mut keeping, out));
                assert_eq!(n, 4);
            }
            keeping.end()
        };
        let [mut first, mut second, mut third] = [const { PartManifolds { kept: vec![], points: vec![] } }; 3];
        assert!(!find(&mut first, &PartManifolds::default(), [0.0; 3]));
        assert!(find(&mut second, &first, [1e-4; 3]) && second.kept.is_empty());
        assert!(!find(&mut third, &first, [0.0, 1e-2, 0.0]));
        assert_eq!((third.kept.len(), third.points.len()), (3, 12));
        let place = |part: &PartManifolds, k: usize| (part.kept[k].position, part.points_of(k)[0].on_second);
        assert!([0, 2].iter().all(|k| place(&third, *k) == place(&first, *k)) && place(&third, 1) != place(&first, 1));
    }

    /// Small and long boxes in either order, that move and turn: they come no nearer than by what is taken for their motion.
    #[test]
    fn gaps_close_by_no_more_than_shapes_have_moved() {
        /// Two shapes, or the second first.
        fn order(i: usize, both: [Placed; 2]) -> [Placed; 2] {
            if i.is_multiple_of(2) { both } else { [both[1], both[0]] }
        }
        let mut random = SplitMix64(6);
        let mut near = 0;
        for i in 0..4_000 {
            let mut vector = |most: f64| DVec3::from([0; 3].map(|_| random.between(-most, most)));
            let (small, long) = (DVec3::splat(0.02), DVec3::new(1.0, 0.01, 0.01));
            let (along, off, shift, turn) = (vector(0.9).x, vector(0.05), vector(2e-3), vector(2e-2));
            let (first, second) = (DQuat::from_scaled_axis(vector(3.0)), DQuat::from_scaled_axis(vector(3.0)));
            let placed = |size: DVec3, position: DVec3, orientation: DQuat| {
                Placed::new(ShapeKind::Box, size, Pose { position, orientation }, None)
            };
            let block = placed(small, DVec3::ZERO, first);
            let rod = placed(long, second * DVec3::X * along + off, second);
            let turned = DQuat::from_scaled_axis(turn) * second;
            let moved_rod = placed(long, rod.position + shift, turned);
            let find = |both: [Placed; 2]| {
                let mut kept = PartManifolds::default();
                again([&both[0], &both[1]], (0.05, 0.0, 0.0), None, (&mut kept, &mut Points::default()));
                kept
            };
            let (before, after) = (find(order(i, [block, rod])), find(order(i, [block, moved_rod])));
            let (Some(before), Some(after)) = (before.kept.first(), after.kept.first()) else { continue };
            let [a, b] = order(i, [block, moved_rod]);
            if before.gap > 0.0 {
                near += 1;
                let least = before.gap - moved([&a, &b], before);
                assert!(after.gap > least - 1e-9, "{i}: {} m, at least {least}", after.gap);
            }
        }
        assert!(near > 500, "{near}");
    }

    /// Shapes that roll a little, on a block, a hull and the end of a cylinder, touch it where they would if they were collided anew.
    #[test]
    fn what_rolls_on_a_face_is_touched_below_it() {
        let mut random = SplitMix64(8);
        let corners: Vec<DVec3> =
            (0..8).map(|k| DVec3::from_array([0, 1, 2].map(|axis| ((k >> axis & 1) * 2 - 1) as f64))).collect();
        let (hull, _) = Hull::of_points(&corners).unwrap();
        let quarter = std::f64::consts::FRAC_PI_2;
        let slant = 0.2f64.atan2(0.6);
        for i in 0..480 {
            let (kind, size, lying, height) = [
                (ShapeKind::Cylinder, DVec3::new(0.2, 0.2, 0.3), quarter, 0.2),
                (ShapeKind::Capsule, DVec3::new(0.2, 0.2, 0.3), quarter, 0.2),
                (ShapeKind::Ellipsoid, DVec3::splat(0.2), quarter, 0.2),
                (ShapeKind::Cone, DVec3::new(0.2, 0.2, 0.3), quarter + slant, 0.3 * slant.sin()),
            ][i % 4];
            let below = [ShapeKind::Box, ShapeKind::Hull, ShapeKind::Cylinder][i / 4 % 3];
            let hull = (below == ShapeKind::Hull).then_some(&hull);
            let frame = Pose { position: DVec3::ZERO, orientation: random.rotation() };
            let floor = Placed::new(below, DVec3::ONE, frame, hull);
            let about = DQuat::from_rotation_z(random.between(0.0, 3.0));
            let rests = about * DQuat::from_rotation_x(lying) * DQuat::from_rotation_z(random.between(0.0, 3.0));
            let gap = random.between(-1e-4, 1e-3);
            let at = |rolled: f64| {
                // The axis of what rolls turns about the vertical as well.
                let turn = about * DQuat::from_rotation_y(rolled) * about.inverse();
                let turn = DQuat::from_rotation_z(0.3 * rolled) * turn;
                let place = DVec3::new(0.1, -0.1, 1.0 + height + gap) + about * DVec3::X * height * rolled;
                let orientation = frame.orientation * turn * rests;
                Placed::new(kind, size, Pose { position: frame.orientation * place, orientation }, None)
            };
            for (is_second, step) in [(true, 5e-4), (false, -5e-4)] {
                let find = |b: &Placed, last: Option<(&Kept, &[KeptPoint])>, kept: &mut PartManifolds| {
                    let mut out = Points::default();
                    let both = if is_second { [&floor, b] } else { [b, &floor] };
                    let n = again(both, (0.01, 2e-3, 0.0), last, (kept, &mut out));
                    out[..n].to_vec()
                };
                let [mut first, mut second] = [PartManifolds::default(), PartManifolds::default()];
                find(&at(0.0), None, &mut first);
                let last = first.kept.first().map(|kept| (kept, &first.points[..]));
                let moved = at(step);
                let (old, new) = (find(&moved, last, &mut second), find(&moved, None, &mut PartManifolds::default()));
                assert!(second.kept[0].position == first.kept[0].position, "{kind:?} on {below:?}: not carried");
                assert!(!new.is_empty() && old.len() == new.len(), "{kind:?} on {below:?}: {old:?} {new:?}");
                for p in &old {
                    // The points of a search are right to a few millionths of the size.
                    let is_same =
                        |q: &Point| p.on_first.distance(q.on_first) < 2e-5 && p.on_second.distance(q.on_second) < 2e-5;
                    assert!(new.iter().any(is_same), "{kind:?} on {below:?}: {old:?} {new:?}");
                }
            }
        }
    }

    #[test]
    fn curved_shapes_that_touch_without_a_face_are_carried_at_rest_alone() {
        let size = DVec3::new(0.2, 0.2, 0.4);
        let place = |position: DVec3, orientation: DQuat| {
            Placed::new(ShapeKind::Cylinder, size, Pose { position, orientation }, None)
        };
        let a = place(DVec3::ZERO, DQuat::IDENTITY);
        let across = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
        for (gap, shift, is_carried) in [(0.0, 1e-7, true), (0.0, 1e-4, false), (5e-3, 1e-4, true)] {
            let mut out = Points::default();
            let [mut first, mut second] = [PartManifolds::default(), PartManifolds::default()];
            let at = DVec3::new(0.4 + gap, 0.0, 0.0);
            let mut find = |b: &Placed, last: Option<(&Kept, &[KeptPoint])>, kept: &mut PartManifolds| {
                again([&a, b], (0.01, 1e-3, 1e-3), last, (kept, &mut out))
            };
            assert_eq!(find(&place(at, across), None, &mut first), 1);
            let last = first.kept.first().map(|kept| (kept, &first.points[..]));
            assert_eq!(find(&place(at + DVec3::Z * shift, across), last, &mut second), 1);
            assert_eq!(second.kept[0].position == first.kept[0].position, is_carried, "{gap} {shift}");
        }
    }
}
