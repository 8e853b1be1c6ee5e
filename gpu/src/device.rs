//! The device: an adapter opened without a window, its queue, and its faults.

use crate::adapter::{Adapter, Choice, USED, WIDE_ATOMICS, choose};
use crate::error::GpuError;
use crate::pace::Pace;
use crate::times::{Times, Timings};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// A message that a callback of the device leaves.
type Message = Arc<Mutex<Option<String>>>;

/// An open graphics device and its queue.
pub struct Device {
    /// The adapter that the device belongs to.
    pub adapter: Adapter,
    pub(crate) raw: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// Least and greatest size of a subgroup, where kernels use subgroup operations.
    pub(crate) subgroup: Option<[u32; 2]>,
    /// Whether kernels may take minima of 64 bits in memory.
    has_wide_atomics: bool,
    /// Whether stages are timed.
    pub(crate) has_timestamps: bool,
    /// Whether times are taken between passes.
    pub(crate) has_timestamps_between: bool,
    lost: Message,
    fault: Message,
    pace: Arc<Mutex<Pace>>,
    idle_times: Arc<Mutex<Vec<Times>>>,
    traffic: Mutex<Traffic>,
    /// Times of commands that have not been waited for.
    unsettled: Mutex<Vec<Timings>>,
    dispatches: Mutex<Dispatches>,
    pub(crate) memory: Arc<Memory>,
}

/// Number of dispatches that have been submitted so far, by the names of their stages.
pub type Dispatches = BTreeMap<&'static str, u64>;

/// What has gone between the processor and a device so far, and the time of the processor that it took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Count of submissions to the queue.
    pub submissions: u64,
    /// Count of waits for the device.
    pub waits: u64,
    /// Bytes written to buffers.
    pub bytes_written: u64,
    /// Bytes read from them.
    pub bytes_read: u64,
    /// Time waited for the device, s.
    pub wait_seconds: f64,
    /// Time in which kernels were compiled, s.
    pub compile_seconds: f64,
    /// Time in which buffers were made, s.
    pub buffer_seconds: f64,
    /// Time in which bytes were written to buffers, s.
    pub write_seconds: f64,
    /// Time in which bytes were taken from buffers that had been read back, s.
    pub read_seconds: f64,
    /// Time in which commands were submitted, s.
    pub submit_seconds: f64,
}

impl std::ops::Sub for Traffic {
    type Output = Traffic;

    fn sub(self, o: Traffic) -> Traffic {
        Traffic {
            submissions: self.submissions - o.submissions,
            waits: self.waits - o.waits,
            bytes_written: self.bytes_written - o.bytes_written,
            bytes_read: self.bytes_read - o.bytes_read,
            wait_seconds: self.wait_seconds - o.wait_seconds,
            compile_seconds: self.compile_seconds - o.compile_seconds,
            buffer_seconds: self.buffer_seconds - o.buffer_seconds,
            write_seconds: self.write_seconds - o.write_seconds,
            read_seconds: self.read_seconds - o.read_seconds,
            submit_seconds: self.submit_seconds - o.submit_seconds,
        }
    }
}

/// Bytes of the buffers of a device.
#[derive(Debug)]
pub(crate) struct Memory {
    taken: AtomicU64,
    most: AtomicU64,
    largest: AtomicU64,
    limit: AtomicU64,
}

impl Default for Memory {
    fn default() -> Memory {
        Memory {
            taken: AtomicU64::new(0),
            most: AtomicU64::new(0),
            largest: AtomicU64::new(0),
            limit: AtomicU64::new(u64::MAX),
        }
    }
}

/// Bytes that a buffer takes of a device's memory, until it is dropped.
#[derive(Debug)]
pub(crate) struct Taken {
    memory: Arc<Memory>,
    bytes: u64,
}

impl Memory {
    /// Take bytes; the limit if they do not fit.
    pub(crate) fn take(self: &Arc<Memory>, bytes: u64) -> Result<Arc<Taken>, u64> {
        let limit = self.limit.load(Ordering::Relaxed);
        let now = self.taken.fetch_add(bytes, Ordering::Relaxed).saturating_add(bytes);
        let taken = Arc::new(Taken { memory: self.clone(), bytes });
        if now > limit {
            return Err(limit);
        }
        self.most.fetch_max(now, Ordering::Relaxed);
        self.largest.fetch_max(bytes, Ordering::Relaxed);
        Ok(taken)
    }
}

