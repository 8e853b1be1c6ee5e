//! Timestamps at the beginning and the end of spans of commands, on the device and on their way back.

use crate::error::GpuError;
use crate::mapped::{Mapped, map, mapped_rows};
use crate::pace::Unit;
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
    pub mapped: Mapped,
    pub submission: wgpu::SubmissionIndex,
}

impl Times {
    /// Room for `n` spans: one that is idle, or a new one.
    pub fn take(device: &wgpu::Device, idle: &mut Vec<Times>, n: usize) -> Times {
        if let Some(found) = idle.iter().position(|times| times.room >= n) {
            return Times { n, ..idle.swap_remove(found) };
        }
        let room = n.next_power_of_two().clamp(LEAST, MAX_TIMED);
        let bytes = 16 * room as u64;
        let buffer = |usage| {
            let desc = wgpu::BufferDescriptor { label: Some("stages"), size: bytes, usage, mapped_at_creation: false };
            device.create_buffer(&desc)
        };
        Times {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
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
    /// The ticks, two to a span, once they are mapped; and the room that they had.
    pub fn take(self) -> Result<(Vec<u64>, Times), GpuError> {
        let ticks = mapped_rows(&self.times.staging, 2 * self.times.n)?;
        self.times.staging.unmap();
        Ok((ticks, self.times))
    }
}

/// The times of the stages of submitted commands.
pub struct Timings {
    pub(crate) spans: Vec<Span>,
    pub(crate) ticks: Option<Ticks>,
    /// Whether later submissions are cut by these times.
    pub(crate) is_observed: bool,
}

/// Commands of the same stage in a submission.
pub(crate) struct Span {
    pub submission: usize,
    pub units: Vec<Unit>,
}
