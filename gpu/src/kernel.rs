//! Kernels: WGSL text with `#import NAME` lines resolved, compiled once for a device, and ready to be recorded.

use crate::device::Device;
use crate::error::GpuError;
use crate::layout::{Slot, parse, slots};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// A part that kernels import: its name and text.
pub type Part<'a> = (&'a str, &'a str);

/// The parts that any kernel can import.
const PARTS: &[Part<'static>] = &[
    ("block", include_str!("kernels/block.wgsl")),
    ("lane", include_str!("kernels/lane.wgsl")),
    ("group_sum", include_str!("kernels/group_sum.wgsl")),
    ("group_tree", include_str!("kernels/group_tree.wgsl")),
    ("same_digit", include_str!("kernels/same_digit.wgsl")),
    ("key", include_str!("kernels/key.wgsl")),
    ("combine", include_str!("kernels/combine.wgsl")),
];

/// The parts that stand in their stead where the device has subgroup operations.
const SUBGROUP_PARTS: &[Part<'static>] = &[
    ("lane", include_str!("kernels/lane_subgroup.wgsl")),
    ("group_sum", include_str!("kernels/group_sum_subgroup.wgsl")),
    ("group_tree", include_str!("kernels/group_tree_subgroup.wgsl")),
    ("same_digit", include_str!("kernels/same_digit_subgroup.wgsl")),
];

/// A compiled WGSL compute kernel: entry point `main`, storage buffers in bind group 0, numbered from 0. Clones are the same kernel.
#[derive(Clone)]
pub struct Kernel {
    pub(crate) name: &'static str,
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) slots: Arc<[Slot]>,
}

/// The kernels that have been compiled for a device, by their text.
#[derive(Default)]
pub struct Kernels {
    compiled: Mutex<HashMap<String, Kernel>>,
}

impl Kernels {
    /// The kernel of a WGSL text, whose lines `#import NAME` are replaced by the part of that name: of `parts`, or one that all kernels
    /// can import. It is compiled the first time. `name` stands in errors.
    ///
    /// # Errors
    /// [`GpuError::Kernel`] with the place of the fault, or [`GpuError::Lost`].
    pub fn get(&self, device: &Device, name: &'static str, text: &str, parts: &[Part]) -> Result<Kernel, GpuError> {
        timed(device, || self.found(device, name, text, parts))
    }

    /// Compile the kernels of some texts, with their names: [`Kernels::get`] then finds them. Several threads read and check the texts, the
    /// driver is given one after the other.
    ///
    /// # Errors
    /// Those of [`Kernels::get`], of the first text that has one.
    pub fn compile_all(&self, device: &Device, texts: &[(&'static str, &str)], parts: &[Part]) -> Result<(), GpuError> {
        timed(device, || {
            let of = |(name, text): &(&'static str, &str)| self.found(device, name, text, parts);
            let found: Vec<Result<(Kernel, bool), GpuError>> = texts.par_iter().map(of).collect();
            let mut compiles = false;
            for found in found {
                compiles |= found?.1;
            }
            Ok(((), compiles))
        })
    }

    /// The kernel of a text, and whether it has been compiled now.
    fn found(
        &self,
        device: &Device,
        name: &'static str,
        text: &str,
        parts: &[Part],
    ) -> Result<(Kernel, bool), GpuError> {
        let fault = |message: String| GpuError::Kernel { kernel: name.into(), message };
        let text = resolve(text, parts, device.subgroup).map_err(fault)?;
        if let Some(kernel) = self.compiled().get(&text) {
            return Ok((kernel.clone(), false));
        }
        // Others are compiled meanwhile; of the same text, the first that is done counts.
        let kernel = compile(device, name, &text)?;
        Ok((self.compiled().entry(text).or_insert(kernel).clone(), true))
    }

    fn compiled(&self) -> MutexGuard<'_, HashMap<String, Kernel>> {
        self.compiled.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of compiled kernels.
    pub fn len(&self) -> usize {
        self.compiled().len()
    }

    /// Whether no kernel has been compiled.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Do what may compile kernels, and count its time if it does.
fn timed<T>(device: &Device, work: impl FnOnce() -> Result<(T, bool), GpuError>) -> Result<T, GpuError> {
    let start = Instant::now();
    let (done, compiles) = work()?;
    if compiles {
        device.count(|traffic| traffic.compile_seconds += start.elapsed().as_secs_f64());
    }
    Ok(done)
}

fn compile(device: &Device, name: &'static str, text: &str) -> Result<Kernel, GpuError> {
    let fault = |message: String| GpuError::Kernel { kernel: name.into(), message };
    let slots = slots(&parse(name, text).map_err(fault)?);
    if slots.iter().enumerate().any(|(k, slot)| slot.binding != k as u32) {
        return Err(fault("its bindings are not numbered from 0".into()));
    }
    let pipeline = device.create(
        || {
            let source = wgpu::ShaderSource::Wgsl(text.into());
            let module = device.raw.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source });
            device.raw.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&layout(device, name, &slots)),
                module: &module,
                entry_point: Some("main"),
                compilation_options: Default::default(),
                cache: None,
            })
        },
        |error| fault(error.to_string()),
    )?;
    let kernel = Kernel { name, pipeline, slots: slots.into() };
    if device.adapter.software {
        dispatch_nothing(device, &kernel);
    }
    Ok(kernel)
}

