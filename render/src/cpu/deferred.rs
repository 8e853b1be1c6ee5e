//! Deferred shading: grids are sampled first, and shaded when the bucket knows which of their points are visible, at those alone.
//!
//! A grid that may be translucent is shaded before, since what it hides depends on its opacity; one whose shaders look at
//! neighbouring points is shaded whole.

use crate::cpu::frame::Frame;
use crate::cpu::micropolygon::{Micropolygon, POINT_BITS, identity};
use crate::cpu::raster::Raster;
use crate::cpu::samples::Samples;
use crate::cpu::samples::visible::{Triangle, Triangles};
use crate::cpu::shade::{Shading, Surface, shade, surface_opacity};
use crate::film::display::place_of;
use crate::scene::source::Item;
use crate::stats::Stats;
use glam::Vec3A;
use sl::Global;
use sl::machine::{Message, Points};

/// The maximum of points that are deferred.
const MAX_POINTS: usize = 1 << 19;

/// How many points of solids are deferred before these are cut, and how many times more of one than of others.
const SOLID_POINTS: usize = MAX_POINTS >> 4;
const SOLID_TIMES: usize = 8;

/// The maximum of grids that are deferred.
const MAX_GRIDS: usize = (1 << (31 - POINT_BITS)) - 1;

/// A grid, some of which is visible.
struct DeferredGrid {
    item: Item,
    points: Points,
    /// Ci and Oi are there.
    shaded: bool,
    /// How far it may be displaced, and its least depth.
    reach: f32,
    z: f32,
    /// How far its points move on the raster, if a display takes that.
    motion: Vec<[f32; 2]>,
    /// What displays take besides colour, if it is shaded.
    outputs: Vec<f32>,
    /// The same grid as shaded later, if its colour or opacity moves.
    moments: Vec<Shaded>,
}

/// A grid as shaded with the colour and opacity of a part of the time that the shutter is open.
pub struct Shaded {
    /// The part of that time.
    pub time: f32,
    /// Its points.
    pub points: Points,
    /// What displays take besides colour.
    pub outputs: Vec<f32>,
}

/// What samples need of a grid, small enough for all of them to lie close.
struct Layout {
    /// Its first point among those of all.
    first: usize,
    nu: usize,
    smooth: bool,
    matte: bool,
    /// If its colour or opacity moves: how many points it has, which are there again for each of these times.
    moments: Option<Box<(usize, Vec<f32>)>>,
}

impl Layout {
    /// Corners of a triangle among the points of all grids; of a flat one, the first alone counts.
    #[inline(always)]
    fn corners(&self, m: Micropolygon) -> [usize; 3] {
        m.corners(self.nu).map(|k| self.first + k)
    }

    /// Points from one time of its colour to the next, and which of these times are before and after a part of the time that the
    /// shutter is open: how many points on the first is, and the part of the way to the second.
    fn moment(&self, time: f32) -> Option<(usize, usize, f32)> {
        let (n, times) = self.moments.as_deref()?;
        let next = times.partition_point(|t| *t < time).min(times.len() - 1);
        let from = next.checked_sub(1).map_or(0.0, |k| times[k]);
        Some((*n, next * n, ((time - from) / (times[next] - from)).clamp(0.0, 1.0)))
    }
}

/// The colours of grids: of all points, and where each grid has its own among them.
struct Colors<'a> {
    layouts: &'a [Layout],
    color: &'a [Vec3A],
    opacity: &'a [Vec3A],
}

// By hand and inlined: every sample asks.
impl Triangles for Colors<'_> {
    #[inline(always)]
    fn still(&self, m: Micropolygon) -> Triangle {
        let layout = &self.layouts[m.grid()];
        let corners @ [a, b, c] = layout.corners(m);
        let color = [self.color[a], self.color[b], self.color[c]];
        let opacity = [self.opacity[a], self.opacity[b], self.opacity[c]];
        Triangle { color, opacity, corners, later: (0, 0.0), smooth: layout.smooth, matte: layout.matte }
    }

    fn at(&self, m: Micropolygon, time: f32) -> Triangle {
        let layout = &self.layouts[m.grid()];
        let Some((n, before, part)) = layout.moment(time) else { return self.still(m) };
        let corners = layout.corners(m).map(|k| k + before);
        let [color, opacity] = [self.color, self.opacity].map(|all| corners.map(|k| all[k].lerp(all[k + n], part)));
        Triangle { color, opacity, corners, later: (n, part), smooth: layout.smooth, matte: layout.matte }
    }
}

/// Which points of all grids are wanted.
struct Wanted<'a> {
    layouts: &'a [Layout],
    points: &'a mut [bool],
    last: Micropolygon,
}

