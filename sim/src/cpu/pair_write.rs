//! Write every pair of shapes whose boxes overlap, once: the bin that holds the least corner of the overlap claims it. (The
//! paper takes the overlap's midpoint; the least corner's bin follows from the shapes' own without arithmetic.)
//! in   position           [n_bodies]       m
//! in   orientation        [n_bodies]
//! in   fat_aabb           [n_shapes]       m, world
//! in   bin_level          [n_shapes]
//! in   bin_low            [n_shapes]
//! in   bin                [n_bin_pairs]    sorted
//! in   bin_shape          [n_bin_pairs]
//! in   bin_start          [n_active_bins]
//! out  sphere_pair_start  [n_tiles + 2]    pairs of spheres of each tile, and of those in none
//! out  sphere_pair        [n_sphere_pairs] the lower shape first
//! out  other_pair_start   [n_tiles + 2]    the same of other pairs
//! out  other_pair         [n_other_pairs]  the lower shape first, and the triangle if one is a mesh or a height field
//! Source: paper §3, stages 7–9.
//!
//! Shapes of different levels are found by the finer one, in the bins of the coarser level that it touches. Surfaces (planes,
//! meshes, height fields) are few and are asked shape by shape.
//!
//! Bodies belong to the brick of bins where their boxes begin, which is their tile. A pair within one is found there. Pairs
//! between tiles go to a second round of tiles, moved by half a brick along each axis, and the few that both rounds cut come
//! last: a solver can work on the tiles of a round side by side, and finds what it asks for near together.

use super::bin_emit::{BinGrid, Bins};
use super::collide::surface_of;
use crate::aabb::Aabb;
use crate::model::Model;
use crate::rows::{ALONE, CHUNK, cut, fill_rows};
use crate::shape::ShapeKind;
use crate::state::State;
use glam::{DMat3, DVec3, Vec3A, Vec4};
use rayon::prelude::*;
use std::ops::Range;

/// Pairs of shapes of a tile while they are found, the lower index first.
#[derive(Clone, Default)]
struct Candidates {
    /// Of two spheres.
    spheres: Vec<[u32; 2]>,
    /// Of others, and the triangle if one is a mesh or a height field.
    others: Vec<[u32; 3]>,
}

impl Candidates {
    #[inline]
    fn push(&mut self, model: &Model, [s, t, triangle]: [u32; 3]) {
        if [s, t].map(|s| model.shape_kind[s as usize]) == [ShapeKind::Sphere; 2] {
            self.spheres.push([s, t]);
        } else {
            self.others.push([s, t, triangle]);
        }
    }
}

/// The pairs of shapes that may touch, by tiles: those of each tile of the first round, of each of the second, and of neither.
#[derive(Default)]
pub struct Pairs {
    /// Tiles of the first round.
    pub n_first: usize,
    /// First pair of spheres of each tile, of those in none, and their end (n_tiles + 2).
    pub sphere_start: Vec<u32>,
    /// Pairs of spheres, the lower shape first (n_sphere_pairs).
    pub spheres: Vec<[u32; 2]>,
    /// First other pair of each tile, of those in none, and their end (n_tiles + 2).
    pub other_start: Vec<u32>,
    /// Other pairs, the lower shape first, and the triangle if one is a mesh or a height field (n_other_pairs).
    pub others: Vec<[u32; 3]>,
}

impl Pairs {
    /// The pairs of spheres of a tile.
    pub fn spheres_of(&self, tile: usize) -> &[[u32; 2]] {
        &self.spheres[self.sphere_start[tile] as usize..self.sphere_start[tile + 1] as usize]
    }

    /// The other pairs of a tile.
    pub fn others_of(&self, tile: usize) -> &[[u32; 3]] {
        &self.others[self.other_start[tile] as usize..self.other_start[tile + 1] as usize]
    }

    /// Number of tiles, and one for what is in none.
    pub fn n_tiles(&self) -> usize {
        self.sphere_start.len() - 1
    }

    /// Take what was found tile by tile: count, scan, write.
    fn take(&mut self, found: Vec<Candidates>, n_first: usize) {
        self.n_first = n_first;
        flatten(&found, |c| &c.spheres, &mut self.sphere_start, &mut self.spheres);
        flatten(&found, |c| &c.others, &mut self.other_start, &mut self.others);
    }
}

/// Write ragged rows as compressed rows.
fn flatten<R: Sync, T: Copy + Default + Send + Sync>(
    rows: &[R],
    items: impl Fn(&R) -> &Vec<T> + Sync,
    start: &mut Vec<u32>,
    out: &mut Vec<T>,
) {
    start.clear();
    start.extend(rows.iter().map(|row| items(row).len() as u32).chain([0]));
    let n = gpu::scan::exclusive_cpu(start) as usize;
    if n <= ALONE {
        out.clear();
        rows.iter().for_each(|row| out.extend_from_slice(items(row)));
        return;
    }
    out.resize(n, T::default());
    let parts = cut(out, rows.iter().map(|row| items(row).len()));
    parts.into_par_iter().zip(rows).for_each(|(own, row)| own.copy_from_slice(items(row)));
}

