//! Cone complementarity problems and the methods that solve them.
//!
//! A problem is a symmetric operator N, an offset r and a product of cones: minimise `½ γᵀNγ + rᵀγ` over γ in the cones
//! (Negrut et al. 2012, §2). A method ([`Method`]) sees N only as an [`Operator`]: `bodies` applies it matrix-free to contacts
//! between bodies, with the joints eliminated; `matrix` holds one as sparse blocks.
//!
//! Multipliers are three numbers a block. Those of contacts are vectors of the world, so that no tangent frame is needed.

mod apgd;
pub(crate) mod balls;
mod barzilai_borwein;
pub mod bodies;
mod descend;
mod exact;
mod gauss_seidel;
mod jacobi;
pub mod joints;
mod ldl;
pub mod matrix;
pub mod problem;
mod schedule;
mod visit;

pub use crate::twist::Twist;

use crate::FrictionLaw;
use crate::cpu::{add, fill_rows, sum_rows, sweep};
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use schedule::{Colored, Tiled};

/// The iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The paper's Algorithm 1.
    Jacobi,
    /// Block after block, coloured.
    GaussSeidel,
    /// Accelerated projected gradient descent with adaptive restart.
    Apgd,
    /// Spectral projected gradients.
    BarzilaiBorwein,
}

impl Method {
    /// All methods.
    pub const ALL: [Method; 4] = [Method::Jacobi, Method::GaussSeidel, Method::Apgd, Method::BarzilaiBorwein];

    /// The name, as model files write it.
    pub fn name(self) -> &'static str {
        match self {
            Method::Jacobi => "jacobi",
            Method::GaussSeidel => "gauss_seidel",
            Method::Apgd => "apgd",
            Method::BarzilaiBorwein => "barzilai_borwein",
        }
    }
}

/// How contacts are solved; also the `solver` section of a model file.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolverSettings {
    /// `apgd`, `barzilai_borwein`, `gauss_seidel` or `jacobi`.
    pub method: Method,
    /// The law of friction: `relaxed` (the paper's convex form) or `exact`.
    pub friction: FrictionLaw,
    /// The most iterations a step; if not given 50, and more where contacts are few: up to 50,000 over their number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iterations: Option<u32>,
    /// Stop when the residual (as in `report.csv`) is below this, m/s; 0 does all iterations.
    pub tolerance: f64,
    /// Relaxation ω of Jacobi and Gauss–Seidel; 0.3 and 1 if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub omega: Option<f64>,
    /// Jacobi's smoothing λ.
    pub lambda: f64,
    /// Whether impulses of the last step are the starting point.
    pub warm_start: bool,
    /// Greatest speed at which an overlap is pushed apart, m/s.
    pub recovery_speed: f64,
    /// Contacts are made at gaps up to this, and farther for fast bodies, m; a fiftieth of the least moving shape if not given.
    pub envelope: Option<f64>,
}

impl Default for SolverSettings {
    fn default() -> SolverSettings {
        SolverSettings {
            method: Method::Apgd,
            friction: FrictionLaw::Relaxed,
            iterations: None,
            tolerance: 1e-7,
            omega: None,
            lambda: 1.0,
            warm_start: true,
            recovery_speed: 1.0,
            envelope: None,
        }
    }
}

impl SolverSettings {
    /// The most iterations for so many blocks.
    pub fn most_iterations(&self, n_blocks: usize) -> u32 {
        self.iterations.unwrap_or((50_000 / n_blocks.max(1)).max(50) as u32)
    }
}

/// How a solve went.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Iterations done.
    pub iterations: u32,
    /// `‖(γ − Π(γ − g (Nγ + r))) / g‖₂ / n_blocks` with g = 10⁻³ η: the velocity, m/s, by which contacts still miss their cones;
    /// rolling blocks count with the speed at their radius of gyration.
    pub residual: f64,
}

/// What an operator makes of multipliers, in the space where it is cheap to combine: all motions, and the joints' multipliers.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Motions of the bodies.
    pub twist: Vec<Twist>,
    /// Multipliers of the eliminated joint rows.
    pub lambda: Vec<f64>,
}

impl Image {
    /// `self = a + β (a − b)`.
    fn extrapolate(&mut self, a: &Image, b: &Image, beta: f64) {
        self.twist.resize(a.twist.len(), Twist::default());
        fill_rows(&mut self.twist, |i| a.twist[i].beyond(&b.twist[i], beta));
        self.lambda.clear();
        self.lambda.extend(a.lambda.iter().zip(&b.lambda).map(|(p, q)| p + (p - q) * beta));
    }

    fn copy_from(&mut self, other: &Image) {
        self.twist.clone_from(&other.twist);
        self.lambda.clone_from(&other.lambda);
    }
}

