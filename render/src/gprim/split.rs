//! Splitting of bicubic patches to pieces that make a grid each.
//!
//! A patch is split in its parameters until a piece is before the near plane, even in depth, and small enough for a grid. A
//! grid's edge is diced by what the edge itself measures, halved where it is long and each half again, and points that the edge
//! does not have so are put onto the line between those that it has: neighbours that share an edge agree on it, whatever their
//! insides need and however they are split.

use crate::gprim::bound::displacement_reach;
use crate::gprim::grid::{Grid, Origin, Sink, Subject};
use crate::gprim::patch::{Piece, dice};
use crate::gprim::quadric::whole_sphere;
use crate::scene::camera::Camera;
use crate::scene::interpolation::cubic_part;
use crate::scene::motion::{Instant, later};
use crate::scene::patch::Patch;
use crate::scene::shape::Shape;
use crate::scene::source::{Item, ItemView};
use glam::Vec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Micropolygons along a grid's edge.
const TILE: usize = 16;

/// Splits after which a piece that still crosses the near plane is given up.
const DEEPEST: u32 = 40;

/// The most segments that a row or column of control points asks for.
const MOST_SEGMENTS: usize = 65536;

/// Depths of a piece's farthest point and its nearest whose ratio is so great that the piece is split in depth.
const CLOSE: f32 = 16.0;

/// How much coarser than a pixel's width at its distance a surface is diced that the camera does not see.
const UNSEEN: f32 = 4.0;

/// The part of its pixels, were it turned to the eye, that a displaced surface is diced for at least.
const ASKEW: f32 = 0.5;

/// Splits after which such a piece is diced as it is.
const DEEPEST_UNSEEN: u32 = 24;

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

    /// What its turn comes by: its least depth, the item, the patch, and where in that it begins.
    pub fn turn(&self) -> (f32, Item, u32, f32) {
        (self.z, self.item, self.patch, self.start())
    }

    fn start(&self) -> f32 {
        self.piece.u[0] + 2.0 * self.piece.v[0]
    }

    /// Whether its turn comes before that of an item whose least depth is `z`.
    fn before(&self, z: f32, item: Item) -> bool {
        self.z.total_cmp(&z).then((self.item.source, self.item.index).cmp(&(item.source, item.index))).is_lt()
    }
}

