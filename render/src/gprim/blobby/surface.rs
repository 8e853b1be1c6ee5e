//! The surface of a blobby, by surface nets on a grid (Gibson 1998): a point in every cell that it crosses, and a quadrilateral across
//! every grid edge that it crosses; the points are then drawn to the surface along the field's slope, which gives the normals too.

use crate::gprim::blobby::{Field, LEVEL, LeafVariable};
use crate::scene::patch::Patch;
use crate::scene::variables::Varying;
use glam::Vec3;

/// Cells along the longest side of the bound.
const CELLS: f32 = 72.0;

/// A surface as points and quadrilaterals between them.
pub struct Net {
    pub points: Vec<Vec3>,
    normals: Vec<Vec3>,
    pub quads: Vec<[usize; 4]>,
    /// Side of a cell that it was found by.
    pub size: f32,
}

impl Field {
    /// The surface as a net.
    pub fn net(&self) -> Net {
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
                let (p, slope) = self.drawn_to_surface(p, lattice.size, 3, &mut scratch);
                cell[lattice.index(i, j, k)] = points.len() as u32;
                points.push(p);
                normals.push(-slope.normalize_or_zero());
            }
        }
        let index = |i: usize, j: usize, k: usize| lattice.index(i, j, k);
        let mut quads = Vec::new();
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
                quads.push(quad);
            }
        }
        Net { points, normals, quads, size: lattice.size }
    }

    /// The patches of the surface's net; `varying` are the variables of the leaves, which blend as their fields do.
    pub fn patches(&self, net: &Net, varying: &[LeafVariable]) -> Vec<Patch> {
        net.quads.iter().map(|quad| self.patch(*quad, &net.points, &net.normals, varying)).collect()
    }

    /// The field's slope, by differences over a part of a cell.
    fn slope(&self, p: Vec3, size: f32, scratch: &mut Vec<f32>) -> Vec3 {
        let d = 0.2 * size;
        let mut along = |axis: Vec3| self.at(p + axis * d, scratch) - self.at(p - axis * d, scratch);
        Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)) / (2.0 * d)
    }

    /// A point moved along the field's slope to the surface, in `steps` steps, and the slope there.
    pub(super) fn drawn_to_surface(
        &self,
        mut p: Vec3,
        size: f32,
        steps: usize,
        scratch: &mut Vec<f32>,
    ) -> (Vec3, Vec3) {
        for _ in 0..steps {
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
