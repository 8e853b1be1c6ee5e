//! Gauss–Seidel sweeps on packed contacts, several blocks at a time: contacts between spheres (`sphere_group`), or manifolds, the contacts
//! of a pair of any shapes (`manifold_group`), by either law of friction. Contacts that roll with friction or stick have groups of their own
//! (`resistance`), so that others do not pay for them.
//!
//! The data of the blocks is packed once per solve, tile by tile and colour by colour (`schedule`), in groups of blocks that have no
//! body in common; a sweep streams through it. The first sweeps are in single precision, where a group has eight contacts of spheres or
//! sixteen manifolds and half the bytes; double precision follows once the residual is near the rounding error. The bodies' velocities are
//! then computed again from the impulses, so that the momentum has no rounding error of single precision.

use super::bodies::BodyOperator;
use super::cells::Cells;
use super::flow::{self, Flow};
use super::group::{self, Group, Grouped, Motion, act};
use super::manifold_group::ManifoldGroup;
use super::operator::Operator;
use super::response::Response;
use super::schedule::{Blocks, Colored, Tiled};
use super::sphere_group::SphereGroup;
use crate::contacts::Arms;
use crate::outcome::Outcome;
use crate::rows::{cut, fill_rows, fold_tasks, sum_rows};
use crate::settings::{FrictionLaw, SolverSettings};
use crate::twist::Twist;
use glam::DVec3;
use rayon::prelude::*;

/// Root mean square of the residual terms at which single precision ends, over the maximum speed of a body.
const COARSE: f64 = 1e-5;

/// The columns of the sweeps, which keep their memory from step to step.
#[derive(Default)]
pub struct Sweeps {
    blocks: Blocks,
    tiled: Tiled,
    spheres: Precisions<8, SphereGroup<f32, 8, 0>, SphereGroup<f64, 4, 0>>,
    manifolds: Precisions<16, ManifoldGroup<f32, 16, 0>, ManifoldGroup<f64, 4, 0>>,
    resisting_spheres: Precisions<8, SphereGroup<f32, 8, 1>, SphereGroup<f64, 4, 1>>,
    resisting_manifolds: Precisions<16, ManifoldGroup<f32, 16, 1>, ManifoldGroup<f64, 4, 1>>,
}

impl Sweeps {
    /// Release the memory of columns that the next solve lays out again, where it is much.
    pub fn release(&mut self) {
        self.spheres.release();
        self.manifolds.release();
        self.resisting_spheres.release();
        self.resisting_manifolds.release();
    }
}

/// Solve: γ comes in as the starting point and goes out as the solution, `response` as its response.
pub fn run(
    op: &mut BodyOperator,
    settings: &SolverSettings,
    gamma: &mut [DVec3],
    response: &mut Response,
    work: &mut Sweeps,
) -> Outcome {
    let Sweeps { blocks, tiled, spheres, manifolds, resisting_spheres, resisting_manifolds } = work;
    match op.contacts.arms {
        Arms::Along(_) => blocks.be_contacts(),
        Arms::Any(_) => blocks.be_manifolds(op.contacts),
    }
    tiled.fill(op.contacts, blocks, &op.masses.inv_mass);
    let at = (&*blocks, &*tiled);
    match (&op.contacts.arms, op.plan.resists()) {
        (Arms::Along(_), false) => spheres.run(op, at, settings, gamma, response),
        (Arms::Any(_), false) => manifolds.run(op, at, settings, gamma, response),
        (Arms::Along(_), true) => resisting_spheres.run(op, at, settings, gamma, response),
        (Arms::Any(_), true) => resisting_manifolds.run(op, at, settings, gamma, response),
    }
}

/// The packed blocks in single and in double precision.
struct Precisions<const L: usize, C, F> {
    coarse: Packed<f32, L, C>,
    fine: Packed<f64, 4, F>,
}

impl<const L: usize, C, F> Default for Precisions<L, C, F> {
    fn default() -> Self {
        Precisions { coarse: Packed::default(), fine: Packed::default() }
    }
}

