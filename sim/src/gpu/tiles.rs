//! The pairs in tiles: those of a tile lie together, in the order of their colours, and the tiles of a round share no moving body. Tiles are
//! made when pairs are found, and hold as long as these; the contacts of a step are in the same order.
//! in     fat_aabb     [n_spheres]   m, world
//! inout  pairs        [n_pairs]     in the order of tiles and colours out
//! out    tile_first   [n_tiles]     first pair of each tile
//! out    round_start  [10]          first tile of each round, and of the pairs in no tile
//! out    color        [n_pairs]     of spheres; of any shapes those of big tiles, since their pairs that touch are coloured in each step
//! out    local        [n_pairs]     places of the bodies in the tile's list; of a big tile, its pairs by their colours
//! out    tile_body    [2 n_pairs]   bodies of each tile; of a big one, the ends of its colours
//! out    tile_size    [n_tiles]     number of bodies; of a big one, of pairs without a colour, and of colours
//! out    big          [n_big]       tiles that do not fit a workgroup
//! Kernels: tile_due.wgsl, tile_key.wgsl, the sort, tile_pairs.wgsl, the compaction, tile_rounds.wgsl, tile_list.wgsl, tile_color.wgsl, tile_order.wgsl,
//! rest_color.wgsl.
//! Twin: cpu/pair_write.rs and cpu/solve/schedule.rs, which have two rounds of tiles, and what crosses both.

use super::bin_emit::Bins;
use super::bodies::Bodies;
use super::bounds::Due;
use super::fixtures::Fixtures;
use super::pair_write::Pairs;
use super::parts::{ROWS, bits, kernel};
use super::spheres::Spheres;
use crate::plan::Narrow;
use gpu::compact::Compact;
use gpu::radix_sort::RadixSort;
use gpu::{Bound, Buffer, Commands, Count, Device, GpuError, Groups, Kernel, Kernels, Work};

/// Volume of a tile over the usual one of a sphere's cube, and of the box about a shape of any kind: as many bodies as a workgroup has room for
/// where they are packed most densely, less a quarter, and of spheres as many contacts as a workgroup has registers for in a bed at rest. Spheres are packed by
/// up to 1.41 in a cube.
const CROWD: [f64; 2] = [235.0, 340.0];

/// Least edge of a tile over the usual width of a shape: neighbours are within a cube of one of the rounds.
const LEAST_EDGE: f64 = 2.5;

/// Moving bodies to a workgroup that takes the tiles of a round one after the other, and the most workgroups: enough to fill any device.
const BODIES_OF_GROUP: usize = 128;
const MOST_GROUPS: usize = 4096;

/// The most bodies of a tile that is not big, and of spheres in the rounds after the first: those of tile_most.wgsl.
const MOST_BODIES: u32 = 480;
const MOST_LATER: u32 = 224;

/// Ways to cut space into tiles: four where a quarter of a tile holds any pair, else eight.
const WAYS: [u32; 2] = [4, 8];

/// Pairs that there is room for, to a dispatch that lists the bodies of tiles, on a software adapter: more would keep it for too long.
const PIECE: usize = 12_500;

/// The bodies, moving shapes and fixtures of a collision.
type Shapes<'a> = (&'a Bodies, &'a Spheres, &'a Fixtures);

/// The tiles, with room for as many pairs as there is.
pub struct Tiles {
    /// First pair of each tile (n_tiles).
    pub first: Buffer<u32>,
    /// Number of tiles.
    pub n: Count,
    /// First tile of each round and of the pairs in no tile, and the end (10).
    pub round_start: Buffer<u32>,
    /// Colours of the pairs (n_pairs).
    color: Buffer<u32>,
    /// Places of a pair's bodies in the list of its tile, 16 bits each; the pairs of a big tile by their colours (n_pairs).
    pub local: Buffer<u32>,
    /// Bodies of each tile, or ends of the colours of a big one, from twice its first pair on (2 n_pairs).
    pub body: Buffer<u32>,
    /// Number of bodies of each tile; of a big one, number of pairs without a colour and of colours (n_tiles).
    pub size: Buffer<[u32; 2]>,
    /// Whether a tile does not fit a workgroup (n_tiles).
    is_big: Buffer<u32>,
    /// First pair of each tile, number of visits, place of the first body, and numbers of bodies and of colours (n_tiles).
    pub visited: Buffer<[u32; 4]>,
    /// Visits of each tile (n_pairs).
    pub order: Buffer<[u32; 2]>,
    /// The big tiles (n_big).
    pub big: Buffer<u32>,
    /// Their number.
    pub n_big: Count,
    kernels: TileKernels,
    sort: RadixSort<u32>,
    compact: [Compact; 2],
    groups: [Groups; 2],
    /// Number of dispatches that list the bodies of the tiles, each of them some.
    n_pieces: u32,
    /// Workgroups of a dispatch over tiles, which take one after the other.
    n_groups: u32,
    /// Whether colours last as long as the pairs: most pairs of spheres touch, and few of any shapes.
    is_lasting: bool,
    /// Number of rounds whose tiles workgroups of their own sweep: the ways to cut space, and where pairs may fit none of these, one for the rest.
    pub rounds: u32,
    ways: u32,
    home: Buffer<u32>,
    key: Buffer<u32>,
    id: Buffer<u32>,
    sorted: Buffer<[u32; 2]>,
    flag: Buffer<u32>,
    n_due: Count,
    n_colored: Count,
    claim: Buffer<u32>,
    edge: f64,
    /// Bits of the number of least bins along an edge.
    edge_bits: u32,
    /// Bits of the index of a tile's cube.
    cube_bits: u32,
}

