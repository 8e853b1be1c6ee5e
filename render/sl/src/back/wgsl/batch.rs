//! The grids that a kernel shades in one dispatch, as the rows of its buffers; and what comes back.

use super::super::bound::{Answer, BoundShader};
use super::super::points::Points;
use super::super::scene::{Scene, asked_in_vain, unknown_space, unset};
use super::super::slots::VariableSlots;
use super::kernel::{Kernel, Shader, Target};
use super::module::{Refused, Slot};
use crate::ir::{Ask, Global, Lookup, Operand, Parameter};
use glam::{Mat3, Mat4};
use std::sync::Arc;

/// What a kernel found wrong while it ran.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The loops of a shader do not end: name, file and line. Its values are not to be used.
    Endless(String, String),
    /// A shader uses an element that its array does not have, which is read as 0 and not written: name, file and line.
    Outside(String, String),
}

/// Where a slot's numbers begin; 0 none, 1 one value, 2 a value a point.
type Row = [u32; 2];

impl Kernel {
    /// Rows of its buffer `status`, which begin as zeros; batches one after another may share it.
    pub fn n_status(&self) -> usize {
        2 * self.shaders.len()
    }

    /// What it found wrong, by its status.
    pub fn faults(&self, status: &[u32]) -> Vec<Fault> {
        let mut faults = vec![];
        for (shader, status) in self.shaders.iter().zip(status.chunks_exact(2)) {
            let program = &shader.bound.program;
            let place = |at: u32| (program.name.clone(), program.place(at - 1).to_string());
            if status[0] > 0 {
                let (name, place) = place(status[0]);
                faults.push(Fault::Endless(name, place));
            }
            if status[1] > 0 {
                let (name, place) = place(status[1]);
                faults.push(Fault::Outside(name, place));
            }
        }
        faults
    }
}

/// A slot without values.
const NONE: Row = [0, 0];

/// How much some batches of a kernel have together, or what stands before a batch in their buffers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Rows of [`Batch::groups`].
    pub groups: usize,
    /// Rows of [`Batch::grids`].
    pub grids: usize,
    /// Rows of [`Batch::slots`].
    pub slots: usize,
    /// Rows of [`Batch::lights`].
    pub lights: usize,
    /// Numbers of all inputs, those that are filled included.
    pub values: usize,
    /// Numbers that the kernel writes.
    pub results: usize,
}

impl std::ops::AddAssign for Extent {
    fn add_assign(&mut self, o: Extent) {
        self.groups += o.groups;
        self.grids += o.grids;
        self.slots += o.slots;
        self.lights += o.lights;
        self.values += o.values;
        self.results += o.results;
    }
}

/// Grids to be shaded by a kernel: the rows of its input buffers, in the order of their bindings.
pub struct Batch<'k> {
    kernel: &'k Kernel,
    /// Of each workgroup: its grid, and the first of the points that it shades.
    pub groups: Vec<[u32; 2]>,
    /// Three rows a grid.
    pub grids: Vec<[u32; 4]>,
    /// Where inputs begin, and of which kind they are.
    pub slots: Vec<Row>,
    /// Lights; one row more than there are lights, so that it is never empty.
    pub lights: Vec<[u32; 4]>,
    /// Numbers of all inputs; at least one.
    pub values: Vec<f32>,
    n_results: usize,
    /// Slots whose numbers the host's kernels fill, and count of these.
    filled: Vec<u32>,
    n_filled: usize,
    /// What stands before it in the buffers of a dispatch.
    before: Extent,
}

