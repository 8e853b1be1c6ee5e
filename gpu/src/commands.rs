//! Commands: dispatches, copies and clears, recorded once and submitted together any number of times, timed by stage.

use crate::buffer::{Bound, Buffer, wait_for_map};
use crate::device::{Device, Dispatches};
use crate::error::GpuError;
use crate::kernel::Kernel;
use crate::pace::{Key, Unit};
use crate::times::{MAX_TIMED, Span, Ticks, Times, Timings};
use bytemuck::Pod;
use std::time::Instant;

/// The most workgroups in one dimension of a dispatch; longer ones go on in the second.
const MAX_GROUPS: u32 = 65_535;

/// The most bytes that a command copies or clears: longer runs are several commands, so that none keeps a device for long.
const MOST_BYTES: u64 = 1 << 24;

/// The number of workgroups of a dispatch.
#[derive(Clone, Copy, Debug)]
pub enum Work<'a> {
    /// This many. Beyond 65,535 the dispatch extends in y, so that a kernel computes its index from both dimensions and ignores
    /// workgroups past its end.
    Groups(u32),
    /// Those of a row (x, y, z and a pad) of a buffer on the device.
    Indirect(&'a Buffer<[u32; 4]>, usize),
}

/// A recorded command.
enum Command {
    Dispatch { pipeline: wgpu::ComputePipeline, group: wgpu::BindGroup, x: u32, y: u32 },
    Indirect { pipeline: wgpu::ComputePipeline, group: wgpu::BindGroup, args: wgpu::Buffer, offset: u64 },
    Copy { from: wgpu::Buffer, to: wgpu::Buffer, first: u64, bytes: u64 },
    Clear { buffer: wgpu::Buffer, first: u64, bytes: u64 },
}

impl Command {
    fn is_dispatch(&self) -> bool {
        matches!(self, Command::Dispatch { .. } | Command::Indirect { .. })
    }
}

/// The commands of a stage.
struct Stage {
    name: &'static str,
    commands: Vec<Command>,
}

/// A list of commands for a device, by stages.
#[derive(Default)]
pub struct Commands {
    stages: Vec<Stage>,
}

impl Commands {
    /// No commands.
    pub fn new() -> Commands {
        Commands::default()
    }

    /// Begin a stage: what follows is timed under this name.
    pub fn stage(&mut self, name: &'static str) {
        self.stages.push(Stage { name, commands: vec![] });
    }

    fn push(&mut self, command: Command) {
        if self.stages.is_empty() {
            self.stage("");
        }
        self.stages.last_mut().expect("a stage").commands.push(command);
    }

    /// Number of dispatches.
    pub fn n_dispatches(&self) -> usize {
        self.stages.iter().flat_map(|s| &s.commands).filter(|c| c.is_dispatch()).count()
    }

    /// Run a kernel over buffers, bound in order from binding 0, and last, if there are any, its constant parameters.
    ///
    /// # Panics
    /// If a buffer's rows are not as wide as those of the kernel, or their number is another: a defect of the caller.
    pub fn dispatch(&mut self, device: &Device, kernel: &Kernel, buffers: &[Bound], params: &[u32], work: Work) {
        let constants = (!params.is_empty()).then(|| {
            let desc = wgpu::BufferDescriptor {
                label: Some("params"),
                size: 4 * params.len() as u64,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            };
            let raw = device.timed(|traffic| &mut traffic.buffer_seconds, || device.raw.create_buffer(&desc));
            // Written rather than mapped: what a lost device makes cannot be mapped, which only the next check may tell.
            device.write(&raw, 0, bytemuck::cast_slice(params));
            raw
        });
        let params = constants.as_ref().map(|raw| Bound { raw, name: "params", width: 4 });
        let bound: Vec<Bound> = buffers.iter().copied().chain(params).collect();
        let widths: Vec<u32> = bound.iter().map(|b| b.width).collect();
        let expected: Vec<u32> = kernel.slots.iter().map(|s| s.width).collect();
        assert!(
            widths == expected,
            "kernel `{}`: {:?} are bound to {:?}",
            kernel.name,
            bound.iter().map(|b| (b.name, b.width)).collect::<Vec<_>>(),
            kernel.slots.iter().map(|s| (s.name.as_str(), s.width)).collect::<Vec<_>>(),
        );
        let entries: Vec<wgpu::BindGroupEntry> = (0..)
            .zip(&bound)
            .map(|(binding, b)| wgpu::BindGroupEntry { binding, resource: b.raw.as_entire_binding() })
            .collect();
        let group = device.raw.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(kernel.name),
            layout: &kernel.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let pipeline = kernel.pipeline.clone();
        self.push(match work {
            Work::Groups(n) => Command::Dispatch { pipeline, group, x: n.min(MAX_GROUPS), y: n.div_ceil(MAX_GROUPS) },
            Work::Indirect(args, row) => {
                Command::Indirect { pipeline, group, args: args.raw.clone(), offset: row as u64 * 16 }
            }
        });
    }

