//! Dicing spheres: as one lattice that is the same from every bucket, so that no two of its grids can part.
//!
//! Of a sphere that hides its back, and that rays do not meet displaced, the half that the eye sees is diced, evenly as the eye sees it
//! ([`Cap`]). Others, and those whose surfaces look at how things change from point to point, are six faces of a cube blown up to the
//! sphere, even to a quarter, without poles. Where a sphere crosses the near plane or fills the image it is drawn as patches instead,
//! which are split as they need.

pub mod cap;
pub mod lattice;
pub mod tile;

use crate::gprim::bound::displacement_reach;
use crate::gprim::grid::{Grid, Sink, Subject};
use crate::gprim::quadric::whole_sphere;
use crate::gprim::sphere::cap::{Cap, Scratch};
use crate::gprim::sphere::lattice::{LatticeSphere, TILE, eye_in_lattice, fill, under_chords};
use crate::gprim::split::{self, Queue, coarsening};
use crate::scene::motion::Instant;
use glam::{Mat3, Vec3};

/// Finer lattices than this are drawn as patches.
const FINEST: usize = 512;

/// How much a displaced normal may lean away from the sphere's, radians, before its grid could be culled wrongly.
const LEAN: f32 = 0.5;

/// A direction on a face (0 to 5: +x, −x, +y, −y, +z, −z), before normalisation.
#[inline]
fn on_cube(face: usize, s: f32, t: f32) -> Vec3 {
    match face {
        0 => Vec3::new(1.0, s, t),
        1 => Vec3::new(-1.0, t, s),
        2 => Vec3::new(t, 1.0, s),
        3 => Vec3::new(s, -1.0, t),
        4 => Vec3::new(s, t, 1.0),
        _ => Vec3::new(t, s, -1.0),
    }
}

/// The same bits for the same direction, whichever face it is reached from.
#[inline]
fn unit(d: Vec3) -> Vec3 {
    // Sorted, so that the sum does not depend on which component is the face's.
    let mut q = [d.x * d.x, d.y * d.y, d.z * d.z];
    q.sort_by(f32::total_cmp);
    d / (q[0] + q[1] + q[2]).sqrt()
}

/// Face coordinate of lattice line `i` of `n`: even in angle, odd about the middle, exactly ±1 at the ends.
#[inline]
fn line(i: i32, n: i32) -> f32 {
    let from_middle = 2 * i - n;
    if from_middle == 0 {
        return 0.0;
    }
    if from_middle.abs() == n {
        return from_middle.signum() as f32;
    }
    (std::f32::consts::FRAC_PI_4 * from_middle.abs() as f32 / n as f32).tan() * from_middle.signum() as f32
}

/// Dice a sphere.
pub fn dice(subject: &Subject<'_>, scratch: &mut Scratch, queue: &mut Queue, grid: &mut Grid, sink: &mut impl Sink) {
    let Subject { view, camera, instants, .. } = *subject;
    let m = view.to_world;
    let linear = Mat3::from_mat4(m);
    let center = m.w_axis.truncate();
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis].map(Vec3::length);
    let radius = x.max(y).max(z);
    let reach = displacement_reach(view, radius);
    let moved = |i: &Instant| i.to_camera.transform_point3(center);
    let first = moved(&instants[0]);
    let depth = first.z;
    let shift = instants[1..].last().map_or(0.0, |last| camera.shift(first, moved(last)));
    let step = view.attributes.shading_rate.sqrt() * coarsening(shift + 2.0 * camera.confusion(depth).abs());
    let nearest = instants.iter().map(|i| moved(i).z).fold(f32::INFINITY, f32::min);
    let lines = (std::f32::consts::FRAC_PI_2 * radius * camera.pixels_at(depth - radius) / step).ceil();
    if !(nearest - radius - reach > camera.near) || lines > FINEST as f32 || linear.determinant() == 0.0 {
        return split::dice_all(subject, whole_sphere(), queue, grid, sink);
    }
    let even = (x - y).abs() <= 1e-5 * x && (x - z).abs() <= 1e-5 * x;
    let sign = linear.determinant().signum();
    // An even sphere is diced along the world's axes: its turn moves nothing but the pattern, which reads object space.
    let n = (lines as usize).max(2);
    // The lattice is wider by what chords cut off, so that small spheres cover what they should.
    let delta = std::f32::consts::FRAC_PI_2 / n as f32;
    let swell = 1.0 / under_chords(delta).sqrt();
    let sphere = LatticeSphere {
        center,
        linear: (if even { Mat3::from_diagonal(Vec3::splat(x)) } else { linear }) * swell,
        normals: if even { Mat3::IDENTITY } else { linear.inverse().transpose() },
        to_object: if even { linear.inverse() * x } else { Mat3::IDENTITY },
        orientation: if even { 1.0 } else { sign },
        to_lattice: if even { Mat3::from_diagonal(Vec3::splat(1.0 / x)) } else { linear.inverse() },
        reach,
        n,
    };
    let a = view.attributes;
    // Its back is seen where its front lets light through, is cut away, or is its inside and not there. Of `Points` it is not there.
    let shows_back = !view.particle && (!a.stays_opaque() || view.attached.opacity.is_some())
        || a.solid.is_some()
        || camera.clips
        || (a.reversed && !a.two_sided);
    // What rays meet displaced has one lattice, from wherever it is seen.
    let displaced = a.displacement.is_some();
    let even_on_raster =
        !(shows_back || a.reads_neighbours() || displaced && (a.traces_displaced() || sink.takes_unseen()));
    if even_on_raster {
        let pixels = radius * camera.pixels_at(depth) / step;
        if let Some(cap) = Cap::new(subject, &sphere, pixels) {
            return cap.dice(subject, LatticeSphere { linear: sphere.linear / swell, ..sphere }, scratch, grid, sink);
        }
    }
    (grid.apron, grid.keep, grid.reach) = (a.displacement.is_some(), [u32::MAX; 4], reach);
    grid.origin = None;
    let tiles = sphere.n.div_ceil(TILE);
    for face in 0..6 {
        for tile in 0..tiles * tiles {
            let range = |k: usize| [k * sphere.n / tiles, (k + 1) * sphere.n / tiles];
            let part = Tile { face, i: range(tile % tiles), j: range(tile / tiles) };
            if sink.takes_unseen() || part.may_show(subject, &sphere, shows_back, sink) {
                let Tile { face, i, j } = part;
                grid.tile = Some([face, i[0], i[1], j[0], j[1]].map(|k| k as u32));
                part.dice(subject, &sphere, &mut scratch.directions, grid);
                sink.take(grid);
            }
        }
    }
}

