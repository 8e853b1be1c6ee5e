//! Columns of a collision that the stages of the processor have found: what the later ones of a device read is written as if its own stages had
//! found it.
//!
//! ```text
//! out  margin, fat_aabb           [n_spheres]   before `bin_emit`
//! out  bin, bin_shape, bin_start  [n_spheres], [n_bins]  of bins as the device has them, by their twin
//! out  pairs                      [n_pairs]     of the processor's, or those of its contacts
//! out  contact, arms              [n_contacts]  in the order of the pairs
//! ```

use super::{Collision, Fault};
use crate::contacts::Contacts;
#[cfg(test)]
use crate::gpu::bin_emit::Emitted;
use crate::gpu::bin_emit::emit_cpu;
use crate::gpu::kinds;
use crate::gpu::rows::{Aabb, Arms, Contact};
use crate::model::Model;
use crate::plan::Narrow;
use crate::shape::ShapeKind;
use crate::stages::Stage;
use crate::state::State;
use gpu::{Commands, Device, GpuError};
use std::collections::HashMap;

/// Where a contact is among those of a device: the rows of pairs and of contacts.
#[derive(Default)]
pub struct Placed {
    /// The contact of the processor for each of the device (n_contacts).
    pub order: Vec<u32>,
    /// The pair of each contact, and the number of contacts before each pair.
    touching: Vec<u32>,
    place: Vec<u32>,
}

impl Collision {
    /// Record the stages from one on. The tiles are the device's own, also of pairs that it is given.
    pub fn record_from(&self, device: &Device, c: &mut Commands, model: &Model, from: Stage) {
        let Collision { bodies, spheres, fixtures, due, bins, pairs, .. } = self;
        if from <= Stage::Bounds {
            c.stage("bounds");
            self.bounds.record(device, c, model, (bodies, spheres), due);
        }
        if from <= Stage::BinEmit {
            c.stage("bin_emit");
            self.bin_emit.record(device, c, spheres, bodies.scale.unit, (due, bins));
        }
        if from <= Stage::BinSort {
            c.stage("bin_sort");
            self.bin_sort.record(device, c, (&bins.bin, &bins.shape), &due.spheres, bins.n() as u32);
        }
        if from <= Stage::BinStart {
            c.stage("bin_start");
            self.bin_start.record(device, c, due, bins);
        }
        if from <= Stage::PairWrite {
            c.stage("pair_write");
            self.pair_write.record(device, c, model, (bodies, spheres, fixtures), (due, bins, pairs));
        }
        if from > Stage::ContactWrite {
            return;
        }
        if from == Stage::ContactWrite {
            c.stage("contact_write");
        }
        self.record_order(device, c);
        self.record_contacts(device, c, model, false);
    }

    /// Record the stages for pairs that hold: the contacts of the pairs that there are; and the boxes, unless the last step is known to have left them.
    /// If they do not hold after all, the step has no room, and is undone.
    pub fn record_held(&self, device: &Device, c: &mut Commands, model: &Model, is_known: bool) {
        if !is_known {
            c.stage("bounds");
            self.bounds.record_margins(device, c, model, (&self.bodies, &self.spheres), (&self.due, false));
        }
        self.record_contacts(device, c, model, true);
    }

    /// Record the boxes of the next step, once the bodies have moved.
    pub fn record_next(&self, device: &Device, c: &mut Commands, model: &Model) {
        self.bounds.record_margins(device, c, model, (&self.bodies, &self.spheres), (&self.due, true));
    }

    fn record_contacts(&self, device: &Device, c: &mut Commands, model: &Model, hold: bool) {
        let Collision { bodies, spheres, fixtures, due, pairs, contacts, .. } = self;
        let shapes = (bodies, spheres, fixtures);
        c.stage("contact_write");
        match &self.manifolds {
            None => self.contact_write.record(device, c, model, shapes, (due, hold), (pairs, contacts)),
            Some(manifolds) => {
                let to = (pairs, &contacts.contact, &contacts.n);
                manifolds.record(device, c, model, shapes, (due, hold), to);
            }
        }
    }

    /// Record what the order of the pairs is: that of tiles, and by bodies.
    fn record_order(&self, device: &Device, c: &mut Commands) {
        let shapes = (&self.bodies, &self.spheres, &self.fixtures);
        if let Some(tiles) = &self.tiles {
            let [_, place] = self.of_pairs();
            tiles.record(device, c, shapes, (&self.due, &self.bins, &self.pairs, place));
        }
        self.pair_order.record(device, c, shapes, (&self.due, &self.pairs));
    }

