//! Blobbies (PRMan's application note 31): a field made of leaves and operators, and the surface where it is 0.421875.
//!
//! The surface is found on a grid by surface nets (Gibson 1998): a point in every cell that it crosses, and a quadrilateral across
//! every grid edge that it crosses; the points are then drawn to the surface along the field's slope, which gives the normals too.

use crate::scene::patch::Patch;
use crate::scene::variables::Varying;
use glam::{Mat4, Vec3};
use ri::Fail;

/// The field's value on the surface.
const LEVEL: f32 = 0.421_875;
/// Cells along the longest side of the bound.
const CELLS: f32 = 72.0;

/// A variable of the leaves of a blobby.
pub struct LeafVariable {
    /// Numbers of a leaf.
    pub numbers: usize,
    /// Those of all leaves.
    pub values: Vec<f32>,
    /// They are matrices, which lead points from the leaf's own space to where they are when the leaves are at rest.
    pub is_place: bool,
}

impl LeafVariable {
    /// Numbers of a value.
    fn width(&self) -> usize {
        if self.is_place { 3 } else { self.numbers }
    }

    /// The value of a leaf at a point of its space.
    fn at(&self, leaf: usize, p: Vec3) -> Vec<f32> {
        let own = &self.values[leaf * self.numbers..(leaf + 1) * self.numbers];
        if self.is_place { Mat4::from_cols_slice(own).transform_point3(p).to_array().to_vec() } else { own.to_vec() }
    }
}

/// A leaf or an operator on those before it.
enum Node {
    Constant(f32),
    /// Of the unit sphere, by the matrix into it.
    Ellipsoid(Mat4),
    /// A segment with a radius, in a space.
    Segment {
        a: Vec3,
        b: Vec3,
        radius: f32,
        into: Mat4,
    },
    /// Repelling plane: height above it of a point, as a depth map would give.
    Plane {
        point: Vec3,
        normal: Vec3,
        reach: f32,
    },
    Add(Vec<usize>),
    Multiply(Vec<usize>),
    Max(Vec<usize>),
    Min(Vec<usize>),
    Subtract(usize, usize),
    Divide(usize, usize),
    Negate(usize),
}

/// A blobby's field.
pub struct Field {
    nodes: Vec<Node>,
    leaves: Vec<usize>,
    min: Vec3,
    max: Vec3,
}

/// The falling off of a leaf's field: 1 in the middle, 0 at distance 1.
fn bump(r2: f32) -> f32 {
    if r2 >= 1.0 { 0.0 } else { (1.0 - r2).powi(3) }
}

impl Field {
    /// Read the codes.
    pub fn new(n_leaves: usize, codes: &[i32], floats: &[f32]) -> Result<Field, Fail> {
        let mut field = Field { nodes: vec![], leaves: vec![], min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };
        let mut at = 0;
        let wrong = |what: String| Fail::new(format!("blobby: {what}"));
        while at < codes.len() {
            let code = codes[at];
            at += 1;
            let mut integer = || {
                at += 1;
                codes.get(at - 1).copied().ok_or(wrong(format!("the codes end within code {code}")))
            };
            let numbers = |first: i32, n: usize| {
                let first = usize::try_from(first).unwrap_or(usize::MAX);
                let found = floats.get(first..first.saturating_add(n));
                found.ok_or(wrong(format!("code {code} needs {n} floats from {first}")))
            };
            let before = field.nodes.len();
            let operand = |i: i32| {
                let i = usize::try_from(i).ok().filter(|i| *i < before);
                i.ok_or(wrong(format!("code {code} names a part that is not before it")))
            };
            let node = match code {
                1000 => Node::Constant(numbers(integer()?, 1)?[0]),
                1001 => {
                    let m = Mat4::from_cols_slice(numbers(integer()?, 16)?);
                    field.reach(&m, Vec3::ZERO, 1.0);
                    Node::Ellipsoid(m.inverse())
                }
                1002 => {
                    let v = numbers(integer()?, 23)?;
                    let (a, b) = (Vec3::from_slice(&v[0..3]), Vec3::from_slice(&v[3..6]));
                    let m = Mat4::from_cols_slice(&v[7..23]);
                    field.reach(&m, a, v[6]);
                    field.reach(&m, b, v[6]);
                    Node::Segment { a, b, radius: v[6], into: m.inverse() }
                }
                1003 => {
                    // A plane instead of the depth file: its name is a string, its numbers say how it repels.
                    let (_, first) = (integer()?, integer()?);
                    let v = numbers(first, 4)?;
                    Node::Plane { point: Vec3::new(0.0, 0.0, v[0]), normal: Vec3::Z, reach: v[1].abs().max(1e-6) }
                }
                0..=3 => {
                    let n = integer()?;
                    let parts = (0..n.clamp(0, 1 << 20)).map(|_| operand(integer()?)).collect::<Result<Vec<_>, _>>()?;
                    match code {
                        0 => Node::Add(parts),
                        1 => Node::Multiply(parts),
                        2 => Node::Max(parts),
                        _ => Node::Min(parts),
                    }
                }
                4 => Node::Subtract(operand(integer()?)?, operand(integer()?)?),
                5 => Node::Divide(operand(integer()?)?, operand(integer()?)?),
                6 => Node::Negate(operand(integer()?)?),
                7 => {
                    operand(integer()?)?;
                    continue;
                }
                other => return Err(wrong(format!("unknown code {other}"))),
            };
            if code >= 1000 {
                field.leaves.push(field.nodes.len());
            }
            field.nodes.push(node);
        }
        if field.leaves.len() != n_leaves {
            return Err(wrong(format!("{} leaves, expected {n_leaves}", field.leaves.len())));
        }
        if field.nodes.is_empty() || !field.min.is_finite() || !field.max.is_finite() {
            return Err(wrong("no leaf with a bound".into()));
        }
        Ok(field)
    }