impl Ord for Waiting {
    /// The nearest is the greatest.
    fn cmp(&self, o: &Waiting) -> Ordering {
        o.z.total_cmp(&self.z).then(o.key().cmp(&self.key())).then(o.start().total_cmp(&self.start()))
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

/// Pieces that wait for their turn, the nearest first.
#[derive(Default)]
pub struct Queue {
    waiting: BinaryHeap<Waiting>,
    /// Pieces that were split.
    pub splits: u64,
}

impl Queue {
    /// The next piece, if its turn comes before that of an item with its least depth.
    pub fn pop_before(&mut self, next: Option<&(f32, Item)>) -> Option<Waiting> {
        self.waiting.peek().filter(|w| next.is_none_or(|(z, item)| w.before(*z, *item)))?;
        self.waiting.pop()
    }

    /// Let pieces wait for their turn.
    pub fn extend(&mut self, pieces: impl IntoIterator<Item = Waiting>) {
        self.waiting.extend(pieces);
    }

    /// Number of pieces that wait.
    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    /// The piece whose turn comes first.
    pub fn first(&self) -> Option<Waiting> {
        self.waiting.peek().copied()
    }

    /// The least depth of the pieces that wait.
    pub fn least_depth(&self) -> Option<f32> {
        self.waiting.peek().map(|w| w.z)
    }

    /// The items whose pieces wait.
    pub fn items(&self) -> impl Iterator<Item = Item> + '_ {
        self.waiting.iter().map(|w| w.item)
    }

    /// All pieces that wait, the nearest first, which do so no more.
    pub fn take(&mut self) -> Vec<Waiting> {
        let mut all = std::mem::take(&mut self.waiting).into_sorted_vec();
        all.reverse();
        all
    }

    /// Split a piece of patch `k` of an item, whose control points are `p` in camera space, into halves that wait.
    fn split(&mut self, (item, k): (Item, usize), p: &[Vec3; 16], piece: Piece, reach: f32, along_u: bool) {
        let halves = |r: [f32; 2]| [[r[0], 0.5 * (r[0] + r[1])], [0.5 * (r[0] + r[1]), r[1]]];
        let (depth, whole) = (piece.depth + 1, [0.0, 1.0]);
        for half in 0..2 {
            let part = |r: [f32; 2], divided: bool| if divided { halves(r)[half] } else { r };
            let [u, v] = [(whole, along_u), (whole, !along_u)].map(|(r, divided)| part(r, divided));
            let z = hull(&sub_patch(p, Piece { u, v, depth })).0.z - reach;
            let piece = Piece { u: part(piece.u, along_u), v: part(piece.v, !along_u), depth };
            self.waiting.push(Waiting { z, item, patch: k as u32, piece });
        }
        self.splits += 1;
    }
}

/// Dice the patches of an item; what is too large is split and waits in the queue.
pub fn dice_all(subject: &Subject<'_>, patches: &[Patch], queue: &mut Queue, grid: &mut Grid, sink: &mut impl Sink) {
    for patch in patches.iter().enumerate() {
        dice_or_split(subject, patch, Piece { u: [0.0, 1.0], v: [0.0, 1.0], depth: 0 }, queue, grid, sink);
    }
}

/// Dice a piece whose turn has come.
pub fn dice_waiting(
    subject: &Subject<'_>,
    waiting: &Waiting,
    queue: &mut Queue,
    grid: &mut Grid,
    sink: &mut impl Sink,
) {
    let patches = match subject.view.shape {
        Shape::Patches(patches, _) => patches,
        Shape::Sphere => whole_sphere(),
    };
    let k = waiting.patch as usize;
    dice_or_split(subject, (k, &patches[k]), waiting.piece, queue, grid, sink);
}

/// Dice a piece of patch `k` of an item, or split it.
fn dice_or_split(
    subject: &Subject<'_>,
    (k, patch): (usize, &Patch),
    piece: Piece,
    queue: &mut Queue,
    grid: &mut Grid,
    sink: &mut impl Sink,
) {
    let Subject { view, camera, instants, .. } = *subject;
    let size = patch.p.iter().map(|p| (*p - patch.p[0]).length()).fold(0.0, f32::max);
    let scale = view.to_world.x_axis.truncate().length();
    let reach = displacement_reach(view, size * scale);
    let to_camera = camera.to_camera * view.to_world;
    let own = sub_patch(&patch.p, piece);
    let p = own.map(|p| to_camera.transform_point3(p));
    let (min, max) = hull(&p);
    // What is wholly behind the near plane as the shutter opens is not seen, wherever it moves.
    if !min.is_finite() || !max.is_finite() {
        return;
    }
    let unseen = Unseen { k, patch, piece, p: &p, reach };
    if max.z + reach < camera.near {
        return unseen.dice(subject, queue, grid, sink);
    }
    // Control points in camera space at a moment.
    let moved = |instant: &Instant| {
        let own =
            if patch.moves.is_empty() { own } else { sub_patch(&later(patch.p, &patch.moves, instant.time), piece) };
        let m = instant.to_camera * view.to_world;
        own.map(|p| m.transform_point3(p))
    };
    let shows = subject.may_show(sink, |instant| {
        let (min, max) = if instant.time == 0.0 { (min, max) } else { hull(&moved(instant)) };
        (min - reach, max + reach)
    });
    if !shows {
        return unseen.dice(subject, queue, grid, sink);
    }
    let last = instants[1..].last().map(&moved);
    if camera.perspective && min.z <= camera.near {
        // What displacement may move about is not worth looking at more closely than that; nor less than half a pixel, at the near
        // plane or where it moves into view.
        let row = |j: usize| path(&[p[4 * j], p[4 * j + 1], p[4 * j + 2], p[4 * j + 3]]);
        let column = |i: usize| path(&[p[i], p[4 + i], p[8 + i], p[12 + i]]);
        let (u, v) = (row(0).max(row(3)), column(0).max(column(3)));
        let into_view = last.map_or(0.0, |last| 0.5 / camera.pixels_at(hull(&last).0.z));
        if piece.depth < DEEPEST
            && can_halve(piece, u >= v)
            && u.max(v) > into_view.max(0.5 * reach).max(0.5 / camera.pixels_at(camera.near))
        {
            return queue.split((subject.item, k), &p, piece, reach, u >= v);
        }
        return unseen.dice(subject, queue, grid, sink);
    }
    let fineness = Fineness::of(subject, &p, last.as_ref(), reach);
    let [nu, nv] = fineness.segments();
    let uneven = camera.perspective && max.z > 2.0 * min.z;
    let deep = piece.depth >= DEEPEST || !(can_halve(piece, true) && can_halve(piece, false));
    if !deep && (nu > TILE || nv > TILE || (uneven && nu * nv > 4)) {
        // What comes close to the eye is large there whichever way it is split: it is first split where it goes away from there.
        let comes_close = camera.perspective && max.z > CLOSE * min.z;
        let along_u = match comes_close {
            true => depths(&p, 4, 1) >= depths(&p, 1, 4),
            // Of what is too long to count either way, too: all pieces that meet in a pole would be seen.
            false if nu == nv && nu == MOST_SEGMENTS => fineness.longest[0] >= fineness.longest[1],
            false => nu >= nv,
        };
        return queue.split((subject.item, k), &p, piece, reach, along_u);
    }
    dice_piece(subject, (k, patch), piece, &fineness, reach, grid, sink);
}

/// Whether there is a number between the ends of a piece's parameters along u or v.
fn can_halve(piece: Piece, along_u: bool) -> bool {
    let [from, to] = if along_u { piece.u } else { piece.v };
    let middle = 0.5 * (from + to);
    from < middle && middle < to
}

/// Dice a piece of patch `k` of an item that is small enough for a grid.
fn dice_piece(
    subject: &Subject<'_>,
    (k, patch): (usize, &Patch),
    piece: Piece,
    fineness: &Fineness,
    reach: f32,
    grid: &mut Grid,
    sink: &mut impl Sink,
) {
    let size = fineness.segments().map(|n| n.min(TILE));
    grid.apron = subject.view.attributes.displacement.is_some();
    dice(subject, patch, piece, size, grid);
    grid.keep = fineness.kept(size);
    (grid.reach, grid.tile) = (reach, None);
    grid.origin = Some(Origin { patch: k as u32, u: piece.u, v: piece.v });
    sink.take(grid);
}

/// A piece of patch `k` of an item that the camera does not see, with its control points in camera space.
struct Unseen<'a> {
    k: usize,
    patch: &'a Patch,
    piece: Piece,
    p: &'a [Vec3; 16],
    reach: f32,
}

