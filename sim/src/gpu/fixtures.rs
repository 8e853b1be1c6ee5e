//! The shapes that never move and that moving ones touch, as a column of a device: planes, boxes, solids of revolution, hulls, and meshes and
//! height fields with their triangles. Coordinates in the frame of a box are exact before they are rounded; those of the others are right to 2e-7 of their size.

use super::fault::Fault;
use super::fixed::Scale;
use super::hulls::Hulls;
use super::kinds::{BOX, CAPSULE, CONE, CYLINDER, HULL, PLANE, SURFACE};
use super::rows::{Aabb, Fixture, Node};
use super::solids::is_mover;
use super::surfaces::Surfaces;
use crate::aabb;
use crate::model::Model;
use crate::shape::ShapeKind;
use crate::state::State;
use glam::{DMat3, DVec3};
use gpu::{Buffer, Device};

/// The column, and the boxes about it.
pub struct Fixtures {
    /// Number of fixtures, but for triangles.
    pub n: usize,
    /// The fixtures, by ascending shape (n_fixtures), then the triangles of the surfaces.
    pub fixture: Buffer<Fixture>,
    /// Their AABBs, grown by the envelope, m; that of a plane is about its position (n_fixtures).
    pub aabb: Buffer<Aabb>,
    /// The boxes about the triangles, by surfaces.
    pub node: Buffer<Node>,
    /// Kinds (n_fixtures).
    pub kinds: Vec<u32>,
    /// Ids of the shapes, and the same AABBs.
    pub boxes: Vec<(usize, Aabb)>,
}

impl Fixtures {
    /// The fixtures of a model: all shapes of bodies that never move, but for spheres and ellipsoids.
    ///
    /// # Errors
    /// [`Fault::Position`]; [`Fault::Gpu`].
    pub fn new(
        device: &Device,
        model: &Model,
        state: &State,
        (scale, hulls): (Scale, &Hulls),
    ) -> Result<Fixtures, Fault> {
        let (mut rows, mut boxes, mut surfaces) = (vec![], vec![], Surfaces::default());
        let own: Vec<usize> = (0..model.n_shapes()).filter(|s| !is_mover(model, *s)).collect();
        for s in own.iter().copied() {
            let mut row = row(model, state, (scale, hulls), s)?;
            if row.kind == SURFACE {
                row.part = surfaces.push((model, scale, own.len()), &row, &state.shape_pose(model, s))?;
            }
            let size = model.shape_size[s];
            let half = match row.kind {
                PLANE => DVec3::ZERO,
                CAPSULE => DVec3::new(size.x, size.x, size.z + size.x),
                CYLINDER | CONE => DVec3::new(size.x, size.x, size.z),
                _ => size,
            };
            boxes.push((s, bounds(model, state, s, half)));
            rows.push(row);
        }
        let kinds = rows.iter().map(|row| row.kind).collect();
        rows.extend(surfaces.triangles);
        Ok(Fixtures {
            n: own.len(),
            kinds,
            node: Buffer::of(device, "node", &surfaces.nodes)?,
            fixture: Buffer::of(device, "fixture", &rows)?,
            aabb: Buffer::of(device, "fixture_aabb", &boxes.iter().map(|(_, b)| *b).collect::<Vec<_>>())?,
            boxes,
        })
    }
}

fn row(model: &Model, state: &State, (scale, hulls): (Scale, &Hulls), s: usize) -> Result<Fixture, Fault> {
    let body = model.shape_body[s];
    let kind = match model.shape_kind[s] {
        ShapeKind::Plane => PLANE,
        ShapeKind::Box => BOX,
        ShapeKind::Capsule => CAPSULE,
        ShapeKind::Cylinder => CYLINDER,
        ShapeKind::Cone => CONE,
        ShapeKind::Hull => HULL,
        ShapeKind::Mesh | ShapeKind::HeightField => SURFACE,
        ShapeKind::Sphere | ShapeKind::Ellipsoid => unreachable!("round shapes are no fixtures"),
    };
    let place = state.shape_pose(model, s);
    let fix = |p: DVec3| scale.fix(p).ok_or(Fault::Position(body));
    let [x_axis, y_axis, z_axis] = [DVec3::X, DVec3::Y, DVec3::Z].map(|e| Scale::axis(place.orientation * e));
    let half = if kind == PLANE { Default::default() } else { fix(model.shape_size[s])? };
    let (material, group) = (model.shape_material[s], model.shape_group[s]);
    let (position, part) = (fix(place.position)?, hulls.of(model, s));
    Ok(Fixture { position, x_axis, y_axis, z_axis, half, kind, shape: s as u32, body, material, group, part })
}

/// The box about a fixture with its margin.
fn bounds(model: &Model, state: &State, s: usize, half: DVec3) -> Aabb {
    let place = state.shape_pose(model, s);
    let r = DMat3::from_quat(place.orientation);
    let reach = r.x_axis.abs() * half.x + r.y_axis.abs() * half.y + r.z_axis.abs() * half.z;
    let own = aabb::Aabb::about(place.position, reach + DVec3::splat(model.envelope));
    Aabb { low: own.min.extend(0.0).to_array(), high: own.max.extend(0.0).to_array() }
}
