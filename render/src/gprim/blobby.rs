//! Blobbies (PRMan's application note 31): a field made of leaves and operators, and the surface where it is 0.421875.
//!
//! `surface` finds the surface, `motion` where it goes as the numbers of the field change.

pub mod motion;
pub mod surface;

use glam::{Mat4, Vec3};
use ri::Fail;

/// The field's value on the surface.
const LEVEL: f32 = 0.421_875;

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
}
