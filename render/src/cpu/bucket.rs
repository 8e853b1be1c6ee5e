//! The bucket loop: which items a bucket has, the picture of one bucket, and the picture of all.

use crate::cpu::bvh::Bvh;
use crate::cpu::imager;
use crate::cpu::samples::{Pixels, Samples};
use crate::cpu::shade::{Grid, displacement_reach};
use crate::cpu::visible::{Held, settle};
use crate::film::bucket::{Tile, tiles};
use crate::film::display::{self, Aov, aovs};
use crate::film::filter::Filter;
use crate::film::image::Image;
use crate::film::jitter::Jitter;
use crate::gprim::patch::Waiting;
use crate::gprim::sphere::Disk;
use crate::gprim::{patch, sphere};
use crate::scene::camera::{Camera, RasterBound};
use crate::scene::motion::{self, instants};
use crate::scene::options::Options;
use crate::scene::shape::Shape;
use crate::scene::source::{Item, ItemView};
use crate::scene::world::Scene;
use glam::{Mat4, Vec3};
use rayon::prelude::*;
use sl::machine::Machine;
use std::collections::BinaryHeap;
use std::sync::Mutex;
use std::time::Instant;

/// What a picture took.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct Stats {
    /// Primitives in the scene.
    pub items: u64,
    /// Pieces of patches that were split, in all buckets.
    pub splits: u64,
    /// Grids diced.
    pub grids: u64,
    /// Grids found hidden or outside after dicing.
    pub grids_hidden: u64,
    /// Points shaded.
    pub shaded_points: u64,
    /// Micropolygons sampled.
    pub micropolygons: u64,
    /// Samples tried against micropolygons.
    pub samples: u64,
    /// Where the time went.
    pub seconds: Seconds,
}

/// Seconds of all threads together.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct Seconds {
    /// Building the hierarchy for rays; of the clock, since several threads share it.
    pub hierarchy: f64,
    /// Bounding primitives and sorting them to buckets; of the clock.
    pub bound: f64,
    /// Splitting, dicing and displacing.
    pub dice: f64,
    /// Sampling.
    pub sample: f64,
    /// Shading, rays included.
    pub shade: f64,
    /// Compositing and filtering, the imager included.
    pub filter: f64,
}

impl Stats {
    fn add(mut self, o: Stats) -> Stats {
        self.splits += o.splits;
        self.grids += o.grids;
        self.grids_hidden += o.grids_hidden;
        self.shaded_points += o.shaded_points;
        self.micropolygons += o.micropolygons;
        self.samples += o.samples;
        self.seconds.dice += o.seconds.dice;
        self.seconds.sample += o.seconds.sample;
        self.seconds.shade += o.seconds.shade;
        self.seconds.filter += o.seconds.filter;
        self
    }
}

/// What all buckets share.
pub struct Frame<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The hierarchy over its primitives, for rays.
    pub bvh: Bvh,
    /// The camera.
    pub camera: Camera,
    /// Where samples lie.
    pub jitter: Jitter,
    /// What displays take besides colour.
    pub aovs: &'a [Aov],
    /// How many numbers these are.
    pub depth: usize,
    /// The number of the first item of each source among all, from 1.
    pub numbers: Vec<usize>,
    filter: [Filter; 2],
    options: &'a Options,
}

impl Frame<'_> {
    /// Whether u, v, s or t of a primitive are wanted.
    pub fn needs_parameters(&self, view: &ItemView<'_>) -> bool {
        view.attributes.reads_parameters() || self.aovs.iter().any(|a| matches!(a.name.as_str(), "u" | "v" | "s" | "t"))
    }
}

/// A bucket at work, and the memory that it works in.
pub struct Job<'a> {
    /// What all buckets share.
    pub frame: &'a Frame<'a>,
    /// Its samples.
    pub samples: Samples,
    /// The moments of the item at hand.
    pub instants: Vec<motion::Instant>,
    /// How far each point of the grid at hand is from where it was first, world space, at each of these moments but the first:
    /// x of all, y of all, z of all. None if it keeps its form.
    pub deformed: Vec<Vec<f32>>,
    /// The grid at hand.
    pub grid: Grid,
    /// The grid machine.
    pub machine: Machine,
    /// Variables of the grid at hand that are the same all over, besides the primitive's.
    pub uniform: Vec<(String, Vec<f32>)>,
    /// Varying variables of the grid at hand.
    pub varying: Vec<(String, Vec<f32>)>,
    /// Directions and normals of the sphere's grid at hand.
    pub directions: Vec<(Vec3, Vec3)>,
    /// For spheres.
    pub disk: Disk,
    /// Pieces of patches that wait for their turn.
    pub waiting: BinaryHeap<Waiting>,
    /// What displays take besides colour, of the points that were shaded last, one's numbers after another's.
    pub outputs: Vec<f32>,
    /// Grids that samples see.
    pub held: Held,
    /// Micropolygons of the grid at hand that are cut away; none if empty.
    pub trimmed: Vec<bool>,
    /// What it took.
    pub stats: Stats,
    /// Raster bound of the samples: x0, y0, x1, y1.
    rect: [f32; 4],
}

