//! Ids of micropolygons in a bucket, as samples keep them, and identities, which every back end gives them alike.

use crate::scene::source::Item;
use sl::Global;
use sl::machine::Points;

/// One triangle of a micropolygon of a grid of the bucket: the grid's index, the index of its first point, and which of the
/// two triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Micropolygon(u32);

/// Bits of a point's index.
pub const POINT_BITS: u32 = 11;

impl Micropolygon {
    /// None.
    pub const NONE: Micropolygon = Micropolygon(u32::MAX);

    /// Of a grid, a first point, and which triangle.
    #[inline(always)]
    pub fn new(grid: usize, point: usize, second: bool) -> Micropolygon {
        Micropolygon((grid << (POINT_BITS + 1) | point << 1 | second as usize) as u32)
    }

    /// It as an id.
    #[inline(always)]
    pub fn id(self) -> u32 {
        self.0
    }

    /// Of [`Self::id`].
    #[inline(always)]
    pub fn from_id(id: u32) -> Micropolygon {
        Micropolygon(id)
    }

    /// The grid.
    #[inline(always)]
    pub fn grid(self) -> usize {
        (self.0 >> (POINT_BITS + 1)) as usize
    }

    /// Its first point.
    #[inline(always)]
    pub fn point(self) -> usize {
        (self.0 >> 1) as usize & ((1 << POINT_BITS) - 1)
    }

    /// Whether it is the second of the two triangles.
    #[inline(always)]
    pub fn is_second(self) -> bool {
        self.0 & 1 == 1
    }

    /// Corners of the triangle, in rows of `nu` points.
    #[inline(always)]
    pub fn corners(self, nu: usize) -> [usize; 3] {
        let k = self.point();
        if self.is_second() { [k, k + nu + 1, k + nu] } else { [k, k + 1, k + nu + 1] }
    }
}

/// The identity of a triangle of a grid: a hash of its item and of where its corners are in the world; never 0.
pub fn identity(item: Item, points: &Points, corners: [usize; 3]) -> u64 {
    let (n, p) = (points.n(), points.get(Global::P).unwrap_or(&[]));
    let places = corners.into_iter().flat_map(|k| (0..3).map(move |c| c * n + k));
    identity_of(item, places.map(|at| p.get(at).map_or(0, |x| x.to_bits())))
}

/// The identity of a triangle of an item, by the numbers of its corners, as bits.
pub fn identity_of(item: Item, numbers: impl Iterator<Item = u32>) -> u64 {
    let mixed = |x: u64, y: u32| {
        let x = (x ^ y as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x ^ x >> 29
    };
    [item.source, item.index].into_iter().chain(numbers).fold(1, mixed).max(1)
}
