//! Whether the edges of a polygon cross: a sweep over their ends, each edge held against its neighbours alone, O(n log n).
//! Source: Shamos and Hoey, Geometric intersection problems, 1976.

use glam::DVec2;
use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::ops::Bound;

/// Ends nearer than this part of the polygon's size to an edge lie on it.
const TOUCHES: f64 = 1e-6;

/// Whether two edges of some loops cross. What touches, runs along another edge or only meets at a corner does not cross.
pub fn crosses(loops: &[&[DVec2]]) -> bool {
    let points = || loops.iter().copied().flatten();
    let low = points().fold(DVec2::INFINITY, |low, p| low.min(*p));
    let least = TOUCHES * points().fold(0.0f64, |size, p| size.max((*p - low).max_element()));
    let around = |points: &'_ [DVec2], i: usize| [points[i], points[(i + 1) % points.len()]];
    let ends = loops.iter().flat_map(|points| (0..points.len()).map(|i| around(points, i)));
    let edges: Vec<Edge> = ends.filter(|[a, b]| a != b).enumerate().map(|(id, ends)| Edge::new(id, ends)).collect();
    // Of ends at one place, those where edges stop come first.
    let mut stops: Vec<(DVec2, bool, usize)> = Vec::with_capacity(2 * edges.len());
    stops.extend(edges.iter().flat_map(|edge| [(edge.from, true, edge.id), (edge.to, false, edge.id)]));
    stops.sort_unstable_by(|a, b| before(a.0, b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut open: BTreeSet<Edge> = BTreeSet::new();
    for (_, starts, id) in stops {
        let edge = edges[id];
        if !starts {
            open.remove(&edge);
        }
        let below = open.range(..edge).next_back();
        let above = open.range((Bound::Excluded(edge), Bound::Unbounded)).next();
        let cross = |a: Option<&Edge>, b: Option<&Edge>| a.zip(b).is_some_and(|(a, b)| a.crosses(b, least));
        let found = match starts {
            true => cross(below, Some(&edge)) || cross(Some(&edge), above),
            false => cross(below, above),
        };
        if found {
            return true;
        }
        if starts {
            open.insert(edge);
        }
    }
    false
}

/// An edge, from its left end to its right one. In order, those below come first; this is one order as long as none cross.
#[derive(Clone, Copy)]
struct Edge {
    id: usize,
    from: DVec2,
    to: DVec2,
}

impl Edge {
    fn new(id: usize, [a, b]: [DVec2; 2]) -> Edge {
        if before(a, b).is_lt() { Edge { id, from: a, to: b } } else { Edge { id, from: b, to: a } }
    }

    /// Twice the area of the triangle that a point makes with it, above 0 if the point is above.
    fn side(&self, p: DVec2) -> f64 {
        (self.to - self.from).perp_dot(p - self.from)
    }

    /// Whether each has an end on either side of the other, farther than `least` from it.
    fn crosses(&self, other: &Edge, least: f64) -> bool {
        let parts = |a: &Edge, b: &Edge| {
            let sides = [a.side(b.from), a.side(b.to)];
            sides[0] * sides[1] < 0.0 && sides.iter().all(|side| side.abs() > least * a.from.distance(a.to))
        };
        parts(self, other) && parts(other, self)
    }
}

impl Ord for Edge {
    fn cmp(&self, other: &Edge) -> Ordering {
        if self.id == other.id {
            return Ordering::Equal;
        }
        // Where the later of them starts; where it ends, if it starts on the other.
        let above = |first: &Edge, later: &Edge| {
            let side = first.side(later.from);
            let side = if side == 0.0 { first.side(later.to) } else { side };
            side.total_cmp(&0.0)
        };
        let order = match before(self.from, other.from) {
            Ordering::Greater => above(other, self),
            _ => above(self, other).reverse(),
        };
        order.then(self.id.cmp(&other.id))
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Edge) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Edge {
    fn eq(&self, other: &Edge) -> bool {
        self.id == other.id
    }
}

impl Eq for Edge {}

/// The order in which the sweep comes to points.
fn before(a: DVec2, b: DVec2) -> Ordering {
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn is_crossed(loops: &[&[[f64; 2]]]) -> bool {
        // Turned too, so that no edge is along an axis.
        let turned = |angle: f64| -> bool {
            let turn = DVec2::from_angle(angle);
            let mut all: Vec<Vec<DVec2>> = vec![];
            for points in loops {
                all.push(points.iter().map(|p| turn.rotate(DVec2::from(*p))).collect());
            }
            crosses(&all.iter().map(Vec::as_slice).collect::<Vec<_>>())
        };
        let [first, second, third] = [0.0, TAU / 4.0, 0.3].map(turned);
        assert_eq!((first, first), (second, third));
        first
    }

    #[test]
    fn edges_cross_or_touch() {
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        assert!(is_crossed(&[&[[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 3.0]]]), "a bow");
        assert!(is_crossed(&[&square, &[[1.0, 1.0], [5.0, 2.0], [1.0, 3.0]]]), "a hole that reaches out");
        assert!(!is_crossed(&[&square, &[[1.0, 1.0], [3.0, 2.0], [1.0, 3.0]]]), "a hole");
        assert!(!is_crossed(&[&square, &[[1.0, 1.0], [4.0, 2.0], [1.0, 3.0]]]), "a hole that touches the outline");
        let keyhole = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        assert!(!is_crossed(&[&keyhole]), "a hole with a way in, there and back");
        let spur = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [6.0, 2.0], [4.0, 2.0], [4.0, 4.0], [0.0, 4.0], [0.0, 4.0]];
        assert!(!is_crossed(&[&spur]), "a spur, and a corner twice");
    }

    #[test]
    fn one_crossing_among_many_edges_is_found() {
        // A band that winds to and fro.
        let n = 20_000;
        let way = |side: f64| (0..n).map(move |i| [i as f64, if i % 2 == 0 { 0.0 } else { 100.0 } + side]);
        let mut band: Vec<[f64; 2]> = way(0.0).chain(way(40.0).rev()).collect();
        assert!(!is_crossed(&[&band]));
        band[n / 2][1] += 60.0;
        assert!(is_crossed(&[&band]));
    }
}
