//! A grid on the raster: where its points fall at each moment of its item, and which of its micropolygons are sampled.

use crate::cpu::coplanar::Behind;
use crate::gprim::grid::Grid;
use crate::scene::camera::{Camera, RasterBound};
use crate::scene::motion::Instant;
use crate::scene::source::ItemView;
use glam::{Vec2, Vec3};
use sl::Global;
use sl::machine::Points;

/// A projected grid.
#[derive(Default)]
pub struct Raster {
    /// Raster x and y, pixels, and depth of each point, at each moment of the item.
    pub at: Vec<Vec<[f32; 3]>>,
    /// Micropolygons that are sampled, by their first points.
    pub micropolygons: Vec<u32>,
}

impl Raster {
    /// How far each point moves on the raster while the shutter is open, pixels to the right and down.
    pub fn motion(&self) -> impl Iterator<Item = [f32; 2]> + '_ {
        let (first, last) = (self.at.first(), self.at.last());
        let both = first.into_iter().flatten().zip(last.into_iter().flatten());
        both.map(|(a, b)| if b[2] > f32::NEG_INFINITY { [b[0] - a[0], b[1] - a[1]] } else { [0.0; 2] })
    }

    /// Project the points of a grid at all moments of its item, which may lie behind others in its plane; the bound on the raster, blur
    /// included, and the least depth, `None` if nothing is before the near plane.
    pub fn project(
        &mut self,
        camera: &Camera,
        instants: &[Instant],
        grid: &Grid,
        behind: Option<&Behind>,
    ) -> Option<RasterBound> {
        let n = grid.points.n();
        let p = grid.points.get(Global::P)?;
        let (mut min, mut max, mut z) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2], f32::INFINITY);
        self.at.resize_with(instants.len(), Vec::new);
        for (moment, (instant, raster)) in instants.iter().zip(&mut self.at).enumerate() {
            let off = moment.checked_sub(1).and_then(|k| grid.deformed.get(k));
            raster.clear();
            for k in 0..n {
                let mut at = Vec3::new(p[k], p[n + k], p[2 * n + k]);
                if let Some(off) = off {
                    at += Vec3::new(off[k], off[n + k], off[2 * n + k]);
                }
                let c = instant.to_camera.transform_point3(at);
                if !(c.z >= camera.near && c.is_finite()) {
                    raster.push([0.0, 0.0, f32::NEG_INFINITY]);
                    continue;
                }
                let r = on_steps(camera.project(c));
                let spread = camera.confusion(c.z).abs();
                raster.push([r.x, r.y, c.z]);
                min = [min[0].min(r.x - spread), min[1].min(r.y - spread)];
                max = [max[0].max(r.x + spread), max[1].max(r.y + spread)];
                z = z.min(c.z);
            }
        }
        if let Some(behind) = behind {
            behind.shift(camera, instants, &mut self.at);
        }
        (z <= camera.far).then_some(RasterBound { min: min.into(), max: max.into(), z })
    }

    /// Choose the micropolygons of a grid that are sampled: neither cut away nor behind the near plane, nor facing away with both triangles
    /// where one side of them is seen, as [`side_seen`] has it.
    pub fn choose(&mut self, camera: &Camera, side: f32, grid: &Grid) {
        let points = &grid.points;
        let (n, nu, nv) = (points.n(), points.nu, points.nv);
        let Raster { at, micropolygons } = self;
        // What moves, or is seen from a lens, may turn to a sample.
        let away = |k: usize| match &at[..] {
            [still] if side != 0.0 && !camera.has_lens() => !faces(still, nu, k, side),
            _ => false,
        };
        let behind = |k: usize| at.iter().any(|raster| !(raster[k][2] >= camera.near));
        let any_behind = (0..n).any(behind);
        micropolygons.clear();
        for j in 0..nv - 1 {
            for i in 0..nu - 1 {
                let k = j * nu + i;
                if grid.trimmed.get(j * (nu - 1) + i) == Some(&true)
                    || (any_behind && [k, k + 1, k + nu + 1, k + nu].into_iter().any(behind))
                    || away(k)
                {
                    continue;
                }
                micropolygons.push(k as u32);
            }
        }
    }
}

/// The sign that the area of a triangle of a grid has on the raster, columns to the right and rows down, where the side of its surface
/// that is seen is before the eye; 0 if both sides are seen. It is where the surface is that tells its sides apart (RISpec 3.2, section 4.2),
/// not the normals that it is given.
pub fn side_seen(camera: &Camera, view: &ItemView<'_>, points: &Points) -> f32 {
    let a = view.attributes;
    let is_opaque = a.stays_opaque() && view.attached.opacity.is_none();
    // `Points` are disks before the eye, whose sides are one.
    let is_disk = view.particle && a.two_sided && !is_opaque;
    if (a.two_sided && !is_disk) || a.solid.is_some() {
        return 0.0;
    }
    let outward = if is_disk && a.reversed { -points.orientation } else { points.orientation };
    if is_mirrored(camera) { -outward } else { outward }
}

/// Whether what runs one way around before the camera runs the other way around on the raster.
pub fn is_mirrored(camera: &Camera) -> bool {
    (camera.to_camera.determinant() < 0.0) != (camera.scale.x * camera.scale.y < 0.0)
}

/// Whether a triangle of a micropolygon shows the side that is seen.
fn faces(raster: &[[f32; 3]], nu: usize, k: usize, side: f32) -> bool {
    let [a, b, c, d] = [k, k + 1, k + nu + 1, k + nu].map(|k| raster[k]);
    let area = |p: [f32; 3], q: [f32; 3]| (p[0] - a[0]) * (q[1] - a[1]) - (q[0] - a[0]) * (p[1] - a[1]);
    side * area(b, c) > 0.0 || side * area(c, d) > 0.0
}

/// A raster point on steps of 1/1024 pixel: single precision then takes differences of places without rounding, so that images
/// do not depend on how they are cut to buckets.
fn on_steps(r: Vec2) -> Vec2 {
    // Of a sum of this size the last place is worth a step.
    const SHIFT: f32 = 12_288.0;
    (r + SHIFT) - SHIFT
}
