//! Layers of samples, seen one behind the other, and how many of them become one.
//!
//! A sample's layers are composited from front to back. What has been laid together so far is the same whether it is one layer or
//! several, so that layers in front of all that a bucket has still to come, and those at the very same depth, may be packed to one
//! at any time, and what is behind layers that let nothing through may be left out, without a change of the image.

use crate::cpu::micropolygon::Micropolygon;
use crate::cpu::samples::{Layer, NO_PRIMITIVE, NONE, Samples};
use crate::film::display::{Aov, placed};
use sl::ir::Kind;

/// The part of light that counts as none: what is behind that little changes no digit of what is before it.
const CLOSED: f32 = 1.0 / (1u64 << 40) as f32;

/// The same where a layer may still turn out to be another's repetition.
const SURELY_CLOSED: f32 = 1.0 / (1u64 << 60) as f32;

/// Two layers of a primitive that are met at sides of grids and nearer to each other than this part of their depth are one: a sample on a side
/// that two grids share meets both. On steep surfaces they may be as far from each other as the surface is across the widened edges. So are layers of
/// two faces of a mesh, where the sample lies on an edge of one of them: elsewhere they are sheets of it that coincide.
const SAME: f32 = 1e-4;

/// The same of what is met at one depth, but for rounding, at sides of grids or not: of ribbons that lie over each other where curves bend.
const COINCIDENT: f32 = 2e-6;

/// Layers of a sample up to which each is compared with those before it.
const FEW: usize = 32;

/// Layers before they are packed for the first time, and the maximum after it.
const MIN_ROOM: usize = 1 << 18;
const MAX_LAYERS: usize = 1 << 21;

impl Layer {
    /// Whether it is seen before what is opaque at a depth.
    #[inline]
    pub(super) fn is_before(&self, z: f32) -> bool {
        self.z < z || self.last && self.z == z
    }

    /// Give it its colour and opacity.
    pub(super) fn paint(&mut self, color: [f32; 3], opacity: [f32; 3], matte: bool) {
        let opacity = opacity.map(|o| o.clamp(0.0, 1.0));
        let mean = (opacity[0] + opacity[1] + opacity[2]) / 3.0;
        self.color = if matte { [0.0; 3] } else { color };
        self.open = opacity.map(|o| 1.0 - o);
        self.alpha = if matte { [0.0; 3] } else { opacity };
        self.half_z = if mean >= 0.5 { self.z } else { f32::INFINITY };
    }

    /// Lay something behind it, which makes both one; `own` and `behind` are what displays take of them besides colour: colours by the
    /// opacity, other values of what is half opaque.
    fn lay(&mut self, next: &Layer, own: &mut [f32], behind: &[f32], aovs: &[Aov]) {
        let takes = self.half_z == f32::INFINITY && next.half_z < f32::INFINITY;
        for (first, aov) in placed(aovs) {
            for c in 0..aov.width() {
                let k = first + c;
                match aov.kind {
                    Kind::Color => own[k] += self.open[c] * behind[k],
                    _ if takes => own[k] = behind[k],
                    _ => {}
                }
            }
        }
        for c in 0..3 {
            self.color[c] += self.open[c] * next.color[c];
            self.alpha[c] += self.open[c] * next.alpha[c];
            self.open[c] *= next.open[c];
        }
        self.half_z = self.half_z.min(next.half_z);
    }
}

/// Light that is left behind layers.
#[derive(Clone, Copy)]
struct Left([f32; 3]);

impl Left {
    const ALL: Left = Left([1.0; 3]);

    fn behind(v: &Layer) -> Left {
        Left(v.open)
    }

    fn pass(&mut self, v: &Layer) {
        self.0.iter_mut().zip(Left::behind(v).0).for_each(|(left, open)| *left *= open);
    }

    fn is_below(&self, part: f32) -> bool {
        self.0.iter().all(|left| left.abs() < part)
    }
}

/// The layers of a sample, nearest first, and which of them repeat another.
#[derive(Default)]
struct Line {
    layers: Vec<u32>,
    repeats: Vec<bool>,
    by_name: Vec<u32>,
    /// Another face was met with them.
    joined: Vec<bool>,
}

