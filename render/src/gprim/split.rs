//! Splitting and dicing bicubic patches.
//!
//! A patch is split in its parameters until a piece is before the near plane, even in depth, and small enough for a grid. A
//! grid's edge is diced by what the edge itself measures, halved where it is long and each half again, and points that the edge
//! does not have so are put onto the line between those that it has: neighbours that share an edge agree on it, whatever their
//! insides need and however they are split.

use crate::cpu::bucket::Job;
use crate::cpu::shade::{Diced, displacement_reach, finish};
use crate::gprim::sphere::whole_sphere;
use crate::scene::motion::{Instant, later};
use crate::scene::patch::{Patch, bernstein, bernstein_slope, bilinear, point_of};
use crate::scene::shape::Shape;
use crate::scene::source::{Item, ItemView};
use glam::Vec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Micropolygons along a grid's edge.
const TILE: usize = 16;

/// Splits after which a piece that still crosses the near plane is given up.
const DEEPEST: u32 = 40;

/// A piece of a patch, in its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    u: [f32; 2],
    v: [f32; 2],
    depth: u32,
}

/// A piece of a patch of an item that waits for its turn, which comes by its least depth.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    z: f32,
    item: Item,
    patch: u32,
    piece: Piece,
}

impl Waiting {
    fn key(&self) -> (u32, u32, u32) {
        (self.item.source, self.item.index, self.patch)
    }

    /// The item.
    pub fn item(&self) -> Item {
        self.item
    }

    /// Whether its turn comes before that of an item whose least depth is `z`.
    pub fn before(&self, z: f32, item: Item) -> bool {
        self.z.total_cmp(&z).then((self.item.source, self.item.index).cmp(&(item.source, item.index))).is_lt()
    }
}

impl Ord for Waiting {
    /// The nearest is the greatest.
    fn cmp(&self, o: &Waiting) -> Ordering {
        let start = |w: &Waiting| w.piece.u[0] + 2.0 * w.piece.v[0];
        o.z.total_cmp(&self.z).then(o.key().cmp(&self.key())).then(start(o).total_cmp(&start(self)))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, o: &Waiting) -> Option<Ordering> {
        Some(self.cmp(o))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, o: &Waiting) -> bool {
        self.cmp(o).is_eq()
    }
}

impl Eq for Waiting {}

/// Draw the patches of an item.
pub fn draw_all(job: &mut Job<'_>, item: Item, view: &ItemView<'_>, patches: &[Patch]) {
    for k in 0..patches.len() {
        draw_piece(job, item, view, patches, k, Piece { u: [0.0, 1.0], v: [0.0, 1.0], depth: 0 });
    }
}

/// Draw a piece whose turn has come; `job` has the moments of its item.
pub fn draw_waiting(job: &mut Job<'_>, view: &ItemView<'_>, waiting: &Waiting) {
    let patches = match view.shape {
        Shape::Patches(patches) => patches,
        Shape::Sphere => whole_sphere(),
    };
    draw_piece(job, waiting.item, view, patches, waiting.patch as usize, waiting.piece);
}

