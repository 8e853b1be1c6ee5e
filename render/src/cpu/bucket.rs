//! The bucket loop: the items of a bucket are diced front to back, their grids displaced, sampled and shaded, and the samples
//! filtered to pixels.

use crate::cpu::blur::quad::Track;
use crate::cpu::deferred::{Deferred, Shaded};
use crate::cpu::displace::{displace, face_eye};
use crate::cpu::frame::Frame;
use crate::cpu::imager;
use crate::cpu::raster::{Raster, is_mirrored, side_seen};
use crate::cpu::samples::layers::ToCome;
use crate::cpu::samples::pixels::Pixels;
use crate::cpu::samples::{SampledGrid, Samples};
use crate::cpu::shade::{Shading, Surface, shade, surface_opacity};
use crate::film::bucket::Bucket;
use crate::gprim::bound::raster_bound;
use crate::gprim::dice::Dicer;
use crate::gprim::grid::{Grid, Sink, Subject};
use crate::gprim::split::Queue;
use crate::scene::camera::RasterBound;
use crate::scene::motion::{self, instants};
use crate::scene::shape::Shape;
use crate::scene::source::Item;
use crate::stats::Stats;
use sl::machine::Points;
use std::collections::{HashMap, HashSet};
use std::time::Instant;

/// The memory of the stages, kept from bucket to bucket: each stage is given its own part.
#[derive(Default)]
pub struct Memory {
    instants: Vec<motion::Instant>,
    dicer: Dicer,
    raster: Raster,
    samples: Samples,
    shading: Shading,
    deferred: Deferred,
    pixels: Points,
}

/// Pixels along the longer edge of a bucket up to which it is drawn at once, whatever is in it.
const SMALL: usize = 8;

/// Render a bucket: at once, or in halves if there is too much in it that others are seen through.
pub fn render_bucket(
    frame: &Frame<'_>,
    memory: &mut Memory,
    bucket: &Bucket,
    items: &[(f32, Item)],
) -> (Pixels, Stats) {
    if let Some(drawn) = draw_bucket(frame, memory, bucket, items) {
        return drawn;
    }
    memory.dicer.queue.take();
    memory.dicer.queue.splits = 0;
    memory.deferred.clear();
    let [(first, stats), (second, more)] = bucket.halves().map(|half| render_bucket(frame, memory, &half, items));
    (Pixels::joined(first, second, bucket, frame.depth), stats.add(more))
}

/// Draw a bucket: its items front to back, then its samples filtered. None if it should be drawn in parts.
fn draw_bucket(
    frame: &Frame<'_>,
    memory: &mut Memory,
    bucket: &Bucket,
    items: &[(f32, Item)],
) -> Option<(Pixels, Stats)> {
    let Memory { instants: moments, dicer, raster, samples, shading, deferred, pixels: points } = memory;
    let (camera, margin, parameters) = (&frame.camera, frame.margin(), frame.needs_parameters());
    let (width, height) = (bucket.width + 2 * margin[0], bucket.height + 2 * margin[1]);
    let (left, top) = (bucket.x as i64 - margin[0] as i64, bucket.y as i64 - margin[1] as i64);
    samples.start(&frame.jitter, left, top, width, height, &frame.aovs);
    let rect = [left as f32, top as f32, (left + width as i64) as f32, (top + height as i64) as f32];
    let mut stats = Stats::default();
    let begun = Instant::now();
    let mut items = items.iter().peekable();
    // The solid that the last item is of.
    let mut solid = None;
    // How many items of each whole are still to come, once layers are packed.
    let mut wholes: Option<HashMap<u32, u32>> = None;
    let whole_of = |item: Item| frame.scene.shared_whole_of(item);
    loop {
        if samples.is_crowded(1) && !deferred.has_uncut() {
            deferred.flush(frame, samples, shading, &mut stats);
            let to_come = || items.clone().filter_map(|(_, item)| whole_of(*item));
            let wholes = wholes.get_or_insert_with(|| counted(to_come()));
            pack(frame, samples, &dicer.queue, items.peek().map(|(z, _)| *z), wholes);
        }
        if (samples.is_overfull() || deferred.is_overfull()) && bucket.width.max(bucket.height) > SMALL {
            return None;
        }
        // Between solids those that are whole may be cut, once none of their pieces waits.
        let next = items.peek().copied();
        let is_between = solid.is_some() && next.is_some_and(|(_, item)| frame.scene.root(*item) != solid);
        let cuts = is_between && deferred.cuts_early();
        // A piece that waits goes before the next item if it is nearer.
        let waiting = dicer.queue.pop_before(next.filter(|_| !cuts));
        if cuts && waiting.is_none() {
            deferred.cut_solids(frame, samples);
            deferred.flush(frame, samples, shading, &mut stats);
        }
        let Some(item) = waiting.map(|w| w.item()).or_else(|| items.next().map(|(_, item)| *item)) else { break };
        if waiting.is_none() {
            solid = frame.scene.root(item);
            let left = wholes.as_mut().and_then(|wholes| wholes.get_mut(&whole_of(item)?));
            left.into_iter().for_each(|left| *left -= 1);
        }
        let view = frame.scene.view(item);
        instants(camera, &view, moments);
        let subject = Subject { item, view: &view, instants: moments, camera, parameters };
        let mut sink = Grids { frame, rect, subject, raster, samples, shading, deferred, stats: &mut stats };
        match waiting {
            Some(waiting) => dicer.dice_waiting(&subject, &waiting, &mut sink),
            None if raster_bound(camera, &view, moments).is_some_and(|b| sink.shows(&b)) => {
                dicer.dice(&subject, &mut sink)
            }
            None => {}
        }
    }
    stats.splits = std::mem::take(&mut dicer.queue.splits);
    deferred.cut_solids(frame, samples);
    deferred.flush(frame, samples, shading, &mut stats);
    let drawn = begun.elapsed().as_secs_f64();
    samples.resolve(&frame.aovs);
    let mut pixels = samples.filter(&frame.filter, margin, &frame.aovs);
    if frame.options.keep_ids {
        pixels.identities = samples.identities(margin);
    }
    let memory = (&mut shading.machine, &mut *points);
    imager::pass(frame, memory, bucket, (&mut pixels.color, &pixels.extra));
    let seconds = &mut stats.seconds;
    seconds.dice = drawn - seconds.sample - seconds.shade - seconds.filter;
    seconds.filter += begun.elapsed().as_secs_f64() - drawn;
    Some((pixels, stats))
}