    /// The boxes of the last run, bits of a bin's index, the usual width of a bin and the unit, m, and what was found of these.
    #[cfg(test)]
    pub fn bins_found(&self, device: &Device) -> Result<(Vec<Aabb>, u32, (f64, f64), Emitted), GpuError> {
        let Collision { spheres, bins, due, bodies, .. } = self;
        let (grid, levels) = (bins.grid.read(device, 3)?, due.levels.read(device, 2)?);
        let found = Emitted {
            grid: [grid[0], grid[1], grid[2]],
            bin: bins.bin.read(device, spheres.n)?,
            levels: [levels[0], levels[1]],
        };
        let boxes = spheres.fat_aabb.read(device, spheres.n)?;
        Ok((boxes, bins.most_bits, (spheres.width, bodies.scale.unit), found))
    }

    /// Room for pairs and for contacts.
    pub fn rooms(&self) -> [usize; 2] {
        [self.pairs.pairs.capacity(), self.contacts.contact.capacity()]
    }

    /// Write margins, m (n_shapes), and the fat boxes of a state, and what the stages before `from` make of them: all pairs are found again.
    pub fn give_boxes(&self, device: &Device, margin: &[f32], state: &State, from: Stage) {
        let Collision { spheres, bins, due, bodies, .. } = self;
        let all = state.fat_aabb.as_deref().unwrap_or_default();
        let box_of = |s: &usize| match all[*s].min.cmple(all[*s].max).all() {
            true => Aabb { low: all[*s].min.extend(0.0).to_array(), high: all[*s].max.extend(0.0).to_array() },
            // That of an inactive body.
            false => Aabb { low: [3.4e38; 4], high: [-3.4e38; 4] },
        };
        let boxes: Vec<Aabb> = spheres.shapes.iter().map(box_of).collect();
        spheres.fat_aabb.write(device, &boxes);
        spheres.margin.write(device, &spheres.shapes.iter().map(|s| margin[*s]).collect::<Vec<f32>>());
        let n = spheres.n as u32;
        for (count, n) in [(&due.spheres, n), (&due.rows, n + 1), (&due.bins, bins.n() as u32)] {
            count.n.write(device, &[n]);
        }
        due.levels.write(device, &[0, 0]);
        if from == Stage::BinEmit {
            return;
        }
        let found = emit_cpu(&boxes, bins.most_bits, (spheres.width, bodies.scale.unit));
        bins.grid.write(device, &found.grid);
        due.levels.write(device, &found.levels);
        let (mut bin, mut shape): (Vec<u32>, Vec<u32>) = (found.bin, (0..n).collect());
        if from > Stage::BinSort {
            gpu::radix_sort::sort_cpu(&mut bin, &mut shape, bins.n() as u32);
        }
        bins.bin.write(device, &bin);
        bins.shape.write(device, &shape);
        if from > Stage::BinStart {
            let mut start = vec![[0; 2]; bins.n()];
            for (i, bin) in bin.iter().enumerate() {
                // That of inactive bodies is behind all.
                let Some([first, end]) = start.get_mut(*bin as usize) else { continue };
                (*first, *end) = (if *end == 0 { i as u32 } else { *first }, i as u32 + 1);
            }
            bins.start.write(device, &start);
        }
    }

    /// The rows of pairs of shapes with their triangles; none of those without an area.
    ///
    /// # Errors
    /// Those of [`gpu::Buffer::read`].
    pub fn rows_of_pairs(&self, device: &Device, model: &Model, pairs: &[[u32; 3]]) -> Result<Vec<[u32; 2]>, GpuError> {
        let triangles = self.triangles(device)?;
        let sides = self.sides(model);
        let row = |[s, t, triangle]: &[u32; 3]| {
            let [a, b] = [*s, *t].map(|shape| match model.shape_kind[shape as usize] {
                ShapeKind::Mesh | ShapeKind::HeightField => triangles.get(&[shape, *triangle]).copied(),
                _ => Some(sides[shape as usize]),
            });
            Some([a?.min(b?), a?.max(b?)])
        };
        Ok(pairs.iter().filter_map(row).collect())
    }

    /// The row of each shape: moving ones come first, then the fixtures.
    fn sides(&self, model: &Model) -> Vec<u32> {
        let mut sides = vec![0; model.n_shapes()];
        let fixtures = self.fixtures.boxes.iter().map(|(s, _)| s);
        (0..).zip(self.spheres.shapes.iter().chain(fixtures)).for_each(|(row, s)| sides[*s] = row);
        sides
    }

