//! N as a sparse matrix of 3×3 blocks, as in files of friction problems: `u = Wγ + q` with blocks (normal, tangent, tangent).
//!
//! W need not be symmetric: the mass matrix of an implicit step has the derivatives of gyroscopic torques, which are not.

use crate::cpu::solve::cells::Cells;
use crate::cpu::solve::cone::project_cone;
use crate::cpu::solve::operator::Operator;
use crate::cpu::solve::response::Response;
use crate::cpu::solve::schedule::Colored;
use crate::rows::{fill_rows, sum_rows};
use crate::twist::Twist;
use glam::{DMat3, DVec3};

/// The operator of a friction problem, with W in compressed rows of 3×3 blocks.
#[derive(Clone, Debug)]
pub struct MatrixOperator {
    /// First block of each row of blocks, and the end: row i has the blocks `start[i]..start[i+1]` (n_contacts + 1).
    pub start: Vec<u32>,
    /// Block column of each block (n_blocks).
    pub column: Vec<u32>,
    /// The 3×3 blocks of W (n_blocks).
    pub block: Vec<DMat3>,
    /// Contact velocities q without multipliers (n_contacts).
    pub q: Vec<DVec3>,
    /// Coefficients of friction μ (n_contacts).
    pub friction: Vec<f64>,
    /// First place in `in_column` of each column of blocks, and the end (n_contacts + 1).
    column_start: Vec<u32>,
    /// The blocks column by column: block row, and index of the block (n_blocks).
    in_column: Vec<[u32; 2]>,
    /// Slip feedback μ|u_t| of exact friction (n_contacts).
    slip_feedback: Vec<f64>,
    /// W_ii and η (n_contacts).
    own: Vec<DMat3>,
    eta: Vec<f64>,
}

impl MatrixOperator {
    /// An operator from blocks row by row, as in the fields of the same names; the columns of a row ascend.
    pub fn new(start: Vec<u32>, column: Vec<u32>, block: Vec<DMat3>, q: Vec<DVec3>, friction: Vec<f64>) -> Self {
        let n = q.len();
        let row = |i: usize| start[i] as usize..start[i + 1] as usize;
        let own: Vec<DMat3> =
            (0..n).map(|i| row(i).find(|p| column[*p] as usize == i).map_or(DMat3::ZERO, |p| block[p])).collect();
        let trace = |m: &DMat3| m.x_axis.x + m.y_axis.y + m.z_axis.z;
        let eta = own.iter().map(|m| if trace(m) > 0.0 { 3.0 / trace(m) } else { 1.0 }).collect();
        let (column_start, in_column) = columns(&start, &column);
        let slip_feedback = vec![0.0; n];
        MatrixOperator { column_start, in_column, slip_feedback, own, eta, start, column, block, q, friction }
    }

    #[inline]
    fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.start[i] as usize..self.start[i + 1] as usize
    }

    /// The blocks of row `i` of W, with their columns.
    pub fn blocks(&self, i: usize) -> impl Iterator<Item = (usize, DMat3)> {
        self.row(i).map(|p| (self.column[p] as usize, self.block[p]))
    }

    /// Block `i` of u = Wγ + q.
    pub fn velocity(&self, gamma: &[DVec3], i: usize) -> DVec3 {
        self.row(i).map(|p| self.block[p] * gamma[self.column[p] as usize]).sum::<DVec3>() + self.q[i]
    }

    /// ‖q‖.
    pub fn scale(&self) -> f64 {
        self.q.iter().map(|q| q.length_squared()).sum::<f64>().sqrt()
    }

    /// The error measure `‖F_nat‖/‖q‖`, F_nat = γ − Π(γ − (u + g)), with the projection Π onto the friction cones, and g = (μ|u_t|, 0, 0)
    /// if `exact`, else 0.
    pub fn error(&self, gamma: &[DVec3], exact: bool) -> f64 {
        let [residual, scale] = sum_rows(self.q.len(), |i| {
            let mut u = self.velocity(gamma, i);
            if exact {
                u.x += self.friction[i] * (u.y * u.y + u.z * u.z).sqrt();
            }
            let natural = gamma[i] - project_cone(gamma[i] - u, DVec3::X, self.friction[i]);
            [natural.length_squared(), self.q[i].length_squared()]
        });
        (residual / scale.max(f64::MIN_POSITIVE)).sqrt()
    }
}

/// The blocks column by column, from those row by row: first places of the columns, and block rows with indices of blocks.
fn columns(start: &[u32], column: &[u32]) -> (Vec<u32>, Vec<[u32; 2]>) {
    let mut first = vec![0; start.len()];
    column.iter().for_each(|j| first[*j as usize + 1] += 1);
    for j in 1..first.len() {
        first[j] += first[j - 1];
    }
    let (mut next, mut blocks) = (first.clone(), vec![[0; 2]; column.len()]);
    for (i, row) in start.windows(2).enumerate() {
        for p in row[0]..row[1] {
            let place = &mut next[column[p as usize] as usize];
            blocks[*place as usize] = [i as u32, p];
            *place += 1;
        }
    }
    (first, blocks)
}