/// The point y = x + β (x − previous), with its image.
#[derive(Clone, Copy)]
pub struct Extrapolated<'a> {
    /// x.
    pub x: &'a [DVec3],
    /// The point before x.
    pub previous: &'a [DVec3],
    /// β.
    pub beta: f64,
    /// The image of y.
    pub image: &'a Image,
}

/// A symmetric operator N with its cones: `gradient = pull(image(γ))` is Nγ + r.
pub trait Operator: Sync {
    /// Number of blocks of three multipliers.
    fn n_blocks(&self) -> usize;
    /// The image of γ; it is affine in γ.
    fn image(&mut self, gamma: &[DVec3], out: &mut Image);
    /// Block i of Nγ + r, from γ's image.
    fn pull(&self, image: &Image, block: usize) -> DVec3;
    /// dᵀNd for the difference of two multipliers, given by their images.
    fn curvature(&self, a: &Image, b: &Image) -> f64;
    /// The size of an image in the units of the curvature.
    fn energy(&self, image: &Image) -> f64;
    /// A projected step from y = x + β (x − previous): `next = Π(y − t η (N y + r))`. Returns
    /// `[|next − y|²/η, (N y + r)·(next − x)]`, summed. An operator may begin the image of `next` in `to`.
    fn descend(&self, next: &mut [DVec3], from: &Extrapolated, step: f64, _to: &mut Image) -> [f64; 2] {
        sweep(next, |first, rows| descend::any(self, first, rows, from, step))
    }
    /// After `descend`: the image of `next`, the image of the point extrapolated from `x` and it, and the curvature along
    /// `next` − y.
    fn advance(&mut self, next: &[DVec3], beta: f64, [x, y]: [&Image; 2], [to, to_y]: [&mut Image; 2]) -> f64 {
        descend::advance(self, next, beta, [x, y], [to, to_y])
    }
    /// Project block i onto its cone; `gamma` has the multipliers that the cone's width may hang on.
    fn project(&self, block: usize, value: DVec3, gamma: &[DVec3]) -> DVec3;
    /// The same, with the multipliers in cells.
    fn project_cells(&self, block: usize, value: DVec3, gamma: &Cells<DVec3>) -> DVec3;
    /// η of a block: 3/trace(N_ii).
    fn eta(&self, block: usize) -> f64;
    /// The length by which the velocities of a block become m/s: 1 but where they are rad/s.
    fn lever(&self, _block: usize) -> f64 {
        1.0
    }
    /// N_ii.
    fn diagonal(&self, block: usize) -> DMat3;
    /// Change block i of γ by `d` and the image with it, but for what the joints do.
    fn kick(&self, image: &Cells<Twist>, block: usize, d: DVec3);
    /// Block i of Nγ + r from an image that others may be changing elsewhere.
    fn pull_cells(&self, image: &Cells<Twist>, block: usize) -> DVec3;
    /// Let the joints answer to kicks.
    fn settle(&mut self, image: &mut Image);
    /// Colour the blocks: those of a colour have no image entry in common.
    fn colors(&self, colored: &mut Colored);
    /// Whether multiples of what is in the cones are in them: none has its tip below zero.
    fn has_open_cones(&self) -> bool {
        true
    }
    /// Whether no block's cone hangs on another's multipliers.
    fn has_cones_apart(&self) -> bool {
        true
    }
    /// The coefficient of friction of a block, and its normal; (0, 0) where it has none.
    fn friction(&self, block: usize) -> (f64, DVec3);
    /// Feed the gap's rate of every block with `μ |v_t|` (exact friction); replaces what was fed before.
    fn feed(&mut self, slip: &[f64]);
}

/// A column whose entries are changed by several threads that never share an entry.
pub struct Cells<'a, T> {
    entry: &'a [std::cell::UnsafeCell<T>],
}

// SAFETY: entries are only reached through `get` and `set`, whose callers hold that no two threads touch the same entry.
unsafe impl<T: Send> Sync for Cells<'_, T> {}

