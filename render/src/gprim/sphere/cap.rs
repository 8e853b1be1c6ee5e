//! The half of a sphere that the eye sees, diced evenly as the eye sees it.

use crate::gprim::grid::{Grid, Sink, Subject};
use crate::gprim::sphere::lattice::{LatticeSphere, TILE, eye_in_lattice, fill, start, under_chords};
use crate::gprim::sphere::tile::{self, CapSphere, CapTile, eighth};
use crate::scene::motion::Instant;
use glam::Vec3;
use std::sync::Arc;

/// Memory of dicing a sphere, kept from sphere to sphere.
#[derive(Default)]
pub struct Scratch {
    /// Directions and normals of the grid at hand.
    pub directions: Vec<(Vec3, Vec3)>,
    disk: Disk,
}

/// The half of a sphere that the eye sees: a square lattice on the disk that it is on the raster (Shirley and Chiu 1997), so that
/// micropolygons are of one size there and the outline is a ring of the lattice.
pub struct Cap {
    /// Towards the eye, and two directions across, in the space of the sphere's lattice.
    axes: [Vec3; 3],
    /// Cosine and sine of the angle from the eye's direction, by rings from the middle.
    rings: Vec<[f32; 2]>,
    /// The ring of the outline, and the angle of its normals.
    outline: (usize, [f32; 2]),
    /// Its grids have an apron, for which the last ring is.
    apron: bool,
}

/// Normals at the outline lean this much towards the eye, radians, so that none is taken for one that faces away.
const INWARDS: f32 = 2e-3;

/// The most that a cap may reach round the outline, for eyes that move, radians.
const ROUND: f32 = 0.5;

/// The most that the cap of a displaced sphere reaches round the outline of what it was, radians: where cuts lay open what was behind.
const LAID_OPEN: f32 = 0.8;

/// The face that a cap is, beside the six of a whole lattice.
const CAP: usize = 6;

impl Cap {
    /// The cap of a sphere whose radius on the raster is `radius` micropolygons; none where the eye is too near or moves too far.
    pub fn new(subject: &Subject<'_>, sphere: &LatticeSphere, radius: f32) -> Option<Cap> {
        let Subject { camera, instants, .. } = *subject;
        let eye = eye_in_lattice(camera, sphere, &instants[0]);
        let distance = if camera.perspective { eye.length() } else { f32::INFINITY };
        let to_eye = eye.normalize_or_zero();
        let up = sphere.to_lattice * camera.to_world.y_axis.truncate();
        let across = up.cross(to_eye).normalize_or_zero();
        // Angles between eyes are seen from the middle; from the surface they may be greater.
        let turn = |i: &Instant| to_eye.angle_between(eye_in_lattice(camera, sphere, i));
        let mut round = instants[1..].iter().map(turn).fold(0.0, f32::max);
        if let Some(lens) = camera.lens_radius() {
            round += lens / (sphere.longest() * distance);
        }
        round *= 1.5;
        if !(distance > 1.05 && round < ROUND) || across == Vec3::ZERO || !across.is_finite() {
            return None;
        }
        // As many micropolygons as the disk has room for.
        let count = (0.5 * std::f32::consts::PI.sqrt() * radius * (1.0 - distance.powi(-2)).powf(-0.5)).ceil().max(1.0);
        let angle = |part: f32| {
            if distance == f32::INFINITY {
                return part.min(1.0).asin();
            }
            let slope = part / (distance * distance - 1.0).sqrt();
            (distance * slope / (1.0 + slope * slope).sqrt()).min(1.0).asin() - slope.atan()
        };
        let pair = |angle: f32| [angle.cos(), angle.sin()];
        let mut rings: Vec<[f32; 2]> = (0..=count as usize).map(|k| pair(angle(k as f32 / count))).collect();
        let outline = (rings.len() - 1, pair(angle(1.0) - INWARDS));
        let apron = subject.view.attributes.displacement.is_some();
        let mut more = (round * radius).ceil();
        if apron {
            round += (1.0 - sphere.reach / sphere.longest()).clamp(-1.0, 1.0).acos().min(LAID_OPEN);
            // What comes in sight there is seen at a slant.
            more = (0.5 * round * radius).ceil().max(more);
        }
        if round > 0.0 {
            let horizon = angle(1.0);
            rings.extend((1..=more as usize + apron as usize).map(|k| pair(horizon + round * k as f32 / more)));
        }
        Some(Cap { axes: [to_eye, across, to_eye.cross(across)], rings, outline, apron })
    }

