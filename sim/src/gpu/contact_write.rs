//! Narrow phase: find the pairs that touch or come within their margins, compact them, write their contacts.
//! in   position  [n_bodies]   fine units
//! in   margin    [n_spheres]  m
//! in   fixture   [n_fixtures]
//! in   pairs     [n_pairs]
//! out  contact   [n_contacts] in the order of the pairs
//! out  room      [3]          whether there is room for all of them, and for how many it is needed
//! Kernels: contact_find.wgsl, the compaction, contact_room.wgsl, contact_write.wgsl. Twin: cpu/contact_write.rs, cpu/sphere_pairs.rs

use super::bodies::Bodies;
use super::bounds::Due;
use super::fixtures::Fixtures;
use super::pair_write::Pairs;
use super::parts::{Layout, ROWS, bits, kernel, kernel_of};
use super::rows::Contact;
use super::spheres::Spheres;
use crate::model::Model;
use gpu::compact::Compact;
use gpu::{Bound, Buffer, Commands, Count, Device, GpuError, Groups, Kernel, Kernels, Work};

/// The contacts.
pub struct Contacts {
    /// Whether each pair touches (n_pairs).
    touches: Buffer<u32>,
    /// The pairs that touch (n_contacts).
    pub touching: Buffer<u32>,
    /// The contacts (n_contacts).
    pub contact: Buffer<Contact>,
    /// Number of contacts.
    pub n: Count,
    compact: Compact,
}

impl Contacts {
    /// Number of contacts of the pairs before each pair, and of all (n_pairs + 1).
    pub fn places(&self) -> &Buffer<u32> {
        self.compact.places()
    }

    /// With room for this many pairs and contacts: of a bed's pairs a quarter touch.
    pub fn new(device: &Device, kernels: &Kernels, [n_pairs, n_contacts]: [usize; 2]) -> Result<Contacts, GpuError> {
        Ok(Contacts {
            touches: Buffer::zeros(device, "touches", n_pairs)?,
            touching: Buffer::zeros(device, "touching", n_contacts)?,
            contact: Buffer::zeros(device, "contact", n_contacts)?,
            n: Count::found(device, n_contacts)?,
            compact: Compact::new(device, kernels, n_pairs)?,
        })
    }
}

/// The stage's kernels.
pub struct ContactWrite {
    find: Kernel,
    room: Kernel,
    write: Kernel,
    groups: [Groups; 2],
}

impl ContactWrite {
    /// Compile the kernels.
    pub fn new(device: &Device, kernels: &Kernels, layout: Layout) -> Result<ContactWrite, GpuError> {
        Ok(ContactWrite {
            find: kernel_of(layout, device, kernels, ("contact_find", include_str!("contact_find.wgsl")))?,
            room: kernel(device, kernels, "contact_room", include_str!("contact_room.wgsl"))?,
            write: kernel_of(layout, device, kernels, ("contact_write", include_str!("contact_write.wgsl")))?,
            groups: [Groups::new(device, kernels, ROWS)?, Groups::new(device, kernels, ROWS)?],
        })
    }

    /// Record the stage; `hold` tells that the pairs are expected to hold.
    pub fn record(
        &self,
        device: &Device,
        commands: &mut Commands,
        model: &Model,
        (bodies, at, fixtures): (&Bodies, &Spheres, &Fixtures),
        (due, hold): (&Due, bool),
        (from, to): (&Pairs, &Contacts),
    ) {
        let [of_pairs, of_contacts] = &self.groups;
        let unit = bits(bodies.scale.unit);
        of_pairs.record(device, commands, &from.n);
        let shapes = [bodies.position.bind(), at.sphere.bind(), fixtures.fixture.bind()];
        let [position, sphere, fixture] = shapes;
        let pairs = from.pairs.bind();
        let bound = [position, sphere, fixture, at.margin.bind(), pairs, to.touches.bind(), from.n.n.bind()];
        // The margin of a fixture is as single precision has it on the CPU.
        commands.dispatch(device, &self.find, &bound, &[unit, bits(model.envelope)], of_pairs.of_level(&from.n, 0));
        to.compact.record(device, commands, &to.touches, &from.n, &to.touching, &to.n);
        let counts = [from.room.bind(), to.n.n.bind(), from.n.n.bind(), due.left.bind(), due.lost.bind()];
        let bound: Vec<Bound> = [to.compact.places().bind()].into_iter().chain(counts).collect();
        let rooms = [from.pairs.capacity() as u32, to.contact.capacity() as u32, hold as u32];
        commands.dispatch(device, &self.room, &bound, &rooms, Work::Groups(1));
        of_contacts.record(device, commands, &to.n);
        let bound = [position, sphere, fixture, pairs, to.touching.bind(), to.contact.bind(), to.n.n.bind()];
        let params = [model.material_names.len() as u32, unit];
        commands.dispatch(device, &self.write, &bound, &params, of_contacts.of_level(&to.n, 0));
    }
}
