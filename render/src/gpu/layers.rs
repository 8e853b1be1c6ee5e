//! Layers of samples on the device: what may be translucent, or is clipped, cut away in part by levels of detail, or fades.
//!
//! The layers of a sample are a list. They are counted, the counts are scanned, the lists filled and each sorted; the points that they need are
//! shaded, and each sample composites its list over what is opaque there. Lists that do not fit at once are made in turn, those of some
//! samples after those of others: nothing is left out.

use crate::cpu::frame::Frame;
use crate::gpu::front::Diced;
use crate::gpu::kernels::{LayerKernels, groups, staged};
use crate::gpu::outputs::Outputs;
use crate::gpu::samples::Samples;
use crate::scene::source::Item;
use gpu::scan::Scan;
use gpu::{Bound, Buffer, Commands, Count, Device, GpuError, Kernels};

/// Some samples of a window, and how many layers they have.
#[derive(Clone, Copy)]
pub struct Range {
    pub first: usize,
    pub end: usize,
    n_layers: usize,
}

/// The layers of the samples of a window.
pub struct Layers<'a> {
    device: &'a Device,
    kernels: LayerKernels,
    scan: Scan,
    /// Of the samples of a range: where the lists end.
    ends: Buffer<u32>,
    total: Buffer<u32>,
    lists: Buffer<[u32; 2]>,
    /// Rows of the grids that wait: `layered.wgsl` has what they are.
    grids: Buffer<[u32; 4]>,
    n_rows: usize,
    planes: Buffer<[f32; 4]>,
    /// What kernels are told besides the range: the step of samples in their order, count of clipping planes.
    own: [u32; 2],
    opacities: Buffer<[f32; 4]>,
    /// The most layers whose lists are there at once, as far as one sample has no more.
    most: usize,
}