impl Unseen<'_> {
    /// Dice it or split it for a sink that takes it all the same.
    fn dice(&self, subject: &Subject<'_>, queue: &mut Queue, grid: &mut Grid, sink: &mut impl Sink) {
        if !sink.takes_unseen() {
            return;
        }
        let Unseen { k, patch, piece, p, reach } = *self;
        let fineness = Fineness::unseen(subject, p);
        let [nu, nv] = fineness.segments();
        if piece.depth < DEEPEST_UNSEEN && (nu > TILE || nv > TILE) {
            return queue.split((subject.item, k), p, piece, reach, nu >= nv);
        }
        dice_piece(subject, (k, patch), piece, &fineness, reach, grid, sink);
    }
}

/// How far a surface may be displaced.
#[derive(Clone, Copy)]
enum Bound {
    /// World units.
    World(f32),
    /// In parts of its size.
    Part(f32),
}

impl Bound {
    /// Of a primitive; none if it is not displaced.
    fn of(view: &ItemView<'_>) -> Option<Bound> {
        view.attributes.displacement.as_ref()?;
        // What a patch alone says would part its edges from its neighbours'.
        Some(match view.attributes.displacement_bound {
            None => Bound::Part(displacement_reach(view, 1.0)),
            Some(_) => Bound::World(displacement_reach(view, 0.0)),
        })
    }