    /// Copy the first `n` rows of a buffer into another.
    ///
    /// # Panics
    /// If either has fewer rows.
    pub fn copy<T: Pod>(&mut self, from: &Buffer<T>, to: &Buffer<T>, n: usize) {
        assert!(n <= from.capacity() && n <= to.capacity());
        let bytes = ((n * size_of::<T>()) as u64).next_multiple_of(4);
        for (first, bytes) in pieces(bytes) {
            self.push(Command::Copy { from: from.raw.clone(), to: to.raw.clone(), first, bytes });
        }
    }

    /// Make all rows of a buffer zero.
    pub fn clear<T: Pod>(&mut self, buffer: &Buffer<T>) {
        for (first, bytes) in pieces(buffer.raw.size()) {
            self.push(Command::Clear { buffer: buffer.raw.clone(), first, bytes });
        }
    }

    /// Submit all commands, which stay as they are and can be submitted again.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn submit(&self, device: &Device) -> Result<Timings, GpuError> {
        Commands::submit_all(device, [self])
    }

    /// Submit the commands of several lists, any of them several times, in as few submissions as keep the device for no more than some
    /// tenths of a second each, by the times that their stages have taken before.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn submit_all<'a>(device: &Device, lists: impl IntoIterator<Item = &'a Commands>) -> Result<Timings, GpuError> {
        device.check()?;
        Prepared::new(device, lists).submit(device)
    }

    /// Encode all commands for a submission that is to come, while the device is at others.
    pub fn prepare(&self, device: &Device) -> Prepared {
        Prepared::new(device, [self])
    }

    /// Submit all commands as [`Commands::submit`] does, whose times [`Device::settle`] takes.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn send(&self, device: &Device) -> Result<(), GpuError> {
        let timings = self.submit(device)?;
        if timings.ticks.is_some() {
            device.unsettled().push(timings);
        }
        Ok(())
    }

    /// Tell that the commands have taken this time, s, where that is not to be had from their timings: see [`Timings::unobserved`].
    pub fn observe(&self, device: &Device, seconds: f64) {
        Commands::observe_all(device, [self], seconds);
    }

    /// Tell that the commands of several lists have taken this time together, s.
    pub fn observe_all<'a>(device: &Device, lists: impl IntoIterator<Item = &'a Commands>, seconds: f64) {
        let stages = lists.into_iter().flat_map(|list| &list.stages);
        let units: Vec<Unit> = stages.map(|stage| Unit::whole(stage.key())).collect();
        device.pace().observe(&units, seconds);
    }
}

/// Commands that are encoded and ready to be submitted once.
pub struct Prepared {
    /// The submissions, with the units of each.
    submissions: Vec<(wgpu::CommandBuffer, Vec<Unit>)>,
    spans: Vec<Span>,
    times: Option<Times>,
    dispatches: Dispatches,
}