impl<'a> Layers<'a> {
    /// Room for lists of up to so many samples, with about so many layers at most at a time.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`] and [`Kernels::get`].
    pub fn new(
        device: &'a Device,
        kernels: &Kernels,
        frame: &Frame<'_>,
        n_samples: usize,
        most: usize,
    ) -> Result<Layers<'a>, GpuError> {
        let planes: Vec<[f32; 4]> =
            frame.planes.iter().flat_map(|plane| plane.rows().map(|[x, y, z]| [x, y, z, 0.0])).collect();
        let [nx, ny] = frame.jitter.strata;
        Ok(Layers {
            device,
            kernels: LayerKernels::new(device, kernels)?,
            scan: Scan::new(device, kernels, n_samples + 1)?,
            ends: Buffer::zeros(device, "layer lists", n_samples + 1)?,
            total: Buffer::zeros(device, "count of layers", 1)?,
            lists: Buffer::zeros(device, "layers", 1)?,
            grids: Buffer::zeros(device, "grids of layers", 1)?,
            n_rows: 0,
            planes: Buffer::of(device, "clipping planes", &planes)?,
            own: [crate::cpu::samples::step(nx * ny) as u32, frame.planes.len() as u32],
            opacities: Buffer::zeros(device, "point opacities", 1)?,
            most,
        })
    }

    /// Nothing waits any more.
    pub fn forget(&mut self) {
        self.n_rows = 0;
    }

    /// Add grids to those that wait.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`].
    pub fn add(&mut self, frame: &Frame<'_>, samples: &mut Samples<'_>, grids: &[Diced]) -> Result<(), GpuError> {
        let (mut rows, mut firsts, mut point) = (vec![], vec![], samples.n_points);
        for grid in grids {
            firsts.push((self.n_rows + rows.len()) as u32);
            let seen = frame.scene.attributes(grid.item).seen.map(f32::to_bits);
            let whole = frame.scene.shared_whole_of(grid.item).map_or(0, |whole| whole.wrapping_add(1));
            let rims = (0..4).map(|k| u32::from(grid.rims[k]) << k).sum();
            rows.push([name_of(frame, grid.item), grid.n() as u32, grid.fades.len() as u32, whole]);
            rows.push([seen[0], seen[1], point as u32, rims]);
            point += grid.n_shaded();
            let time = |some: &[f32], k: usize| some.get(k).map_or(0, |time| time.to_bits());
            rows.extend(grid.fades.chunks(4).map(|some| [0, 1, 2, 3].map(|k| time(some, k))));
        }
        self.grids.reserve(self.device, self.n_rows + rows.len())?;
        self.grids.write_from(self.device, self.n_rows, &rows);
        self.n_rows += rows.len();
        let mut commands = Commands::new();
        samples.upload(frame, grids, &firsts, false, &mut commands)?;
        commands.send(self.device)
    }

    /// Find the layers of the samples from one to before another, as ranges whose lists fit; and which points they need, a bit each, on the device and here.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`] and [`Device::check`].
    pub fn find(
        &mut self,
        samples: &Samples<'_>,
        [first, end]: [usize; 2],
    ) -> Result<(Vec<Range>, Buffer<u32>, Vec<u32>), GpuError> {
        let n_layers = self.count(samples, [first, end])?;
        let mut ranges = vec![Range { first, end, n_layers }];
        if n_layers > self.most {
            ranges = fitting(first, &self.ends.read(self.device, end - first + 1)?, self.most);
        }
        ranges.retain(|range| range.n_layers > 0);
        let n_words = samples.n_points.div_ceil(32);
        let wanted = Buffer::<u32>::zeros(self.device, "points of layers", n_words)?;
        let alone = ranges.len() == 1;
        for range in &ranges {
            self.fill(samples, *range, alone && n_layers <= self.most)?;
            let mut commands = staged("sample");
            let bound = [self.lists.bind(), samples.micropolygons.bind(), wanted.bind()];
            let n = range.n_layers;
            commands.dispatch(self.device, &self.kernels.layer_points, &bound, &[n as u32], groups(n, 256));
            commands.send(self.device)?;
        }
        let bits = wanted.read(self.device, n_words)?;
        Ok((ranges, wanted, bits))
    }

    /// What kernels over micropolygons bind and are told, of the samples from one to before another.
    fn told<'s>(&self, samples: &'s Samples<'_>, [first, end]: [usize; 2]) -> (Vec<Bound<'s>>, Vec<u32>) {
        let (bound, mut params) = samples.seen_at_length([0, samples.n_micropolygons]);
        params.extend([first as u32, end as u32, self.own[0], self.own[1]]);
        (bound, params)
    }

    /// Count the layers of samples: the sums of the counts stand in `ends` then.
    fn count(&self, samples: &Samples<'_>, range: [usize; 2]) -> Result<usize, GpuError> {
        let Layers { device, kernels, ends, total, grids, planes, .. } = self;
        let kernel = if samples.is_blurred() { &kernels.blur_layer_count } else { &kernels.layer_count };
        let n = range[1] - range[0];
        let (mut bound, params) = self.told(samples, range);
        bound.extend([samples.depth.bind(), grids.bind(), planes.bind(), ends.bind()]);
        let mut commands = staged("sample");
        commands.clear(ends);
        commands.dispatch(device, kernel, &bound, &params, groups(samples.n_micropolygons, 64));
        self.scan.record(device, &mut commands, ends, &Count::of(device, n + 1)?);
        commands.dispatch(device, &kernels.layer_total, &[ends.bind(), total.bind()], &[n as u32], groups(1, 1));
        commands.send(device)?;
        Ok(total.read(device, 1)?[0] as usize)
    }

    /// Fill and sort the lists of a range, whose counts are there or are counted first.
    fn fill(&mut self, samples: &Samples<'_>, range: Range, is_counted: bool) -> Result<(), GpuError> {
        let Range { first, end, n_layers } = range;
        if !is_counted {
            self.count(samples, [first, end])?;
        }
        self.lists.reserve(self.device, n_layers)?;
        let Layers { device, kernels, ends, lists, grids, planes, .. } = &*self;
        let kernel = if samples.is_blurred() { &kernels.blur_layer_fill } else { &kernels.layer_fill };
        let (mut bound, params) = self.told(samples, [first, end]);
        bound.extend([samples.depth.bind(), grids.bind(), planes.bind(), ends.bind(), lists.bind()]);
        let n = end - first;
        let mut commands = staged("sample");
        commands.dispatch(device, kernel, &bound, &params, groups(samples.n_micropolygons, 64));
        let bound = [ends.bind(), lists.bind()];
        commands.dispatch(device, &kernels.layer_sort, &bound, &[n as u32], groups(n, 64));
        commands.send(device)?;
        Ok(())
    }

    /// The opacities of the points that wait, 0 so far, for shading to fill.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`].
    pub fn opacities(&mut self, n_points: usize) -> Result<&Buffer<[f32; 4]>, GpuError> {
        self.opacities.reserve(self.device, n_points)?;
        let mut commands = staged("shade");
        commands.clear(&self.opacities);
        commands.send(self.device)?;
        Ok(&self.opacities)
    }

    /// Composite the layers of ranges over what is opaque: nothing waits any more.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`] and [`Device::check`].
    pub fn compose(
        &mut self,
        samples: &mut Samples<'_>,
        ranges: &[Range],
        mut outputs: Option<&mut Outputs>,
    ) -> Result<(), GpuError> {
        for range in ranges {
            if ranges.len() > 1 {
                self.fill(samples, *range, false)?;
            }
            self.compose_range(samples, *range, outputs.as_deref_mut())?;
        }
        samples.forget();
        self.forget();
        Ok(())
    }

    fn compose_range(
        &self,
        samples: &Samples<'_>,
        Range { first, end, .. }: Range,
        outputs: Option<&mut Outputs>,
    ) -> Result<(), GpuError> {
        let Layers { device, kernels, ends, lists, grids, opacities, .. } = self;
        let n = end - first;
        let mut commands = staged("shade");
        let kernel = if samples.is_blurred() { &kernels.blur_layer_join } else { &kernels.layer_join };
        let (mut bound, params) = self.told(samples, [first, end]);
        bound.extend([grids.bind(), ends.bind(), lists.bind()]);
        commands.dispatch(device, kernel, &bound, &params, groups(n, 64));
        let kernel = match (samples.is_blurred(), outputs.is_some()) {
            (false, false) => &kernels.layer_colors,
            (false, true) => &kernels.layer_colors_outputs,
            (true, false) => &kernels.blur_layer_colors,
            (true, true) => &kernels.blur_layer_colors_outputs,
        };
        let (mut bound, mut params) = self.told(samples, [first, end]);
        bound.extend([samples.colors.bind(), opacities.bind(), grids.bind(), ends.bind(), lists.bind()]);
        bound.extend([samples.depth.bind(), samples.color.bind(), samples.visible.bind()]);
        if let Some(outputs) = outputs {
            outputs.sums.reserve(device, n * outputs.n)?;
            let Outputs { n, kinds, of_points, sums, of_samples, .. } = outputs;
            bound.extend([kinds.bind(), of_points.bind(), sums.bind(), of_samples.bind()]);
            params.push(*n as u32);
        }
        commands.dispatch(device, kernel, &bound, &params, groups(n, 64));
        commands.send(device)?;
        Ok(())
    }
}

