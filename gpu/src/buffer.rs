//! Typed buffers of a device, which grow, and their read-back, which does not block.

use crate::device::{Device, Taken};
use crate::error::GpuError;
use crate::mapped::{Mapped, map, mapped_rows};
use bytemuck::Pod;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::mpsc::TryRecvError;
use wgpu::BufferUsages as Usage;

/// A storage buffer of rows of type `T`, at least one. Clones are the same memory.
#[derive(Clone, Debug)]
pub struct Buffer<T> {
    pub(crate) raw: wgpu::Buffer,
    name: &'static str,
    capacity: usize,
    /// What it takes of the device's memory.
    _taken: Arc<Taken>,
    row: PhantomData<T>,
}

/// A buffer as a kernel binds it.
#[derive(Clone, Copy, Debug)]
pub struct Bound<'a> {
    pub(crate) raw: &'a wgpu::Buffer,
    pub(crate) name: &'static str,
    /// Size of a row, bytes.
    pub(crate) width: u32,
}

impl<T: Pod> Buffer<T> {
    /// A buffer of `capacity` rows of zeros; `name` stands in errors.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::Limit`], [`GpuError::Memory`], [`GpuError::Lost`].
    pub fn zeros(device: &Device, name: &'static str, capacity: usize) -> Result<Buffer<T>, GpuError> {
        let capacity = capacity.max(1);
        // A whole number of words.
        let bytes = (capacity as u64).saturating_mul(size_of::<T>() as u64).saturating_add(3) / 4 * 4;
        let limit = device.adapter.max_buffer.min(device.adapter.max_binding);
        if bytes > limit {
            return Err(GpuError::TooLarge { buffer: name.into(), bytes, limit });
        }
        let taken = take(device, name, bytes)?;
        let usage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST | Usage::INDIRECT;
        let desc = wgpu::BufferDescriptor { label: Some(name), size: bytes, usage, mapped_at_creation: false };
        let raw = device.create(
            || device.timed(|traffic| &mut traffic.buffer_seconds, || device.raw.create_buffer(&desc)),
            |error| match error {
                wgpu::Error::OutOfMemory { .. } => GpuError::Memory { buffer: name.into(), bytes },
                other => GpuError::Device(other.to_string()),
            },
        )?;
        Ok(Buffer { raw, name, capacity, _taken: taken, row: PhantomData })
    }

    /// A buffer that holds `rows`.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`].
    pub fn of(device: &Device, name: &'static str, rows: &[T]) -> Result<Buffer<T>, GpuError> {
        let buffer = Buffer::zeros(device, name, rows.len())?;
        buffer.write(device, rows);
        Ok(buffer)
    }

    /// Number of rows that it has room for.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Write the first rows, before any command that is submitted later.
    ///
    /// # Panics
    /// If there are more rows than the buffer has room for.
    pub fn write(&self, device: &Device, rows: &[T]) {
        self.write_from(device, 0, rows);
    }

    /// Write rows from the row `first` on, which begins at a whole number of words, before any command that is submitted later.
    ///
    /// # Panics
    /// If there are more rows than the buffer has room for.
    pub fn write_from(&self, device: &Device, first: usize, rows: &[T]) {
        let end = first + rows.len();
        assert!(end <= self.capacity, "{end} rows for buffer `{}` of {}", self.name, self.capacity);
        let start = (first * size_of::<T>()) as u64;
        let bytes: &[u8] = bytemuck::cast_slice(rows);
        let whole = bytes.len() / 4 * 4;
        device.write(&self.raw, start, &bytes[..whole]);
        if whole < bytes.len() {
            let mut last = [0; 4];
            last[..bytes.len() - whole].copy_from_slice(&bytes[whole..]);
            device.write(&self.raw, start + whole as u64, &last);
        }
    }

