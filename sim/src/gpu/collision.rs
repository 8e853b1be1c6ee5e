//! Collision on a device: the stages from `bounds` to `contact_write`, recorded once and submitted for every step.
//!
//! Pairs hold while no sphere has left its fat box: the stages of the broad phase then have nothing to do, as their counts on the device
//! say, and are left out where the host expects it. If there are more pairs than room, there are none at all, and the stages are run again with
//! more room; no pair is dropped.

pub mod given;

use super::bin_emit::{BinEmit, Bins};
use super::bin_start::BinStart;
use super::bodies::Bodies;
use super::bounds::{Bounds, Due};
use super::contact_write::{ContactWrite, Contacts};
use super::fixtures::Fixtures;
use super::manifolds::Manifolds;
use super::pair_write::{PairWrite, Pairs};
use super::parts::Layout;
use super::rows::{Aabb, Arms, Contact};
use super::sides::{PairOrder, PairSides};
use super::solids;
use super::spheres::Spheres;
use super::tiles::Tiles;
use crate::aabb;
use crate::model::Model;
use crate::plan::{Narrow, rolls};
use crate::stages::Stage;
use crate::state::State;
use gpu::radix_sort::RadixSort;
use gpu::{Buffer, Commands, Count, Device, GpuError, Kernels};

pub use super::fault::Fault;

/// Number of pairs and of contacts of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// Number of pairs of fat boxes.
    pub pairs: usize,
    /// Number of contacts.
    pub contacts: usize,
}

/// The collision stages of a model's moving shapes.
pub struct Collision {
    /// The state of the bodies.
    pub bodies: Bodies,
    spheres: Spheres,
    fixtures: Fixtures,
    due: Due,
    bins: Bins,
    bounds: Bounds,
    bin_emit: BinEmit,
    bin_sort: RadixSort<u32>,
    bin_start: BinStart,
    pair_write: PairWrite,
    contact_write: ContactWrite,
    pairs: Pairs,
    pair_order: PairOrder,
    tiles: Option<Tiles>,
    contacts: Contacts,
    /// The narrow phase of shapes of any kind, where these are not spheres alone.
    manifolds: Option<Manifolds>,
    /// A column of arms for kernels that have no use for it.
    no_arms: Buffer<Arms>,
    found: Found,
}

impl Collision {
    /// For the moving shapes and fixtures of a model, where a state has them.
    ///
    /// # Errors
    /// Those of the moving shapes and fixtures, [`Fault::Position`] and [`Fault::Gpu`].
    pub fn new(device: &Device, kernels: &Kernels, model: &Model, state: &State) -> Result<Collision, Fault> {
        let narrow = solids::narrow_of(model);
        let layout = Layout {
            narrow,
            rolls: rolls(model),
            hulls: solids::has_hulls(model),
            surfaces: solids::has_surfaces(model),
        };
        let (spheres, scale) = Spheres::new(device, model, narrow)?;
        let fixtures = Fixtures::new(device, model, state, (scale, &spheres.hulls))?;
        let n = spheres.n;
        let bins = Bins::new(device, n)?;
        // A sphere in a bed touches about six others, a pair each for two, and is near to few more; solids touch at several points.
        let [room, of_contacts] = match narrow {
            Narrow::Spheres => [13 * n / 4 + 64, 3 * n + 64],
            Narrow::Any => [4 * n + 64; 2],
        };
        let manifolds = match narrow {
            Narrow::Spheres => None,
            Narrow::Any => Some(Manifolds::new(device, kernels, layout, (&spheres, &fixtures), [room; 2])?),
        };
        let pairs = Pairs::new(device, n, room)?;
        let mut collision = Collision {
            pair_order: PairOrder::new(device, kernels, model.n_bodies(), &pairs)?,
            bodies: Bodies::new(device, scale, layout, model.n_bodies())?,
            fixtures,
            manifolds,
            no_arms: Buffer::zeros(device, "no arms", 1)?,
            due: Due::new(device, n, bins.n())?,
            bins,
            bounds: Bounds::new(device, kernels, layout)?,
            bin_emit: BinEmit::new(device, kernels)?,
            bin_sort: RadixSort::new(device, kernels, n)?,
            bin_start: BinStart::new(device, kernels)?,
            pair_write: PairWrite::new(device, kernels, (model, layout), n)?,
            contact_write: ContactWrite::new(device, kernels, layout)?,
            pairs,
            tiles: None,
            contacts: Contacts::new(device, kernels, [room, of_contacts])?,
            found: Found { pairs: 0, contacts: 0 },
            spheres,
        };
        collision.place(device, model, state)?;
        Ok(collision)
    }