impl<const L: usize, C: Group<f32, L>, F: Group<f64, 4>> Precisions<L, C, F>
where
    f32: Grouped<L>,
{
    /// As [`Sweeps::release`].
    fn release(&mut self) {
        /// Bytes up to which memory is kept: the system takes longer to give it again than the step would to fill it.
        const MUCH: usize = 64 << 20;
        let Precisions { coarse, fine } = self;
        if size_of_val(&coarse.groups[..]) + size_of_val(&fine.groups[..]) > MUCH {
            *self = Self::default();
        }
    }

    fn run(
        &mut self,
        op: &mut BodyOperator,
        at: (&Blocks, &Tiled),
        settings: &SolverSettings,
        gamma: &mut [DVec3],
        response: &mut Response,
    ) -> Outcome {
        let Precisions { coarse, fine } = self;
        let is_exact = settings.friction == FrictionLaw::Exact;
        let course = Course::of(settings, op, gamma.len());
        let mut outcome = Outcome { iterations: 0, residual: f64::INFINITY };
        if op.joints.rows.is_empty() {
            coarse.fill(op, at, gamma, is_exact);
            if let Some(factor) = excess(op, |b| coarse.twist(at.1, b), |b| op.free(b)) {
                gamma.iter_mut().for_each(|g| *g *= factor);
                coarse.fill(op, at, gamma, is_exact);
            }
            let tolerance = COARSE * coarse.max_speed() / (gamma.len() as f64).sqrt();
            let course = Course { tolerance: settings.tolerance.max(tolerance), ..course };
            outcome = coarse.sweeps(&course, &at.1.flow);
            coarse.unpack(at, op.contacts.len(), gamma);
        } else if gamma.len() > settings.max_iterations(gamma.len()) as usize {
            op.response(&vec![DVec3::ZERO; gamma.len()], response);
            let free = std::mem::take(&mut response.twist);
            op.response(gamma, response);
            if let Some(factor) = excess(op, |b| response.twist[b], |b| free[b]) {
                gamma.iter_mut().for_each(|g| *g *= factor);
            }
        }
        op.joints.reset(response);
        if outcome.iterations < course.max && outcome.residual > settings.tolerance {
            fine.fill(op, at, gamma, is_exact);
            let course = Course { begun: outcome.iterations, ..course };
            outcome = if op.joints.rows.is_empty() {
                fine.sweeps(&course, &at.1.flow)
            } else {
                let mut solve_joints = |fine: &mut Packed<f64, 4, F>| {
                    fine.store(at.1, response);
                    op.solve_joints(response);
                    fine.load(at.1, response);
                };
                solve_joints(fine);
                fine.sweeps_in_turn(&course, solve_joints)
            };
            fine.unpack(at, op.contacts.len(), gamma);
            fine.store(at.1, response);
        } else {
            op.response(gamma, response);
        }
        outcome
    }
}

/// Where the impulses that a solve starts from add energy to the bodies, as those of an impact in the step after it, which would throw
/// them back: the factor at which they take the most. It is as that of `scale`, from the velocities of the bodies `after` these impulses and
/// `free` of them.
fn excess(
    op: &BodyOperator,
    after: impl Fn(usize) -> Twist + Sync,
    free: impl Fn(usize) -> Twist + Sync,
) -> Option<f64> {
    /// What is gained, over the energy and over that of a step of free fall: more than a few grains gain on their way, or a load that swings on a
    /// bed, which would go on for ever if it were pushed back.
    const GREAT: [f64; 2] = [0.02, 100.0];
    let masses = op.masses;
    let energy = |b: usize, twist: &Twist| masses.energy::<false>(b, twist);
    let fall = Twist { v: DVec3::X * op.least_slip, w: DVec3::ZERO };
    let n_bodies = masses.inv_mass.len();
    let [with, without, of_fall] =
        sum_rows(n_bodies, |b| [energy(b, &after(b)), energy(b, &free(b)), energy(b, &fall)]);
    let gain = with - without;
    if gain <= (GREAT[0] * with).max(GREAT[1] * of_fall) {
        return None;
    }
    let [curvature] = sum_rows(n_bodies, |b| [energy(b, &after(b).minus(&free(b)))]);
    let factor = 0.5 - 0.5 * gain / curvature;
    factor.is_finite().then(|| factor.max(0.0))
}

