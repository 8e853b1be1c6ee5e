//! The device: an adapter opened without a window, typed buffers on it, and dispatch.

use bytemuck::Pod;
use wgpu::util::DeviceExt;

/// An error of a graphics device.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No suitable Vulkan adapter was found.
    #[error("no Vulkan adapter was found")]
    NoAdapter,
    /// The device could not be opened, or a transfer failed; the message is wgpu's.
    #[error("graphics device: {0}")]
    Device(String),
}

/// A Vulkan adapter (a GPU or a software rasteriser), as `scree doctor` lists it.
#[derive(Clone, Debug)]
pub struct Adapter {
    /// Name of the adapter.
    pub name: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Whether the adapter is a software rasteriser; [`Device::open`] takes one only where the caller allows it.
    pub software: bool,
}

fn instance() -> wgpu::Instance {
    let mut desc = wgpu::InstanceDescriptor::new_without_display_handle();
    desc.backends = wgpu::Backends::VULKAN;
    wgpu::Instance::new(desc)
}

fn describe(adapter: &wgpu::Adapter) -> Adapter {
    let info = adapter.get_info();
    Adapter {
        name: info.name,
        driver: format!("{} {}", info.driver, info.driver_info),
        software: info.device_type == wgpu::DeviceType::Cpu,
    }
}

/// All Vulkan adapters of this machine, hardware before software.
pub fn adapters() -> Vec<Adapter> {
    let found = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::VULKAN));
    let mut list: Vec<Adapter> = found.iter().map(describe).collect();
    list.sort_by_key(|a| a.software);
    list
}

/// An open graphics device and its queue.
pub struct Device {
    /// The adapter that the device belongs to.
    pub adapter: Adapter,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
}

impl Device {
    /// Open the first hardware adapter, or else, if `allow_software`, a software one, with the adapter's own limits. Errors:
    /// [`GpuError::NoAdapter`], or [`GpuError::Device`] if the adapter does not open.
    pub fn open(allow_software: bool) -> Result<Device, GpuError> {
        let mut found = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::VULKAN));
        found.sort_by_key(|a| describe(a).software);
        let adapter = found.into_iter().find(|a| allow_software || !describe(a).software).ok_or(GpuError::NoAdapter)?;
        let desc =
            wgpu::DeviceDescriptor { label: Some("scree"), required_limits: adapter.limits(), ..Default::default() };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&desc)).map_err(|e| GpuError::Device(e.to_string()))?;
        Ok(Device { adapter: describe(&adapter), device, queue })
    }

    /// A new storage buffer that holds `data`.
    pub fn upload<T: Pod>(&self, data: &[T]) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::cast_slice(data),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
        })
    }

    /// A new storage buffer of `n` zeros of type `T`, at least one.
    pub fn zeros<T: Pod>(&self, n: usize) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: (n.max(1) * size_of::<T>()) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// Read the first `n` values of a buffer; blocks until all submitted work is done. An error if the transfer fails.
    pub fn download<T: Pod>(&self, buffer: &wgpu::Buffer, n: usize) -> Result<Vec<T>, GpuError> {
        let size = (n * size_of::<T>()) as u64;
        if size == 0 {
            return Ok(Vec::new());
        }
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, size);
        self.queue.submit([encoder.finish()]);
        let (send, receive) = std::sync::mpsc::channel();
        staging.slice(..).map_async(wgpu::MapMode::Read, move |r| {
            let _ = send.send(r);
        });
        let fault = |e: &dyn std::fmt::Display| GpuError::Device(e.to_string());
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| fault(&e))?;
        receive.recv().map_err(|e| fault(&e))?.map_err(|e| fault(&e))?;
        let view = staging.slice(..).get_mapped_range().map_err(|e| fault(&e))?;
        Ok(bytemuck::pod_collect_to_vec(&view))
    }
}
