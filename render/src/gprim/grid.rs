//! Grids of micropolygons: what a dicer reads of an item, the grid that it fills, and where grids go.

use crate::gprim::sphere::tile::CapTile;
use crate::scene::camera::{Camera, RasterBound};
use crate::scene::motion::Instant;
use crate::scene::source::{Item, ItemView};
use glam::Vec3;
use sl::Global;
use sl::machine::Points;

/// An item to dice.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The item.
    pub item: Item,
    /// The item, looked up.
    pub view: &'a ItemView<'a>,
    /// Its moments.
    pub instants: &'a [Instant],
    /// The camera.
    pub camera: &'a Camera,
    /// Whether u, v, s, t and Ng are wanted, whatever the item's shaders read.
    pub parameters: bool,
}

impl Subject<'_> {
    /// Whether u, v, s and t of its points are wanted.
    pub fn needs_parameters(&self) -> bool {
        self.parameters || self.view.attributes.reads_parameters()
    }

    /// Whether the normals of the surface itself are wanted where others are given.
    pub fn needs_geometric_normal(&self) -> bool {
        self.parameters || self.view.attributes.reads(Global::Ng)
    }

    /// Whether some of the item may be visible; `box_at` is the camera-space box of that at a moment.
    pub fn may_show(&self, sink: &mut impl Sink, box_at: impl Fn(&Instant) -> (Vec3, Vec3)) -> bool {
        let bounds = self.instants.iter().filter_map(|i| {
            let (min, max) = box_at(i);
            self.camera.bound(min, max)
        });
        bounds.reduce(RasterBound::join).is_some_and(|b| sink.shows(&b))
    }
}

/// Where grids go.
pub trait Sink {
    /// Whether something within a bound may be visible: on the raster that is rendered, not hidden.
    fn shows(&mut self, bound: &RasterBound) -> bool;
    /// Take a grid; its memory is used again for the next.
    fn take(&mut self, grid: &mut Grid);
    /// Whether it takes what the camera does not see, too.
    fn takes_unseen(&self) -> bool {
        false
    }
    /// Whether it takes tiles of spheres' caps of this number of rings by what makes them.
    fn takes_caps(&self, _n_rings: usize) -> bool {
        false
    }
    /// Take such a tile, if it does: the grid has all but P and N.
    fn take_cap(&mut self, _cap: CapTile, _grid: &mut Grid) {}
}

/// A grid: points in rows, in world space, as a dicer leaves it.
#[derive(Default)]
pub struct Grid {
    /// P, N, Ng where it is wanted and another than N, and u, v, s, t where these are wanted; primitive variables in the slots of the item's view.
    pub points: Points,
    /// P before displacement, of the grid that was displaced last.
    pub undisplaced: Vec<f32>,
    /// How far each point is from where it was first, world space, at each moment of the item but the first: x of all, y of all,
    /// z of all. Empty if it keeps its form.
    pub deformed: Vec<Vec<f32>>,
    /// Micropolygons that are cut away; none if empty.
    pub trimmed: Vec<bool>,
    /// An extra ring of points all around, for derivatives, which is dropped after displacement.
    pub apron: bool,
    /// After displacement, points of an edge that its neighbour does not have are put onto the line between those that it has:
    /// by bits, the points that are kept of the edges at the first row, last row, first column, last column.
    pub keep: [u32; 4],
    /// How far its points may be displaced, world units.
    pub reach: f32,
    /// The part of a patch that it is.
    pub origin: Option<Origin>,
    /// The part of a sphere's lattice that it is: its face, and its first and last column and row.
    pub tile: Option<[u32; 5]>,
}

/// A part of a patch: the patch's index among those of its item, and ranges of its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    pub patch: u32,
    pub u: [f32; 2],
    pub v: [f32; 2],
}

impl Origin {
    /// Whether it reaches the edges of the patch: the least and the greatest u, the least and the greatest v.
    pub fn rims(&self) -> [bool; 4] {
        [self.u[0] == 0.0, self.u[1] == 1.0, self.v[0] == 0.0, self.v[1] == 1.0]
    }
}