    /// Dice it, tile by tile.
    pub fn dice(
        &self,
        subject: &Subject<'_>,
        mut sphere: LatticeSphere,
        scratch: &mut Scratch,
        grid: &mut Grid,
        sink: &mut impl Sink,
    ) {
        (grid.apron, grid.keep, grid.reach, grid.origin) = (self.apron, [u32::MAX; 4], sphere.reach, None);
        let half = self.half();
        sphere.linear *= 1.0 / self.covered().sqrt();
        let tiles = (2 * half).div_ceil(TILE);
        let range = |k: usize| [k * 2 * half / tiles, (k + 1) * 2 * half / tiles];
        let mut alike = None;
        for tile in 0..tiles * tiles {
            let (i, j) = (range(tile % tiles), range(tile / tiles));
            let (middle, spread) = self.around(&mut scratch.disk, i, j);
            let around = sphere.center + sphere.linear * middle;
            let reach = 2.0 * (0.5 * spread).sin() * sphere.longest() + sphere.reach;
            let box_at = |instant: &Instant| {
                let c = instant.to_camera.transform_point3(around);
                (c - reach, c + reach)
            };
            if tiles > 1 && !subject.may_show(sink, box_at) {
                continue;
            }
            grid.tile = Some([CAP, i[0], i[1], j[0], j[1]].map(|k| k as u32));
            if !self.apron && sink.takes_caps(self.rings.len()) {
                start(subject, &sphere, [i, j].map(|[lo, hi]| hi - lo + 1), grid);
                let sphere = alike.get_or_insert_with(|| Arc::new(self.alike(subject, &sphere))).clone();
                sink.take_cap(CapTile { sphere, first: [i[0], j[0]].map(|k| k as i32 - half as i32) }, grid);
                continue;
            }
            self.dice_tile(subject, &sphere, i, j, scratch, grid);
            sink.take(grid);
        }
    }

    /// The part of the disk that is covered: a ring has eight sides for each that is within it, whose chords cut something off. One that reaches
    /// round the outline has more of them, and is seen from there as well, if little smaller.
    fn covered(&self) -> f32 {
        let (outline, [cos, sin]) = (self.outline.0, self.rings[self.outline.0]);
        let of_ring = |k: usize| {
            let delta = 0.25 * std::f32::consts::PI / k as f32;
            let round = self.rings[k][0] * cos + self.rings[k][1] * sin;
            under_chords(delta) * round * round
        };
        (outline..=self.half()).map(of_ring).fold(0.0, f32::max)
    }

    /// What its tiles have alike.
    fn alike(&self, subject: &Subject<'_>, sphere: &LatticeSphere) -> CapSphere {
        CapSphere {
            center: sphere.center,
            linear: sphere.linear,
            normals: sphere.normals,
            axes: self.axes,
            rings: self.rings.clone(),
            outline: self.outline,
            outward: if subject.view.attributes.reversed { -1.0 } else { 1.0 },
        }
    }

    /// Rings about the middle that are drawn.
    fn half(&self) -> usize {
        self.rings.len() - 1 - self.apron as usize
    }

    /// The direction of a point of the lattice.
    fn direction(&self, disk: &mut Disk, i: usize, j: usize) -> Vec3 {
        let half = self.half() as i32;
        let (a, b) = (i as i32 - half, j as i32 - half);
        let [cos, sin] = self.rings[a.abs().max(b.abs()) as usize];
        let [x, y] = disk.direction(a, b);
        self.axes[0] * cos + (self.axes[1] * x + self.axes[2] * y) * sin
    }

