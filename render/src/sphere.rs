//! Dicing spheres: six faces of a cube blown up to the sphere, as one lattice, so that no two of its grids can part.
//!
//! The lattice is even to a quarter, has no poles, and is the same from every bucket. Where a sphere crosses the near plane or
//! fills the picture it is drawn as patches instead, which are split as they need.

use crate::bucket::Job;
use crate::motion::Instant;
use crate::patch::{self, coarsening};
use crate::scene::{Item, ItemView, Patch, sphere_uv};
use crate::shade::{Diced, displacement_reach, finish, keeps_opacity};
use crate::surfaces::{circle, revolve};
use glam::{Mat3, Vec3};
use std::sync::OnceLock;

/// Points along a grid's edge, less one.
const TILE: usize = 11;

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

/// A sphere being drawn, in the space of its lattice.
struct Ball {
    center: Vec3,
    /// Lattice directions to world, the radius in it.
    linear: Mat3,
    /// Lattice directions to world normals.
    normals: Mat3,
    /// Lattice directions to object directions.
    to_object: Mat3,
    /// 1, or −1 if the transformation mirrors.
    orientation: f32,
    /// World to lattice space, its turn alone.
    to_lattice: Mat3,
    reach: f32,
    /// Lines of a face, less one.
    n: usize,
}

/// Draw a sphere item.
pub fn draw(job: &mut Job<'_>, item: Item, view: &ItemView<'_>) {
    let m = view.to_world;
    let linear = Mat3::from_mat4(m);
    let center = m.w_axis.truncate();
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis].map(Vec3::length);
    let radius = x.max(y).max(z);
    let camera = &job.frame.camera;
    let reach = displacement_reach(view, radius);
    let moved = |i: &Instant| i.to_camera.transform_point3(center);
    let first = moved(&job.instants[0]);
    let depth = first.z;
    let shift = job.instants[1..].last().map_or(0.0, |last| camera.shift(first, moved(last)));
    let step = view.attributes.shading_rate.sqrt() * coarsening(shift + 2.0 * camera.confusion(depth).abs());
    let nearest = job.instants.iter().map(|i| moved(i).z).fold(f32::INFINITY, f32::min);
    let lines = (std::f32::consts::FRAC_PI_2 * radius * camera.pixels_at(depth - radius) / step).ceil();
    if !(nearest - radius - reach > camera.near) || lines > FINEST as f32 || linear.determinant() == 0.0 {
        return patch::draw_all(job, item, view, whole_sphere());
    }
    let even = (x - y).abs() <= 1e-5 * x && (x - z).abs() <= 1e-5 * x;
    let sign = linear.determinant().signum();
    // An even sphere is diced along the world's axes: its turn moves nothing but the pattern, which reads object space.
    let n = (lines as usize).max(2);
    // Chords cut a part δ²/6 off a circle's area, δ the angle of one: the lattice is that much wider, so that small spheres
    // cover what they should.
    let delta = std::f32::consts::FRAC_PI_2 / n as f32;
    let swell = 1.0 / (1.0 - delta * delta / 6.0).sqrt();
    let ball = Ball {
        center,
        linear: (if even { Mat3::from_diagonal(Vec3::splat(x)) } else { linear }) * swell,
        normals: if even { Mat3::IDENTITY } else { linear.inverse().transpose() },
        to_object: if even { linear.inverse() * x } else { Mat3::IDENTITY },
        orientation: if even { 1.0 } else { sign },
        to_lattice: if even { Mat3::from_diagonal(Vec3::splat(1.0 / x)) } else { linear.inverse() },
        reach,
        n,
    };
    let seen_through = view.attributes.opacity != [1.0; 3] || !keeps_opacity(&view.attributes.surface.program);
    let tiles = ball.n.div_ceil(TILE);
    for face in 0..6 {
        for tile in 0..tiles * tiles {
            let range = |k: usize| [k * ball.n / tiles, (k + 1) * ball.n / tiles];
            draw_tile(job, item, view, &ball, face, range(tile % tiles), range(tile / tiles), seen_through);
        }
    }
}

/// The patches of the unit sphere.
fn whole_sphere() -> &'static [Patch] {
    static PATCHES: OnceLock<Vec<Patch>> = OnceLock::new();
    PATCHES.get_or_init(|| {
        let quarter = 0.5 * std::f32::consts::PI;
        revolve(&circle([0.0; 2], 1.0, -quarter, quarter), 360.0)
    })
}

