//! Start each contact from the impulse that the contact of the same shapes and feature had in the last step.
//! in   contact     [n_contacts]
//! in   last_key    [n_last]      shapes and features of the last step's contacts
//! in   last_gamma  [n_last]      N s, world
//! in   last_roll   [n_last]      N m s, world, where there is rolling friction
//! out  gamma       [n_contacts]  N s, world; zero for a new contact
//! out  roll        [n_contacts]  N m s, world
//! Kernels: last_insert.wgsl, warm_start.wgsl; last_write.wgsl at the step's end. Twin: cpu/warm_start.rs, which goes along the pairs while
//! these hold.
//!
//! What a step starts from is written once the step is known to be valid, so that a step can be done again.

use super::parts::{Layout, ROWS, kernel, kernel_of};
use super::rows::Contact;
use crate::contacts::Contacts;
use gpu::{Buffer, Commands, Count, Device, GpuError, Groups, Kernel, Kernels};

/// The contacts of the last step, and the stage's kernels.
pub struct WarmStart {
    insert: Kernel,
    find: Kernel,
    write: Kernel,
    groups: [Groups; 2],
    /// Shapes and feature; the fourth number is not used (n_last).
    key: Buffer<[u32; 4]>,
    /// Impulses, N s, world (n_last).
    gamma: Buffer<[f32; 4]>,
    /// Rolling impulses, N m s, world, where there is rolling friction; else one row (n_last).
    roll: Buffer<[f32; 4]>,
    /// Their number.
    n: Count,
    /// One more than the index of a contact, by its shapes and feature.
    table: Buffer<u32>,
}

impl WarmStart {
    /// With room for this many contacts.
    pub fn new(device: &Device, kernels: &Kernels, layout: Layout, room: usize) -> Result<WarmStart, GpuError> {
        Ok(WarmStart {
            insert: kernel(device, kernels, "last_insert", include_str!("last_insert.wgsl"))?,
            find: kernel_of(layout, device, kernels, ("warm_start", include_str!("warm_start.wgsl")))?,
            write: kernel_of(layout, device, kernels, ("last_write", include_str!("last_write.wgsl")))?,
            groups: [Groups::new(device, kernels, ROWS)?, Groups::new(device, kernels, ROWS)?],
            key: Buffer::zeros(device, "last_key", room)?,
            gamma: Buffer::zeros(device, "last_gamma", room)?,
            roll: Buffer::zeros(device, "last_roll", if layout.rolls { room } else { 1 })?,
            n: Count::found(device, room)?,
            table: Buffer::zeros(device, "contact table", slots(room))?,
        })
    }

    /// Make room for as many contacts as `room`; those of the last step are kept. Recorded commands then mean the old columns.
    pub fn make_room(&mut self, device: &Device, room: usize) -> Result<(), GpuError> {
        self.key.reserve(device, room)?;
        self.gamma.reserve(device, room)?;
        if self.roll.capacity() > 1 {
            self.roll.reserve(device, room)?;
        }
        self.n.capacity = self.key.capacity().min(self.gamma.capacity());
        self.table = Buffer::zeros(device, "contact table", slots(self.n.capacity))?;
        Ok(())
    }

    /// Take over the contacts of a state. There must be room for them.
    pub fn place(&self, device: &Device, contacts: &Contacts) {
        let key: Vec<[u32; 4]> = contacts.key.iter().map(|k| [k[0], k[1], k[2], 0]).collect();
        let gamma: Vec<[f32; 4]> = contacts.impulse.iter().map(|z| z.as_vec3().extend(0.0).to_array()).collect();
        if self.roll.capacity() > 1 {
            let vector = |v: &glam::DVec3| v.as_vec3().extend(0.0).to_array();
            let mut roll: Vec<[f32; 4]> = contacts.rolling_impulse.iter().map(vector).collect();
            roll.resize(key.len(), [0.0; 4]);
            self.roll.write(device, &roll);
        }
        self.key.write(device, &key);
        self.gamma.write(device, &gamma);
        self.n.n.write(device, &[key.len() as u32]);
    }

    /// Record the stage for contacts whose number `n` is known to `groups`.
    pub fn record(
        &self,
        device: &Device,
        commands: &mut Commands,
        (contact, n): (&Buffer<Contact>, &Count),
        [gamma, roll]: [&Buffer<[f32; 4]>; 2],
    ) {
        let [of_last, of_contacts] = &self.groups;
        commands.clear(&self.table);
        of_last.record(device, commands, &self.n);
        let bound = [self.key.bind(), self.table.bind(), self.n.n.bind()];
        commands.dispatch(device, &self.insert, &bound, &[], of_last.of_level(&self.n, 0));
        of_contacts.record(device, commands, n);
        let last = [self.key.bind(), self.gamma.bind(), self.table.bind()];
        let rolling = [self.roll.bind(), roll.bind()];
        let bound = [contact.bind(), last[0], last[1], last[2], gamma.bind(), n.n.bind(), rolling[0], rolling[1]];
        commands.dispatch(device, &self.find, &bound, &[], of_contacts.of_level(n, 0));
    }

    /// Record that the contacts of this step are those of the last one in the next step, unless this one is undone.
    pub fn record_keep(
        &self,
        device: &Device,
        commands: &mut Commands,
        (contact, n): (&Buffer<Contact>, &Count),
        ([gamma, roll], room): ([&Buffer<[f32; 4]>; 2], &Buffer<u32>),
    ) {
        let out = [self.key.bind(), self.gamma.bind(), self.n.n.bind()];
        let rolling = [roll.bind(), self.roll.bind()];
        let own = [contact.bind(), gamma.bind(), out[0], out[1], out[2], room.bind(), n.n.bind()];
        let bound: Vec<gpu::Bound> = own.into_iter().chain(rolling).collect();
        // No contacts are kept, too, by one workgroup at least.
        let one = gpu::Work::Groups(1);
        commands.dispatch(device, &self.write, &bound, &[], one);
        commands.dispatch(device, &self.write, &bound, &[], self.groups[1].of_level(n, 0));
    }
}

/// Slots of the table for a number of contacts.
fn slots(n: usize) -> usize {
    (2 * n).next_power_of_two().max(2)
}
