//! Timestamps at the beginning and the end of spans of commands, on the device and on their way back.

use crate::buffer::{map, mapped_rows, wait_for_map};
use crate::device::Device;
use crate::error::GpuError;
use std::sync::mpsc::Receiver;
use wgpu::BufferUsages as Usage;

/// The most spans that are timed, by the limit of a query set.
pub(crate) const MAX_TIMED: usize = wgpu::QUERY_SET_MAX_QUERIES as usize / 2;

/// The least number of spans that there is room for.
const LEAST: usize = 16;

/// Room for the timestamps of spans. It is made once and used again: to make it takes longer than a short step.
#[derive(Debug)]
pub(crate) struct Times {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
    /// Number of spans that there is room for.
    room: usize,
    /// Number of spans.
    n: usize,
}

/// Timestamps on their way back.
pub(crate) struct Ticks {
    times: Times,
    mapped: Receiver<Result<(), String>>,
    submission: wgpu::SubmissionIndex,
}

impl Times {
    /// Room for `n` spans.
    pub fn take(device: &Device, n: usize) -> Times {
        let mut idle = device.idle_times();
        if let Some(found) = idle.iter().position(|times| times.room >= n) {
            return Times { n, ..idle.swap_remove(found) };
        }
        drop(idle);
        let room = n.next_power_of_two().clamp(LEAST, MAX_TIMED);
        let bytes = 16 * room as u64;
        let buffer = |usage| {
            let desc = wgpu::BufferDescriptor { label: Some("stages"), size: bytes, usage, mapped_at_creation: false };
            device.raw.create_buffer(&desc)
        };
        Times {
            set: device.raw.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("stages"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * room as u32,
            }),
            resolved: buffer(Usage::QUERY_RESOLVE | Usage::COPY_SRC),
            staging: buffer(Usage::MAP_READ | Usage::COPY_DST),
            room,
            n,
        }
    }

    /// The set, and the index of the first of the two timestamps of a span.
    pub fn of_span(&self, span: usize) -> (&wgpu::QuerySet, u32) {
        (&self.set, 2 * span as u32)
    }

    /// Record that all of them are made ready to be read.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.set, 0..2 * self.n as u32, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, 16 * self.n as u64);
    }

    /// Read them back, once they have been submitted.
    pub fn read_back(self, submission: wgpu::SubmissionIndex) -> Ticks {
        let mapped = map(&self.staging);
        Ticks { times: self, mapped, submission }
    }
}

impl Ticks {
    /// The ticks, two to a span; waits for them.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn wait(self, device: &Device) -> Result<Vec<u64>, GpuError> {
        let Ticks { times, mapped, submission } = self;
        wait_for_map(device, &mapped, &submission)?;
        let ticks = mapped_rows(&times.staging, 2 * times.n)?;
        times.staging.unmap();
        device.idle_times().push(times);
        Ok(ticks)
    }
}
