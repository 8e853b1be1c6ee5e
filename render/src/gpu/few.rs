//! The points of grids that are shaded together, and what they need: a batch of their kernels, and what is given without these.

use crate::cpu::deferred::gather;
use crate::cpu::frame::Frame;
use crate::cpu::globals::surface_globals;
use crate::cpu::shade::{Surface, prepare, surface_opacity};
use crate::cpu::view::View;
use crate::film::display::{SHOWN, placed};
use crate::gpu::front::Diced;
use crate::gpu::refusal::Refusal;
use crate::scene::source::{Item, ItemView};
use sl::Global;
use sl::machine::{BoundShader, Points, VariableSlots};
use sl::wgsl::{Batch, Kernel, Target};

/// Where the numbers of a global begin among those that a kernel gives of a point.
pub fn offset_of(kernel: &Kernel, global: Global) -> Option<usize> {
    kernel.outputs().iter().find(|output| output.target == Target::Global(global)).map(|output| output.offset)
}

/// Those of some bits that are set, from the first one on.
fn set_of(bits: &[u32], first: usize, n: usize) -> impl Iterator<Item = u32> + '_ {
    let end = first + n;
    (first / 32..end.div_ceil(32)).flat_map(move |word| {
        let mut left = within(bits, word, first, end);
        std::iter::from_fn(move || {
            let k = (left != 0).then(|| left.trailing_zeros())?;
            left &= left - 1;
            Some((32 * word + k as usize - first) as u32)
        })
    })
}

/// How many of some bits are set.
pub fn count_of(bits: &[u32], first: usize, n: usize) -> usize {
    let end = first + n;
    (first / 32..end.div_ceil(32)).map(|word| within(bits, word, first, end).count_ones() as usize).sum()
}

/// The bits of a word from one to before another.
fn within(bits: &[u32], word: usize, first: usize, end: usize) -> u32 {
    let low = u32::MAX << first.saturating_sub(32 * word);
    let high = if end - 32 * word >= 32 { u32::MAX } else { (1 << (end - 32 * word)) - 1 };
    bits[word] & low & high
}

/// A grid whose points are shaded: its index, the first of its points among all, and how many tiles that the device dices are before it.
#[derive(Clone, Copy)]
pub struct Chosen {
    pub index: usize,
    pub first: usize,
    pub cap: u32,
}

/// The points that are shaded together.
#[derive(Default)]
pub struct Few<'k> {
    /// The kernel of their surface's shader.
    kernel: Option<&'k Kernel>,
    takes_outputs: bool,
    pub grids: Vec<FewOfGrid>,
    /// Count of those that are wanted.
    pub n_points: usize,
    /// Of each that is wanted, its opacity, if the surface's shader leaves that as it is: three runs a grid.
    pub opacities: Vec<f32>,
    /// What displays take besides colours: rows of results, and rows of numbers that are given.
    pub rows: Vec<[u32; 4]>,
    pub given_rows: Vec<[u32; 4]>,
    pub given_outputs: Vec<f32>,
    /// Of those of tiles that the device dices: two rows a tile, as `cap_points.wgsl` has them.
    pub of_caps: Vec<[u32; 4]>,
    gathered: Points,
    wanted: Vec<u32>,
}

/// Those of a grid.
pub struct FewOfGrid {
    /// Count of its points that are shaded.
    pub n: usize,
    /// Its source.
    source: u32,
    /// Whether its opacity may be other than it is given as a whole.
    has_opacities: bool,
    /// Whether all its points are shaded, not only those that are wanted.
    is_whole: bool,
    /// Its first point among all: as the shutter opens, whose bits say which are wanted, and as it is shaded. Count of all its points.
    first: [usize; 2],
    n_all: usize,
    /// Count of those that are wanted, and where their opacities begin, if they are given.
    pub n_wanted: usize,
    opacities: usize,
}

impl FewOfGrid {
    /// Two rows as `point_colors.wgsl` has them, for results that begin at a place.
    pub fn rows(&self, results: usize) -> [[u32; 4]; 2] {
        self.rows_of(results, self.n, self.is_whole)
    }

    /// The same for the opacities that are given.
    pub fn rows_of_opacities(&self) -> [[u32; 4]; 2] {
        self.rows_of(self.opacities, self.n_wanted, false)
    }

    fn rows_of(&self, results: usize, n: usize, is_whole: bool) -> [[u32; 4]; 2] {
        // The highest bit if its opacity is given as a whole.
        let named = self.source | u32::from(!self.has_opacities) << 31;
        let [bits, first] = self.first.map(|at| at as u32);
        [[bits, self.n_all as u32, first, n as u32], [results as u32, named, u32::from(is_whole), 0]]
    }
}