    fn reach(&mut self, m: &Mat4, center: Vec3, radius: f32) {
        let c = m.transform_point3(center);
        let row = |k: usize| Vec3::new(m.x_axis[k], m.y_axis[k], m.z_axis[k]).length() * radius;
        let half = Vec3::new(row(0), row(1), row(2));
        self.min = self.min.min(c - half);
        self.max = self.max.max(c + half);
    }

    fn leaf(&self, node: &Node, p: Vec3) -> f32 {
        match node {
            Node::Constant(x) => *x,
            Node::Ellipsoid(m) => bump(m.transform_point3(p).length_squared()),
            Node::Segment { a, b, radius, into } => {
                let q = into.transform_point3(p);
                let way = *b - *a;
                let t =
                    if way == Vec3::ZERO { 0.0 } else { ((q - *a).dot(way) / way.length_squared()).clamp(0.0, 1.0) };
                bump((q - (*a + way * t)).length_squared() / (radius * radius))
            }
            Node::Plane { point, normal, reach } => {
                let height = (p - *point).dot(*normal) / reach;
                if height < 0.0 { -1.0 } else { -bump(height * height) }
            }
            _ => 0.0,
        }
    }

    /// A point in the space of a leaf.
    fn in_leaf(&self, leaf: usize, p: Vec3) -> Vec3 {
        match &self.nodes[self.leaves[leaf]] {
            Node::Ellipsoid(into) | Node::Segment { into, .. } => into.transform_point3(p),
            _ => p,
        }
    }

    /// The field at a point; `values` is scratch.
    fn at(&self, p: Vec3, values: &mut Vec<f32>) -> f32 {
        values.clear();
        for node in &self.nodes {
            let parts = |list: &[usize]| list.iter().map(|i| values[*i]).collect::<Vec<f32>>();
            let x = match node {
                Node::Add(list) => parts(list).iter().sum(),
                Node::Multiply(list) => parts(list).iter().product(),
                Node::Max(list) => parts(list).into_iter().fold(f32::NEG_INFINITY, f32::max),
                Node::Min(list) => parts(list).into_iter().fold(f32::INFINITY, f32::min),
                Node::Subtract(a, b) => values[*a] - values[*b],
                Node::Divide(a, b) if values[*b] != 0.0 => values[*a] / values[*b],
                Node::Divide(..) => 0.0,
                Node::Negate(a) => -values[*a],
                leaf => self.leaf(leaf, p),
            };
            values.push(x);
        }
        *values.last().expect("a field has nodes")
    }

    /// The surface as patches; `varying` are the variables of the leaves, which blend as their fields do.
    pub fn patches(&self, varying: &[LeafVariable]) -> Vec<Patch> {
        let mut scratch = Vec::new();
        let lattice = Lattice::over(self);
        let [nx, ny, nz] = lattice.n;
        let mut value = vec![0.0; nx * ny * nz];
        for [i, j, k] in cells([0; 3], lattice.n) {
            value[lattice.index(i, j, k)] = self.at(lattice.place(i, j, k), &mut scratch) - LEVEL;
        }
        // A point in each cell that is crossed.
        let mut cell = vec![u32::MAX; nx * ny * nz];
        let (mut points, mut normals): (Vec<Vec3>, Vec<Vec3>) = (vec![], vec![]);
        for [i, j, k] in cells([0; 3], lattice.n.map(|n| n - 1)) {
            if let Some(p) = lattice.crossing([i, j, k], &value) {
                let (p, slope) = self.drawn_to_surface(p, lattice.size, &mut scratch);
                cell[lattice.index(i, j, k)] = points.len() as u32;
                points.push(p);
                normals.push(-slope.normalize_or_zero());
            }
        }
        let index = |i: usize, j: usize, k: usize| lattice.index(i, j, k);
        let mut patches = Vec::new();
        for [i, j, k] in cells([1; 3], lattice.n.map(|n| n - 1)) {
            let here = value[index(i, j, k)] > 0.0;
            // The four cells around each of the three edges that start here.
            for (there, around) in [
                (index(i + 1, j, k), [(i, j - 1, k - 1), (i, j, k - 1), (i, j - 1, k), (i, j, k)]),
                (index(i, j + 1, k), [(i - 1, j, k - 1), (i - 1, j, k), (i, j, k - 1), (i, j, k)]),
                (index(i, j, k + 1), [(i - 1, j - 1, k), (i, j - 1, k), (i - 1, j, k), (i, j, k)]),
            ] {
                if (value[there] > 0.0) == here {
                    continue;
                }
                let mut quad = around.map(|(i, j, k)| cell[index(i, j, k)] as usize);
                if quad.contains(&(u32::MAX as usize)) {
                    continue;
                }
                if !here {
                    quad.swap(1, 2);
                }
                patches.push(self.patch(quad, &points, &normals, varying));
            }
        }
        patches
    }

