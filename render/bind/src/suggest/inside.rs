//! Points in boxes, counted: a k-d tree, whose parts that lie in a box are counted whole.

use glam::Vec3;

/// Points, sorted as a tree: the middle one parts those before it from those behind it along an axis, and so on within both.
pub(super) struct Points {
    sorted: Vec<Vec3>,
    lo: Vec3,
    hi: Vec3,
}

/// Points that are counted one by one.
const FEW: usize = 16;

impl Points {
    /// Sort points, all of them finite.
    pub(super) fn new(mut points: Vec<Vec3>) -> Points {
        let lo = points.iter().fold(Vec3::INFINITY, |lo, p| lo.min(*p));
        let hi = points.iter().fold(Vec3::NEG_INFINITY, |hi, p| hi.max(*p));
        sort(&mut points, 0);
        Points { sorted: points, lo, hi }
    }

    /// The number of all points.
    pub(super) fn len(&self) -> usize {
        self.sorted.len()
    }

    /// The lowest corner of the box around the points; infinite if there are none.
    pub(super) fn lo(&self) -> Vec3 {
        self.lo
    }

    /// The number of points between two corners, those on the faces left out.
    pub(super) fn count(&self, lo: Vec3, hi: Vec3) -> usize {
        count(&self.sorted, 0, [self.lo, self.hi], [lo, hi])
    }
}

fn sort(points: &mut [Vec3], axis: usize) {
    if points.len() <= FEW {
        return;
    }
    let half = points.len() / 2;
    let (before, _, behind) = points.select_nth_unstable_by(half, |a, b| a[axis].total_cmp(&b[axis]));
    sort(before, (axis + 1) % 3);
    sort(behind, (axis + 1) % 3);
}

/// Count the points of a part of the tree, which lie in `within`, that are in the box from `lo` to `hi`.
fn count(points: &[Vec3], axis: usize, within: [Vec3; 2], [lo, hi]: [Vec3; 2]) -> usize {
    let is_in = |p: &Vec3| p.cmpgt(lo).all() && p.cmplt(hi).all();
    let [from, to] = within;
    if from.cmpge(hi).any() || to.cmple(lo).any() {
        return 0;
    }
    if is_in(&from) && is_in(&to) {
        return points.len();
    }
    if points.len() <= FEW {
        return points.iter().filter(|p| is_in(p)).count();
    }
    let half = points.len() / 2;
    let middle = points[half];
    let (mut end, mut start) = (to, from);
    (end[axis], start[axis]) = (middle[axis], middle[axis]);
    let next = (axis + 1) % 3;
    is_in(&middle) as usize
        + count(&points[..half], next, [from, end], [lo, hi])
        + count(&points[half + 1..], next, [start, to], [lo, hi])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_counted_as_one_by_one() {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Few values, so that many points lie on faces and upon each other.
            (state >> 24) as f32 / 16.0
        };
        for n in [0, 1, FEW, FEW + 1, 1000] {
            let all: Vec<Vec3> = (0..n).map(|_| Vec3::new(next(), next(), next())).collect();
            let points = Points::new(all.clone());
            assert_eq!(points.len(), n);
            for _ in 0..200 {
                let [a, b] = [0; 2].map(|_| Vec3::new(next(), next(), next()));
                let (lo, hi) = (a.min(b), a.max(b));
                let expected = all.iter().filter(|p| p.cmpgt(lo).all() && p.cmplt(hi).all()).count();
                assert_eq!(points.count(lo, hi), expected, "{n}: {lo} {hi}");
            }
            assert_eq!(points.count(Vec3::NEG_INFINITY, Vec3::INFINITY), n);
        }
    }
}
