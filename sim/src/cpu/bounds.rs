//! Bound every shape by an axis-aligned box, grown by its margin.
//! in   position, orientation, velocity   [n_bodies]
//!      shape_kind, shape_size            [n_shapes]  m
//! out  margin                            [n_shapes]  m, how far from its surface contacts are looked for: δ + |v| h
//!      aabb                              [n_shapes]  m, world
//! Source: paper §3, before stage 1.

use super::{Aabb, fill_rows};
use crate::{Model, ShapeKind, State};
use glam::{DMat3, DVec3};

/// The stage.
pub fn run(model: &Model, state: &State, margin: &mut Vec<f64>, aabb: &mut Vec<Aabb>) {
    let n = model.n_shapes();
    margin.resize(n, 0.0);
    aabb.resize(n, Aabb::default());
    fill_rows(margin, |s| {
        let speed = state.velocity[model.shape_body[s] as usize].length();
        model.envelope + speed * model.step
    });
    let margin = &*margin;
    fill_rows(aabb, |s| {
        let body = model.shape_body[s] as usize;
        let reach = margin[s]
            + match model.shape_kind[s] {
                ShapeKind::Sphere => model.shape_size[s],
                ShapeKind::Box => {
                    let r = DMat3::from_quat(state.orientation[body]);
                    let h = model.shape_size[s];
                    r.x_axis.abs() * h.x + r.y_axis.abs() * h.y + r.z_axis.abs() * h.z
                }
                ShapeKind::Plane => DVec3::INFINITY,
            };
        Aabb { min: state.position[body] - reach, max: state.position[body] + reach }
    });
}