/// How many there are of each name.
fn counted(names: impl Iterator<Item = u32>) -> HashMap<u32, u32> {
    let mut all = HashMap::new();
    names.for_each(|name| *all.entry(name).or_default() += 1);
    all
}

/// Pack the layers of samples, all of which have their colours, between two items or pieces.
fn pack(
    frame: &Frame<'_>,
    samples: &mut Samples,
    queue: &Queue,
    next_item: Option<f32>,
    wholes_to_come: &HashMap<u32, u32>,
) {
    let waiting: HashSet<u64> = queue.items().map(primitive_of).collect();
    let wholes: HashSet<u32> = queue.items().filter_map(|item| frame.scene.shared_whole_of(item)).collect();
    let has_whole = |whole: u32| wholes.contains(&whole) || wholes_to_come.get(&whole).is_some_and(|n| *n > 0);
    let has = |primitive: u64, whole: Option<u32>| waiting.contains(&primitive) || whole.is_some_and(has_whole);
    let next = [queue.least_depth(), next_item].into_iter().flatten().fold(f32::INFINITY, f32::min);
    samples.pack(&ToCome { z: next, has: &has }, &frame.aovs);
}

/// The name of a primitive among samples.
fn primitive_of(item: Item) -> u64 {
    (item.source as u64) << 32 | item.index as u64
}

/// What becomes of an item's grids in a bucket: the stages after dicing, with what they read and what they write.
struct Grids<'a> {
    frame: &'a Frame<'a>,
    /// Raster bound of the samples: x0, y0, x1, y1.
    rect: [f32; 4],
    subject: Subject<'a>,
    raster: &'a mut Raster,
    samples: &'a mut Samples,
    shading: &'a mut Shading,
    deferred: &'a mut Deferred,
    stats: &'a mut Stats,
}

