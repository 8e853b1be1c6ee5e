//! The samples of a part of the image, on the device: what is nearest at each, and its colour.
//!
//! What is nearest at a sample is the least depth, and the first of those micropolygons that have it, so that every device finds what the processor
//! finds: in one pass by atomics of 64 bits, else in two. All is sampled before the points that are visible are shaded, and then the samples get their colours.

use crate::cpu::frame::Frame;
use crate::cpu::samples::BLOCK;
use crate::film::jitter::{Jitter, Moments, PERIOD};
use crate::gpu::caps::{Caps, DiceGoal, Placed};
use crate::gpu::front::{Diced, Window};
use crate::gpu::kept::Kept;
use crate::gpu::kernels::{FrameKernels, Sampling, groups, staged};
use gpu::{Bound, Buffer, Commands, Device, GpuError};

/// What micropolygons are: colour is interpolated; nothing but a hole.
const SMOOTH: u32 = 1;
const MATTE: u32 = 2;
/// Of triangles of positive area alone, or of negative, if one side is seen.
const POSITIVE: u32 = 4;
const NEGATIVE: u32 = 8;
/// Bits before the row.
const FLAG_BITS: u32 = 4;

/// What samples of an image of motion or a lens have besides their places.
struct Blur {
    /// Of each pixel of the pattern and stratum of time: time, place on the lens, number of the sample; then the same by these numbers.
    moments: Buffer<[f32; 4]>,
    /// Bounds of each stratum: of time, and of the place on the lens along x and y.
    strata: Buffer<[f32; 2]>,
    /// How grids move: a row of places, a row of counts, and their keys.
    tracks: Buffer<[u32; 4]>,
    n: usize,
    /// Whether there is a lens; its reach, one over the depth that is sharp, and the least depth, as bits.
    lens: [u32; 4],
}

/// What is nearest at samples while micropolygons are sampled.
enum Nearest {
    /// The key of its depth above 1 more than its id.
    Wide(Buffer<u64>),
    /// The keys of depths before the micropolygons at hand.
    Before(Buffer<u32>),
}

/// The samples of a part of the image.
pub struct Samples<'a> {
    pub(super) device: &'a Device,
    kernels: &'a FrameKernels,
    strata: [usize; 2],
    n: usize,
    /// What kernels are told of the part.
    pub(super) head: [u32; 7],
    pub(super) offsets: Buffer<[f32; 2]>,
    pub(super) depth: Buffer<u32>,
    nearest: Nearest,
    pub(super) visible: Buffer<u32>,
    pub(super) color: Buffer<[f32; 4]>,
    blocks: Buffer<u32>,
    /// Micropolygons that wait for their colours, and their points, at all moments if the image is blurred.
    points: Buffer<[f32; 4]>,
    pub(super) micropolygons: Buffer<[u32; 4]>,
    pub(super) n_points: usize,
    n_places: usize,
    pub(super) n_micropolygons: usize,
    /// Tiles of spheres' caps among what waits.
    pub(super) caps: Caps,
    /// What samples of a blurred image have besides.
    blur: Option<Blur>,
    /// Colours of the points.
    pub(super) colors: Buffer<[f32; 4]>,
}

