//! Errors of graphics devices.

/// An error of a graphics device.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GpuError {
    /// There is no Vulkan adapter, or none but software ones where these are not allowed.
    #[error(
        "no {}Vulkan adapter was found: install the Vulkan driver of the GPU{}",
        if *.software { "" } else { "hardware " },
        if *.software { ", or a software one (Debian: apt-get install mesa-vulkan-drivers)" } else { "; a software adapter has to be chosen, by its index or name" }
    )]
    NoAdapter {
        /// Whether a software adapter would have done.
        software: bool,
    },
    /// No adapter, or more than one, is what was asked for.
    #[error("{fault} `{wanted}`; the adapters of this machine are: {known}")]
    Choice {
        /// What was asked for.
        wanted: String,
        /// What is wrong with it.
        fault: &'static str,
        /// Indices and names of the adapters.
        known: String,
    },
    /// The device could not be opened.
    #[error("the adapter `{adapter}` does not open: {message}")]
    Open {
        /// Name of the adapter.
        adapter: String,
        /// The driver's message.
        message: String,
    },
    /// The device was lost: the driver has reset it, or it was removed.
    #[error("the graphics device was lost: {0}")]
    Lost(String),
    /// A kernel is not valid WGSL, or the driver refuses it.
    #[error("kernel `{kernel}` does not compile: {message}")]
    Kernel {
        /// Name of the kernel.
        kernel: String,
        /// Place and fault.
        message: String,
    },
    /// A buffer is larger than the adapter allows.
    #[error("buffer `{buffer}` would have {bytes} bytes, and this adapter allows {limit}")]
    TooLarge {
        /// Name of the buffer.
        buffer: String,
        /// Its size.
        bytes: u64,
        /// The adapter's limit.
        limit: u64,
    },
    /// A buffer does not fit into the memory that buffers may take.
    #[error(
        "buffer `{buffer}` of {bytes} bytes does not fit with the others into the {limit} bytes that they may take"
    )]
    Limit {
        /// The buffer.
        buffer: String,
        /// Its size, bytes.
        bytes: u64,
        /// What all may take, bytes.
        limit: u64,
    },
    /// The device's memory has run out.
    #[error("the device has no memory for buffer `{buffer}` of {bytes} bytes")]
    Memory {
        /// Name of the buffer.
        buffer: String,
        /// Its size.
        bytes: u64,
    },
    /// Commands or a transfer failed; the message is wgpu's.
    #[error("graphics device: {0}")]
    Device(String),
}
