//! The levels of a film: which brightness becomes black, and which white. They are measured once, of its first, middle and last frame
//! drawn small, and the same for all its images, so that nothing flickers.

use crate::displays::context;
use bind::binding::{BLACK, Binding, Quality, WHITE};
use bind::data::Source;
use bind::{Moment, emit};
use render::ri::files::Files;

/// The longer side of the images that are measured, pixels, and that of a draft's.
const SIDE: [u32; 2] = [240, 160];
/// The samples along the sides of their pixels, at most.
const SAMPLES: u32 = 2;
/// Values of 8 bits at or below which a pixel is dark, and at or above which it is bright.
const DARK: f32 = 12.0 / 255.0;
const BRIGHT: f32 = 240.0 / 255.0;
/// The shares of a small image that are to be dark and bright, at least, for a thousandth of one in full size: highlights are smaller there.
const DARK_SHARE: f64 = 0.0014;
const BRIGHT_SHARE: f64 = 0.0018;
/// The share that levels may make bright, at most.
const MOST_BRIGHT: f64 = 0.025;
/// How far levels go.
const HIGHEST_BLACK: f64 = 0.5;
const LOWEST_WHITE: f64 = 0.7;
/// The steps by which levels are looked for.
const STEP: f64 = 0.01;

/// Measure the levels of a binding's film where they are open: they are changed no more than it takes for each of the frames to have some black
/// and some white. Frames that cannot be drawn are left out: why, is said where they are drawn.
pub fn settle(binding: &mut Binding, source: &Source, files: &Files) {
    if !emit::levels_are_open(binding, files) {
        return;
    }
    // Of the frames that there will be, so that one that is lost and comes again changes nothing.
    let numbers = source.expected();
    let draft = binding.output.quality == Quality::Draft;
    let [first, middle, last] = [0, numbers.len() / 2, numbers.len().saturating_sub(1)].map(|k| numbers.get(k));
    let mut chosen: Vec<u64> =
        if draft { vec![first] } else { vec![first, middle, last] }.into_iter().flatten().copied().collect();
    chosen.dedup();
    let small = small(binding, draft);
    let images: Vec<Vec<[f32; 3]>> = chosen.iter().filter_map(|frame| draw(&small, source, *frame, files)).collect();
    // What has been read for it is not what an image depends on.
    guard::trace();
    let Some([low, high]) = (!images.is_empty()).then(|| levels_of(&images)) else { return };
    binding.output.levels = Some([low, high]);
    if [low, high] != [BLACK, WHITE] {
        eprintln!("note: of the film's brightness, {low} becomes black and {high} white: `levels: [{low}, {high}]`");
    }
}

/// The binding with images that are small.
fn small(binding: &Binding, draft: bool) -> Binding {
    let mut small = binding.clone();
    let output = &mut small.output;
    let side = output.resolution[0].max(output.resolution[1]);
    let most = SIDE[draft as usize].min(side);
    output.resolution = output.resolution.map(|n| (n as u64 * most as u64 / side as u64).max(1) as u32);
    output.samples = output.samples.map(|n| n.min(SAMPLES));
    if output.quality == Quality::Final {
        let samples = output.samples;
        output.set_quality(Quality::Normal);
        output.samples = samples;
    }
    small
}

/// The colours of a frame's pixels as a screen shows them; none if it cannot be drawn.
fn draw(binding: &Binding, source: &Source, frame: u64, files: &Files) -> Option<Vec<[f32; 3]>> {
    let table = source.shared(frame).ok()?;
    let moment = Moment::of(binding, source, &table).ok()?;
    let mut context = context(files).ok()?;
    emit::frame(binding, &moment, "levels.png", files, &mut context).ok()?;
    let pixels = &context.results.last()?.image.pixels;
    Some(pixels.iter().map(|p| [p[0], p[1], p[2]]).collect())
}

/// The levels by which each image has some black and some white.
fn levels_of(images: &[Vec<[f32; 3]>]) -> [f64; 2] {
    let roots: Vec<Vec<[f32; 3]>> = images.iter().map(|image| image.iter().map(|p| p.map(root)).collect()).collect();
    let shares = |levels: [f64; 2], is: &dyn Fn(f32) -> bool| -> Vec<f64> {
        let curve = Levels::new(levels);
        let share = |image: &Vec<[f32; 3]>| image.iter().filter(|p| is(curve.brightness(**p))).count() as f64;
        roots.iter().map(|image| share(image) / image.len() as f64).collect()
    };
    let [dark, bright] = [root(DARK), root(BRIGHT)];
    let whites = |k: usize| shares([BLACK, step(WHITE, k, -1.0)], &|y| y >= bright);
    // Whites first: what becomes white does so whatever is black. As many as are wanted, but not too many in any image.
    let n = ((WHITE - LOWEST_WHITE) / STEP).round() as usize;
    let wanted = first(n, |k| whites(k).iter().all(|share| *share >= BRIGHT_SHARE));
    let most = first(n + 1, |k| whites(k).iter().any(|share| *share > MOST_BRIGHT)).saturating_sub(1);
    let white = step(WHITE, wanted.min(most), -1.0);
    let n = ((HIGHEST_BLACK - BLACK) / STEP).round() as usize;
    let blacks = |k: usize| shares([step(BLACK, k, 1.0), white], &|y| y <= dark);
    [step(BLACK, first(n, |k| blacks(k).iter().all(|share| *share >= DARK_SHARE)), 1.0), white]
}

/// A value some steps up or down, of two digits.
fn step(from: f64, k: usize, way: f64) -> f64 {
    ((from + way * k as f64 * STEP) / STEP).round() / (1.0 / STEP).round()
}

/// The first number below `n` that is so, if those after it are, too; `n` if none is.
fn first(n: usize, is: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, n);
    while low < high {
        let middle = (low + high) / 2;
        if is(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

/// The root of light of what a screen shows.
fn root(x: f32) -> f32 {
    x.clamp(0.0, 1.0).powf(1.1)
}

/// The curve of levels as the shaders of the library have it (`film.h`), over roots of light.
struct Levels {
    dark: f32,
    bright: f32,
    is_none: bool,
}

impl Levels {
    fn new([low, high]: [f64; 2]) -> Levels {
        Levels { dark: root(low as f32), bright: root(high as f32), is_none: [low, high] == [BLACK, WHITE] }
    }

    /// What a value becomes.
    fn level(&self, x: f32) -> f32 {
        let [black, white] = [root(BLACK as f32), root(WHITE as f32)];
        let slope = (1.0 - black) / (1.0 - self.dark);
        let toe = slope * self.dark / black;
        let high = black + slope * (self.bright - self.dark);
        let (from, lift) = (0.6 * high, white - high);
        let shoulder = (1.0 + 2.0 * lift / (high - from)) * (1.0 - high) / (1.0 - white);
        let t = (x / self.dark).min(1.0);
        let y = black * t / (t + toe * (1.0 - t)) + slope * (x - self.dark).clamp(0.0, 1.0);
        let q = ((y - from) / (high - from)).clamp(0.0, 1.0);
        let u = ((1.0 - y) / (1.0 - high)).clamp(0.0, 1.0);
        y.min(high) + lift * q * q + (1.0 - white) * (1.0 - u / (u + shoulder * (1.0 - u)))
    }

    /// The brightness of a colour, as a root of light.
    fn brightness(&self, root: [f32; 3]) -> f32 {
        let mix = |c: [f32; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        let y = mix(root);
        if self.is_none {
            return y;
        }
        let plain = self.level(y) / y.max(1e-5);
        mix(root.map(|x| (0.5 * (x * plain + self.level(x))).min(1.0)))
    }
}
