//! Edges of micropolygons at samples of layers: every layer counts, so that a sample on an edge that two triangles share belongs to one of
//! them.
//!
//! On which side of an edge a sample lies is the sign of a determinant of its two ends, which triangles on either side of it evaluate to
//! the same number of the other sign. On the line itself a sample counts as if it were moved by an infinitesimal to the left, and by less
//! than that down. Sides of grids are another matter: grids round the points that they share apart, and one may have points on a
//! side that the other does not have. There an edge is taken wider, and layers of both grids are joined (`layers.rs`).
//!
//! Twin: gpu/layer_edges.wgsl

/// A micropolygon's edge is taken this much wider, pixels, so that rounding opens no crack between neighbours.
pub(crate) const EDGE: f32 = 1.5e-3;

/// Parts of `EDGE` beside a side of a grid within which a sample lies at that side.
const BAND: f32 = 3.0;

/// Parts of `EDGE` inside an edge of the primitive up to which a sample lies on it. Farther inside, a neighbour that is met has the sample
/// on its own edge, or beyond.
const ON_RIM: f32 = 0.65;

/// What of a micropolygon has a sample, which lies somewhere about it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AtEdge {
    /// It is near a side of its grid, where another grid of the same primitive may be met, too.
    pub grid: bool,
    /// And this side is an edge of the primitive.
    pub primitive: bool,
    /// By how much depths of what is one there may differ.
    pub slack: f32,
}

/// A micropolygon around a sample.
pub struct Around {
    /// Corners from the sample on, pixels.
    pub corners: [[f32; 2]; 4],
    /// Which sides are sides of the grid, and of the primitive: from its first corner to the second, to the third, to the fourth, and back.
    pub outer: [bool; 4],
    pub rims: [bool; 4],
    /// The sign of the area of triangles that are there; 0 if both are.
    pub side: f32,
}

/// An edge as the sample sees it.
#[derive(Clone, Copy)]
struct Side {
    /// Twice the area between the sample and the edge.
    area: f32,
    /// The sample lies to its left.
    left: bool,
    /// How much of the other sign the area may be, if the edge is taken wider.
    width: Option<f32>,
}

impl Side {
    fn new(p: [f32; 2], q: [f32; 2], is_outer: bool) -> Side {
        let area = area_of(p, q);
        let left = area > 0.0 || area == 0.0 && (q[1] > p[1] || q[1] == p[1] && q[0] > p[0]);
        Side { area, left, width: is_outer.then(|| EDGE * length(p, q)) }
    }

    fn reversed(self) -> Side {
        Side { area: -self.area, left: !self.left, ..self }
    }

    /// Whether the sample lies on the side of the edge where a triangle is, which has the edge on its left if `is_left`.
    fn has(&self, is_left: bool) -> bool {
        match self.width {
            Some(width) => (if is_left { self.area } else { -self.area }) >= -width,
            None => self.left == is_left,
        }
    }
}

impl Around {
    /// Which triangles of the micropolygon have the sample.
    pub fn inside(&self) -> [bool; 2] {
        let [a, b, c, d] = self.corners;
        let [ab, bc] = [Side::new(a, b, self.outer[0]), Side::new(b, c, self.outer[1])];
        let [cd, da] = [Side::new(c, d, self.outer[2]), Side::new(d, a, self.outer[3])];
        let diagonal = Side::new(a, c, false);
        [[ab, bc, diagonal.reversed()], [cd, da, diagonal]].map(|sides| {
            let area = sides[0].area + sides[1].area + sides[2].area;
            area != 0.0 && self.side * area >= 0.0 && sides.iter().all(|side| side.has(area > 0.0))
        })
    }

    /// Where the sample is, in a triangle with these depths at its corners.
    pub fn at_edge(&self, second: bool, depths: [f32; 4]) -> AtEdge {
        let [a, b, c, d] = self.corners;
        let area = if second {
            area_of(c, d) + area_of(d, a) + area_of(a, c)
        } else {
            area_of(a, b) + area_of(b, c) - area_of(a, c)
        };
        let (mut grid, mut primitive) = (false, false);
        for k in (0..4).filter(|k| self.outer[*k]) {
            let (p, q) = (self.corners[k], self.corners[(k + 1) % 4]);
            let band = BAND * EDGE;
            let beside = |c: usize| p[c].min(q[c]) <= band && p[c].max(q[c]) >= -band;
            let inside = if area > 0.0 { area_of(p, q) } else { -area_of(p, q) };
            if beside(0) && beside(1) && inside.abs() <= band * length(p, q) {
                grid = true;
                primitive |= self.rims[k] && inside <= ON_RIM * EDGE * length(p, q);
            }
        }
        let slack = if grid { self.slack(second, depths) } else { 0.0 };
        AtEdge { grid, primitive, slack }
    }

