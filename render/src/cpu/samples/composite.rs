//! Compositing of the layers of samples.

use crate::cpu::samples::{Layer, NONE, Samples};
use crate::film::display::{Aov, placed};
use crate::scene::solid::{Met, Solids, Walk};
use sl::ir::Kind;

impl Samples {
    /// Composite the lists: each sample's colour, premultiplied, and its coverage. Of solids, the surfaces of the wholes count.
    pub fn resolve(&mut self, aovs: &[Aov], solids: &Solids) {
        let mut stack: Vec<(u32, Layer)> = Vec::new();
        let (mut walk, mut line, mut dropped) = (Walk::default(), vec![], vec![]);
        for k in 0..self.list.len() {
            if self.list[k] == NONE {
                continue;
            }
            stack.clear();
            let mut at = self.list[k];
            while at != NONE {
                let v = self.layers[at as usize];
                if v.z < self.z[k] {
                    stack.push((at, v));
                }
                at = v.next;
            }
            // Farthest first; what is equally far keeps the order in which it came.
            stack.sort_by(|a, b| b.1.z.total_cmp(&a.1.z));
            if stack.iter().any(|(_, v)| v.solid.is_some()) {
                let met = |(name, (_, v)): (usize, &(u32, Layer))| {
                    v.solid.map(|(leaf, enters)| Met { at: v.z, leaf, enters, name: name as u32 })
                };
                line.clear();
                line.extend(stack.iter().enumerate().rev().filter_map(met));
                let kept = walk.surfaces(solids, &mut line);
                dropped.clear();
                dropped.resize(stack.len(), false);
                line.iter().zip(kept).for_each(|(met, kept)| dropped[met.name as usize] = !kept);
                let mut dropped = dropped.iter();
                stack.retain(|_| dropped.next() == Some(&false));
            }
            for (layer, v) in &stack {
                for c in 0..3 {
                    self.color[k][c] = v.color[c] + self.color[k][c] * (1.0 - v.opacity[c]);
                }
                let mean = (v.opacity[0] + v.opacity[1] + v.opacity[2]) / 3.0;
                self.alpha[k] = if v.matte { 0.0 } else { mean } + self.alpha[k] * (1.0 - mean);
                if self.depth > 0 {
                    let own = &self.layer_outputs[*layer as usize * self.depth..][..self.depth];
                    let under = &mut self.outputs[k * self.depth..][..self.depth];
                    lay_over(aovs, own, v.opacity, under);
                }
                if mean >= 0.5 {
                    self.z[k] = v.z;
                }
            }
        }
    }
}

/// Lay what displays take of a surface over what is behind it: colours by the opacity, other values if it is half opaque.
fn lay_over(aovs: &[Aov], own: &[f32], opacity: [f32; 3], under: &mut [f32]) {
    let mean = (opacity[0] + opacity[1] + opacity[2]) / 3.0;
    for (first, aov) in placed(aovs) {
        for c in 0..aov.width() {
            let k = first + c;
            match aov.kind {
                Kind::Color => under[k] = own[k] + under[k] * (1.0 - opacity[c]),
                _ if mean >= 0.5 => under[k] = own[k],
                _ => {}
            }
        }
    }
}