/// The tile of a body that is held in place: any.
const HELD: u32 = u32::MAX;

/// What is found in a tile. One thread uses it tile after tile.
struct Found<'a> {
    model: &'a Model,
    /// The tile of each body in both rounds (n_bodies).
    tile: &'a [[u32; 2]],
    here: u32,
    /// Pairs within the tile, and the others.
    own: Candidates,
    cut: Vec<[u32; 3]>,
}

impl Found<'_> {
    #[inline]
    fn push(&mut self, s: u32, t: u32, triangle: u32) {
        let pair = [s.min(t), s.max(t), triangle];
        let tiles = [s, t].map(|s| self.tile[self.model.shape_body[s as usize] as usize][0]);
        if tiles.iter().all(|tile| *tile == self.here || *tile == HELD) {
            self.own.push(self.model, pair);
        } else {
            self.cut.push(pair);
        }
    }
}

/// Members of a bin that are compared four at a time.
const MEMBERS: usize = 64;

/// What the stage reads.
struct Input<'a> {
    model: &'a Model,
    state: &'a State,
    aabb: &'a [Aabb],
    grid: &'a BinGrid,
    bin: &'a [u32],
    shape: &'a [u32],
    bin_start: &'a [[u32; 2]],
}

impl Input<'_> {
    /// Whether two shapes may touch at all: not of one body, not both held in place, not of bodies or groups that pass through
    /// each other. What is inactive has no box, so that nobody asks.
    #[inline]
    fn may_meet(&self, s: u32, t: u32) -> bool {
        let model = self.model;
        let (a, b) = (model.shape_body[s as usize], model.shape_body[t as usize]);
        if a == b || !(self.state.moves(a as usize) || self.state.moves(b as usize)) {
            return false;
        }
        let n_groups = model.group_names.len();
        let group = |s: u32| if n_groups == 1 { 0 } else { model.shape_group[s as usize] as usize };
        !(model.groups_pass[group(s) * n_groups + group(t)]
            || (!model.exclusions.is_empty() && model.exclusions.binary_search(&[a.min(b), a.max(b)]).is_ok()))
    }
}

/// The stage.
pub fn run(model: &Model, state: &State, bins: &Bins, pairs: &mut Pairs) {
    let aabb = state.fat_aabb.as_deref().expect("boxes from `bounds`");
    let Bins { grid, bin, shape, start } = bins;
    let input = &Input { model, state, aabb, grid, bin, shape, bin_start: start };
    let is_there = |s: usize| model.shape_kind[s].is_surface() && !state.is_inactive(model.shape_body[s] as usize);
    let surfaces: Vec<SurfaceAt> =
        (0..model.n_shapes() as u32).filter(|s| is_there(*s as usize)).map(|s| SurfaceAt::of(input, s)).collect();
    let mixed = input.grid.levels.iter().filter(|l| l.used).count() > 1;
    let tile = tiles_of(input);
    // Room for so many pairs is no small block, whose memory would not go back to the system.
    const ROOM: usize = 1 << 14;
    let found = || {
        let own = Candidates { spheres: Vec::with_capacity(ROOM), others: vec![] };
        Found { model, tile: &tile, here: NOWHERE, own, cut: vec![] }
    };

    let bricks = bricks_of(input);
    let within = bricks.par_iter().with_max_len(1).map_init(found, |found, (brick, rows)| {
        found.here = *brick;
        found.own.spheres.clear();
        found.own.others.clear();
        rows.clone().for_each(|row| in_bin(input, input.bin_start[row], found));
        (found.own.clone(), std::mem::take(&mut found.cut))
    });
    let (mut found_in, mut cut): (Vec<Candidates>, Vec<Vec<[u32; 3]>>) = within.unzip();
    // The coarser levels and the surfaces that each shape meets.
    if mixed || !surfaces.is_empty() {
        let rows =
            (0..model.n_shapes().div_ceil(CHUNK)).into_par_iter().with_max_len(1).map_init(found, |found, chunk| {
                for s in chunk * CHUNK..((chunk + 1) * CHUNK).min(model.n_shapes()) {
                    if mixed {
                        in_coarser_levels(input, s as u32, found);
                    }
                    surfaces.iter().for_each(|t| on_surface(input, s as u32, t, found));
                }
                std::mem::take(&mut found.cut)
            });
        cut.par_extend(rows);
    }

    hand_over(model, &tile, &bricks, &cut.concat(), &mut found_in);
    pairs.take(found_in, bricks.len());
}

