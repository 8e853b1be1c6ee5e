//! What samples see: grids are sampled first, and shaded when the bucket knows what of them is seen, at those points alone.
//!
//! A grid that may be half transparent is shaded before, since what it hides hangs on its opacity; one whose shaders look at
//! neighbouring points is shaded whole.

use crate::cpu::bucket::Job;
use crate::cpu::samples::Triangle;
use crate::cpu::shade::{shade, surface_opacity};
use crate::film::display::place_of;
use crate::scene::source::Item;
use glam::Vec3A;
use sl::machine::Points;

/// One triangle of a micropolygon of a grid of the bucket: the grid's number, the number of its first point, and which of the
/// two triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Micropolygon(u32);

/// Bits of a point's number.
const POINT_BITS: u32 = 11;

/// Points that are held at most before they are shaded, as far as they are seen by then.
const MOST_POINTS: usize = 1 << 19;

/// Grids that are held at most.
const MOST_GRIDS: usize = (1 << (31 - POINT_BITS)) - 1;

impl Micropolygon {
    /// None.
    pub const NONE: Micropolygon = Micropolygon(u32::MAX);

    /// Of a grid, a first point, and which triangle.
    #[inline(always)]
    pub fn new(grid: usize, point: usize, second: bool) -> Micropolygon {
        Micropolygon((grid << (POINT_BITS + 1) | point << 1 | second as usize) as u32)
    }

    /// All of it as a number.
    #[inline(always)]
    pub fn number(self) -> u32 {
        self.0
    }

    /// Of [`Self::number`].
    #[inline(always)]
    pub fn of_number(number: u32) -> Micropolygon {
        Micropolygon(number)
    }

    #[inline(always)]
    fn grid(self) -> usize {
        (self.0 >> (POINT_BITS + 1)) as usize
    }

    #[inline(always)]
    fn point(self) -> usize {
        (self.0 >> 1) as usize & ((1 << POINT_BITS) - 1)
    }

    /// Corners of the triangle, in rows of `nu` points.
    #[inline(always)]
    fn corners(self, nu: usize) -> [usize; 3] {
        let k = self.point();
        if self.0 & 1 == 0 { [k, k + 1, k + nu + 1] } else { [k, k + nu + 1, k + nu] }
    }
}

/// A grid that samples see.
struct Seen {
    item: Item,
    points: Points,
    /// Ci and Oi are there.
    shaded: bool,
    /// How far it may be displaced, and its least depth.
    reach: f32,
    z: f32,
    /// Of its primitive variables, how many are the same all over.
    uniform: usize,
    /// How far its points move on the raster, if a display takes that.
    motion: Vec<[f32; 2]>,
    /// What displays take besides colour, if it is shaded.
    outputs: Vec<f32>,
}

/// What samples need to know of a grid, small enough for all of them to lie close.
struct Brief {
    /// Its first point among those of all.
    first: usize,
    nu: usize,
    smooth: bool,
    matte: bool,
}

impl Brief {
    /// Corners of a triangle among the points of all grids; of a flat one, the first alone counts.
    #[inline(always)]
    fn corners(&self, m: Micropolygon) -> [usize; 3] {
        m.corners(self.nu).map(|k| self.first + k)
    }
}

/// The grids of a bucket that are seen.
#[derive(Default)]
pub struct Held {
    grids: Vec<Seen>,
    briefs: Vec<Brief>,
    n: usize,
    wanted: Vec<bool>,
    color: Vec<Vec3A>,
    opacity: Vec<Vec3A>,
    /// What displays take besides colour.
    outputs: Vec<f32>,
    /// Points of one grid that are wanted, and what is gathered of them.
    few: Vec<u32>,
    gathered: Points,
    spare: Vec<Points>,
}

impl Held {
    /// The number that the next grid will have.
    pub fn next(&self) -> usize {
        self.grids.len()
    }
}

/// Keep the grid at hand, which samples see; `reach` is how far it may be displaced, `z` its least depth.
pub fn hold(job: &mut Job<'_>, item: Item, shaded: bool, reach: f32, z: f32) {
    let held = &mut job.held;
    let attributes = job.frame.scene.attributes(item);
    let points = std::mem::replace(&mut job.grid.points, held.spare.pop().unwrap_or_default());
    let first = held.n;
    held.n += points.n();
    debug_assert!(points.n() <= 1 << POINT_BITS);
    let (smooth, matte) = (attributes.smooth, attributes.matte);
    let uniform = job.grid.uniform;
    let motion = if place_of(job.frame.aovs, "motion").is_some() { job.grid.motion().collect() } else { vec![] };
    let outputs = if shaded { std::mem::take(&mut job.outputs) } else { vec![] };
    held.briefs.push(Brief { first, nu: points.nu, smooth, matte });
    held.grids.push(Seen { motion, outputs, item, uniform, points, shaded, reach, z });
    if held.n >= MOST_POINTS || held.grids.len() >= MOST_GRIDS {
        settle(job);
    }
}