    /// The pixels that a curve in camera space is diced for; as it is, it has `pixels`. Of a surface seen askew, displacement turns parts
    /// towards the eye: these are as long as the surface is whichever way it is turned, at most by how far the displacement
    /// may lengthen each pixel.
    fn lengthened(self, camera: &Camera, c: &[Vec3; 4], pixels: f32) -> f32 {
        let own = path(c);
        let reach = match self {
            Bound::World(reach) => reach,
            Bound::Part(part) => part * own,
        };
        let scale = camera.pixels_at(c.iter().map(|p| p.z).fold(f32::INFINITY, f32::min));
        pixels.max((ASKEW * own * scale).min(pixels * (0.5 + reach * scale)))
    }
}

/// How finely a piece is diced: what each row and column of its control points asks for, and each edge.
struct Fineness {
    /// Segments that the rows of control points ask for.
    rows: [usize; 4],
    /// Segments that the columns ask for.
    columns: [usize; 4],
    /// Points of the edges at the first row, last row, first column, last column, where these are found by halving.
    edges: [Option<u32>; 4],
    /// The longest of the rows and of the columns, in micropolygons.
    longest: [f32; 2],
    /// Whether the piece may be blurred, by motion or by the lens.
    blurred: bool,
}

impl Fineness {
    /// Measure a piece of control points `p` in camera space; `last` are those as the shutter closes, if they move.
    fn of(subject: &Subject<'_>, p: &[Vec3; 16], last: Option<&[Vec3; 16]>, reach: f32) -> Fineness {
        let Subject { view, camera, .. } = *subject;
        let step = view.attributes.shading_rate.sqrt();
        // Nearer than it may be displaced, its size on the raster says nothing.
        let ahead = p.map(|p| Vec3::new(p.x, p.y, p.z.max(reach)));
        // A curve that turns towards the eye is short on the raster but needs points for its depth, up to a limit.
        // What is blurred needs fewer; an edge's blur is its own, so that neighbours agree.
        let blur = |k: usize| {
            let shift = last.map_or(0.0, |last| camera.shift(ahead[k], last[k]));
            shift + 2.0 * camera.confusion(p[k].z).abs()
        };
        let blurred = last.is_some() || camera.has_lens();
        let on_raster = |p: Vec3| camera.project(p).extend(0.0);
        let (raster, bound) = (ahead.map(on_raster), Bound::of(view));
        let lengthened =
            |c: &[Vec3; 4], flat: f32| bound.map_or(flat, |bound| bound.lengthened(camera, c, flat)) / step;
        let length = |c: &[Vec3; 4]| lengthened(c, path(&c.map(on_raster)));
        let pixels = |a: usize, stride: usize| {
            let leg = [a, a + stride, a + 2 * stride, a + 3 * stride];
            let fine = lengthened(&leg.map(|k| ahead[k]), path(&leg.map(|k| raster[k])));
            if !blurred {
                return fine;
            }
            // A bent edge keeps its shape however much it is blurred.
            let coarser = coarsening(leg.iter().map(|k| blur(*k)).fold(f32::INFINITY, f32::min));
            (fine / coarser).max(fine.min(4.0))
        };
        let rate = |length: f32| (length.clamp(1.0, MOST_SEGMENTS as f32).ceil() as usize).next_power_of_two();
        // An edge that is not blurred is halved where it is long, as far as that goes, so that neighbours find the same points on
        // it however they are split.
        let halved = |a: usize, stride: usize| {
            let mut points = 1 | 1 << TILE;
            let curve = [a, a + stride, a + 2 * stride, a + 3 * stride].map(|k| ahead[k]);
            halve(curve, 0, TILE, &length, &mut points).then_some(points)
        };
        let (rows, columns) = ([0, 1, 2, 3].map(|j| pixels(4 * j, 1)), [0, 1, 2, 3].map(|i| pixels(i, 4)));
        Fineness {
            rows: rows.map(rate),
            columns: columns.map(rate),
            longest: [rows, columns].map(|all| all.into_iter().fold(0.0, f32::max)),
            edges: [(0, 1), (12, 1), (0, 4), (3, 4)].map(|(a, stride)| if blurred { None } else { halved(a, stride) }),
            blurred,
        }
    }

