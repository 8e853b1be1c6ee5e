//! Rendering of an image: its buckets, in parallel.

use crate::cpu::bucket::{Memory, render_bucket};
use crate::cpu::frame::Frame;
use crate::cpu::samples::pixels::Pixels;
use crate::cpu::sort::items_of_buckets;
use crate::drawn::Drawn;
use crate::film::bucket::{Bucket, buckets};
use crate::film::image::Image;
use crate::scene::camera::Camera;
use crate::scene::options::Options;
use crate::scene::world::Scene;
use crate::stats::{Seconds, Stats};
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

/// Render an image; `progress` is called with the buckets done and in all.
pub fn render(scene: &Scene, options: &Options, camera: Camera, progress: &(dyn Fn(usize, usize) + Sync)) -> Drawn {
    let start = Instant::now();
    let frame = Frame::new(scene, options, camera);
    let hierarchy = start.elapsed().as_secs_f64();
    let size = options.bucket_size;
    let (columns, rows) = (options.width.div_ceil(size), options.height.div_ceil(size));
    let start = Instant::now();
    let lists = items_of_buckets(&frame, [size; 2], [columns, rows]);
    let bound = start.elapsed().as_secs_f64();
    let done = AtomicUsize::new(0);
    let [[x0, y0], [x1, y1]] = options.window();
    let inside = |t: &Bucket| t.x < x1 && t.x + t.width > x0 && t.y < y1 && t.y + t.height > y0;
    let own: Vec<Bucket> = buckets(options.width, options.height, size, options.shard).filter(inside).collect();
    let per_pixel = if options.keep_ids { options.samples[0] * options.samples[1] } else { 0 };
    let identities = vec![0; options.width * options.height * per_pixel];
    let image = Image::new(options.width, options.height, frame.aovs.clone());
    let items = scene.sources.iter().map(|s| s.len() as u64).sum();
    let mut stats = Stats { items, seconds: Seconds { hierarchy, bound, ..Seconds::default() }, ..Stats::default() };
    // Memory between buckets, so that it is taken once a thread.
    let idle = Mutex::new(Vec::<Memory>::new());
    let drawn = Mutex::new((image, identities));
    let render = |bucket: &Bucket| {
        if scene.stopped().is_some() {
            return Stats::default();
        }
        let spare = || idle.lock().unwrap_or_else(|e| e.into_inner());
        let found = spare().pop();
        let mut memory = found.unwrap_or_default();
        let (pixels, stats) = render_bucket(&frame, &mut memory, bucket, &lists[bucket.index]);
        spare().push(memory);
        {
            let (image, identities) = &mut *drawn.lock().unwrap_or_else(|e| e.into_inner());
            put(image, identities, bucket, &pixels, [per_pixel, frame.depth]);
        }
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, own.len());
        stats
    };
    let of_buckets: Vec<Stats> = own.par_iter().with_max_len(1).map(render).collect();
    stats = of_buckets.into_iter().fold(stats, Stats::add);
    let count = |of: &AtomicU64| of.load(Ordering::Relaxed);
    (stats.occlusion_rays, stats.opacity_runs) =
        (count(&frame.rays.tally.occlusion), count(&frame.rays.tally.opacities));
    let (image, identities) = drawn.into_inner().unwrap_or_else(|e| e.into_inner());
    Drawn { image, stats, identities }
}

/// Put a bucket's pixels into the image, with `per_pixel` identities and `depth` numbers of output variables each.
fn put(image: &mut Image, identities: &mut [u64], bucket: &Bucket, pixels: &Pixels, [per_pixel, depth]: [usize; 2]) {
    for row in 0..bucket.height {
        let (at, from) = ((bucket.y + row) * image.width + bucket.x, row * bucket.width);
        image.pixels[at..][..bucket.width].copy_from_slice(&pixels.color[from..][..bucket.width]);
        let kept = bucket.width * per_pixel;
        identities[at * per_pixel..][..kept].copy_from_slice(&pixels.identities[from * per_pixel..][..kept]);
        let wide = bucket.width * depth;
        image.extra[at * depth..][..wide].copy_from_slice(&pixels.extra[from * depth..][..wide]);
    }
}
