//! The camera: world → camera space → raster (pixels from the upper left corner), and bounds on the raster.

use crate::scene::options::Options;
use glam::{Mat4, Vec2, Vec3, Vec4};

/// A camera.
#[derive(Clone, Debug)]
pub struct Camera {
    /// World to camera: x right, y up, z into the image.
    pub to_camera: Mat4,
    /// The same later on, by the part of the time that the shutter is open then.
    pub moves: Vec<(f32, Mat4)>,
    /// Of a lens: how far blur reaches, pixels, at infinity if all is sharp there, times a unit of depth, and the depth that is
    /// sharp.
    lens: Option<[f32; 2]>,
    /// Radius of the lens, world.
    aperture: f32,
    /// Camera to world.
    pub to_world: Mat4,
    /// Where the eye is, world.
    pub eye: Vec3,
    /// Perspective, or orthographic.
    pub perspective: bool,
    /// Pixels for a unit of x/z and y/z, or of x and y.
    pub scale: Vec2,
    /// Raster point of the axis.
    pub center: Vec2,
    /// Screen point of the axis.
    shift: Vec2,
    /// Width and height of the screen window.
    window: Vec2,
    /// Least and greatest x/z and y/z that the image shows, with some room for filters.
    view: [Vec2; 2],
    /// Nearest depth.
    pub near: f32,
    /// The depth that is 0 in spaces of the image.
    depth_from: f32,
    /// Farthest depth.
    pub far: f32,
    /// Clipping planes cut away some of what it sees.
    pub clips: bool,
}

/// Nearest depth if no plane says.
const NEAREST: f32 = 1e-6;

/// A rectangle of the raster and the least depth of what is in it.
#[derive(Clone, Copy, Debug)]
pub struct RasterBound {
    /// Least corner, pixels.
    pub min: Vec2,
    /// Greatest corner, pixels.
    pub max: Vec2,
    /// Least depth.
    pub z: f32,
}

impl RasterBound {
    /// The bound of both.
    pub fn join(self, other: RasterBound) -> RasterBound {
        RasterBound { min: self.min.min(other.min), max: self.max.max(other.max), z: self.z.min(other.z) }
    }
}

impl Camera {
    /// The camera of the options and of the transformation that was current at `WorldBegin`, now and later on.
    pub fn new(options: &Options, to_camera: Mat4, moves: Vec<(f32, Mat4)>) -> Camera {
        let (w, h) = (options.width as f32, options.height as f32);
        let aspect = options.aspect();
        let window = options.screen_window.unwrap_or(if aspect >= 1.0 {
            [-aspect, aspect, -1.0, 1.0]
        } else {
            [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect]
        });
        let [left, right, bottom, top] = window;
        let half = options.fov.map_or(1.0, |fov| (fov.to_radians() * 0.5).tan());
        let per_unit = Vec2::new(w / (right - left), h / (top - bottom));
        let to_world = to_camera.inverse();
        let [factors, shift] = options.screen.map(Vec2::from);
        let scale = per_unit / half * factors;
        let center = Vec2::new(shift.x - left, top - shift.y) * per_unit;
        // The aperture's radius is half the focal length over the f-stop (RISpec 4.1.1); parallel rays have no focus.
        let lens = options
            .lens
            .filter(|_| options.fov.is_some())
            .map(|[f_stop, length, distance]| [0.5 * length / f_stop * scale.x.abs().max(scale.y.abs()), distance]);
        // As far as filters reach, and what is blurred beside the view.
        let room = Vec2::splat(32.0 + confusion(lens, options.clipping[0]).abs());
        let [a, b] = [(-center - room) / scale, (Vec2::new(w, h) - center + room) / scale];
        let view = [a.min(b), a.max(b)];
        Camera {
            // Raster y runs downwards, camera y upwards.
            view: [Vec2::new(view[0].x, -view[1].y), Vec2::new(view[1].x, -view[0].y)],
            clips: !options.clipping_planes.is_empty(),
            to_camera,
            moves,
            lens,
            aperture: options.lens.map_or(0.0, |[f_stop, length, _]| 0.5 * length / f_stop),
            to_world,
            eye: to_world.transform_point3(Vec3::ZERO),
            perspective: options.fov.is_some(),
            scale,
            center,
            shift,
            window: Vec2::new(right - left, top - bottom),
            near: if options.sees_near { NEAREST } else { options.clipping[0] },
            depth_from: options.clipping[0],
            far: options.clipping[1],
        }
    }

