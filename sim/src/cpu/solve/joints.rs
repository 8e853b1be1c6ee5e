//! Elimination of the joints: impulses f change the velocities by `M⁻¹f`, and the joints are solved for the multipliers λ that
//! satisfy `Bᵀv + Ψ/h + ∂Ψ/∂t + Cλ = 0`, by a sparse factorisation of `S = BᵀM⁻¹B + C`.
//!
//! The projected iteration over contacts then works with `M̃⁻¹ = M⁻¹ − M⁻¹B S⁻¹ BᵀM⁻¹` in place of M⁻¹: a chain of stiff joints
//! with light links and a heavy load costs it no iterations. (The paper iterates over joints and contacts alike, and names
//! the slow convergence as its open problem, §6.)
//!
//! C has the compliance of springs, and for rigid rows a small fraction of the diagonal, which regularises redundant rows.

use super::ldl::Ldl;
use super::response::Response;
use crate::cpu::masses::Masses;
use crate::joint::Row;
use crate::twist::Twist;

/// Compliance of a rigid row, relative to its diagonal. It distributes the load over redundant rows (two pins of a hinge, a closed ring
/// of hinges); a chain that carries a thousand times its links' weight gives way by some 10⁻⁸ m.
const REGULARIZATION: f64 = 1e-6;

/// The rows of a step and their factorisation.
#[derive(Default)]
pub struct Joints {
    /// The rows.
    pub rows: Vec<Row>,
    /// `Ψ/h + ∂Ψ/∂t` and the terms of springs, m/s or rad/s (n_rows).
    pub bias: Vec<f64>,
    /// Bodies of the rows when the sparsity pattern was analysed (n_rows).
    pattern: Vec<[u32; 2]>,
    /// Rows of each moving body.
    of_body: Vec<(u32, Vec<u32>)>,
    /// Whether a body has rows (n_bodies).
    is_held: Vec<bool>,
    /// Slots of the pairs (k, l ≥ k) of each body's rows, in order.
    slot: Vec<u32>,
    ldl: Ldl,
    rhs: Vec<f64>,
    softness: Vec<f64>,
}

/// A row's Jacobian on one of its bodies.
fn on_body(row: &Row, body: u32) -> Twist {
    if row.bodies[1] == body {
        Twist { v: row.linear, w: row.angular_b }
    } else {
        Twist { v: -row.linear, w: -row.angular_a }
    }
}

impl Joints {
    /// Factorise S for the rows of a step.
    pub fn prepare(&mut self, masses: &Masses) {
        let n = self.rows.len();
        if n == 0 {
            return;
        }
        if self.pattern.len() != n || self.rows.iter().zip(&self.pattern).any(|(r, p)| r.bodies != *p) {
            self.analyse(masses);
        }
        self.ldl.clear();
        let mut slot = self.slot.iter();
        let mut next = || *slot.next().expect("as many slots as pairs");
        self.softness.clear();
        self.softness.extend(self.rows.iter().map(|r| r.softness));
        let mut diagonal = vec![0.0; n];
        for (body, rows) in &self.of_body {
            for (i, &k) in rows.iter().enumerate() {
                let own = on_body(&self.rows[k as usize], *body);
                let b = *body as usize;
                let m = Twist { v: own.v * masses.inv_mass[b], w: masses.apply_inv_inertia(b, own.w) };
                for &l in &rows[i..] {
                    let other = on_body(&self.rows[l as usize], *body);
                    let value = other.v.dot(m.v) + other.w.dot(m.w);
                    self.ldl.add(next(), value);
                    if k == l {
                        diagonal[k as usize] += value;
                    }
                }
            }
        }
        for k in 0..n {
            let min = REGULARIZATION * diagonal[k].max(f64::MIN_POSITIVE);
            self.softness[k] = self.softness[k].max(min);
            self.ldl.add(next(), self.softness[k]);
        }
        let largest = diagonal.iter().fold(0f64, |m, d| m.max(*d)).max(f64::MIN_POSITIVE);
        self.ldl.factorise(1e-14 * largest);
    }

