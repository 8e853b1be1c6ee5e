//! Triangle meshes and height fields.

use glam::DVec3;

/// A static surface of triangles, solid below (behind) them.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Vertices, local, m.
    pub vertices: Vec<DVec3>,
    /// Triangles: indices into `vertices`, anticlockwise seen from outside (n_triangles).
    pub triangles: Vec<[u32; 3]>,
    /// Convex edges and corners of each triangle, as bits (n_triangles): bit e, from 0 to 2, is set if the edge from corner e to
    /// corner e+1 is convex or a border, and belongs to this triangle rather than to its neighbour; bit 3+k says the same of corner k.
    pub sharp: Vec<u8>,
    /// Spatial index of the triangles.
    index: Index,
}

/// Spatial index of triangles.
#[derive(Clone, Debug, PartialEq)]
enum Index {
    /// A tree of boxes: node i has the triangles `order[first..first+n]` if n > 0, else the nodes first and first+1.
    Tree { nodes: Vec<TreeNode>, order: Vec<u32> },
    /// A grid of cells in x and y, two triangles each.
    Cells { origin: [f64; 2], spacing: [f64; 2], n: [usize; 2] },
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct TreeNode {
    min: DVec3,
    max: DVec3,
    first: u32,
    n: u32,
}

impl Surface {
    /// A triangle mesh from vertices, m, and triangles that face outwards.
    pub fn mesh(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Surface {
        let (nodes, order) = tree(&vertices, &triangles);
        let sharp = sharp_edges(&vertices, &triangles);
        Surface { vertices, triangles, sharp, index: Index::Tree { nodes, order } }
    }

    /// A height field, m: `heights[j n_x + i]` at x = origin_x + i spacing_x, y = origin_y + j spacing_y, with n_x, n_y ≥ 2.
    pub fn height_field(heights: &[f64], n: [usize; 2], origin: [f64; 2], spacing: [f64; 2]) -> Surface {
        let vertices: Vec<DVec3> = (0..n[0] * n[1])
            .map(|k| {
                let (i, j) = ((k % n[0]) as f64, (k / n[0]) as f64);
                DVec3::new(origin[0] + i * spacing[0], origin[1] + j * spacing[1], heights[k])
            })
            .collect();
        let mut triangles = Vec::with_capacity(2 * (n[0] - 1) * (n[1] - 1));
        for j in 0..n[1] - 1 {
            for i in 0..n[0] - 1 {
                let v = |di: usize, dj: usize| ((j + dj) * n[0] + i + di) as u32;
                triangles.push([v(0, 0), v(1, 0), v(1, 1)]);
                triangles.push([v(0, 0), v(1, 1), v(0, 1)]);
            }
        }
        let sharp = sharp_edges(&vertices, &triangles);
        Surface { vertices, triangles, sharp, index: Index::Cells { origin, spacing, n: [n[0] - 1, n[1] - 1] } }
    }

    /// The corners of a triangle, local, m.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|v| self.vertices[v as usize])
    }

    /// Visit the triangles that a shape in the box from `min` to `max`, local, m, may touch, in a fixed order. In a mesh they are those
    /// whose boxes overlap the box; in a height field also the triangles above it, since a shape below the ground is pushed out.
    pub fn visit(&self, min: DVec3, max: DVec3, found: &mut dyn FnMut(u32)) {
        match &self.index {
            Index::Tree { nodes, order } => {
                let mut open = vec![0u32];
                while let Some(i) = open.pop() {
                    let node = &nodes[i as usize];
                    if !(node.min.cmple(max).all() && min.cmple(node.max).all()) {
                        continue;
                    }
                    if node.n == 0 {
                        open.extend([node.first + 1, node.first]);
                    } else {
                        order[node.first as usize..(node.first + node.n) as usize].iter().for_each(|t| found(*t));
                    }
                }
            }
            Index::Cells { origin, spacing, n } => {
                let cell = |x: f64, axis: usize| ((x - origin[axis]) / spacing[axis]).floor();
                let range = |axis: usize| {
                    let (lo, hi) = (cell(min[axis], axis), cell(max[axis], axis));
                    (hi >= 0.0 && lo < n[axis] as f64)
                        .then(|| (lo.max(0.0) as usize, (hi.max(0.0) as usize).min(n[axis] - 1)))
                };
                let (Some((i0, i1)), Some((j0, j1))) = (range(0), range(1)) else { return };
                for j in j0..=j1 {
                    for i in i0..=i1 {
                        for t in [0, 1] {
                            let triangle = (2 * (j * n[0] + i) + t) as u32;
                            // A shape below the ground is still to be pushed out of it.
                            if self.corners(triangle).iter().any(|c| c.z >= min.z) {
                                found(triangle);
                            }
                        }
                    }
                }
            }
        }
    }

    /// Whether all that is below the surface is solid, however deep: a height field.
    pub fn is_ground(&self) -> bool {
        matches!(self.index, Index::Cells { .. })
    }

    /// The boxes of the triangles as one walk down a tree, with which [`Surface::visit`] finds the same triangles.
    pub fn walk(&self) -> Vec<Branch> {
        let mut walk = vec![];
        let own;
        let (nodes, order, lowest) = match &self.index {
            Index::Tree { nodes, order } => (nodes, order, f64::INFINITY),
            // A shape below the ground is still to be pushed out of it.
            Index::Cells { .. } => {
                own = tree(&self.vertices, &self.triangles);
                (&own.0, &own.1, f64::NEG_INFINITY)
            }
        };
        if !self.triangles.is_empty() {
            go_down(nodes, order, 0, &mut walk);
        }
        walk.iter_mut().for_each(|b| b.min.z = b.min.z.min(lowest));
        walk
    }

