//! Broad phase: write every pair of shapes whose fat AABBs overlap, once: the bin with the minimum corner of the overlap reports it.
//! (The paper takes the overlap's midpoint; the bin of the minimum corner follows from those of the shapes without arithmetic.)
//! in   position           [n_bodies]       m
//! in   orientation        [n_bodies]
//! in   fat_aabb           [n_shapes]       m, world
//! in   bin_level          [n_shapes]
//! in   bin_low            [n_shapes]
//! in   bin                [n_bin_pairs]    sorted
//! in   bin_shape          [n_bin_pairs]
//! in   bin_start          [n_active_bins]
//! out  sphere_pair_start  [n_tiles + 2]    pairs of spheres of each tile, and of those in no tile
//! out  sphere_pair        [n_sphere_pairs] the lower id first
//! out  other_pair_start   [n_tiles + 2]    the same of other pairs
//! out  other_pair         [n_other_pairs]  the lower id first, and the triangle where one is a mesh or a height field
//! Source: paper §3, stages 7–9.
//!
//! Pairs of shapes of different levels are found from the finer one, in the bins of the coarser level that it overlaps. Surfaces
//! (planes, meshes, height fields) are few: every shape is tested against them.
//!
//! The tile of a body is the brick of bins with the minimum corner of its box. Pairs within a tile belong to the first round. Pairs
//! between tiles go to a second round of tiles, shifted by half a brick along each axis, and the few that cross tiles in both rounds
//! come last: a solver can work on the tiles of a round in parallel, each with its data near together.

use super::bin_emit::{BinGrid, Bins};
use super::collide::surface_of;
use crate::aabb::Aabb;
use crate::model::Model;
use crate::rows::{CHUNK, SERIAL_LIMIT, cut, fill_rows};
use crate::shape::ShapeKind;
use crate::state::State;
use glam::{DMat3, DVec3, Vec3A, Vec4};
use rayon::prelude::*;
use std::ops::Range;

/// Candidate pairs of a tile while they are found, the lower id first.
#[derive(Clone, Default)]
struct Candidates {
    /// Pairs of spheres.
    spheres: Vec<[u32; 2]>,
    /// Other pairs, and the triangle where one is a mesh or a height field.
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

/// The candidate pairs by tiles: those of each tile of the first round, of each of the second, and of no tile.
#[derive(Default)]
pub struct Pairs {
    /// Number of tiles of the first round.
    pub n_first: usize,
    /// First pair of spheres of each tile and of the pairs in no tile, and the end (n_tiles + 2).
    pub sphere_start: Vec<u32>,
    /// Pairs of spheres, the lower id first (n_sphere_pairs).
    pub spheres: Vec<[u32; 2]>,
    /// First other pair of each tile and of the pairs in no tile, and the end (n_tiles + 2).
    pub other_start: Vec<u32>,
    /// Other pairs, the lower id first, and the triangle where one is a mesh or a height field (n_other_pairs).
    pub others: Vec<[u32; 3]>,
    /// Where each body lies in columns in which those of a tile are neighbours, in cache lines of their own (n_bodies).
    pub place: Vec<u32>,
    /// Length of these columns.
    pub n_places: usize,
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

    /// Number of tiles, and one for the pairs in no tile.
    pub fn n_tiles(&self) -> usize {
        self.sphere_start.len() - 1
    }

