//! Ids of micropolygons in a bucket, as samples keep them.

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

    #[inline(always)]
    fn point(self) -> usize {
        (self.0 >> 1) as usize & ((1 << POINT_BITS) - 1)
    }

    /// Corners of the triangle, in rows of `nu` points.
    #[inline(always)]
    pub fn corners(self, nu: usize) -> [usize; 3] {
        let k = self.point();
        if self.0 & 1 == 0 { [k, k + 1, k + nu + 1] } else { [k, k + nu + 1, k + nu] }
    }
}