    /// Minimum and maximum corner of the box that contains all vertices, local, m.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.vertices.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), v| (lo.min(*v), hi.max(*v)))
    }
}

/// A box of the tree of a surface's triangles.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Minimum corner, local, m.
    pub min: DVec3,
    /// Maximum corner, local, m.
    pub max: DVec3,
    /// The triangles of a leaf; none where boxes follow below this one.
    pub triangles: Vec<u32>,
    /// Where the walk goes on beside the box.
    pub next: usize,
}

/// Write a node of a tree, and those below it.
fn go_down(nodes: &[TreeNode], order: &[u32], i: usize, walk: &mut Vec<Branch>) {
    let (TreeNode { min, max, first, n }, at) = (nodes[i], walk.len());
    let triangles = order[first as usize..][..n as usize].to_vec();
    walk.push(Branch { min, max, triangles, next: 0 });
    if n == 0 {
        [first, first + 1].into_iter().for_each(|child| go_down(nodes, order, child as usize, walk));
    }
    walk[at].next = walk.len();
}

/// A tree of boxes about triangles, halved along their longest axes, and the order of the triangles in its leaves.
fn tree(vertices: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<TreeNode>, Vec<u32>) {
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    let mut nodes = vec![];
    let bounds = |t: u32| {
        let corners = triangles[t as usize].map(|v| vertices[v as usize]);
        (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]))
    };
    nodes.push(TreeNode { min: DVec3::ZERO, max: DVec3::ZERO, first: 0, n: order.len() as u32 });
    let mut open = vec![0usize];
    while let Some(i) = open.pop() {
        let TreeNode { first, n, .. } = nodes[i];
        let range = first as usize..(first + n) as usize;
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for t in &order[range.clone()] {
            let (lo, hi) = bounds(*t);
            (min, max) = (min.min(lo), max.max(hi));
        }
        (nodes[i].min, nodes[i].max) = (min, max);
        if n <= 4 {
            continue;
        }
        let extent = max - min;
        let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
        let middle = |t: u32| bounds(t).0[axis] + bounds(t).1[axis];
        order[range].sort_by(|a, b| middle(*a).total_cmp(&middle(*b)));
        let half = n / 2;
        let child = nodes.len() as u32;
        for (first, n) in [(first, half), (first + half, n - half)] {
            open.push(nodes.len());
            nodes.push(TreeNode { min, max, first, n });
        }
        (nodes[i].first, nodes[i].n) = (child, 0);
    }
    (nodes, order)
}

/// The edges of triangles, in the direction in which each triangle goes about itself.
struct Edges {
    /// Where the edges from a vertex begin (n_vertices + 1).
    first: Vec<u32>,
    /// The other vertex and the triangle of each edge, ordered by them within a vertex (3 n_triangles).
    ends: Vec<[u32; 2]>,
}

impl Edges {
    fn of(n_vertices: usize, triangles: &[[u32; 3]]) -> Edges {
        let mut first = vec![0u32; n_vertices + 1];
        for v in triangles.as_flattened() {
            first[*v as usize + 1] += 1;
        }
        for v in 0..n_vertices {
            first[v + 1] += first[v];
        }
        let mut next = first.clone();
        let mut ends = vec![[0u32; 2]; 3 * triangles.len()];
        for (i, t) in triangles.iter().enumerate() {
            for e in 0..3 {
                let at = &mut next[t[e] as usize];
                ends[*at as usize] = [t[(e + 1) % 3], i as u32];
                *at += 1;
            }
        }
        first.windows(2).for_each(|range| ends[range[0] as usize..range[1] as usize].sort_unstable());
        Edges { first, ends }
    }

    /// The triangle that has an edge, the last of several.
    fn triangle(&self, from: u32, to: u32) -> Option<usize> {
        let ends = &self.ends[self.first[from as usize] as usize..self.first[from as usize + 1] as usize];
        let beyond = ends.partition_point(|[end, _]| *end <= to);
        ends[..beyond].last().filter(|[end, _]| *end == to).map(|[_, triangle]| *triangle as usize)
    }
}

/// The bits of convex edges and corners, each of which belongs to one triangle.
fn sharp_edges(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Vec<u8> {
    let at = |v: u32| vertices[v as usize];
    let normal = |t: &[u32; 3]| (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).normalize_or_zero();
    let edges = Edges::of(vertices.len(), triangles);
    let mut sharp = vec![0u8; triangles.len()];
    let mut corner_taken = vec![false; vertices.len()];
    for (i, t) in triangles.iter().enumerate() {
        for e in 0..3 {
            let is_convex = match edges.triangle(t[(e + 1) % 3], t[e]) {
                None => true,
                Some(j) => {
                    let other = triangles[j].iter().find(|v| **v != t[e] && **v != t[(e + 1) % 3]);
                    let beyond = other.map_or(DVec3::ZERO, |v| at(*v) - at(t[e]));
                    i < j && beyond.dot(normal(t)) < -1e-6 * beyond.length()
                }
            };
            if is_convex {
                sharp[i] |= 1 << e;
                for k in [e, (e + 1) % 3] {
                    if !std::mem::replace(&mut corner_taken[t[k] as usize], true) {
                        sharp[i] |= 8 << k;
                    }
                }
            }
        }
    }
    sharp
}