/// A part of a face of the cube: ranges of its lattice lines.
#[derive(Clone, Copy)]
struct Tile {
    face: usize,
    i: [usize; 2],
    j: [usize; 2],
}

impl Tile {
    /// Whether it may be visible; one that faces away is not, unless it is seen from behind.
    fn may_show(&self, subject: &Subject<'_>, sphere: &LatticeSphere, shows_back: bool, sink: &mut impl Sink) -> bool {
        let (Tile { face, i, j }, n) = (*self, sphere.n as i32);
        let at = |i: f32, j: f32| {
            let angle = |k: f32| (std::f32::consts::FRAC_PI_4 * (2.0 * k / n as f32 - 1.0)).tan();
            on_cube(face, angle(i), angle(j)).normalize()
        };
        let middle = at(0.5 * (i[0] + i[1]) as f32, 0.5 * (j[0] + j[1]) as f32);
        let corners = [(i[0], j[0]), (i[1], j[0]), (i[0], j[1]), (i[1], j[1])].map(|(i, j)| at(i as f32, j as f32));
        let spread = corners.iter().map(|c| c.dot(middle)).fold(1.0, f32::min).clamp(-1.0, 1.0).acos();
        if !shows_back {
            // The tile faces away if no direction d in it has d · eye > 1, at no moment.
            let lean = if sphere.reach > 0.0 { LEAN } else { 0.0 };
            let faces_away = |instant: &Instant| {
                let eye = eye_in_lattice(subject.camera, sphere, instant);
                let away = middle.angle_between(eye) - spread - lean;
                away > 0.0 && away.cos() * eye.length() < 1.0
            };
            if subject.instants.iter().all(faces_away) {
                return false;
            }
        }
        let around = sphere.center + sphere.linear * middle;
        let half = 2.0 * (0.5 * spread).sin() * sphere.longest() + sphere.reach;
        let box_at = |instant: &Instant| {
            let c = instant.to_camera.transform_point3(around);
            (c - half, c + half)
        };
        subject.may_show(sink, box_at)
    }

    fn dice(&self, subject: &Subject<'_>, sphere: &LatticeSphere, directions: &mut Vec<(Vec3, Vec3)>, grid: &mut Grid) {
        let (Tile { face, i, j }, ring) = (*self, grid.apron as i32);
        let lines = |[lo, hi]: [usize; 2]| (lo as i32 - ring..=hi as i32 + ring).map(|k| line(k, sphere.n as i32));
        let (s, t): (Vec<f32>, Vec<f32>) = (lines(i).collect(), lines(j).collect());
        directions.clear();
        directions.extend(t.iter().flat_map(|t| s.iter().map(|s| unit(on_cube(face, *s, *t)))).map(|d| (d, d)));
        fill(subject, sphere, [s.len(), t.len()], directions, grid);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_share_their_edges_to_the_bit() {
        let n = 13;
        let mut on_edges: Vec<[u32; 3]> = Vec::new();
        for face in 0..6 {
            for k in 0..=n {
                for (i, j) in [(0, k), (n, k), (k, 0), (k, n)] {
                    on_edges.push(unit(on_cube(face, line(i, n), line(j, n))).to_array().map(f32::to_bits));
                }
            }
        }
        // 12 edges with 12 inner points each, met from two faces, and 8 corners.
        on_edges.sort();
        on_edges.dedup();
        assert_eq!(on_edges.len(), 12 * 12 + 8);
    }

    #[test]
    fn rows_turn_outwards() {
        for face in 0..6 {
            let at = |s: f32, t: f32| on_cube(face, s, t);
            let normal = (at(0.1, 0.0) - at(0.0, 0.0)).cross(at(0.0, 0.1) - at(0.0, 0.0));
            assert!(normal.dot(at(0.0, 0.0)) > 0.0, "face {face}");
        }
    }
}