fn draw_piece(job: &mut Job<'_>, item: Item, view: &ItemView<'_>, patches: &[Patch], k: usize, piece: Piece) {
    let patch = &patches[k];
    let size = patch.p.iter().map(|p| (*p - patch.p[0]).length()).fold(0.0, f32::max);
    let scale = view.to_world.x_axis.truncate().length();
    let reach = displacement_reach(view, size * scale);
    let to_camera = job.frame.camera.to_camera * view.to_world;
    let own = sub_patch(&patch.p, piece);
    let p = own.map(|p| to_camera.transform_point3(p));
    let hull =
        |p: &[Vec3; 16]| p.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    let (min, max) = hull(&p);
    // What is wholly behind the near plane as the shutter opens is not seen, wherever it moves.
    if !min.is_finite() || !max.is_finite() || max.z + reach < job.frame.camera.near {
        return;
    }
    // Control points in camera space at a moment.
    let moved = |instant: &Instant| {
        let own =
            if patch.moves.is_empty() { own } else { sub_patch(&later(patch.p, &patch.moves, instant.time), piece) };
        let m = instant.to_camera * view.to_world;
        own.map(|p| m.transform_point3(p))
    };
    let shows = job.worth(|instant| {
        let (min, max) = if instant.time == 0.0 { (min, max) } else { hull(&moved(instant)) };
        (min - reach, max + reach)
    });
    if !shows {
        return;
    }
    let camera = &job.frame.camera;
    let split = |along_u: bool, waiting: &mut BinaryHeap<Waiting>| {
        let halves = |r: [f32; 2]| [[r[0], 0.5 * (r[0] + r[1])], [0.5 * (r[0] + r[1]), r[1]]];
        let (depth, whole) = (piece.depth + 1, [0.0, 1.0]);
        for half in 0..2 {
            let part = |r: [f32; 2], divided: bool| if divided { halves(r)[half] } else { r };
            let [u, v] = [(whole, along_u), (whole, !along_u)].map(|(r, divided)| part(r, divided));
            let z = hull(&sub_patch(&p, Piece { u, v, depth })).0.z - reach;
            let piece = Piece { u: part(piece.u, along_u), v: part(piece.v, !along_u), depth };
            waiting.push(Waiting { z, item, patch: k as u32, piece });
        }
    };
    let row = |j: usize| path(&[p[4 * j], p[4 * j + 1], p[4 * j + 2], p[4 * j + 3]]);
    let column = |i: usize| path(&[p[i], p[4 + i], p[8 + i], p[12 + i]]);
    let last = job.instants[1..].last().map(&moved);
    let crosses = camera.perspective && min.z <= camera.near;
    if crosses {
        // What displacement may move about is not worth looking at more closely than that; nor, of what moves into view, less
        // than half a pixel there.
        let (u, v) = (row(0).max(row(3)), column(0).max(column(3)));
        let into_view = last.map_or(0.0, |last| 0.5 / camera.pixels_at(hull(&last).0.z));
        if piece.depth < DEEPEST && u.max(v) > into_view.max(0.5 * reach) {
            split(u >= v, &mut job.waiting);
            job.stats.splits += 1;
        }
        return;
    }
    let step = view.attributes.shading_rate.sqrt();
    // Nearer than it may be displaced, its size on the raster says nothing.
    let ahead = p.map(|p| Vec3::new(p.x, p.y, p.z.max(reach)));
    let raster = ahead.map(|p| camera.project(p).extend(0.0));
    // A curve that turns towards the eye is short on the raster but needs points for its depth, up to a limit.
    // What is blurred needs fewer; an edge's blur is its own, so that neighbours agree.
    let blur = |k: usize| {
        let shift = last.map_or(0.0, |last| camera.shift(ahead[k], last[k]));
        shift + 2.0 * camera.confusion(p[k].z).abs()
    };
    let blurred = last.is_some() || camera.has_lens();
    let pixels = |a: usize, stride: usize| {
        let leg = [a, a + stride, a + 2 * stride, a + 3 * stride];
        let fine = path(&leg.map(|k| raster[k])) / step;
        if !blurred {
            return fine;
        }
        // A bent edge keeps its shape however much it is blurred.
        let coarser = coarsening(leg.iter().map(|k| blur(*k)).fold(f32::INFINITY, f32::min));
        (fine / coarser).max(fine.min(4.0))
    };
    let rate = |length: f32| (length.clamp(1.0, 65536.0).ceil() as usize).next_power_of_two();
    let rows = [0, 1, 2, 3].map(|j| rate(pixels(4 * j, 1)));
    let columns = [0, 1, 2, 3].map(|i| rate(pixels(i, 4)));
    // An edge that is not blurred is halved where it is long, as far as that goes, so that neighbours find the same points on it
    // however they are split.
    let halved = |a: usize, stride: usize| {
        let mut points = 1 | 1 << TILE;
        let curve = [a, a + stride, a + 2 * stride, a + 3 * stride].map(|k| ahead[k]);
        let length = |c: &[Vec3; 4]| path(&c.map(|p| camera.project(p).extend(0.0))) / step;
        halve(curve, 0, TILE, &length, &mut points).then_some(points)
    };
    let edges = [(0, 1), (12, 1), (0, 4), (3, 4)].map(|(a, stride)| if blurred { None } else { halved(a, stride) });
    let own = |edge: usize, rate: usize| match edges[edge] {
        Some(points) => segments(points),
        None if blurred => rate,
        None => rate.max(2 * TILE),
    };
    let most = |a: usize, inner: [usize; 2], b: usize| a.max(inner[0]).max(inner[1]).max(b);
    let nu = most(own(0, rows[0]), [rows[1], rows[2]], own(1, rows[3]));
    let nv = most(own(2, columns[0]), [columns[1], columns[2]], own(3, columns[3]));
    let uneven = camera.perspective && max.z > 2.0 * min.z;
    let deep = piece.depth >= DEEPEST;
    if !deep && (nu > TILE || nv > TILE || (uneven && nu * nv > 4)) {
        job.stats.splits += 1;
        return split(nu >= nv, &mut job.waiting);
    }
    let (nu, nv) = (nu.min(TILE), nv.min(TILE));
    let apron = view.attributes.displacement.is_some();
    dice(job, view, patch, piece, nu, nv, apron);
    let kept = |n: usize, edge: usize, rate: usize| {
        let every = (n / rate.min(n)).max(1);
        let is_kept =
            |k: usize| edges[edge].map_or(k.is_multiple_of(every), |points| points >> (k * TILE / n) & 1 == 1);
        (0..=n).filter(|k| is_kept(*k)).fold(0u32, |bits, k| bits | 1 << k)
    };
    let keep = [kept(nu, 0, rows[0]), kept(nu, 1, rows[3]), kept(nv, 2, columns[0]), kept(nv, 3, columns[3])];
    finish(job, item, view, &Diced { apron, keep }, reach);
}