/// The course of the sweeps of a solve: over all tiles until the residual is within the tolerance, or the maximum number of iterations. While a
/// gap then still closes by more than its width faster than at `closing`, or the residual is above `lost`, sweeps over the tiles with such gaps
/// alternate with those over all, which are not over-relaxed, so that the last impulses are in their cones; not where `closing` is infinite.
#[derive(Clone, Copy)]
struct Course {
    friction: FrictionLaw,
    omega: f64,
    /// The maximum number of iterations, and that of those before these sweeps.
    max: u32,
    begun: u32,
    /// m/s.
    tolerance: f64,
    /// m/s.
    closing: f64,
    /// m/s.
    lost: f64,
    /// Number of multipliers.
    n: usize,
}

impl Course {
    /// Sweeps over some tiles between two over all.
    const LOCAL: u32 = 3;
    /// One sweep over all tiles.
    const ONCE: Course = Course {
        friction: FrictionLaw::Relaxed,
        omega: 1.0,
        max: 1,
        begun: 0,
        tolerance: 0.0,
        closing: f64::INFINITY,
        lost: f64::INFINITY,
        n: 1,
    };

    fn of(settings: &SolverSettings, op: &BodyOperator, n: usize) -> Course {
        Course {
            friction: settings.friction,
            omega: settings.omega.unwrap_or(1.0),
            max: settings.max_iterations(n),
            begun: 0,
            tolerance: settings.tolerance,
            closing: settings.overlap_tolerance.map_or(f64::INFINITY, |overlap| overlap / op.recovery.step),
            lost: settings.residual_bound(op.least_slip),
            n,
        }
    }

    /// The most sweeps that are over all tiles one after the other.
    fn in_a_row(&self) -> u32 {
        self.max.saturating_sub(self.begun)
    }

    /// The most sweeps.
    fn most(&self) -> u32 {
        let beyond = if self.closing.is_finite() { (SolverSettings::BEYOND - 1) * self.max } else { 0 };
        self.in_a_row() + beyond * (Self::LOCAL + 1)
    }

    /// Whether a sweep waits for what those before have left: it is the first one over some tiles.
    fn waits(&self, sweep: u32) -> bool {
        sweep.checked_sub(self.in_a_row()).is_some_and(|beyond| beyond.is_multiple_of(Self::LOCAL + 1))
    }

    /// Whether a sweep is over all tiles.
    fn is_over_all(&self, sweep: u32) -> bool {
        sweep < self.in_a_row() || self.waits(sweep + 1)
    }

    /// The relaxation factor of a sweep, and the speed of closing, m/s, in the tiles that it visits.
    fn of_sweep(&self, sweep: u32) -> [f64; 2] {
        match self.is_over_all(sweep) {
            true => [if self.closing.is_finite() { self.omega.min(1.0) } else { self.omega }, 0.0],
            false => [self.omega, self.closing],
        }
    }

    /// Whether what a sweep has left is enough: the residual terms of the blocks at the time of their visits, squared and summed, and the
    /// greatest speed at which a gap closed, m/s.
    fn is_enough(&self, sweep: u32, [residual2, fastest]: [f64; 2]) -> bool {
        let residual = self.residual(residual2);
        let is_calm = fastest <= self.closing && residual <= self.lost || self.closing.is_infinite();
        self.is_over_all(sweep) && (residual <= self.tolerance || sweep + 1 >= self.in_a_row() && is_calm)
    }

    fn residual(&self, residual2: f64) -> f64 {
        residual2.sqrt() / self.n as f64
    }

