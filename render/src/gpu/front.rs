//! The front of a frame, on the processor: items from front to back are bound, split, diced, displaced and projected, in waves. What is
//! hidden by the waves before is not diced. Caps of spheres are tiled here, and their points made by the device.

use crate::cpu::deferred::OF_GRIDS;
use crate::cpu::displace::{displace, face_eye};
use crate::cpu::frame::Frame;
use crate::cpu::raster::{Raster, side_seen};
use crate::cpu::samples::BLOCK;
use crate::cpu::samples::cull::blocks_of;
use crate::film::display::place_of;
use crate::gprim::bound::raster_bound;
use crate::gprim::dice::Dicer;
use crate::gprim::grid::{Grid, Sink, Subject};
use crate::gprim::sphere::tile::{CapTile, MOST_RINGS};
use crate::gprim::split::{Queue, Waiting};
use crate::gpu::limits::Limits;
use crate::scene::camera::RasterBound;
use crate::scene::motion::{self, instants};
use crate::scene::source::{Item, ItemView};
use crate::stats::Stats;
use glam::Mat4;
use rayon::prelude::*;
use sl::Global;
use sl::machine::{Machine, Points};
use std::cmp::Ordering;
use std::sync::{Mutex, PoisonError};

/// A grid on the raster, some of whose micropolygons may be visible.
pub struct Diced {
    /// The item that it is of.
    pub item: Item,
    /// Count of its points along a row, and of rows.
    pub size: [usize; 2],
    /// Its points, displaced; none if the device dices it. They are large, and grids are sorted.
    pub points: Option<Box<Points>>,
    /// What the device dices it of, if it does.
    pub cap: Option<Cap>,
    /// Raster x and y, pixels, and depth of each point, at each moment of the item; none if the device dices it.
    pub raster: Vec<Vec<[f32; 3]>>,
    /// Of each span between two moments: the times from and until which it holds, when it begins, and one over its length, 0 if it has none; none
    /// where samples have no times.
    pub keys: Vec<[f32; 4]>,
    /// Its micropolygons, by their first points; none if the device dices it.
    pub micropolygons: Vec<u32>,
    /// The sign of the area on the raster of triangles that are there; 0 if all are.
    pub side: f32,
    /// How far it may be displaced.
    pub reach: f32,
    /// Its least depth; 0 if the device dices it.
    pub z: f32,
    /// The times at which it is shaded again, as its colour or opacity moves.
    pub fades: Vec<f32>,
    /// Whether its first and last points along u and along v are edges of the primitive.
    pub rims: [bool; 4],
    /// How far its points move on the raster, if a display takes that.
    pub motion: Vec<[f32; 2]>,
}

/// A tile of a sphere's cap that the device dices.
pub struct Cap {
    pub tile: CapTile,
    /// As [`Points::orientation`].
    pub orientation: f32,
    /// From where the item stood as the shutter opened to camera space, at each moment of the item; none if that is the camera's own.
    pub to_camera: Vec<Mat4>,
}

impl Cap {
    /// Count of the moments of the item.
    pub fn n_moments(&self) -> usize {
        self.to_camera.len().max(1)
    }
}

impl Diced {
    /// Count of its points.
    pub fn n(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Count of the places of its points, at all moments.
    fn n_places(&self) -> usize {
        self.n() * self.cap.as_ref().map_or(self.raster.len(), Cap::n_moments)
    }

    /// Count of its micropolygons; of those that the device dices, some may not be there.
    pub fn n_micropolygons(&self) -> usize {
        match self.cap {
            Some(_) => (self.size[0] - 1) * (self.size[1] - 1),
            None => self.micropolygons.len(),
        }
    }

    /// The first point of a micropolygon.
    pub fn first_of(&self, micropolygon: usize) -> usize {
        let across = self.size[0] - 1;
        match self.cap {
            Some(_) => micropolygon / across * self.size[0] + micropolygon % across,
            None => self.micropolygons[micropolygon] as usize,
        }
    }

    /// Count of its points, and of these as shaded again.
    pub fn n_shaded(&self) -> usize {
        self.n() * (1 + self.fades.len())
    }
}

/// The part of the raster that is drawn, and how deep blocks of its pixels are.
pub struct Window {
    /// First pixel.
    pub corner: [i64; 2],
    /// Pixels along x and y.
    pub size: [usize; 2],
    /// The greatest depth of the samples of each block; none before the first wave.
    pub blocks: Vec<f32>,
    /// The pixels that are wanted, from the first one on: the first, and the one after the last.
    pub part: [[usize; 2]; 2],
}

impl Window {
    /// Whether something within a bound may be visible.
    fn shows(&self, bound: &RasterBound) -> bool {
        let (min, max) = (bound.min.to_array(), bound.max.to_array());
        let [left, top] = self.corner.map(|x| x as f32);
        let [[x0, y0], [x1, y1]] = self.part.map(|at| [left + at[0] as f32, top + at[1] as f32]);
        if !(max[0] >= x0 && max[1] >= y0 && min[0] <= x1 && min[1] <= y1) {
            return false;
        }
        let Some(([x0, x1], [y0, y1])) = blocks_of([left, top], self.size, min, max) else { return false };
        let columns = self.size[0].div_ceil(BLOCK);
        let [first, end] = self.part;
        let [x0, y0] = [x0.max(first[0] / BLOCK), y0.max(first[1] / BLOCK)];
        let [x1, y1] = [x1.min((end[0] - 1) / BLOCK), y1.min((end[1] - 1) / BLOCK)];
        let mut all = (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| y * columns + x));
        self.blocks.is_empty() || all.any(|block| self.blocks[block] >= bound.z)
    }
}