    /// How far the depth of a triangle changes within the band, but no further than it changes at all.
    fn slack(&self, second: bool, depths: [f32; 4]) -> f32 {
        let [i, j, k] = if second { [0, 2, 3] } else { [0, 1, 2] };
        let [p, q, r] = [i, j, k].map(|k| self.corners[k]);
        let (u, v) = ([q[0] - p[0], q[1] - p[1]], [r[0] - p[0], r[1] - p[1]]);
        let (du, dv) = (depths[j] - depths[i], depths[k] - depths[i]);
        let area = (u[0] * v[1] - v[0] * u[1]).abs();
        let change = BAND * EDGE * ((du * v[1] - dv * u[1]).abs() + (dv * u[0] - du * v[0]).abs());
        let range = du.max(dv).max(0.0) - du.min(dv).min(0.0);
        if change < range * area { change / area } else { range }
    }
}

/// Twice the area between a sample and an edge whose ends are given from the sample on; positive where the sample lies to its left.
#[inline(always)]
pub fn area_of(p: [f32; 2], q: [f32; 2]) -> f32 {
    p[0] * q[1] - p[1] * q[0]
}

/// The length of an edge as its two parts add up.
fn length(p: [f32; 2], q: [f32; 2]) -> f32 {
    (q[0] - p[0]).abs() + (q[1] - p[1]).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places of samples on steps of 1/1024 pixel about a fan of triangles, at any of its edges and corners: each is in one triangle.
    #[test]
    fn a_sample_on_an_edge_or_a_corner_is_in_one_triangle() {
        // A grid of 5 × 5 points with all sides within a larger one; one row is drawn together to a point, one to a line.
        let point = |i: i32, j: i32| match j {
            2 => [(i * 1311) % 2048 + 2048 * i, 4096],
            3 => [2048 * i, 4097 + (i * 7) % 3],
            4 => [4000, 9000],
            _ => [2048 * i + (j * 613) % 700, 2048 * j + (i * i * 397) % 1024],
        };
        let mut seen = 0;
        for (x, y) in (0..120).flat_map(|x| (0..300).map(move |y| (x * 64 + 512, y * 16 + 512))) {
            let place = |i: i32, j: i32| point(i, j).map(|c| c as f32 / 1024.0);
            let of = |i: i32, j: i32| {
                let p = place(i, j);
                [p[0] - x as f32 / 1024.0, p[1] - y as f32 / 1024.0]
            };
            let count = |i: i32, j: i32| {
                let corners = [of(i, j), of(i + 1, j), of(i + 1, j + 1), of(i, j + 1)];
                let around = Around { corners, outer: [false; 4], rims: [false; 4], side: 0.0 };
                around.inside().iter().filter(|inside| **inside).count()
            };
            let n: usize = (0..4).flat_map(|i| (0..4).map(move |j| (i, j))).map(|(i, j)| count(i, j)).sum();
            // In the middle, beyond reach of the outer sides.
            if (2000..6000).contains(&x) && (2500..4000).contains(&y) {
                assert_eq!(n, 1, "at {x}, {y}");
                seen += 1;
            }
        }
        assert!(seen > 1000);
        // Corners and places along edges themselves.
        for (x, y) in (1..4).flat_map(|i| (1..3).map(move |j| (i, j))).map(|(i, j)| (point(i, j)[0], point(i, j)[1])) {
            let of = |i: i32, j: i32| {
                let p = point(i, j);
                [(p[0] - x) as f32 / 1024.0, (p[1] - y) as f32 / 1024.0]
            };
            let count = |(i, j): (i32, i32)| {
                let corners = [of(i, j), of(i + 1, j), of(i + 1, j + 1), of(i, j + 1)];
                let around = Around { corners, outer: [false; 4], rims: [false; 4], side: 0.0 };
                around.inside().iter().filter(|inside| **inside).count()
            };
            let n: usize = (0..4).flat_map(|i| (0..4).map(move |j| (i, j))).map(count).sum();
            assert_eq!(n, 1, "at corner {x}, {y}");
        }
    }

    #[test]
    fn at_the_side_of_a_grid_an_edge_is_wider_and_depths_may_differ_by_their_slope() {
        let around = |x: f32| Around {
            corners: [[x, -0.5], [x + 1.0, -0.5], [x + 1.0, 0.5], [x, 0.5]],
            outer: [false, false, false, true],
            rims: [false, false, false, true],
            side: 0.0,
        };
        assert_eq!(around(0.001).inside(), [false, true]);
        assert_eq!(around(0.002).inside(), [false, false]);
        let depths = [10.0, 12.0, 12.0, 10.0];
        let at = around(0.001).at_edge(true, depths);
        assert!(at.grid && at.primitive && (at.slack - 2.0 * BAND * EDGE).abs() < 1e-6, "{at:?}");
        assert_eq!(around(-0.1).at_edge(true, depths), AtEdge::default());
        // The slope of a sliver says nothing: its depths differ by no more than they do.
        let sliver = Around { corners: [[0.0, 0.0], [1e-3, 0.0], [1e-3, 9.0], [0.0, 9.0]], ..around(0.0) };
        assert_eq!(sliver.at_edge(false, [10.0, 12.0, 12.0, 10.0]).slack, 2.0);
    }
}