/// Dispatch a kernel with no workgroups. The drivers of software adapters compile a kernel when it is first dispatched, for seconds: the first
/// commands of a step are not to wait for it, and their times are to be theirs alone.
fn dispatch_nothing(device: &Device, kernel: &Kernel) {
    /// Bytes that hold a row of any buffer.
    const ROW: u64 = 4096;
    let rows = |_: &Slot| {
        device.raw.create_buffer(&wgpu::BufferDescriptor {
            label: Some("nothing"),
            size: ROW,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        })
    };
    let rows: Vec<wgpu::Buffer> = kernel.slots.iter().map(rows).collect();
    let entries: Vec<wgpu::BindGroupEntry> = (0..)
        .zip(&rows)
        .map(|(binding, rows)| wgpu::BindGroupEntry { binding, resource: rows.as_entire_binding() })
        .collect();
    let group = device.raw.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(kernel.name),
        layout: &kernel.pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let mut encoder = device.raw.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&kernel.pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(0, 0, 0);
    drop(pass);
    device.submit(encoder.finish());
}

fn layout(device: &Device, name: &str, slots: &[Slot]) -> wgpu::PipelineLayout {
    let entry = |slot: &Slot| wgpu::BindGroupLayoutEntry {
        binding: slot.binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: !slot.is_written },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries: Vec<_> = slots.iter().map(entry).collect();
    let group =
        device.raw.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries });
    let bind_group_layouts = &[Some(&group)];
    device.raw.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts,
        ..Default::default()
    })
}

/// Replace every line `#import NAME` by the part of that name, each once.
///
/// # Errors
/// A part that is not there.
fn resolve(text: &str, parts: &[Part], subgroup: Option<[u32; 2]>) -> Result<String, String> {
    let (mut out, mut seen) = (String::new(), vec![]);
    include(text, parts, subgroup, &mut seen, &mut out)?;
    Ok(out)
}

fn include<'a>(
    text: &'a str,
    parts: &[Part<'a>],
    subgroup: Option<[u32; 2]>,
    seen: &mut Vec<&'a str>,
    out: &mut String,
) -> Result<(), String> {
    let own: &[Part] = if subgroup.is_some() { SUBGROUP_PARTS } else { &[] };
    for line in text.lines() {
        let Some(name) = line.strip_prefix("#import ").map(str::trim) else {
            // The size that the file stands for where it is compiled alone.
            match (line.starts_with("const SUBGROUP_MIN: u32 ="), subgroup) {
                (true, Some([least, _])) => *out += &format!("const SUBGROUP_MIN: u32 = {least}u;"),
                _ => *out += line,
            }
            out.push('\n');
            continue;
        };
        if !seen.contains(&name) {
            seen.push(name);
            let mut known = parts.iter().chain(own).chain(PARTS);
            let part = known.find(|(n, _)| *n == name).ok_or(format!("it imports the unknown part `{name}`"))?;
            include(part.1, parts, subgroup, seen, out)?;
        }
    }
    Ok(())
}