/// What is diced next.
#[derive(Clone, Copy)]
enum Turn {
    Item(f32, Item),
    Piece(Waiting),
}

impl Turn {
    /// Which of two comes first.
    fn cmp(&self, other: &Turn) -> Ordering {
        let key = |turn: &Turn| match turn {
            // An item comes before its pieces.
            Turn::Item(z, item) => (*z, *item, 0, -1.0),
            Turn::Piece(waiting) => waiting.turn(),
        };
        let ((z, item, patch, start), (other_z, other, other_patch, other_start)) = (key(self), key(other));
        let by_item = (item.source, item.index, patch).cmp(&(other.source, other.index, other_patch));
        z.total_cmp(&other_z).then(by_item).then(start.total_cmp(&other_start))
    }
}

/// The memory of a thread that dices.
#[derive(Default)]
struct Hand {
    instants: Vec<motion::Instant>,
    dicer: Dicer,
    raster: Raster,
    machine: Machine,
}

/// The items of a window that wait to be diced.
pub struct Front<'a> {
    frame: &'a Frame<'a>,
    items: std::iter::Peekable<std::vec::IntoIter<(f32, Item)>>,
    queue: Queue,
    /// Grids that were diced before others whose turn is earlier, those of a turn together, with the count of their points.
    early: Vec<(Turn, usize, Vec<Diced>)>,
    /// Count of the points of all of these, and whether they are in the order of their turns.
    n_early: usize,
    in_order: bool,
    /// Items, and pieces of items, that are diced at a time.
    round: usize,
    /// The most places of points that a wave has, as far as it has more than one grid.
    most: usize,
    /// Those of threads that dice nothing at present.
    hands: Mutex<Vec<Hand>>,
}

