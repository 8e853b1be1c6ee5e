//! The axis of the data that points up. Scenes, cameras and lights have z up; what is drawn is turned so that it stands in them as it stood in
//! its simulation.

use frame::Fault;
use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::f32::consts::FRAC_1_SQRT_2;
use std::path::Path;

/// The axis of the data that points up: against gravity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub enum Up {
    /// x.
    #[serde(rename = "x")]
    X,
    /// Against x.
    #[serde(rename = "-x")]
    MinusX,
    /// y.
    #[serde(rename = "y")]
    Y,
    /// Against y.
    #[serde(rename = "-y")]
    MinusY,
    /// z.
    #[default]
    #[serde(rename = "z")]
    Z,
    /// Against z.
    #[serde(rename = "-z")]
    MinusZ,
}

impl Up {
    /// The axis that gravity, in any unit, points against most; z where there is none.
    pub fn against(gravity: [f64; 3]) -> Up {
        let [x, y, z] = gravity.map(f64::abs);
        let against = |g: f64, [up, down]: [Up; 2]| if g <= 0.0 { up } else { down };
        match gravity {
            [g, ..] if x > y && x > z => against(g, [Up::X, Up::MinusX]),
            [_, g, _] if y > z => against(g, [Up::Y, Up::MinusY]),
            [.., g] => against(g, [Up::Z, Up::MinusZ]),
        }
    }

    /// The axis that points up in a run of scree: against the gravity of its model; z where that cannot be read.
    pub fn of_run(folder: &Path) -> Up {
        #[derive(Deserialize)]
        struct Gravity {
            gravity: Option<[f64; 3]>,
        }
        let model: Result<(Gravity, _), Fault> = frame::yaml::read(&folder.join("model.yaml"));
        model.ok().and_then(|(model, _)| model.gravity).map_or(Up::Z, Up::against)
    }

    /// Whether nothing is turned.
    pub fn is_z(&self) -> bool {
        *self == Up::Z
    }

    /// The condition, on columns of a quaternion, that the z axis of a row points up by more than half.
    pub fn is_upright(self) -> &'static str {
        match self {
            Up::X => "quat_x * quat_z + quat_w * quat_y > 0.25",
            Up::MinusX => "quat_x * quat_z + quat_w * quat_y < -0.25",
            Up::Y => "quat_y * quat_z - quat_w * quat_x > 0.25",
            Up::MinusY => "quat_y * quat_z - quat_w * quat_x < -0.25",
            Up::Z => "quat_x * quat_x + quat_y * quat_y < 0.25",
            Up::MinusZ => "quat_x * quat_x + quat_y * quat_y > 0.75",
        }
    }

    /// The rotation by which what is up comes to be z.
    pub fn rotation(self) -> Quat {
        const HALF: f32 = FRAC_1_SQRT_2;
        match self {
            Up::X => Quat::from_xyzw(0.0, -HALF, 0.0, HALF),
            Up::MinusX => Quat::from_xyzw(0.0, HALF, 0.0, HALF),
            Up::Y => Quat::from_xyzw(HALF, 0.0, 0.0, HALF),
            Up::MinusY => Quat::from_xyzw(-HALF, 0.0, 0.0, HALF),
            Up::Z => Quat::IDENTITY,
            Up::MinusZ => Quat::from_xyzw(1.0, 0.0, 0.0, 0.0),
        }
    }

    /// A vector or a place, turned by [`Up::rotation`] without rounding.
    pub fn turn<T: Copy + std::ops::Neg<Output = T>>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self {
            Up::X => [-z, y, x],
            Up::MinusX => [z, y, -x],
            Up::Y => [x, -z, y],
            Up::MinusY => [x, z, -y],
            Up::Z => [x, y, z],
            Up::MinusZ => [x, -y, -z],
        }
    }

    /// [`Up::turn`] of a vector.
    pub fn turn_vector(self, v: Vec3) -> Vec3 {
        self.turn(v.to_array()).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_up_comes_to_be_z_by_a_rotation() {
        let ways = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
        let all = [Up::X, Up::MinusX, Up::Y, Up::MinusY, Up::Z, Up::MinusZ];
        for (up, way) in all.into_iter().zip(ways) {
            assert_eq!(up.turn_vector(way), Vec3::Z, "{up:?}");
            assert_eq!(Up::against((-9.81 * way).as_dvec3().to_array()), up);
            let v = Vec3::new(1.0, -2.0, 3.5);
            assert!((up.rotation() * v - up.turn_vector(v)).length() < 1e-6, "{up:?}");
        }
        assert_eq!(Up::against([0.0; 3]), Up::Z);
        assert_eq!(Up::against([3.0, 0.0, -9.0]), Up::Z);
    }
}
