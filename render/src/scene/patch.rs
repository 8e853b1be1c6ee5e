//! Bicubic Bézier patches with the values at their corners: what every primitive but a whole sphere becomes.

use crate::scene::interpolation::{bernstein, bernstein_slope, bilinear, lerp4};
use crate::scene::trim::Trim;
use crate::scene::variables::Varying;
use glam::Vec3;
use std::sync::Arc;

/// s and t of the corners of primitives if nothing else is said.
pub const TEXTURE_CORNERS: [f32; 8] = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0];

/// A bicubic Bézier patch with its corner values.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Control points, u fastest.
    pub p: [Vec3; 16],
    /// u and v at the corners (0,0), (1,0), (0,1), (1,1).
    pub uv: [[f32; 2]; 4],
    /// s and t at the corners.
    pub st: [[f32; 2]; 4],
    /// s and t where they follow control points and not the corners alone.
    pub curved_st: Option<Box<[Option<Varying>; 2]>>,
    /// Whether s and t are variables of the primitive, and not those of its parameters.
    pub own_st: [bool; 2],
    /// Varying variables. Names are the shape's.
    pub varying: Vec<Varying>,
    /// Variables that are the same all over.
    pub uniform: Vec<Vec<f32>>,
    /// Normals that the scene gives, which go before the patch's own.
    pub normals: Option<Box<Varying>>,
    /// Flat, so that it cannot shadow itself.
    pub flat: bool,
    /// What of it is cut away.
    pub trim: Option<Arc<Trim>>,
    /// Control points later on, by the part of the time that the shutter is open then.
    pub moves: Vec<(f32, [Vec3; 16])>,
}

impl Patch {
    /// The bilinear patch of four corners (0,0), (1,0), (0,1), (1,1), as a bicubic one.
    pub fn bilinear(c: [Vec3; 4]) -> Patch {
        let mut p = [Vec3::ZERO; 16];
        for (k, q) in p.iter_mut().enumerate() {
            let (u, v) = ((k % 4) as f32 / 3.0, (k / 4) as f32 / 3.0);
            *q = lerp4(c, u, v);
        }
        let normal = (c[1] - c[0]).cross(c[2] - c[0]).normalize_or_zero();
        let flat = (c[3] - c[0]).dot(normal).abs() <= 1e-5 * (c[3] - c[0]).length();
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        Patch { flat, ..Patch::of(p, corners) }
    }

    /// A bicubic patch over a range of parameters, which are its texture coordinates too.
    pub fn smooth(p: [Vec3; 16], u: [f32; 2], v: [f32; 2]) -> Patch {
        let corners = [[u[0], v[0]], [u[1], v[0]], [u[0], v[1]], [u[1], v[1]]];
        Patch::of(p, corners)
    }

    /// Set s and t to those that others at the corners (0,0), (1,0), (0,1), (1,1) of the parameters' unit square make, if the patch has
    /// none of its own.
    pub fn set_corners(&mut self, corners: &[f32; 8]) {
        if *corners == TEXTURE_CORNERS {
            return;
        }
        let (uv, st, own) = (self.uv, self.st, self.own_st);
        let unit = [0, 1, 2, 3].map(|k| [0, 1].map(|axis| if own[axis] { uv[k][axis] } else { st[k][axis] }));
        for axis in [0, 1].into_iter().filter(|axis| !self.own_st[*axis]) {
            let of = [0, 1, 2, 3].map(|k| corners[2 * k + axis]);
            self.st.iter_mut().zip(unit).for_each(|(st, [u, v])| st[axis] = bilinear(of, u, v));
        }
    }

    /// Whether it has the parameters, coordinates, normals and variables of another.
    pub fn has_values_of(&self, other: &Patch) -> bool {
        (self.uv, self.st, &self.curved_st) == (other.uv, other.st, &other.curved_st)
            && (&self.varying, &self.uniform, &self.normals) == (&other.varying, &other.uniform, &other.normals)
    }

    /// A patch without variables, whose parameters are its texture coordinates too.
    fn of(p: [Vec3; 16], corners: [[f32; 2]; 4]) -> Patch {
        Patch {
            p,
            uv: corners,
            st: corners,
            curved_st: None,
            own_st: [false; 2],
            varying: vec![],
            uniform: vec![],
            normals: None,
            flat: false,
            trim: None,
            moves: vec![],
        }
    }

