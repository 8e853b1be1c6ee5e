//! The anchor of Negrut et al. 2012, sections 5.3 and 5.4: a sphere as tip, a cylinder as shaft and a helix of thin boxes as blade, guided
//! along a vertical line about which it may turn.

use super::parts::{DimensionError, Parts, body, joint, part, positive};
use crate::joint::JointKind;
use crate::model_file::{BoxFile, CylinderFile, FunctionFile, LoadFile, ShapeFile, SphereFile};
use serde::{Deserialize, Serialize};

/// The most boxes of a blade.
const MAX_BOXES: usize = 100_000;

/// A helical anchor (Negrut et al. 2012, §5.3): a sphere as tip, a cylinder as shaft and a helix of boxes as blade. The tip's lowest
/// point is at `position`; the axis is vertical.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HelicalAnchor {
    /// Name of the material.
    pub material: String,
    /// Position of the lowest point, m, world.
    pub position: [f64; 3],
    /// Mass, kg.
    pub mass: f64,
    /// Outer radius of the blade, m.
    pub radius: f64,
    /// Radius of the shaft and of the sphere at its tip, m.
    pub shaft_radius: f64,
    /// Length of the shaft, m.
    pub shaft_length: f64,
    /// Rise of the blade in a turn, m.
    pub pitch: f64,
    /// Number of turns of the blade.
    pub turns: f64,
    /// Number of boxes that make up the blade.
    pub boxes: usize,
    /// Thickness of the blade, m.
    pub thickness: f64,
    /// Height of the blade's lower end over the lowest point, m.
    pub blade_height: f64,
    /// Torque about the axis, N m, over time; positive screws the anchor in.
    pub torque: FunctionFile,
    /// Force along the axis, N, over time; positive pulls up.
    pub pull: FunctionFile,
    /// Whether a cylindrical joint to the world guides the axis.
    pub guided: bool,
}

impl Default for HelicalAnchor {
    fn default() -> HelicalAnchor {
        HelicalAnchor {
            material: "steel".into(),
            position: [0.0; 3],
            mass: 10.0,
            radius: 0.5,
            shaft_radius: 0.08,
            shaft_length: 2.0,
            pitch: 0.35,
            turns: 2.0,
            boxes: 67,
            thickness: 0.02,
            blade_height: 0.12,
            torque: FunctionFile::Constant(0.0),
            pull: FunctionFile::Constant(0.0),
            guided: true,
        }
    }
}

impl HelicalAnchor {
    /// Check the dimensions.
    fn check(&self) -> Result<(), DimensionError> {
        positive(&[
            ("mass", self.mass),
            ("radius", self.radius),
            ("shaft_radius", self.shaft_radius),
            ("shaft_length", self.shaft_length),
            ("pitch", self.pitch),
            ("turns", self.turns),
            ("boxes", self.boxes as f64),
            ("thickness", self.thickness),
        ])?;
        if self.boxes > MAX_BOXES {
            return Err(("boxes", format!("is {}, expected at most {MAX_BOXES}", self.boxes)));
        }
        if self.radius <= self.shaft_radius {
            return Err((
                "radius",
                format!("is {}, expected more than the shaft's {}", self.radius, self.shaft_radius),
            ));
        }
        Ok(())
    }

    /// The body, guide and loads of an anchor; `name` is its body's, and the prefix of its joint's.
    ///
    /// # Errors
    /// A dimension that is not above zero, or a blade that is no wider than the shaft.
    pub(crate) fn build(&self, name: &str) -> Result<Parts, DimensionError> {
        self.check()?;
        let [x, y, z] = self.position;
        let r = self.shaft_radius;
        // The body's frame is at the sphere's centre.
        let mut anchor = body(name.into(), name, &self.material, [x, y, z + r], self.mass);
        let mut shapes = vec![
            part(ShapeFile { sphere: Some(SphereFile { radius: r }), ..ShapeFile::default() }, [0.0; 3], None),
            part(
                ShapeFile {
                    cylinder: Some(CylinderFile { radius: r, length: self.shaft_length }),
                    ..ShapeFile::default()
                },
                [0.0, 0.0, 0.5 * self.shaft_length],
                None,
            ),
        ];
        // Each box spans the blade from shaft to rim, and a little more than its sector of the turn at mid radius.
        let (inner, outer) = (0.8 * r, self.radius);
        let middle = 0.5 * (inner + outer);
        let sector = self.turns * std::f64::consts::TAU / self.boxes as f64;
        let rise = self.pitch * self.turns / self.boxes as f64;
        let along = ((middle * sector).powi(2) + rise * rise).sqrt() * 1.15;
        let tilt = (rise / (middle * sector)).atan();
        for k in 0..self.boxes {
            let angle = (k as f64 + 0.5) * sector;
            let height = self.blade_height - r + (k as f64 + 0.5) * rise;
            let size = [outer - inner, along, self.thickness];
            // Rotated about the axis, then tilted about its own radius.
            let rotation = glam::DQuat::from_rotation_z(angle) * glam::DQuat::from_rotation_x(tilt);
            let mut blade = part(
                ShapeFile { block: Some(BoxFile { size }), ..ShapeFile::default() },
                [middle * angle.cos(), middle * angle.sin(), height],
                None,
            );
            blade.orientation = Some([rotation.w, rotation.x, rotation.y, rotation.z]);
            shapes.push(blade);
        }
        anchor.shapes = Some(shapes);
        anchor.center = Some([0.0, 0.0, 0.3 * self.shaft_length]);
        let mut parts = Parts { bodies: vec![anchor], ..Parts::default() };
        if self.guided {
            parts.joints.push(joint(
                format!("{name}_guide"),
                JointKind::Cylindrical,
                ["world", name],
                [x, y, z + 0.3 * self.shaft_length],
                [0.0, 0.0, 1.0],
            ));
        }
        let load = |force: Option<[f64; 3]>, torque: Option<[f64; 3]>, value: &FunctionFile| LoadFile {
            body: name.into(),
            force,
            torque,
            value: value.clone(),
            frame: Default::default(),
            point: None,
            from: None,
            until: None,
        };
        // The blade rises against the clock seen from above: turning it clockwise screws it in.
        parts.loads.push(load(None, Some([0.0, 0.0, -1.0]), &self.torque));
        parts.loads.push(load(Some([0.0, 0.0, 1.0]), None, &self.pull));
        Ok(parts)
    }
}