    fn analyse(&mut self, masses: &Masses) {
        let n = self.rows.len();
        self.pattern = self.rows.iter().map(|r| r.bodies).collect();
        let mut of_body: std::collections::BTreeMap<u32, Vec<u32>> = Default::default();
        for (k, row) in self.rows.iter().enumerate() {
            for body in row.bodies {
                if masses.inv_mass[body as usize] > 0.0 {
                    of_body.entry(body).or_default().push(k as u32);
                }
            }
        }
        self.of_body = of_body.into_iter().collect();
        self.is_held.clear();
        self.is_held.resize(masses.inv_mass.len(), false);
        self.of_body.iter().for_each(|(body, _)| self.is_held[*body as usize] = true);
        let mut entry_of: std::collections::HashMap<[u32; 2], u32> = Default::default();
        let mut entries: Vec<[u32; 2]> = vec![];
        let mut all: Vec<u32> = vec![];
        let mut take = |pair: [u32; 2]| {
            let next = entries.len() as u32;
            all.push(*entry_of.entry(pair).or_insert_with(|| {
                entries.push(pair);
                next
            }));
        };
        for (_, rows) in &self.of_body {
            for (i, &k) in rows.iter().enumerate() {
                rows[i..].iter().for_each(|&l| take([k, l]));
            }
        }
        (0..n as u32).for_each(|k| take([k, k]));
        // Rows between the same two bodies are eliminated together.
        let mut groups: std::collections::BTreeMap<[u32; 2], u32> = Default::default();
        let group: Vec<u32> = self
            .rows
            .iter()
            .map(|r| {
                let next = groups.len() as u32;
                *groups.entry(r.bodies).or_insert(next)
            })
            .collect();
        let (ldl, slots) = Ldl::analyse(n, &entries, &group);
        self.ldl = ldl;
        self.slot = all.iter().map(|e| slots[*e as usize]).collect();
    }

    /// Whether a joint acts on a moving body.
    #[inline]
    pub fn hold(&self, body: u32) -> bool {
        !self.rows.is_empty() && self.is_held[body as usize]
    }

    /// Discard the sparsity pattern: other bodies move.
    pub fn invalidate(&mut self) {
        self.pattern.clear();
    }

    /// Reset the multipliers of a response to zero, for velocities without joints.
    pub fn reset(&self, response: &mut Response) {
        response.lambda.clear();
        response.lambda.resize(self.rows.len(), 0.0);
    }

    /// Solve the joints: update the multipliers λ and the velocities of a response whose velocities include the effect of its λ.
    pub fn solve(&mut self, masses: &Masses, response: &mut Response) {
        self.solve_with(masses, response, 1.0);
    }

    /// [`Joints::solve`] for rows that are where they shall be and stay there.
    pub fn solve_at_rest(&mut self, masses: &Masses, response: &mut Response) {
        self.solve_with(masses, response, 0.0);
    }

    fn solve_with(&mut self, masses: &Masses, response: &mut Response, bias: f64) {
        if self.rows.is_empty() {
            return;
        }
        self.rhs.clear();
        for (k, row) in self.rows.iter().enumerate() {
            let speed = row.speed_in(&response.twist);
            self.rhs.push(-(speed + bias * self.bias[k] + self.softness[k] * response.lambda[k]));
        }
        self.ldl.solve(&mut self.rhs);
        response.lambda.iter_mut().zip(&self.rhs).for_each(|(l, more)| *l += more);
        for (row, lambda) in self.rows.iter().zip(&self.rhs) {
            masses.apply_row_impulse(&mut response.twist, row, *lambda);
        }
    }

    /// λᵀCλ of a difference of multipliers.
    pub fn compliance(&self, a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).zip(&self.softness).map(|((p, q), c)| c * (p - q) * (p - q)).sum()
    }
}