impl Wanted<'_> {
    #[inline(always)]
    fn add(&mut self, m: Micropolygon) {
        // Neighbouring samples often see the same micropolygon.
        if m != self.last {
            self.last = m;
            let layout = &self.layouts[m.grid()];
            let [a, b, c] = layout.corners(m);
            self.points[a] = true;
            if layout.smooth {
                (self.points[b], self.points[c]) = (true, true);
            }
        }
    }
}

/// Grids with visible points, until they are flushed.
#[derive(Default)]
pub struct Deferred {
    grids: Vec<DeferredGrid>,
    layouts: Vec<Layout>,
    n: usize,
    /// Whether there are solids that are not cut.
    uncut: bool,
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

impl Deferred {
    /// The index that the next grid will have.
    pub fn next(&self) -> usize {
        self.grids.len()
    }

    /// Defer a grid with visible points, in exchange for other memory. `shaded` has what displays take of its points, if it is
    /// shaded, and the same grid as shaded later, if its colour or opacity moves.
    pub fn push(
        &mut self,
        frame: &Frame<'_>,
        surface: &Surface<'_>,
        points: &mut Points,
        raster: &Raster,
        (shaded, moments): (Option<&mut Shading>, Vec<Shaded>),
    ) {
        let Surface { item, view, reach, z, .. } = *surface;
        let points = std::mem::replace(points, self.spare.pop().unwrap_or_default());
        let first = self.n;
        self.uncut |= view.attributes.solid.is_some();
        self.n += points.n() * (1 + moments.len());
        debug_assert!(points.n() <= 1 << POINT_BITS);
        let (smooth, matte) = (view.attributes.smooth, view.attributes.matte);
        let motion = if place_of(&frame.aovs, "motion").is_some() { raster.motion().collect() } else { vec![] };
        let is_shaded = shaded.is_some();
        let outputs = shaded.map_or(vec![], |shading| std::mem::take(&mut shading.outputs));
        let times: Vec<f32> = moments.iter().map(|shaded| shaded.time).collect();
        let fades = (!times.is_empty()).then(|| Box::new((points.n(), times)));
        self.layouts.push(Layout { first, nu: points.nu, smooth, matte, moments: fades });
        self.grids.push(DeferredGrid { motion, outputs, item, points, shaded: is_shaded, reach, z, moments });
    }

    /// Whether it should be flushed before more is pushed.
    pub fn is_full(&self) -> bool {
        let most = if self.uncut { MAX_POINTS * SOLID_TIMES } else { MAX_POINTS };
        self.n >= most || self.grids.len() >= MAX_GRIDS
    }

    /// Whether parts of solids that are not whole come near to what is deferred at most: what of them is within others, or behind them, would
    /// be shaded.
    pub fn is_overfull(&self) -> bool {
        self.uncut && self.n >= MAX_POINTS * SOLID_TIMES / 4 * 3
    }

    /// Whether solids should be cut and flushed as soon as they are whole: what is hidden within others, or behind them, is not shaded.
    pub fn cuts_early(&self) -> bool {
        self.uncut && self.n >= SOLID_POINTS
    }

    /// Whether there are solids that are not cut.
    pub fn has_uncut(&self) -> bool {
        self.uncut
    }

    /// Forget all grids.
    pub fn clear(&mut self) {
        self.layouts.clear();
        self.spare.extend(self.grids.drain(..).map(|grid| grid.points));
        (self.n, self.uncut) = (0, false);
    }

    /// Leave of solids what may be seen, once all that the bucket has is there.
    pub fn cut_solids(&mut self, frame: &Frame<'_>, samples: &mut Samples) {
        self.uncut = false;
        samples.cut_solids(&frame.scene.solids, |m| !self.grids[m.grid()].shaded);
    }

