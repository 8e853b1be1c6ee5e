//! [`Operator`] of the contacts between bodies.

use super::bodies::{Block, BodyOperator, Free, Offset};
use super::cells::Cells;
use super::descend;
use super::operator::{self, Operator};
use super::response::{Extrapolated, Response};
use super::schedule::Colored;
use crate::rows::{add, reduce_chunks, reduce_chunks_of_two, sum_rows};
use crate::twist::Twist;
use glam::{DMat3, DVec3};

impl Operator for BodyOperator<'_> {
    fn n_blocks(&self) -> usize {
        self.contacts.len() * if self.plan.rolls { 2 } else { 1 }
    }

    fn response(&mut self, gamma: &[DVec3], out: &mut Response) {
        self.clear_sums(&mut out.twist);
        self.add_blocks(0, gamma, &Cells::new(&mut out.twist));
        self.finish(out);
    }

    #[inline]
    fn gradient(&self, response: &Response, i: usize) -> DVec3 {
        self.relative(i, |b| response.twist[b])
    }

    fn curvature(&self, a: &Response, b: &Response) -> f64 {
        let energy = |i: usize| [self.masses.energy::<false>(i, &a.twist[i].minus(&b.twist[i]))];
        sum_rows(self.masses.inv_mass.len(), energy)[0] + self.joints.compliance(&a.lambda, &b.lambda)
    }

    fn energy(&self, response: &Response) -> f64 {
        let [energy] = sum_rows(self.masses.inv_mass.len(), |b| [self.masses.energy::<false>(b, &response.twist[b])]);
        energy + self.joints.compliance(&response.lambda, &vec![0.0; response.lambda.len()])
    }

    fn descend(&self, next: &mut [DVec3], from: &Extrapolated, step: f64, to: &mut Response) -> [f64; 2] {
        if self.plan.coheres {
            return reduce_chunks(next, |first, rows| operator::any(self, first, rows, from, step));
        }
        self.clear_sums(&mut to.twist);
        let sums = Cells::new(&mut to.twist);
        let n = self.contacts.len();
        let (own, others) = next.split_at_mut(n);
        let done = descend::contacts(self, own, from, step, &sums);
        let rest = reduce_chunks(others, |first, rows| operator::any(self, n + first, rows, from, step));
        self.add_blocks(n, next, &sums);
        add(done, rest)
    }

    fn advance(&mut self, next: &[DVec3], beta: f64, [x, y]: [&Response; 2], [to, to_y]: [&mut Response; 2]) -> f64 {
        if self.plan.coheres {
            return operator::advance(self, next, beta, [x, y], [to, to_y]);
        }
        if !self.joints.rows.is_empty() {
            self.finish(to);
            to_y.extrapolate(to, x, beta);
            return self.curvature(to, y);
        }
        // Without joints one pass over the bodies does all of it.
        if self.masses.are_isotropic() {
            return self.advance_bodies::<true>(beta, [x, y], [to, to_y]);
        }
        self.advance_bodies::<false>(beta, [x, y], [to, to_y])
    }

    #[inline]
    fn project(&self, i: usize, y: DVec3, gamma: &[DVec3]) -> DVec3 {
        self.project_with(i, y, |i| gamma[i])
    }

    unsafe fn project_in(&self, i: usize, y: DVec3, gamma: &Cells<DVec3>) -> DVec3 {
        // SAFETY: the caller's promise.
        self.project_with(i, y, |i| unsafe { gamma.get(i) })
    }

    #[inline]
    fn eta(&self, i: usize) -> f64 {
        self.eta[i]
    }

    /// The radius of gyration √(η_roll/η_contact) of a rolling block.
    #[inline]
    fn lever(&self, i: usize) -> f64 {
        match self.block(i) {
            Block::Roll(contact) => (self.eta[i] / self.eta[contact]).sqrt(),
            _ => 1.0,
        }
    }

    fn diagonal(&self, i: usize) -> DMat3 {
        let masses = self.masses;
        match self.block(i) {
            Block::Contact(i) => {
                let [a, b] = self.contacts.bodies[i].map(|b| b as usize);
                let [arm_a, arm_b] = self.contacts.arms(i);
                let cross =
                    |arm: DVec3| DMat3::from_cols(arm.cross(DVec3::X), arm.cross(DVec3::Y), arm.cross(DVec3::Z));
                let rotational = |b: usize, arm: DVec3| {
                    let c = cross(arm);
                    c.transpose() * masses.inv_inertia(b) * c
                };
                DMat3::from_diagonal(DVec3::splat(masses.inv_mass[a] + masses.inv_mass[b]))
                    + rotational(a, arm_a)
                    + rotational(b, arm_b)
            }
            Block::Roll(i) => {
                let [a, b] = self.contacts.bodies[i].map(|b| b as usize);
                masses.inv_inertia(a) + masses.inv_inertia(b)
            }
        }
    }

    unsafe fn apply(&self, cells: &Cells<Twist>, i: usize, d: DVec3) {
        let masses = self.masses;
        self.split(i, d, |body, linear, angular| {
            let b = body as usize;
            if masses.inv_mass[b] > 0.0 {
                // SAFETY: the caller's promise.
                unsafe {
                    let t = cells.get(b);
                    cells.set(
                        b,
                        Twist { v: t.v + linear * masses.inv_mass[b], w: t.w + masses.apply_inv_inertia(b, angular) },
                    );
                }
            }
        });
    }

    unsafe fn gradient_in(&self, cells: &Cells<Twist>, i: usize) -> DVec3 {
        // SAFETY: the caller's promise.
        self.relative(i, |b| unsafe { cells.get(b) })
    }

    fn solve_joints(&mut self, response: &mut Response) {
        self.joints.solve(self.masses, response);
    }

    fn colors(&self, colored: &mut Colored) {
        let moving = |body: u32| (self.masses.inv_mass[body as usize] > 0.0).then_some(body);
        let bodies = |i: u32| match self.block(i as usize) {
            Block::Contact(i) | Block::Roll(i) => self.contacts.bodies[i].map(moving),
        };
        let mut taken = vec![0; self.masses.inv_mass.len()];
        // SAFETY: no other thread is at work.
        unsafe { colored.fill(0..self.n_blocks() as u32, bodies, |_| 1, &Cells::new(&mut taken)) };
    }

    fn has_homogeneous_cones(&self) -> bool {
        !self.plan.coheres
    }

    fn has_independent_cones(&self) -> bool {
        !self.plan.rolls
    }

    fn friction(&self, i: usize) -> (f64, DVec3) {
        match self.block(i) {
            Block::Contact(i) => (self.law(i).friction, self.contacts.normal[i]),
            _ => (0.0, DVec3::ZERO),
        }
    }

    fn last_slip(&self) -> Option<Vec<f64>> {
        let mut slip = self.last_slip.to_vec();
        slip.resize(self.n_blocks(), 0.0);
        Some(slip)
    }

    fn least_slip(&self, i: usize) -> f64 {
        self.least_slip * self.friction(i).0
    }

    fn set_slip_feedback(&mut self, slip: &[f64]) {
        let Offset::Column(offset) = &mut self.offset else { unreachable!("exact friction has a column of offsets") };
        for i in 0..self.contacts.len() {
            offset[i] = self.offset_without_slip[i] + slip[i];
        }
    }
}

impl BodyOperator<'_> {
    /// [`Operator::advance`] over the bodies, without joints.
    fn advance_bodies<const ISOTROPIC: bool>(
        &self,
        beta: f64,
        [x, y]: [&Response; 2],
        [to, to_y]: [&mut Response; 2],
    ) -> f64 {
        let Free::Column(free) = self.free else { unreachable!("descent methods have a column of free velocities") };
        to_y.twist.resize(to.twist.len(), Twist::default());
        let [curvature] = reduce_chunks_of_two(&mut to.twist, &mut to_y.twist, |first, to, to_y| {
            let mut sum = 0.0;
            for (k, (to, to_y)) in to.iter_mut().zip(to_y).enumerate() {
                let b = first + k;
                let (x, y) = (&x.twist[b], &y.twist[b]);
                let new = free[b].plus(&self.masses.change::<ISOTROPIC>(b, to));
                *to = new;
                *to_y = new.beyond(x, beta);
                sum += self.masses.energy::<ISOTROPIC>(b, &new.minus(y));
            }
            [sum]
        });
        curvature
    }
}