impl<'a> Samples<'a> {
    /// Room for the samples of windows of up to so many pixels.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`].
    pub fn new(
        device: &'a Device,
        (kernels, kept): (&'a FrameKernels, &Kept),
        frame: &Frame<'_>,
        n_pixels: usize,
        n_blocks: usize,
    ) -> Result<Samples<'a>, GpuError> {
        let strata = frame.jitter.strata;
        let n = n_pixels * strata[0] * strata[1];
        Ok(Samples {
            device,
            kernels,
            strata,
            n,
            head: [0; 7],
            offsets: Buffer::of(device, "sample places", &places(&frame.jitter))?,
            depth: kept.take(device, "sample depths", n)?,
            nearest: match kernels.sampling {
                Sampling::Wide(_) => Nearest::Wide(kept.take(device, "nearest at samples", n)?),
                Sampling::Twice(_) => Nearest::Before(kept.take(device, "earlier sample depths", n)?),
            },
            visible: kept.take(device, "visible micropolygons", n)?,
            color: kept.take(device, "sample colours", n)?,
            blocks: kept.take(device, "block depths", n_blocks)?,
            points: kept.take(device, "raster points", 1)?,
            micropolygons: kept.take(device, "micropolygons", 1)?,
            n_points: 0,
            n_places: 0,
            n_micropolygons: 0,
            caps: Caps::new(device, kept, frame)?,
            blur: frame.jitter.moments.as_ref().map(|moments| Blur::new(device, frame, moments)).transpose()?,
            colors: kept.take(device, "point colours", 1)?,
        })
    }

    /// Keep the buffers for another frame.
    pub fn keep(self, kept: &Kept) {
        kept.give("sample depths", self.depth);
        match self.nearest {
            Nearest::Wide(nearest) => kept.give("nearest at samples", nearest),
            Nearest::Before(before) => kept.give("earlier sample depths", before),
        }
        kept.give("visible micropolygons", self.visible);
        kept.give("sample colours", self.color);
        kept.give("block depths", self.blocks);
        kept.give("raster points", self.points);
        kept.give("micropolygons", self.micropolygons);
        kept.give("point colours", self.colors);
        self.caps.keep(kept);
    }