    /// Take the candidate pairs of all tiles, which were found in parts, in order: count, scan, write. `first_part` is the first of each tile,
    /// the first `n_first` of which are of the first round.
    fn take(&mut self, found: Vec<Candidates>, first_part: &[usize], n_first: usize) {
        self.n_first = n_first;
        flatten(&found, |c| &c.spheres, &mut self.sphere_start, &mut self.spheres);
        flatten(&found, |c| &c.others, &mut self.other_start, &mut self.others);
        for start in [&mut self.sphere_start, &mut self.other_start] {
            *start = first_part.iter().chain([&found.len()]).map(|part| start[*part]).collect();
        }
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
    if n <= SERIAL_LIMIT {
        out.clear();
        rows.iter().for_each(|row| out.extend_from_slice(items(row)));
        return;
    }
    out.resize(n, T::default());
    let parts = cut(out, rows.iter().map(|row| items(row).len()));
    parts.into_par_iter().zip(rows).for_each(|(own, row)| own.copy_from_slice(items(row)));
}

/// The tile of a body that is held in place, which fits every tile.
const HELD: u32 = u32::MAX;

/// The pairs that a task finds in a tile, in memory that it keeps from tile to tile.
struct Found<'a> {
    model: &'a Model,
    /// The tile of each body in both rounds (n_bodies).
    tile: &'a [[u32; 2]],
    here: u32,
    /// Pairs within the tile, and pairs across tiles.
    own: Candidates,
    crossing: Vec<[u32; 3]>,
    /// The members of the bin in runs, and after them what is left of bins before it.
    side_by_side: Vec<SideBySide>,
}

impl Found<'_> {
    #[inline]
    fn push(&mut self, s: u32, t: u32, triangle: u32) {
        let pair = [s.min(t), s.max(t), triangle];
        let tiles = [s, t].map(|s| self.tile[self.model.shape_body[s as usize] as usize][0]);
        if tiles.iter().all(|tile| *tile == self.here || *tile == HELD) {
            self.own.push(self.model, pair);
        } else {
            self.crossing.push(pair);
        }
    }
}

/// Number of shapes of a bin in a run: one bit each.
const RUN: usize = 64;

/// The input of the stage.
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
    /// Whether two shapes may collide: not of one body, not both held in place, not of bodies or groups that are excluded. Inactive shapes
    /// have empty boxes, which overlap none.
    #[inline]
    fn may_collide(&self, s: u32, t: u32) -> bool {
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
    let is_surface = |s: usize| model.shape_kind[s].is_surface() && !state.is_inactive(model.shape_body[s] as usize);
    let surfaces: Vec<SurfaceAt> =
        (0..model.n_shapes() as u32).filter(|s| is_surface(*s as usize)).map(|s| SurfaceAt::of(input, s)).collect();
    let mixed = input.grid.levels.iter().filter(|l| l.used).count() > 1;
    let tile = tiles_of(input);
    // A large allocation, whose memory goes back to the system when it is freed.
    const CAPACITY: usize = 1 << 14;
    let found = || {
        let own = Candidates { spheres: Vec::with_capacity(CAPACITY), others: vec![] };
        Found { model, tile: &tile, here: NOWHERE, own, crossing: vec![], side_by_side: vec![] }
    };

    /// Active bins of a brick that one task looks through.
    const PART: usize = 64;
    let bricks = bricks_of(input);
    let (mut parts, mut first_part) = (vec![], vec![]);
    for (brick, rows) in &bricks {
        first_part.push(parts.len());
        // A brick without active bins has pairs that other bricks' bins report, so that it has a part too.
        let part = |first: usize| (*brick, first..(first + PART).min(rows.end));
        parts.push(part(rows.start));
        parts.extend(rows.clone().step_by(PART).skip(1).map(part));
    }
    let within = parts.par_iter().with_max_len(1).map_init(found, |found, (brick, rows)| {
        found.here = *brick;
        found.own.spheres.clear();
        found.own.others.clear();
        rows.clone().for_each(|row| in_bin(input, input.bin_start[row], found));
        (found.own.clone(), std::mem::take(&mut found.crossing))
    });
    let (mut found_in, mut crossing): (Vec<Candidates>, Vec<Vec<[u32; 3]>>) = within.unzip();
    // The pairs of each shape with shapes of coarser levels and with surfaces.
    if mixed || !surfaces.is_empty() {
        let rows =
            (0..model.n_shapes().div_ceil(CHUNK)).into_par_iter().with_max_len(1).map_init(found, |found, chunk| {
                for s in chunk * CHUNK..((chunk + 1) * CHUNK).min(model.n_shapes()) {
                    if mixed {
                        in_coarser_levels(input, s as u32, found);
                    }
                    surfaces.iter().for_each(|t| on_surface(input, s as u32, t, found));
                }
                std::mem::take(&mut found.crossing)
            });
        crossing.par_extend(rows);
    }

    let mut place = std::mem::take(&mut pairs.place);
    let take = || {
        assign(model, &tile, &bricks, &crossing.concat(), (&mut found_in, &mut first_part));
        pairs.take(found_in, &first_part, bricks.len());
    };
    let ((), n_places) = rayon::join(take, || places_of(input, &tile, &mut place));
    (pairs.place, pairs.n_places) = (place, n_places);
}

