//! The rows that `contact_write` fills, tile by tile.

use super::collide::collide_spheres;
use super::collide::point::Point;
use crate::sphere::Sphere;
use glam::DVec3;

/// The rows of a tile's contacts.
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
    /// Write row `i`: two shapes, as far as spheres go, touch in a point. `arms_of` makes the arms of two bodies that touch in a
    /// point, of which those that are spheres have the radii given.
    #[inline(always)]
    pub fn put(
        &mut self,
        i: usize,
        [p, q]: [Sphere; 2],
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

    /// Write row `i`: the spheres of two shapes touch.
    #[inline(always)]
    pub fn put_spheres(
        &mut self,
        i: usize,
        pair: [u32; 2],
        [p, q]: [Sphere; 2],
        arms_of: impl Fn([u32; 2], &Point, [f64; 2]) -> A,
    ) {
        let point = collide_spheres((p.centre, p.radius), (q.centre, q.radius));
        self.put(i, [p, q], [pair[0], pair[1], point.feature], &point, arms_of);
    }
}

/// The lengths of the arms of spheres: the contact point is half the gap away from a sphere's surface.
pub fn along(_: [u32; 2], point: &Point, radii: [f64; 2]) -> [f64; 2] {
    radii.map(|r| r + 0.5 * point.gap)
}