/// Hand the pairs that were not found in their tiles over to these: to those of the first round, which are there already, to
/// those of the second, which are added, or to the row of neither, which comes last.
fn hand_over(
    model: &Model,
    tile: &[[u32; 2]],
    bricks: &[(u32, Range<usize>)],
    cut: &[[u32; 3]],
    found: &mut Vec<Candidates>,
) {
    /// Bits of a pair's place in `cut`.
    const PLACE: u32 = 30;
    let tile_of = |[s, t, _]: &[u32; 3]| {
        let [a, b] = [s, t].map(|s| tile[model.shape_body[*s as usize] as usize]);
        match (0..2).find(|round| a[*round] == b[*round] || a[*round] == HELD || b[*round] == HELD) {
            Some(round) => (round, a[round].min(b[round])),
            None => (2, 0),
        }
    };
    // Round, tile and place in one number, by which they are sorted.
    let key = |(place, pair): (usize, &[u32; 3])| {
        let (round, tile) = tile_of(pair);
        (round as u64) << (32 + PLACE) | (tile as u64) << PLACE | place as u64
    };
    let mut order: Vec<u64> = cut.par_iter().enumerate().map(key).collect();
    order.par_sort_unstable();
    let mut neither = Candidates::default();
    for run in order.chunk_by(|a, b| a >> PLACE == b >> PLACE) {
        let (round, tile) = (run[0] >> (32 + PLACE), (run[0] >> PLACE) as u32);
        let mut own = Candidates::default();
        let home = match round {
            0 => bricks.binary_search_by_key(&tile, |(brick, _)| *brick).map_or(&mut neither, |k| &mut found[k]),
            1 => &mut own,
            _ => &mut neither,
        };
        run.iter().for_each(|key| home.push(model, cut[*key as usize & ((1 << PLACE) - 1)]));
        if round == 1 {
            found.push(own);
        }
    }
    found.push(neither);
}

/// No brick.
const NOWHERE: u32 = u32::MAX - 1;

/// The tile of each body in both rounds; of a body of several shapes, the last one's.
fn tiles_of(input: &Input) -> Vec<[u32; 2]> {
    let Input { model, state, grid, .. } = input;
    let mut of_shape = vec![[0; 2]; model.n_shapes()];
    fill_rows(&mut of_shape, |s| grid.bricks_of(s));
    let mut tile = vec![[HELD; 2]; model.n_bodies()];
    for (body, of_shape) in model.shape_body.iter().zip(of_shape) {
        if state.moves(*body as usize) {
            tile[*body as usize] = of_shape;
        }
    }
    tile
}

/// The bricks that have any shape, rising, and which of the active bins are theirs.
fn bricks_of(input: &Input) -> Vec<(u32, Range<usize>)> {
    let Input { grid, bin, bin_start, .. } = input;
    let mut rows = 0;
    let of_brick = |shapes: &[u32]| {
        let brick = grid.brick(shapes[0]);
        let first = rows;
        let in_brick = |row: &[u32; 2]| grid.brick(bin[row[0] as usize]) == brick;
        rows += bin_start[first..].iter().take_while(|row| in_brick(row)).count();
        (brick, first..rows)
    };
    bin.chunk_by(|a, b| grid.brick(*a) == grid.brick(*b)).map(of_brick).collect()
}

/// The pairs that a bin claims.
#[inline]
fn in_bin(input: &Input, [first, end]: [u32; 2], found: &mut Found) {
    let grid = input.grid;
    let members = &input.shape[first as usize..end as usize];
    let here = grid.place(grid.level[members[0] as usize] as usize, input.bin[first as usize]);
    // The overlap of two boxes begins in this bin along an axis if one of them does: with a bit an axis, the bin claims a pair
    // whose bits together are all set.
    let begins = |s: u32| grid.low[s as usize].cmpeq(here).bitmask() as usize;
    let boxes = |s: u32| &input.aabb[s as usize];
    let mut find = |s: u32, t: u32| {
        if input.may_meet(s, t) {
            found.push(s, t, 0);
        }
    };
    if members.len() > MEMBERS {
        for (i, &s) in members.iter().enumerate() {
            for &t in &members[i + 1..] {
                if begins(s) | begins(t) == 7 && boxes(s).overlaps(boxes(t)) {
                    find(s, t);
                }
            }
        }
        return;
    }
    let mut side_by_side = [FourBoxes::default(); MEMBERS / 4];
    let mut bits = [0; MEMBERS];
    // The members, as bits, that have the bits `k` among theirs.
    let mut having = [0u64; 8];
    for (i, &s) in members.iter().enumerate() {
        side_by_side[i / 4].put(i % 4, boxes(s));
        bits[i] = begins(s);
        (0..8).filter(|k| bits[i] & k == *k).for_each(|k| having[k] |= 1 << i);
    }
    for (i, &s) in members.iter().enumerate() {
        let (own, mut claimed) = (boxes(s), having[7 & !bits[i]] & (u64::MAX << i) & !(1 << i));
        while claimed != 0 {
            let block = claimed.trailing_zeros() as usize / 4;
            let mut near = side_by_side[block].overlap(own) & (claimed >> (4 * block)) as u32;
            while near != 0 {
                find(s, members[4 * block + near.trailing_zeros() as usize]);
                near &= near - 1;
            }
            claimed &= !(15 << (4 * block));
        }
    }
}

