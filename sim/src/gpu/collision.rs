//! Collision of spheres on a device: the stages from `bounds` to `contact_write`, recorded once and submitted for every step.
//!
//! Pairs hold while no sphere has left its fat box: the stages of the broad phase then have nothing to do, as their counts on the device
//! say. If there are more pairs than room, the step is done again with more; none is dropped.

use super::bin_emit::{BinEmit, Bins, bits, n_bins};
use super::bin_start::BinStart;
use super::bounds::{Bounds, Due};
use super::contact_write::{ContactWrite, Contacts};
use super::pair_write::{PairWrite, Pairs};
use super::rows::Contact;
use super::spheres::Spheres;
use crate::model::Model;
use crate::state::State;
use gpu::radix_sort::RadixSort;
use gpu::{Buffer, Commands, Count, Device, GpuError, Kernels};

pub use super::spheres::Fault;

/// Number of pairs and of contacts of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// Number of pairs of fat boxes.
    pub pairs: usize,
    /// Number of contacts.
    pub contacts: usize,
}

/// The collision stages of a model's spheres.
pub struct Collision {
    spheres: Spheres,
    due: Due,
    bins: Bins,
    bounds: Bounds,
    bin_emit: BinEmit,
    bin_sort: RadixSort<u32>,
    bin_start: BinStart,
    pair_write: PairWrite,
    contact_write: ContactWrite,
    pairs: Pairs,
    contacts: Contacts,
    commands: Commands,
    found: Found,
}

impl Collision {
    /// For the spheres of a model, with bins for where they are now.
    ///
    /// # Errors
    /// Those of the spheres, and [`Fault::Gpu`].
    pub fn new(device: &Device, kernels: &Kernels, model: &Model, state: &State) -> Result<Collision, Fault> {
        let spheres = Spheres::new(device, model, state)?;
        let n = spheres.n;
        let bits = bits_of(model, state, n);
        let n_bins = n_bins(bits);
        let bins = Bins {
            bits,
            bin: Buffer::zeros(device, "bin", n)?,
            shape: Buffer::zeros(device, "bin_shape", n)?,
            start: Buffer::zeros(device, "bin_start", n_bins)?,
        };
        // A sphere in a bed touches about six others, a pair each for two.
        let room = 4 * n + 64;
        let mut collision = Collision {
            due: Due::new(device, n, n_bins)?,
            bins,
            bounds: Bounds::new(device, kernels)?,
            bin_emit: BinEmit::new(device, kernels)?,
            bin_sort: RadixSort::new(device, kernels, n)?,
            bin_start: BinStart::new(device, kernels)?,
            pair_write: PairWrite::new(device, kernels, model, n)?,
            contact_write: ContactWrite::new(device, kernels)?,
            pairs: pairs(device, n, room)?,
            contacts: Contacts::new(device, kernels, room)?,
            commands: Commands::new(),
            found: Found { pairs: 0, contacts: 0 },
            spheres,
        };
        collision.commands = collision.record(device, model);
        Ok(collision)
    }

    /// Take over the positions, velocities and activities of a state.
    ///
    /// # Errors
    /// [`Fault::Position`].
    pub fn place(&mut self, device: &Device, state: &State) -> Result<(), Fault> {
        if self.spheres.place(device, state)? {
            // Pairs of bodies that are held are left out, and so are those that are inactive.
            self.find_all(device);
        }
        Ok(())
    }

    /// Run the stages for where the spheres are.
    ///
    /// # Errors
    /// [`Fault::Gpu`], also if there is no memory for the pairs.
    pub fn run(&mut self, device: &Device, kernels: &Kernels, model: &Model) -> Result<Found, Fault> {
        loop {
            self.commands.submit(device)?;
            let pairs = self.pairs.n.read(device)?;
            if pairs <= self.pairs.pairs.capacity() {
                self.found = Found { pairs, contacts: self.contacts.n.read(device)? };
                return Ok(self.found);
            }
            let room = pairs + pairs / 2;
            self.pairs = self::pairs(device, self.spheres.n, room)?;
            self.contacts = Contacts::new(device, kernels, room)?;
            self.commands = self.record(device, model);
            self.find_all(device);
        }
    }

    /// Have the pairs found again in the next run.
    pub fn find_all(&self, device: &Device) {
        self.due.left.write(device, &[1]);
    }

    /// What the last run has found.
    pub fn found(&self) -> Found {
        self.found
    }

    /// The column of contacts and their number, for kernels; after a run that has made more room they are others.
    pub fn columns(&self) -> (&Buffer<Contact>, &Count) {
        (&self.contacts.contact, &self.contacts.n)
    }

    /// The contacts of the last run.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn contacts(&self, device: &Device) -> Result<Vec<Contact>, Fault> {
        Ok(self.contacts.contact.read(device, self.found.contacts)?)
    }

    /// The time of a run's stages, s; none if the adapter takes no times.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn stage_seconds(&self, device: &Device) -> Result<Option<Vec<(&'static str, f64)>>, Fault> {
        Ok(self.commands.submit(device)?.wait(device)?)
    }

    /// Number of dispatches of a run.
    pub fn n_dispatches(&self) -> usize {
        self.commands.n_dispatches()
    }

    fn record(&self, device: &Device, model: &Model) -> Commands {
        let Collision { spheres, due, bins, pairs, contacts, .. } = self;
        let mut commands = Commands::new();
        let c = &mut commands;
        c.stage("bounds");
        self.bounds.record(device, c, model, spheres, due);
        c.stage("bin_emit");
        self.bin_emit.record(device, c, spheres, due, bins);
        c.stage("bin_sort");
        let max_key = n_bins(bins.bits) as u32;
        self.bin_sort.record(device, c, (&bins.bin, &bins.shape), &due.spheres, max_key);
        c.stage("bin_start");
        self.bin_start.record(device, c, due, bins);
        c.stage("pair_write");
        self.pair_write.record(device, c, model, spheres, (due, bins), pairs);
        c.stage("contact_write");
        self.contact_write.record(device, c, model, spheres, pairs, contacts);
        commands
    }
}

fn pairs(device: &Device, n: usize, room: usize) -> Result<Pairs, GpuError> {
    let start = Buffer::zeros(device, "pair_start", n + 1)?;
    Ok(Pairs { start, pairs: Buffer::zeros(device, "pairs", room)?, n: Count::found(device, room)? })
}

/// Bits of the bins' coordinates, for the box about the moving spheres and their usual width.
fn bits_of(model: &Model, state: &State, n: usize) -> [u32; 3] {
    let moving = || {
        let spheres = (0..model.n_shapes()).filter(|s| model.is_centred_sphere(*s));
        spheres.map(|s| (state.position[model.shape_body[s] as usize], model.shape_size[s].x))
    };
    let inverse: f64 = moving().map(|(_, radius)| 0.5 / radius).sum();
    let low = moving().fold(glam::DVec3::INFINITY, |low, (p, _)| low.min(p));
    let high = moving().fold(glam::DVec3::NEG_INFINITY, |high, (p, _)| high.max(p));
    bits(n, n as f64 / inverse, (high - low).to_array())
}
