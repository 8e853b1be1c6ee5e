//! A kernel: WGSL text with `#import NAME` lines resolved, compiled, and ready to dispatch.

use crate::Device;

/// Parts that kernels import.
const PARTS: &[(&str, &str)] = &[("block", include_str!("kernels/block.wgsl"))];

/// The most workgroups in one dimension of a dispatch; longer ones go on in the second.
const MAX_GROUPS: u32 = 65_535;

/// A compiled WGSL compute kernel: entry point `main`, buffers in bind group 0.
pub struct Kernel {
    pipeline: wgpu::ComputePipeline,
}

impl Kernel {
    /// Compile the WGSL text `source`, after `#import NAME` lines are replaced by the shared parts of that name; `name` labels the
    /// kernel in validation messages. Panics if the text is not valid.
    pub fn new(device: &Device, name: &str, source: &str) -> Kernel {
        let module = device.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(resolve_imports(source).into()),
        });
        let pipeline = device.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        Kernel { pipeline }
    }

    /// Submit `n_groups` workgroups over `buffers`, bound in order from binding 0. Beyond 65 535 workgroups the dispatch extends in
    /// y, so that a kernel computes its index from both dimensions and ignores workgroups past its end.
    pub fn dispatch(&self, device: &Device, buffers: &[&wgpu::Buffer], n_groups: u32) {
        let entries: Vec<wgpu::BindGroupEntry> = buffers
            .iter()
            .enumerate()
            .map(|(i, b)| wgpu::BindGroupEntry { binding: i as u32, resource: b.as_entire_binding() })
            .collect();
        let group = device.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = device.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(n_groups.min(MAX_GROUPS), n_groups.div_ceil(MAX_GROUPS), 1);
        drop(pass);
        device.queue.submit([encoder.finish()]);
    }
}

/// Replace every line `#import NAME` by the part of that name.
fn resolve_imports(source: &str) -> String {
    let mut out = String::new();
    for line in source.lines() {
        match line.strip_prefix("#import ") {
            Some(name) => {
                let part = PARTS.iter().find(|(n, _)| *n == name.trim());
                out.push_str(part.unwrap_or_else(|| panic!("kernel imports unknown part `{name}`")).1);
            }
            None => out.push_str(line),
        }
        out.push('\n');
    }
    out
}