    /// Measure a piece that the camera does not see, for rays: by its distance from the eye.
    fn unseen(subject: &Subject<'_>, p: &[Vec3; 16]) -> Fineness {
        let Subject { view, camera, .. } = *subject;
        let step = view.attributes.shading_rate.sqrt() * UNSEEN;
        let length = |c: &[Vec3; 4]| {
            let distance = c.iter().map(|p| p.length()).fold(f32::INFINITY, f32::min);
            path(c) * camera.pixels_at(distance) / step
        };
        let leg = |a: usize, stride: usize| [a, a + stride, a + 2 * stride, a + 3 * stride].map(|k| p[k]);
        let rate = |c: [Vec3; 4]| (length(&c).clamp(1.0, 65536.0).ceil() as usize).next_power_of_two();
        let halved = |c: [Vec3; 4]| {
            let mut points = 1 | 1 << TILE;
            halve(c, 0, TILE, &length, &mut points).then_some(points)
        };
        Fineness {
            longest: [0.0; 2],
            rows: [0, 1, 2, 3].map(|j| rate(leg(4 * j, 1))),
            columns: [0, 1, 2, 3].map(|i| rate(leg(i, 4))),
            edges: [(0, 1), (12, 1), (0, 4), (3, 4)].map(|(a, stride)| halved(leg(a, stride))),
            blurred: false,
        }
    }

    /// Segments that the piece needs in each direction, which may be more than a grid has.
    fn segments(&self) -> [usize; 2] {
        let own = |edge: usize, rate: usize| match self.edges[edge] {
            Some(points) => segments(points),
            None if self.blurred => rate,
            None => rate.max(2 * TILE),
        };
        let most = |a: usize, inner: [usize; 2], b: usize| a.max(inner[0]).max(inner[1]).max(b);
        let (rows, columns) = (self.rows, self.columns);
        [
            most(own(0, rows[0]), [rows[1], rows[2]], own(1, rows[3])),
            most(own(2, columns[0]), [columns[1], columns[2]], own(3, columns[3])),
        ]
    }

    /// The points that are kept of each edge of a grid of this size ([`Grid::keep`]).
    fn kept(&self, [nu, nv]: [usize; 2]) -> [u32; 4] {
        let kept = |n: usize, edge: usize, rate: usize| {
            let every = (n / rate.min(n)).max(1);
            let is_kept =
                |k: usize| self.edges[edge].map_or(k.is_multiple_of(every), |points| points >> (k * TILE / n) & 1 == 1);
            (0..=n).filter(|k| is_kept(*k)).fold(0u32, |bits, k| bits | 1 << k)
        };
        let (rows, columns) = (self.rows, self.columns);
        [kept(nu, 0, rows[0]), kept(nu, 1, rows[3]), kept(nv, 2, columns[0]), kept(nv, 3, columns[3])]
    }
}

/// The factor by which a micropolygon's edges may lengthen where motion or the lens blurs it over `blur` pixels.
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

/// The box of control points.
fn hull(p: &[Vec3; 16]) -> (Vec3, Vec3) {
    p.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(*p), hi.max(*p)))
}

/// The greatest change of depth along a leg of control points, `stride` apart, of the four that begin `next` apart.
fn depths(p: &[Vec3; 16], next: usize, stride: usize) -> f32 {
    let change = |leg: usize| {
        let of = [0, 1, 2, 3].map(|k| p[leg * next + k * stride].z);
        of.iter().copied().fold(f32::NEG_INFINITY, f32::max) - of.iter().copied().fold(f32::INFINITY, f32::min)
    };
    (0..4).map(change).fold(0.0, f32::max)
}

/// Length of a control polygon's leg.
fn path(p: &[Vec3; 4]) -> f32 {
    (p[1] - p[0]).length() + (p[2] - p[1]).length() + (p[3] - p[2]).length()
}

/// Control points of a piece, by de Casteljau's construction in each direction.
fn sub_patch(p: &[Vec3; 16], piece: Piece) -> [Vec3; 16] {
    let mut out = *p;
    for j in 0..4 {
        let row = cubic_part([out[4 * j], out[4 * j + 1], out[4 * j + 2], out[4 * j + 3]], piece.u);
        out[4 * j..4 * j + 4].copy_from_slice(&row);
    }
    for i in 0..4 {
        let column = cubic_part([out[i], out[4 + i], out[8 + i], out[12 + i]], piece.v);
        (0..4).for_each(|j| out[4 * j + i] = column[j]);
    }
    out
}