/// Places of the bodies in the order of their bins: those of a tile are neighbours, and share no cache line with those of another. Returns the
/// length of columns by them.
fn places_of(input: &Input, tile: &[[u32; 2]], place: &mut Vec<u32>) -> usize {
    /// Rows that are no more than two cache lines together.
    const ALIGN: usize = 4;
    let Input { model, grid, .. } = input;
    let mut bin = vec![u32::MAX; tile.len()];
    for (s, body) in model.shape_body.iter().enumerate() {
        if tile[*body as usize][0] != HELD {
            bin[*body as usize] = grid.index(grid.level[s] as usize, grid.low[s]);
        }
    }
    let mut order: Vec<u64> = bin.par_iter().enumerate().map(|(body, bin)| (*bin as u64) << 32 | body as u64).collect();
    order.par_sort_unstable();
    place.resize(tile.len(), 0);
    let (mut n, mut here) = (0usize, NOWHERE);
    for key in order {
        let body = key as u32 as usize;
        if tile[body][0] != here {
            (n, here) = (n.next_multiple_of(ALIGN), tile[body][0]);
        }
        place[body] = n as u32;
        n += 1;
    }
    n
}

/// Assign the pairs across tiles, and those found outside their tiles, to tiles: to those of the first round, which exist already, to
/// those of the second, which are added, or to no tile, which comes last. `found` has them by parts, `first_part` the first of each tile.
fn assign(
    model: &Model,
    tile: &[[u32; 2]],
    bricks: &[(u32, Range<usize>)],
    crossing: &[[u32; 3]],
    (found, first_part): (&mut Vec<Candidates>, &mut Vec<usize>),
) {
    /// Bits of a pair's index in `crossing`.
    const PLACE: u32 = 30;
    let tile_of = |[s, t, _]: &[u32; 3]| {
        let [a, b] = [s, t].map(|s| tile[model.shape_body[*s as usize] as usize]);
        match (0..2).find(|round| a[*round] == b[*round] || a[*round] == HELD || b[*round] == HELD) {
            Some(round) => (round, a[round].min(b[round])),
            None => (2, 0),
        }
    };
    // Round, tile and index in one sort key.
    let key = |(place, pair): (usize, &[u32; 3])| {
        let (round, tile) = tile_of(pair);
        (round as u64) << (32 + PLACE) | (tile as u64) << PLACE | place as u64
    };
    let mut order: Vec<u64> = crossing.par_iter().enumerate().map(key).collect();
    order.par_sort_unstable();
    let (mut neither, n_within) = (Candidates::default(), found.len());
    for run in order.chunk_by(|a, b| a >> PLACE == b >> PLACE) {
        let (round, tile) = (run[0] >> (32 + PLACE), (run[0] >> PLACE) as u32);
        let mut own = Candidates::default();
        let home = match round {
            0 => match bricks.binary_search_by_key(&tile, |(brick, _)| *brick) {
                Ok(k) => &mut found[first_part.get(k + 1).copied().unwrap_or(n_within) - 1],
                Err(_) => &mut neither,
            },
            1 => &mut own,
            _ => &mut neither,
        };
        run.iter().for_each(|key| home.push(model, crossing[*key as usize & ((1 << PLACE) - 1)]));
        if round == 1 {
            first_part.push(found.len());
            found.push(own);
        }
    }
    first_part.push(found.len());
    found.push(neither);
}

/// No brick.
const NOWHERE: u32 = u32::MAX - 1;

/// The tiles of each body in both rounds; for a body with several shapes, those of the last (n_bodies).
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

/// The bricks that have any shape, ascending, and the range of the active bins of each.
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