    /// The field's slope, by differences over a part of a cell.
    fn slope(&self, p: Vec3, size: f32, scratch: &mut Vec<f32>) -> Vec3 {
        let d = 0.2 * size;
        let mut along = |axis: Vec3| self.at(p + axis * d, scratch) - self.at(p - axis * d, scratch);
        Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)) / (2.0 * d)
    }

    /// A point moved along the field's slope to the surface, and the slope there.
    fn drawn_to_surface(&self, mut p: Vec3, size: f32, scratch: &mut Vec<f32>) -> (Vec3, Vec3) {
        for _ in 0..3 {
            let g = self.slope(p, size, scratch);
            if g.length_squared() > 1e-12 {
                let step = g * ((LEVEL - self.at(p, scratch)) / g.length_squared());
                p += step.clamp_length_max(0.5 * size);
            }
        }
        (p, self.slope(p, size, scratch))
    }

    /// A quadrilateral of the net, curved by its normals.
    fn patch(&self, quad: [usize; 4], points: &[Vec3], normals: &[Vec3], varying: &[LeafVariable]) -> Patch {
        let mut patch = Patch::bilinear(quad.map(|i| points[i]));
        patch.flat = false;
        let given = quad.iter().flat_map(|i| normals[*i].to_array()).collect();
        patch.normals = Some(Box::new(Varying::new(3, given)));
        for variable in varying {
            let width = variable.width();
            let mut corners = Vec::with_capacity(4 * width);
            for i in quad {
                let weights: Vec<f32> =
                    self.leaves.iter().map(|l| self.leaf(&self.nodes[*l], points[i]).max(0.0)).collect();
                let whole: f32 = weights.iter().sum();
                let own = |l: usize| variable.at(l, self.in_leaf(l, points[i]));
                let sum = (0..weights.len()).filter(|l| weights[*l] > 0.0).fold(vec![0.0; width], |mut sum, l| {
                    sum.iter_mut().zip(own(l)).for_each(|(sum, x)| *sum += weights[l] * x);
                    sum
                });
                corners.extend(if whole > 0.0 { sum.into_iter().map(|x| x / whole).collect() } else { own(0) });
            }
            patch.varying.push(Varying::new(width, corners));
        }
        patch
    }
}

/// The points over a field's bound at which it is evaluated.
struct Lattice {
    origin: Vec3,
    /// Side of a cell.
    size: f32,
    /// Points along each axis.
    n: [usize; 3],
}

impl Lattice {
    fn over(field: &Field) -> Lattice {
        let size = (field.max - field.min).max_element() / CELLS;
        let n = ((field.max - field.min) / size).ceil().as_uvec3() + 3;
        Lattice { origin: field.min - size, size, n: n.to_array().map(|n| n as usize) }
    }

    fn place(&self, i: usize, j: usize, k: usize) -> Vec3 {
        self.origin + Vec3::new(i as f32, j as f32, k as f32) * self.size
    }

    fn index(&self, i: usize, j: usize, k: usize) -> usize {
        (k * self.n[1] + j) * self.n[0] + i
    }

    /// The mean of where the surface crosses a cell's edges, if it does.
    fn crossing(&self, [i, j, k]: [usize; 3], value: &[f32]) -> Option<Vec3> {
        let corner = |c: usize| (i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
        let at = |c: usize| {
            let (i, j, k) = corner(c);
            value[self.index(i, j, k)]
        };
        let place = |c: usize| {
            let (i, j, k) = corner(c);
            self.place(i, j, k)
        };
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for a in 0..8usize {
            for b in [a | 1, a | 2, a | 4].into_iter().filter(|b| *b != a) {
                let (x, y) = (at(a), at(b));
                if (x > 0.0) != (y > 0.0) {
                    sum += place(a).lerp(place(b), x / (x - y));
                    count += 1.0;
                }
            }
        }
        (count > 0.0).then(|| sum / count)
    }
}

/// Indices from `lo` to before `hi` along each axis, the first axis fastest.
fn cells(lo: [usize; 3], hi: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let along = move |axis: usize| lo[axis]..hi[axis];
    along(2).flat_map(move |k| along(1).flat_map(move |j| along(0).map(move |i| [i, j, k])))
}