/// The response of γ has u in `v` and γ itself in `w`, so that a combination of responses has both.
impl Operator for MatrixOperator {
    fn n_blocks(&self) -> usize {
        self.q.len()
    }

    fn response(&mut self, gamma: &[DVec3], out: &mut Response) {
        out.twist.resize(gamma.len(), Twist::default());
        let this = &*self;
        fill_rows(&mut out.twist, |i| Twist { v: this.velocity(gamma, i), w: gamma[i] });
    }

    #[inline]
    fn gradient(&self, response: &Response, i: usize) -> DVec3 {
        response.twist[i].v + DVec3::new(self.slip_feedback[i], 0.0, 0.0)
    }

    fn curvature(&self, a: &Response, b: &Response) -> f64 {
        sum_rows(self.q.len(), |i| [(a.twist[i].w - b.twist[i].w).dot(a.twist[i].v - b.twist[i].v)])[0]
    }

    fn energy(&self, response: &Response) -> f64 {
        sum_rows(self.q.len(), |i| [response.twist[i].w.dot(response.twist[i].v).abs()])[0]
    }

    #[inline]
    fn project(&self, i: usize, y: DVec3, _: &[DVec3]) -> DVec3 {
        project_cone(y, DVec3::X, self.friction[i])
    }

    unsafe fn project_in(&self, i: usize, y: DVec3, _: &Cells<DVec3>) -> DVec3 {
        project_cone(y, DVec3::X, self.friction[i])
    }

    #[inline]
    fn eta(&self, i: usize) -> f64 {
        self.eta[i]
    }

    fn diagonal(&self, i: usize) -> DMat3 {
        self.own[i]
    }

    unsafe fn apply(&self, cells: &Cells<Twist>, i: usize, d: DVec3) {
        for [j, p] in &self.in_column[self.column_start[i] as usize..self.column_start[i + 1] as usize] {
            let (j, p) = (*j as usize, *p as usize);
            // SAFETY: the caller's promise; one block at a time is visited.
            let t = unsafe { cells.get(j) };
            unsafe { cells.set(j, Twist { v: t.v + self.block[p] * d, w: if i == j { t.w + d } else { t.w } }) };
        }
    }

    unsafe fn gradient_in(&self, cells: &Cells<Twist>, i: usize) -> DVec3 {
        // SAFETY: the caller's promise.
        unsafe { cells.get(i).v + DVec3::new(self.slip_feedback[i], 0.0, 0.0) }
    }

    fn solve_joints(&mut self, _: &mut Response) {}

    fn colors(&self, colored: &mut Colored) {
        // An impulse changes a whole column.
        colored.one_by_one(self.q.len() as u32);
    }

    fn friction(&self, i: usize) -> (f64, DVec3) {
        (self.friction[i], DVec3::X)
    }

    fn set_slip_feedback(&mut self, slip: &[f64]) {
        self.slip_feedback.copy_from_slice(slip);
    }
}

#[cfg(test)]
mod tests {
    use super::MatrixOperator;
    use crate::cpu::solve::cells::Cells;
    use crate::cpu::solve::operator::Operator;
    use crate::cpu::solve::response::Response;
    use crate::fill::SplitMix64;
    use glam::{DMat3, DVec3};

    #[test]
    fn an_impulse_changes_a_column_of_an_unsymmetric_matrix() {
        let mut random = SplitMix64(0);
        let mut number = || random.between(-1.0, 1.0);
        let mut vector = || DVec3::new(number(), number(), number());
        // Block (0, 2) has no counterpart.
        let (start, column) = (vec![0, 3, 5, 6], vec![0, 1, 2, 0, 1, 2]);
        let block = column.iter().map(|_| DMat3::from_cols(vector(), vector(), vector())).collect();
        let (q, gamma): (Vec<DVec3>, Vec<DVec3>) = (0..3).map(|_| (vector(), vector())).unzip();
        let mut op = MatrixOperator::new(start, column, block, q, vec![0.5; 3]);
        let (mut applied, mut evaluated) = (Response::default(), Response::default());
        op.response(&[DVec3::ZERO; 3], &mut applied);
        op.response(&gamma, &mut evaluated);
        let cells = Cells::new(&mut applied.twist);
        // SAFETY: one thread has the cells.
        (0..3).for_each(|i| unsafe { op.apply(&cells, i, gamma[i]) });
        for (a, b) in applied.twist.iter().zip(&evaluated.twist) {
            assert!((a.v - b.v).length() < 1e-14 && a.w == b.w, "{a:?}, expected {b:?}");
        }
    }
}