/// The pairs that a bin reports.
#[inline]
fn in_bin(input: &Input, [first, end]: [u32; 2], found: &mut Found) {
    let grid = input.grid;
    let members = &input.shape[first as usize..end as usize];
    let here = grid.coordinates(grid.level[members[0] as usize] as usize, input.bin[first as usize]);
    // The minimum corner of the overlap of two boxes is in this bin along an axis if that of one of them is: with a bit per axis, the bin
    // reports a pair whose bits together are all set.
    let begins = |s: u32| grid.low[s as usize].cmpeq(here).bitmask() as u64;
    let boxes = |s: u32| &input.aabb[s as usize];
    let find = |found: &mut Found, s: u32, t: u32| {
        if input.may_collide(s, t) {
            found.push(s, t, 0);
        }
    };
    let n_runs = members.len().div_ceil(RUN);
    found.side_by_side.resize(n_runs.max(found.side_by_side.len()), SideBySide::default());
    for (run, members) in found.side_by_side.iter_mut().zip(members.chunks(RUN)) {
        run.begins = [0; 3];
        for (i, &s) in members.iter().enumerate() {
            run.boxes[i / 4].put(i % 4, boxes(s));
            let own = begins(s);
            run.begins.iter_mut().enumerate().for_each(|(axis, begins)| *begins |= (own >> axis & 1) << i);
        }
    }
    for (i, &s) in members.iter().enumerate() {
        let own = boxes(s);
        let begins = found.side_by_side[i / RUN].begins.map(|begins| (begins >> (i % RUN) & 1).wrapping_neg());
        for run in i / RUN..n_runs {
            let there = u64::MAX >> RUN.saturating_sub(members.len() - RUN * run);
            // In its own run those after it.
            let after = if run == i / RUN { there & (u64::MAX << (i % RUN)) & !(1 << (i % RUN)) } else { there };
            let of_run = found.side_by_side[run].begins;
            let mut claimed = (0..3).fold(after, |claimed, axis| claimed & (begins[axis] | of_run[axis]));
            while claimed != 0 {
                let block = claimed.trailing_zeros() as usize / 4;
                let mut near = found.side_by_side[run].boxes[block].overlap(own) & (claimed >> (4 * block)) as u32;
                while near != 0 {
                    find(found, s, members[RUN * run + 4 * block + near.trailing_zeros() as usize]);
                    near &= near - 1;
                }
                claimed &= !(15 << (4 * block));
            }
        }
    }
}

/// The members of a bin, or a run of them: their boxes side by side.
#[derive(Clone, Copy, Default)]
struct SideBySide {
    boxes: [FourBoxes; RUN / 4],
    /// Mask of the members whose boxes begin in the bin, along each axis.
    begins: [u64; 3],
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

    /// Mask of the boxes that overlap a box.
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
                if a.overlaps(b) && grid.index(level, low.max(grid.low[t as usize])) == here && input.may_collide(s, t)
                {
                    found.push(s, t, 0);
                }
            }
        });
    }
}

/// A surface in world coordinates.
struct SurfaceAt {
    shape: u32,
    kind: ShapeKind,
    position: DVec3,
    /// Rotation from world to local.
    to_local: DMat3,
    /// For a plane: its normal, and its offset along it with the envelope and the rounding of boxes added, m.
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
            to_local: DMat3::from_quat(place.orientation.inverse()),
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
        // The deepest corner of the box; that of an empty box is at infinity.
        let deepest = Vec3A::select(t.up.cmpgt(Vec3A::ZERO), a.min, a.max);
        if deepest.dot(t.up) <= t.height
            && !input.model.shape_kind[s as usize].is_surface()
            && input.may_collide(s, t.shape)
        {
            found.push(s, t.shape, 0);
        }
        return;
    }
    if input.model.shape_kind[s as usize].is_surface() || !a.min.is_finite() || !input.may_collide(s, t.shape) {
        return;
    }
    let (min, max) = (a.min.as_dvec3(), a.max.as_dvec3());
    let (centre, half) = (0.5 * (min + max), 0.5 * (max - min));
    let Some(surface) = surface_of(input.model, t.shape as usize) else { return };
    // The bounds of the shape's box in the surface's frame.
    let local = t.to_local * (centre - t.position);
    let reach = t.to_local.x_axis.abs() * half.x + t.to_local.y_axis.abs() * half.y + t.to_local.z_axis.abs() * half.z;
    surface.visit(local - reach, local + reach, &mut |triangle| found.push(s, t.shape, triangle));
}
