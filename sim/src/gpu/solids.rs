//! Moving shapes of any kind as rows of a device, and the families of pairs that their narrow phases are for.

use super::hulls::Hulls;
use super::kinds::{BALL, BOX, CAPSULE, CONE, CYLINDER, ELLIPSOID, HULL, PLANE, SPHERE, SURFACE};
use super::rows::Solid;
use crate::inertia::is_isotropic;
use crate::model::Model;
use crate::plan::{Narrow, has_friction_alone, has_joints};
use crate::settings::Method;
use crate::shape::ShapeKind;

/// The shapes that the kernels of a model are for: spheres about the centres of mass of bodies of isotropic inertia, among fixtures that are no
/// hulls, or any.
///
/// Gauss–Seidel visits contacts of spheres by themselves where these know friction alone.
pub fn narrow_of(model: &Model) -> Narrow {
    let is_fixture = |s: usize| !is_mover(model, s) && model.shape_kind[s] != ShapeKind::Hull;
    let has_spheres_only = (0..model.n_shapes()).all(|s| model.is_centred_sphere(s) || is_fixture(s));
    let is_turned = |b: usize| model.inv_mass[b] > 0.0 && !is_isotropic(model.inv_inertia[b]);
    // Joints have arms of any direction, and turn bodies.
    let is_turned = (0..model.n_bodies()).any(is_turned) || has_joints(model);
    let may_sweep = model.solver.method.is_none_or(|method| method == Method::GaussSeidel);
    let has_own_visits = !may_sweep || has_friction_alone(model);
    if has_spheres_only && !is_turned && has_own_visits { Narrow::Spheres } else { Narrow::Any }
}

/// Whether a shape is one of those that are binned; the others are fixtures.
pub fn is_mover(model: &Model, s: usize) -> bool {
    let is_round = matches!(model.shape_kind[s], ShapeKind::Sphere | ShapeKind::Ellipsoid);
    is_round || model.inv_mass[model.shape_body[s] as usize] > 0.0
}

/// Whether some shapes are hulls.
pub fn has_hulls(model: &Model) -> bool {
    model.shape_kind.contains(&ShapeKind::Hull)
}

/// Whether some shapes are meshes or height fields.
pub fn has_surfaces(model: &Model) -> bool {
    model.shape_kind.iter().any(|kind| matches!(kind, ShapeKind::Mesh | ShapeKind::HeightField))
}

/// Half the least width of a shape, m.
pub fn least_of(model: &Model, s: usize) -> f64 {
    let size = model.shape_size[s];
    match model.shape_kind[s] {
        ShapeKind::Capsule => size.x,
        _ => size.min_element(),
    }
}

/// The row of a shape.
///
/// # Panics
/// For a surface, which never moves.
pub fn row(model: &Model, hulls: &Hulls, s: usize) -> Solid {
    let (size, place) = (model.shape_size[s], &model.shape_pose[s]);
    let is_ball = model.is_centred_sphere(s);
    let kind = match model.shape_kind[s] {
        ShapeKind::Sphere if is_ball => BALL,
        ShapeKind::Sphere => SPHERE,
        ShapeKind::Ellipsoid => ELLIPSOID,
        ShapeKind::Box => BOX,
        ShapeKind::Capsule => CAPSULE,
        ShapeKind::Cylinder => CYLINDER,
        ShapeKind::Cone => CONE,
        ShapeKind::Hull => HULL,
        ShapeKind::Plane | ShapeKind::Mesh | ShapeKind::HeightField => unreachable!("surfaces never move"),
    };
    let arm = if kind == SPHERE { place.position.length() } else { place.position.length() + size.length() };
    Solid {
        half: size.as_vec3().to_array(),
        kind,
        offset: if is_ball { [0.0; 3] } else { place.position.as_vec3().to_array() },
        lever: if is_ball { 0.0 } else { arm as f32 },
        turn: if is_ball { [0.0, 0.0, 0.0, 1.0] } else { place.orientation.as_quat().to_array() },
        part: hulls.of(model, s),
        pad: 0,
        more: [0; 2],
    }
}

/// A family of pairs.
#[derive(Clone, Copy)]
pub struct Family {
    /// Name of its kernels.
    pub name: &'static str,
    /// The part that tells its pairs.
    pub pairs: &'static str,
    /// The part that finds their points.
    pub points: &'static str,
    /// Whether shapes of its pairs may be hulls.
    pub hulls: bool,
}

/// A family by the end of its files' names.
macro_rules! family {
    ($name:literal, $end:literal, $points:literal, $hulls:literal) => {
        Family {
            name: $name,
            pairs: include_str!(concat!("family_", $end, ".wgsl")),
            points: include_str!(concat!("points_", $points, ".wgsl")),
            hulls: $hulls,
        }
    };
}

/// The families that the pairs of some rows among fixtures of some kinds may be of.
pub fn families(rows: &[Solid], fixtures: &[u32]) -> Vec<Family> {
    let is_ball = |kind: u32| kind == BALL || kind == SPHERE;
    let own = |k: u32| rows.iter().any(|row| row.kind == k);
    let has = |k: u32| own(k) || fixtures.contains(&k);
    let solids = [BOX, CAPSULE, CYLINDER, CONE];
    let has_moving_solids = rows.iter().any(|row| !is_ball(row.kind));
    let is_unround = rows.iter().any(|row| row.kind != BALL);
    let has_balls = own(SPHERE) || own(BALL) && solids.into_iter().any(own);
    let is_angular = |k: &u32| *k != BOX && has(*k);
    let has_others = solids.iter().any(is_angular) && has_moving_solids || own(ELLIPSOID);
    let all: [(bool, Family); 6] = [
        (fixtures.contains(&PLANE) && is_unround, family!("plane_contacts", "plane", "plane", true)),
        (fixtures.contains(&SURFACE) && is_unround, family!("triangle_contacts", "triangle", "triangle", true)),
        (has_balls, family!("ball_contacts", "ball", "ball", false)),
        (own(BOX), family!("box_contacts", "box", "box", false)),
        (has_others, family!("convex_contacts", "convex", "convex", false)),
        (has(HULL), family!("hull_contacts", "hull", "convex", true)),
    ];
    all.into_iter().filter(|(has_some, _)| *has_some).map(|(_, family)| family).collect()
}