    /// The rows of the triangles, by their shapes and indices.
    fn triangles(&self, device: &Device) -> Result<HashMap<[u32; 2], u32>, GpuError> {
        let fixtures = &self.fixtures.fixture;
        if !self.bodies.layout.surfaces {
            return Ok(HashMap::new());
        }
        let rows = fixtures.read(device, fixtures.capacity())?;
        let of = |row: &crate::gpu::rows::Fixture| (row.kind == kinds::TRIANGLE).then_some([row.shape, row.half.x[1]]);
        let first = self.spheres.n as u32;
        Ok((first..).zip(&rows).filter_map(|(at, row)| Some((of(row)?, at))).collect())
    }

    /// Write pairs, for which there is room.
    pub fn give_pairs(&self, device: &Device, rows: &[[u32; 2]]) {
        self.pairs.pairs.write(device, rows);
        self.pairs.n.n.write(device, &[rows.len() as u32]);
        self.pairs.room.write(device, &[rows.len() as u32, 1, 0]);
    }

    /// Find the places of contacts: their pairs are given to the device, and where they are to be in tiles, these put them in order.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn place_contacts(&self, device: &Device, model: &Model, contacts: &Contacts) -> Result<Placed, Fault> {
        let n = contacts.len() as u32;
        let sides = self.sides(model);
        let pair_of = |i: u32| {
            let [s, t, _] = contacts.key[i as usize];
            let [a, b] = [s, t].map(|shape| sides[shape as usize]);
            [a.min(b), a.max(b)]
        };
        // Where arms are of any direction a pair may have several contacts.
        let is_any = self.bodies.layout.narrow == Narrow::Any;
        let all: Vec<u32> = (0..n).collect();
        let runs: Vec<&[u32]> = all.chunk_by(|i, j| is_any && pair_of(*i) == pair_of(*j)).collect();
        self.give_pairs(device, &runs.iter().map(|run| pair_of(run[0])).collect::<Vec<_>>());
        let mut commands = Commands::new();
        commands.stage("pair_write");
        self.record_order(device, &mut commands);
        commands.submit(device)?;
        let mut left: HashMap<[u32; 2], Vec<&[u32]>> = HashMap::new();
        runs.iter().rev().for_each(|run| left.entry(pair_of(run[0])).or_default().push(run));
        let mut placed = Placed { place: vec![0], ..Placed::default() };
        for (k, pair) in (0..).zip(self.pairs.pairs.read(device, runs.len())?) {
            let run = left.get_mut(&pair).and_then(Vec::pop).expect("tiles have the pairs that they are given");
            placed.order.extend(run);
            placed.touching.extend(run.iter().map(|_| k));
            placed.place.push(placed.order.len() as u32);
        }
        Ok(placed)
    }

    /// Write contacts, for which there is room.
    pub fn give_contacts(&self, device: &Device, (model, state): (&Model, &State), from: &Contacts, placed: &Placed) {
        let own = |i: &u32| {
            let i = *i as usize;
            let (normal, [arm_a, arm_b]) = (from.normal[i], from.arms(i));
            let reach = match self.bodies.layout.narrow {
                Narrow::Spheres => [arm_a.dot(normal), -arm_b.dot(normal)],
                Narrow::Any => [0.0; 2],
            };
            Contact {
                bodies: from.bodies[i],
                shapes: [from.key[i][0], from.key[i][1]],
                normal: normal.as_vec3().to_array(),
                gap: from.gap[i] as f32,
                reach: reach.map(|x| x as f32),
                law: from.law[i],
                feature: from.key[i][2],
            }
        };
        let n = from.len() as u32;
        self.contacts.contact.write(device, &placed.order.iter().map(own).collect::<Vec<_>>());
        self.contacts.n.n.write(device, &[n]);
        self.pairs.room.write(device, &[0, 1, n]);
        if let Some(manifolds) = &self.manifolds {
            let is_face = |s: &u32| {
                let s = *s as usize;
                model.shape_kind[s] != ShapeKind::Sphere && state.moves(model.shape_body[s] as usize)
            };
            let arms = |i: &u32| {
                let [a, b] = from.arms(*i as usize).map(|arm| arm.as_vec3().to_array());
                Arms { a, is_face: from.key[*i as usize][..2].iter().any(is_face) as u32, b, pad: 0 }
            };
            manifolds.arms.write(device, &placed.order.iter().map(arms).collect::<Vec<_>>());
        }
        let [touching, place] = self.of_pairs();
        place.write(device, &placed.place);
        if self.manifolds.is_none() {
            touching.write(device, &placed.touching);
        }
    }
}