    /// Take over the poses, velocities and activities of a state, and its fat AABBs, if it has some: the pairs of these are found again.
    ///
    /// # Errors
    /// [`Fault::Position`].
    pub fn place(&mut self, device: &Device, model: &Model, state: &State) -> Result<(), Fault> {
        // Pairs of bodies that are held are left out, and so are those that are inactive.
        if self.bodies.place(device, model, state)? {
            self.find_all(device);
        }
        if let Some(boxes) = &state.fat_aabb {
            let own = |s: &usize| {
                let b = &boxes[*s];
                Aabb { low: b.min.extend(0.0).to_array(), high: b.max.extend(0.0).to_array() }
            };
            let boxes: Vec<Aabb> = self.spheres.shapes.iter().map(own).collect();
            self.spheres.fat_aabb.write(device, &boxes);
            self.due.left.write(device, &[0]);
            self.due.lost.write(device, &[1]);
        }
        Ok(())
    }

    /// Run the stages for where the spheres are.
    ///
    /// # Errors
    /// [`Fault::Gpu`], also if there is no memory for the pairs.
    pub fn run(&mut self, device: &Device, kernels: &Kernels, model: &Model) -> Result<Found, Fault> {
        loop {
            let mut commands = Commands::new();
            self.record(device, &mut commands, model);
            commands.submit(device)?;
            let room = self.pairs.room.read(device, 3)?;
            let needed = [room[0], room[2]].map(|n| n as usize);
            if room[1] == 1 {
                self.found = Found { pairs: needed[0], contacts: self.contacts.n.read(device)? };
                return Ok(self.found);
            }
            self.make_room(device, kernels, needed)?;
        }
    }

    /// Make room for a number of pairs and of contacts; pairs will be found again for the fat boxes that there are. Recorded commands then mean the old
    /// columns.
    ///
    /// # Errors
    /// [`GpuError`], if there is no memory for them.
    pub fn make_room(&mut self, device: &Device, kernels: &Kernels, needed: [usize; 2]) -> Result<(), GpuError> {
        let [room, of_contacts] = needed.map(|n| n + n / 8 + 64);
        let rooms = [room.max(self.pairs.pairs.capacity()), of_contacts.max(self.contacts.contact.capacity())];
        self.pairs = Pairs::new(device, self.spheres.n, rooms[0])?;
        self.pair_order = PairOrder::new(device, kernels, self.bodies.n, &self.pairs)?;
        match &mut self.manifolds {
            None => self.contacts = Contacts::new(device, kernels, rooms)?,
            Some(manifolds) => {
                // Their pairs are in lists of the families.
                self.contacts = Contacts::new(device, kernels, [rooms[1]; 2])?;
                *manifolds =
                    Manifolds::new(device, kernels, self.bodies.layout, (&self.spheres, &self.fixtures), rooms)?;
            }
        }
        if let Some(tiles) = &mut self.tiles {
            *tiles = Tiles::new(device, kernels, (&self.spheres, &self.bodies, &self.bins), &self.pairs)?;
        }
        self.due.lost.write(device, &[1]);
        Ok(())
    }

    /// Have the pairs put into tiles from now on.
    ///
    /// # Errors
    /// [`GpuError`].
    pub fn make_tiles(&mut self, device: &Device, kernels: &Kernels) -> Result<(), GpuError> {
        if self.tiles.is_none() {
            self.tiles = Some(Tiles::new(device, kernels, (&self.spheres, &self.bodies, &self.bins), &self.pairs)?);
            self.due.lost.write(device, &[1]);
        }
        Ok(())
    }

    /// The tiles, if pairs are put into them.
    pub fn tiles(&self) -> Option<&Tiles> {
        self.tiles.as_ref()
    }

