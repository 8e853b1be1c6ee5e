//! Tiles of spheres' caps that the device dices: what it is given of each, and of those of them that are shaded.

use crate::cpu::frame::Frame;
use crate::gprim::sphere::tile::CapSphere;
use crate::gpu::front::Cap;
use crate::gpu::kept::Kept;
use crate::gpu::kernels::{FrameKernels, groups};
use glam::{Mat4, Vec3};
use gpu::{Buffer, Commands, Device, GpuError, Work};
use std::sync::Arc;

/// Rows of a tile, and of what the tiles of a sphere have alike: `cap.wgsl` has what they are.
const ROWS: usize = 2;
const ALIKE: usize = 11;

/// Tiles that wait for their colours.
pub struct Caps {
    rows: Buffer<[u32; 4]>,
    spheres: Buffer<[u32; 4]>,
    rings: Buffer<[f32; 2]>,
    matrices: Buffer<[f32; 4]>,
    /// Least depths.
    least: Buffer<u32>,
    /// Tiles that were hidden, and micropolygons that are not there.
    left_out: Buffer<u32>,
    n: usize,
    n_spheres: usize,
    n_rings: usize,
    n_matrices: usize,
}

/// A tile, of points in rows, and where its points and micropolygons are: its first place, its first micropolygon, its first point, what its
/// micropolygons are, its track.
pub struct Placed<'a> {
    pub cap: &'a Cap,
    pub size: [usize; 2],
    pub place: usize,
    pub micropolygon: usize,
    pub point: usize,
    pub flags: u32,
    pub track: u32,
}

/// Where tiles are diced to: what kernels are told of the window, the depths of its blocks, points, micropolygons.
pub struct DiceGoal<'a> {
    pub head: [u32; 7],
    pub blocks: &'a Buffer<u32>,
    pub points: &'a Buffer<[f32; 4]>,
    pub micropolygons: &'a Buffer<[u32; 4]>,
}

impl Caps {
    /// None yet.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`].
    pub fn new(device: &Device, kept: &Kept, frame: &Frame<'_>) -> Result<Caps, GpuError> {
        let camera = columns(&frame.camera.to_camera);
        Ok(Caps {
            rows: kept.take(device, "caps", 1)?,
            spheres: kept.take(device, "spheres of caps", 1)?,
            rings: kept.take(device, "rings", 1)?,
            matrices: Buffer::of(device, "matrices to camera space", &camera)?,
            least: kept.take(device, "least depths of caps", 1)?,
            left_out: Buffer::zeros(device, "hidden caps", 2)?,
            n: 0,
            n_spheres: 0,
            n_rings: 0,
            n_matrices: camera.len(),
        })
    }

    /// Keep the buffers for another frame.
    pub fn keep(self, kept: &Kept) {
        kept.give("caps", self.rows);
        kept.give("spheres of caps", self.spheres);
        kept.give("rings", self.rings);
        kept.give("least depths of caps", self.least);
    }

    /// No tile waits any more.
    pub fn forget(&mut self) {
        (self.n, self.n_spheres, self.n_rings, self.n_matrices) = (0, 0, 0, 4);
    }

