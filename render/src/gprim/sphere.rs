//! Dicing spheres: as one lattice that is the same from every bucket, so that no two of its grids can part.
//!
//! Of a sphere that keeps its form and hides its back, the half that the eye sees is diced, evenly as the eye sees it ([`Cap`]).
//! Others, and those whose shaders look at how things change from point to point, are six faces of a cube blown up to the sphere,
//! even to a quarter, without poles. Where a sphere crosses the near plane or fills the picture it is drawn as patches instead,
//! which are split as they need.

use crate::cpu::bucket::Job;
use crate::cpu::shade::{Diced, displacement_reach, finish};
use crate::gprim::patch::{self, coarsening};
use crate::gprim::surfaces::{circle, revolve};
use crate::scene::motion::Instant;
use crate::scene::patch::Patch;
use crate::scene::shape::sphere_uv;
use crate::scene::source::{Item, ItemView};
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

impl Ball {
    /// Its longest half axis, world.
    fn longest(&self) -> f32 {
        let [x, y, z] = [self.linear.x_axis, self.linear.y_axis, self.linear.z_axis].map(Vec3::length);
        x.max(y).max(z)
    }
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
    let a = view.attributes;
    let seen_through = !a.stays_opaque();
    let even_on_raster = !seen_through && a.displacement.is_none() && !a.reads_neighbours();
    if even_on_raster && (a.two_sided || !a.reversed) {
        let pixels = radius * camera.pixels_at(depth) / step;
        if let Some(cap) = Cap::new(job, &ball, pixels) {
            return cap.draw(job, item, view, Ball { linear: ball.linear / swell, ..ball });
        }
    }
    let tiles = ball.n.div_ceil(TILE);
    for face in 0..6 {
        for tile in 0..tiles * tiles {
            let range = |k: usize| [k * ball.n / tiles, (k + 1) * ball.n / tiles];
            draw_tile(job, item, view, &ball, face, range(tile % tiles), range(tile / tiles), seen_through);
        }
    }
}

/// The half of a sphere that the eye sees: a square lattice on the disk that it is on the raster (Shirley and Chiu 1997), so that
/// micropolygons are of one size there and the outline is a ring of the lattice.
struct Cap {
    /// Towards the eye, and two directions across, in the space of the sphere's lattice.
    axes: [Vec3; 3],
    /// Cosine and sine of the angle from the eye's direction, by rings from the middle.
    rings: Vec<[f32; 2]>,
    /// The ring of the outline, and the angle of its normals.
    outline: (usize, [f32; 2]),
}

/// Normals at the outline lean this much towards the eye, radians, so that none is taken for one that faces away.
const INWARDS: f32 = 2e-3;

/// The most that a cap may reach round the outline, for eyes that move, radians.
const ROUND: f32 = 0.5;