impl Job<'_> {
    /// Whether something may show in this bucket: in range, on its raster, not hidden. `box_at` is its camera-space box at a
    /// moment of the item.
    pub fn worth(&mut self, box_at: impl Fn(&motion::Instant) -> (Vec3, Vec3)) -> bool {
        let camera = &self.frame.camera;
        let bounds = self.instants.iter().filter_map(|i| {
            let (min, max) = box_at(i);
            camera.bound(min, max)
        });
        bounds.reduce(RasterBound::join).is_some_and(|b| self.shows(&b))
    }

    fn shows(&mut self, bound: &RasterBound) -> bool {
        self.touches(bound.min.to_array(), bound.max.to_array())
            && !self.samples.hides(bound.min.to_array(), bound.max.to_array(), bound.z)
    }

    /// Whether a raster rectangle touches this bucket's samples.
    pub fn touches(&self, min: [f32; 2], max: [f32; 2]) -> bool {
        max[0] >= self.rect[0] && max[1] >= self.rect[1] && min[0] <= self.rect[2] && min[1] <= self.rect[3]
    }
}

/// Make the picture; `progress` is told buckets done and in all.
pub fn render(
    scene: &Scene,
    options: &Options,
    camera: Camera,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> (Image, Stats) {
    let filter =
        [Filter::new(options.filter, options.filter_width[0]), Filter::new(options.filter, options.filter_width[1])];
    let jitter = Jitter::new(options.samples, camera.has_lens(), scene.moves(&camera));
    let aovs = aovs(&options.displays);
    let depth = display::depth(&aovs);
    let numbers = scene.numbers();
    let start = Instant::now();
    let bvh = Bvh::build(scene);
    let hierarchy = start.elapsed().as_secs_f64();
    let frame = Frame { scene, bvh, camera, jitter, aovs: &aovs, depth, numbers, filter, options };
    let size = options.bucket_size;
    let (columns, rows) = (options.width.div_ceil(size), options.height.div_ceil(size));
    let start = Instant::now();
    let lists = items_of_buckets(&frame, columns, rows);
    let bound = start.elapsed().as_secs_f64();
    let done = std::sync::atomic::AtomicUsize::new(0);
    let [[x0, y0], [x1, y1]] = options.window();
    let inside = |t: &Tile| t.x < x1 && t.x + t.width > x0 && t.y < y1 && t.y + t.height > y0;
    let own: Vec<Tile> = tiles(options.width, options.height, size, options.share).filter(inside).collect();
    let job = || Job {
        frame: &frame,
        samples: Samples::default(),
        instants: vec![],
        deformed: vec![],
        grid: Grid::default(),
        machine: Machine::new(),
        uniform: Vec::new(),
        varying: Vec::new(),
        directions: vec![],
        disk: Disk::default(),
        waiting: BinaryHeap::new(),
        outputs: vec![],
        held: Held::default(),
        trimmed: vec![],
        stats: Stats::default(),
        rect: [0.0; 4],
    };
    let mut image = Image::new(options.width, options.height, aovs.clone());
    let items = scene.sources.iter().map(|s| s.len() as u64).sum();
    let mut stats = Stats { items, seconds: Seconds { hierarchy, bound, ..Seconds::default() }, ..Stats::default() };
    // Jobs between buckets, so that their memory is taken once a thread.
    let idle = Mutex::new(Vec::new());
    // So many at a time that what is held beside the picture itself stays small.
    for batch in own.chunks(1024) {
        let draw = |tile: &Tile| {
            let spare = || idle.lock().unwrap_or_else(|e| e.into_inner());
            let found = spare().pop();
            let mut job = found.unwrap_or_else(&job);
            let drawn = one_bucket(&mut job, tile, &lists[tile.bucket]);
            spare().push(job);
            progress(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1, own.len());
            drawn
        };
        let drawn: Vec<(Pixels, Stats)> = batch.par_iter().with_max_len(1).map(draw).collect();
        for (tile, (pixels, took)) in batch.iter().zip(drawn) {
            stats = stats.add(took);
            for row in 0..tile.height {
                let (at, from) = ((tile.y + row) * options.width + tile.x, row * tile.width);
                image.pixels[at..][..tile.width].copy_from_slice(&pixels.color[from..][..tile.width]);
                let wide = tile.width * depth;
                image.extra[at * depth..][..wide].copy_from_slice(&pixels.extra[from * depth..][..wide]);
            }
        }
    }
    (image, stats)
}

/// The picture of a bucket: its items front to back, then its samples filtered.
fn one_bucket(job: &mut Job<'_>, tile: &Tile, items: &[(f32, Item)]) -> (Pixels, Stats) {
    let frame = job.frame;
    let (options, margin) = (frame.options, [frame.filter[0].margin(), frame.filter[1].margin()]);
    let (width, height) = (tile.width + 2 * margin[0], tile.height + 2 * margin[1]);
    let (left, top) = (tile.x as i64 - margin[0] as i64, tile.y as i64 - margin[1] as i64);
    job.samples.start(&frame.jitter, left, top, width, height, frame.aovs);
    job.rect = [left as f32, top as f32, (left + width as i64) as f32, (top + height as i64) as f32];
    job.stats = Stats::default();
    let begun = Instant::now();
    // What has waited goes before the next item if it is nearer.
    let mut items = items.iter().peekable();
    loop {
        let waiting = job.waiting.peek().filter(|w| items.peek().is_none_or(|(z, item)| w.before(*z, *item)));
        if waiting.is_some() {
            draw_waiting(job);
        } else if let Some((_, item)) = items.next() {
            draw(job, *item);
        } else {
            break;
        }
    }
    settle(job);
    let drawn = begun.elapsed().as_secs_f64();
    job.samples.resolve(frame.aovs);
    let mut pixels = job.samples.filter(&frame.filter[0], &frame.filter[1], margin, frame.aovs);
    if let Some(imager) = &options.imager {
        let (machine, points) = (&mut job.machine, &mut job.grid.points);
        imager::develop(imager, frame.scene, machine, points, [tile.x, tile.y], tile.width, &mut pixels.color);
    }
    let seconds = &mut job.stats.seconds;
    seconds.dice = drawn - seconds.sample - seconds.shade - seconds.filter;
    seconds.filter += begun.elapsed().as_secs_f64() - drawn;
    (pixels, job.stats)
}

fn draw(job: &mut Job<'_>, item: Item) {
    let view = job.frame.scene.view(item);
    instants(&job.frame.camera, &view, &mut job.instants);
    if !raster_bound(&job.frame.camera, &view, &job.instants).is_some_and(|b| job.shows(&b)) {
        return;
    }
    job.deformed.clear();
    match view.shape {
        Shape::Sphere => {
            sphere::draw(job, item, &view);
        }
        Shape::Patches(patches) => patch::draw_all(job, item, &view, patches),
    }
}

fn draw_waiting(job: &mut Job<'_>) {
    let Some(waiting) = job.waiting.pop() else { return };
    let view = job.frame.scene.view(waiting.item());
    instants(&job.frame.camera, &view, &mut job.instants);
    patch::draw_waiting(job, &view, &waiting);
}

/// The raster bound of an item over all its moments, displacement included; none where it is never in the depth range.
fn raster_bound(camera: &Camera, view: &ItemView<'_>, instants: &[motion::Instant]) -> Option<RasterBound> {
    let bounds = instants.iter().filter_map(|instant| {
        let (min, max) = camera_box(instant.to_camera * view.to_world, view);
        if min.is_finite() && max.is_finite() { camera.bound(min, max) } else { None }
    });
    bounds.reduce(RasterBound::join)
}

/// The box of an item in camera space, displacement included.
fn camera_box(m: Mat4, view: &ItemView<'_>) -> (Vec3, Vec3) {
    let (min, max) = match view.shape {
        Shape::Sphere => {
            let row = |k: usize| Vec3::new(m.x_axis[k], m.y_axis[k], m.z_axis[k]).length();
            let (center, half) = (m.w_axis.truncate(), Vec3::new(row(0), row(1), row(2)));
            (center - half, center + half)
        }
        Shape::Patches(patches) => patches
            .iter()
            .flat_map(|patch| patch.p.iter().chain(patch.moves.iter().flat_map(|(_, p)| p)))
            .map(|p| m.transform_point3(*p))
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p))),
    };
    let reach = displacement_reach(view, 0.5 * (max - min).max_element());
    (min - reach, max + reach)
}

