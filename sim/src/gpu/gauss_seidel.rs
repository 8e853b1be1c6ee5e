//! Gauss–Seidel by tiles on a device: the bodies of a tile are loaded into the memory of a workgroup, its contacts are swept there colour by
//! colour several times, and all is written back once. The tiles of a round share no moving body; four rounds, or eight, have all pairs of
//! shapes that are not much larger than usual, and a last one the rest. The joints are solved at the end of each iteration. Pairs of
//! spheres have colours as long as they hold. Of other shapes those that touch are coloured in each step: pairs that are near alone, about four of
//! five, would make twice as many colours.
//! in     row       [n_contacts]
//! inout  gamma     [n_contacts]  N s, world
//! inout  motion    [n_bodies]    m/s, rad/s
//! Kernels: tile_start.wgsl, tile_visits.wgsl, tile_sweep.wgsl, tile_sweep_later.wgsl, rest_sweep.wgsl and tile_end.wgsl for
//! spheres, visit_write.wgsl, tile_manifolds.wgsl and rest_manifolds.wgsl for shapes of any kind, joint_response.wgsl, tile_decide.wgsl, closing.wgsl and
//! closing_decide.wgsl. Twin: cpu/solve/sweeps.rs, whose iteration is one sweep; what is repeated here is a pass over the contacts in memory, [`passes`]. Where a gap
//! still closes too fast, all tiles are swept again, not those alone in which one does; tiles of slow bodies are swept on alone, as there.
//!
//! Bytes of a contact and iteration: of spheres its visit (48), its impulse read and written (32): 80 from memory, in the order in which they are
//! visited; of any shapes its row (64), its impulse read and written (32), its row of visits (16), and a share of its pair (20 of a pair): 117 where a
//! pair has four, and another 112 for each sweep after the first that the cache has lost them for. Beside them the bodies of the tiles, 32 bytes read and
//! written for each tile that they are in.

use super::collision::Collision;
use super::fault::Fault;
use super::parts::{bits, kernel_of};
use super::problem::Problem;
use super::tiles::Tiles;
use crate::plan::Narrow;
use crate::settings::{FrictionLaw, SolverSettings};
use gpu::{Bound, Buffer, Commands, Count, Device, GpuError, Kernel, Kernels, Work};

/// Bytes of a contact and iteration from memory: of spheres, and of any shapes.
pub const BYTES: [f64; 2] = [80.0, 117.0];

/// Sweeps of a tile for one pass over its contacts in memory: of spheres, which stay in registers, and of any shapes.
pub const SWEEPS: [u32; 2] = [4, 2];

/// Passes over the tiles for so many iterations, which are sweeps over all contacts. Four sweeps of spheres carry impulses through a tile and not
/// beyond it: in a bed at rest they leave as much overlap as two of the processor's (4,000 spheres; 8, 24 and 50 sweeps as 4.6, 12 and 25 passes). Of other
/// shapes an iteration is a pass.
pub fn passes(narrow: Narrow, iterations: u32) -> u32 {
    match narrow {
        Narrow::Spheres if iterations > 0 => iterations / 2 + 1,
        _ => iterations,
    }
}

/// The iterations that so many passes stand for: those of the settings, if these are even and all of them were made.
pub fn iterations_of(narrow: Narrow, passes: u32) -> u32 {
    match narrow {
        Narrow::Spheres if passes > 1 => 2 * (passes - 1),
        _ => passes,
    }
}

/// The columns of the method, and its kernels.
pub struct GaussSeidel {
    start: Kernel,
    visits: Visits,
    decide: Kernel,
    closing: Option<Closing>,
    /// The residual of slow bodies, of any shapes, up to which they are swept on, and their speed, m/s.
    settling: Option<[f64; 2]>,
    /// Workgroups of the joints and of `closing` (2).
    pub work: Buffer<[u32; 4]>,
    /// Residual terms of each tile squared (n_tiles).
    moved: Buffer<f32>,
    /// Those of the big tiles (1).
    moved_rest: Buffer<f32>,
    /// Workgroups of a dispatch over tiles, and the number of these dispatches, each of them some.
    n_groups: u32,
    n_pieces: u32,
    columns: Columns,
    /// Sweeps, whether Coulomb's law is exact, and ω; the tolerance, m/s.
    params: [u32; 3],
    tolerance: f64,
}