impl Prepared {
    fn new<'a>(device: &Device, lists: impl IntoIterator<Item = &'a Commands>) -> Prepared {
        let stages: Vec<&Stage> = lists.into_iter().flat_map(|list| &list.stages).collect();
        let keys: Vec<Key> = stages.iter().map(|stage| stage.key()).collect();
        let plan = device.pace().plan(&keys);
        // Neighbours of the same name are timed together.
        let spans: Vec<(usize, &[(usize, Unit)])> = (0..)
            .zip(&plan)
            .flat_map(|(k, own)| own.chunk_by(|a, b| a.1.key.0 == b.1.key.0).map(move |units| (k, units)))
            .collect();
        let is_timed = device.has_timestamps && (1..=MAX_TIMED).contains(&spans.len());
        let times = is_timed.then(|| Times::take(&device.raw, &mut device.idle_times(), spans.len()));
        let mut next = 0;
        let (mut submissions, mut dispatches) = (vec![], Dispatches::new());
        for (k, submission) in plan.iter().enumerate() {
            let mut encoder = device.raw.create_command_encoder(&Default::default());
            while let Some((_, units)) = spans.get(next).filter(|span| span.0 == k) {
                let of_unit = |(stage, unit): &(usize, Unit)| &stages[*stage].commands[unit.first..unit.end];
                let commands: Vec<&Command> = units.iter().flat_map(of_unit).collect();
                let name = units[0].1.key.0;
                *dispatches.entry(name).or_default() += commands.iter().filter(|c| c.is_dispatch()).count() as u64;
                encode(device, &mut encoder, (name, &commands), times.as_ref().map(|t| t.of_span(next)));
                next += 1;
            }
            if let Some(times) = times.as_ref().filter(|_| k + 1 == plan.len()) {
                times.resolve(&mut encoder);
            }
            submissions.push((encoder.finish(), units_of(submission)));
        }
        let spans = spans.into_iter().map(|(submission, own)| Span { submission, units: units_of(own) }).collect();
        Prepared { submissions, spans, times, dispatches }
    }

    /// Submit the commands.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn submit(self, device: &Device) -> Result<Timings, GpuError> {
        device.check()?;
        device.count_dispatches(&self.dispatches);
        let mut last = None;
        for (commands, units) in self.submissions {
            let waits = self.times.is_none() && device.pace().is_due(&units);
            if waits {
                device.wait()?;
            }
            let started = Instant::now();
            last = Some(device.submit(commands));
            if waits {
                device.wait()?;
                let seconds = started.elapsed().as_secs_f64();
                device.pace().observe(&units, seconds);
                device.pace().submission(seconds);
            }
        }
        let ticks = self.times.zip(last).map(|(times, last)| times.read_back(last));
        Ok(Timings { spans: self.spans, ticks, is_observed: true })
    }
}

/// Runs of bytes, of [`MOST_BYTES`] at most, that make up this number of them: the first byte of each, and its length.
fn pieces(bytes: u64) -> impl Iterator<Item = (u64, u64)> {
    (0..bytes.div_ceil(MOST_BYTES)).map(move |k| (k * MOST_BYTES, MOST_BYTES.min(bytes - k * MOST_BYTES)))
}

impl Stage {
    fn key(&self) -> Key {
        (self.name, self.commands.len())
    }
}

fn units_of(units: &[(usize, Unit)]) -> Vec<Unit> {
    units.iter().map(|(_, unit)| *unit).collect()
}

impl Commands {
    /// Submit all commands and wait for them. Returns the time that the stage of this name takes, s, from timestamps; where the adapter
    /// has none, the wall time of all stages.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn stage_seconds(&self, device: &Device, stage: &str) -> Result<f64, GpuError> {
        device.wait()?;
        let started = Instant::now();
        let times = self.submit(device)?.wait(device)?;
        let wall = started.elapsed().as_secs_f64();
        Ok(times.map_or(wall, |times| times.iter().filter(|(name, _)| *name == stage).map(|(_, s)| s).sum()))
    }
}

/// Encode commands: a pass for each run of dispatches between copies and clears, and the time before and after them.
fn encode(
    device: &Device,
    encoder: &mut wgpu::CommandEncoder,
    (name, commands): (&str, &[&Command]),
    times: Option<(&wgpu::QuerySet, u32)>,
) {
    if let Some((set, first)) = times {
        mark(device, encoder, set, first);
    }
    for run in commands.chunk_by(|a, b| a.is_dispatch() && b.is_dispatch()) {
        if run[0].is_dispatch() {
            let desc = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes: None };
            let mut pass = encoder.begin_compute_pass(&desc);
            run.iter().for_each(|command| run_in_pass(&mut pass, command));
        } else {
            transfer(encoder, run[0]);
        }
    }
    if let Some((set, first)) = times {
        mark(device, encoder, set, first + 1);
    }
}