    /// The pair of each contact, where each pair has one at most, and the number of contacts of the pairs before each pair.
    pub fn of_pairs(&self) -> [&Buffer<u32>; 2] {
        let place = self.manifolds.as_ref().map_or(self.contacts.places(), |manifolds| &manifolds.place);
        [&self.contacts.touching, place]
    }

    /// The sides of the pairs by their bodies; once more room has been made they are others.
    pub fn pair_sides(&self) -> &PairSides {
        self.pair_order.sides()
    }

    /// Record the visits to the pairs in tiles that touch, unless these have lasting ones.
    pub fn record_touching(&self, device: &Device, c: &mut Commands) {
        let [_, place] = self.of_pairs();
        if let Some(tiles) = &self.tiles {
            tiles.record_touching(device, c, (&self.bodies, &self.spheres, &self.fixtures), (&self.pairs, place));
        }
    }

    /// Number of pairs, on the device.
    pub fn n_pairs(&self) -> &Count {
        &self.pairs.n
    }

    /// Have the boxes renewed and the pairs found again in the next run.
    pub fn find_all(&self, device: &Device) {
        self.due.left.write(device, &[1]);
    }

    /// What the last run has found.
    pub fn found(&self) -> Found {
        self.found
    }

    /// The column of contacts and their number, for kernels; once more room has been made they are others.
    pub fn columns(&self) -> (&Buffer<Contact>, &Count) {
        (&self.contacts.contact, &self.contacts.n)
    }

    /// The arms of the contacts, where they are of any direction; else one row that is not used.
    pub fn arms(&self) -> &Buffer<Arms> {
        self.manifolds.as_ref().map_or(&self.no_arms, |manifolds| &manifolds.arms)
    }

    /// As bits: the number of steps, from the start of the last run on and from that of the next, for which the pairs hold (1 each).
    pub fn lasts(&self) -> [&Buffer<u32>; 2] {
        [&self.due.lasts, &self.due.next[0]]
    }

    /// Number of pairs that room is needed for, whether there is room, and number of contacts that it is needed for (3).
    pub fn room(&self) -> &Buffer<u32> {
        &self.pairs.room
    }

    /// The contacts of the last run.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn contacts(&self, device: &Device) -> Result<Vec<Contact>, Fault> {
        Ok(self.contacts.contact.read(device, self.found.contacts)?)
    }

    /// Read the fat AABBs back (n_shapes); those of planes are unbounded, and a fixture's is the tight one.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn fetch_boxes(&self, device: &Device, model: &Model) -> Result<Vec<aabb::Aabb>, GpuError> {
        let corner = |c: [f32; 4]| glam::Vec3A::new(c[0], c[1], c[2]);
        let of = |b: &Aabb| match b.low[0] > b.high[0] {
            true => aabb::Aabb::EMPTY,
            false => aabb::Aabb { min: corner(b.low), max: corner(b.high) },
        };
        let unbounded = aabb::Aabb { min: glam::Vec3A::NEG_INFINITY, max: glam::Vec3A::INFINITY };
        let mut boxes = vec![unbounded; model.n_shapes()];
        let fixed = self.fixtures.boxes.iter().filter(|(s, _)| !model.shape_kind[*s].is_surface());
        fixed.for_each(|(s, b)| boxes[*s] = of(b));
        let own = self.spheres.fat_aabb.read(device, self.spheres.n)?;
        self.spheres.shapes.iter().zip(&own).for_each(|(s, b)| boxes[*s] = of(b));
        Ok(boxes)
    }

    /// The time of a run's stages, s; none if the adapter takes no times.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn stage_seconds(&self, device: &Device, model: &Model) -> Result<Option<Vec<(&'static str, f64)>>, Fault> {
        let mut commands = Commands::new();
        self.record(device, &mut commands, model);
        Ok(commands.submit(device)?.wait(device)?)
    }

    /// Number of dispatches of a run.
    pub fn n_dispatches(&self, device: &Device, model: &Model) -> usize {
        let mut commands = Commands::new();
        self.record(device, &mut commands, model);
        commands.n_dispatches()
    }

    /// Record the stages.
    pub fn record(&self, device: &Device, c: &mut Commands, model: &Model) {
        self.record_from(device, c, model, Stage::Bounds);
    }
}