    /// A direction in the middle of a tile, and the angle from there within which all of it is: its corners lie farthest, up to a
    /// little.
    fn around(&self, disk: &mut Disk, i: [usize; 2], j: [usize; 2]) -> (Vec3, f32) {
        let middle = self.direction(disk, (i[0] + i[1]) / 2, (j[0] + j[1]) / 2);
        let corners = [(i[0], j[0]), (i[1], j[0]), (i[0], j[1]), (i[1], j[1])];
        let angle = |(i, j): (usize, usize)| self.direction(disk, i, j).angle_between(middle);
        (middle, 1.1 * corners.map(angle).into_iter().fold(0.0, f32::max) + 1e-3)
    }

    fn dice_tile(
        &self,
        subject: &Subject<'_>,
        sphere: &LatticeSphere,
        i: [usize; 2],
        j: [usize; 2],
        scratch: &mut Scratch,
        grid: &mut Grid,
    ) {
        let (half, ring) = (self.half() as i32, self.apron as i32);
        let [i, j] = [i, j].map(|[lo, hi]| lo as i32 - ring..=hi as i32 + ring);
        let size = [&i, &j].map(|range| (range.end() - range.start() + 1) as usize);
        let [to_eye, across, up] = self.axes;
        let Scratch { directions, disk } = scratch;
        directions.clear();
        for b in j {
            for a in i.clone() {
                let (a, b) = (a - half, b - half);
                let ring = a.abs().max(b.abs()) as usize;
                let [x, y] = disk.direction(a, b);
                let side = across * x + up * y;
                let on = |[cos, sin]: [f32; 2]| to_eye * cos + side * sin;
                let normal = if ring >= self.outline.0 { self.outline.1 } else { self.rings[ring] };
                directions.push((on(self.rings[ring]), on(normal)));
            }
        }
        fill(subject, sphere, size, directions, grid);
    }
}

/// Directions from the middle of a square lattice on a disk, by column and row from there, kept from sphere to sphere.
#[derive(Default)]
pub struct Disk {
    /// For each ring, of an eighth of it: cosine and sine.
    eighths: Vec<Vec<[f32; 2]>>,
}

impl Disk {
    fn direction(&mut self, a: i32, b: i32) -> [f32; 2] {
        tile::direction(a, b, |ring, along| {
            while self.eighths.len() <= ring {
                let n = self.eighths.len();
                self.eighths.push((0..=n).map(|k| eighth(n, k)).collect());
            }
            self.eighths[ring][along]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_of_a_cap_lie_within_their_bounds() {
        for (half, horizon) in [(3usize, 1.5f32), (12, 1.2), (40, 0.7), (55, 1.56)] {
            let angle = |k: usize| (k as f32 / half as f32 * horizon.sin()).min(1.0).asin();
            let rings = (0..=half).map(|k| [angle(k).cos(), angle(k).sin()]).collect();
            let cap = Cap { axes: [Vec3::Z, Vec3::X, Vec3::Y], rings, outline: (half, [0.0, 1.0]), apron: false };
            let mut disk = Disk::default();
            let tiles = (2 * half).div_ceil(TILE);
            let range = |k: usize| [k * 2 * half / tiles, (k + 1) * 2 * half / tiles];
            for (i, j) in (0..tiles * tiles).map(|t| (range(t % tiles), range(t / tiles))) {
                let (middle, spread) = cap.around(&mut disk, i, j);
                for (a, b) in (i[0]..=i[1]).flat_map(|a| (j[0]..=j[1]).map(move |b| (a, b))) {
                    let off = cap.direction(&mut disk, a, b).angle_between(middle);
                    assert!(off <= spread, "{half} {i:?} {j:?}: {off} beyond {spread}");
                }
            }
        }
    }
}