/// Take the time; in an empty pass, where the adapter takes none between passes.
fn mark(device: &Device, encoder: &mut wgpu::CommandEncoder, query_set: &wgpu::QuerySet, index: u32) {
    if device.has_timestamps_between {
        encoder.write_timestamp(query_set, index);
        return;
    }
    let writes = wgpu::ComputePassTimestampWrites {
        query_set,
        beginning_of_pass_write_index: Some(index),
        end_of_pass_write_index: None,
    };
    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes: Some(writes) });
}

fn run_in_pass(pass: &mut wgpu::ComputePass, command: &Command) {
    match command {
        Command::Dispatch { pipeline, group, x, y } => {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(*x, *y, 1);
        }
        Command::Indirect { pipeline, group, args, offset } => {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups_indirect(args, *offset);
        }
        Command::Copy { .. } | Command::Clear { .. } => {}
    }
}

fn transfer(encoder: &mut wgpu::CommandEncoder, command: &Command) {
    match command {
        Command::Copy { from, to, first, bytes } => encoder.copy_buffer_to_buffer(from, *first, to, *first, *bytes),
        Command::Clear { buffer, first, bytes } => encoder.clear_buffer(buffer, *first, Some(*bytes)),
        Command::Dispatch { .. } | Command::Indirect { .. } => {}
    }
}

impl Ticks {
    /// The ticks, two to a span; waits for them.
    fn wait(self, device: &Device) -> Result<Vec<u64>, GpuError> {
        wait_for_map(device, &self.mapped, &self.submission)?;
        let (ticks, times) = self.take()?;
        device.idle_times().push(times);
        Ok(ticks)
    }
}

impl Timings {
    /// Number of submissions that the commands were cut into.
    pub fn n_submissions(&self) -> usize {
        self.spans.last().map_or(0, |span| span.submission + 1)
    }

    /// The same times, which tell nothing of how long the commands may take: most of them may have had nothing to do.
    pub fn unobserved(self) -> Timings {
        Timings { is_observed: false, ..self }
    }

    /// Wait for the commands. Returns the time of each stage, s; none if the adapter takes no times.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn wait(self, device: &Device) -> Result<Option<Vec<(&'static str, f64)>>, GpuError> {
        let Some(ticks) = self.ticks else {
            device.wait()?;
            return Ok(None);
        };
        let ticks = ticks.wait(device)?;
        let period = device.queue.get_timestamp_period() as f64 * 1e-9;
        let between = |begin: u64, end: u64| end.saturating_sub(begin) as f64 * period;
        let spans: Vec<(&Span, &[u64])> = self.spans.iter().zip(ticks.chunks(2)).collect();
        let mut pace = device.pace();
        for submission in spans.chunk_by(|a, b| a.0.submission == b.0.submission) {
            let ends = [&submission[0], &submission[submission.len() - 1]];
            pace.submission(between(ends[0].1[0], ends[1].1[1]));
        }
        let mut stages: Vec<(&'static str, f64)> = vec![];
        for (span, ticks) in spans {
            let (name, seconds) = (span.units[0].key.0, between(ticks[0], ticks[1]));
            if self.is_observed {
                pace.observe(&span.units, seconds);
            }
            match stages.last_mut().filter(|last| last.0 == name) {
                Some(last) => last.1 += seconds,
                None => stages.push((name, seconds)),
            }
        }
        Ok(Some(stages))
    }
}

impl Device {
    /// Wait for what [`Commands::send`] has submitted since this was last called; the time of each stage on the device, s: none where it
    /// takes no times.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn settle(&self) -> Result<Vec<(&'static str, f64)>, GpuError> {
        let sent = std::mem::take(&mut *self.unsettled());
        let mut all = vec![];
        for timings in sent {
            all.extend(timings.wait(self)?.unwrap_or_default());
        }
        Ok(all)
    }
}