impl<'a> Front<'a> {
    /// Of items with their least depths, the nearest first, as much at a time as limits say.
    pub fn new(frame: &'a Frame<'a>, items: Vec<(f32, Item)>, limits: &Limits) -> Front<'a> {
        let (items, hands) = (items.into_iter().peekable(), Mutex::default());
        let (queue, early, round, most) = (Queue::default(), vec![], limits.round, limits.points / 2);
        Front { frame, items, queue, early, n_early: 0, in_order: true, round, most, hands }
    }

    /// Dice what comes next, until there are about so many points; nothing if all is diced. What a round comes to beyond the most that a wave
    /// may have is left to the next. The grids are in the order of their turns, those of later waves after those of earlier ones: of what is
    /// equally deep, the first is visible, however much is diced at a time.
    pub fn wave(&mut self, window: &Window, n_points: usize, stats: &mut Stats) -> Vec<Diced> {
        loop {
            if !self.in_order {
                self.early.sort_by(|a, b| a.0.cmp(&b.0));
                self.in_order = true;
            }
            let next = self.next();
            let end = match next {
                Some(next) => self.early.partition_point(|(turn, ..)| turn.cmp(&next).is_lt()),
                None => self.early.len(),
            };
            let later: usize = self.early[end..].iter().map(|(_, n, _)| n).sum();
            if self.n_early - later >= n_points || next.is_none() {
                self.n_early = later;
                let early = self.early.split_off(end);
                let now = std::mem::replace(&mut self.early, early);
                return self.fit(now);
            }
            // Where there is enough that waits for what is nearer, nothing is diced that is farther: it may be hidden.
            let last = self.early.last().map(|(turn, ..)| *turn).filter(|_| self.n_early >= n_points);
            self.round(window, last, stats);
        }
    }

    /// The grids of turns, as far as they fit into a wave; the others wait for the next.
    fn fit(&mut self, turns: Vec<(Turn, usize, Vec<Diced>)>) -> Vec<Diced> {
        let mut grids = Vec::with_capacity(turns.iter().map(|(.., own)| own.len()).sum());
        let (mut n_places, mut rest) = (0, vec![]);
        for (turn, _, mut own) in turns {
            let mut fits = |grid: &Diced| {
                n_places += grid.n_places();
                n_places <= self.most
            };
            let at = if rest.is_empty() { own.iter().position(|grid| !fits(grid)).unwrap_or(own.len()) } else { 0 };
            let later = own.split_off(if grids.is_empty() { at.max(1).min(own.len()) } else { at });
            grids.extend(own);
            if !later.is_empty() {
                rest.push((turn, later.iter().map(Diced::n).sum::<usize>(), later));
            }
        }
        self.n_early += rest.iter().map(|(_, n, _)| n).sum::<usize>();
        self.early.splice(..0, rest);
        grids
    }

    /// Dice some items and pieces, those up to a turn if it is given.
    fn round(&mut self, window: &Window, until: Option<Turn>, stats: &mut Stats) {
        /// Turns that a thread takes at a time.
        const CHUNK: usize = 8;
        let (turns, frame) = (self.turns(until), self.frame);
        let hands = || self.hands.lock().unwrap_or_else(PoisonError::into_inner);
        let diced: Vec<(Vec<(Vec<Diced>, Vec<Waiting>)>, Stats)> = turns
            .par_chunks(CHUNK)
            .map(|turns| {
                let (begun, mut stats) = (std::time::Instant::now(), Stats::default());
                let mut hand = hands().pop().unwrap_or_default();
                let own = turns.iter().map(|turn| hand.dice(frame, window, *turn, &mut stats)).collect();
                hands().push(hand);
                stats.seconds.dice = begun.elapsed().as_secs_f64();
                (own, stats)
            })
            .collect();
        for (turns, (of_turns, of_chunk)) in turns.chunks(CHUNK).zip(diced) {
            for (turn, (own, waiting)) in turns.iter().zip(of_turns) {
                if !own.is_empty() {
                    let n = own.iter().map(Diced::n).sum();
                    self.n_early += n;
                    self.in_order &= self.early.last().is_none_or(|(last, ..)| last.cmp(turn).is_le());
                    self.early.push((*turn, n, own));
                }
                self.queue.extend(waiting);
            }
            *stats = stats.add(of_chunk);
        }
    }

    /// What is diced next.
    fn next(&mut self) -> Option<Turn> {
        let item = self.items.peek().map(|(z, item)| Turn::Item(*z, *item));
        let piece = self.queue.first().map(Turn::Piece);
        [item, piece].into_iter().flatten().min_by(Turn::cmp)
    }

    /// The next items and pieces, in the order of their depths, those up to a turn if it is given.
    fn turns(&mut self, until: Option<Turn>) -> Vec<Turn> {
        let mut turns = vec![];
        let comes = |next: &Turn| until.is_none_or(|until| next.cmp(&until).is_le());
        while turns.len() < self.round && self.next().is_some_and(|next| comes(&next)) {
            let piece = self.queue.pop_before(self.items.peek()).map(Turn::Piece);
            let next = piece.or_else(|| self.items.next().map(|(z, item)| Turn::Item(z, item)));
            let Some(turn) = next else { break };
            turns.push(turn);
        }
        turns
    }
}

impl Hand {
    /// Dice an item or a piece: its grids, and the pieces that wait.
    fn dice(
        &mut self,
        frame: &Frame<'_>,
        window: &Window,
        turn: Turn,
        stats: &mut Stats,
    ) -> (Vec<Diced>, Vec<Waiting>) {
        let Hand { instants: moments, dicer, raster, machine } = self;
        let (camera, parameters) = (&frame.camera, frame.needs_parameters());
        let item = match turn {
            Turn::Item(_, item) => item,
            Turn::Piece(waiting) => waiting.item(),
        };
        let view = frame.scene.view(item);
        instants(camera, &view, moments);
        let subject = Subject { item, view: &view, instants: moments, camera, parameters };
        let diced = vec![];
        let dices_caps = dices_caps(frame, &view);
        let mut sink = Taken { frame, window, subject, raster, machine, dices_caps, diced, stats };
        match turn {
            Turn::Piece(waiting) => dicer.dice_waiting(&subject, &waiting, &mut sink),
            Turn::Item(..) if raster_bound(camera, &view, moments).is_some_and(|b| sink.shows(&b)) => {
                dicer.dice(&subject, &mut sink);
            }
            Turn::Item(..) => {}
        }
        let Taken { diced, stats, .. } = sink;
        stats.splits += std::mem::take(&mut dicer.queue.splits);
        (diced, dicer.queue.take())
    }
}