    /// The outcome of so many sweeps, of which the last has left that.
    fn outcome(&self, n_sweeps: u32, left: [f64; 2]) -> Outcome {
        let in_a_row = self.in_a_row().min(n_sweeps);
        let iterations = self.begun + in_a_row + (n_sweeps - in_a_row) / (Self::LOCAL + 1);
        Outcome { iterations, residual: self.residual(left[0]) }
    }
}

/// All blocks in groups, and the motions of the bodies.
struct Packed<T, const L: usize, G> {
    groups: Vec<G>,
    /// Number of groups of each tile of both rounds, and of each colour of the blocks in no tile.
    n_groups: [Vec<usize>; 3],
    /// The motions of the bodies at their places, and one of none.
    motion: Vec<Motion<T>>,
    /// The greatest speed at which a gap closed in each tile of both rounds when it was visited last, m/s.
    fastest: [Vec<f64>; 2],
}

impl<T, const L: usize, G> Default for Packed<T, L, G> {
    fn default() -> Self {
        Packed { groups: vec![], n_groups: Default::default(), motion: vec![], fastest: Default::default() }
    }
}

/// Number of groups up to which one thread visits them.
const SERIAL_LIMIT: usize = 512;

/// Number of groups that one task packs.
const TASK: usize = 32;

/// The least number of tasks that a thread packs, of so many groups.
fn min_tasks(n_groups: usize) -> usize {
    if n_groups < SERIAL_LIMIT { SERIAL_LIMIT / TASK } else { 1 }
}

impl<T: Grouped<L>, const L: usize, G: Group<T, L>> Packed<T, L, G> {
    /// Pack the blocks with the impulses γ, project these onto their cones, and compute the motions of the bodies with them.
    fn fill(&mut self, op: &BodyOperator, (blocks, tiled): (&Blocks, &Tiled), gamma: &[DVec3], is_exact: bool) {
        let (masses, n_bodies) = (op.masses, op.masses.inv_mass.len());
        let groups_of = |color: &[u32]| color.len().div_ceil(L);
        let of_round = |tiles: &[Colored]| tiles.iter().map(|tile| tile.colors().map(groups_of).sum()).collect();
        let [first, second] = &tiled.rounds;
        self.n_groups = [of_round(first), of_round(second), tiled.shared.colors().map(groups_of).collect()];
        let n_groups = self.n_groups.iter().flatten().sum();
        if self.groups.len() < n_groups {
            self.groups.resize(n_groups, G::empty(n_bodies));
        }
        let lanes: Vec<&[u32]> = tiled.colors().flat_map(|color| color.chunks(L)).collect();
        let pack = |groups: &mut [G], lanes: &[&[u32]]| {
            for (group, lanes) in groups.iter_mut().zip(lanes) {
                group.fill(op, lanes.iter().map(|block| blocks.contacts(*block)), gamma, is_exact);
                group.place(&tiled.place);
            }
        };
        self.motion.resize(n_bodies + 1, Motion::default());
        fill_rows(&mut self.motion[..n_bodies], |place| {
            let b = tiled.order[place] as usize;
            Motion::of(&op.free(b), masses.inv_mass[b], masses.inv_moment[b])
        });
        if self.can_flow() {
            // By the threads that will visit them.
            let pack = |first: usize, groups: &mut [G]| pack(groups, &lanes[first..]);
            self.flow::<{ act::APPLY }>(&tiled.flow, &Course::ONCE, pack);
        } else {
            let tasks = self.groups[..n_groups].par_chunks_mut(TASK).zip(lanes.par_chunks(TASK));
            tasks.with_min_len(min_tasks(n_groups)).for_each(|(groups, lanes)| pack(groups, lanes));
            self.visit::<{ act::APPLY }>(1.0, 0.0);
        }
    }

    /// The groups of each tile of both rounds, and of each colour of the blocks in no tile.
    fn parts(&mut self) -> [Vec<&mut [G]>; 3] {
        let mut rest = &mut self.groups[..];
        self.n_groups.each_ref().map(|lengths| {
            let (own, after) = std::mem::take(&mut rest).split_at_mut(lengths.iter().sum());
            rest = after;
            cut(own, lengths.iter().copied())
        })
    }

