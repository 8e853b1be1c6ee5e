//! Times of submitted commands, as the device takes them.

use crate::pace::Unit;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Mutex, PoisonError};

/// The most spans that are timed, by the limit of a query set.
pub(crate) const MAX_TIMED: usize = wgpu::QUERY_SET_MAX_QUERIES as usize / 2;

/// Timestamps at the beginning and the end of each span of commands.
#[derive(Debug)]
pub(crate) struct Times {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    pub(crate) staging: wgpu::Buffer,
    /// The most spans.
    capacity: usize,
}

/// Timestamps on their way back.
pub(crate) struct Ticks {
    pub(crate) times: Times,
    pub(crate) n_spans: usize,
    pub(crate) mapped: Receiver<Result<(), String>>,
}

impl Times {
    /// For so many spans: such as have served before, or new ones.
    pub(crate) fn new(device: &wgpu::Device, spare: &Mutex<Vec<Times>>, n_spans: usize) -> Times {
        let mut spare = spare.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(k) = spare.iter().position(|times| times.capacity >= n_spans) {
            return spare.swap_remove(k);
        }
        drop(spare);
        let capacity = n_spans.next_power_of_two().clamp(8, MAX_TIMED);
        let count = 2 * capacity as u32;
        let set = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("stages"),
            ty: wgpu::QueryType::Timestamp,
            count,
        });
        let buffer = |usage| {
            let size = u64::from(count) * 8;
            let label = Some("stages");
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
        };
        use wgpu::BufferUsages as Usage;
        let resolved = buffer(Usage::QUERY_RESOLVE | Usage::COPY_SRC);
        Times { set, resolved, staging: buffer(Usage::MAP_READ | Usage::COPY_DST), capacity }
    }

    pub(crate) fn of_span(&self, span: usize) -> (&wgpu::QuerySet, u32) {
        (&self.set, 2 * span as u32)
    }

    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder, n_spans: usize) {
        let n = 2 * n_spans as u32;
        encoder.resolve_query_set(&self.set, 0..n, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, u64::from(n) * 8);
    }

    /// Begin to read them, after what resolves them is submitted.
    pub(crate) fn read_back(self, n_spans: usize) -> Ticks {
        let (send, mapped) = channel();
        self.staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // The reader may have gone.
            let _ = send.send(result.map_err(|e| e.to_string()));
        });
        Ticks { times: self, n_spans, mapped }
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
    pub(crate) submission: usize,
    pub(crate) units: Vec<Unit>,
}
