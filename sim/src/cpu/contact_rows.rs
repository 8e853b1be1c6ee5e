//! The contact rows that `contact_write` fills, tile by tile.

use super::collide::collide_spheres;
use super::collide::point::Point;
use crate::sphere::Sphere;
use glam::DVec3;

/// The contact rows of a tile.
pub struct Rows<'a, A> {
    /// Ids of bodies A and B.
    pub bodies: &'a mut [[u32; 2]],
    /// Identity of each contact from step to step.
    pub key: &'a mut [[u32; 3]],
    /// Unit normal, out of A.
    pub normal: &'a mut [DVec3],
    /// Gap, m.
    pub gap: &'a mut [f64],
    /// Index of the contact law.
    pub law: &'a mut [u32],
    /// Arms.
    pub arms: &'a mut [A],
    /// Number of materials, by which the laws are indexed.
    pub n_materials: u32,
}

impl<A> Rows<'_, A> {
    /// Write row `i`: the contact of two shapes in a point. Of shapes that are no spheres, `p` and `q` have the body and the material
    /// alone. `arms_of` makes the arms from the bodies, the point, of which the first shape is now A's, and the radii.
    #[inline(always)]
    pub fn put(
        &mut self,
        i: usize,
        [p, q]: [Sphere; 2],
        key: [u32; 3],
        point: &Point,
        arms_of: impl Fn([u32; 2], &Point, [f64; 2]) -> A,
    ) {
        let is_swapped = p.body > q.body;
        let radii = if is_swapped { [q.radius, p.radius] } else { [p.radius, q.radius] };
        self.bodies[i] = if is_swapped { [q.body, p.body] } else { [p.body, q.body] };
        self.key[i] = key;
        let swapped = Point { normal: -point.normal, on_first: point.on_second, on_second: point.on_first, ..*point };
        let point = if is_swapped { &swapped } else { point };
        self.normal[i] = point.normal;
        self.gap[i] = point.gap;
        self.law[i] = p.material * self.n_materials + q.material;
        self.arms[i] = arms_of(self.bodies[i], point, radii);
    }

    /// Write row `i`: the contact of two spheres.
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

/// Lengths of the arms of spheres, m: the contact point is half the gap away from a sphere's surface.
pub fn along(_: [u32; 2], point: &Point, radii: [f64; 2]) -> [f64; 2] {
    radii.map(|r| r + 0.5 * point.gap)
}
