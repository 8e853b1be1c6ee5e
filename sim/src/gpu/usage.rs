//! What a device has been used for.

use gpu::{Dispatches, Traffic};

/// What a device has been used for.
#[derive(Clone, Debug)]
pub struct Usage {
    /// The longest time that a submission of commands has kept it, s.
    pub longest_submission: f64,
    /// The most bytes that buffers have taken together.
    pub most_bytes: u64,
    /// Bytes of the largest buffer.
    pub largest_buffer: u64,
    /// Bytes of a contact and sweep from memory, by the method of the model.
    pub bytes_per_contact_sweep: f64,
    /// Sweeps over contacts, by the number of these.
    pub contact_sweeps: u64,
    /// Steps that were begun as if the pairs held, and begun again since they did not.
    pub begun_again: u64,
    /// What has gone between the processor and the device.
    pub traffic: Traffic,
    /// Dispatches by stage.
    pub dispatches: Dispatches,
}