/// Four boxes, coordinate by coordinate.
#[derive(Clone, Copy, Default)]
struct FourBoxes {
    min: [Vec4; 3],
    max: [Vec4; 3],
}

impl FourBoxes {
    #[inline(always)]
    fn put(&mut self, lane: usize, b: &Aabb) {
        for axis in 0..3 {
            (self.min[axis][lane], self.max[axis][lane]) = (b.min[axis], b.max[axis]);
        }
    }

    /// Which of them share a point with a box, as bits.
    #[inline(always)]
    fn overlap(&self, b: &Aabb) -> u32 {
        let along = |k: usize| self.min[k].cmple(Vec4::splat(b.max[k])) & self.max[k].cmpge(Vec4::splat(b.min[k]));
        (along(0) & along(1) & along(2)).bitmask()
    }
}

/// The pairs of a shape with shapes of coarser levels.
fn in_coarser_levels(input: &Input, s: u32, found: &mut Found) {
    let Input { model, aabb, grid, .. } = input;
    if model.shape_kind[s as usize].is_surface() {
        return;
    }
    let a = &aabb[s as usize];
    for level in grid.level[s as usize] as usize + 1..grid.levels.len() {
        if !grid.levels[level].used {
            continue;
        }
        let low = grid.bin_of(level, a.min);
        grid.visit(level, a, |here| {
            let start = input.bin.partition_point(|b| *b < here);
            let members = input.bin[start..].iter().zip(&input.shape[start..]).take_while(|(b, _)| **b == here);
            for (_, &t) in members {
                let b = &aabb[t as usize];
                if a.overlaps(b) && grid.index(level, low.max(grid.low[t as usize])) == here && input.may_meet(s, t) {
                    found.push(s, t, 0);
                }
            }
        });
    }
}

/// A surface in its place.
struct SurfaceAt {
    shape: u32,
    kind: ShapeKind,
    position: DVec3,
    /// World to local.
    turn: DMat3,
    /// Of a plane: its normal, and its height along it with all slack of the boxes added.
    up: Vec3A,
    height: f32,
}

impl SurfaceAt {
    fn of(input: &Input, shape: u32) -> SurfaceAt {
        let place = input.state.shape_pose(input.model, shape as usize);
        let up = place.orientation * DVec3::Z;
        let reach = place.position.dot(up);
        SurfaceAt {
            shape,
            kind: input.model.shape_kind[shape as usize],
            position: place.position,
            turn: DMat3::from_quat(place.orientation.inverse()),
            up: up.as_vec3a(),
            height: (reach + 1e-6 * reach.abs() + input.model.envelope) as f32,
        }
    }
}

/// The pairs of a shape with a plane, or with the triangles of a mesh or a height field.
#[inline]
fn on_surface(input: &Input, s: u32, t: &SurfaceAt, found: &mut Found) {
    let a = &input.aabb[s as usize];
    if t.kind == ShapeKind::Plane {
        // The box's corner that is deepest; an empty box has none.
        let deepest = Vec3A::select(t.up.cmpgt(Vec3A::ZERO), a.min, a.max);
        if deepest.dot(t.up) <= t.height
            && !input.model.shape_kind[s as usize].is_surface()
            && input.may_meet(s, t.shape)
        {
            found.push(s, t.shape, 0);
        }
        return;
    }
    if input.model.shape_kind[s as usize].is_surface() || !a.min.is_finite() || !input.may_meet(s, t.shape) {
        return;
    }
    let (min, max) = (a.min.as_dvec3(), a.max.as_dvec3());
    let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
    let Some(surface) = surface_of(input.model, t.shape as usize) else { return };
    // The box of the shape's box, in the surface's frame.
    let local = t.turn * (centre - t.position);
    let reach = t.turn.x_axis.abs() * half.x + t.turn.y_axis.abs() * half.y + t.turn.z_axis.abs() * half.z;
    surface.visit(local - reach, local + reach, &mut |triangle| found.push(s, t.shape, triangle));
}