    /// Shade the visible points of all grids and give the samples their colours.
    pub fn flush(&mut self, frame: &Frame<'_>, samples: &mut Samples, shading: &mut Shading, stats: &mut Stats) {
        let begun = std::time::Instant::now();
        let shaded_before = stats.seconds.shade;
        let Deferred { grids, layouts, n, uncut, wanted, color, opacity, outputs, few, gathered, spare } = self;
        let (motion, depth) = (place_of(&frame.aovs, "motion"), frame.depth);
        wanted.clear();
        wanted.resize(*n, false);
        let mut want = Wanted { layouts, points: wanted, last: Micropolygon::NONE };
        for m in samples.visible() {
            want.add(m);
        }
        samples.for_each_layer(|m| want.add(m));
        color.resize(*n, Vec3A::ZERO);
        opacity.resize(*n, Vec3A::ZERO);
        outputs.resize(*n * depth, 0.0);
        for (grid, layout) in grids.iter_mut().zip(&*layouts) {
            let range = layout.first..layout.first + grid.points.n();
            few.clear();
            few.extend(wanted[range.clone()].iter().enumerate().filter(|(_, w)| **w).map(|(k, _)| k as u32));
            if few.is_empty() {
                continue;
            }
            if layout.matte && !grid.shaded {
                // What is not shaded is opaque.
                opacity[range].fill(Vec3A::ONE);
                continue;
            }
            let view = frame.scene.view(grid.item);
            let whole = grid.shaded || view.attributes.reads_neighbours();
            if !grid.shaded {
                if !whole {
                    gather(&grid.points, view.attached.n_uniform, few, gathered);
                }
                let points = if whole { &mut grid.points } else { &mut *gathered };
                let surface = Surface { item: grid.item, view: &view, reach: grid.reach, z: grid.z, time: 0.0 };
                shade(frame, &surface, points, shading, stats);
            }
            let points = if whole { &grid.points } else { &*gathered };
            let own = if grid.shaded { &grid.outputs } else { &shading.outputs };
            let later = grid.moments.iter().map(|shaded| (&shaded.points, &shaded.outputs));
            for (moment, (points, own)) in std::iter::once((points, own)).chain(later).enumerate() {
                let n = points.n();
                let (ci, oi) = (points.get(Global::Ci).unwrap_or(&[0.0; 3]), surface_opacity(points));
                let of = |v: &[f32], k: usize| {
                    let [a, b, c] = if v.len() == 3 { [0, 1, 2] } else { [k, n + k, 2 * n + k] };
                    Vec3A::new(v[a], v[b], v[c])
                };
                let first = layout.first + moment * grid.points.n();
                for (i, k) in few.iter().enumerate() {
                    let (k, from) = (*k as usize, if whole { *k as usize } else { i });
                    (color[first + k], opacity[first + k]) = (of(ci, from), of(oi, from));
                    if depth > 0 {
                        let goal = &mut outputs[(first + k) * depth..][..depth];
                        goal.copy_from_slice(&own[from * depth..][..depth]);
                        if let (Some(first), Some(motion)) = (motion, grid.motion.get(k)) {
                            goal[first..first + 2].copy_from_slice(motion);
                        }
                    }
                }
            }
        }
        let colors = Colors { layouts, color, opacity };
        note_identities(frame, samples, grids, &colors);
        samples.set_colors(&colors, outputs);
        layouts.clear();
        spare.extend(grids.drain(..).map(|grid| grid.points));
        (*n, *uncut) = (0, false);
        let shaded = stats.seconds.shade - shaded_before;
        stats.seconds.filter += begun.elapsed().as_secs_f64() - shaded;
    }
}

/// Note what samples see that have no colour yet, if that is kept.
fn note_identities(frame: &Frame<'_>, samples: &mut Samples, grids: &[DeferredGrid], colors: &Colors<'_>) {
    if frame.options.keep_ids {
        samples.note_identities(colors, |m| {
            let grid = &grids[m.grid()];
            identity(grid.item, &grid.points, m.corners(grid.points.nu))
        });
    }
}

/// What grids have of points that are shaded later: all else is found then.
pub const OF_GRIDS: [Global; 8] = {
    use Global::{DPdtime, N, Ng, P, S, T, U, V};
    [P, N, Ng, U, V, S, T, DPdtime]
};

/// Some points of a grid, as a row of their own; the first `n_uniform` of its primitive variables are the same all over.
pub fn gather(points: &Points, n_uniform: usize, few: &[u32], out: &mut Points) {
    let n = points.n();
    (out.nu, out.nv, out.orientation) = (few.len(), 1, points.orientation);
    let of = |values: &[f32], out: &mut Vec<f32>| {
        for run in values.chunks_exact(n) {
            out.extend(few.iter().map(|k| run[*k as usize]));
        }
    };
    for global in OF_GRIDS {
        let goal = out.refill(global);
        if let Some(values) = points.get(global).filter(|v| !v.is_empty() && v.len() % n == 0) {
            of(values, goal);
        }
    }
    out.clear_variables();
    for told in &points.messages {
        let mut few_values = vec![];
        if told.values.len() >= n && told.values.len() % n == 0 {
            of(&told.values, &mut few_values);
        } else {
            few_values.clone_from(&told.values);
        }
        out.messages.push(Message { from: told.from, name: told.name.clone(), values: few_values });
    }
    for (slot, values) in points.variables().iter().enumerate() {
        let goal = out.next_variable();
        if slot < n_uniform { goal.extend_from_slice(values) } else { of(values, goal) }
    }
}