    /// Begin a window: nothing is there.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn start(&mut self, window: &Window) -> Result<(), GpuError> {
        let ([x, y], [width, height]) = (window.corner.map(|x| x as i32 as u32), window.size.map(|n| n as u32));
        self.head = [x, y, width, height, self.strata[0] as u32, self.strata[1] as u32, 0];
        self.n = window.size[0] * window.size[1] * self.strata[0] * self.strata[1];
        self.forget();
        let mut commands = staged("sample");
        let bound = [self.depth.bind(), self.visible.bind(), self.color.bind()];
        let work = groups(self.n, 256);
        commands.dispatch(self.device, &self.kernels.clear_samples, &bound, &[self.n as u32], work);
        if let (Nearest::Wide(nearest), Sampling::Wide(kernels)) = (&self.nearest, &self.kernels.sampling) {
            commands.dispatch(self.device, &kernels.clear_nearest, &[nearest.bind()], &[self.n as u32], work);
        }
        commands.send(self.device)
    }

    /// No micropolygons wait for their colours.
    pub fn forget(&mut self) {
        (self.n_points, self.n_places, self.n_micropolygons) = (0, 0, 0);
        self.caps.forget();
        if let Some(blur) = &mut self.blur {
            blur.n = 0;
        }
    }

    /// The number of places of micropolygons that wait for their colours: points at all moments.
    pub fn n_places(&self) -> usize {
        self.n_places
    }

    /// Make room for a number of points and their micropolygons, which are known to come.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`].
    pub fn expect(&mut self, n_points: usize) -> Result<(), GpuError> {
        self.points.reserve(self.device, n_points)?;
        self.micropolygons.reserve(self.device, n_points)?;
        Ok(())
    }

    /// Sample the micropolygons of grids; the depths of the window's blocks are what they are then.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`] and [`Device::check`].
    pub fn sample(&mut self, frame: &Frame<'_>, grids: &[Diced], window: &mut Window) -> Result<(), GpuError> {
        let first = self.n_micropolygons;
        let mut commands = Commands::new();
        self.upload(frame, grids, &[], !window.blocks.is_empty(), &mut commands)?;
        commands.stage("sample");
        let range = [first, self.n_micropolygons - first];
        let n_blocks = window.size[0].div_ceil(BLOCK) * window.size[1].div_ceil(BLOCK);
        self.record(&mut commands, range, n_blocks);
        let device = self.device;
        commands.send(device)?;
        window.blocks = self.blocks.read(device, n_blocks)?.into_iter().map(depth_of).collect();
        Ok(())
    }

    /// Record that micropolygons of a range, a first one and their count, are sampled, and the depths of blocks found.
    fn record(&self, commands: &mut Commands, range: [usize; 2], n_blocks: usize) {
        let Samples { device, kernels, depth, nearest, visible, .. } = self;
        let (seen, params) = self.seen(range);
        let (work, all) = (groups(range[1], 64), groups(self.n, 256));
        let told = [self.head[2], self.head[3], (self.strata[0] * self.strata[1]) as u32, n_blocks as u32];
        match (&kernels.sampling, nearest) {
            (Sampling::Wide(kernels), Nearest::Wide(nearest)) => {
                let kernel = if self.is_blurred() { &kernels.blur_nearest } else { &kernels.sample_nearest };
                commands.dispatch(device, kernel, &[&seen[..], &[nearest.bind()]].concat(), &params, work);
                let bound = [nearest.bind(), self.blocks.bind()];
                commands.dispatch(device, &kernels.block_nearest, &bound, &told, groups(n_blocks, 64));
            }
            (Sampling::Twice(kernels), Nearest::Before(before)) => {
                let [depth_kernel, id_kernel] = match self.is_blurred() {
                    true => [&kernels.blur_depth, &kernels.blur_id],
                    false => [&kernels.sample_depth, &kernels.sample_id],
                };
                let three = [depth.bind(), before.bind(), visible.bind()];
                commands.copy(depth, before, self.n);
                commands.dispatch(device, depth_kernel, &[&seen, &three[..1]].concat(), &params, work);
                commands.dispatch(device, &kernels.uncover, &three, &[self.n as u32], all);
                commands.dispatch(device, id_kernel, &[&seen[..], &three].concat(), &params, work);
                let bound = [depth.bind(), self.blocks.bind()];
                commands.dispatch(device, &kernels.block_depth, &bound, &told, groups(n_blocks, 64));
            }
            _ => unreachable!("what is nearest is as the kernels have it"),
        }
    }

    /// Let depths and ids of what is nearest stand for themselves, which are together while it is sampled.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn part(&self) -> Result<(), GpuError> {
        let (Nearest::Wide(nearest), Sampling::Wide(kernels)) = (&self.nearest, &self.kernels.sampling) else {
            return Ok(());
        };
        let mut commands = staged("sample");
        let bound = [nearest.bind(), self.depth.bind(), self.visible.bind()];
        commands.dispatch(self.device, &kernels.part_nearest, &bound, &[self.n as u32], groups(self.n, 256));
        commands.send(self.device)
    }

    /// What kernels over micropolygons bind first, and what they are told: the part, and a first micropolygon and their count.
    pub(super) fn seen(&self, range: [usize; 2]) -> (Vec<Bound<'_>>, Vec<u32>) {
        let mut bound = vec![self.points.bind(), self.micropolygons.bind(), self.offsets.bind()];
        let mut params: Vec<u32> = self.head.into_iter().chain(range.map(|n| n as u32)).collect();
        if let Some(blur) = &self.blur {
            bound.extend([blur.moments.bind(), blur.strata.bind(), blur.tracks.bind()]);
            params.extend(blur.lens);
        }
        (bound, params)
    }

    /// Add grids to those that wait for their colours; `rows` has a number of each that its micropolygons have besides, if they have any.
    /// What the device dices is left out if `culls` and it is behind the depths of the window's blocks; that it does so is recorded.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`].
    pub(super) fn upload(
        &mut self,
        frame: &Frame<'_>,
        grids: &[Diced],
        rows: &[u32],
        culls: bool,
        commands: &mut Commands,
    ) -> Result<(), GpuError> {
        let of_host = || grids.iter().filter(|grid| grid.cap.is_none());
        let mut points = Runs::with_capacity(of_host().flat_map(|grid| &grid.raster).map(Vec::len).sum());
        let mut micropolygons = Runs::with_capacity(of_host().map(|grid| grid.micropolygons.len()).sum());
        let (mut tracks, mut caps) = (vec![], vec![]);
        let mut n_points = self.n_points;
        let first_track = self.blur.as_ref().map_or(0, |blur| blur.n);
        for (k, grid) in grids.iter().enumerate() {
            let a = frame.scene.attributes(grid.item);
            let row = rows.get(k).copied().unwrap_or(0) << FLAG_BITS;
            let flags =
                [(a.smooth, SMOOTH), (a.matte, MATTE), (grid.side > 0.0, POSITIVE), (grid.side < 0.0, NEGATIVE)];
            let flags = flags.into_iter().fold(row, |all, (is, flag)| if is { all | flag } else { all });
            let (first, nu, track) = (n_points as u32, grid.size[0] as u32, (first_track + tracks.len()) as u32);
            if self.blur.is_some() {
                let place = (self.n_places + points.n) as u32;
                tracks.extend([[first, place, grid.n() as u32, track + 2], [grid.keys.len() as u32, 0, 0, 0]]);
                tracks.extend(grid.keys.iter().map(|key| key.map(f32::to_bits)));
            }
            if let Some(cap) = &grid.cap {
                let [place, micropolygon] = [self.n_places + points.n, self.n_micropolygons + micropolygons.n];
                caps.push(Placed { size: grid.size, cap, place, micropolygon, point: n_points, flags, track });
                points.skip(cap.n_moments() * grid.n());
                micropolygons.skip(grid.n_micropolygons());
            } else {
                points.extend(grid.raster.iter().flatten().map(|[x, y, z]| [*x, *y, *z, 0.0]));
                micropolygons.extend(grid.micropolygons.iter().map(|k| [first + k, nu, flags, track]));
            }
            n_points += grid.n_shaded();
        }
        self.points.reserve(self.device, self.n_places + points.n)?;
        self.micropolygons.reserve(self.device, self.n_micropolygons + micropolygons.n)?;
        points.write(self.device, &self.points, self.n_places);
        micropolygons.write(self.device, &self.micropolygons, self.n_micropolygons);
        if let Some(blur) = &mut self.blur {
            blur.tracks.reserve(self.device, first_track + tracks.len())?;
            blur.tracks.write_from(self.device, first_track, &tracks);
            blur.n += tracks.len();
        }
        self.n_points = n_points;
        self.n_places += points.n;
        self.n_micropolygons += micropolygons.n;
        let range = self.caps.add(self.device, &caps)?;
        if range[1] > 0 {
            let Samples { head, blocks, points, micropolygons, .. } = &*self;
            let goal = DiceGoal { head: *head, blocks, points, micropolygons };
            self.caps.dice(self.device, &goal, self.kernels, frame, commands, (range, culls));
        }
        Ok(())
    }

    /// The same, and what kernels are told is as long without a lens.
    pub(super) fn seen_at_length(&self, range: [usize; 2]) -> (Vec<Bound<'_>>, Vec<u32>) {
        let (bound, mut params) = self.seen(range);
        params.resize(self.head.len() + 6, 0);
        (bound, params)
    }

    /// Which points of the micropolygons that wait are visible, a bit each, on the device and here.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`] and [`Buffer::read`].
    pub fn visible_points(&self) -> Result<(Buffer<u32>, Vec<u32>), GpuError> {
        let n_words = self.n_points.div_ceil(32);
        let wanted = Buffer::<u32>::zeros(self.device, "visible points", n_words)?;
        let mut commands = staged("shade");
        let bound = [self.visible.bind(), self.micropolygons.bind(), wanted.bind()];
        let work = groups(self.n, 256);
        commands.dispatch(self.device, &self.kernels.visible_points, &bound, &[self.n as u32], work);
        commands.send(self.device)?;
        let bits = wanted.read(self.device, n_words)?;
        Ok((wanted, bits))
    }

    /// Samples of the window, in all and of a pixel.
    pub fn n(&self) -> [usize; 2] {
        [self.n, self.strata[0] * self.strata[1]]
    }

    /// Whether samples have times or places on a lens.
    pub fn is_blurred(&self) -> bool {
        self.blur.is_some()
    }

    /// The ids of what is visible at each sample, pixel after pixel: twice the micropolygon's number, and 1 more for its second triangle; all
    /// bits where nothing waits for its colour.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn visible(&self) -> Result<Vec<u32>, GpuError> {
        self.visible.read(self.device, self.n)
    }

    /// The colours of the points of the micropolygons that wait, black so far, for shading to fill.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`].
    pub fn colors(&mut self) -> Result<&Buffer<[f32; 4]>, GpuError> {
        self.colors.reserve(self.device, self.n_points)?;
        let mut commands = staged("shade");
        commands.clear(&self.colors);
        commands.send(self.device)?;
        Ok(&self.colors)
    }

    /// Give the samples their colours: nothing waits any more.
    ///
    /// # Errors
    /// Those of [`Device::check`].
    pub fn set_colors(&mut self) -> Result<(), GpuError> {
        let (mut bound, params) = self.seen([0, 0]);
        bound.extend([self.colors.bind(), self.visible.bind(), self.color.bind()]);
        let kernel = if self.blur.is_some() { &self.kernels.blur_colors } else { &self.kernels.sample_colors };
        let mut commands = staged("shade");
        commands.dispatch(self.device, kernel, &bound, &params, groups(self.n, 64));
        commands.send(self.device)?;
        self.forget();
        Ok(())
    }

    /// The filtered pixels of the window but for its margins, row by row.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`] and [`Buffer::read`].
    pub fn pixels(&self, frame: &Frame<'_>) -> Result<Vec<[f32; 4]>, GpuError> {
        let (table, params, n) = self.filter(frame)?;
        let pixels = Buffer::zeros(self.device, "pixels", n)?;
        let mut commands = staged("filter");
        let bound = [self.color.bind(), self.offsets.bind(), table.bind(), pixels.bind()];
        commands.dispatch(self.device, &self.kernels.filter, &bound, &params, groups(n, 64));
        commands.send(self.device)?;
        pixels.read(self.device, n)
    }

    /// The values of the pixel filter, what its kernels are told, and the count of pixels.
    pub(super) fn filter(&self, frame: &Frame<'_>) -> Result<(Buffer<f32>, Vec<u32>, usize), GpuError> {
        let [x, y] = frame.filter.axes();
        let margin = frame.margin().map(|n| n as u32);
        let kind = if frame.filter.is_pixel() { 1 } else { x.shape() };
        let table: Vec<f32> = x.table.iter().chain(&y.table).copied().collect();
        let table = Buffer::of(self.device, "filter", &table)?;
        let own = [margin[0], margin[1], x.half.to_bits(), y.half.to_bits(), x.table.len() as u32, kind];
        let params = self.head[..6].iter().copied().chain(own).collect();
        let n = ((self.head[2] - 2 * margin[0]) * (self.head[3] - 2 * margin[1])) as usize;
        Ok((table, params, n))
    }
}