    /// The matrices from world to the spaces of the image: `screen`, `raster` in pixels and `NDC` from 0 to 1, both from the
    /// upper left corner. Depth goes from 0 at the near plane to 1 at the far one (RISpec 4.1).
    pub fn image_spaces(&self, options: &Options) -> [(&'static str, Mat4); 3] {
        let depth = 1.0 / (1.0 - self.depth_from / self.far);
        let screen_scale = self.scale * self.window / Vec2::new(options.width as f32, options.height as f32);
        // From camera space, before the division by what is the depth in perspective.
        let projection = |scale: Vec2, center: Vec2| {
            let (s, c) = (scale, center);
            let (x, y) = (Vec4::new(s.x, 0.0, 0.0, 0.0), Vec4::new(0.0, s.y, 0.0, 0.0));
            if self.perspective {
                Mat4::from_cols(
                    x,
                    y,
                    Vec4::new(c.x, c.y, depth, 1.0),
                    Vec4::new(0.0, 0.0, -self.depth_from * depth, 0.0),
                )
            } else {
                let step = depth / self.far;
                Mat4::from_cols(x, y, Vec4::new(0.0, 0.0, step, 0.0), Vec4::new(c.x, c.y, -self.depth_from * step, 1.0))
            }
        };
        let raster = projection(self.scale * Vec2::new(1.0, -1.0), self.center);
        let size = Vec3::new(1.0 / options.width as f32, 1.0 / options.height as f32, 1.0);
        let screen = projection(screen_scale, self.shift);
        [("screen", screen), ("raster", raster), ("NDC", Mat4::from_scale(size) * raster)]
            .map(|(name, m)| (name, m * self.to_camera))
    }

    /// The planes of a raster place and a depth that are those of camera space, for [`is_clipped`].
    pub fn raster_planes(&self, planes: &[Vec4]) -> Vec<RasterPlane> {
        let of = |plane: &Vec4| {
            let (x, y) = (plane.x / self.scale.x, -plane.y / self.scale.y);
            let constant = -x * self.center.x - y * self.center.y;
            if self.perspective {
                RasterPlane { by_depth: [x, y, constant + plane.z], by_place: [0.0, 0.0, plane.w] }
            } else {
                RasterPlane { by_depth: [0.0, 0.0, plane.z], by_place: [x, y, constant + plane.w] }
            }
        };
        planes.iter().map(of).collect()
    }

    /// Corners of the part of the raster that the image shows, with some room for filters.
    pub fn raster_view(&self) -> [Vec2; 2] {
        let [a, b] = self.view.map(|v| self.center + Vec2::new(v.x, -v.y) * self.scale);
        [a.min(b), a.max(b)]
    }

    /// Raster point of a camera-space point before the near plane.
    #[inline]
    pub fn project(&self, p: Vec3) -> Vec2 {
        let k = if self.perspective { 1.0 / p.z } else { 1.0 };
        Vec2::new(self.center.x + p.x * k * self.scale.x, self.center.y - p.y * k * self.scale.y)
    }

    /// How far a point at a depth is spread by the lens, pixels: the radius of its circle of confusion, negative before what is
    /// sharp.
    #[inline]
    pub fn confusion(&self, z: f32) -> f32 {
        confusion(self.lens, z.max(self.near))
    }

    /// How far a camera-space point moves on the raster; 0 if it goes behind the near plane.
    pub fn shift(&self, from: Vec3, to: Vec3) -> f32 {
        if to.z > self.near { (self.project(to) - self.project(from)).length() } else { 0.0 }
    }

    /// The radius of the lens, if there is one.
    pub fn lens_radius(&self) -> Option<f32> {
        self.lens.map(|_| self.aperture)
    }

    /// Of a lens: how far blur reaches, pixels, at infinity if all is sharp there, times a unit of depth, and the depth that is sharp.
    pub fn focus(&self) -> Option<[f32; 2]> {
        self.lens
    }

    /// Whether there is a lens.
    pub fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// Pixels that a unit length covers at a depth.
    #[inline]
    pub fn pixels_at(&self, z: f32) -> f32 {
        let scale = self.scale.x.abs().max(self.scale.y.abs());
        if self.perspective { scale / z.max(self.near) } else { scale }
    }

    /// The raster bound of a camera-space box, `None` if it is wholly out of the depth range. A box that reaches behind the
    /// near plane may be anywhere on the raster, unless all of it is beside the view.
    pub fn bound(&self, min: Vec3, max: Vec3) -> Option<RasterBound> {
        if !(max.z >= self.near && min.z <= self.far) {
            return None;
        }
        if self.perspective && min.z < self.near {
            for axis in 0..2 {
                // The view is widest where the box is deepest.
                let (lo, hi) = (self.view[0][axis], self.view[1][axis]);
                let most = (hi * max.z).max(hi * self.near);
                let least = (lo * max.z).min(lo * self.near);
                if min[axis] > most || max[axis] < least {
                    return None;
                }
            }
            return Some(RasterBound { min: Vec2::NEG_INFINITY, max: Vec2::INFINITY, z: self.near });
        }
        let (mut lo, mut hi) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for z in [min.z, max.z] {
            for corner in [Vec3::new(min.x, min.y, z), Vec3::new(max.x, max.y, z)] {
                let p = self.project(corner);
                lo = lo.min(p);
                hi = hi.max(p);
            }
        }
        let spread = self.confusion(min.z).abs().max(self.confusion(max.z).abs());
        Some(RasterBound { min: lo - spread, max: hi + spread, z: min.z })
    }

    /// The way from the eye to a point: the shading language's I. In parallel projection it comes from the eye's plane.
    #[inline]
    pub fn incident(&self, p: Vec3) -> Vec3 {
        if self.perspective {
            return p - self.eye;
        }
        self.to_world.transform_vector3(Vec3::Z) * self.to_camera.transform_point3(p).z.max(NEAREST)
    }
}

/// A plane over raster places and depths: factors of x, y and 1, those that count times the depth and those that count alone.
#[derive(Clone, Copy, Debug)]
pub struct RasterPlane {
    by_depth: [f32; 3],
    by_place: [f32; 3],
}

impl RasterPlane {
    /// Its factors: those that count times the depth, and those that count alone.
    pub fn rows(&self) -> [[f32; 3]; 2] {
        [self.by_depth, self.by_place]
    }
}

/// Whether a place on the raster at a depth lies on the clipped side of any plane.
pub fn is_clipped(planes: &[RasterPlane], [x, y]: [f32; 2], z: f32) -> bool {
    let at = |f: &[f32; 3]| f[0] * x + f[1] * y + f[2];
    planes.iter().any(|plane| at(&plane.by_depth) * z + at(&plane.by_place) > 0.0)
}

/// The radius of a lens's circle of confusion at a depth, as [`Camera::confusion`] has it.
fn confusion(lens: Option<[f32; 2]>, z: f32) -> f32 {
    lens.map_or(0.0, |[reach, sharp]| reach * (1.0 / sharp - 1.0 / z))
}
