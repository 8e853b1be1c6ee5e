//! Where rays meet surfaces: place, normals and parameters there.

use crate::cpu::mesh::Spot;
use crate::scene::facets::place_on;
use crate::scene::interpolation::bilinear;
use crate::scene::patch::Patch;
use crate::scene::shape::{Shape, sphere_uv};
use crate::scene::source::ItemView;
use glam::{Mat3, Vec3};

/// Where a ray meets something, world space.
#[derive(Clone, Copy)]
pub struct Hit {
    pub from: Vec3,
    pub dir: Vec3,
    pub distance: f32,
}

/// A surface where a ray meets it, world space.
pub struct Met<'a> {
    pub place: Vec3,
    pub normal: Vec3,
    /// The normal of the surface itself.
    pub geometric: Vec3,
    /// Place and both normals before the surface was displaced.
    pub before: [Vec3; 3],
    pub uv: [f32; 2],
    pub st: [f32; 2],
    /// The patch that was met, and where in its parameters.
    pub on: Option<(&'a Patch, [f32; 2])>,
}

impl Met<'_> {
    /// Whether the uniform variables here are those of another place.
    pub fn has_uniform_of(&self, other: &Met) -> bool {
        match (self.on, other.on) {
            (Some((a, _)), Some((b, _))) => a.uniform == b.uniform,
            (a, b) => a.is_none() && b.is_none(),
        }
    }
}

/// An item where a ray meets it.
pub fn meet<'a>(view: &ItemView<'a>, &Hit { from, dir, distance }: &Hit) -> Met<'a> {
    let place = from + dir * distance;
    let normals = Mat3::from_mat4(view.to_world).inverse().transpose();
    match view.shape {
        Shape::Sphere => {
            let d = view.to_world.inverse().transform_point3(place).normalize_or_zero();
            let uv = sphere_uv(d);
            let normal = (normals * d).normalize_or_zero();
            Met { place, normal, geometric: normal, before: [place, normal, normal], uv, st: uv, on: None }
        }
        Shape::Patches(patches, _) => {
            let inverse = view.to_world.inverse();
            let (o, d) = (inverse.transform_point3(from), inverse.transform_vector3(dir));
            let at = inverse.transform_point3(place);
            let found = patches.iter().filter_map(|p| Some((place_on(p, o, d, at)?, p)));
            let nearest = found.min_by(|a, b| a.0.0.total_cmp(&b.0.0)).map(|((_, spot), patch)| (patch, spot));
            let Some((patch, [u, v])) = nearest.or_else(|| spot_near(patches, at)) else {
                let before = [place, -dir, -dir];
                let uv = [0.0; 2];
                return Met { place, normal: -dir, geometric: -dir, before, uv, st: uv, on: None };
            };
            let both = both_normals(patch, [u, v]).map(|m| (normals * m).normalize_or_zero());
            met_on(patch, [u, v], place, both)
        }
    }
}

/// The normal of an item that is flat all over, world space.
pub fn flat_normal(view: &ItemView<'_>) -> Option<Vec3> {
    let Shape::Patches(patches, _) = view.shape else { return None };
    let [patch] = patches.as_slice() else { return None };
    let corner = |k: usize| view.to_world.transform_point3(patch.p[k]);
    patch.flat.then(|| (corner(3) - corner(0)).cross(corner(12) - corner(0)).normalize_or_zero())
}

/// Parts along u and along v at whose ends [`spot_near`] looks at a patch first, and how often it halves these then.
const PARTS: usize = 8;
const HALVINGS: usize = 12;

/// Where the patches of an item are nearest to a place, all in their own space: rounding may have put it just beside all of them, as at a
/// seam. None of what has no area.
fn spot_near(patches: &[Patch], at: Vec3) -> Option<(&Patch, [f32; 2])> {
    let part = |k: usize| k as f32 / PARTS as f32;
    let spots = (0..(PARTS + 1) * (PARTS + 1)).map(|k| [part(k % (PARTS + 1)), part(k / (PARTS + 1))]);
    let off = |patch: &Patch, [u, v]: [f32; 2]| (patch.at(u, v) - at).length_squared();
    let all = patches.iter().flat_map(|patch| spots.clone().map(move |spot| (patch, spot)));
    let has_normal = |(patch, [u, v]): &(&Patch, [f32; 2])| patch.normal(*u, *v) != Vec3::ZERO;
    let (patch, mut best) = all.filter(has_normal).min_by(|a, b| off(a.0, a.1).total_cmp(&off(b.0, b.1)))?;
    let mut step = 0.5 / PARTS as f32;
    for _ in 0..HALVINGS {
        let [u, v] = best;
        let beside = [[u - step, v], [u + step, v], [u, v - step], [u, v + step]];
        let beside = beside.map(|spot| spot.map(|x| x.clamp(0.0, 1.0)));
        best =
            beside.into_iter().fold(best, |best, spot| if off(patch, spot) < off(patch, best) { spot } else { best });
        step *= 0.5;
    }
    has_normal(&(patch, best)).then_some((patch, best))
}

/// A displaced item where a ray meets its mesh.
pub fn meet_displaced<'a>(view: &ItemView<'a>, hit: &Hit, spot: &Spot) -> Met<'a> {
    let place = hit.from + hit.dir * hit.distance;
    // The mesh has the normals that shaders have, which turn with the orientation.
    let normal = if view.attributes.reversed { -spot.normal } else { spot.normal };
    let facet = if view.to_world.determinant() < 0.0 { -spot.facet } else { spot.facet };
    let patches = match view.shape {
        Shape::Patches(patches, _) => patches.as_slice(),
        Shape::Sphere => &[],
    };
    if let Some((k, uv)) = spot.on
        && let Some(patch) = patches.get(k as usize)
    {
        let normals = Mat3::from_mat4(view.to_world).inverse().transpose();
        let [u, v] = uv;
        let [given, own] = both_normals(patch, uv).map(|m| (normals * m).normalize_or_zero());
        let before = [view.to_world.transform_point3(patch.at(u, v)), given, own];
        return Met { before, ..met_on(patch, uv, place, [normal, facet]) };
    }
    let d = view.to_world.inverse().transform_point3(place).normalize_or_zero();
    let uv = sphere_uv(d);
    let normals = Mat3::from_mat4(view.to_world).inverse().transpose();
    let before = (normals * d).normalize_or_zero();
    let before = [view.to_world.transform_point3(d), before, before];
    Met { place, normal, geometric: facet, before, uv, st: uv, on: None }
}

/// The normals of a patch that shaders have as N and as Ng, in its own space.
fn both_normals(patch: &Patch, [u, v]: [f32; 2]) -> [Vec3; 2] {
    let own = patch.normal(u, v);
    [patch.given_normal(u, v).unwrap_or(own), own]
}

/// A patch at parameters of it.
fn met_on(patch: &Patch, [u, v]: [f32; 2], place: Vec3, [normal, geometric]: [Vec3; 2]) -> Met<'_> {
    let of = |axis: usize| bilinear(patch.uv.map(|c| c[axis]), u, v);
    let st = [patch.st_at(0, u, v), patch.st_at(1, u, v)];
    let before = [place, normal, geometric];
    Met { place, normal, geometric, before, uv: [of(0), of(1)], st, on: Some((patch, [u, v])) }
}
