//! Rendering of an image on a device: its windows, one after the other, each by waves from front to back.

use crate::cpu::frame::Frame;
use crate::cpu::imager;
use crate::cpu::micropolygon::identity;
use crate::cpu::samples::BLOCK;
use crate::cpu::sort::items_of_buckets;
use crate::drawn::Drawn;
use crate::film::bucket::{Bucket, buckets};
use crate::film::image::Image;
use crate::gpu::front::{Diced, Front, Window};
use crate::gpu::kernels::FrameKernels;
use crate::gpu::refusal::Refusal;
use crate::gpu::samples::Samples;
use crate::gpu::shading::Shaders;
use crate::gpu::{supported, world};
use crate::scene::camera::Camera;
use crate::scene::options::Options;
use crate::scene::source::Item;
use crate::scene::world::Scene;
use crate::stats::{Seconds, Stats};
use gpu::{Choice, Device, GpuError, Kernels};
use rayon::prelude::*;
use sl::machine::{Machine, Points};
use std::time::Instant;

/// The most samples of a window.
const WINDOW_SAMPLES: usize = 1 << 22;

/// The most pixels along a window.
const WINDOW_WIDTH: usize = 2048;

/// Points of the first wave of a window, and of the largest, about.
const WAVE: [usize; 2] = [1 << 17, 1 << 19];

/// Points, at all moments, after which what is visible is shaded before more is diced.
const MOST_POINTS: usize = 1 << 21;

/// A device that draws images, with its kernels: what is compiled for an image serves the next.
pub struct Renderer {
    device: Device,
    kernels: Kernels,
    own: FrameKernels,
}

impl Renderer {
    /// Open an adapter.
    ///
    /// # Errors
    /// Those of [`Device::open`], and of kernels that do not compile.
    pub fn open(choice: &Choice) -> Result<Renderer, GpuError> {
        let device = Device::open(choice)?;
        let kernels = Kernels::default();
        let own = FrameKernels::new(&device, &kernels)?;
        Ok(Renderer { device, kernels, own })
    }

    /// The adapter.
    pub fn adapter(&self) -> &gpu::Adapter {
        &self.device.adapter
    }

    /// Give the device up, as [`Device::lose`] does.
    pub fn lose(&self) {
        self.device.lose();
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
        self.draw(scene, options, camera, progress).map_err(|refusal| match (refusal, self.device.wait()) {
            // What has failed by it may be known before the loss.
            (Refusal::Device(_), Err(lost @ GpuError::Lost(_))) => Refusal::Device(lost),
            (refusal, _) => refusal,
        })
    }

    fn draw(
        &self,
        scene: &Scene,
        options: &Options,
        camera: Camera,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Drawn, Refusal> {
        if let Some(why) = supported::refused(scene, options) {
            return Err(Refusal::Unsupported(why));
        }
        self.device.check()?;
        let start = Instant::now();
        let frame = Frame::new(scene, options, camera);
        let mut shaders = Shaders::new(&self.device, &self.kernels, &self.own)?;
        let needs = shaders.find(&frame)?;
        shaders.set_world(&world_of(&frame, needs)?)?;
        let hierarchy = start.elapsed().as_secs_f64();
        let items = scene.sources.iter().map(|s| s.len() as u64).sum();
        let stats = Stats { items, seconds: Seconds { hierarchy, ..Seconds::default() }, ..Stats::default() };
        let mut drawing = Drawing::new(self, &frame, shaders, stats);
        drawing.windows(progress)?;
        drawing.finish()
    }
}

/// What kernels read of a scene, as far as they ask what stops light and what closes the sky.
fn world_of(frame: &Frame<'_>, [light, sky]: [bool; 2]) -> Result<Vec<[u32; 4]>, Refusal> {
    let plain = frame.rays.plain_surfaces();
    if light && let Some(why) = supported::refused_rays(frame.scene, plain.is_some()) {
        return Err(Refusal::Unsupported(why));
    }
    let id = |item: Item| frame.scene.id_of(item) as u32;
    let sky = sky.then(|| frame.rays.surroundings(frame.scene));
    Ok(world::rows(plain.filter(|_| light), sky, &id))
}

/// An image that is drawn.
struct Drawing<'a> {
    renderer: &'a Renderer,
    frame: &'a Frame<'a>,
    shaders: Shaders<'a>,
    stats: Stats,
    image: Image,
    identities: Vec<u64>,
}

