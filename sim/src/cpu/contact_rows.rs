//! The rows that `contact_write` fills, piece by piece.

use super::bounds::Ball;
use super::collide::{Point, collide_balls};
use glam::DVec3;

/// The rows of a piece's contacts.
pub struct Rows<'a, A> {
    /// Bodies A and B.
    pub bodies: &'a mut [[u32; 2]],
    /// What each is known by.
    pub key: &'a mut [[u32; 3]],
    /// Unit normal, out of A.
    pub normal: &'a mut [DVec3],
    /// Gap, m.
    pub gap: &'a mut [f64],
    /// The law that holds.
    pub law: &'a mut [u32],
    /// The arms.
    pub arms: &'a mut [A],
    /// Materials that the model has, by which laws are numbered.
    pub n_materials: u32,
}

impl<A> Rows<'_, A> {
    /// Write row `i`: two shapes, as far as balls go, touch in a point. `arms_of` makes the arms of two bodies that touch in a
    /// point, of which those that are balls have the radii given.
    #[inline(always)]
    pub fn put(
        &mut self,
        i: usize,
        [p, q]: [Ball; 2],
        key: [u32; 3],
        point: &Point,
        arms_of: impl Fn([u32; 2], &Point, [f64; 2]) -> A,
    ) {
        let turned = p.body > q.body;
        let radii = if turned { [q.radius, p.radius] } else { [p.radius, q.radius] };
        self.bodies[i] = if turned { [q.body, p.body] } else { [p.body, q.body] };
        self.key[i] = key;
        self.normal[i] = if turned { -point.normal } else { point.normal };
        self.gap[i] = point.gap;
        self.law[i] = p.material * self.n_materials + q.material;
        self.arms[i] = arms_of(self.bodies[i], point, radii);
    }

    /// Write row `i`: the balls of two shapes touch.
    #[inline(always)]
    pub fn put_balls(
        &mut self,
        i: usize,
        pair: [u32; 2],
        [p, q]: [Ball; 2],
        arms_of: impl Fn([u32; 2], &Point, [f64; 2]) -> A,
    ) {
        let point = collide_balls((p.centre, p.radius), (q.centre, q.radius));
        self.put(i, [p, q], [pair[0], pair[1], point.feature], &point, arms_of);
    }
}

/// The lengths of the arms of balls: the contact point is half the gap away from a ball's surface.
pub fn along(_: [u32; 2], point: &Point, radii: [f64; 2]) -> [f64; 2] {
    radii.map(|r| r + 0.5 * point.gap)
}