/// Shade what is seen and give the samples its colours.
pub fn settle(job: &mut Job<'_>) {
    let mut held = std::mem::take(&mut job.held);
    let begun = std::time::Instant::now();
    let shading = job.stats.seconds.shade;
    let Held { grids, briefs, n, wanted, color, opacity, outputs, few, gathered, spare } = &mut held;
    let (motion, depth) = (place_of(job.frame.aovs, "motion"), job.frame.depth);
    wanted.clear();
    wanted.resize(*n, false);
    // Neighbouring samples often see the same micropolygon.
    let mut last = Micropolygon::NONE;
    job.samples.for_each_seen(|m| {
        if m != last {
            last = m;
            let brief = &briefs[m.grid()];
            let [a, b, c] = brief.corners(m);
            wanted[a] = true;
            if brief.smooth {
                (wanted[b], wanted[c]) = (true, true);
            }
        }
    });
    color.resize(*n, Vec3A::ZERO);
    opacity.resize(*n, Vec3A::ZERO);
    outputs.resize(*n * depth, 0.0);
    for (grid, brief) in grids.iter_mut().zip(&*briefs) {
        let range = brief.first..brief.first + grid.points.n();
        few.clear();
        few.extend(wanted[range.clone()].iter().enumerate().filter(|(_, w)| **w).map(|(k, _)| k as u32));
        if few.is_empty() || brief.matte && !grid.shaded {
            continue;
        }
        let view = job.frame.scene.view(grid.item);
        let whole = grid.shaded || view.attributes.reads_neighbours();
        if !grid.shaded {
            if !whole {
                gather(&grid.points, grid.uniform, few, gathered);
            }
            let points = if whole { &mut grid.points } else { &mut *gathered };
            shade(job, grid.item, &view, points, grid.reach, grid.z);
        }
        let points = if whole { &grid.points } else { &*gathered };
        let n = points.n();
        let (ci, oi) = (points.get("Ci").unwrap_or(&[0.0; 3]), surface_opacity(points));
        let of = |v: &[f32], k: usize| {
            let [a, b, c] = if v.len() == 3 { [0, 1, 2] } else { [k, n + k, 2 * n + k] };
            Vec3A::new(v[a], v[b], v[c])
        };
        let (color, opacity) = (&mut color[range.clone()], &mut opacity[range]);
        for (i, k) in few.iter().enumerate() {
            let (k, from) = (*k as usize, if whole { *k as usize } else { i });
            (color[k], opacity[k]) = (of(ci, from), of(oi, from));
            if depth > 0 {
                let own = if grid.shaded { &grid.outputs } else { &job.outputs };
                let goal = &mut outputs[(brief.first + k) * depth..][..depth];
                goal.copy_from_slice(&own[from * depth..][..depth]);
                if let (Some(first), Some(motion)) = (motion, grid.motion.get(k)) {
                    goal[first..first + 2].copy_from_slice(motion);
                }
            }
        }
    }
    let look = |m: Micropolygon| {
        let brief = &briefs[m.grid()];
        let corners = brief.corners(m);
        let (smooth, matte) = (brief.smooth, brief.matte);
        Triangle { color: corners.map(|k| color[k]), opacity: corners.map(|k| opacity[k]), corners, smooth, matte }
    };
    job.samples.paint(look, outputs);
    briefs.clear();
    spare.extend(grids.drain(..).map(|grid| grid.points));
    *n = 0;
    job.held = held;
    let shading = job.stats.seconds.shade - shading;
    job.stats.seconds.filter += begun.elapsed().as_secs_f64() - shading;
}

/// Some points of a grid, as a row of their own; the first `uniform` of its primitive variables are the same all over.
fn gather(points: &Points, uniform: usize, few: &[u32], out: &mut Points) {
    let n = points.n();
    (out.nu, out.nv, out.orientation) = (few.len(), 1, points.orientation);
    let of = |values: &[f32], out: &mut Vec<f32>| {
        for run in values.chunks_exact(n) {
            out.extend(few.iter().map(|k| run[*k as usize]));
        }
    };
    for name in ["P", "N", "u", "v", "s", "t"] {
        let goal = out.refill(name);
        if let Some(values) = points.get(name).filter(|v| !v.is_empty() && v.len() % n == 0) {
            of(values, goal);
        }
    }
    out.inputs.clear();
    out.inputs.extend_from_slice(&points.inputs[..uniform]);
    for (name, values) in &points.inputs[uniform..] {
        let mut goal = Vec::new();
        of(values, &mut goal);
        out.inputs.push((name.clone(), goal));
    }
}