impl Drop for Taken {
    fn drop(&mut self) {
        self.memory.taken.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl Device {
    /// Open an adapter, with its own limits and with the optional features that kernels and timers use.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::Choice`], or [`GpuError::Open`] if the adapter does not open.
    pub fn open(choice: &Choice) -> Result<Device, GpuError> {
        let (adapter, handle) = choose(choice)?;
        let features = handle.features() & USED;
        let desc = wgpu::DeviceDescriptor {
            label: Some("scree"),
            required_features: features,
            required_limits: handle.limits(),
            ..Default::default()
        };
        let (raw, queue) = pollster::block_on(handle.request_device(&desc))
            .map_err(|e| GpuError::Open { adapter: adapter.name.clone(), message: e.to_string() })?;
        let [lost, fault] = [Message::default(), Message::default()];
        let note = lost.clone();
        raw.set_device_lost_callback(move |reason, text| {
            let text = if text.is_empty() { format!("{reason:?}") } else { text };
            leave(&note, text);
        });
        let note = fault.clone();
        raw.on_uncaptured_error(Arc::new(move |error: wgpu::Error| leave(&note, error.to_string())));
        let subgroup = adapter.subgroup;
        let has_wide_atomics = features.contains(WIDE_ATOMICS);
        let has_timestamps = features.contains(wgpu::Features::TIMESTAMP_QUERY);
        let has_timestamps_between = features.contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS);
        let (pace, idle_times, traffic, unsettled, dispatches, memory) = Default::default();
        Ok(Device {
            adapter,
            raw,
            queue,
            subgroup,
            has_wide_atomics,
            has_timestamps,
            has_timestamps_between,
            lost,
            fault,
            pace,
            idle_times,
            traffic,
            unsettled,
            dispatches,
            memory,
        })
    }

    /// Another handle to the same device, for work beside what this one is given: its traffic and the times of its commands are its own. Loss
    /// and faults are the device's, and so those of all its handles.
    pub fn another(&self) -> Device {
        Device {
            adapter: self.adapter.clone(),
            raw: self.raw.clone(),
            queue: self.queue.clone(),
            subgroup: self.subgroup,
            has_wide_atomics: self.has_wide_atomics,
            has_timestamps: self.has_timestamps,
            has_timestamps_between: self.has_timestamps_between,
            lost: self.lost.clone(),
            fault: self.fault.clone(),
            pace: self.pace.clone(),
            idle_times: self.idle_times.clone(),
            traffic: Mutex::default(),
            unsettled: Mutex::default(),
            dispatches: Mutex::default(),
            memory: self.memory.clone(),
        }
    }

    /// The most bytes that buffers have taken together.
    pub fn most_memory(&self) -> u64 {
        self.memory.most.load(Ordering::Relaxed)
    }

    /// Bytes of the largest buffer that there has been.
    pub fn largest_buffer(&self) -> u64 {
        self.memory.largest.load(Ordering::Relaxed)
    }

    /// Let buffers take no more bytes together than these.
    pub fn limit_memory(&self, bytes: u64) {
        self.memory.limit.store(bytes, Ordering::Relaxed);
    }

    /// Whether commands are timed by the clock of the device.
    pub fn has_timer(&self) -> bool {
        self.has_timestamps
    }

    /// What has gone between the processor and the device so far.
    pub fn traffic(&self) -> Traffic {
        *self.traffic.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The dispatches that have been submitted so far, also those that turned out to have no workgroups.
    pub fn dispatches(&self) -> Dispatches {
        self.dispatches.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(crate) fn count_dispatches(&self, added: &Dispatches) {
        let mut dispatches = self.dispatches.lock().unwrap_or_else(PoisonError::into_inner);
        added.iter().for_each(|(stage, n)| *dispatches.entry(stage).or_default() += n);
    }

    pub(crate) fn count(&self, add: impl FnOnce(&mut Traffic)) {
        add(&mut self.traffic.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Do something, and add the time that it takes to one of those of the traffic.
    pub(crate) fn timed<T>(&self, of: impl FnOnce(&mut Traffic) -> &mut f64, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let done = work();
        self.count(|traffic| *of(traffic) += start.elapsed().as_secs_f64());
        done
    }

    /// Submit commands to the queue.
    pub(crate) fn submit(&self, commands: wgpu::CommandBuffer) -> wgpu::SubmissionIndex {
        self.count(|traffic| traffic.submissions += 1);
        self.timed(|traffic| &mut traffic.submit_seconds, || self.queue.submit([commands]))
    }

    /// Write bytes to a buffer, before any command that is submitted later.
    pub(crate) fn write(&self, buffer: &wgpu::Buffer, start: u64, bytes: &[u8]) {
        self.count(|traffic| traffic.bytes_written += bytes.len() as u64);
        self.timed(|traffic| &mut traffic.write_seconds, || self.queue.write_buffer(buffer, start, bytes));
    }

    /// The times of commands that have not been waited for.
    pub(crate) fn unsettled(&self) -> MutexGuard<'_, Vec<Timings>> {
        self.unsettled.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn pace(&self) -> MutexGuard<'_, Pace> {
        self.pace.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tell by which factor all commands may come to take longer before their times are known again.
    pub fn expect_growth(&self, factor: f64) {
        self.pace().growth = factor;
    }

    /// The longest time that a submission of commands has kept the device so far, s, of those whose timings have been waited for.
    pub fn longest_submission(&self) -> f64 {
        self.pace().longest
    }

    /// Whether kernels may take minima of numbers of 64 bits in memory by atomics.
    pub fn has_wide_atomics(&self) -> bool {
        self.has_wide_atomics
    }

    /// The same device, whose kernels do without atomics of 64 bits, as on an adapter that has none.
    pub fn without_wide_atomics(self) -> Device {
        Device { has_wide_atomics: false, ..self }
    }

    /// The same device, whose kernels do without subgroup operations, as on an adapter that has none.
    pub fn without_subgroups(self) -> Device {
        Device { subgroup: None, ..self }
    }

    /// The same device, whose commands are timed by the clock of the processor alone, as on an adapter that has no timestamps.
    pub fn without_timestamps(self) -> Device {
        Device { has_timestamps: false, ..self }
    }

    /// Give the device up, as a driver does that resets it: whatever is asked of it afterwards is [`GpuError::Lost`].
    pub fn lose(&self) {
        self.raw.destroy();
    }

    /// Check that the device has not been lost and that no command has failed.
    ///
    /// # Errors
    /// [`GpuError::Lost`] or [`GpuError::Device`].
    pub fn check(&self) -> Result<(), GpuError> {
        if let Some(message) = read(&self.lost) {
            return Err(GpuError::Lost(message));
        }
        read(&self.fault).map_or(Ok(()), |message| Err(GpuError::Device(message)))
    }

    /// Wait until all submitted work is done.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn wait(&self) -> Result<(), GpuError> {
        self.poll(wgpu::PollType::wait_indefinitely())
    }

    /// Wait until the work up to a submission is done.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub(crate) fn wait_for(&self, submission: &wgpu::SubmissionIndex) -> Result<(), GpuError> {
        self.poll(wgpu::PollType::Wait { submission_index: Some(submission.clone()), timeout: None })
    }

    fn poll(&self, until: wgpu::PollType) -> Result<(), GpuError> {
        let start = Instant::now();
        let done = self.raw.poll(until);
        self.count(|traffic| {
            traffic.waits += 1;
            traffic.wait_seconds += start.elapsed().as_secs_f64();
        });
        self.check()?;
        done.map(|_| ()).map_err(|e| GpuError::Device(e.to_string()))
    }

    /// The timestamps that commands have done with, for others.
    pub(crate) fn idle_times(&self) -> MutexGuard<'_, Vec<Times>> {
        self.idle_times.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Create something on the device; an error of validation, of the driver or of memory is given to `error`. Scopes of errors are those of a
    /// thread (by the feature `std` of wgpu): what other threads do meanwhile does not get into them.
    pub(crate) fn create<T>(
        &self,
        make: impl FnOnce() -> T,
        error: impl FnOnce(wgpu::Error) -> GpuError,
    ) -> Result<T, GpuError> {
        let memory = self.raw.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.raw.push_error_scope(wgpu::ErrorFilter::Validation);
        let internal = self.raw.push_error_scope(wgpu::ErrorFilter::Internal);
        let made = make();
        let faults = [internal, validation, memory].map(|scope| pollster::block_on(scope.pop()));
        if let Some(message) = read(&self.lost) {
            return Err(GpuError::Lost(message));
        }
        faults.into_iter().flatten().next().map_or(Ok(made), |fault| Err(error(fault)))
    }
}

/// Leave a message, if it is the first.
fn leave(message: &Message, text: String) {
    message.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(text);
}

fn read(message: &Message) -> Option<String> {
    message.lock().unwrap_or_else(PoisonError::into_inner).clone()
}