impl<'k> Few<'k> {
    /// None yet, of a kernel; whether displays take more than colours.
    pub fn of(kernel: &'k Kernel, takes_outputs: bool) -> Few<'k> {
        Few { kernel: Some(kernel), takes_outputs, ..Few::default() }
    }

    /// Add the points of a grid that are wanted, or all if its shaders look at neighbours; as the shutter opens, and at each time of a
    /// colour or opacity that moves.
    ///
    /// # Errors
    /// What the batch cannot take.
    pub fn add(
        &mut self,
        frame: &Frame<'_>,
        grid: &Diced,
        (chosen, wanted): (Chosen, &[u32]),
        batch: &mut Batch<'_>,
        mut later: Option<&mut Batch<'_>>,
    ) -> Result<(), Refusal> {
        let (first, n) = (chosen.first, grid.n());
        self.wanted.clear();
        self.wanted.extend(set_of(wanted, first, n));
        let view = frame.scene.view(grid.item);
        for moment in 0..=grid.fades.len() {
            let time = moment.checked_sub(1).map_or(0.0, |k| grid.fades[k]);
            let places = [first, first + moment * n];
            self.add_at(frame, (grid, &view), (places, chosen.cap, time), batch, later.as_deref_mut())?;
        }
        Ok(())
    }

    /// Add those of a time, whose places among all begin at the second; at the first, those whose bits say which are wanted.
    fn add_at(
        &mut self,
        frame: &Frame<'_>,
        (grid, view): (&Diced, &ItemView<'_>),
        (places @ [bits, first], cap, time): ([usize; 2], u32, f32),
        batch: &mut Batch<'_>,
        later: Option<&mut Batch<'_>>,
    ) -> Result<(), Refusal> {
        let whole = view.attributes.reads_neighbours();
        let mut gathered = std::mem::take(&mut self.gathered);
        match (&grid.points, &grid.cap) {
            (Some(points), _) if whole => gathered.clone_from(points),
            (Some(points), _) => gather(points, view.attached.n_uniform, &self.wanted, &mut gathered),
            (None, Some(cap)) => of_cap(cap.orientation, view, self.wanted.len(), &mut gathered),
            (None, None) => {}
        }
        let points = &mut gathered;
        let surface = Surface { item: grid.item, view, reach: grid.reach, z: grid.z, time };
        let filled: &[Global] = match (&grid.cap, view.attributes.surface.program.global(Global::Ng)) {
            (None, _) => &[],
            (Some(_), None) => &OF_CAPS[..3],
            (Some(_), Some(_)) => &OF_CAPS,
        };
        let scene = if grid.cap.is_some() {
            surface_globals(points, view, frame.camera.eye, time);
            // The device knows how near the start of a ray nothing is met.
            View::new(frame.scene, &frame.rays, grid.item, view, [0.0; 2])
        } else {
            prepare(frame, &surface, points)
        };
        let id = frame.scene.id_of(grid.item);
        let [x, y, z] = scene.flat.unwrap_or_default().to_array();
        let whole_id = frame.scene.whole_of(grid.item);
        let halves = |n: u32| [(n & 0xffff) as f32, (n >> 16) as f32];
        let ([low, high], [whole_low, whole_high]) = (halves(id as u32), halves(whole_id));
        let own = [low, high, scene.bias[0], scene.bias[1], x, y, z, whole_low, whole_high];
        let shader = (&*view.attributes.surface, &view.attached.surface);
        let given = batch.n_filled();
        let (k, given_own) = add(batch, shader, points, &scene, (&own, filled))?;
        if grid.cap.is_some() {
            self.of_caps.push([cap, points.n() as u32, bits as u32, given as u32]);
            self.of_caps.push([given_own as u32, (filled.len() == OF_CAPS.len()) as u32, 0, 0]);
        }
        self.n_points += self.wanted.len();
        self.grids.push(FewOfGrid {
            n: points.n(),
            source: grid.item.source,
            has_opacities: !view.attributes.keeps_opacity() || view.attached.opacity.is_some(),
            is_whole: whole,
            first: places,
            n_all: grid.n(),
            n_wanted: self.wanted.len(),
            opacities: self.opacities.len(),
        });
        self.note_given(frame, (grid.item, &grid.motion), first, (batch, k), view, points);
        if let (Some(later), Some(shader)) = (later, &view.attributes.atmosphere) {
            // The surface's results come here, and what it was given.
            let is_found = |g: Global| self.kernel.is_some_and(|kernel| offset_of(kernel, g).is_some());
            let is_relayed = |g: &Global| is_found(*g) && shader.program.global(*g).is_some();
            let is_carried = |g: &Global| batch.start_of(k, *g).is_some();
            let relayed = [Global::Ci, Global::Oi].into_iter().filter(is_relayed);
            let filled: Vec<Global> = relayed.chain(CARRIED.into_iter().filter(is_carried)).collect();
            let scene = View { shader_to_world: view.attributes.atmosphere_space, ..scene };
            add(later, (shader, &view.attached.atmosphere), points, &scene, (&own, &filled))?;
        }
        self.gathered = gathered;
        Ok(())
    }

    /// Note what is given of the points of the last grid, the one of an index of a batch: their opacities, if the shader leaves them, and
    /// where what displays take of them besides colours is found.
    fn note_given(
        &mut self,
        frame: &Frame<'_>,
        (item, motion): (Item, &[[f32; 2]]),
        first: usize,
        (batch, index): (&Batch<'_>, usize),
        view: &ItemView<'_>,
        points: &Points,
    ) {
        let (Some(kernel), Some(grid)) = (self.kernel, self.grids.last()) else { return };
        // Its place among those of its grid that are shaded.
        let place = |(i, k): (usize, &u32)| if grid.is_whole { *k } else { i as u32 };
        if offset_of(kernel, Global::Oi).is_none() {
            let given = surface_opacity(points);
            for c in 0..3 {
                let of = |at: u32| if given.len() == 3 { given[c] } else { given[c * grid.n + at as usize] };
                self.opacities.extend(self.wanted.iter().enumerate().map(|own| of(place(own))));
            }
        }
        if !self.takes_outputs {
            return;
        }
        let own: Vec<(u32, u32)> =
            self.wanted.iter().enumerate().map(|own| (first as u32 + own.1, place(own))).collect();
        let own = &own;
        let id = [frame.scene.id_of(item) as f32];
        for (place, aov) in placed(&frame.aovs) {
            let (width, name) = (aov.width(), aov.name.as_str());
            let goal = |point: u32| (point as usize * frame.depth + place) as u32;
            if view.attributes.matte && SHOWN.contains(&name) {
                continue;
            }
            if name == "motion" {
                for (point, _) in own {
                    let values = motion.get(*point as usize - first).copied().unwrap_or_default();
                    self.given_rows.push([goal(*point), self.given_outputs.len() as u32, 1, 2]);
                    self.given_outputs.extend(values);
                }
                continue;
            }
            let global = if name == "id" || name == "z" { None } else { Global::of_name(name) };
            if let Some(output) = kernel.output_of(name, global).filter(|output| output.width == width) {
                let from = batch.results_of(index) + output.offset * grid.n;
                let row = |(point, at): &(u32, u32)| [goal(*point), from as u32 + at, grid.n as u32, width as u32];
                self.rows.extend(own.iter().map(row));
                continue;
            }
            let values = match name {
                "z" => None,
                "id" => Some(&id[..]),
                "Ng" => points.get(Global::Ng).filter(|v| !v.is_empty()).or(points.get(Global::N)),
                _ => global.and_then(|g| points.get(g)).or_else(|| points.variable(view.attached.slot(name)?)),
            };
            let Some(values) = values.filter(|v| v.len() == width || v.len() == width * grid.n) else { continue };
            for (point, at) in own {
                self.given_rows.push([goal(*point), self.given_outputs.len() as u32, 1, width as u32]);
                self.given_outputs.extend(of_point(values, width, grid.n, *at as usize));
            }
        }
    }

    /// The runs of a surface's results that its atmosphere is given, and of what the surface was given itself.
    pub fn relays(&self, batch: &Batch<'_>, kernel: &Kernel, later: &Batch<'_>) -> [Vec<[u32; 4]>; 2] {
        let run = |k: usize, source: usize, goal: usize, is_carried: bool| {
            [source as u32, goal as u32, 3 * self.grids[k].n as u32, u32::from(is_carried)]
        };
        let [mut results, mut values] = [vec![], vec![]];
        for k in 0..self.grids.len() {
            for global in [Global::Ci, Global::Oi] {
                let found = offset_of(kernel, global).zip(later.start_of(k, global));
                results.extend(
                    found.map(|(offset, goal)| run(k, batch.results_of(k) + offset * self.grids[k].n, goal, false)),
                );
            }
            for global in CARRIED {
                let found = batch.start_of(k, global).zip(later.start_of(k, global));
                values.extend(found.map(|(source, goal)| run(k, source, goal, true)));
            }
        }
        [results, values]
    }
}

/// Points of a sphere's cap: all that they have alike.
fn of_cap(orientation: f32, view: &ItemView<'_>, n: usize, points: &mut Points) {
    points.globals_mut().for_each(Vec::clear);
    (points.nu, points.nv, points.orientation) = (n, 1, orientation);
    points.footprints.clear();
    view.fill_variables(points);
    view.to_current(points);
}

/// What an atmosphere's shader is given as the surface's was, however that left it.
const CARRIED: [Global; 3] = [Global::P, Global::N, Global::I];

/// What the device gives shaders of points that it dices.
const OF_CAPS: [Global; 4] = [Global::P, Global::N, Global::I, Global::Ng];

/// Add the points of a grid to those of a kernel, with the host's own numbers and what the device fills; its index, and where the own
/// numbers begin.
fn add(
    batch: &mut Batch<'_>,
    (shader, slots): (&BoundShader, &VariableSlots),
    points: &Points,
    scene: &View<'_>,
    (own, filled): (&[f32], &[Global]),
) -> Result<(usize, usize), Refusal> {
    let k = batch.add_filled(shader, slots, points, scene, filled)?;
    Ok((k, batch.give(k, own)))
}

/// The numbers of a point of `n`, of values that are one for all or one a point.
fn of_point(values: &[f32], width: usize, n: usize, k: usize) -> impl Iterator<Item = f32> + '_ {
    let is_one = values.len() == width;
    (0..width).map(move |c| if is_one { values[c] } else { values[c * n + k] })
}