impl Cap {
    /// Of a sphere of so many micropolygons' radius; none where the eye is too near or moves too far.
    fn new(job: &Job<'_>, ball: &Ball, radius: f32) -> Option<Cap> {
        let camera = &job.frame.camera;
        let eye = eye_in_lattice(job, ball, &job.instants[0]);
        let distance = if camera.perspective { eye.length() } else { f32::INFINITY };
        let to_eye = eye.normalize_or_zero();
        let up = ball.to_lattice * camera.to_world.y_axis.truncate();
        let across = up.cross(to_eye).normalize_or_zero();
        // Angles between eyes are seen from the middle; from the surface they may be greater.
        let turn = |i: &Instant| to_eye.angle_between(eye_in_lattice(job, ball, i));
        let mut round = job.instants[1..].iter().map(turn).fold(0.0, f32::max);
        if let Some(lens) = camera.lens_radius() {
            round += lens / (ball.longest() * distance);
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
        if round > 0.0 {
            let more = (round * radius).ceil();
            let horizon = angle(1.0);
            rings.extend((1..=more as usize).map(|k| pair(horizon + round * k as f32 / more)));
        }
        Some(Cap { axes: [to_eye, across, to_eye.cross(across)], rings, outline })
    }

    fn draw(&self, job: &mut Job<'_>, item: Item, view: &ItemView<'_>, mut ball: Ball) {
        let half = self.rings.len() - 1;
        // The outline has eight sides a ring.
        let delta = 0.25 * std::f32::consts::PI / self.outline.0 as f32;
        ball.linear *= 1.0 / (1.0 - delta * delta / 6.0).sqrt();
        let tiles = (2 * half).div_ceil(TILE);
        let range = |k: usize| [k * 2 * half / tiles, (k + 1) * 2 * half / tiles];
        for tile in 0..tiles * tiles {
            let (i, j) = (range(tile % tiles), range(tile / tiles));
            let (middle, spread) = self.around(&mut job.disk, i, j);
            let around = ball.center + ball.linear * middle;
            let reach = 2.0 * (0.5 * spread).sin() * ball.longest();
            let box_at = |instant: &Instant| {
                let c = instant.to_camera.transform_point3(around);
                (c - reach, c + reach)
            };
            if tiles > 1 && !job.worth(box_at) {
                continue;
            }
            self.dice(job, view, &ball, i, j);
            finish(job, item, view, &Diced { apron: false, keep: [u32::MAX; 4] }, 0.0);
        }
    }

    /// The direction of a point of the lattice.
    fn direction(&self, disk: &mut Disk, i: usize, j: usize) -> Vec3 {
        let half = self.rings.len() as i32 - 1;
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

    fn dice(&self, job: &mut Job<'_>, view: &ItemView<'_>, ball: &Ball, i: [usize; 2], j: [usize; 2]) {
        let half = self.rings.len() as i32 - 1;
        let size = [i, j].map(|[lo, hi]| hi - lo + 1);
        let [to_eye, across, up] = self.axes;
        let mut directions = std::mem::take(&mut job.directions);
        directions.clear();
        for b in j[0]..=j[1] {
            for a in i[0]..=i[1] {
                let (a, b) = (a as i32 - half, b as i32 - half);
                let ring = a.abs().max(b.abs()) as usize;
                let [x, y] = job.disk.direction(a, b);
                let side = across * x + up * y;
                let on = |[cos, sin]: [f32; 2]| to_eye * cos + side * sin;
                let normal = if ring >= self.outline.0 { self.outline.1 } else { self.rings[ring] };
                directions.push((on(self.rings[ring]), on(normal)));
            }
        }
        fill(job, view, ball, size, &directions);
        job.directions = directions;
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
        let (x, y) = (a.unsigned_abs() as usize, b.unsigned_abs() as usize);
        let (ring, along) = (x.max(y), x.min(y));
        while self.eighths.len() <= ring {
            let n = self.eighths.len();
            let at = |k: usize| (std::f32::consts::FRAC_PI_4 * k as f32 / n.max(1) as f32).sin_cos();
            self.eighths.push((0..=n).map(|k| [at(k).1, at(k).0]).collect());
        }
        let [near, far] = self.eighths[ring][along];
        let (cos, sin) = if x >= y { (near, far) } else { (far, near) };
        [if a < 0 { -cos } else { cos }, if b < 0 { -sin } else { sin }]
    }
}

/// The patches of the unit sphere.
pub fn whole_sphere() -> &'static [Patch] {
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
    let around = ball.center + ball.linear * middle;
    let half = 2.0 * (0.5 * spread).sin() * ball.longest() + ball.reach;
    let box_at = |instant: &Instant| {
        let c = instant.to_camera.transform_point3(around);
        (c - half, c + half)
    };
    if !job.worth(box_at) {
        return;
    }
    let apron = view.attributes.displacement.is_some();
    dice(job, view, ball, face, i, j, apron);
    finish(job, item, view, &Diced { apron, keep: [u32::MAX; 4] }, ball.reach);
}

fn dice(job: &mut Job<'_>, view: &ItemView<'_>, ball: &Ball, face: usize, i: [usize; 2], j: [usize; 2], apron: bool) {
    let ring = apron as i32;
    let lines = |[lo, hi]: [usize; 2]| (lo as i32 - ring..=hi as i32 + ring).map(|k| line(k, ball.n as i32));
    let (s, t): (Vec<f32>, Vec<f32>) = (lines(i).collect(), lines(j).collect());
    let mut directions = std::mem::take(&mut job.directions);
    directions.clear();
    directions.extend(t.iter().flat_map(|t| s.iter().map(|s| unit(on_cube(face, *s, *t)))).map(|d| (d, d)));
    fill(job, view, ball, [s.len(), t.len()], &directions);
    job.directions = directions;
}

/// Make the grid of the points of a sphere in some directions, with the normals of others, in rows.
fn fill(job: &mut Job<'_>, view: &ItemView<'_>, ball: &Ball, [nu, nv]: [usize; 2], directions: &[(Vec3, Vec3)]) {
    let points = &mut job.grid.points;
    (points.nu, points.nv) = (nu, nv);
    points.orientation = if view.attributes.reversed { -ball.orientation } else { ball.orientation };
    let n = points.n();
    let mut p = std::mem::take(points.refill("P"));
    let mut normal = std::mem::take(points.refill("N"));
    p.resize(3 * n, 0.0);
    normal.resize(3 * n, 0.0);
    let outward = if view.attributes.reversed { -1.0 } else { 1.0 };
    for (k, (d, m)) in directions.iter().enumerate() {
        let (q, m) = (ball.center + ball.linear * *d, ball.normals * *m * outward);
        (p[k], p[n + k], p[2 * n + k]) = (q.x, q.y, q.z);
        (normal[k], normal[n + k], normal[2 * n + k]) = (m.x, m.y, m.z);
    }
    *points.refill("P") = p;
    *points.refill("N") = normal;
    job.trimmed.clear();
    job.uniform.clear();
    job.varying.clear();
    if job.frame.needs_parameters(view) {
        let of = |(d, _): &(Vec3, Vec3)| sphere_uv(ball.to_object * *d);
        for (axis, names) in [["u", "s"], ["v", "t"]].into_iter().enumerate() {
            for name in names {
                points.refill(name).extend(directions.iter().map(|d| of(d)[axis]));
            }
        }
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
    fn tiles_of_a_cap_lie_within_their_bounds() {
        for (half, horizon) in [(3usize, 1.5f32), (12, 1.2), (40, 0.7), (55, 1.56)] {
            let angle = |k: usize| (k as f32 / half as f32 * horizon.sin()).min(1.0).asin();
            let rings = (0..=half).map(|k| [angle(k).cos(), angle(k).sin()]).collect();
            let cap = Cap { axes: [Vec3::Z, Vec3::X, Vec3::Y], rings, outline: (half, [0.0, 1.0]) };
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

    #[test]
    fn rows_turn_outwards() {
        for face in 0..6 {
            let at = |s: f32, t: f32| on_cube(face, s, t);
            let normal = (at(0.1, 0.0) - at(0.0, 0.0)).cross(at(0.0, 0.1) - at(0.0, 0.0));
            assert!(normal.dot(at(0.0, 0.0)) > 0.0, "face {face}");
        }
    }
}