/// How much wider micropolygons may be that are blurred over so many pixels.
pub fn coarsening(blur: f32) -> f32 {
    1.0 + blur / 5.0
}

/// Equal segments of an edge that have all these points of `TILE` at their ends.
fn segments(points: u32) -> usize {
    let finest = (1..=TILE).filter(|k| points >> k & 1 == 1).map(|k| k.trailing_zeros()).min();
    TILE >> finest.unwrap_or(0)
}

/// Halve a curve from place `lo` to `hi` of an edge of `TILE` where it is longer than 1, and each half likewise, and note the
/// places in between; false if there are not enough of them.
fn halve(curve: [Vec3; 4], lo: usize, hi: usize, length: &impl Fn(&[Vec3; 4]) -> f32, points: &mut u32) -> bool {
    if !(length(&curve) > 1.0) {
        return true;
    }
    if hi - lo == 1 {
        return false;
    }
    let middle = (lo + hi) / 2;
    *points |= 1 << middle;
    let [a, b, c, d] = curve;
    let (ab, bc, cd) = (0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + d));
    let (abc, bcd) = (0.5 * (ab + bc), 0.5 * (bc + cd));
    let m = 0.5 * (abc + bcd);
    halve([a, ab, abc, m], lo, middle, length, points) && halve([m, bcd, cd, d], middle, hi, length, points)
}

/// Length of a control polygon's leg.
fn path(p: &[Vec3; 4]) -> f32 {
    (p[1] - p[0]).length() + (p[2] - p[1]).length() + (p[3] - p[2]).length()
}

/// Control points of a piece, by de Casteljau's construction in each direction.
fn sub_patch(p: &[Vec3; 16], piece: Piece) -> [Vec3; 16] {
    let mut out = *p;
    for j in 0..4 {
        let row = sub_curve([out[4 * j], out[4 * j + 1], out[4 * j + 2], out[4 * j + 3]], piece.u);
        out[4 * j..4 * j + 4].copy_from_slice(&row);
    }
    for i in 0..4 {
        let column = sub_curve([out[i], out[4 + i], out[8 + i], out[12 + i]], piece.v);
        (0..4).for_each(|j| out[4 * j + i] = column[j]);
    }
    out
}

/// Bézier points of the part of a curve between two parameters: its blossom.
fn sub_curve(p: [Vec3; 4], [a, b]: [f32; 2]) -> [Vec3; 4] {
    let blossom = |t: [f32; 3]| {
        let mut q = p;
        for (level, t) in t.into_iter().enumerate() {
            for i in 0..3 - level {
                q[i] = q[i].lerp(q[i + 1], t);
            }
        }
        q[0]
    };
    [blossom([a, a, a]), blossom([a, a, b]), blossom([a, b, b]), blossom([b, b, b])]
}