/// The eye in lattice space as seen from the sphere at a moment, or a point far away towards it.
fn eye_in_lattice(job: &Job<'_>, ball: &Ball, instant: &Instant) -> Vec3 {
    let to = if job.frame.camera.perspective { instant.eye - ball.center } else { instant.eye * -1e6 };
    ball.to_lattice * to
}

#[allow(clippy::too_many_arguments)]
fn draw_tile(
    job: &mut Job<'_>,
    item: Item,
    view: &ItemView<'_>,
    ball: &Ball,
    face: usize,
    i: [usize; 2],
    j: [usize; 2],
    seen_through: bool,
) {
    let n = ball.n as i32;
    let at = |i: f32, j: f32| {
        let angle = |k: f32| (std::f32::consts::FRAC_PI_4 * (2.0 * k / n as f32 - 1.0)).tan();
        on_cube(face, angle(i), angle(j)).normalize()
    };
    let middle = at(0.5 * (i[0] + i[1]) as f32, 0.5 * (j[0] + j[1]) as f32);
    let corners = [(i[0], j[0]), (i[1], j[0]), (i[0], j[1]), (i[1], j[1])].map(|(i, j)| at(i as f32, j as f32));
    let spread = corners.iter().map(|c| c.dot(middle)).fold(1.0, f32::min).clamp(-1.0, 1.0).acos();
    if !seen_through {
        // The tile faces away if no direction d in it has d · eye > 1, at no moment.
        let lean = if ball.reach > 0.0 { LEAN } else { 0.0 };
        let faces_away = |instant: &Instant| {
            let eye = eye_in_lattice(job, ball, instant);
            let away = middle.angle_between(eye) - spread - lean;
            away > 0.0 && away.cos() * eye.length() < 1.0
        };
        if job.instants.iter().all(faces_away) {
            return;
        }
    }
    let longest = ball.linear.x_axis.length().max(ball.linear.y_axis.length()).max(ball.linear.z_axis.length());
    let around = ball.center + ball.linear * middle;
    let half = 2.0 * (0.5 * spread).sin() * longest + ball.reach;
    let box_at = |instant: &Instant| {
        let c = instant.to_camera.transform_point3(around);
        (c - half, c + half)
    };
    if !job.worth(box_at) {
        return;
    }
    let apron = view.attributes.displacement.is_some();
    dice(job, view, ball, face, i, j, apron);
    finish(job, item, view, &Diced { apron, keep: [1; 4] }, ball.reach);
}

fn dice(job: &mut Job<'_>, view: &ItemView<'_>, ball: &Ball, face: usize, i: [usize; 2], j: [usize; 2], apron: bool) {
    let ring = apron as i32;
    let lines = |[lo, hi]: [usize; 2]| (lo as i32 - ring..=hi as i32 + ring).map(|k| line(k, ball.n as i32));
    let (s, t): (Vec<f32>, Vec<f32>) = (lines(i).collect(), lines(j).collect());
    let points = &mut job.grid.points;
    (points.nu, points.nv) = (s.len(), t.len());
    points.orientation = if view.attributes.reversed { -ball.orientation } else { ball.orientation };
    let n = points.n();
    let mut p = std::mem::take(points.refill("P"));
    let mut normal = std::mem::take(points.refill("N"));
    p.resize(3 * n, 0.0);
    normal.resize(3 * n, 0.0);
    let outward = if view.attributes.reversed { -1.0 } else { 1.0 };
    for (b, t) in t.iter().enumerate() {
        for (a, s) in s.iter().enumerate() {
            let k = b * points.nu + a;
            let d = unit(on_cube(face, *s, *t));
            let (q, m) = (ball.center + ball.linear * d, ball.normals * d * outward);
            (p[k], p[n + k], p[2 * n + k]) = (q.x, q.y, q.z);
            (normal[k], normal[n + k], normal[2 * n + k]) = (m.x, m.y, m.z);
        }
    }
    *points.refill("P") = p;
    *points.refill("N") = normal;
    job.trimmed.clear();
    if job.needs_parameters(view) {
        parameters(job, ball, face, &s, &t);
    }
}

/// u, v, s, t of the grid.
fn parameters(job: &mut Job<'_>, ball: &Ball, face: usize, s: &[f32], t: &[f32]) {
    let (mut us, mut vs) = (Vec::new(), Vec::new());
    for t in t {
        for s in s {
            let d = ball.to_object * unit(on_cube(face, *s, *t));
            let [u, v] = sphere_uv(d);
            us.push(u);
            vs.push(v);
        }
    }
    let points = &mut job.grid.points;
    points.refill("s").extend_from_slice(&us);
    points.refill("t").extend_from_slice(&vs);
    *points.refill("u") = us;
    *points.refill("v") = vs;
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
