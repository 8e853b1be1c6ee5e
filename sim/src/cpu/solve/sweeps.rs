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
use super::group::{self, Group, Grouped, Motion, act};
use super::islands::{self, Slow};
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

/// The residual from which on islands of slow bodies are solved as a whole, and the error that is left of them, over that to which they are swept:
/// slow modes have far greater errors than residuals.
const SETTLED: f64 = 0.1;

/// Where sweeps end.
struct Ends {
    /// The residual, m/s.
    tolerance: f64,
    /// The speed at which a gap may close by more than its width after the sweeps of the settings, m/s.
    closing: Option<f64>,
    /// The residual above which gaps are not looked at, m/s.
    lost: f64,
    /// The residual of the contacts of a tile, m/s, where its bodies are no faster than the second, m/s.
    settling: Option<(f64, f64)>,
}

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
        let settling = settings.settling_tolerance.map(|residual| (residual, SolverSettings::SLOW * op.least_slip));
        let ends = Ends {
            tolerance: settings.tolerance,
            closing: settings.overlap_tolerance.map(|overlap| overlap / op.recovery.step),
            lost: settings.residual_bound(op.least_slip),
            settling: settling.filter(|_| matches!(op.contacts.arms, Arms::Any(_))),
        };
        let mut outcome = Outcome { iterations: 0, residual: f64::INFINITY };
        let mut unsettled = vec![];
        if op.joints.rows.is_empty() {
            coarse.fill(op, at, gamma, is_exact);
            if let Some(factor) = excess(op, |b| coarse.motion[b].twist(), |b| op.free(b)) {
                gamma.iter_mut().for_each(|g| *g *= factor);
                coarse.fill(op, at, gamma, is_exact);
            }
            let tolerance = COARSE * coarse.max_speed() / (gamma.len() as f64).sqrt();
            let ends = Ends { tolerance: settings.tolerance.max(tolerance), ..ends };
            coarse.sweeps(settings, gamma.len(), &ends, &mut outcome, |_| ());
            coarse.unpack(at, op.contacts.len(), gamma);
            unsettled = coarse.unsettled(at, &ends);
        } else if gamma.len() > settings.max_iterations(gamma.len()) as usize {
            op.response(&vec![DVec3::ZERO; gamma.len()], response);
            let free = std::mem::take(&mut response.twist);
            op.response(gamma, response);
            if let Some(factor) = excess(op, |b| response.twist[b], |b| free[b]) {
                gamma.iter_mut().for_each(|g| *g *= factor);
            }
        }
        op.joints.reset(response);
        if outcome.iterations < settings.max_iterations(gamma.len()) && outcome.residual > settings.tolerance {
            fine.fill(op, at, gamma, is_exact);
            let mut solve_joints = |fine: &mut Packed<f64, 4, F>| {
                if !op.joints.rows.is_empty() {
                    fine.store(response);
                    op.solve_joints(response);
                    fine.load(response);
                }
            };
            solve_joints(fine);
            fine.sweeps(settings, gamma.len(), &ends, &mut outcome, solve_joints);
            fine.unpack(at, op.contacts.len(), gamma);
            fine.store(response);
            unsettled = fine.unsettled(at, &ends);
        } else {
            op.response(gamma, response);
        }
        let can_be_solved = op.joints.rows.is_empty() && !op.plan.resists() && !unsettled.is_empty();
        if let Some((residual, _)) = ends.settling.filter(|_| can_be_solved) {
            let speeds = [settings.rest_speed, op.least_slip];
            let slow = Slow { blocks: unsettled, all: at.0, error: SETTLED * residual, speeds, is_exact };
            if islands::solve(op, &slow, gamma, &response.twist) {
                op.response(gamma, response);
            }
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

/// All blocks in groups, and the motions of the bodies.
struct Packed<T, const L: usize, G> {
    groups: Vec<G>,
    /// Number of groups of each tile of both rounds, and of each colour of the blocks in no tile.
    n_groups: [Vec<usize>; 3],
    motion: Vec<Motion<T>>,
    /// The tiles of both rounds.
    tiles: [Vec<Tile>; 2],
    /// The blocks in no tile, as if they were one.
    shared: Tile,
}

/// What is known of a tile.
#[derive(Clone, Copy, Default)]
struct Tile {
    n_contacts: f64,
    /// What [`Group::visit`] returned when it was visited last.
    visited: [f64; 2],
    /// Whether its bodies are slow.
    is_slow: bool,
}

/// Which tiles a sweep visits; the blocks in no tile it does in any case.
#[derive(Clone, Copy)]
enum Which {
    All,
    /// Those in which a gap closed at this speed, m/s, or faster.
    Closing(f64),
    /// Those of slow bodies whose contacts had a greater residual than this in the root mean square, m/s.
    Unsettled(f64),
}

impl Which {
    fn has(self, tile: &Tile) -> bool {
        let [residual2, closing] = tile.visited;
        match self {
            Which::All => true,
            Which::Closing(least) => closing >= least,
            Which::Unsettled(residual) => tile.is_slow && residual2 > residual * residual * tile.n_contacts,
        }
    }
}

impl<T, const L: usize, G> Default for Packed<T, L, G> {
    fn default() -> Self {
        Packed {
            groups: vec![],
            n_groups: Default::default(),
            motion: vec![],
            tiles: Default::default(),
            shared: Tile::default(),
        }
    }
}

/// Number of groups up to which one thread visits them.
const SERIAL_LIMIT: usize = 512;

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
        let [first, second, shared] = self.parts();
        for (parts, tiles) in [first, second].into_iter().zip(&tiled.rounds) {
            let tiles = parts.into_par_iter().zip(tiles).with_max_len(1);
            tiles.for_each(|(groups, tile)| pack(groups, tile.colors(), op, blocks, gamma, is_exact));
        }
        let colors = shared.into_iter().zip(tiled.shared.colors());
        colors.for_each(|(groups, color)| pack(groups, [color].into_iter(), op, blocks, gamma, is_exact));
        let contacts = |block: &u32| blocks.contacts(*block).len();
        let tile = |blocks: &Colored| Tile {
            n_contacts: blocks.colors().flatten().map(contacts).sum::<usize>() as f64,
            ..Tile::default()
        };
        for (own, tiles) in self.tiles.iter_mut().zip(&tiled.rounds) {
            own.clear();
            own.extend(tiles.iter().map(tile));
        }
        self.shared = tile(&tiled.shared);
        self.motion.resize(n_bodies + 1, Motion::default());
        fill_rows(&mut self.motion[..n_bodies], |b| Motion::of(&op.free(b), masses.inv_mass[b], masses.inv_moment[b]));
        self.visit::<{ act::APPLY }>(1.0, Which::All);
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
    fn load(&mut self, response: &Response) {
        for (motion, twist) in self.motion.iter_mut().zip(&response.twist) {
            *motion = Motion::of(twist, motion.row[3].wide(), motion.row[7].wide());
        }
    }

    /// Store the motions of the bodies to a response.
    fn store(&self, response: &mut Response) {
        response.twist.resize(self.motion.len() - 1, Twist::default());
        fill_rows(&mut response.twist, |b| self.motion[b].twist());
    }

    /// Maximum speed of a body, m/s.
    fn max_speed(&self) -> f64 {
        self.motion.iter().fold(0.0f64, |max, m| max.max(m.twist().v.length_squared())).sqrt()
    }

    /// Sweep until the residual is within the tolerance, or the maximum number of iterations. While a gap then still closes by more than its
    /// width too fast, or the residual is above `lost`, sweeps over the tiles with such gaps alternate with those over all, which are not
    /// over-relaxed, so that the last impulses are in their cones. Tiles of slow bodies whose contacts have too great a residual are swept on alone.
    /// `solve_joints` follows every sweep.
    fn sweeps(
        &mut self,
        settings: &SolverSettings,
        n: usize,
        ends: &Ends,
        outcome: &mut Outcome,
        mut solve_joints: impl FnMut(&mut Self),
    ) {
        /// Sweeps over some tiles between two over all.
        const LOCAL: u32 = 3;
        let max = settings.max_iterations(n);
        let omega = settings.omega.unwrap_or(1.0);
        let of_all = if ends.closing.is_some() { omega.min(1.0) } else { omega };
        while outcome.iterations < SolverSettings::BEYOND * max {
            if let Some(closing) = ends.closing.filter(|_| outcome.iterations >= max) {
                for _ in 0..LOCAL {
                    self.sweep(settings.friction, omega, Which::Closing(closing));
                    solve_joints(self);
                }
            }
            // The residual terms of the blocks at the time of their visits, squared and summed.
            let [residual2, fastest] = self.sweep(settings.friction, of_all, Which::All);
            *outcome = Outcome { iterations: outcome.iterations + 1, residual: residual2.sqrt() / n as f64 };
            solve_joints(self);
            if outcome.residual <= ends.tolerance {
                return;
            }
            let is_enough = ends.closing.is_none_or(|most| fastest <= most && outcome.residual <= ends.lost);
            if outcome.iterations >= max && is_enough {
                break;
            }
        }
        let Some((residual, speed)) = ends.settling else { return };
        self.find_slow(speed);
        let which = Which::Unsettled(residual);
        let mut left = (SolverSettings::BEYOND * max).saturating_sub(outcome.iterations);
        while left > 0 && self.tiles.iter().flatten().chain([&self.shared]).any(|tile| which.has(tile)) {
            self.sweep(settings.friction, of_all, which);
            solve_joints(self);
            left -= 1;
        }
    }

    /// The blocks of the tiles of slow bodies that the sweeps have left unsettled.
    fn unsettled(&self, (_, tiled): (&Blocks, &Tiled), ends: &Ends) -> Vec<u32> {
        let Some((residual, _)) = ends.settling else { return vec![] };
        let which = Which::Unsettled(SETTLED * residual);
        let tiles = self.tiles.iter().zip(&tiled.rounds).flat_map(|(tiles, blocks)| tiles.iter().zip(blocks));
        let own = tiles.chain([(&self.shared, &tiled.shared)]).filter(|(tile, _)| which.has(tile));
        own.flat_map(|(_, blocks)| blocks.colors().flatten().copied()).collect()
    }

    /// Find the tiles of slow bodies, which are no faster than a speed, m/s.
    fn find_slow(&mut self, speed: f64) {
        let (motion, mut tiles) = (std::mem::take(&mut self.motion), std::mem::take(&mut self.tiles));
        let is_slow = |body: &u32| motion[*body as usize].twist().v.length_squared() <= speed * speed;
        let are_slow = |groups: &[G]| groups.iter().all(|group| group.bodies().as_flattened().iter().all(is_slow));
        let [first, second, shared] = self.parts();
        for (parts, tiles) in [first, second].into_iter().zip(&mut tiles) {
            parts.into_iter().zip(tiles).for_each(|(groups, tile)| tile.is_slow = are_slow(groups));
        }
        let is_slow = shared.into_iter().all(|groups| are_slow(groups));
        (self.motion, self.tiles, self.shared.is_slow) = (motion, tiles, is_slow);
    }

    /// Visit the blocks of some tiles once, and those in no tile. Returns what [`Group::visit`] does.
    fn sweep(&mut self, friction: FrictionLaw, omega: f64, which: Which) -> [f64; 2] {
        match friction {
            FrictionLaw::Relaxed => self.visit::<{ act::RELAXED }>(omega, which),
            FrictionLaw::Exact => self.visit::<{ act::EXACT }>(omega, which),
        }
    }

    fn visit<const ACT: u8>(&mut self, omega: f64, which: Which) -> [f64; 2] {
        /// Number of groups of a shared colour that one task visits.
        const TASK: usize = 128;
        let (mut motion, mut tiles) = (std::mem::take(&mut self.motion), std::mem::take(&mut self.tiles));
        let cells = Cells::new(&mut motion);
        // SAFETY: the tiles of a round, and the blocks of a shared colour, have no moving body in common.
        let visit = |groups: &mut [G]| unsafe { group::visit::<T, L, G, ACT>(groups, &cells, omega) };
        let visit_tile = |(groups, tile): (&mut [G], &mut Tile)| {
            if !which.has(tile) {
                return [0.0, tile.visited[1]];
            }
            tile.visited = visit(groups);
            tile.visited
        };
        let and = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a + c, b.max(d)];
        let mut visited = [0.0; 2];
        let [first, second, shared] = self.parts();
        for (parts, tiles) in [first, second].into_iter().zip(&mut tiles) {
            let is_serial = parts.iter().map(|groups| groups.len()).sum::<usize>() < SERIAL_LIMIT;
            let tiles = parts.into_par_iter().zip(tiles);
            visited = and(visited, fold_tasks(tiles, is_serial, visit_tile, and));
        }
        let mut of_shared = [0.0; 2];
        for color in shared {
            let is_serial = color.len() < SERIAL_LIMIT;
            of_shared = and(of_shared, fold_tasks(color.par_chunks_mut(TASK), is_serial, visit, and));
        }
        (self.motion, self.tiles, self.shared.visited) = (motion, tiles, of_shared);
        and(visited, of_shared)
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
        let read = |groups: &[G], color: &[u32]| {
            for (group, color) in groups.iter().zip(color.chunks(L)) {
                for (l, block) in color.iter().enumerate() {
                    blocks.contacts(*block).enumerate().for_each(|(k, i)| put(group, (l, k), i));
                }
            }
        };
        let [first, second, shared] = self.parts();
        for (parts, tiles) in [first, second].into_iter().zip(&tiled.rounds) {
            let tiles = parts.into_par_iter().zip(tiles).with_max_len(1);
            tiles.for_each(|(mut groups, tile)| {
                for color in tile.colors() {
                    let (own, after) = std::mem::take(&mut groups).split_at_mut(color.len().div_ceil(L));
                    groups = after;
                    read(own, color);
                }
            });
        }
        shared.into_iter().zip(tiled.shared.colors()).for_each(|(groups, color)| read(groups, color));
    }
}

/// Pack the blocks of some colours into groups.
fn pack<'a, T: Grouped<L>, const L: usize, G: Group<T, L>>(
    groups: &mut [G],
    colors: impl Iterator<Item = &'a [u32]>,
    op: &BodyOperator,
    blocks: &Blocks,
    gamma: &[DVec3],
    is_exact: bool,
) {
    for (group, color) in groups.iter_mut().zip(colors.flat_map(|color| color.chunks(L))) {
        group.fill(op, color.iter().map(|block| blocks.contacts(*block)), gamma, is_exact);
    }
}