    /// Load the motions of the bodies from a response.
    fn load(&mut self, tiled: &Tiled, response: &Response) {
        for (motion, b) in self.motion.iter_mut().zip(&tiled.order) {
            *motion = Motion::of(&response.twist[*b as usize], motion.row[3].wide(), motion.row[7].wide());
        }
    }

    /// Store the motions of the bodies to a response.
    fn store(&self, tiled: &Tiled, response: &mut Response) {
        response.twist.resize(self.motion.len() - 1, Twist::default());
        fill_rows(&mut response.twist, |b| self.twist(tiled, b));
    }

    /// The velocities of a body.
    fn twist(&self, tiled: &Tiled, body: usize) -> Twist {
        self.motion[tiled.place[body] as usize].twist()
    }

    /// Maximum speed of a body, m/s.
    fn max_speed(&self) -> f64 {
        self.motion.iter().fold(0.0f64, |max, m| max.max(m.twist().v.length_squared())).sqrt()
    }

    /// Sweep, tiles waiting for their neighbours alone where that is worth it.
    fn sweeps(&mut self, course: &Course, flow: &Flow) -> Outcome {
        if !self.can_flow() {
            return self.sweeps_in_turn(course, |_| ());
        }
        let (n_sweeps, left) = match course.friction {
            FrictionLaw::Relaxed => self.flow::<{ act::RELAXED }>(flow, course, |_, _| ()),
            FrictionLaw::Exact => self.flow::<{ act::EXACT }>(flow, course, |_, _| ()),
        };
        course.outcome(n_sweeps, left)
    }

    /// Sweep, one after the other; `solve_joints` follows each.
    fn sweeps_in_turn(&mut self, course: &Course, mut solve_joints: impl FnMut(&mut Self)) -> Outcome {
        let (mut n_sweeps, mut left) = (0, [0.0; 2]);
        while n_sweeps < course.most() {
            let [omega, least] = course.of_sweep(n_sweeps);
            left = match course.friction {
                FrictionLaw::Relaxed => self.visit::<{ act::RELAXED }>(omega, least),
                FrictionLaw::Exact => self.visit::<{ act::EXACT }>(omega, least),
            };
            solve_joints(self);
            n_sweeps += 1;
            if course.is_enough(n_sweeps - 1, left) {
                break;
            }
        }
        course.outcome(n_sweeps, left)
    }

    /// Whether tiles are worth waiting for alone: there are many groups, and few of them in no tile, which one thread visits.
    fn can_flow(&self) -> bool {
        let [first, second, shared] = self.n_groups.each_ref().map(|n| n.iter().sum::<usize>());
        first + second >= SERIAL_LIMIT && shared <= (first + second) / 16
    }

    /// Visit the tiles sweep by sweep, as [`Packed::visit`] does, each waiting for its neighbours alone; `before` gets the first group of a tile and
    /// its groups before each visit. Returns the number of sweeps and what the last one has left.
    fn flow<const ACT: u8>(
        &mut self,
        flow: &Flow,
        course: &Course,
        before: impl Fn(usize, &mut [G]) + Sync,
    ) -> (u32, [f64; 2]) {
        let (mut motion, mut fastest) = (std::mem::take(&mut self.motion), std::mem::take(&mut self.fastest));
        let cells = Cells::new(&mut motion);
        for (fastest, n_groups) in fastest.iter_mut().zip(&self.n_groups) {
            fastest.resize(n_groups.len(), 0.0);
        }
        let [first, second, shared] = &self.n_groups;
        let lengths = first.iter().chain(second).copied().chain([shared.iter().sum()]);
        let firsts = lengths.clone().scan(0, |end, n| {
            let first = *end;
            *end += n;
            Some(first)
        });
        let tiles = firsts.zip(cut(&mut self.groups, lengths));
        let fastest_of = fastest.iter_mut().flatten().map(Some).chain([None]);
        let visit = |((first, groups), fastest): &mut ((usize, &mut [G]), Option<&mut f64>), sweep: u32| {
            before(*first, groups);
            let [omega, least] = course.of_sweep(sweep);
            if let Some(fastest) = fastest.as_ref().filter(|fastest| ***fastest < least) {
                return [0.0, **fastest];
            }
            // SAFETY: neighbours, which have moving bodies in common, are not visited at the same time.
            let visited = unsafe { group::visit::<T, L, G, ACT>(groups, &cells, omega) };
            if let Some(fastest) = fastest {
                **fastest = visited[1];
            }
            visited
        };
        let sweeps = flow::Sweeps {
            most: course.most(),
            waits: |sweep| course.waits(sweep),
            is_enough: |sweep, left| course.is_enough(sweep, left),
        };
        let swept = flow.run(&sweeps, tiles.zip(fastest_of).collect(), |((_, groups), _)| groups.len(), visit);
        (self.motion, self.fastest) = (motion, fastest);
        swept
    }