impl<'a> Drawing<'a> {
    fn new(renderer: &'a Renderer, frame: &'a Frame<'a>, shaders: Shaders<'a>, stats: Stats) -> Drawing<'a> {
        let options = frame.options;
        let image = Image::new(options.width, options.height, vec![]);
        let kept = if options.keep_ids { image.pixels.len() * per_pixel(frame) } else { 0 };
        Drawing { renderer, frame, shaders, stats, image, identities: vec![0; kept] }
    }

    /// The buckets that are drawn.
    fn buckets(&self) -> Vec<Bucket> {
        let options = self.frame.options;
        let [[x0, y0], [x1, y1]] = options.window();
        let inside = |t: &Bucket| t.x < x1 && t.x + t.width > x0 && t.y < y1 && t.y + t.height > y0;
        buckets(options.width, options.height, options.bucket_size, options.shard).filter(inside).collect()
    }

    fn windows(&mut self, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<(), Refusal> {
        let (frame, renderer) = (self.frame, self.renderer);
        let (width, height) = (frame.options.width, frame.options.height);
        let across = width.min(WINDOW_WIDTH);
        let down = (WINDOW_SAMPLES / per_pixel(frame) / across).clamp(1, height);
        let (columns, rows) = (width.div_ceil(across), height.div_ceil(down));
        let margin = frame.margin();
        let [w, h] = [across + 2 * margin[0], down + 2 * margin[1]];
        let n_blocks = w.div_ceil(BLOCK) * h.div_ceil(BLOCK);
        let mut samples = Samples::new(&renderer.device, &renderer.own, frame, w * h, n_blocks)?;
        let start = Instant::now();
        let mut lists = items_of_buckets(frame, [across, down], [columns, rows]);
        self.stats.seconds.bound = start.elapsed().as_secs_f64();
        let own = self.buckets();
        for k in 0..columns * rows {
            let (x, y) = (k % columns * across, k / columns * down);
            let size = [across.min(width - x), down.min(height - y)];
            let meets = |b: &Bucket| b.x < x + size[0] && b.x + b.width > x && b.y < y + size[1] && b.y + b.height > y;
            if own.iter().any(meets) && frame.scene.stopped().is_none() {
                self.window(&mut samples, [x, y], size, std::mem::take(&mut lists[k]))?;
            }
            progress(k + 1, columns * rows);
        }
        Ok(())
    }

    /// Draw the part of the image of a size from a pixel on.
    fn window(
        &mut self,
        samples: &mut Samples<'_>,
        [x, y]: [usize; 2],
        size: [usize; 2],
        items: Vec<(f32, Item)>,
    ) -> Result<(), Refusal> {
        let (frame, margin) = (self.frame, self.frame.margin());
        let corner = [x as i64 - margin[0] as i64, y as i64 - margin[1] as i64];
        let around = [size[0] + 2 * margin[0], size[1] + 2 * margin[1]];
        let mut window = Window { corner, size: around, blocks: vec![] };
        samples.start(&window)?;
        let mut front = Front::new(frame, items);
        let (mut held, mut wave) = (vec![], WAVE[0]);
        loop {
            let grids = front.wave(&window, wave, &mut self.stats);
            if grids.is_empty() {
                break;
            }
            let start = Instant::now();
            samples.sample(frame, &grids, &mut window)?;
            self.stats.seconds.sample += start.elapsed().as_secs_f64();
            held.extend(grids);
            if samples.n_places() >= MOST_POINTS {
                self.flush(samples, &window, &mut held)?;
            }
            wave = (2 * wave).min(WAVE[1]);
        }
        self.flush(samples, &window, &mut held)?;
        let start = Instant::now();
        let pixels = samples.pixels(frame)?;
        for (row, own) in pixels.chunks_exact(size[0]).enumerate() {
            self.image.pixels[(y + row) * self.image.width + x..][..size[0]].copy_from_slice(own);
        }
        self.stats.seconds.filter += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Shade the visible points of grids that are sampled, and give the samples their colours.
    fn flush(&mut self, samples: &mut Samples<'_>, window: &Window, held: &mut Vec<Diced>) -> Result<(), Refusal> {
        if held.is_empty() {
            return Ok(());
        }
        let start = Instant::now();
        if self.frame.options.keep_ids {
            self.note_identities(&samples.visible()?, window, held);
        }
        let wanted = samples.visible_points()?;
        let colors = samples.colors()?.clone();
        self.shaders.shade(self.frame, held, &wanted, &colors, &mut self.stats)?;
        samples.set_colors()?;
        held.clear();
        self.stats.seconds.shade += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Note what the samples of a window see.
    fn note_identities(&mut self, visible: &[u32], window: &Window, held: &[Diced]) {
        let n = per_pixel(self.frame);
        let starts: Vec<usize> =
            held.iter().scan(0, |next, grid| Some(std::mem::replace(next, *next + grid.micropolygons.len()))).collect();
        let (width, height) = (self.image.width as i64, self.image.height as i64);
        for (k, id) in visible.iter().enumerate().filter(|(_, id)| **id != u32::MAX) {
            let (pixel, micropolygon) = (k / n, (*id / 2) as usize);
            let x = (pixel % window.size[0]) as i64 + window.corner[0];
            let y = (pixel / window.size[0]) as i64 + window.corner[1];
            if x < 0 || y < 0 || x >= width || y >= height {
                continue;
            }
            let k_grid = starts.partition_point(|start| *start <= micropolygon) - 1;
            let grid = &held[k_grid];
            let (first, nu) = (grid.micropolygons[micropolygon - starts[k_grid]] as usize, grid.points.nu);
            let corners =
                if id & 1 == 0 { [first, first + 1, first + nu + 1] } else { [first, first + nu + 1, first + nu] };
            self.identities[(y * width + x) as usize * n + k % n] = identity(grid.item, &grid.points, corners);
        }
    }

    /// The image, through the imager shader.
    fn finish(mut self) -> Result<Drawn, Refusal> {
        let (options, own) = (self.frame.options, self.buckets());
        let width = self.image.width;
        let mut image = Image::new(width, self.image.height, vec![]);
        let start = Instant::now();
        let of_bucket = |bucket: &Bucket| {
            let rows = (bucket.y..bucket.y + bucket.height).map(|y| y * width + bucket.x);
            let mut pixels: Vec<[f32; 4]> =
                rows.flat_map(|at| self.image.pixels[at..][..bucket.width].iter().copied()).collect();
            if let Some(imager) = &options.imager {
                imager::expose(options, self.frame.scene, &mut pixels);
                let (mut machine, mut points) = (Machine::default(), Points::default());
                let corner = [bucket.x, bucket.y];
                imager::run(imager, self.frame.scene, &mut machine, &mut points, corner, bucket.width, &mut pixels);
            }
            pixels
        };
        let finished: Vec<Vec<[f32; 4]>> = own.par_iter().map(of_bucket).collect();
        for (bucket, pixels) in own.iter().zip(finished) {
            for (row, of_row) in pixels.chunks_exact(bucket.width).enumerate() {
                image.pixels[(bucket.y + row) * width + bucket.x..][..bucket.width].copy_from_slice(of_row);
            }
        }
        self.stats.seconds.filter += start.elapsed().as_secs_f64();
        Ok(Drawn { image, stats: self.stats, identities: self.identities })
    }
}

/// Samples of a pixel.
fn per_pixel(frame: &Frame<'_>) -> usize {
    frame.jitter.strata[0] * frame.jitter.strata[1]
}
