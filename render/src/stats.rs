//! Render statistics: counts of every stage, and its time.

/// Render statistics: counts over all buckets of an image (or of its shard), and times.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct Stats {
    /// Count of primitives in the scene.
    pub items: u64,
    /// Count of pieces of patches that were split rather than diced.
    pub splits: u64,
    /// Count of grids diced.
    pub grids: u64,
    /// Count of grids culled after dicing: hidden, or outside the bucket.
    pub grids_hidden: u64,
    /// Count of points shaded.
    pub shaded_points: u64,
    /// Count of micropolygons sampled.
    pub micropolygons: u64,
    /// Count of tests of a sample against a micropolygon; 0 of an image of a graphics device, which does not count them.
    pub samples: u64,
    /// Count of rays of `occlusion`; 0 of an image of a graphics device.
    pub occlusion_rays: u64,
    /// Count of runs of surface shaders for the opacity of what a ray meets.
    pub opacity_runs: u64,
    /// Time by stage.
    pub seconds: Seconds,
    /// What a graphics device has done of it; none of an image of the processor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device: Option<DeviceStats>,
}

/// What has gone between the processor and a graphics device for an image, where the processor waited, and how long the device worked.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct DeviceStats {
    /// Count of waves of micropolygons: each is sampled before what it hides would be diced.
    pub waves: u64,
    /// Count of dispatches of kernels.
    pub dispatches: u64,
    /// Count of submissions of commands.
    pub submissions: u64,
    /// Count of waits of the processor for the device.
    pub waits: u64,
    /// Bytes that were written to the device.
    pub bytes_written: u64,
    /// Bytes that were read from it.
    pub bytes_read: u64,
    /// The most bytes that buffers have taken of its memory together so far: those of this image, of others in flight, and those kept.
    pub device_bytes: u64,
    /// Bytes of the largest buffer so far.
    pub largest_buffer_bytes: u64,
    /// Time that the processor waited, s.
    pub wait_seconds: f64,
    /// Time in which kernels were compiled, s: none of a frame whose shaders an earlier one had.
    pub compile_seconds: f64,
    /// Time in which the processor made buffers, s.
    pub buffer_seconds: f64,
    /// Time in which it wrote to them, s.
    pub write_seconds: f64,
    /// Time in which it took what had been read from them, s.
    pub read_seconds: f64,
    /// Time in which it submitted commands, s.
    pub submit_seconds: f64,
    /// Time of the device by stage, s, by its own clock; none where it has no clock.
    pub seconds: Option<DeviceSeconds>,
}

impl DeviceStats {
    /// The same, with what a device has been given since its traffic and its dispatches were these.
    pub(crate) fn since(self, (traffic, dispatches): &(gpu::Traffic, u64), device: &gpu::Device) -> DeviceStats {
        let traffic = device.traffic() - *traffic;
        DeviceStats {
            dispatches: device.dispatches().values().sum::<u64>() - dispatches,
            device_bytes: device.most_memory(),
            largest_buffer_bytes: device.largest_buffer(),
            submissions: traffic.submissions,
            waits: traffic.waits,
            bytes_written: traffic.bytes_written,
            bytes_read: traffic.bytes_read,
            wait_seconds: traffic.wait_seconds,
            compile_seconds: traffic.compile_seconds,
            buffer_seconds: traffic.buffer_seconds,
            write_seconds: traffic.write_seconds,
            read_seconds: traffic.read_seconds,
            submit_seconds: traffic.submit_seconds,
            ..self
        }
    }
}

/// Time of a graphics device by stage, s.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct DeviceSeconds {
    /// Dicing, as far as the device does that.
    pub dice: f64,
    /// Sampling micropolygons.
    pub sample: f64,
    /// Finding the points that are visible, shading them, and giving samples their colours.
    pub shade: f64,
    /// Filtering.
    pub filter: f64,
}

/// Time by stage, s: summed over threads, or wall-clock time where a field says so. Of an image of a graphics device, all but `dice` is
/// wall-clock time of the processor, waits for the device included; [`DeviceStats`] has how long the device worked.
#[derive(Clone, Copy, Debug, Default, serde::Serialize)]
pub struct Seconds {
    /// Building the bounding volume hierarchy for rays; wall-clock time, since several threads share it.
    pub hierarchy: f64,
    /// Bounding primitives and sorting them to buckets; wall-clock time.
    pub bound: f64,
    /// Splitting, dicing and displacing.
    pub dice: f64,
    /// Sampling micropolygons.
    pub sample: f64,
    /// Shading, including the rays that shaders trace.
    pub shade: f64,
    /// Compositing, filtering and the imager shader.
    pub filter: f64,
}

impl Stats {
    /// The sums over two sets of buckets; `items`, what rays asked, and the seconds of the clock, are of the first.
    pub(crate) fn add(mut self, o: Stats) -> Stats {
        self.splits += o.splits;
        self.grids += o.grids;
        self.grids_hidden += o.grids_hidden;
        self.shaded_points += o.shaded_points;
        self.micropolygons += o.micropolygons;
        self.samples += o.samples;
        self.seconds.dice += o.seconds.dice;
        self.seconds.sample += o.seconds.sample;
        self.seconds.shade += o.seconds.shade;
        self.seconds.filter += o.seconds.filter;
        self
    }
}