    /// Make room for `n` rows, with half as many to spare if it grows; what it holds is kept. Returns whether it has grown: recorded
    /// commands then still mean the old memory.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`]; the buffer is then as it was.
    pub fn reserve(&mut self, device: &Device, n: usize) -> Result<bool, GpuError> {
        if n <= self.capacity {
            return Ok(false);
        }
        let row = size_of::<T>().max(1) as u64;
        let most = (device.adapter.max_buffer.min(device.adapter.max_binding) / row) as usize;
        let larger = match Buffer::zeros(device, self.name, n.saturating_add(n / 2).min(most).max(n)) {
            Err(GpuError::Limit { .. }) => Buffer::zeros(device, self.name, n)?,
            other => other?,
        };
        let mut encoder = device.raw.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&self.raw, 0, &larger.raw, 0, self.raw.size());
        device.submit(encoder.finish());
        *self = larger;
        Ok(true)
    }

    /// The buffer as a kernel binds it.
    pub fn bind(&self) -> Bound<'_> {
        Bound { raw: &self.raw, name: self.name, width: size_of::<T>() as u32 }
    }

    /// Begin to read the first `n` rows, as all commands submitted so far leave them.
    ///
    /// # Errors
    /// [`GpuError::Memory`], [`GpuError::Lost`].
    pub fn read_back(&self, device: &Device, n: usize) -> Result<ReadBack<T>, GpuError> {
        assert!(n <= self.capacity, "{n} rows of buffer `{}` of {}", self.name, self.capacity);
        let size = ((n.max(1) * size_of::<T>()) as u64).next_multiple_of(4);
        let usage = Usage::MAP_READ | Usage::COPY_DST;
        let desc = wgpu::BufferDescriptor { label: Some(self.name), size, usage, mapped_at_creation: false };
        let taken = take(device, self.name, size)?;
        let staging = device.create(
            || device.timed(|traffic| &mut traffic.buffer_seconds, || device.raw.create_buffer(&desc)),
            |error| match error {
                wgpu::Error::OutOfMemory { .. } => GpuError::Memory { buffer: self.name.into(), bytes: size },
                other => GpuError::Device(other.to_string()),
            },
        )?;
        let mut encoder = device.raw.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&self.raw, 0, &staging, 0, size);
        let submission = device.submit(encoder.finish());
        device.count(|traffic| traffic.bytes_read += size);
        let mapped = map(&staging);
        Ok(ReadBack { staging, _taken: taken, mapped, submission, n, row: PhantomData })
    }

    /// Read the first `n` rows; waits until all work that has been submitted so far is done.
    ///
    /// # Errors
    /// Those of [`Buffer::read_back`] and of [`Device::check`].
    pub fn read(&self, device: &Device, n: usize) -> Result<Vec<T>, GpuError> {
        self.read_back(device, n)?.wait(device)
    }
}

/// Take memory for a buffer.
fn take(device: &Device, name: &str, bytes: u64) -> Result<Arc<Taken>, GpuError> {
    device.memory.take(bytes).map_err(|limit| GpuError::Limit { buffer: name.into(), bytes, limit })
}

/// Wait for a buffer that is being mapped, which the work up to a submission writes.
///
/// # Errors
/// Those of [`Device::check`].
pub(crate) fn wait_for_map(
    device: &Device,
    mapped: &Mapped,
    submission: &wgpu::SubmissionIndex,
) -> Result<(), GpuError> {
    device.wait_for(submission)?;
    mapped.recv().map_err(|_| GpuError::Device("a transfer was dropped".into()))?.map_err(GpuError::Device)
}

/// Rows on their way back from a device.
pub struct ReadBack<T> {
    staging: wgpu::Buffer,
    /// What they take of the device's memory.
    _taken: Arc<Taken>,
    mapped: Mapped,
    submission: wgpu::SubmissionIndex,
    n: usize,
    row: PhantomData<T>,
}

impl<T: Pod> ReadBack<T> {
    /// The rows, if they have arrived; else itself, to be asked again. Does not block.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn poll(self, device: &Device) -> Result<Result<Vec<T>, ReadBack<T>>, GpuError> {
        let polled = device.raw.poll(wgpu::PollType::Poll);
        device.check()?;
        polled.map_err(|e| GpuError::Device(e.to_string()))?;
        match self.mapped.try_recv() {
            Ok(result) => {
                result.map_err(GpuError::Device)?;
                mapped_rows(&self.staging, self.n).map(Ok)
            }
            Err(TryRecvError::Empty) => Ok(Err(self)),
            Err(TryRecvError::Disconnected) => Err(GpuError::Device("a transfer was dropped".into())),
        }
    }

    /// The rows; waits for them.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn wait(self, device: &Device) -> Result<Vec<T>, GpuError> {
        wait_for_map(device, &self.mapped, &self.submission)?;
        device.timed(|traffic| &mut traffic.read_seconds, || mapped_rows(&self.staging, self.n))
    }
}