fn dice(job: &mut Job<'_>, view: &ItemView<'_>, patch: &Patch, piece: Piece, nu: usize, nv: usize, apron: bool) {
    let ring = apron as i32;
    // All points are of the whole patch at dyadic parameters, so that grids that share an edge compute the same points.
    let lines = |r: [f32; 2], n: usize| {
        (-ring..=n as i32 + ring).map(move |k| r[0] + (r[1] - r[0]) * k as f32 / n as f32).collect::<Vec<f32>>()
    };
    let (us, vs) = (lines(piece.u, nu), lines(piece.v, nv));
    let normals = glam::Mat3::from_mat4(view.to_world).inverse().transpose();
    // Normals that the scene gives go before the patch's own.
    let given = patch.varying.iter().find(|(name, v)| name == "N" && v.len() == 12).map(|(_, v)| v.as_slice());
    let mirrored = view.to_world.determinant() < 0.0;
    let sign = if view.attributes.reversed { -1.0 } else { 1.0 };
    let points = &mut job.grid.points;
    (points.nu, points.nv) = (us.len(), vs.len());
    points.orientation = if mirrored { -sign } else { sign };
    let n = points.n();
    let mut p = std::mem::take(points.refill("P"));
    let mut normal = std::mem::take(points.refill("N"));
    p.resize(3 * n, 0.0);
    normal.resize(3 * n, 0.0);
    let along: Vec<([f32; 4], [f32; 4])> = us.iter().map(|u| (bernstein(*u), bernstein_slope(*u))).collect();
    let mix = |c: &[Vec3; 4], w: &[f32; 4]| c[0] * w[0] + c[1] * w[1] + c[2] * w[2] + c[3] * w[3];
    // What is flat has one normal, but for the tips of triangles.
    let even = (patch.flat && given.is_none()).then(|| normals * patch.normal(0.5, 0.5));
    let even = even.map(|m| m.normalize_or_zero() * sign);
    for (j, v) in vs.iter().enumerate() {
        // The row as a curve along u, and its slope along v.
        let (bv, dv) = (bernstein(*v), bernstein_slope(*v));
        let column = |i: usize, w: &[f32; 4]| mix(&[0, 4, 8, 12].map(|row| patch.p[row + i]), w);
        let (row, rise) = ([0, 1, 2, 3].map(|i| column(i, &bv)), [0, 1, 2, 3].map(|i| column(i, &dv)));
        for (i, (u, (bu, du))) in us.iter().zip(&along).enumerate() {
            let k = j * us.len() + i;
            let q = view.to_world.transform_point3(mix(&row, bu));
            let m = even.unwrap_or_else(|| {
                let own = given
                    .map_or_else(|| patch.normal_of(mix(&row, du), mix(&rise, bu), *u, *v), |n| normal_at(n, *u, *v));
                (normals * own).normalize_or_zero() * sign
            });
            (p[k], p[n + k], p[2 * n + k]) = (q.x, q.y, q.z);
            (normal[k], normal[n + k], normal[2 * n + k]) = (m.x, m.y, m.z);
        }
    }
    *points.refill("P") = p;
    *points.refill("N") = normal;
    deform(job, view, patch, [&us, &vs], ring as usize);
    if job.frame.needs_parameters(view) {
        let points = &mut job.grid.points;
        for (name, corner) in [
            ("u", patch.uv.map(|c| c[0])),
            ("v", patch.uv.map(|c| c[1])),
            ("s", patch.st.map(|c| c[0])),
            ("t", patch.st.map(|c| c[1])),
        ] {
            let values = vs.iter().flat_map(|v| us.iter().map(move |u| bilinear(corner, *u, *v)));
            points.refill(name).extend(values);
        }
    }
    job.trimmed.clear();
    if let Some(trim) = &patch.trim {
        let inner = |n: usize| (0..n).map(move |k| (k as f32 + 0.5) / n as f32);
        for v in inner(nv) {
            let v = piece.v[0] + (piece.v[1] - piece.v[0]) * v;
            job.trimmed.extend(inner(nu).map(|u| {
                let u = piece.u[0] + (piece.u[1] - piece.u[0]) * u;
                let at = |k: usize| bilinear(patch.uv.map(|c| c[k]), u, v);
                !trim.keeps(at(0), at(1))
            }));
        }
    }
    job.varying.clear();
    for (name, values) in patch.varying.iter().filter(|(name, _)| name != "N") {
        let width = values.len() / 4;
        let corner = |c: usize| [0, 1, 2, 3].map(|k| values[k * width + c]);
        // The apron is dropped from globals alone: variables are made without it.
        let inner = |x: &[f32]| x[ring as usize..x.len() - ring as usize].to_vec();
        let (us, vs) = (inner(&us), inner(&vs));
        let all = (0..width).flat_map(|c| {
            vs.iter()
                .flat_map(|v| us.iter().map(|u| bilinear(corner(c), *u, *v)).collect::<Vec<_>>())
                .collect::<Vec<_>>()
        });
        job.varying.push((name.clone(), all.collect()));
    }
    job.uniform.clear();
    job.uniform.extend(patch.uniform.iter().cloned());
}

/// How far the points of the grid, without the apron, are from where they were first, at each later moment.
fn deform(job: &mut Job<'_>, view: &ItemView<'_>, patch: &Patch, [us, vs]: [&[f32]; 2], ring: usize) {
    job.deformed.clear();
    if patch.moves.is_empty() {
        return;
    }
    let (us, vs) = (&us[ring..us.len() - ring], &vs[ring..vs.len() - ring]);
    let n = us.len() * vs.len();
    for instant in &job.instants[1..] {
        let moved = later(patch.p, &patch.moves, instant.time);
        let mut all = vec![0.0; 3 * n];
        for (k, (v, u)) in vs.iter().flat_map(|v| us.iter().map(move |u| (*v, *u))).enumerate() {
            let off = view.to_world.transform_vector3(point_of(&moved, u, v) - patch.at(u, v));
            (all[k], all[n + k], all[2 * n + k]) = (off.x, off.y, off.z);
        }
        job.deformed.push(all);
    }
}

/// The normal between those of the corners.
fn normal_at(corners: &[f32], u: f32, v: f32) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|c| bilinear([0, 1, 2, 3].map(|k| corners[3 * k + c]), u, v)))
}