struct TileKernels {
    due: Kernel,
    key: Kernel,
    pairs: Kernel,
    rounds: Kernel,
    list: Kernel,
    color: Kernel,
    order: Kernel,
    rest: Kernel,
}

impl Tiles {
    /// Workgroups of each of the dispatches over tiles, and their number: more than one where it would keep the adapter for too long. They take a quarter
    /// of the time of the pairs.
    pub fn pieces(&self) -> (u32, u32) {
        let n_pieces = self.n_pieces.div_ceil(4);
        (self.n_groups.div_ceil(n_pieces), n_pieces)
    }

    /// Record the visits to the pairs that touch, in steps in which there are tiles, unless they have lasting ones.
    pub fn record_touching(
        &self,
        device: &Device,
        commands: &mut Commands,
        shapes: Shapes,
        of: (&Pairs, &Buffer<u32>),
    ) {
        if !self.is_lasting {
            self.record_visits(device, commands, shapes, of, (&self.n, false));
        }
    }

    /// Record the colours of pairs, and their visits in the order of these.
    fn record_visits(
        &self,
        device: &Device,
        commands: &mut Commands,
        (_, at, fixtures): Shapes,
        (pairs, place): (&Pairs, &Buffer<u32>),
        (due, are_all): (&Count, bool),
    ) {
        let (n_groups, n_pieces) = self.pieces();
        let of_tiles = [self.first.bind(), self.size.bind(), self.is_big.bind(), self.round_start.bind()];
        let counts = [self.n.n.bind(), pairs.n.n.bind(), due.n.bind()];
        let from = [place.bind(), self.local.bind()].into_iter().chain(of_tiles).chain(counts);
        let colored: Vec<Bound> = from.clone().chain([self.color.bind()]).collect();
        let of_pairs = [pairs.pairs.bind(), at.sphere.bind(), fixtures.fixture.bind(), self.color.bind()];
        let ordered: Vec<Bound> = from.chain(of_pairs).chain([self.visited.bind(), self.order.bind()]).collect();
        for (kernel, bound) in [(&self.kernels.color, colored), (&self.kernels.order, ordered)] {
            for piece in 0..n_pieces {
                let params = [are_all as u32, piece, n_pieces, self.rounds];
                commands.dispatch(device, kernel, &bound, &params, Work::Groups(n_groups));
            }
        }
    }