/// The name of the primitive that an item is, or is of: layers of it that are very near to each other are one.
fn name_of(frame: &Frame<'_>, item: Item) -> u32 {
    frame.scene.id_of(item) as u32
}

/// Ranges of samples from the first on whose lists fit into so many layers, as far as one has no more; `sums` are those of the layers
/// before each.
fn fitting(first: usize, sums: &[u32], most: usize) -> Vec<Range> {
    let (mut ranges, mut start) = (vec![], 0);
    while start + 1 < sums.len() {
        let fits = sums[start + 1..].partition_point(|sum| (sum - sums[start]) as usize <= most);
        let end = start + fits.max(1);
        let n_layers = (sums[end] - sums[start]) as usize;
        ranges.push(Range { first: first + start, end: first + end, n_layers });
        start = end;
    }
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_fit_and_leave_no_sample_out() {
        let of = |most: usize| -> Vec<[usize; 3]> {
            let ranges = fitting(10, &[0, 2, 3, 3, 9, 10], most);
            ranges.iter().map(|r| [r.first, r.end, r.n_layers]).collect()
        };
        assert_eq!(of(10), [[10, 15, 10]]);
        assert_eq!(of(3), [[10, 13, 3], [13, 14, 6], [14, 15, 1]]);
        assert_eq!(of(0), [[10, 11, 2], [11, 12, 1], [12, 13, 0], [13, 14, 6], [14, 15, 1]]);
    }
}
