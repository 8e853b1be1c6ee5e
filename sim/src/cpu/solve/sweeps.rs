//! Gauss–Seidel sweeps on packed contacts, several blocks at a time: contacts between spheres (`sphere_group`), or manifolds, the contacts
//! of a pair of any shapes (`manifold_group`), by either law of friction. Contacts that roll with friction or stick have groups of their own
//! (`resistance`), so that others do not pay for them.
//!
//! The data of the blocks is packed once per solve, tile by tile and colour by colour (`schedule`), in groups of blocks that have no
//! body in common; a sweep streams through it. The first sweeps are in single precision, where a group has eight contacts of spheres or
//! sixteen manifolds and half the bytes; double precision follows once the residual is near the rounding error. The bodies' velocities are
//! then computed again from the impulses, so that the momentum has no rounding error of single precision.

use super::bodies::BodyOperator;
use super::group::{Group, Grouped};
use super::islands::{self, Slow};
use super::manifold_group::ManifoldGroup;
use super::operator::Operator;
use super::packed::{Packed, Which};
use super::response::Response;
use super::schedule::{Blocks, Tiled};
use super::sphere_group::SphereGroup;
use crate::contacts::Arms;
use crate::outcome::Outcome;
use crate::rows::sum_rows;
use crate::settings::{FrictionLaw, SolverSettings};
use crate::team::{self, Team};
use crate::twist::Twist;
use glam::DVec3;

/// Root mean square of the residual terms at which single precision ends, over the maximum speed of a body.
const COARSE: f64 = 1e-5;

/// The residual from which on islands of slow bodies are solved as a whole, and the error that is left of them, over that to which they are swept:
/// slow modes have far greater errors than residuals.
const SETTLED: f64 = 0.1;

/// Contacts up to which one thread visits them.
const FEW: usize = 1024;

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
    pace: team::Pace,
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
    let Sweeps { blocks, tiled, pace, spheres, manifolds, resisting_spheres, resisting_manifolds } = work;
    match op.contacts.arms {
        Arms::Along(_) => blocks.be_contacts(),
        Arms::Any(_) => blocks.be_manifolds(op.contacts),
    }
    tiled.fill(op.contacts, blocks, &op.masses.inv_mass);
    let at = (&*blocks, &*tiled);
    let is_small = op.contacts.len() <= FEW;
    team::gather(pace, is_small, |team| match (&op.contacts.arms, op.plan.resists()) {
        (Arms::Along(_), false) => spheres.run(team, op, at, settings, gamma, response),
        (Arms::Any(_), false) => manifolds.run(team, op, at, settings, gamma, response),
        (Arms::Along(_), true) => resisting_spheres.run(team, op, at, settings, gamma, response),
        (Arms::Any(_), true) => resisting_manifolds.run(team, op, at, settings, gamma, response),
    })
}

/// The packed blocks in single and in double precision.
struct Precisions<const L: usize, C: Group<f32, L>, F: Group<f64, 4>>
where
    f32: Grouped<L>,
{
    coarse: Packed<f32, L, C>,
    fine: Packed<f64, 4, F>,
}

impl<const L: usize, C: Group<f32, L>, F: Group<f64, 4>> Default for Precisions<L, C, F>
where
    f32: Grouped<L>,
{
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
        const MUCH: usize = 96 << 20;
        let Precisions { coarse, fine } = self;
        if coarse.size() + fine.size() > MUCH {
            *self = Self::default();
        }
    }

    fn run(
        &mut self,
        team: &Team,
        op: &mut BodyOperator,
        at: (&Blocks, &Tiled),
        settings: &SolverSettings,
        gamma: &mut [DVec3],
        response: &mut Response,
    ) -> Outcome {
        let Precisions { coarse, fine } = self;
        let is_exact = settings.friction == FrictionLaw::Exact;
        let slow = SolverSettings::SLOW * op.least_slip;
        let settling = settings.settling_tolerance.map(|residual| (residual, slow));
        let ends = Ends {
            tolerance: settings.tolerance,
            closing: settings.overlap_tolerance.map(|overlap| overlap / op.recovery.step),
            lost: settings.residual_bound(op.least_slip),
            settling: settling.filter(|_| matches!(op.contacts.arms, Arms::Any(_))),
        };
        let mut outcome = Outcome { iterations: 0, residual: f64::INFINITY };
        let mut unsettled = vec![];
        if op.joints.rows.is_empty() && fits_single(op) {
            coarse.fill(team, op, at, gamma, is_exact);
            if let Some(factor) = excess(op, |b| coarse.twist(at.1, b), |b| op.free(b)) {
                gamma.iter_mut().for_each(|g| *g *= factor);
                coarse.fill(team, op, at, gamma, is_exact);
            }
            let tolerance = COARSE * coarse.max_speed() / (gamma.len() as f64).sqrt();
            let ends = Ends { tolerance: settings.tolerance.max(tolerance), ..ends };
            coarse.sweeps(team, settings, gamma.len(), &ends, &mut outcome, |_| ());
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
            fine.fill(team, op, at, gamma, is_exact);
            let mut solve_joints = |fine: &mut Packed<f64, 4, F>| {
                if !op.joints.rows.is_empty() {
                    fine.store(at.1, response);
                    op.solve_joints(response);
                    fine.load(at.1, response);
                }
            };
            solve_joints(fine);
            fine.sweeps(team, settings, gamma.len(), &ends, &mut outcome, solve_joints);
            fine.unpack(at, op.contacts.len(), gamma);
            fine.store(at.1, response);
            unsettled = fine.unsettled(at, &ends);
        } else {
            op.response(gamma, response);
        }
        let can_be_solved = op.joints.rows.is_empty() && !op.plan.resists();
        if let Some((residual, _)) = ends.settling.filter(|_| can_be_solved) {
            let speeds = [settings.rest_speed, slow];
            let slow = Slow { blocks: unsettled, all: at.0, error: SETTLED * residual, speeds, is_exact };
            if islands::solve(op, &slow, gamma, response) {
                op.response(gamma, response);
            }
        }
        outcome
    }
}