impl Sink for Grids<'_> {
    fn shows(&mut self, bound: &RasterBound) -> bool {
        let (min, max) = (bound.min.to_array(), bound.max.to_array());
        let [x0, y0, x1, y1] = self.rect;
        let touches = max[0] >= x0 && max[1] >= y0 && min[0] <= x1 && min[1] <= y1;
        touches && !self.samples.hides(min, max, bound.z)
    }

    /// Displace, project, shade and sample a grid.
    fn take(&mut self, grid: &mut Grid) {
        let Subject { item, view, instants, camera, .. } = self.subject;
        let displaced = view.attributes.displacement.is_some();
        if displaced && self.frame.known.bound(item, grid).is_some_and(|bound| !bound.is_some_and(|b| self.shows(&b))) {
            self.stats.grids += 1;
            self.stats.grids_hidden += 1;
            return;
        }
        displace(self.frame.scene, &self.frame.displacement_rays, &self.subject, grid, &mut self.shading.machine);
        face_eye(&self.subject, grid);
        let bound = self.raster.project(camera, instants, grid, self.frame.coplanar.behind(item));
        if displaced {
            self.frame.known.note(item, grid, bound);
        }
        let Some(bound) = bound else { return };
        self.stats.grids += 1;
        if !self.shows(&bound) {
            self.stats.grids_hidden += 1;
            return;
        }
        let surface = Surface { item, view, reach: grid.reach, z: bound.z, time: 0.0 };
        // Behind what lets nothing through nothing need be shaded to know what it hides.
        if self.samples.is_closed() && !self.sample(grid, None, true) {
            self.stats.grids_hidden += 1;
            return;
        }
        // What is surely opaque is shaded when the bucket knows which of its points are visible.
        let later = view.attributes.stays_opaque() && view.attached.opacity.is_none();
        let moments = if later { vec![] } else { self.shade_over_time(&surface, &grid.points) };
        if !later {
            shade(self.frame, &surface, &mut grid.points, self.shading, self.stats);
        }
        // All surfaces of a solid are layers until it is known which are of the whole.
        let is_opaque = later || surface_opacity(&grid.points).iter().all(|o| *o >= 1.0);
        let opaque = is_opaque
            && moments.is_empty()
            && view.attributes.solid.is_none()
            && view.attributes.seen == [0.0, 1.0]
            && self.frame.planes.is_empty();
        if !self.sample(grid, opaque.then_some(later), false) {
            return;
        }
        let shaded = if later { None } else { Some(&mut *self.shading) };
        self.deferred.push(self.frame, &surface, &mut grid.points, self.raster, (shaded, moments));
        // Of an item whose layers are more than should be there between two, all may repeat each other.
        let is_crowded = self.samples.is_crowded(2) && !self.deferred.has_uncut();
        if is_crowded || self.deferred.is_full() {
            self.deferred.flush(self.frame, self.samples, self.shading, self.stats);
        }
        if is_crowded {
            self.samples.pack(&ToCome { z: 0.0, has: &|_, _| true }, &self.frame.aovs);
        }
    }
}

impl Grids<'_> {
    /// Shade points with the colours and opacities that they have after the shutter opens, at each time that these turn.
    fn shade_over_time(&mut self, surface: &Surface<'_>, points: &Points) -> Vec<Shaded> {
        let times = surface.view.attributes.fade_times().into_iter();
        let shaded = times.map(|time| {
            let mut points = points.clone();
            shade(self.frame, &Surface { time, ..*surface }, &mut points, self.shading, self.stats);
            Shaded { time, points, outputs: std::mem::take(&mut self.shading.outputs) }
        });
        shaded.collect()
    }

    /// Whether triangles of a grid of positive area on the raster are where its primitive is entered.
    fn is_entered(&self, points: &Points) -> bool {
        let Subject { item, view, camera, .. } = self.subject;
        let outward = match view.shape {
            Shape::Sphere => (points.orientation > 0.0) != view.attributes.reversed,
            Shape::Patches(..) => self.frame.rays.is_outward(item),
        };
        outward != is_mirrored(camera)
    }

    /// Sample a projected grid, or only find whether there is a sample for it; whether any sample takes something of it. Of what is `opaque` it
    /// says whether that was known before it was shaded.
    fn sample(&mut self, grid: &Grid, opaque: Option<bool>, is_probe: bool) -> bool {
        let begun = Instant::now();
        let Subject { item, view, instants, camera, .. } = self.subject;
        let side = side_seen(camera, view, &grid.points);
        self.raster.choose(camera, side, grid);
        let Raster { at, micropolygons } = &*self.raster;
        let nu = grid.points.nu;
        let primitive = primitive_of(item);
        let solid = view.attributes.solid.map(|leaf| (leaf, self.is_entered(&grid.points)));
        let sampled = SampledGrid {
            index: self.deferred.next(),
            opaque: opaque.is_some(),
            as_layers: opaque != Some(true),
            smooth: view.attributes.smooth,
            size: [nu, grid.points.nv],
            rims: grid.origin.map_or([false; 4], |part| part.rims()),
            primitive,
            whole: self.frame.scene.shared_whole_of(item),
            seen: view.attributes.seen,
            planes: &self.frame.planes,
            solid,
            side,
            is_probe,
        };
        let jitter = &self.frame.jitter;
        // Without a lens, what stands still in an image of motion is sampled as if it moved.
        let tally = if jitter.moments.is_some() {
            self.samples.blurred(nu, micropolygons, &Track { instants, raster: at, camera, jitter }, &sampled)
        } else {
            self.samples.still(&at[0], nu, micropolygons, &sampled)
        };
        self.stats.micropolygons += if is_probe { 0 } else { micropolygons.len() as u64 };
        self.stats.samples += tally.tried;
        self.stats.seconds.sample += begun.elapsed().as_secs_f64();
        tally.hit
    }
}