    /// Give it variables that are a part `t` of the way from its own to those of the same patch at another time.
    pub fn blend_variables(&mut self, to: &Patch, t: f32) {
        let st = self.st.iter_mut().flatten().zip(to.st.iter().flatten());
        let uniform = self.uniform.iter_mut().zip(&to.uniform).flat_map(|(a, b)| a.iter_mut().zip(b));
        st.chain(uniform).for_each(|(a, b)| *a += (b - *a) * t);
        let curved = self.curved_st.iter_mut().zip(&to.curved_st).flat_map(|(a, b)| a.iter_mut().zip(b.iter()));
        let curved = curved.filter_map(|(a, b)| Some((a.as_mut()?, b.as_ref()?)));
        let normals = self.normals.as_deref_mut().zip(to.normals.as_deref());
        self.varying.iter_mut().zip(&to.varying).chain(curved).chain(normals).for_each(|(a, b)| a.blend(b, t));
    }

    /// A patch of other points, with the parameters, coordinates, normals and variables of this one between two parts of v.
    pub fn part(&self, p: [Vec3; 16], [a, b]: [f32; 2]) -> Patch {
        if [a, b] == [0.0, 1.0] {
            return Patch { p, ..self.clone() };
        }
        let between = |corners: [[f32; 2]; 4]| {
            let at = |u: usize, v: f32| [0, 1].map(|c| corners[u][c] * (1.0 - v) + corners[u + 2][c] * v);
            [at(0, a), at(1, a), at(0, b), at(1, b)]
        };
        Patch {
            p,
            uv: between(self.uv),
            st: between(self.st),
            curved_st: self
                .curved_st
                .as_deref()
                .map(|both| Box::new([0, 1].map(|axis| both[axis].as_ref().map(|values| values.part([a, b]))))),
            varying: self.varying.iter().map(|values| values.part([a, b])).collect(),
            normals: self.normals.as_deref().map(|values| Box::new(values.part([a, b]))),
            ..self.clone()
        }
    }

    /// The point at (u, v).
    pub fn at(&self, u: f32, v: f32) -> Vec3 {
        point_of(&self.p, u, v)
    }

    /// Derivatives along u and v.
    pub fn slopes(&self, u: f32, v: f32) -> (Vec3, Vec3) {
        let (bu, bv, du, dv) = (bernstein(u), bernstein(v), bernstein_slope(u), bernstein_slope(v));
        let sum = |x: [f32; 4], y: [f32; 4]| {
            (0..4).map(|j| (0..4).map(|i| self.p[4 * j + i] * x[i]).sum::<Vec3>() * y[j]).sum()
        };
        (sum(du, bv), sum(bu, dv))
    }

    /// The normal that the scene gives at (u, v).
    pub fn given_normal(&self, u: f32, v: f32) -> Option<Vec3> {
        let normals = self.normals.as_deref()?;
        Some(Vec3::from_array([0, 1, 2].map(|c| normals.at(c, u, v))))
    }

    /// s (axis 0) or t (axis 1) at (u, v).
    pub fn st_at(&self, axis: usize, u: f32, v: f32) -> f32 {
        match self.curved_st.as_deref().and_then(|both| both[axis].as_ref()) {
            Some(curved) => curved.at(0, u, v),
            None => bilinear(self.st.map(|c| c[axis]), u, v),
        }
    }

    /// The normal at (u, v): where the derivatives vanish, as at the tip of a triangle, that of a point nearby.
    pub fn normal(&self, u: f32, v: f32) -> Vec3 {
        let (du, dv) = self.slopes(u, v);
        self.normal_of(du, dv, u, v)
    }

    /// The normal at (u, v), whose derivatives are given.
    pub fn normal_of(&self, mut du: Vec3, mut dv: Vec3, mut u: f32, mut v: f32) -> Vec3 {
        for _ in 0..3 {
            let n = du.cross(dv);
            if n.length_squared() > 1e-12 * du.length_squared().max(dv.length_squared()).powi(2) {
                return n.normalize();
            }
            (u, v) = (u + (0.5 - u) * 0.02, v + (0.5 - v) * 0.02);
            (du, dv) = self.slopes(u, v);
        }
        Vec3::ZERO
    }
}

/// The point at (u, v) of the bicubic Bézier patch of some control points.
pub(crate) fn point_of(p: &[Vec3; 16], u: f32, v: f32) -> Vec3 {
    let (bu, bv) = (bernstein(u), bernstein(v));
    (0..4).map(|j| (0..4).map(|i| p[4 * j + i] * bu[i]).sum::<Vec3>() * bv[j]).sum()
}