impl Line {
    /// Find the layers of a primitive that are the same as one of it before them.
    fn find_repeats(&mut self, all: &[Layer]) {
        let Line { layers, repeats, by_name, .. } = self;
        let of = |k: usize| &all[layers[k] as usize];
        let n = layers.len();
        repeats.clear();
        repeats.resize(n, false);
        if n <= FEW {
            for k in 1..n {
                let v = of(k);
                let counts = |before: &usize| of(*before).primitive == v.primitive && !repeats[*before];
                let is_one = v.primitive != NO_PRIMITIVE && {
                    let mut near = (0..k).rev().take_while(|before| is_near(of(*before), v, COINCIDENT));
                    near.any(|before| counts(&before))
                        || v.at_edge.grid && {
                            let mut at_edges = (0..k).rev().filter(|before| of(*before).at_edge.grid);
                            at_edges.find(counts).is_some_and(|before| is_within_slack(of(before), v, SAME))
                        }
                };
                repeats[k] = is_one;
            }
        } else {
            by_name.clear();
            by_name.extend((0..n as u32).filter(|k| of(*k as usize).primitive != NO_PRIMITIVE));
            by_name.sort_unstable_by_key(|k| (of(*k as usize).primitive, *k));
            let (mut before, mut at_edge): (Option<&Layer>, Option<&Layer>) = (None, None);
            for k in by_name.iter() {
                let v = of(*k as usize);
                let is_of = |before: &&Layer| before.primitive == v.primitive;
                let is_one = before.filter(is_of).is_some_and(|before| is_near(before, v, COINCIDENT))
                    || at_edge.filter(is_of).is_some_and(|before| is_within_slack(before, v, SAME));
                if is_one {
                    repeats[*k as usize] = true;
                    continue;
                }
                before = Some(v);
                if v.at_edge.grid {
                    at_edge = before;
                }
            }
        }
        if n > 1 && (0..n).any(|k| of(k).whole.is_some() && of(k).at_edge.primitive) {
            self.join_faces(all);
        }
    }

    /// Find the layers of faces of a mesh that are met on an edge that another face has, too: those at one depth, and then what is left of
    /// those on edges, where faces that lean to each other are met beside their edge.
    fn join_faces(&mut self, all: &[Layer]) {
        let Line { layers, repeats, by_name, joined } = self;
        let of = |k: u32| &all[layers[k as usize] as usize];
        by_name.clear();
        by_name.extend((0..layers.len() as u32).filter(|k| of(*k).whole.is_some() && !repeats[*k as usize]));
        by_name.sort_unstable_by_key(|k| (of(*k).whole, *k));
        joined.clear();
        joined.resize(layers.len(), false);
        for (tolerance, again) in [(COINCIDENT, true), (SAME, false)] {
            let mut last: Option<u32> = None;
            for k in by_name.iter().copied() {
                if repeats[k as usize] {
                    continue;
                }
                let v = of(k);
                let waits = |k: u32, joined: &[bool]| of(k).at_edge.primitive && (again || !joined[k as usize]);
                let goes_on = |before: &u32| {
                    let near = is_near(of(*before), v, tolerance) || is_within_slack(of(*before), v, tolerance);
                    of(*before).whole == v.whole && near && (waits(*before, joined) || waits(k, joined))
                };
                match last.filter(goes_on) {
                    Some(before) => (repeats[k as usize], joined[before as usize]) = (true, true),
                    None => last = Some(k),
                }
            }
        }
    }
}

/// Whether the depths of two layers, the first the nearer one, differ by no more than a part of it.
#[inline]
fn is_near(before: &Layer, v: &Layer, part: f32) -> bool {
    v.z - before.z <= part * v.z
}

/// The same where both are met at sides of grids: their depths may differ as they do across these.
#[inline]
fn is_within_slack(before: &Layer, v: &Layer, part: f32) -> bool {
    let (a, b) = (before.at_edge, v.at_edge);
    a.grid && b.grid && v.z - before.z <= part * v.z + (a.slack + b.slack)
}

/// What is still to come, as layers are packed.
pub struct ToCome<'a> {
    /// Its least depth.
    pub z: f32,
    /// Whether some of a primitive is among it, or of the whole that this is a part of.
    pub has: &'a dyn Fn(u64, Option<u32>) -> bool,
}

impl Samples {
    /// Forget all layers.
    pub(super) fn clear_layers(&mut self) {
        self.layers.clear();
        self.layers.shrink_to(MAX_LAYERS);
        self.packed.0.shrink_to(MAX_LAYERS);
        self.layer_outputs.clear();
        (self.n_colored, self.room, self.closed) = (0, MIN_ROOM, false);
    }

    /// Whether there are so many layers, or so many times more, that they should be packed.
    pub fn is_crowded(&self, times: usize) -> bool {
        self.layers.len() >= self.room * times
    }

