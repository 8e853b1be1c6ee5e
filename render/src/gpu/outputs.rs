//! What displays take besides colours: of points, of samples and, filtered, of pixels.

use crate::cpu::frame::Frame;
use crate::film::display::placed;
use crate::gpu::kernels::{OutputKernels, groups, staged};
use crate::gpu::samples::Samples;
use gpu::{Buffer, Device, GpuError, Kernels};
use sl::ir::Kind;

/// What kernels make of a number: 1 to 3 are those of a colour, and so many more of one that counts by the opacity.
const OTHER: u32 = 0;
const DEPTH: u32 = 4;
const ID: u32 = 5;
const WEIGHTED: u32 = 8;

/// The numbers that displays take besides colours, `n` of each point, sample and pixel.
pub struct Outputs {
    pub(super) kernels: OutputKernels,
    pub(super) n: usize,
    pub(super) kinds: Buffer<u32>,
    pub(super) of_points: Buffer<f32>,
    pub(super) of_samples: Buffer<f32>,
    /// What the layers of samples have come to.
    pub(super) sums: Buffer<f32>,
}

impl Outputs {
    /// Room for those of so many samples; none if displays take nothing but colours.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`] and [`Kernels::get`].
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        frame: &Frame<'_>,
        n_samples: usize,
    ) -> Result<Option<Outputs>, GpuError> {
        if frame.aovs.is_empty() {
            return Ok(None);
        }
        let kinds: Vec<u32> = placed(&frame.aovs)
            .flat_map(|(_, aov)| {
                let kind = move |c: usize| match (aov.kind, aov.name.as_str()) {
                    (Kind::Color, _) => c as u32 + 1 + if aov.is_weighted() { WEIGHTED } else { 0 },
                    (_, "z") => DEPTH,
                    (_, "id") => ID,
                    _ => OTHER,
                };
                (0..aov.width()).map(kind)
            })
            .collect();
        Ok(Some(Outputs {
            kernels: OutputKernels::new(device, kernels)?,
            n: frame.depth,
            kinds: Buffer::of(device, "kinds of outputs", &kinds)?,
            of_points: Buffer::zeros(device, "outputs of points", 1)?,
            of_samples: Buffer::zeros(device, "outputs of samples", n_samples * frame.depth)?,
            sums: Buffer::zeros(device, "outputs of layers", 1)?,
        }))
    }

    /// Begin a window: nothing is there.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn start(&self, device: &Device) -> Result<(), GpuError> {
        let mut commands = staged("filter");
        commands.clear(&self.of_samples);
        commands.send(device)?;
        Ok(())
    }

    /// Make room for those of points, all 0, for shading to fill.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`].
    pub fn reserve(&mut self, device: &Device, n_points: usize) -> Result<(), GpuError> {
        self.of_points.reserve(device, n_points * self.n)?;
        let mut commands = staged("shade");
        commands.clear(&self.of_points);
        commands.send(device)?;
        Ok(())
    }

    /// Give those of points to the samples that see them and have no colours yet.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn set(&self, samples: &Samples<'_>) -> Result<(), GpuError> {
        let (mut bound, mut params) = samples.seen_at_length([0, 0]);
        bound.extend([samples.visible.bind(), self.of_points.bind(), self.of_samples.bind()]);
        params.push(self.n as u32);
        let kernel = if samples.is_blurred() { &self.kernels.blur_outputs } else { &self.kernels.sample_outputs };
        let mut commands = staged("shade");
        commands.dispatch(samples.device, kernel, &bound, &params, groups(samples.n()[0], 64));
        commands.send(samples.device)?;
        Ok(())
    }

    /// Those of the pixels of a window but for its margins, pixel by pixel.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`] and [`Buffer::read`].
    pub fn pixels(&self, samples: &Samples<'_>, frame: &Frame<'_>) -> Result<Vec<f32>, GpuError> {
        let (table, mut params, n_pixels) = samples.filter(frame)?;
        params.push(self.n as u32);
        let n = n_pixels * self.n;
        let pixels = Buffer::zeros(samples.device, "outputs of pixels", n)?;
        let Samples { color, offsets, depth, .. } = samples;
        let bound = [
            color.bind(),
            offsets.bind(),
            table.bind(),
            depth.bind(),
            self.kinds.bind(),
            self.of_samples.bind(),
            pixels.bind(),
        ];
        let mut commands = staged("filter");
        commands.dispatch(samples.device, &self.kernels.filter_outputs, &bound, &params, groups(n, 64));
        commands.send(samples.device)?;
        pixels.read(samples.device, n)
    }
}
