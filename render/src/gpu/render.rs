//! Rendering of an image on a device: its windows, one after the other, each by waves from front to back.

use crate::cpu::frame::Frame;
use crate::cpu::imager;
use crate::cpu::micropolygon::{Micropolygon, identity, identity_of};
use crate::cpu::samples::BLOCK;
use crate::cpu::sort::items_of_buckets;
use crate::drawn::Drawn;
use crate::film::bucket::{Bucket, buckets};
use crate::film::image::Image;
use crate::gpu::flight::{Flight, Flights};
use crate::gpu::front::{Diced, Front, Window};
use crate::gpu::kernels::FrameKernels;
use crate::gpu::layers::Layers;
use crate::gpu::limits::Limits;
use crate::gpu::outputs::Outputs;
use crate::gpu::refusal::Refusal;
use crate::gpu::samples::Samples;
use crate::gpu::shading::{Goal, Shaders};
use crate::gpu::{supported, world};
use crate::scene::camera::Camera;
use crate::scene::options::Options;
use crate::scene::source::Item;
use crate::scene::world::Scene;
use crate::stats::{DeviceSeconds, DeviceStats, Seconds, Stats};
use gpu::{Choice, Device, GpuError, Kernels};
use rayon::prelude::*;
use sl::machine::{Machine, Points};
use std::time::Instant;

/// The most pixels along a window.
const WINDOW_WIDTH: usize = 2048;

/// A device that draws images, with its kernels: what is compiled for an image serves the next.
pub struct Renderer {
    device: Device,
    kernels: Kernels,
    own: FrameKernels,
    flights: Flights,
    /// How much of a frame is on the device at a time.
    pub limits: Limits,
}

impl Renderer {
    /// Open an adapter.
    ///
    /// # Errors
    /// Those of [`Device::open`], and of kernels that do not compile.
    pub fn open(choice: &Choice) -> Result<Renderer, GpuError> {
        Renderer::new(Device::open(choice)?)
    }

    /// The same, on a device.
    ///
    /// # Errors
    /// Those of kernels that do not compile.
    pub fn new(device: Device) -> Result<Renderer, GpuError> {
        let kernels = Kernels::default();
        let own = FrameKernels::new(&device, &kernels)?;
        Ok(Renderer { device, kernels, own, flights: Flights::default(), limits: Limits::default() })
    }

    /// The adapter.
    pub fn adapter(&self) -> &gpu::Adapter {
        &self.device.adapter
    }

    /// Give the device up, as [`Device::lose`] does.
    pub fn lose(&self) {
        self.device.lose();
    }

    /// Take no more than so many bytes of the device's memory for buffers: less of a frame is there at a time. A frame that does not fit all
    /// the same is not drawn.
    pub fn limit_memory(&mut self, bytes: u64) {
        self.limits = Limits::within(bytes);
        self.flights = Flights::limited();
        self.device.limit_memory(bytes);
    }

    /// The most triangles of displaced surfaces that rays may meet: those of half of what a kernel can bind, or of a quarter of the memory.
    fn most_facets(&self) -> usize {
        let Limits { facets, .. } = self.limits;
        facets.min(self.device.adapter.max_binding as usize / (2 * world::FACET_BYTES))
    }

    /// The most bytes that buffers have taken together.
    pub fn most_memory(&self) -> u64 {
        self.device.most_memory()
    }

    /// Whether the device is lost or a command of it has failed, so that it draws nothing more.
    pub fn has_failed(&self) -> bool {
        self.device.check().is_err()
    }