/// What decides whether iterations go on.
struct Closing {
    /// The speed at which gaps may close, and the residual that may be left, m/s.
    most: [f64; 2],
    measure: Kernel,
    decide: Kernel,
    /// As bits: the greatest speed at which a gap closes, m/s (1).
    fastest: Buffer<u32>,
}

/// The columns of visits to contacts of spheres.
struct SphereVisits {
    /// What the visits of each tile need of their contacts, their impulses, and the contacts, in their order (n_pairs).
    visits: Buffer<[u32; 12]>,
    impulses: Buffer<[f32; 4]>,
    contact_of: Buffer<u32>,
    /// The tiles with the numbers of their visits (n_tiles).
    swept: Buffer<[u32; 4]>,
}

/// The kernels of the visits.
enum Visits {
    /// Of contacts of spheres.
    Spheres {
        gather: Kernel,
        /// Of the first round, and of those after it.
        sweep: Kernel,
        later: Kernel,
        rest: Kernel,
        end: Kernel,
        columns: Box<SphereVisits>,
    },
    /// Of manifolds, the contacts of a pair of any shapes.
    Manifolds {
        write: Kernel,
        sweep: Kernel,
        rest: Kernel,
        /// Step lengths along the normal and the tangents, kg, and the normal's effect on both tangents, 1/kg (n_contacts).
        visits: Buffer<[f32; 4]>,
    },
}

impl Visits {
    fn new(device: &Device, kernels: &Kernels, problem: &Problem, tiles: &Tiles) -> Result<Visits, GpuError> {
        let get = |name, text| kernel_of(problem.layout, device, kernels, (name, text));
        Ok(match problem.layout.narrow {
            Narrow::Spheres => Visits::Spheres {
                gather: get("tile_visits", include_str!("tile_visits.wgsl"))?,
                sweep: get("tile_sweep", include_str!("tile_sweep.wgsl"))?,
                later: get("tile_sweep_later", include_str!("tile_sweep_later.wgsl"))?,
                rest: get("rest_sweep", include_str!("rest_sweep.wgsl"))?,
                end: get("tile_end", include_str!("tile_end.wgsl"))?,
                columns: Box::new(SphereVisits {
                    visits: Buffer::zeros(device, "visits", tiles.order.capacity())?,
                    impulses: Buffer::zeros(device, "impulses of visits", tiles.order.capacity())?,
                    contact_of: Buffer::zeros(device, "contacts of visits", tiles.order.capacity())?,
                    swept: Buffer::zeros(device, "swept tiles", tiles.visited.capacity())?,
                }),
            },
            Narrow::Any => Visits::Manifolds {
                write: get("visit_write", include_str!("visit_write.wgsl"))?,
                sweep: get("tile_manifolds", include_str!("tile_manifolds.wgsl"))?,
                rest: get("rest_manifolds", include_str!("rest_manifolds.wgsl"))?,
                visits: Buffer::zeros(device, "visits", problem.gamma.capacity())?,
            },
        })
    }

    /// The kernel over the tiles of a round.
    fn sweep(&self, round: u32) -> &Kernel {
        match self {
            Visits::Spheres { later, .. } if round > 0 => later,
            Visits::Spheres { sweep, .. } | Visits::Manifolds { sweep, .. } => sweep,
        }
    }

    /// The kernel over big tiles.
    fn rest(&self) -> &Kernel {
        let (Visits::Spheres { rest, .. } | Visits::Manifolds { rest, .. }) = self;
        rest
    }
}