/// Rows for a buffer, with gaps that the device fills.
struct Runs<T> {
    rows: Vec<T>,
    /// Of each run without a gap, how many rows and gaps are before it, and how many rows.
    starts: Vec<[usize; 2]>,
    /// Count of rows and of gaps.
    n: usize,
}

impl<T: gpu::Pod> Runs<T> {
    /// None yet, with room for a number of rows.
    fn with_capacity(n: usize) -> Runs<T> {
        Runs { rows: Vec::with_capacity(n), starts: vec![], n: 0 }
    }

    fn extend(&mut self, rows: impl Iterator<Item = T>) {
        let before = self.rows.len();
        if self.starts.last().is_none_or(|[at, first]| self.n - at != before - first) {
            self.starts.push([self.n, before]);
        }
        self.rows.extend(rows);
        self.n += self.rows.len() - before;
    }

    fn skip(&mut self, n: usize) {
        self.n += n;
    }

    /// Write them from a row on: runs that are near to each other together with the gaps between them, before these are filled.
    fn write(&self, device: &Device, buffer: &Buffer<T>, first: usize) {
        /// Bytes that are written in the time that another write takes.
        const GAP: usize = 1 << 15;
        let gap = GAP / size_of::<T>();
        let ends = self.starts.iter().skip(1).map(|[_, end]| *end).chain([self.rows.len()]);
        let runs: Vec<(usize, &[T])> =
            self.starts.iter().zip(ends).map(|([at, begin], end)| (*at, &self.rows[*begin..end])).collect();
        for near in runs.chunk_by(|a, b| b.0 - a.0 - a.1.len() <= gap) {
            let (at, rows) = near[0];
            if near.len() == 1 {
                buffer.write_from(device, first + at, rows);
                continue;
            }
            let (last, end) = near[near.len() - 1];
            let mut all = vec![T::zeroed(); last + end.len() - at];
            near.iter().for_each(|(own, rows)| all[own - at..][..rows.len()].copy_from_slice(rows));
            buffer.write_from(device, first + at, &all);
        }
    }
}