    /// Whether there are more layers than a bucket should have.
    pub fn is_overfull(&self) -> bool {
        self.layers.len() >= MAX_LAYERS
    }

    /// Whether layers have closed samples to what is behind them.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// The layers of a sample that are seen, nearest first; of what is equally near, what came first.
    fn line_up(&self, k: usize, line: &mut Line) {
        let layers = &mut line.layers;
        layers.clear();
        let mut at = self.list[k];
        while at != NONE {
            let v = &self.layers[at as usize];
            if v.is_before(self.z[k]) {
                layers.push(at);
            }
            at = v.next;
        }
        if layers.len() > 1 {
            layers.reverse();
            layers.sort_by(|a, b| self.layers[*a as usize].z.total_cmp(&self.layers[*b as usize].z));
        }
        line.find_repeats(&self.layers);
    }

    /// Composite the lists: each sample's colour, premultiplied, and its coverage.
    pub fn resolve(&mut self, aovs: &[Aov]) {
        let (mut line, depth) = (Line::default(), self.depth);
        let (mut of_sum, mut of_group) = (vec![0.0; depth], vec![0.0; depth]);
        for k in 0..self.list.len() {
            if self.list[k] == NONE {
                continue;
            }
            self.line_up(k, &mut line);
            let mut sum: Option<Layer> = None;
            let mut add = |group: Layer, own: &[f32]| {
                match &mut sum {
                    None => of_sum.copy_from_slice(own),
                    Some(sum) => sum.lay(&group, &mut of_sum, own, aovs),
                }
                Left::behind(sum.get_or_insert(group)).is_below(CLOSED)
            };
            let mut group: Option<Layer> = None;
            let mut is_closed = false;
            for (at, _) in line.layers.iter().zip(&line.repeats).filter(|(_, repeats)| !**repeats) {
                let (v, own) = (&self.layers[*at as usize], outputs_of(&self.layer_outputs, depth, *at as usize));
                match &mut group {
                    Some(group) if group.z == v.z => group.lay(v, &mut of_group, own, aovs),
                    _ => {
                        is_closed = group.take().is_some_and(|before| add(before, &of_group));
                        if is_closed {
                            break;
                        }
                        group = Some(*v);
                        of_group.copy_from_slice(own);
                    }
                }
            }
            is_closed |= group.is_some_and(|group| add(group, &of_group));
            let Some(sum) = sum else { continue };
            self.lay_over_opaque(k, &sum, &of_sum, is_closed, aovs);
        }
    }

    /// Lay what the layers of a sample have come to over what is opaque there, which counts for nothing where they let nothing through.
    fn lay_over_opaque(&mut self, k: usize, sum: &Layer, own: &[f32], is_closed: bool, aovs: &[Aov]) {
        let is_half = sum.half_z < f32::INFINITY;
        for (first, aov) in placed(aovs) {
            for c in 0..aov.width() {
                let under = &mut self.outputs[k * self.depth + first + c];
                match aov.kind {
                    Kind::Color if is_closed => *under = own[first + c],
                    Kind::Color => *under = own[first + c] + sum.open[c] * *under,
                    _ if is_half || is_closed => *under = own[first + c],
                    _ => {}
                }
            }
        }
        let (color, alpha) = if is_closed { ([0.0; 3], 0.0) } else { (self.color[k], self.alpha[k]) };
        for c in 0..3 {
            self.color[k][c] = sum.color[c] + sum.open[c] * color[c];
        }
        self.alpha[k] = (0..3).map(|c| sum.alpha[c] + sum.open[c] * alpha).sum::<f32>() / 3.0;
        if is_half || is_closed {
            self.z[k] = if is_half { sum.half_z } else { sum.z };
        }
    }