    /// Add tiles; the first of them and their count.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`].
    pub fn add(&mut self, device: &Device, tiles: &[Placed<'_>]) -> Result<[usize; 2], GpuError> {
        let (first, n) = (self.n, tiles.len());
        let mut rows = vec![[0; 4]; ROWS * n];
        let (mut spheres, mut rings, mut matrices) = (vec![], vec![], vec![]);
        let mut last: Option<&Cap> = None;
        // Tiles of a sphere are neighbours.
        for (rows, tile) in rows.as_chunks_mut().0.iter_mut().zip(tiles) {
            if last.is_none_or(|last| !last.is_alike(tile.cap)) {
                let starts = [self.n_rings + rings.len(), self.n_matrices + matrices.len()].map(|at| at as u32);
                spheres.extend(tile.cap.rows(starts));
                rings.extend_from_slice(&tile.cap.tile.sphere.rings);
                matrices.extend(tile.cap.to_camera.iter().flat_map(columns));
                last = Some(tile.cap);
            }
            *rows = tile.rows((self.n_spheres + spheres.len() / ALIKE - 1) as u32);
        }
        self.rows.reserve(device, ROWS * (first + n))?;
        self.spheres.reserve(device, ALIKE * self.n_spheres + spheres.len())?;
        self.rings.reserve(device, self.n_rings + rings.len())?;
        self.matrices.reserve(device, self.n_matrices + matrices.len())?;
        self.least.reserve(device, first + n)?;
        self.rows.write_from(device, ROWS * first, &rows);
        self.spheres.write_from(device, ALIKE * self.n_spheres, &spheres);
        self.rings.write_from(device, self.n_rings, &rings);
        self.matrices.write_from(device, self.n_matrices, &matrices);
        self.n += n;
        self.n_spheres += spheres.len() / ALIKE;
        self.n_rings += rings.len();
        self.n_matrices += matrices.len();
        Ok([first, n])
    }

    /// Record that tiles, a first one and their count, are diced, of which those behind the depths of blocks are left out if `culls`.
    pub fn dice(
        &self,
        device: &Device,
        goal: &DiceGoal<'_>,
        kernels: &FrameKernels,
        frame: &Frame<'_>,
        commands: &mut Commands,
        ([first, n], culls): ([usize; 2], bool),
    ) {
        let camera = &frame.camera;
        let [reach, inverse] = camera.focus().map_or([0.0; 2], |[reach, sharp]| [reach, 1.0 / sharp]);
        let [center, scale] = [camera.center, camera.scale];
        let numbers = [camera.near, camera.far, center.x, center.y, scale.x, scale.y, reach, inverse];
        let own = [first as u32, n as u32, culls as u32];
        let params: Vec<u32> =
            goal.head.into_iter().chain(own).chain(numbers.iter().map(|number| number.to_bits())).collect();
        let bound = [
            self.rows.bind(),
            self.spheres.bind(),
            self.rings.bind(),
            kernels.disk.bind(),
            self.matrices.bind(),
            goal.blocks.bind(),
            goal.points.bind(),
            goal.micropolygons.bind(),
            self.least.bind(),
            self.left_out.bind(),
        ];
        commands.stage("dice");
        commands.dispatch(device, &kernels.cap_dice, &bound, &params, groups(n, 1));
    }

    /// Record that values are given the points of tiles that are shaded: two rows of each tile, and a bit a point that is.
    pub fn give(
        &self,
        device: &Device,
        kernels: &FrameKernels,
        frame: &Frame<'_>,
        commands: &mut Commands,
        (given, wanted, values): (&Buffer<[u32; 4]>, &Buffer<u32>, &Buffer<f32>),
        n: usize,
    ) {
        let camera = &frame.camera;
        let scale = camera.scale.x.abs().max(camera.scale.y.abs());
        let numbers = camera.eye.to_array().into_iter().chain([scale, camera.near]).map(f32::to_bits);
        let params: Vec<u32> = [0; 8].into_iter().chain([n as u32]).chain(numbers).collect();
        let bound = [
            self.rows.bind(),
            self.spheres.bind(),
            self.rings.bind(),
            kernels.disk.bind(),
            self.least.bind(),
            given.bind(),
            wanted.bind(),
            values.bind(),
        ];
        commands.dispatch(device, &kernels.cap_points, &bound, &params, Work::Groups(n as u32));
    }

    /// Count of the tiles that were hidden so far, and of the micropolygons that were not there.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn left_out(&self, device: &Device) -> Result<[u64; 2], GpuError> {
        let all = self.left_out.read(device, 2)?;
        Ok([all[0], all[1]].map(u64::from))
    }
}

impl Placed<'_> {
    /// Its rows, of a sphere.
    fn rows(&self, sphere: u32) -> [[u32; 4]; ROWS] {
        let Placed { cap, size, place, micropolygon, point, flags, track } = self;
        let pair = |[x, y]: [u32; 2]| x & 0xffff | y << 16;
        let (first, size) = (pair(cap.tile.first.map(|k| k as u32)), pair(size.map(|n| n as u32)));
        [[*place as u32, *micropolygon as u32, *point as u32, *track], [first, size, sphere, *flags]]
    }
}

impl Cap {
    /// Whether another tile is of the same sphere.
    fn is_alike(&self, other: &Cap) -> bool {
        Arc::ptr_eq(&self.tile.sphere, &other.tile.sphere)
    }

    /// What the tiles of its sphere have alike, whose first ring and first row of a matrix are given.
    fn rows(&self, [ring, matrix]: [u32; 2]) -> [[u32; 4]; ALIKE] {
        let CapSphere { center, linear, normals, axes, outline, outward, .. } = &*self.tile.sphere;
        let number = |v: Vec3, w: f32| v.extend(w).to_array().map(f32::to_bits);
        let column = |v: Vec3| number(v, 0.0);
        let matrix = if self.to_camera.is_empty() { 0 } else { matrix };
        [
            [ring, outline.0 as u32, self.n_moments() as u32, matrix],
            number(*center, outline.1[0]),
            number(axes[0], outline.1[1]),
            number(axes[1], *outward),
            column(axes[2]),
            column(linear.x_axis),
            column(linear.y_axis),
            column(linear.z_axis),
            column(normals.x_axis),
            column(normals.y_axis),
            column(normals.z_axis),
        ]
    }
}

fn columns(m: &Mat4) -> [[f32; 4]; 4] {
    m.to_cols_array_2d()
}