    /// Render an image; `progress` is called with the windows done and in all.
    ///
    /// # Errors
    /// Why the device cannot.
    pub(crate) fn render(
        &self,
        scene: &Scene,
        options: &Options,
        camera: Camera,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Drawn, Refusal> {
        let draw = |flight: &Flight| self.draw(flight, scene, options, camera.clone(), progress);
        self.flights.draw(&self.device, draw).map_err(|refusal| match (refusal, self.device.wait()) {
            // What has failed by it may be known before the loss.
            (Refusal::Device(_), Err(lost @ GpuError::Lost(_))) => Refusal::Device(lost),
            (refusal, _) => refusal,
        })
    }

    fn draw(
        &self,
        flight: &Flight,
        scene: &Scene,
        options: &Options,
        camera: Camera,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Drawn, Refusal> {
        if let Some(why) = supported::refused(scene) {
            return Err(Refusal::Unsupported(why));
        }
        let Flight { device, kept } = flight;
        let (start, before) = (Instant::now(), (device.traffic(), device.dispatches().values().sum()));
        let frame = Frame::new(scene, options, camera);
        let mut shaders = Shaders::new(device, (&self.kernels, &self.own, kept), self.limits.values)?;
        let layered: Vec<bool> = (0..scene.sources.len()).map(|k| is_layered(&frame, k)).collect();
        let needs = shaders.materials.find(&frame, &layered)?;
        shaders.set_world(&world_of(&frame, needs, self.most_facets())?)?;
        let hierarchy = start.elapsed().as_secs_f64();
        let items = scene.sources.iter().map(|s| s.len() as u64).sum();
        let stats = Stats { items, seconds: Seconds { hierarchy, ..Seconds::default() }, ..Stats::default() };
        let mut drawing = Drawing::new((self, flight), &frame, shaders, layered, stats);
        drawing.windows(progress)?;
        let mut drawn = drawing.finish()?;
        drawn.stats.device = drawn.stats.device.map(|stats| stats.since(&before, device));
        Ok(drawn)
    }
}

/// What kernels read of a scene, as far as they ask what stops light and what closes the sky.
fn world_of(frame: &Frame<'_>, [light, sky]: [bool; 2], most: usize) -> Result<Vec<[u32; 4]>, Refusal> {
    let met = if light { Some(met_of(frame, most)?) } else { None };
    let id = |item: Item| frame.scene.id_of(item) as u32;
    let sky = sky.then(|| frame.rays.surroundings(frame.scene));
    let maps = frame.scene.textures.numbered();
    let too_large = |map| {
        Refusal::Unsupported(format!(
            "the map `{map}` is larger than textures may be in memory, which is not built for graphics devices"
        ))
    };
    world::rows(frame.scene, met, sky, &maps, &id).map_err(too_large)
}

/// What a window of an image is drawn in.
struct Room<'a> {
    samples: Samples<'a>,
    /// Layers, if the frame has some.
    layers: Option<Layers<'a>>,
    /// What displays take besides colours, if they do.
    outputs: Option<Outputs>,
}

/// What rays of shaders meet, of which so many triangles may be displaced.
fn met_of<'f>(frame: &'f Frame<'_>, most: usize) -> Result<world::Met<'f>, Refusal> {
    let surfaces = frame.rays.open_surfaces();
    if let Some(why) = supported::refused_rays(frame.scene, surfaces.is_some()) {
        return Err(Refusal::Unsupported(why));
    }
    let (bvh, displaced) = surfaces.expect("refused without");
    let many = "rays meet more displaced surfaces than fit, which is not built for graphics devices";
    let facets = displaced.map_or(Some(vec![]), |displaced| displaced.all_facets(most));
    Ok(world::Met { bvh, facets: facets.ok_or_else(|| Refusal::Unsupported(many.into()))? })
}

/// An image that is drawn.
struct Drawing<'a> {
    renderer: &'a Renderer,
    flight: &'a Flight,
    frame: &'a Frame<'a>,
    shaders: Shaders<'a>,
    /// Whether what is of a source becomes layers.
    layered: Vec<bool>,
    stats: Stats,
    image: Image,
    identities: Vec<u64>,
}

