//! Buffers that are mapped for the processor to read.

use crate::error::GpuError;
use bytemuck::Pod;
use std::sync::mpsc::{Receiver, channel};

/// Tells when a buffer is mapped, or why it is not.
pub(crate) type Mapped = Receiver<Result<(), String>>;

/// Map a buffer for reading, once the work that has been submitted is done. The receiver is told so.
pub(crate) fn map(buffer: &wgpu::Buffer) -> Mapped {
    let (send, mapped) = channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The reader may have gone.
        let _ = send.send(result.map_err(|e| e.to_string()));
    });
    mapped
}

/// The first `n` rows of a mapped buffer.
pub(crate) fn mapped_rows<T: Pod>(buffer: &wgpu::Buffer, n: usize) -> Result<Vec<T>, GpuError> {
    let view = buffer.get_mapped_range(..).map_err(|e| GpuError::Device(e.to_string()))?;
    Ok(bytemuck::pod_collect_to_vec(&view[..n * size_of::<T>()]))
}