/// The depth of a key, which rises with it.
fn depth_of(key: u32) -> f32 {
    f32::from_bits(if key >> 31 == 1 { key ^ 0x8000_0000 } else { !key })
}

impl Blur {
    fn new(device: &Device, frame: &Frame<'_>, of: &Moments) -> Result<Blur, GpuError> {
        let n = of.bounds.len();
        let mut moments = vec![[0.0; 4]; 2 * PERIOD * PERIOD * n];
        for (pixel, stratum) in (0..PERIOD * PERIOD).flat_map(|pixel| (0..n).map(move |stratum| (pixel, stratum))) {
            let ([column, row], [time, x, y]) = of.of((pixel % PERIOD) as i64, (pixel / PERIOD) as i64, stratum);
            // Without a lens, samples are in the order of their times.
            let place = row as usize * frame.jitter.strata[0] + column as usize;
            let sample = if frame.jitter.lens { place } else { stratum };
            let moment = [time, x, y, sample as f32];
            moments[pixel * n + stratum] = moment;
            moments[(PERIOD * PERIOD + pixel) * n + sample] = moment;
        }
        let strata: Vec<[f32; 2]> = of.bounds.iter().flatten().copied().collect();
        let lens = match frame.camera.focus() {
            Some([reach, sharp]) => [1, reach.to_bits(), (1.0 / sharp).to_bits(), frame.camera.near.to_bits()],
            None => [0; 4],
        };
        Ok(Blur {
            moments: Buffer::of(device, "sample moments", &moments)?,
            strata: Buffer::of(device, "strata", &strata)?,
            tracks: Buffer::zeros(device, "tracks", 1)?,
            n: 0,
            lens,
        })
    }
}

/// The places of samples in their pixels, by their numbers: row by row of strata, or in images of motion without a lens by their times.
fn places(jitter: &Jitter) -> Vec<[f32; 2]> {
    let Some(moments) = jitter.moments.as_ref().filter(|_| !jitter.lens) else { return jitter.offsets().to_vec() };
    let [nx, ny] = jitter.strata;
    let place = |k: usize| {
        let (x, y) = (k % (PERIOD * nx), k / (PERIOD * nx));
        let pixel = [(x / nx) as i64, (y / ny) as i64];
        let (stratum, _) = moments.of(pixel[0], pixel[1], y % ny * nx + x % nx);
        jitter.in_pixel(pixel, stratum.map(usize::from))
    };
    (0..jitter.offsets().len()).map(place).collect()
}