/// For each bucket, its items with their least depth, nearest first.
fn items_of_buckets(frame: &Frame<'_>, columns: usize, rows: usize) -> Vec<Vec<(f32, Item)>> {
    let size = frame.options.bucket_size as f32;
    let margin = [frame.filter[0].margin() as f32, frame.filter[1].margin() as f32];
    let items: Vec<Item> =
        frame.scene.items().filter(|i| frame.scene.sources[i.source as usize].attributes.visible).collect();
    let bounds: Vec<_> = items
        .par_iter()
        .with_min_len(1024)
        .map_init(Vec::new, |moments, item| {
            let view = frame.scene.view(*item);
            instants(&frame.camera, &view, moments);
            raster_bound(&frame.camera, &view, moments)
        })
        .collect();
    let mut lists: Vec<Vec<(f32, Item)>> = vec![Vec::new(); columns * rows];
    for (item, bound) in items.iter().zip(bounds) {
        let Some(bound) = bound else { continue };
        let range = |lo: f32, hi: f32, margin: f32, n: usize| {
            let first = ((lo - margin) / size).floor().max(0.0);
            let last = ((hi + margin) / size).floor().min(n as f32 - 1.0);
            (first <= last).then_some(first as usize..last as usize + 1)
        };
        let across = range(bound.min.x, bound.max.x, margin[0], columns);
        let down = range(bound.min.y, bound.max.y, margin[1], rows);
        if let (Some(across), Some(down)) = (across, down) {
            for row in down {
                for column in across.clone() {
                    lists[row * columns + column].push((bound.z, *item));
                }
            }
        }
    }
    lists.par_iter_mut().for_each(|list| {
        list.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1.source, a.1.index).cmp(&(b.1.source, b.1.index))));
    });
    lists
}
