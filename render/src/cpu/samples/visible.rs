//! Visible points: which micropolygons samples have, and the colours that they get of these.

use crate::cpu::micropolygon::Micropolygon;
use crate::cpu::samples::{Layer, NONE, Samples, within};
use glam::Vec3A;

/// The opacity from which on a layer counts as what is visible, where that is kept.
const OPAQUE: f32 = 1.0 - 1e-6;

/// A shaded triangle of a micropolygon.
#[derive(Clone, Copy, Default)]
pub struct Triangle {
    /// Colours of its corners, by their opacity already.
    pub color: [Vec3A; 3],
    /// Opacities.
    pub opacity: [Vec3A; 3],
    /// The corners among the points of all grids.
    pub corners: [usize; 3],
    /// How many points on they are again, as shaded later, and the part of the way to that.
    pub later: (usize, f32),
    /// What lies between the corners is between them; else it is as the first is.
    pub smooth: bool,
    /// It leaves a hole.
    pub matte: bool,
}

/// What has the triangles of micropolygons.
pub trait Triangles {
    /// The triangle of a micropolygon that is as it was when the shutter opened.
    fn still(&self, m: Micropolygon) -> Triangle;
    /// A triangle at a part of the time that the shutter is open.
    fn at(&self, m: Micropolygon, time: f32) -> Triangle;
}

impl Triangle {
    /// Whether its corners let nothing through, but for rounding.
    fn is_opaque(&self) -> bool {
        let least = Vec3A::splat(OPAQUE);
        self.opacity[..if self.smooth { 3 } else { 1 }].iter().all(|o| o.cmpge(least).all())
    }

    /// What each corner counts at a place with these weights of the second and third.
    #[inline]
    fn weights(&self, [second, third]: [f32; 2]) -> [f32; 3] {
        if self.smooth { within([1.0 - second - third, second, third]) } else { [1.0, 0.0, 0.0] }
    }

    /// What displays take besides colour at such a place, of what they take at all points.
    fn outputs(&self, all: &[f32], w: [f32; 3], own: &mut [f32]) {
        let depth = own.len();
        for (i, own) in own.iter_mut().enumerate() {
            // What is the same at all corners stays that to the bit.
            let (n, part) = self.later;
            let [a, b, c] = self.corners.map(|k| {
                let now = all[k * depth + i];
                if n == 0 { now } else { now + (all[(k + n) * depth + i] - now) * part }
            });
            *own = a + (b - a) * w[1] + (c - a) * w[2];
        }
    }
}

impl Samples {
    /// The micropolygons that are visible, opaque, and have no colour yet.
    #[inline]
    pub fn visible(&self) -> impl Iterator<Item = Micropolygon> + '_ {
        self.visible.iter().map(|id| Micropolygon::from_id(*id)).filter(|m| *m != Micropolygon::NONE)
    }

    /// Visit those of layers that are visible and have no colour yet.
    pub fn for_each_layer(&self, mut visit: impl FnMut(Micropolygon)) {
        for layer in &self.layers[self.n_colored..] {
            if layer.micropolygon != Micropolygon::NONE && layer.is_before(self.z[layer.sample as usize]) {
                visit(layer.micropolygon);
            }
        }
    }

    /// Note the identities of micropolygons that are visible and have no colour yet: of what is opaque, and of layers whose corners let
    /// nothing through.
    pub fn note_identities(&mut self, triangles: &impl Triangles, identity_of: impl Fn(Micropolygon) -> u64) {
        self.identities.resize(self.visible.len(), 0);
        self.identity_z.resize(self.visible.len(), f32::INFINITY);
        let mut note = |k: usize, z: f32, m: Micropolygon| {
            if z < self.identity_z[k] {
                (self.identities[k], self.identity_z[k]) = (identity_of(m), z);
            }
        };
        for (k, id) in self.visible.iter().enumerate() {
            let micropolygon = Micropolygon::from_id(*id);
            if micropolygon != Micropolygon::NONE {
                note(k, self.z[k], micropolygon);
            }
        }
        for k in 0..self.list.len() {
            let time = self.time.get(k).copied().unwrap_or(0.0);
            let mut nearest: Option<&Layer> = None;
            let mut at = self.list[k];
            while at != NONE {
                let layer = &self.layers[at as usize];
                at = layer.next;
                let is_new = layer.micropolygon != Micropolygon::NONE && layer.is_before(self.z[k]);
                // The last of a list came first.
                let is_nearer = nearest.is_none_or(|v| layer.z <= v.z);
                if is_new && is_nearer && triangles.at(layer.micropolygon, time).is_opaque() {
                    nearest = Some(layer);
                }
            }
            if let Some(layer) = nearest {
                note(k, layer.z, layer.micropolygon);
            }
        }
    }

    /// Give visible points their colours, those of triangles; `outputs` has what displays take besides of all points.
    pub fn set_colors(&mut self, triangles: &impl Triangles, outputs: &[f32]) {
        let mut last = Micropolygon::NONE;
        let mut triangle = Triangle::default();
        for k in 0..self.list.len() {
            let id = Micropolygon::from_id(std::mem::replace(&mut self.visible[k], Micropolygon::NONE.id()));
            if id == Micropolygon::NONE {
                continue;
            }
            // Neighbouring samples often see the same micropolygon.
            if id != last {
                // Nothing that is opaque changes its colour.
                (last, triangle) = (id, triangles.still(id));
            }
            if triangle.matte {
                (self.color[k], self.alpha[k]) = ([0.0; 3], 0.0);
                continue;
            }
            let w = triangle.weights([self.weights[0][k], self.weights[1][k]]);
            let [a, b, c] = triangle.color;
            self.color[k] = (a * w[0] + b * w[1] + c * w[2]).to_array();
            self.alpha[k] = 1.0;
            if self.depth > 0 {
                triangle.outputs(outputs, w, &mut self.outputs[k * self.depth..][..self.depth]);
            }
        }
        if !self.layers.is_empty() {
            self.set_layer_colors(triangles, outputs);
        }
    }

    /// The same of layers that others may be seen through.
    fn set_layer_colors(&mut self, triangles: &impl Triangles, outputs: &[f32]) {
        self.layer_outputs.resize(self.layers.len() * self.depth, 0.0);
        for at in self.n_colored..self.layers.len() {
            let layer = &mut self.layers[at];
            let id = std::mem::replace(&mut layer.micropolygon, Micropolygon::NONE);
            let k = layer.sample as usize;
            if id == Micropolygon::NONE || !layer.is_before(self.z[k]) {
                continue;
            }
            let triangle = triangles.at(id, self.time.get(k).copied().unwrap_or(0.0));
            let w = triangle.weights(layer.weights);
            let mix = |[a, b, c]: [Vec3A; 3]| (a * w[0] + b * w[1] + c * w[2]).to_array();
            let opacity = mix(triangle.opacity);
            layer.paint(mix(triangle.color), opacity, triangle.matte);
            let own = &mut self.layer_outputs[at * self.depth..][..self.depth];
            if triangle.matte {
                own.fill(0.0);
            } else {
                triangle.outputs(outputs, w, own);
                for (own, channel) in own.iter_mut().zip(&self.weighted) {
                    *own *= channel.map_or(1.0, |c| opacity[c].clamp(0.0, 1.0));
                }
            }
        }
        self.n_colored = self.layers.len();
    }
}