/// The columns of a collision with tiles that the method reads.
struct Columns {
    place: Buffer<u32>,
    /// Number of rounds.
    rounds: u32,
    tile: Buffer<[u32; 4]>,
    order: Buffer<[u32; 2]>,
    local: Buffer<u32>,
    first: Buffer<u32>,
    body: Buffer<u32>,
    size: Buffer<[u32; 2]>,
    big: Buffer<u32>,
    round_start: Buffer<u32>,
    n_big: Count,
    n_tiles: Count,
    n_pairs: Count,
}

impl Columns {
    fn of(collision: &Collision, tiles: &Tiles) -> Columns {
        let [_, place] = collision.of_pairs();
        Columns {
            place: place.clone(),
            tile: tiles.visited.clone(),
            order: tiles.order.clone(),
            local: tiles.local.clone(),
            first: tiles.first.clone(),
            body: tiles.body.clone(),
            size: tiles.size.clone(),
            big: tiles.big.clone(),
            round_start: tiles.round_start.clone(),
            rounds: tiles.rounds,
            n_big: tiles.n_big.clone(),
            n_tiles: tiles.n.clone(),
            n_pairs: collision.n_pairs().clone(),
        }
    }
}

impl GaussSeidel {
    /// For the contacts of a collision, which must have tiles. `most` is the speed at which gaps may close and the residual that may be left, m/s,
    /// where iterations go on while there is more; `settling` the residual of slow bodies of any shapes and their speed, m/s, where tiles of them are
    /// swept on while theirs is greater.
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        (settings, most, settling): (&SolverSettings, Option<[f64; 2]>, Option<[f64; 2]>),
        (problem, collision): (&Problem, &Collision),
    ) -> Result<GaussSeidel, Fault> {
        let get = |name, text| kernel_of(problem.layout, device, kernels, (name, text));
        let tiles = collision.tiles().expect("pairs are in tiles");
        let is_exact = (settings.friction == FrictionLaw::Exact) as u32;
        let closing = |most| -> Result<Closing, Fault> {
            Ok(Closing {
                most,
                measure: get("closing", include_str!("closing.wgsl"))?,
                decide: get("closing_decide", include_str!("closing_decide.wgsl"))?,
                fastest: Buffer::zeros(device, "closing", 1)?,
            })
        };
        // Where iterations go on, the last are not over-relaxed.
        let omega = settings.omega.unwrap_or(1.0).min(if most.is_some() { 1.0 } else { f64::INFINITY });
        let columns = Columns::of(collision, tiles);
        let (n_groups, n_pieces) = tiles.pieces();
        Ok(GaussSeidel {
            closing: most.map(closing).transpose()?,
            settling: settling.filter(|_| problem.layout.narrow == Narrow::Any),
            start: get("tile_start", include_str!("tile_start.wgsl"))?,
            visits: Visits::new(device, kernels, problem, tiles)?,
            decide: get("tile_decide", include_str!("tile_decide.wgsl"))?,
            work: Buffer::zeros(device, "work of tiles", 2)?,
            moved: Buffer::zeros(device, "moved", tiles.first.capacity())?,
            moved_rest: Buffer::zeros(device, "moved", 1)?,
            n_groups,
            n_pieces,
            columns,
            params: [SWEEPS[problem.layout.narrow as usize], is_exact, bits(omega)],
            tolerance: settings.tolerance,
        })
    }

    /// Record the start.
    pub fn record_start(
        &self,
        device: &Device,
        commands: &mut Commands,
        (problem, collision): (&Problem, &Collision),
        settings: &SolverSettings,
    ) {
        collision.record_touching(device, commands);
        let c = &self.columns;
        let bound = [problem.scalars.bind(), self.work.bind(), problem.n_contacts.n.bind()];
        let params = [settings.iterations.unwrap_or(0), (problem.layout.narrow == Narrow::Spheres) as u32];
        commands.dispatch(device, &self.start, &bound, &params, Work::Groups(1));
        if let Visits::Spheres { gather, columns, .. } = &self.visits {
            let of_tiles = [c.tile.bind(), c.order.bind(), c.place.bind(), c.round_start.bind()];
            let of_contacts = [problem.row(), problem.motion.bind(), problem.gamma.bind()];
            let SphereVisits { visits, impulses, contact_of, swept } = &**columns;
            let out = [visits.bind(), impulses.bind(), contact_of.bind(), swept.bind()];
            let bound: Vec<Bound> = of_tiles.into_iter().chain(of_contacts).chain(out).collect();
            self.over_tiles(device, commands, (gather, &bound, &[self.params[1]]));
        }
        if let Visits::Manifolds { write, visits, .. } = &self.visits {
            let [mass, orientation] = problem.inertia();
            let bound = [problem.row(), mass, orientation, visits.bind(), problem.n_contacts.n.bind()];
            commands.dispatch(device, write, &bound, &[self.params[1]], problem.contacts());
        }
    }

    /// Record the end: the impulses of the contacts are those of their visits.
    pub fn record_end(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        if let Visits::Spheres { end, columns, .. } = &self.visits {
            let SphereVisits { impulses, contact_of, swept, .. } = &**columns;
            let round_start = self.columns.round_start.bind();
            let bound = [swept.bind(), contact_of.bind(), impulses.bind(), round_start, problem.gamma.bind()];
            self.over_tiles(device, commands, (end, &bound, &[]));
        }
    }

    /// Record a kernel over all tiles, whose parameters begin with the index of its dispatch, their number and that of the rounds.
    fn over_tiles(&self, device: &Device, commands: &mut Commands, (kernel, bound, more): (&Kernel, &[Bound], &[u32])) {
        for piece in 0..self.n_pieces {
            let params: Vec<u32> =
                [piece, self.n_pieces, self.columns.rounds].into_iter().chain(more.iter().copied()).collect();
            commands.dispatch(device, kernel, bound, &params, Work::Groups(self.n_groups));
        }
    }

    /// Whether iterations may go on beyond those of the settings.
    pub fn goes_beyond(&self) -> bool {
        self.closing.is_some() || self.settling.is_some()
    }

    /// Number of rounds of an iteration.
    pub fn rounds(&self) -> u32 {
        self.columns.rounds
    }

    /// As bits the squares of the residual of slow bodies and of their speed; zeros where sweeps do not go on for them.
    fn settling(&self) -> [u32; 2] {
        self.settling.map_or([0; 2], |most| most.map(|most| bits(most * most)))
    }

    /// Record a round of an iteration.
    pub fn record_round(&self, device: &Device, commands: &mut Commands, problem: &Problem, round: u32) {
        let [of_sweep, _] = self.bound(problem);
        let ([sweeps, is_exact, omega], sweep) = (self.params, self.visits.sweep(round));
        let settling = self.settling();
        // The law of spheres is in their visits.
        let n_params = if matches!(self.visits, Visits::Spheres { .. }) { 5 } else { 8 };
        for piece in 0..self.n_pieces {
            let params = [round, piece, self.n_pieces, sweeps, omega, is_exact, settling[0], settling[1]];
            commands.dispatch(device, sweep, &of_sweep, &params[..n_params], Work::Groups(self.n_groups));
        }
    }

    /// Record what follows the rounds of an iteration: big tiles and pairs in none, the joints, and whether there is another.
    pub fn record_rest(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        let c = &self.columns;
        let [_, of_rest] = self.bound(problem);
        let counts = [c.round_start.bind(), problem.n_contacts.n.bind()];
        let scalars = problem.scalars.bind();
        let moved = [self.moved.bind(), self.moved_rest.bind()];
        let of_decision = [moved[0], moved[1], scalars, self.work.bind(), counts[0], counts[1]];
        let (rest, settling) = (self.visits.rest(), self.settling());
        let n_params = if matches!(self.visits, Visits::Spheres { .. }) { 7 } else { 10 };
        // Without joints the last kernel decides whether another iteration follows.
        let beyond = if self.settling.is_some() { SolverSettings::BEYOND } else { 0 };
        let deciding = [bits(self.tolerance), self.closing.is_some() as u32, c.rounds, beyond];
        let decides = problem.joints.is_none() as u32;
        let params: Vec<u32> = self.params.into_iter().chain([decides]).chain(deciding).chain(settling).collect();
        commands.dispatch(device, rest, &of_rest, &params[..n_params], Work::Groups(1));
        if let Some(joints) = &problem.joints {
            let work = Work::Indirect(&self.work, 0);
            joints.record_more(device, commands, &problem.of_joints(), work);
            commands.dispatch(device, &self.decide, &of_decision, &deciding, Work::Groups(1));
        }
    }

    /// The commands, under the name of a stage, that decide after an iteration whether there are more than those of the settings, where there may be.
    pub fn closing(&self, device: &Device, problem: &Problem, stage: &'static str) -> Option<Commands> {
        let closing = self.closing.as_ref()?;
        let mut commands = Commands::new();
        commands.stage(stage);
        let fastest = closing.fastest.bind();
        let bound = [problem.row(), problem.motion.bind(), fastest, problem.n_contacts.n.bind()];
        commands.dispatch(device, &closing.measure, &bound, &[], Work::Indirect(&self.work, 1));
        let stands_for_two = (problem.layout.narrow == Narrow::Spheres) as u32;
        let params = [bits(closing.most[0]), bits(closing.most[1]), SolverSettings::BEYOND, stands_for_two];
        let bound = [fastest, problem.scalars.bind(), self.work.bind()];
        commands.dispatch(device, &closing.decide, &bound, &params, Work::Groups(1));
        Some(commands)
    }

    /// What the kernels over tiles and over big tiles bind.
    fn bound<'a>(&'a self, problem: &'a Problem) -> [Vec<Bound<'a>>; 2] {
        let c = &self.columns;
        let (row, motion, gamma, scalars) =
            (problem.row(), problem.motion.bind(), problem.gamma.bind(), problem.scalars.bind());
        let (moved, moved_rest) = (self.moved.bind(), self.moved_rest.bind());
        let (place, first, size) = (c.place.bind(), c.first.bind(), c.size.bind());
        let (n_tiles, n_pairs) = (c.n_tiles.n.bind(), c.n_pairs.n.bind());
        let of_tiles = [c.body.bind(), c.round_start.bind(), motion];
        let of_decision = [moved, c.round_start.bind(), self.work.bind(), problem.n_contacts.n.bind(), scalars];
        let of_big = [c.local.bind(), c.body.bind(), first, size, c.big.bind(), c.n_big.n.bind(), n_tiles, n_pairs];
        let [mass, orientation] = problem.inertia();
        let [roll, roll_row] = problem.rolling();
        match &self.visits {
            Visits::Spheres { columns, .. } => {
                let SphereVisits { visits, impulses, swept, .. } = &**columns;
                let sweep =
                    [visits.bind(), swept.bind()].into_iter().chain(of_tiles).chain([impulses.bind(), moved, scalars]);
                let rest = [row, place].into_iter().chain(of_big);
                [sweep.collect(), rest.chain([motion, gamma, moved_rest]).chain(of_decision).collect()]
            }
            Visits::Manifolds { visits, .. } => {
                let own = [row, visits.bind(), place];
                let of_bodies = [mass, orientation, roll, roll_row];
                let sweep =
                    own.into_iter().chain([c.order.bind(), c.tile.bind()]).chain(of_tiles).chain([gamma, moved]);
                let rest = own.into_iter().chain(of_big).chain([motion, gamma, moved_rest]);
                let sweep = sweep.chain(of_bodies).chain([scalars]);
                [sweep.collect(), rest.chain(of_bodies).chain(of_decision).collect()]
            }
        }
    }
}
