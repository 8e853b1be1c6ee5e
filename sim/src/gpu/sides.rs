//! The sides of the contacts in the order of their bodies, which the solver sums over. Those of the pairs are sorted when pairs are found, and hold as
//! long as these; in each step those that touch are taken from them.
//! in   pairs       [n_pairs]
//! in   place       [n_pairs + 1]   number of contacts of the pairs before each pair
//! out  side        [2 n_contacts]  sorted by body: twice the contact, and one more for B
//! out  side_start  [n_bodies]      first side of each body that moves, and the end
//! Kernels: side_due.wgsl, side_pairs.wgsl, the sort, bin_clear.wgsl, bin_start.wgsl; side_count.wgsl, the scan, side_write.wgsl. Twin:
//! cpu/solve/bodies.rs

use super::bodies::Bodies;
use super::bounds::Due;
use super::fixtures::Fixtures;
use super::pair_write::Pairs;
use super::parts::{ROWS, groups, kernel};
use super::spheres::Spheres;
use gpu::radix_sort::RadixSort;
use gpu::scan::Scan;
use gpu::{Bound, Buffer, Commands, Count, Device, GpuError, Groups, Kernel, Kernels, Work};

/// The sides of the pairs.
#[derive(Clone)]
pub struct PairSides {
    /// Twice the pair, and one more for B (2 n_pairs).
    side: Buffer<u32>,
    /// First of these of each body, and the end (n_bodies).
    start: Buffer<[u32; 2]>,
}

/// What sorts the sides of the pairs.
pub struct PairOrder {
    sides: PairSides,
    body: Buffer<u32>,
    n_due: Count,
    bodies: Count,
    due: Kernel,
    pairs: Kernel,
    clear: Kernel,
    ends: Kernel,
    sort: RadixSort<u32>,
    groups: Groups,
}

impl PairOrder {
    /// With room for as many pairs as there is.
    pub fn new(device: &Device, kernels: &Kernels, n_bodies: usize, pairs: &Pairs) -> Result<PairOrder, GpuError> {
        let room = 2 * pairs.pairs.capacity();
        let get = |name, text| kernel(device, kernels, name, text);
        let sides = PairSides {
            side: Buffer::zeros(device, "sides of pairs", room)?,
            start: Buffer::zeros(device, "pair sides of bodies", n_bodies)?,
        };
        Ok(PairOrder {
            sides,
            body: Buffer::zeros(device, "bodies of sides", room)?,
            n_due: Count::found(device, room)?,
            bodies: Count::found(device, n_bodies)?,
            due: get("side_due", include_str!("side_due.wgsl"))?,
            pairs: get("side_pairs", include_str!("side_pairs.wgsl"))?,
            clear: get("bin_clear", include_str!("bin_clear.wgsl"))?,
            ends: get("bin_start", include_str!("bin_start.wgsl"))?,
            sort: RadixSort::new(device, kernels, room)?,
            groups: Groups::new(device, kernels, ROWS)?,
        })
    }

    /// The sides; once more room has been made they are others.
    pub fn sides(&self) -> &PairSides {
        &self.sides
    }

    /// Record the sides of the pairs, if these were found in this step.
    pub fn record(
        &self,
        device: &Device,
        commands: &mut Commands,
        (bodies, at, fixtures): (&Bodies, &Spheres, &Fixtures),
        (due, pairs): (&Due, &Pairs),
    ) {
        let (n_due, one) = (self.n_due.n.bind(), Work::Groups(1));
        let [body, side, start] = [self.body.bind(), self.sides.side.bind(), self.sides.start.bind()];
        let counts = [due.spheres.n.bind(), pairs.n.n.bind(), n_due, self.bodies.n.bind()];
        commands.dispatch(device, &self.due, &counts, &[bodies.n as u32], one);
        self.groups.record(device, commands, &self.n_due);
        let work = self.groups.of_level(&self.n_due, 0);
        let shapes = [pairs.pairs.bind(), at.sphere.bind(), fixtures.fixture.bind()];
        let bound: Vec<Bound> = shapes.into_iter().chain([bodies.mass.bind(), body, side, n_due]).collect();
        commands.dispatch(device, &self.pairs, &bound, &[], work);
        self.sort.record(device, commands, (&self.body, &self.sides.side), &self.n_due, bodies.n as u32);
        commands.dispatch(device, &self.clear, &[start, self.bodies.n.bind()], &[], groups(bodies.n));
        commands.dispatch(device, &self.ends, &[body, start, n_due], &[], work);
    }
}

/// The sides of the contacts.
pub struct Sides {
    of_pairs: PairSides,
    /// Number of contacts of the pairs before each pair (n_pairs + 1).
    place: Buffer<u32>,
    side: Buffer<u32>,
    start: Buffer<[u32; 2]>,
    number: Buffer<u32>,
    rows: Count,
    count: Kernel,
    write: Kernel,
    scan: Scan,
}

impl Sides {
    /// With room for this many contacts of as many bodies.
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        (of_pairs, place): (&PairSides, &Buffer<u32>),
        (n_bodies, room): (usize, usize),
    ) -> Result<Sides, GpuError> {
        let get = |name, text| kernel(device, kernels, name, text);
        Ok(Sides {
            of_pairs: of_pairs.clone(),
            place: place.clone(),
            side: Buffer::zeros(device, "sides", 2 * room)?,
            start: Buffer::zeros(device, "side_start", n_bodies)?,
            number: Buffer::zeros(device, "sides of bodies", n_bodies + 1)?,
            rows: Count::of(device, n_bodies + 1)?,
            count: get("side_count", include_str!("side_count.wgsl"))?,
            write: get("side_write", include_str!("side_write.wgsl"))?,
            scan: Scan::new(device, kernels, n_bodies + 1)?,
        })
    }

    /// Record the sides of the contacts that there are.
    pub fn record(&self, device: &Device, commands: &mut Commands, n_contacts: &Count) {
        let n_bodies = self.start.capacity();
        let own = [self.of_pairs.side.bind(), self.of_pairs.start.bind(), self.place.bind()];
        let [side, start, place] = own;
        let bound = [side, start, place, n_contacts.n.bind(), self.number.bind()];
        commands.dispatch(device, &self.count, &bound, &[], groups(n_bodies + 1));
        self.scan.record(device, commands, &self.number, &self.rows);
        let bound = [side, start, place, self.number.bind(), self.side.bind(), self.start.bind()];
        commands.dispatch(device, &self.write, &bound, &[], groups(n_bodies));
    }

    /// The sides, and the first of each body.
    pub fn bind(&self) -> [Bound<'_>; 2] {
        [self.side.bind(), self.start.bind()]
    }
}
