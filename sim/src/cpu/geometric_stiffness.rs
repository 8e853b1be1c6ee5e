//! Geometric stiffness of joints and springs that carry loads too heavy for the step.
//!
//! The force F of a joint on a body at the arm r turns with nothing while the arm turns with the body: its torque changes by −K δθ with
//! K = (F·r) 1 − r Fᵀ. Light links under tension swing fast, and where h²K is above their inertia the explicit rows of a step shake them
//! apart. There K acts at the step's end, as a stiff spring does: it is added to the inertia, h²K for the links' rotation, and so S stays
//! block-sparse; a link of constant length resists transverse motion with F over its length, by two rows.
//! Source: Andrews, Teichmann and Kry, *Geometric stiffness for real-time constrained multibody dynamics* (2017), with the threshold of
//! [`super::joint_write`] for springs. Forces are those of the last step.

use super::masses::Masses;
use super::solve::joints::Joints;
use crate::geometry::principal;
use crate::joint::{Coordinate, Frames, Joint, Row, Spring, SpringKind, SpringState};
use crate::model::Model;
use crate::state::State;
use crate::twist::Twist;
use glam::{DMat3, DVec3};
use std::collections::BTreeMap;

/// Greatest h²K over the inertia: explicit motion is stable below 4.
const BOUND: f64 = 2.0;

/// The geometric stiffness of the joints and springs of a step.
#[derive(Default)]
pub struct Stiffness {
    /// That of the rotation of bodies, N m/rad, world.
    of_body: BTreeMap<u32, DMat3>,
    /// Transverse rows of links.
    transverse: Vec<Row>,
}

impl Stiffness {
    /// Add the stiffness of a joint with the frames `f`, which carried the force of the last step.
    pub fn add(&mut self, joint: &Joint, f: &Frames, force_on_a: DVec3) {
        if force_on_a == DVec3::ZERO {
            return;
        }
        self.turn(joint.bodies, f, force_on_a);
        if joint.kind.coordinate() == Some(Coordinate::Length) {
            self.swing(&joint.free_row(f, Coordinate::Length), f, force_on_a);
        }
    }

    /// Add the stiffness of a spring between two points with the frames `f`, which had the force of the last step.
    pub fn add_spring(&mut self, spring: &Spring, f: &Frames, known: &SpringState) {
        if known.force == 0.0 || spring.kind == SpringKind::Angle {
            return;
        }
        let pull = f.offset().normalize_or_zero() * known.force;
        self.turn(spring.bodies, f, pull);
        if spring.kind == SpringKind::Line {
            spring.rows(f, known).for_each(|along| self.swing(&along, f, pull));
        }
    }

    /// Stiffness of the rotation of two bodies at whose arms a force acts.
    fn turn(&mut self, bodies: [u32; 2], f: &Frames, force_on_a: DVec3) {
        for ((body, force), arm) in bodies.into_iter().zip([force_on_a, -force_on_a]).zip(f.arms()) {
            let product = DMat3::from_cols(arm * force.x, arm * force.y, arm * force.z);
            let stiffness = DMat3::IDENTITY * force.dot(arm) - (product + product.transpose()) * 0.5;
            *self.of_body.entry(body).or_insert(DMat3::ZERO) += stiffness;
        }
    }

    /// Stiffness of a link across it: its force over its length.
    fn swing(&mut self, along: &Row, f: &Frames, force_on_a: DVec3) {
        let stiffness = along.linear.dot(force_on_a) / along.psi.max(f64::MIN_POSITIVE);
        let (u, w) = along.linear.any_orthonormal_pair();
        // The stiffness stands where the compliance over h² comes to be.
        let [a, b] = f.arms();
        self.transverse.extend([u, w].map(|e| Row {
            bodies: along.bodies,
            linear: e,
            angular_a: a.cross(e),
            angular_b: b.cross(e),
            softness: stiffness,
            ..Row::default()
        }));
    }

    /// Let what is too stiff for the step `h` act at its end: on the inertia of bodies and their velocities without joints, and as rows.
    pub fn apply(self, model: &Model, state: &State, h: f64, masses: &mut Masses, free: &[Twist], joints: &mut Joints) {
        for (body, stiffness) in self.of_body {
            let b = body as usize;
            let least = model.inv_inertia[b].max_element().recip();
            // The trace of K is twice F·r, and the greatest eigenvalue at most the norm.
            let norm = stiffness.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
            if !state.moves(b) || h * h * norm < BOUND * least {
                continue;
            }
            let (values, axes) = principal(stiffness);
            let values = (values * (h * h / BOUND) - least).max(DVec3::ZERO);
            let axes = DMat3::from_quat(axes);
            let added = axes * DMat3::from_diagonal(values) * axes.transpose();
            if values != DVec3::ZERO {
                masses.stiffen(b, added);
            }
        }
        for row in self.transverse {
            let stiffness = row.softness;
            let added = h * h * stiffness / BOUND - 1.0 / masses.response(&row);
            if added > 0.0 {
                joints.rows.push(Row { softness: 1.0 / added, ..row });
                joints.bias.push(-row.speed_in(free));
            }
        }
    }
}
