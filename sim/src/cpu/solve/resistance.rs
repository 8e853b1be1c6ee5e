//! What contacts that roll with friction, or stick, have besides: adhesion, and a block of angular impulse.
//!
//! The block's width is that of the normal impulse and the adhesion: a disc across the normal, and a range along it
//! ([`BodyOperator::project_with`]). It is visited after its contact.

use super::bodies::BodyOperator;
use super::operator::Operator;
use crate::lanes::{Lane3, Lanes, Real};
use glam::DVec3;

/// The columns of contacts side by side in lanes.
#[derive(Clone, Copy)]
pub struct Resistance<T, const L: usize> {
    /// Adhesion, N s.
    adhesion: [T; L],
    /// Coefficients of rolling and of spinning friction, m.
    rolling: [T; L],
    spinning: [T; L],
    /// The angular impulse on B, N m s.
    pub impulse: [[T; L]; 3],
    /// A bound of the response to it, 1/(kg m²), and its reciprocal; zero in a lane without a contact.
    response: [T; L],
    inverse: [T; L],
}

impl<T: Real, const L: usize> Resistance<T, L> {
    /// Columns without contacts.
    pub fn empty() -> Self {
        let zero = [T::default(); L];
        Resistance { adhesion: zero, rolling: zero, spinning: zero, impulse: [zero; 3], response: zero, inverse: zero }
    }

    /// Put contact `i` into a lane, with the impulses γ, of which the angular one is projected.
    pub fn put(&mut self, l: usize, op: &BodyOperator, i: usize, gamma: &[DVec3]) {
        let law = op.law(i);
        self.adhesion[l] = T::of(op.adhesion(i));
        if op.plan.rolls {
            let roll = op.contacts.len() + i;
            let impulse = op.project(roll, gamma[roll], gamma);
            (self.rolling[l], self.spinning[l]) = (T::of(law.rolling), T::of(law.spinning));
            (0..3).for_each(|k| self.impulse[k][l] = T::of(impulse[k]));
        }
    }

    /// Set the bound of the response.
    #[inline(always)]
    pub fn prepare<V: Lanes<T, L>>(&mut self, response: V) {
        let (zero, one) = (V::splat(T::of(0.0)), V::splat(T::of(1.0)));
        self.response = response.to_array();
        self.inverse = response.select_le(zero, zero, one / response).to_array();
    }

    /// Adhesion, N s.
    #[inline(always)]
    pub fn tip<V: Lanes<T, L>>(&self) -> V {
        V::load(&self.adhesion)
    }

    /// The angular impulse.
    #[inline(always)]
    pub fn roll<V: Lanes<T, L>>(&self) -> Lane3<V> {
        let [x, y, z] = &self.impulse;
        Lane3 { x: V::load(x), y: V::load(y), z: V::load(z) }
    }

    /// Visit the block of contacts with the impulse `gamma`, whose bodies turn against each other at `w`. Returns the change of the angular
    /// impulse, and what it adds to the sum of the squared residual terms, where `inv_eta` is that of the contacts.
    #[inline(always)]
    pub fn visit<V: Lanes<T, L>>(
        &mut self,
        w: Lane3<V>,
        (n, gamma): (Lane3<V>, Lane3<V>),
        (omega, inv_eta): (V, V),
    ) -> (Lane3<V>, V) {
        let (zero, one) = (V::splat(T::of(0.0)), V::splat(T::of(1.0)));
        let normal = gamma.dot(n) + self.tip();
        let normal = zero.select_le(normal, normal, zero);
        let before = self.roll();
        let z = before.minus(w.times(V::load(&self.inverse)));
        let spin = z.dot(n);
        let across = z.minus(n.times(spin));
        let (most, widest) = (V::load(&self.rolling) * normal, V::load(&self.spinning) * normal);
        let length = across.dot(across).sqrt();
        let least = zero - widest;
        let spin = spin.select_le(widest, spin, widest);
        let spin = least.select_le(spin, spin, least);
        let z = n.times(spin).plus(across.times(length.select_le(most, one, most / length)));
        let d = z.minus(before).times(omega);
        let after = before.plus(d);
        self.impulse = [after.x.to_array(), after.y.to_array(), after.z.to_array()];
        (d, d.dot(d) * V::load(&self.response) * inv_eta)
    }
}
