//! A sphere in the space of its lattice, and the grid of some of its points.

use crate::gprim::grid::{Grid, Subject};
use crate::scene::camera::Camera;
use crate::scene::motion::Instant;
use crate::scene::shape::sphere_uv;
use glam::{Mat3, Vec3};
use sl::Global;

/// Points along a grid's edge, less one.
pub const TILE: usize = 11;

/// A sphere being drawn, in the space of its lattice.
pub struct LatticeSphere {
    /// The middle, world.
    pub center: Vec3,
    /// Lattice directions to world, the radius in it.
    pub linear: Mat3,
    /// Lattice directions to world normals.
    pub normals: Mat3,
    /// Lattice directions to object directions.
    pub to_object: Mat3,
    /// 1, or −1 if the transformation mirrors.
    pub orientation: f32,
    /// World to lattice space, its turn alone.
    pub to_lattice: Mat3,
    /// How far it may be displaced, world.
    pub reach: f32,
    /// Lines of a face, less one.
    pub n: usize,
}

impl LatticeSphere {
    /// Its longest half axis, world.
    pub fn longest(&self) -> f32 {
        let [x, y, z] = [self.linear.x_axis, self.linear.y_axis, self.linear.z_axis].map(Vec3::length);
        x.max(y).max(z)
    }
}

/// The eye in lattice space as seen from the sphere at a moment, or a point far away towards it.
pub fn eye_in_lattice(camera: &Camera, sphere: &LatticeSphere, instant: &Instant) -> Vec3 {
    let to = if camera.perspective { instant.eye - sphere.center } else { instant.eye * -1e6 };
    sphere.to_lattice * to
}

/// Begin a grid of a sphere: all that its points have alike.
pub fn start(subject: &Subject<'_>, sphere: &LatticeSphere, [nu, nv]: [usize; 2], grid: &mut Grid) {
    let view = subject.view;
    let points = &mut grid.points;
    (points.nu, points.nv) = (nu, nv);
    points.orientation = if view.attributes.reversed { -sphere.orientation } else { sphere.orientation };
    [Global::P, Global::N, Global::Ng].into_iter().for_each(|global| points.refill(global).clear());
    grid.deformed.clear();
    grid.trimmed.clear();
    view.fill_variables(points);
    view.to_current(points);
}

/// Make the grid of the points of a sphere in some directions, with the normals of others, in rows.
pub fn fill(
    subject: &Subject<'_>,
    sphere: &LatticeSphere,
    size: [usize; 2],
    directions: &[(Vec3, Vec3)],
    grid: &mut Grid,
) {
    start(subject, sphere, size, grid);
    let view = subject.view;
    let points = &mut grid.points;
    let n = points.n();
    let mut p = std::mem::take(points.refill(Global::P));
    let mut normal = std::mem::take(points.refill(Global::N));
    p.resize(3 * n, 0.0);
    normal.resize(3 * n, 0.0);
    let outward = if view.attributes.reversed { -1.0 } else { 1.0 };
    for (k, (d, m)) in directions.iter().enumerate() {
        let (q, m) = (sphere.center + sphere.linear * *d, sphere.normals * *m * outward);
        (p[k], p[n + k], p[2 * n + k]) = (q.x, q.y, q.z);
        (normal[k], normal[n + k], normal[2 * n + k]) = (m.x, m.y, m.z);
    }
    *points.refill(Global::P) = p;
    *points.refill(Global::N) = normal;
    if subject.needs_parameters() {
        let of = |(d, _): &(Vec3, Vec3)| sphere_uv(sphere.to_object * *d);
        for (axis, globals) in [[Global::U, Global::S], [Global::V, Global::T]].into_iter().enumerate() {
            for global in globals {
                points.refill(global).extend(directions.iter().map(|d| of(d)[axis]));
            }
        }
        view.set_coordinates(points);
    }
}

/// The part of a circle's area that is left by chords, of the angle δ each.
pub fn under_chords(delta: f32) -> f32 {
    1.0 - delta * delta / 6.0
}
