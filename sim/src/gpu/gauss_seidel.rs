//! Gauss–Seidel by tiles on a device: the bodies of a tile are loaded into the memory of a workgroup, its contacts are swept there colour by
//! colour several times, and all is written back once. The tiles of a round share no moving body; eight rounds have all pairs of spheres
//! that are not much larger than usual, and a last one the rest.
//! in     row       [n_contacts]
//! inout  gamma     [n_contacts]  N s, world
//! inout  motion    [n_bodies]    m/s, rad/s
//! Kernels: tile_start.wgsl, tile_sweep.wgsl, rest_sweep.wgsl, tile_decide.wgsl. Twin: cpu/solve/sweeps.rs, whose iteration is one sweep; here
//! it is one pass over the contacts in memory.
//!
//! Bytes of a contact and iteration: its row (48), its impulse read and written (32), its pair, colour and places (12): 92 from memory,
//! beside the bodies of the tiles, 32 bytes read and written for each tile that they are in.

use super::collision::Collision;
use super::fault::Fault;
use super::parts::{bits, kernel};
use super::problem::Problem;
use super::tiles::Tiles;
use crate::model::Model;
use crate::settings::FrictionLaw;
use gpu::{Bound, Buffer, Commands, Count, Device, Kernel, Kernels, Work};

/// Bytes of a contact and iteration from memory.
pub const BYTES: f64 = 92.0;

/// Sweeps of a tile for one pass over its contacts in memory.
pub const SWEEPS: u32 = 2;

/// Number of rounds of tiles.
const ROUNDS: usize = 8;

/// The columns of the method, and its kernels.
pub struct GaussSeidel {
    start: Kernel,
    sweep: Kernel,
    rest: Kernel,
    decide: Kernel,
    /// Workgroups of each round, and of the big tiles (9).
    work: Buffer<[u32; 4]>,
    /// Residual terms of each tile squared (n_tiles).
    moved: Buffer<f32>,
    /// Those of the big tiles (1).
    moved_rest: Buffer<f32>,
    columns: Columns,
    /// Sweeps, whether Coulomb's law is exact, and ω; the tolerance, m/s.
    params: [u32; 3],
    tolerance: f64,
}

/// The columns of a collision with tiles that the method reads.
struct Columns {
    touching: Buffer<u32>,
    place: Buffer<u32>,
    color: Buffer<u32>,
    local: Buffer<u32>,
    first: Buffer<u32>,
    body: Buffer<u32>,
    size: Buffer<[u32; 2]>,
    is_big: Buffer<u32>,
    big: Buffer<u32>,
    round_start: Buffer<u32>,
    n_big: Count,
    n_tiles: Count,
    n_pairs: Count,
}

impl Columns {
    fn of(collision: &Collision, tiles: &Tiles) -> Columns {
        let [touching, place] = collision.of_pairs();
        Columns {
            touching: touching.clone(),
            place: place.clone(),
            color: tiles.color.clone(),
            local: tiles.local.clone(),
            first: tiles.first.clone(),
            body: tiles.body.clone(),
            size: tiles.size.clone(),
            is_big: tiles.is_big.clone(),
            big: tiles.big.clone(),
            round_start: tiles.round_start.clone(),
            n_big: tiles.n_big.clone(),
            n_tiles: tiles.n.clone(),
            n_pairs: collision.n_pairs().clone(),
        }
    }
}

impl GaussSeidel {
    /// For the contacts of a collision, which must have tiles.
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        model: &Model,
        (problem, collision): (&Problem, &Collision),
    ) -> Result<GaussSeidel, Fault> {
        let get = |name, text| kernel(device, kernels, name, text);
        let tiles = collision.tiles().expect("pairs are in tiles");
        let settings = &model.solver;
        let is_exact = (settings.friction == FrictionLaw::Exact) as u32;
        Ok(GaussSeidel {
            start: get("tile_start", include_str!("tile_start.wgsl"))?,
            sweep: get("tile_sweep", include_str!("tile_sweep.wgsl"))?,
            rest: get("rest_sweep", include_str!("rest_sweep.wgsl"))?,
            decide: get("tile_decide", include_str!("tile_decide.wgsl"))?,
            work: Buffer::zeros(device, "work of tiles", ROUNDS + 1)?,
            moved: Buffer::zeros(device, "moved", problem.gamma.capacity())?,
            moved_rest: Buffer::zeros(device, "moved", 1)?,
            columns: Columns::of(collision, tiles),
            params: [SWEEPS, is_exact, bits(settings.omega.unwrap_or(1.0))],
            tolerance: settings.tolerance,
        })
    }

    /// Record the start.
    pub fn record_start(&self, device: &Device, commands: &mut Commands, problem: &Problem, iterations: Option<u32>) {
        let c = &self.columns;
        let counts = [c.round_start.bind(), c.n_big.n.bind(), problem.n_contacts.n.bind()];
        let bound = [problem.scalars.bind(), self.work.bind(), counts[0], counts[1], counts[2]];
        commands.dispatch(device, &self.start, &bound, &[iterations.unwrap_or(0)], Work::Groups(1));
    }

    /// Record iterations.
    pub fn record(&self, device: &Device, commands: &mut Commands, problem: &Problem, iterations: u32) {
        let c = &self.columns;
        let (row, motion, gamma) = (problem.row(), problem.motion.bind(), problem.gamma.bind());
        let (moved, moved_rest) = (self.moved.bind(), self.moved_rest.bind());
        let of_pairs = [row, c.touching.bind(), c.place.bind(), c.color.bind()];
        let (first, size) = (c.first.bind(), c.size.bind());
        let (n_tiles, n_pairs, start) = (c.n_tiles.n.bind(), c.n_pairs.n.bind(), c.round_start.bind());
        let of_tiles = [c.local.bind(), first, c.body.bind(), size, c.is_big.bind(), start, n_tiles, n_pairs];
        let of_sweep: Vec<Bound> = of_pairs.into_iter().chain(of_tiles).chain([motion, gamma, moved]).collect();
        let of_big = [first, size, c.big.bind(), c.n_big.n.bind(), n_tiles, n_pairs];
        let of_rest: Vec<Bound> = of_pairs.into_iter().chain(of_big).chain([motion, gamma, moved_rest]).collect();
        let counts = [start, problem.n_contacts.n.bind()];
        let of_decision = [moved, moved_rest, problem.scalars.bind(), self.work.bind(), counts[0], counts[1]];
        let [sweeps, is_exact, omega] = self.params;
        for _ in 0..iterations {
            for round in 0..ROUNDS {
                let params = [round as u32, sweeps, is_exact, omega];
                commands.dispatch(device, &self.sweep, &of_sweep, &params, Work::Indirect(&self.work, round));
            }
            let work = Work::Indirect(&self.work, ROUNDS);
            commands.dispatch(device, &self.rest, &of_rest, &self.params, work);
            let params = [bits(self.tolerance)];
            commands.dispatch(device, &self.decide, &of_decision, &params, Work::Groups(1));
        }
    }
}