/// Whether the squares of impulses stay within single precision.
fn fits_single(op: &BodyOperator) -> bool {
    /// The greatest momentum of a body before the solve, kg m/s: its square is 3e-9 of the greatest number.
    const MOST: f64 = 1e15;
    /// The mass up to which no speed is asked for, kg.
    const LIGHT: f64 = 1e9;
    let is_great = |b: usize| op.masses.inv_mass[b] > 0.0 && op.masses.inv_mass[b] < 1.0 / LIGHT;
    !(0..op.masses.inv_mass.len()).any(|b| is_great(b) && op.free(b).v.length() > MOST * op.masses.inv_mass[b])
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

impl<T: Grouped<L>, const L: usize, G: Group<T, L>> Packed<T, L, G> {
    /// Sweep until the residual is within the tolerance, or the maximum number of iterations. While a gap then still closes by more than its
    /// width too fast, or the residual is above `lost`, sweeps over the tiles with such gaps alternate with those over all, which are not
    /// over-relaxed, so that the last impulses are in their cones. Tiles of slow bodies whose contacts have too great a residual are swept on alone.
    /// Few contacts that are settled are swept on while the residual is above `lost`. `solve_joints` follows every sweep.
    fn sweeps(
        &mut self,
        team: &Team,
        settings: &SolverSettings,
        n: usize,
        ends: &Ends,
        outcome: &mut Outcome,
        mut solve_joints: impl FnMut(&mut Self),
    ) {
        /// Sweeps over some tiles between two over all.
        const LOCAL: u32 = 3;
        /// Visits of contacts that cost nothing: few contacts are swept on while they are lost.
        const CHEAP: usize = 20_000;
        let max = settings.max_iterations(n);
        let omega = settings.omega.unwrap_or(1.0);
        let of_all = if ends.closing.is_some() { omega.min(1.0) } else { omega };
        let mut is_lost = false;
        while outcome.iterations < SolverSettings::BEYOND * max || is_lost {
            if let Some(closing) = ends.closing.filter(|_| outcome.iterations >= max) {
                for _ in 0..LOCAL {
                    self.sweep(team, settings.friction, omega, Which::Closing(closing));
                    solve_joints(self);
                }
            }
            // The residual terms of the blocks at the time of their visits, squared and summed.
            let [residual2, fastest] = self.sweep(team, settings.friction, of_all, Which::All);
            *outcome = Outcome { iterations: outcome.iterations + 1, residual: residual2.sqrt() / n as f64 };
            solve_joints(self);
            if outcome.residual <= ends.tolerance {
                return;
            }
            let is_enough = ends.closing.is_none_or(|most| fastest <= most && outcome.residual <= ends.lost);
            let is_cheap = ends.settling.is_some() && outcome.iterations as usize * n < CHEAP;
            is_lost = outcome.residual > ends.lost && is_cheap;
            if outcome.iterations >= max && is_enough && !is_lost {
                break;
            }
        }
        let Some((residual, speed)) = ends.settling else { return };
        self.find_slow(speed);
        let which = Which::Unsettled(residual);
        let mut left = (SolverSettings::BEYOND * max).saturating_sub(outcome.iterations);
        while left > 0 && self.has(which) {
            self.sweep(team, settings.friction, of_all, which);
            solve_joints(self);
            left -= 1;
        }
    }

    /// The blocks of the tiles of slow bodies that the sweeps have left unsettled.
    fn unsettled(&self, (_, tiled): (&Blocks, &Tiled), ends: &Ends) -> Vec<u32> {
        let Some((residual, _)) = ends.settling else { return vec![] };
        self.blocks(tiled, Which::Unsettled(SETTLED * residual))
    }
}