    /// For the pairs of these spheres.
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        (spheres, bodies, bins): (&Spheres, &Bodies, &Bins),
        pairs: &Pairs,
    ) -> Result<Tiles, GpuError> {
        let room = pairs.pairs.capacity();
        let column = |name| Buffer::zeros(device, name, room);
        let get = |name, text| kernel(device, kernels, name, text);
        let mut home = vec![0; bodies.n];
        let of_body = spheres.bodies.iter().enumerate().rev();
        of_body.for_each(|(sphere, body)| home[*body as usize] = sphere as u32);
        let compact = |n| Compact::new(device, kernels, n);
        let crowd = CROWD[(bodies.layout.narrow == Narrow::Any) as usize];
        let edge = (crowd * spheres.volume).cbrt().max(LEAST_EDGE * spheres.width);
        let edge_bits = if edge < 4.0 * spheres.width { 1 } else { 2 };
        let ways = WAYS[(4.0 * spheres.longest > edge) as usize];
        // A tile of the first way has a body at least, one of another two, which the first has parted; one tile more has the pairs that fit none.
        let most_tiles = room.min((ways as usize + 1) * bodies.n / 2 + 1);
        let of_tiles = |name| Buffer::zeros(device, name, most_tiles);
        let n_pieces = if device.adapter.software { room.div_ceil(PIECE) as u32 } else { 1 };
        Ok(Tiles {
            first: of_tiles("tile_first")?,
            n: Count::found(device, most_tiles)?,
            round_start: Buffer::zeros(device, "round_start", 10)?,
            color: column("color")?,
            local: column("local")?,
            body: Buffer::zeros(device, "tile_body", 2 * room)?,
            size: Buffer::zeros(device, "tile_size", most_tiles)?,
            is_big: of_tiles("is_big")?,
            visited: Buffer::zeros(device, "tiles", most_tiles)?,
            order: Buffer::zeros(device, "order of visits", room)?,
            big: of_tiles("big")?,
            n_big: Count::found(device, most_tiles)?,
            kernels: TileKernels {
                due: get("tile_due", include_str!("tile_due.wgsl"))?,
                key: get("tile_key", include_str!("tile_key.wgsl"))?,
                pairs: get("tile_pairs", include_str!("tile_pairs.wgsl"))?,
                rounds: get("tile_rounds", include_str!("tile_rounds.wgsl"))?,
                list: get("tile_list", include_str!("tile_list.wgsl"))?,
                color: get("tile_color", include_str!("tile_color.wgsl"))?,
                order: get("tile_order", include_str!("tile_order.wgsl"))?,
                rest: get("rest_color", include_str!("rest_color.wgsl"))?,
            },
            sort: RadixSort::new(device, kernels, room)?,
            compact: [compact(room)?, compact(most_tiles)?],
            groups: [Groups::new(device, kernels, ROWS)?, Groups::new(device, kernels, n_pieces as usize)?],
            n_pieces,
            n_groups: bodies.n.div_ceil(BODIES_OF_GROUP).clamp(1, MOST_GROUPS) as u32,
            is_lasting: bodies.layout.narrow == Narrow::Spheres,
            ways,
            rounds: if ways == WAYS[0] { ways } else { ways + 1 },
            home: Buffer::of(device, "home", &home)?,
            key: column("tile_key")?,
            id: column("tile pairs")?,
            sorted: Buffer::zeros(device, "sorted pairs", room)?,
            flag: column("tile flags")?,
            n_due: Count::found(device, room)?,
            n_colored: Count::found(device, most_tiles)?,
            claim: Buffer::of(device, "claims", &vec![u32::MAX; bodies.n])?,
            edge,
            edge_bits,
            cube_bits: bins.most_bits - 3 * edge_bits,
        })
    }

    /// Record the tiles of the pairs, if these were found in this step.
    pub fn record(
        &self,
        device: &Device,
        commands: &mut Commands,
        (bodies, at, fixtures): Shapes,
        (due, bins, to, place): (&Due, &Bins, &Pairs, &Buffer<u32>),
    ) {
        let (kernels, one) = (&self.kernels, Work::Groups(1));
        let [n_due, n_tiles, n_big] = [&self.n_due, &self.n, &self.n_big].map(|count| count.n.bind());
        let [pairs, key, id] = [to.pairs.bind(), self.key.bind(), self.id.bind()];
        let shapes = [at.sphere.bind(), fixtures.fixture.bind(), bodies.activity.bind()];
        let [sphere, fixture, activity] = shapes;
        commands.dispatch(
            device,
            &kernels.due,
            &[due.spheres.n.bind(), to.n.n.bind(), n_due, n_tiles, n_big],
            &[],
            one,
        );
        let [of_pairs, of_tiles] = &self.groups;
        of_pairs.record(device, commands, &self.n_due);
        let work = of_pairs.of_level(&self.n_due, 0);
        let boxes = [self.home.bind(), at.fat_aabb.bind(), bins.grid.bind()];
        let bound: Vec<Bound> = [pairs].into_iter().chain(shapes).chain(boxes).chain([key, id, n_due]).collect();
        let params = [self.cube_bits, bits(self.edge), self.edge_bits, self.ways];
        commands.dispatch(device, &kernels.key, &bound, &params, work);
        self.sort.record(device, commands, (&self.key, &self.id), &self.n_due, 8 << self.cube_bits);
        let sorted = self.sorted.bind();
        commands.dispatch(device, &kernels.pairs, &[pairs, key, id, sorted, self.flag.bind(), n_due], &[], work);
        self.compact[0].record(device, commands, &self.flag, &self.n_due, &self.first, &self.n);
        let (first, start, n_colored) = (self.first.bind(), self.round_start.bind(), self.n_colored.n.bind());
        let bound = [key, first, n_tiles, n_due, start, n_colored];
        commands.dispatch(device, &kernels.rounds, &bound, &[self.cube_bits], one);
        of_tiles.record(device, commands, &self.n_colored);
        let n_pairs = to.n.n.bind();
        let (color, size, is_big) = (self.color.bind(), self.size.bind(), self.is_big.bind());
        let from = [sorted, sphere, fixture, activity, first, n_tiles, n_pairs, start];
        let out = [pairs, self.local.bind(), self.body.bind(), size, is_big];
        let bound: Vec<Bound> = from.into_iter().chain(out).collect();
        let most_later = if self.is_lasting { MOST_LATER } else { MOST_BODIES };
        for piece in 0..self.n_pieces {
            let params = [piece, self.n_pieces, self.rounds, most_later];
            commands.dispatch(device, &kernels.list, &bound, &params, of_tiles.of_level(&self.n_colored, 0));
        }
        if self.is_lasting {
            self.record_visits(device, commands, (bodies, at, fixtures), (to, place), (&self.n_colored, true));
        }
        self.compact[1].record(device, commands, &self.is_big, &self.n_colored, &self.big, &self.n_big);
        let from = [pairs, sphere, fixture, activity, first, n_tiles, n_pairs, n_colored];
        let lists = [self.local.bind(), self.body.bind()];
        let found = [self.big.bind(), n_big, self.claim.bind(), color];
        let out = found.into_iter().chain(lists).chain([size]);
        let bound: Vec<Bound> = from.into_iter().chain(out).collect();
        commands.dispatch(device, &kernels.rest, &bound, &[], one);
    }
}