impl<'a, T: Copy> Cells<'a, T> {
    /// Share a column.
    fn new(column: &'a mut [T]) -> Cells<'a, T> {
        let entry: *const [T] = column;
        // SAFETY: UnsafeCell<T> has the layout of T, and the column is borrowed for as long as the cells live.
        Cells { entry: unsafe { &*(entry as *const [std::cell::UnsafeCell<T>]) } }
    }

    /// Read an entry.
    #[inline(always)]
    pub fn get(&self, i: usize) -> T {
        // SAFETY: blocks that are visited at once share no moving body (`schedule`), and entries of bodies held in place are
        // never written; where entries are blocks, each task has its own; so nobody writes this one meanwhile.
        unsafe { *self.entry[i].get() }
    }

    /// Write an entry.
    #[inline(always)]
    pub fn set(&self, i: usize, value: T) {
        // SAFETY: as for `get`; of bodies, only moving ones are written.
        unsafe { *self.entry[i].get() = value }
    }
}

/// The rounding of impulses and of velocities, of their size: some units in the last place.
const ROUNDING: f64 = 1e-15;

/// The methods' own columns, kept from step to step.
#[derive(Default)]
pub struct Workspace {
    previous: Vec<DVec3>,
    next: Vec<DVec3>,
    best: Vec<DVec3>,
    image_next: Image,
    image_y: Image,
    image_y_next: Image,
    image_best: Image,
    colored: Colored,
    tiled: Tiled,
    coarse: balls::Packed<f32, 8>,
    fine: balls::Packed<f64, 4>,
    /// The step length that was right for the last APGD; the next begins with it.
    pub step_length: f64,
}

impl Workspace {
    /// Let go of what the next solve lays out anew.
    pub fn forget(&mut self) {
        (self.coarse, self.fine) = Default::default();
    }
}

/// Visit tasks that share no body, side by side unless there is little to do; sums in order.
fn share<T: Send, const K: usize>(
    tasks: impl IndexedParallelIterator<Item = T>,
    is_little: bool,
    visit: impl Fn(T) -> [f64; K] + Send + Sync,
) -> [f64; K] {
    let least = if is_little { tasks.len().max(1) } else { 1 };
    let parts: Vec<[f64; K]> = tasks.with_min_len(least).map(visit).collect();
    parts.into_iter().fold([0.0; K], add)
}

/// The best iterate of a method whose residual does not fall at every step. The residual is looked at now and then, and at the
/// end. The starting point is no candidate: where a blow has just come its mean residual may be less than that of iterates that
/// have begun to spread it.
struct Best {
    outcome: Outcome,
    /// Whether the iterate that was looked at last is the best.
    is_current: bool,
}

impl Best {
    /// Iterations between looks at the residual, and where no residual is good enough to stop at.
    const LOOK: [u32; 2] = [10, 25];

    fn new() -> Best {
        Best { outcome: Outcome { iterations: 0, residual: f64::INFINITY }, is_current: true }
    }

    /// Look at the iterate after `done` iterations, if it is time; whether it is good enough.
    fn look(
        &mut self,
        op: &impl Operator,
        settings: &SolverSettings,
        done: u32,
        (gamma, image): (&[DVec3], &Image),
        (kept, kept_image): (&mut Vec<DVec3>, &mut Image),
    ) -> bool {
        let last = done >= settings.most_iterations(gamma.len());
        if !done.is_multiple_of(Self::LOOK[(settings.tolerance <= 0.0) as usize]) && !last {
            return false;
        }
        self.compare(Outcome { iterations: done, residual: residual(op, gamma, image) });
        let is_enough = self.is_current && self.outcome.residual <= settings.tolerance;
        if self.is_current && !is_enough && !last {
            kept.clear();
            kept.extend_from_slice(gamma);
            kept_image.copy_from(image);
        }
        is_enough
    }

    /// Compare an iterate with the best one, of those whose residual is finite.
    fn compare(&mut self, outcome: Outcome) {
        self.is_current = outcome.residual <= self.outcome.residual || !self.outcome.residual.is_finite();
        if self.is_current {
            self.outcome = outcome;
        }
    }