    /// Visit the blocks once: those of tiles in which a gap closed at `least`, m/s, or faster, and those in no tile. Returns what
    /// [`Group::visit`] does.
    fn visit<const ACT: u8>(&mut self, omega: f64, least: f64) -> [f64; 2] {
        /// Number of groups of a shared colour that one task visits.
        const TASK: usize = 128;
        let (mut motion, mut fastest) = (std::mem::take(&mut self.motion), std::mem::take(&mut self.fastest));
        let cells = Cells::new(&mut motion);
        // SAFETY: the tiles of a round, and the blocks of a shared colour, have no moving body in common.
        let visit = |groups: &mut [G]| unsafe { group::visit::<T, L, G, ACT>(groups, &cells, omega) };
        let visit_tile = |(groups, fastest): (&mut [G], &mut f64)| {
            if *fastest < least {
                return [0.0, *fastest];
            }
            let visited = visit(groups);
            *fastest = visited[1];
            visited
        };
        let and = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a + c, b.max(d)];
        let mut visited = [0.0; 2];
        let [first, second, shared] = self.parts();
        for (tiles, fastest) in [first, second].into_iter().zip(&mut fastest) {
            let is_serial = tiles.iter().map(|groups| groups.len()).sum::<usize>() < SERIAL_LIMIT;
            fastest.resize(tiles.len(), 0.0);
            let tiles = tiles.into_par_iter().zip(fastest);
            visited = and(visited, fold_tasks(tiles, is_serial, visit_tile, and));
        }
        for color in shared {
            let is_serial = color.len() < SERIAL_LIMIT;
            visited = and(visited, fold_tasks(color.par_chunks_mut(TASK), is_serial, visit, and));
        }
        (self.motion, self.fastest) = (motion, fastest);
        visited
    }

    /// Read the impulses of the contacts back, and the angular ones that follow them if there are any.
    fn unpack(&mut self, (blocks, tiled): (&Blocks, &Tiled), n_contacts: usize, gamma: &mut [DVec3]) {
        let rolls = gamma.len() > n_contacts;
        let gamma = Cells::new(gamma);
        let put = |group: &G, (l, k): (usize, usize), i: usize| {
            // SAFETY: each contact is in one block, and each group is one task's.
            unsafe { gamma.set(i, group.gamma(l, k)) };
            if let Some(roll) = group.roll(l, k).filter(|_| rolls) {
                // SAFETY: as above.
                unsafe { gamma.set(n_contacts + i, roll) };
            }
        };
        let lanes: Vec<&[u32]> = tiled.colors().flat_map(|color| color.chunks(L)).collect();
        let tasks = self.groups[..lanes.len()].par_chunks(TASK).zip(lanes.par_chunks(TASK));
        tasks.with_min_len(min_tasks(lanes.len())).for_each(|(groups, lanes)| {
            for (group, lanes) in groups.iter().zip(lanes) {
                for (l, block) in lanes.iter().enumerate() {
                    blocks.contacts(*block).enumerate().for_each(|(k, i)| put(group, (l, k), i));
                }
            }
        });
    }
}
