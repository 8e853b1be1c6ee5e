//! Moving shapes of any kind as rows of a device, and the families of pairs that their narrow phases are for.

use super::fault::Fault;
use super::kinds::{BALL, BOX, CAPSULE, CONE, CYLINDER, ELLIPSOID, PLANE, SPHERE};
use super::rows::Solid;
use crate::inertia::is_isotropic;
use crate::model::Model;
use crate::plan::{Narrow, has_joints};
use crate::shape::ShapeKind;

/// The shapes that the kernels of a model are for: spheres about the centres of mass of bodies of isotropic inertia, among fixtures, or any.
pub fn narrow_of(model: &Model) -> Narrow {
    let has_spheres_only = (0..model.n_shapes()).all(|s| model.is_centred_sphere(s) || !is_mover(model, s));
    let is_turned = |b: usize| model.inv_mass[b] > 0.0 && !is_isotropic(model.inv_inertia[b]);
    // Joints have arms of any direction, and turn bodies.
    let is_turned = (0..model.n_bodies()).any(is_turned) || has_joints(model);
    if has_spheres_only && !is_turned { Narrow::Spheres } else { Narrow::Any }
}

/// Whether a shape is one of those that are binned; the others are fixtures.
pub fn is_mover(model: &Model, s: usize) -> bool {
    let is_round = matches!(model.shape_kind[s], ShapeKind::Sphere | ShapeKind::Ellipsoid);
    is_round || model.inv_mass[model.shape_body[s] as usize] > 0.0
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
/// # Errors
/// [`Fault::Unsupported`] for a shape of a kind that no kernel is built for.
pub fn row(model: &Model, s: usize) -> Result<Solid, Fault> {
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
        kind => return Err(unsupported(model, s, &format!("a {} that moves", kind.name()))),
    };
    let arm = if kind == SPHERE { place.position.length() } else { place.position.length() + size.length() };
    Ok(Solid {
        half: size.as_vec3().to_array(),
        kind,
        offset: if is_ball { [0.0; 3] } else { place.position.as_vec3().to_array() },
        lever: if is_ball { 0.0 } else { arm as f32 },
        turn: if is_ball { [0.0, 0.0, 0.0, 1.0] } else { place.orientation.as_quat().to_array() },
    })
}

/// The fault of a shape that no kernel is built for.
pub fn unsupported(model: &Model, s: usize, what: &str) -> Fault {
    let label = model.body_label(model.shape_body[s] as usize);
    Fault::Unsupported(format!("body {label} has a shape that no kernel is built for yet: {what}"))
}

/// A family of pairs: the name of its kernels, the text that tells its pairs, and that which finds their points.
pub type Family = (&'static str, &'static str, &'static str);

/// The families that the pairs of some rows among fixtures of some kinds may be of.
pub fn families(rows: &[Solid], fixtures: &[u32]) -> Vec<Family> {
    let is_ball = |kind: u32| kind == BALL || kind == SPHERE;
    let own = |k: u32| rows.iter().any(|row| row.kind == k);
    let has = |k: u32| own(k) || fixtures.contains(&k);
    let solids = [BOX, CAPSULE, CYLINDER, CONE];
    let has_moving_solids = rows.iter().any(|row| !is_ball(row.kind));
    let has_planes = fixtures.contains(&PLANE) && rows.iter().any(|row| row.kind != BALL);
    let has_balls = own(SPHERE) || own(BALL) && solids.into_iter().any(own);
    let is_angular = |k: &u32| *k != BOX && has(*k);
    let has_others = solids.iter().any(is_angular) && has_moving_solids || own(ELLIPSOID);
    let all: [(bool, Family); 4] = [
        (has_planes, ("plane_contacts", include_str!("family_plane.wgsl"), include_str!("points_plane.wgsl"))),
        (has_balls, ("ball_contacts", include_str!("family_ball.wgsl"), include_str!("points_ball.wgsl"))),
        (own(BOX), ("box_contacts", include_str!("family_box.wgsl"), include_str!("points_box.wgsl"))),
        (has_others, ("convex_contacts", include_str!("family_convex.wgsl"), include_str!("points_convex.wgsl"))),
    ];
    all.into_iter().filter(|(has_some, _)| *has_some).map(|(_, family)| family).collect()
}