    /// Pack layers, all of which have their colours: those of a sample in front of all that is to come become one, and so do those at
    /// one depth whose primitives are there as a whole. Where they let nothing through, nothing behind them is seen any more.
    pub fn pack(&mut self, to_come: &ToCome<'_>, aovs: &[Aov]) {
        let mut line = Line::default();
        let (layers, outputs) = std::mem::take(&mut self.packed);
        let mut packed = Packed { layers, outputs, depth: self.depth };
        for k in 0..self.list.len() {
            if self.list[k] == NONE {
                continue;
            }
            self.line_up(k, &mut line);
            let start = packed.layers.len();
            let waits = |at: &u32| {
                let v = &self.layers[*at as usize];
                v.solid.is_some() || v.micropolygon != Micropolygon::NONE
            };
            if line.layers.iter().any(waits) {
                line.layers.iter().for_each(|at| packed.push(self, *at as usize));
            } else if let Some(z) = packed.pack(self, &line, to_come, aovs) {
                (self.z[k], self.visible[k]) = (z, Micropolygon::NONE.id());
                self.closed = true;
            }
            self.list[k] = NONE;
            for at in start..packed.layers.len() {
                packed.layers[at].next = std::mem::replace(&mut self.list[k], at as u32);
            }
        }
        std::mem::swap(&mut self.layers, &mut packed.layers);
        std::mem::swap(&mut self.layer_outputs, &mut packed.outputs);
        packed.layers.clear();
        packed.outputs.clear();
        self.packed = (packed.layers, packed.outputs);
        (self.n_colored, self.room) = (0, MIN_ROOM.max(2 * self.layers.len()));
        self.block_dirty.fill(true);
    }
}

/// Layers that have been packed.
struct Packed {
    layers: Vec<Layer>,
    outputs: Vec<f32>,
    depth: usize,
}

impl Packed {
    fn push(&mut self, samples: &Samples, at: usize) {
        self.layers.push(samples.layers[at]);
        self.outputs.extend_from_slice(outputs_of(&samples.layer_outputs, self.depth, at));
        // What has no colour yet may have no outputs either.
        self.outputs.resize(self.layers.len() * self.depth, 0.0);
    }

    /// Lay a layer behind another that has been packed.
    fn lay(&mut self, at: usize, next: &Layer, behind: &[f32], aovs: &[Aov]) {
        let own = &mut self.outputs[at * self.depth..][..self.depth];
        self.layers[at].lay(next, own, behind, aovs);
        (self.layers[at].primitive, self.layers[at].whole) = (NO_PRIMITIVE, None);
    }

    /// Pack the layers of a sample; the depth from which on nothing is seen, if there is one.
    fn pack(&mut self, samples: &Samples, line: &Line, to_come: &ToCome<'_>, aovs: &[Aov]) -> Option<f32> {
        let of = |at: &u32| &samples.layers[*at as usize];
        let mut left = Left::ALL;
        let (mut front, mut first): (Option<usize>, usize) = (None, 0);
        let mut all_past = true;
        for group in line.layers.chunk_by(|a, b| of(a).z == of(b).z) {
            let repeats = &line.repeats[first..first + group.len()];
            first += group.len();
            let (z, start) = (of(&group[0]).z, self.layers.len());
            // A layer that repeats one before it is that near to it, but at sides of grids.
            let may_repeat = |at: &u32| {
                let v = of(at);
                v.at_edge.slack > 0.0 && v.primitive != NO_PRIMITIVE && (to_come.has)(v.primitive, v.whole)
            };
            all_past &= z < to_come.z * (1.0 - 2.0 * SAME) && !group.iter().any(may_repeat);
            let (is_known, is_past) = (z < to_come.z, all_past);
            let (mut is_one, mut is_closed) = (true, false);
            for (at, repeats) in group.iter().zip(repeats) {
                let v = of(at);
                let is_whole = v.primitive == NO_PRIMITIVE || !(to_come.has)(v.primitive, v.whole);
                if *repeats && (is_known || is_whole) {
                    continue;
                }
                if !repeats {
                    left.pass(v);
                }
                let stands = (is_past || is_whole) && !repeats;
                if is_one && stands && self.layers.len() > start {
                    let behind = outputs_of(&samples.layer_outputs, self.depth, *at as usize);
                    self.lay(start, v, behind, aovs);
                } else {
                    self.push(samples, *at as usize);
                }
                is_one &= stands;
            }
            if is_past && self.layers.len() == start + 1 {
                let front = *front.get_or_insert(start);
                if front < start {
                    let (v, behind) = (self.layers[start], self.outputs[start * self.depth..].to_vec());
                    self.layers.truncate(start);
                    self.outputs.truncate(start * self.depth);
                    self.lay(front, &v, &behind, aovs);
                }
                is_closed = Left::behind(&self.layers[front]).is_below(CLOSED);
            }
            if is_closed || left.is_below(SURELY_CLOSED) {
                // Those of this sample alone, however many others lie at this depth.
                self.layers[start..].iter_mut().for_each(|v| v.last = true);
                return Some(z);
            }
        }
        None
    }
}

fn outputs_of(outputs: &[f32], depth: usize, at: usize) -> &[f32] {
    outputs.get(at * depth..(at + 1) * depth).unwrap_or(&[])
}
