//! Layers of solids: those that are surfaces of the whole.

use crate::cpu::micropolygon::Micropolygon;
use crate::cpu::samples::{Layer, NONE, Samples};
use crate::scene::solid::{Met, Solids, Walk};

impl Samples {
    /// Leave of the lists what may be seen: of solids the surfaces of the wholes, and nothing behind the first layer that is opaque.
    /// All layers of what is not cut must be there; `stays_opaque` tells it of micropolygons that have no colour yet.
    pub fn cut_solids(&mut self, solids: &Solids, stays_opaque: impl Fn(Micropolygon) -> bool) {
        if self.layers.is_empty() {
            return;
        }
        let (mut stack, mut walk, mut line) = (vec![], Walk::default(), vec![]);
        for k in 0..self.list.len() {
            stack.clear();
            let mut at = self.list[k];
            while at != NONE {
                let v = &self.layers[at as usize];
                if v.is_before(self.z[k]) {
                    stack.push(at);
                }
                at = v.next;
            }
            if stack.iter().all(|at| self.layers[*at as usize].solid.is_none()) {
                continue;
            }
            // Nearest first; of what is equally near, what came first.
            stack.reverse();
            stack.sort_by(|a, b| self.layers[*a as usize].z.total_cmp(&self.layers[*b as usize].z));
            let met = |at: &u32| {
                let v = &self.layers[*at as usize];
                v.solid.map(|(leaf, enters)| Met { at: v.z, leaf, enters, name: *at })
            };
            line.clear();
            line.extend(stack.iter().filter_map(met));
            let kept = walk.surfaces(solids, &mut line);
            for (met, _) in line.iter().zip(kept).filter(|(_, kept)| **kept) {
                self.layers[met.name as usize].solid = None;
            }
            self.list[k] = NONE;
            for at in &stack {
                let v = &mut self.layers[*at as usize];
                if v.solid.is_some() {
                    continue;
                }
                v.next = std::mem::replace(&mut self.list[k], *at);
                let is_opaque = match v.micropolygon {
                    Micropolygon::NONE => v.open.iter().all(|o| *o <= 0.0),
                    waiting => stays_opaque(waiting),
                };
                if is_opaque {
                    // What comes later is hidden behind it.
                    self.visible[k] = Micropolygon::NONE.id();
                    self.z[k] = v.z.next_up();
                    break;
                }
            }
        }
        self.block_dirty.fill(true);
        self.compact();
    }

    /// Leave out the layers that no list has.
    fn compact(&mut self) {
        let (depth, layers) = (self.depth, std::mem::take(&mut self.layers));
        let outputs = std::mem::take(&mut self.layer_outputs);
        self.n_colored = 0;
        for first in &mut self.list {
            let mut at = std::mem::replace(first, NONE);
            let mut last = None;
            while at != NONE {
                let to = self.layers.len() as u32;
                match last {
                    None => *first = to,
                    Some(before) => self.layers[before as usize].next = to,
                }
                let layer = layers[at as usize];
                self.layers.push(Layer { next: NONE, ..layer });
                self.layer_outputs.extend(outputs.get(at as usize * depth..(at as usize + 1) * depth).unwrap_or(&[]));
                self.layer_outputs.resize(self.layers.len() * depth, 0.0);
                (last, at) = (Some(to), layer.next);
            }
        }
    }
}