    /// Put the best iterate back where it is not the last one.
    fn finish(self, done: u32, gamma: &mut [DVec3], image: &mut Image, work: &Workspace) -> Outcome {
        if !self.is_current {
            gamma.copy_from_slice(&work.best);
            image.copy_from(&work.image_best);
        }
        Outcome { iterations: done, residual: self.outcome.residual }
    }
}

/// Whether nothing carries and nothing needs to: the starting point without impulses is the solution.
fn is_idle(op: &impl Operator, gamma: &[DVec3], image: &Image) -> bool {
    gamma.iter().all(|g| *g == DVec3::ZERO) && residual(op, gamma, image) == 0.0
}

/// Solve: γ comes in as the starting point and goes out as the solution, `image` as its image.
pub fn solve(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut Vec<DVec3>,
    image: &mut Image,
    work: &mut Workspace,
) -> Outcome {
    if op.n_blocks() == 0 {
        op.image(gamma, image);
        return Outcome::default();
    }
    if op.has_cones_apart() {
        let values = Cells::new(gamma);
        let project = |i: usize| values.set(i, op.project_cells(i, values.get(i), &values));
        (0..op.n_blocks()).into_par_iter().with_min_len(crate::cpu::PIECE).for_each(project);
    } else {
        // One after the other: what a rolling block may carry hangs on its contact's.
        (0..gamma.len()).for_each(|i| gamma[i] = op.project(i, gamma[i], gamma));
    }
    op.image(gamma, image);
    match settings.friction {
        FrictionLaw::Relaxed => {
            scale(op, gamma, image, work);
            run(op, settings, gamma, image, work)
        }
        FrictionLaw::Exact => exact::run(op, settings, gamma, image, work),
    }
}

/// Scale the starting point so that the objective is least along it, which can only lessen it: cones are kept. Impulses of the
/// last step that stopped a fall would otherwise push back, and those of a load that has just come would be too small for as
/// many iterations as a stack's slowest mode takes, which is the common factor of its impulses.
fn scale(op: &mut impl Operator, gamma: &mut Vec<DVec3>, image: &mut Image, work: &mut Workspace) {
    /// Beyond this factor the image is evaluated again: what small impulses add to velocities is rounded.
    const FAR: f64 = 1e3;
    if gamma.iter().all(|g| *g == DVec3::ZERO) {
        return;
    }
    let Workspace { next, image_next, image_y, .. } = work;
    next.clear();
    next.resize(gamma.len(), DVec3::ZERO);
    op.image(next, image_next);
    // γᵀNγ, and γᵀ(Nγ + r).
    let curvature = op.curvature(image, image_next);
    let [slope] = sum_rows(gamma.len(), |i| [gamma[i].dot(op.pull(image, i))]);
    let factor = 1.0 - slope / curvature;
    let most = if op.has_open_cones() { f64::INFINITY } else { 1.0 };
    if curvature > 0.0 && factor.is_finite() {
        let factor = factor.clamp(0.0, most);
        fill_rows(next, |i| gamma[i] * factor);
        std::mem::swap(gamma, next);
        if factor > FAR {
            op.image(gamma, image);
        } else {
            image_y.extrapolate(image, image_next, factor - 1.0);
            std::mem::swap(image, image_y);
        }
    }
}

/// Solve with the offset as it is.
fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut Vec<DVec3>,
    image: &mut Image,
    work: &mut Workspace,
) -> Outcome {
    if is_idle(op, gamma, image) {
        return Outcome::default();
    }
    match settings.method {
        Method::Jacobi => jacobi::run(op, settings, gamma, image, work),
        Method::GaussSeidel => gauss_seidel::run(op, settings, gamma, image, work),
        Method::Apgd => apgd::run(op, settings, gamma, image, work),
        Method::BarzilaiBorwein => barzilai_borwein::run(op, settings, gamma, image, work),
    }
}

/// Project onto the cone |γ_t| ≤ μ γ_n about the axis n.
#[inline]
pub fn project_cone(y: DVec3, n: DVec3, mu: f64) -> DVec3 {
    let normal = y.dot(n);
    let tangent = y - n * normal;
    let t2 = tangent.length_squared();
    if normal >= 0.0 && t2 <= mu * mu * normal * normal {
        return y;
    }
    let t = t2.sqrt();
    if t * mu <= -normal {
        return DVec3::ZERO;
    }
    let kept = (t * mu + normal) / (mu * mu + 1.0);
    n * kept + tangent * (mu * kept / t)
}

/// What a block misses of its cone: `(γ − Π(γ − g (Nγ + r))) / g` with g = 10⁻³ η, m/s (rad/s for rolling blocks).
#[inline]
fn missed(op: &impl Operator, i: usize, eta: f64, gamma: &[DVec3], image: &Image) -> DVec3 {
    let g = 1e-3 * eta;
    let gradient = op.pull(image, i);
    (gamma[i] - op.project(i, gamma[i] - gradient * g, gamma)) / g
}

/// The residual of γ: see [`Outcome::residual`].
pub fn residual(op: &impl Operator, gamma: &[DVec3], image: &Image) -> f64 {
    let [sum] = sum_rows(gamma.len(), |i| {
        let lever = op.lever(i);
        [missed(op, i, op.eta(i), gamma, image).length_squared() * (lever * lever)]
    });
    sum.sqrt() / gamma.len() as f64
}

/// The block that misses its cone by most. There must be blocks; their η are evaluated again, which some methods do not keep.
pub fn worst_block(op: &impl Operator, gamma: &[DVec3], image: &Image) -> usize {
    let miss = |i: usize| {
        let n = op.diagonal(i);
        let trace = n.x_axis.x + n.y_axis.y + n.z_axis.z;
        missed(op, i, 3.0 / trace, gamma, image).length_squared() * op.lever(i).powi(2)
    };
    (0..gamma.len()).map(|i| (miss(i), i)).fold((-1.0, 0), |worst, now| if now.0 > worst.0 { now } else { worst }).1
}