/// What becomes of an item's grids.
struct Taken<'a> {
    frame: &'a Frame<'a>,
    window: &'a Window,
    subject: Subject<'a>,
    raster: &'a mut Raster,
    machine: &'a mut Machine,
    /// Caps of spheres are diced by the device.
    dices_caps: bool,
    diced: Vec<Diced>,
    stats: &'a mut Stats,
}

impl Taken<'_> {
    /// The spans between the moments of the item, where samples have times.
    fn keys(&self) -> Vec<[f32; 4]> {
        if self.frame.jitter.moments.is_some() { keys(self.subject.instants) } else { vec![] }
    }
}

impl Sink for Taken<'_> {
    fn shows(&mut self, bound: &RasterBound) -> bool {
        self.window.shows(bound)
    }

    fn takes_caps(&self, n_rings: usize) -> bool {
        self.dices_caps && n_rings <= MOST_RINGS
    }

    fn take_cap(&mut self, tile: CapTile, grid: &mut Grid) {
        let Subject { item, view, instants, .. } = self.subject;
        let to_camera = if instants.len() > 1 { instants.iter().map(|at| at.to_camera).collect() } else { vec![] };
        let own = Diced {
            item,
            size: [grid.points.nu, grid.points.nv],
            points: None,
            cap: Some(Cap { tile, orientation: grid.points.orientation, to_camera }),
            raster: vec![],
            keys: self.keys(),
            micropolygons: vec![],
            side: 0.0,
            reach: 0.0,
            z: 0.0,
            fades: view.attributes.fade_times(),
            rims: [false; 4],
            motion: vec![],
        };
        // The device counts those that are hidden.
        self.stats.grids += 1;
        self.stats.micropolygons += own.n_micropolygons() as u64;
        self.diced.push(own);
    }

    fn take(&mut self, grid: &mut Grid) {
        let Subject { item, view, instants, camera, .. } = self.subject;
        displace(self.frame.scene, &self.frame.displacement_rays, &self.subject, grid, self.machine);
        face_eye(&self.subject, grid);
        let behind = self.frame.coplanar.behind(item);
        let Some(bound) = self.raster.project(camera, instants, grid, behind) else { return };
        self.stats.grids += 1;
        if !self.shows(&bound) {
            self.stats.grids_hidden += 1;
            return;
        }
        let side = side_seen(camera, view, &grid.points);
        self.raster.choose(camera, side, grid);
        if self.raster.micropolygons.is_empty() {
            return;
        }
        self.stats.micropolygons += self.raster.micropolygons.len() as u64;
        let is_moved = place_of(&self.frame.aovs, "motion").is_some();
        let motion = if is_moved { self.raster.motion().collect() } else { vec![] };
        self.diced.push(Diced {
            item,
            size: [grid.points.nu, grid.points.nv],
            points: Some(Box::new(given(&grid.points))),
            cap: None,
            raster: self.raster.at.clone(),
            keys: self.keys(),
            micropolygons: self.raster.micropolygons.clone(),
            side,
            reach: grid.reach,
            z: bound.z,
            fades: view.attributes.fade_times(),
            rims: grid.origin.map_or([false; 4], |part| part.rims()),
            motion,
        });
    }
}

/// What a grid gives of its points, as long as it is: the dicer's own memory is used again.
fn given(points: &Points) -> Points {
    let n = points.n();
    let mut own = Points::new(points.nu, points.nv, points.orientation);
    for global in OF_GRIDS {
        if let Some(values) = points.get(global).filter(|v| !v.is_empty() && v.len() % n == 0) {
            own.set(global, values.to_vec());
        }
    }
    own.messages.clone_from(&points.messages);
    points.variables().iter().for_each(|values| own.next_variable().extend_from_slice(values));
    own
}

/// Whether the device dices the caps of a sphere: all that is wanted of their points are P, N, Ng and I.
fn dices_caps(frame: &Frame<'_>, view: &ItemView<'_>) -> bool {
    let a = view.attributes;
    let is_plain = a.two_sided && !view.particle && a.displacement.is_none() && a.atmosphere.is_none();
    is_plain
        && frame.camera.perspective
        && frame.n_taken == 0
        && !a.is_shown()
        && !a.reads_parameters()
        && !a.reads_neighbours()
        && !a.reads(Global::DPdtime)
}

/// The spans between the moments of an item.
fn keys(instants: &[motion::Instant]) -> Vec<[f32; 4]> {
    /// Later than any sample.
    const NEVER: f32 = 1e30;
    let last = instants.len() - 1;
    let key = |k: usize| {
        let (start, next) = (instants[k].time, (k + 1).min(last));
        let rate = if next > k { 1.0 / (instants[next].time - start) } else { 0.0 };
        let until = if k + 1 < last { instants[k + 1].time } else { NEVER };
        [start, until, start, rate]
    };
    (0..last.max(1)).map(key).collect()
}