impl<'a> Drawing<'a> {
    fn new(
        (renderer, flight): (&'a Renderer, &'a Flight),
        frame: &'a Frame<'a>,
        shaders: Shaders<'a>,
        layered: Vec<bool>,
        stats: Stats,
    ) -> Drawing<'a> {
        let options = frame.options;
        let seconds = flight.device.has_timer().then(DeviceSeconds::default);
        let stats = Stats { device: Some(DeviceStats { seconds, ..DeviceStats::default() }), ..stats };
        let image = Image::new(options.width, options.height, frame.aovs.clone());
        let kept = if options.keep_ids { image.pixels.len() * per_pixel(frame) } else { 0 };
        Drawing { renderer, flight, frame, shaders, layered, stats, image, identities: vec![0; kept] }
    }

    /// The buckets that are drawn.
    fn buckets(&self) -> Vec<Bucket> {
        let options = self.frame.options;
        let [[x0, y0], [x1, y1]] = options.window();
        let inside = |t: &Bucket| t.x < x1 && t.x + t.width > x0 && t.y < y1 && t.y + t.height > y0;
        buckets(options.width, options.height, options.bucket_size, options.shard).filter(inside).collect()
    }

    /// Add up the times of what the device has been given so far, which waits for it.
    fn settle(&mut self) -> Result<(), GpuError> {
        let stages = self.flight.device.settle()?;
        if let Some(all) = self.stats.device.as_mut().and_then(|device| device.seconds.as_mut()) {
            stages.into_iter().for_each(|(stage, seconds)| all.add(stage, seconds));
        }
        Ok(())
    }

    fn count_wave(&mut self) {
        self.stats.device.iter_mut().for_each(|device| device.waves += 1);
    }

    fn windows(&mut self, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<(), Refusal> {
        let (frame, renderer) = (self.frame, self.renderer);
        let (width, height) = (frame.options.width, frame.options.height);
        let across = width.min(WINDOW_WIDTH);
        let margin = frame.margin();
        let wide = across + 2 * margin[0];
        let down = (renderer.limits.samples / numbers_of_pixel(frame) / wide).saturating_sub(2 * margin[1]);
        let down = down.clamp(1, height);
        let (columns, rows) = (width.div_ceil(across), height.div_ceil(down));
        let [w, h] = [across + 2 * margin[0], down + 2 * margin[1]];
        let (n_blocks, n_samples) = (w.div_ceil(BLOCK) * h.div_ceil(BLOCK), w * h * per_pixel(frame));
        let Renderer { kernels, own, limits, .. } = renderer;
        let Flight { device, kept } = self.flight;
        let has_layers = self.layered.iter().any(|is| *is);
        let layers = has_layers.then(|| Layers::new(device, kernels, frame, n_samples, limits.layers)).transpose()?;
        let outputs = Outputs::new(device, kernels, frame, n_samples)?;
        let mut room = Room { samples: Samples::new(device, (own, kept), frame, w * h, n_blocks)?, layers, outputs };
        let start = Instant::now();
        let mut lists = items_of_buckets(frame, [across, down], [columns, rows]);
        self.stats.seconds.bound = start.elapsed().as_secs_f64();
        let own = self.buckets();
        for k in 0..columns * rows {
            let (x, y) = (k % columns * across, k / columns * down);
            let size = [across.min(width - x), down.min(height - y)];
            let meets = |b: &Bucket| b.x < x + size[0] && b.x + b.width > x && b.y < y + size[1] && b.y + b.height > y;
            if own.iter().any(meets) && frame.scene.stopped().is_none() {
                self.window(&mut room, [x, y], size, std::mem::take(&mut lists[k]))?;
            }
            progress(k + 1, columns * rows);
        }
        let [grids, micropolygons] = room.samples.caps.left_out(device)?;
        self.stats.grids_hidden += grids;
        self.stats.micropolygons -= micropolygons;
        room.samples.keep(kept);
        self.shaders.keep();
        Ok(())
    }

    /// Draw the part of the image of a size from a pixel on.
    fn window(
        &mut self,
        room: &mut Room<'_>,
        [x, y]: [usize; 2],
        size: [usize; 2],
        items: Vec<(f32, Item)>,
    ) -> Result<(), Refusal> {
        let (frame, margin) = (self.frame, self.frame.margin());
        let corner = [x as i64 - margin[0] as i64, y as i64 - margin[1] as i64];
        let around = [size[0] + 2 * margin[0], size[1] + 2 * margin[1]];
        let mut window = Window { corner, size: around, blocks: vec![], part: [[0; 2], around] };
        room.samples.start(&window)?;
        if let Some(outputs) = &room.outputs {
            outputs.start(&self.flight.device)?;
        }
        let (later, items) = items.into_iter().partition(|(_, item)| self.layered[item.source as usize]);
        self.opaque(room, &mut window, items)?;
        self.layers(room, &mut window, later)?;
        let start = Instant::now();
        let pixels = room.samples.pixels(frame)?;
        if size == [self.image.width, self.image.height] {
            self.image.pixels = pixels;
        } else {
            for (row, own) in pixels.chunks_exact(size[0]).enumerate() {
                self.image.pixels[(y + row) * self.image.width + x..][..size[0]].copy_from_slice(own);
            }
        }
        if let Some(outputs) = &room.outputs {
            let (pixels, wide) = (outputs.pixels(&room.samples, frame)?, size[0] * frame.depth);
            for (row, own) in pixels.chunks_exact(wide).enumerate() {
                let at = (y + row) * self.image.width + x;
                self.image.extra[at * frame.depth..][..wide].copy_from_slice(own);
            }
        }
        self.stats.seconds.filter += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Draw what is opaque in a window.
    fn opaque(&mut self, room: &mut Room<'_>, window: &mut Window, items: Vec<(f32, Item)>) -> Result<(), Refusal> {
        let frame = self.frame;
        let limits = self.renderer.limits;
        // About the number of points of an item that are there at once: of a sphere of some pixels.
        room.samples.expect((32 * items.len()).min(limits.points))?;
        let mut front = Front::new(frame, items, &limits);
        let (mut held, mut wave) = (vec![], limits.wave[0]);
        loop {
            // What the wave before hides is not diced: to dice it meanwhile takes longer than to wait.
            let grids = front.wave(window, wave, &mut self.stats);
            if grids.is_empty() {
                break;
            }
            self.count_wave();
            let start = Instant::now();
            room.samples.sample(frame, &grids, window)?;
            self.settle()?;
            self.stats.seconds.sample += start.elapsed().as_secs_f64();
            held.extend(grids);
            if room.samples.n_places() >= limits.points {
                self.flush(room, window, &mut held)?;
            }
            wave = (2 * wave).min(limits.wave[1]);
        }
        self.flush(room, window, &mut held)
    }

    /// Shade the visible points of grids that are sampled, and give the samples their colours.
    fn flush(&mut self, room: &mut Room<'_>, window: &Window, held: &mut Vec<Diced>) -> Result<(), Refusal> {
        if held.is_empty() {
            return Ok(());
        }
        let Room { samples, outputs, .. } = room;
        let start = Instant::now();
        samples.part()?;
        if self.frame.options.keep_ids {
            self.note_identities(&samples.visible()?, 0, window, held);
        }
        let (wanted, bits) = samples.visible_points()?;
        if let Some(outputs) = &mut *outputs {
            outputs.reserve(&self.flight.device, samples.n_points)?;
        }
        let colors = samples.colors()?.clone();
        let outputs_of = outputs.as_ref();
        let goal = Goal { colors: &colors, opacities: None, outputs: outputs_of, caps: &samples.caps, wanted: &wanted };
        self.shaders.shade(self.frame, held, &bits, goal, &mut self.stats)?;
        if let Some(outputs) = &*outputs {
            outputs.set(samples)?;
        }
        samples.set_colors()?;
        // There are many, with memory of their own.
        held.par_drain(..).for_each(drop);
        self.stats.seconds.shade += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Draw the layers of a window, over what is opaque: all at once, or where they are too many, one part of the pixels after another.
    fn layers(&mut self, room: &mut Room<'_>, window: &mut Window, items: Vec<(f32, Item)>) -> Result<(), Refusal> {
        if items.is_empty() {
            return Ok(());
        }
        let mut parts = vec![Part { first: 0, end: window.size[0] * window.size[1] }];
        while let Some(part) = parts.pop() {
            window.part = part.rectangle(window.size[0]);
            let stats = self.stats;
            match self.dice_layers(room, window, &items, part.end - part.first > 1)? {
                Some(mut held) => self.compose(room, window, part, &mut held)?,
                None => {
                    self.stats = Stats { device: self.stats.device, ..stats };
                    let [first, second] = part.halves(window.size[0]);
                    parts.extend([second, first]);
                }
            }
        }
        Ok(())
    }

    /// Dice what becomes layers in the part of a window; none if there is too much of it, and it `can_part`.
    fn dice_layers(
        &mut self,
        room: &mut Room<'_>,
        window: &Window,
        items: &[(f32, Item)],
        can_part: bool,
    ) -> Result<Option<Vec<Diced>>, Refusal> {
        let Room { samples, layers: Some(layers), .. } = room else { return Ok(Some(vec![])) };
        let limits = self.renderer.limits;
        let mut front = Front::new(self.frame, items.to_vec(), &limits);
        let mut held: Vec<Diced> = vec![];
        loop {
            let grids = front.wave(window, limits.wave[1], &mut self.stats);
            if grids.is_empty() {
                return Ok(Some(held));
            }
            self.count_wave();
            layers.add(self.frame, samples, &grids)?;
            held.extend(grids);
            if can_part && samples.n_places().max(samples.n_points) >= limits.points {
                samples.forget();
                layers.forget();
                return Ok(None);
            }
        }
    }

    /// Find the layers of the samples of a part of a window, shade their points, and lay them over what is opaque.
    fn compose(&mut self, room: &mut Room<'_>, window: &Window, part: Part, held: &mut [Diced]) -> Result<(), Refusal> {
        let Room { samples, layers: Some(layers), outputs } = room else { return Ok(()) };
        if held.is_empty() {
            return Ok(());
        }
        let start = Instant::now();
        let [_, n] = samples.n();
        let (ranges, wanted, bits) = layers.find(samples, [part.first * n, part.end * n])?;
        self.stats.seconds.sample += start.elapsed().as_secs_f64();
        if ranges.is_empty() {
            return layers.compose(samples, &ranges, None).map_err(Refusal::from);
        }
        let start = Instant::now();
        if let Some(outputs) = &mut *outputs {
            outputs.reserve(&self.flight.device, samples.n_points)?;
        }
        let colors = samples.colors()?.clone();
        let opacities = layers.opacities(samples.n_points)?.clone();
        let goal = Goal {
            colors: &colors,
            opacities: Some(&opacities),
            outputs: outputs.as_ref(),
            caps: &samples.caps,
            wanted: &wanted,
        };
        self.shaders.shade(self.frame, held, &bits, goal, &mut self.stats)?;
        layers.compose(samples, &ranges, outputs.as_mut())?;
        if self.frame.options.keep_ids {
            for range in &ranges {
                let visible = samples.visible()?;
                self.note_identities(&visible[..range.end], range.first, window, held);
            }
        }
        self.stats.seconds.shade += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Note what the samples of a window see, from one on.
    fn note_identities(&mut self, visible: &[u32], first: usize, window: &Window, held: &[Diced]) {
        let n = per_pixel(self.frame);
        let starts: Vec<usize> =
            held.iter().scan(0, |next, grid| Some(std::mem::replace(next, *next + grid.n_micropolygons()))).collect();
        let of = |id: u32| {
            let micropolygon = (id / 2) as usize;
            let k = starts.partition_point(|start| *start <= micropolygon) - 1;
            let (grid, nu) = (&held[k], held[k].size[0]);
            let corner = grid.first_of(micropolygon - starts[k]);
            let corners = Micropolygon::new(0, corner, id & 1 == 1).corners(nu);
            match (&grid.cap, &grid.points) {
                (Some(cap), _) => {
                    let places = corners.into_iter().flat_map(|point| cap.tile.place(nu, point).to_array());
                    identity_of(grid.item, places.map(f32::to_bits))
                }
                (None, Some(points)) => identity(grid.item, points, corners),
                (None, None) => 0,
            }
        };
        let [width, height] = window.size;
        let wide = self.image.width * n;
        self.identities.par_chunks_mut(wide).enumerate().for_each(|(y, row)| {
            let y = y as i64 - window.corner[1];
            if !(0..height as i64).contains(&y) {
                return;
            }
            // Neighbours often see the same.
            let mut last = (u32::MAX, 0);
            for (k, own) in row.iter_mut().enumerate() {
                let x = (k / n) as i64 - window.corner[0];
                let sample = (y as usize * width + x.max(0) as usize) * n + k % n;
                let id = visible.get(sample).filter(|_| (0..width as i64).contains(&x) && sample >= first);
                if let Some(id) = id.filter(|id| **id != u32::MAX) {
                    if last.0 != *id {
                        last = (*id, of(*id));
                    }
                    *own = last.1;
                }
            }
        });
    }

    /// The image, through the imager shader.
    fn finish(mut self) -> Result<Drawn, Refusal> {
        let (options, own) = (self.frame.options, self.buckets());
        let width = self.image.width;
        let depth = self.frame.depth;
        self.shaders.materials.report(self.frame.scene)?;
        self.settle()?;
        let start = Instant::now();
        let n_drawn: usize = own.iter().map(|bucket| bucket.width * bucket.height).sum();
        if options.imager.is_none() && self.frame.shown.is_none() && n_drawn == self.image.pixels.len() {
            // All of it is drawn, and nothing is left to do.
            return Ok(Drawn { image: self.image, stats: self.stats, identities: self.identities });
        }
        let mut image = Image::new(width, self.image.height, self.frame.aovs.clone());
        let of_bucket = |bucket: &Bucket| {
            let rows = (bucket.y..bucket.y + bucket.height).map(|y| y * width + bucket.x);
            let mut pixels: Vec<[f32; 4]> =
                rows.clone().flat_map(|at| self.image.pixels[at..][..bucket.width].iter().copied()).collect();
            let extra: Vec<f32> =
                rows.flat_map(|at| self.image.extra[at * depth..][..bucket.width * depth].iter().copied()).collect();
            let memory = (&mut Machine::default(), &mut Points::default());
            imager::pass(self.frame, memory, bucket, (&mut pixels, &extra));
            pixels
        };
        let finished: Vec<Vec<[f32; 4]>> = own.par_iter().map(of_bucket).collect();
        for (bucket, pixels) in own.iter().zip(finished) {
            for (row, of_row) in pixels.chunks_exact(bucket.width).enumerate() {
                let (at, wide) = ((bucket.y + row) * width + bucket.x, bucket.width * depth);
                image.pixels[at..][..bucket.width].copy_from_slice(of_row);
                image.extra[at * depth..][..wide].copy_from_slice(&self.image.extra[at * depth..][..wide]);
            }
        }
        self.stats.seconds.filter += start.elapsed().as_secs_f64();
        Ok(Drawn { image, stats: self.stats, identities: self.identities })
    }
}

impl DeviceSeconds {
    /// Add the time of a stage, as [`staged`](crate::gpu::kernels::staged) names it.
    fn add(&mut self, stage: &str, seconds: f64) {
        *match stage {
            "dice" => &mut self.dice,
            "sample" => &mut self.sample,
            "filter" => &mut self.filter,
            _ => &mut self.shade,
        } += seconds;
    }
}

/// Some pixels of a window, row by row: several rows, or some of one.
#[derive(Clone, Copy)]
struct Part {
    first: usize,
    end: usize,
}

impl Part {
    /// The first pixel, and the one after the last, of a window of a width.
    fn rectangle(self, width: usize) -> [[usize; 2]; 2] {
        let [x0, x1] = if self.is_wide(width) { [0, width] } else { [self.first % width, (self.end - 1) % width + 1] };
        [[x0, self.first / width], [x1, (self.end - 1) / width + 1]]
    }

    fn is_wide(self, width: usize) -> bool {
        self.end - self.first >= width
    }

    fn halves(self, width: usize) -> [Part; 2] {
        let Part { first, end } = self;
        let unit = if end - first > width { width } else { 1 };
        let middle = first + (end - first) / unit / 2 * unit;
        [Part { first, end: middle }, Part { first: middle, end }]
    }
}

/// Whether what is of a source becomes layers, as on the processor: what is surely opaque, whole and always the same does not.
fn is_layered(frame: &Frame<'_>, source: usize) -> bool {
    let own = &frame.scene.sources[source];
    if own.len() == 0 {
        return false;
    }
    supported::is_translucent(own) || own.attributes.seen != [0.0, 1.0] || !frame.planes.is_empty()
}

/// Numbers of a pixel that take as much room as its samples and what displays take of these.
fn numbers_of_pixel(frame: &Frame<'_>) -> usize {
    per_pixel(frame) * (4 + frame.depth) / 4
}

/// Samples of a pixel.
fn per_pixel(frame: &Frame<'_>) -> usize {
    frame.jitter.strata[0] * frame.jitter.strata[1]
}