impl<'k> Batch<'k> {
    /// No grids yet, and the lights that shine on all of them: those that the kernel was made for, or others that differ from these in
    /// numbers alone.
    ///
    /// # Errors
    /// A light that kernels do not have.
    pub fn new(kernel: &'k Kernel, lights: &[Arc<BoundShader>], scene: &dyn Scene) -> Result<Batch<'k>, Refused> {
        let (groups, grids, slots, rows, values) = (vec![], vec![], vec![], vec![], vec![0.0]);
        let (n_results, filled, n_filled) = (0, vec![], 0);
        let before = Extent::default();
        let mut batch =
            Batch { kernel, groups, grids, slots, lights: rows, values, n_results, filled, n_filled, before };
        let asked = if kernel.of_light.is_empty() { &[] } else { lights };
        assert_eq!(asked.len(), kernel.of_light.len(), "lights of another kernel");
        for (k, (light, index)) in asked.iter().zip(&kernel.of_light).enumerate() {
            if scene.emitter(k, 0, &|_| [0.0; 3]).is_some() {
                return Err(Refused { shader: light.program.name.clone(), reason: "is that of an area light".into() });
            }
            let first = batch.slots.len() as u32;
            let none = Points::new(1, 1, 1.0);
            batch.inputs(&kernel.shaders[*index], light, &VariableSlots::default(), &none, (scene, &[]))?;
            let has = |(bit, category): (usize, &String)| (light.in_category(category) as u32) << bit;
            let categories = kernel.categories.iter().enumerate().map(has).sum();
            batch.lights.push([*index as u32, first, categories, light.program.is_ambient as u32]);
        }
        batch.lights.push([0; 4]);
        Ok(batch)
    }

    /// Add a grid; its index.
    ///
    /// # Errors
    /// A grid that is too large for the kernel, or one for which the scene answers a query by another string than it did when the
    /// kernel was written.
    pub fn add(
        &mut self,
        shader: &BoundShader,
        variables: &VariableSlots,
        points: &Points,
        scene: &dyn Scene,
    ) -> Result<usize, Refused> {
        self.add_filled(shader, variables, points, scene, &[])
    }

    /// Add a grid, of which some globals are filled by kernels of the host: values of all points, one global's runs after another's. They stand
    /// behind all others, as [`Batch::place_filled`] says when all grids are added.
    ///
    /// # Errors
    /// Those of [`Batch::add`].
    pub fn add_filled(
        &mut self,
        shader: &BoundShader,
        variables: &VariableSlots,
        points: &Points,
        scene: &dyn Scene,
        filled: &[Global],
    ) -> Result<usize, Refused> {
        assert!(self.kernel.is_of(shader), "`{}` is not the kernel's shader", shader.program.name);
        let (n, index) = (points.n(), self.grids.len() / 3);
        if let Some(names) = self.kernel.other_answer(scene) {
            let reason = format!("has a kernel for another answer to what it asks by `{}`", names.join("`, `"));
            return Err(Refused { shader: shader.program.name.clone(), reason });
        }
        if self.kernel.grid && n > self.kernel.group as usize {
            let reason = format!("looks at neighbours in a grid of {n} points, more than {}", self.kernel.group);
            return Err(Refused { shader: shader.program.name.clone(), reason });
        }
        let first = self.slots.len() as u32;
        self.inputs(&self.kernel.shaders[0], shader, variables, points, (scene, filled))?;
        let n_lights = self.lights.len() as u32 - 1;
        self.grids.push([n as u32, points.nu as u32, points.orientation.to_bits(), first]);
        self.grids.push([0, n_lights, self.n_results as u32, 0]);
        let footprints = self.footprints(points);
        self.grids.push([footprints, 0, 0, 0]);
        let each = if self.kernel.grid { n } else { self.kernel.group as usize };
        self.groups.extend((0..n).step_by(each.max(1)).map(|k| [index as u32, k as u32]));
        self.n_results += n * self.kernel.n_results();
        // Places are numbers of 32 bits.
        if (self.values.len() + self.n_filled).max(self.n_results) > u32::MAX as usize / 4 {
            let reason = "has more values than a kernel can count".into();
            return Err(Refused { shader: shader.program.name.clone(), reason });
        }
        Ok(index)
    }

    /// Give the host's functions numbers of a grid, which they read in [`Batch::values`] from `work.own` on.
    /// Where they begin.
    pub fn give(&mut self, grid: usize, own: &[f32]) -> usize {
        let first = self.values.len();
        self.grids[3 * grid + 1][3] = first as u32;
        self.values.extend_from_slice(own);
        first
    }

    /// Count of numbers that kernels of the host fill, so far.
    pub fn n_filled(&self) -> usize {
        self.n_filled
    }

    /// Say where what kernels of the host fill stands when all grids are added: behind all other values, from this number on.
    pub fn place_filled(&mut self) -> usize {
        let first = self.values.len();
        self.filled.drain(..).for_each(|slot| self.slots[slot as usize][0] += first as u32);
        first
    }

    /// Count of the numbers of all inputs, those that are filled included.
    pub fn n_values(&self) -> usize {
        self.values.len() + self.n_filled
    }

    /// How much it has of each.
    pub fn extent(&self) -> Extent {
        Extent {
            groups: self.groups.len(),
            grids: self.grids.len(),
            slots: self.slots.len(),
            lights: self.lights.len(),
            values: self.n_values(),
            results: self.n_results,
        }
    }

    /// What stands before it in the buffers of a dispatch.
    pub fn before(&self) -> Extent {
        self.before
    }

    /// Stand behind other batches of its kernel in the buffers of one dispatch, which then shades the grids of all; when all grids are added,
    /// and what is filled has its place.
    pub fn stand_behind(&mut self, before: Extent) {
        assert!(self.before == Extent::default() && self.filled.is_empty(), "a batch is placed once, and last");
        let Extent { grids, slots, lights, values, results, .. } = before;
        let [grids, slots, lights, values, results] = [grids / 3, slots, lights, values, results].map(|n| n as u32);
        self.groups.iter_mut().for_each(|[grid, _]| *grid += grids);
        for [head, more, last] in self.grids.as_chunks_mut().0 {
            head[3] += slots;
            (more[0], more[2], more[3]) = (more[0] + lights, more[2] + results, more[3] + values);
            last[0] += if last[0] > 0 { values } else { 0 };
        }
        self.slots.iter_mut().filter(|[_, kind]| *kind > 0).for_each(|[first, _]| *first += values);
        self.lights.iter_mut().for_each(|light| light[1] += slots);
        self.before = before;
    }

    /// Where the values of a global at the points of a grid begin among those of a dispatch, if it has one a point.
    pub fn start_of(&self, grid: usize, global: Global) -> Option<usize> {
        let [n, .., slots] = self.grids[3 * grid];
        let [first, kind] = self.slots[slots as usize - self.before.slots + global.slot()];
        (kind == 2 || kind == 1 && n == 1).then_some(first as usize)
    }

    /// Where the results of a grid begin among those of a dispatch; those of an [`Output`](super::Output) stand `offset` times its count of points later.
    pub fn results_of(&self, grid: usize) -> usize {
        self.grids[3 * grid + 1][2] as usize
    }

    /// Count of numbers that the kernel writes.
    pub fn n_results(&self) -> usize {
        self.n_results
    }

    /// Rows of the buffer `status`, which begin as zeros.
    pub fn n_status(&self) -> usize {
        self.kernel.n_status()
    }

    /// Set the globals that the kernel changed at the points of a grid, as the grid machine does: those that the points have.
    pub fn take(&self, grid: usize, results: &[f32], points: &mut Points) {
        for output in self.kernel.outputs() {
            if let Target::Global(global) = output.target
                && let Some(buffer) = points.get_mut(global)
            {
                buffer.clear();
                buffer.extend_from_slice(self.values_of(grid, output.offset, output.width, results));
            }
        }
    }

    /// The values of an output parameter at the points of a grid, a triple as three runs.
    pub fn output<'r>(&self, grid: usize, name: &str, results: &'r [f32]) -> Option<&'r [f32]> {
        let params = &self.kernel.shaders[0].bound.program.params;
        let is_it = |target| matches!(target, Target::Parameter(k) if params[k].name == name);
        let output = self.kernel.outputs().iter().find(|o| is_it(o.target))?;
        Some(self.values_of(grid, output.offset, output.width, results))
    }

    fn values_of<'r>(&self, grid: usize, offset: usize, width: usize, results: &'r [f32]) -> &'r [f32] {
        let (n, first) = (self.grids[3 * grid][0] as usize, self.results_of(grid));
        &results[first + offset * n..first + (offset + width) * n]
    }

    /// What the kernel found wrong.
    pub fn faults(&self, status: &[u32]) -> Vec<Fault> {
        self.kernel.faults(status)
    }

    /// The inputs of a shader: globals, parameters, and what else it asks for.
    fn inputs(
        &mut self,
        shader: &Shader,
        bound: &BoundShader,
        variables: &VariableSlots,
        points: &Points,
        (scene, filled): (&dyn Scene, &[Global]),
    ) -> Result<(), Refused> {
        /// Globals that kernels read besides those of their shaders: what lights are asked for.
        const ALWAYS: [Global; 3] = [Global::P, Global::N, Global::I];
        let n = points.n();
        let first = self.n_filled;
        for global in Global::all() {
            let width = global.kind().width();
            if !ALWAYS.contains(&global) && bound.program.global(global).is_none() {
                self.slots.push(NONE);
                continue;
            }
            if let Some(k) = filled.iter().position(|own| *own == global) {
                let before: usize = filled[..k].iter().map(|own| own.kind().width()).sum();
                self.filled.push(self.slots.len() as u32);
                self.slots.push([(first + before * n) as u32, 2]);
                self.n_filled += width * n;
                continue;
            }
            let row = match points.get(global).filter(|values| !values.is_empty()) {
                Some(values) => self.push(values, width, n),
                None => match unset(global, scene) {
                    values if values.is_empty() => Some(NONE),
                    values => self.push(&values, width, n),
                },
            };
            let row = row.ok_or_else(|| odd(bound, global.name()))?;
            self.slots.push(row);
        }
        for (slot, param) in bound.program.params.iter().enumerate() {
            let given = variables.of_parameter(slot).and_then(|k| points.variable(k));
            let row = self.parameter(param, given, bound.value(slot), n).ok_or_else(|| odd(bound, &param.name))?;
            self.slots.push(row);
        }
        for (slot, byte) in &shader.slots {
            let row = self.answer((slot, *byte), bound, points, scene);
            self.slots.push(row);
        }
        Ok(())
    }

    /// What the points stand for: 1 more than where that begins among the values, 0 if they stand for their micropolygons.
    fn footprints(&mut self, points: &Points) -> u32 {
        // Kernels that do not look at neighbours read none.
        if points.footprints.is_empty() || !self.kernel.grid {
            return 0;
        }
        let first = self.values.len() as u32 + 1;
        (0..3).for_each(|c| self.values.extend(points.footprints.iter().map(|footprint| footprint[c])));
        first
    }

    /// Values of a width, one or one a point; none if there are as many as neither.
    fn push(&mut self, values: &[f32], width: usize, n: usize) -> Option<Row> {
        let kind = if values.len() == width {
            1
        } else if values.len() == width * n {
            2
        } else {
            return None;
        };
        let first = self.values.len() as u32;
        self.values.extend_from_slice(values);
        Some([first, kind])
    }

    /// A parameter: a primitive variable, else what is bound, else none.
    fn parameter(&mut self, param: &Parameter, given: Option<&[f32]>, own: Option<&Answer>, n: usize) -> Option<Row> {
        let Operand::Number(r) = param.reg else { return Some(NONE) };
        let own = own.and_then(|own| if let Answer::Numbers(v) = own { Some(v.as_slice()) } else { None });
        match given.or(own) {
            Some(values) => self.push(values, r.width() * param.array.unwrap_or(1) as usize, n),
            None => Some(NONE),
        }
    }

    /// What a shader asks of the scene.
    fn answer(&mut self, (slot, byte): (&Slot, u32), bound: &BoundShader, points: &Points, scene: &dyn Scene) -> Row {
        let warn = |message: Option<String>| {
            message.into_iter().for_each(|message| scene.warn(bound.program.placed(byte, &message)));
        };
        let matrix = |from: &str, to: &str| {
            let spaces = [from, to].map(|space| bound.space_of(space));
            let found = scene.matrix(spaces[0], spaces[1]);
            warn(if found.is_none() { unknown_space(scene, spaces) } else { None });
            found.map_or(Mat4::IDENTITY, |m| Mat4::from_cols_array(&m))
        };
        let (values, kind) = match slot {
            Slot::Matrix { from, to } => (matrix(from, to).to_cols_array().to_vec(), 1),
            Slot::NormalMatrix { from, to } => {
                let m = Mat3::from_mat4(matrix(from, to)).inverse().transpose();
                (Mat4::from_mat3(m).to_cols_array().to_vec(), 1)
            }
            Slot::Map { how, name } => {
                warn(if *how == Lookup::Shadow { None } else { scene.map_fault(*how, name, false) });
                (vec![scene.map_number(*how, name) as f32], 1)
            }
            Slot::Answer { what, names, width, len } => {
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let Some(values) = numbers(*what, &names, points, scene) else {
                    warn(asked_in_vain(*what, &names, scene));
                    return NONE;
                };
                // One value is that of all, also where a light is given one point for all.
                let varying = values.len() == width * points.n() && *len == 1 && points.n() > 1;
                if !varying && values.len() < width * len {
                    return NONE;
                }
                (values, if varying { 2 } else { 1 })
            }
        };
        let first = self.values.len() as u32;
        self.values.extend_from_slice(&values);
        [first, kind]
    }
}

/// The answer in numbers to a query by name: what shaders that ran before tell, else what the scene says.
fn numbers(what: Ask, names: &[&str], points: &Points, scene: &dyn Scene) -> Option<Vec<f32>> {
    if let (Ask::RendererInfo, ["version"]) = (what, names) {
        let parts = env!("CARGO_PKG_VERSION").split('.').map(|p| p.parse().unwrap_or(0.0));
        return Some(parts.chain([0.0]).collect());
    }
    let told = points.messages.iter().find(|told| told.from == what && told.name == names[0]);
    let told = told.map(|told| Answer::Numbers(told.values.clone()));
    match told.or_else(|| scene.ask(what, names))? {
        Answer::Numbers(values) => Some(values),
        Answer::Text(_) | Answer::Texts(_) => None,
    }
}

fn odd(shader: &BoundShader, name: &str) -> Refused {
    let reason = format!("is given neither one value nor one a point for `{name}`");
    Refused { shader: shader.program.name.clone(), reason }
}
