//! Names that columns of orientations and velocities go by in other programs.

use super::columns::{is_numeric, only};
use super::lengths::Length;
use frame::Frame;

/// Names of a quaternion w, x, y, z, in small letters and without other characters: of scree, DEM-Engine, LAMMPS, LIGGGHTS and Chrono.
const QUATERNIONS: [[&str; 4]; 10] = [
    ["quatw", "quatx", "quaty", "quatz"],
    ["qw", "qx", "qy", "qz"],
    ["quatw", "quati", "quatj", "quatk"],
    ["orientationw", "orientationx", "orientationy", "orientationz"],
    ["quaternionw", "quaternionx", "quaterniony", "quaternionz"],
    ["rotw", "rotx", "roty", "rotz"],
    ["e0", "e1", "e2", "e3"],
    ["q0", "q1", "q2", "q3"],
    ["quat0", "quat1", "quat2", "quat3"],
    ["quat1", "quat2", "quat3", "quat4"],
];

/// What stands before the axis in names of velocities: `v_x`, `velocity:0`, `Velocity X (m/s)`.
const VELOCITIES: [&str; 8] =
    ["v", "vel", "velo", "velocity", "velocities", "linearvelocity", "particlevelocity", "translationalvelocity"];

/// The columns of a quaternion w, x, y, z, if the frame has one of length 1 in every row.
pub(super) fn orientation(frame: &Frame) -> Option<[&str; 4]> {
    let named = |names: [&str; 4]| -> Option<[&str; 4]> {
        let found: Vec<&str> = names.iter().filter_map(|name| only(frame, name, is_numeric)).collect();
        found.try_into().ok()
    };
    QUATERNIONS.into_iter().filter_map(named).find(|names| is_unit(frame, names))
}

/// Whether four columns are quaternions of length 1 in every row.
pub(super) fn is_unit(frame: &Frame, names: &[&str; 4]) -> bool {
    let Some(columns) = names.iter().map(|name| frame.column(name)).collect::<Option<Vec<_>>>() else { return false };
    let square = |row: usize| columns.iter().filter_map(|c| c.number(row)).map(|x| x * x).sum::<f64>();
    frame.rows() > 0 && (0..frame.rows()).all(|row| (square(row) - 1.0).abs() < 0.01)
}

/// The columns of a velocity, if the frame has any that can be read in m/s.
pub(super) fn velocity<'a>(frame: &'a Frame, position: &[Length<'a>; 3]) -> Option<[Length<'a>; 3]> {
    let named = |(head, axes): (&str, [char; 3])| -> Option<[Length<'a>; 3]> {
        let one = |k: usize| {
            let name = only(frame, &format!("{head}{}", axes[k]), is_numeric)?;
            Length::of_velocity(frame, name, &position[k])
        };
        Some([one(0)?, one(1)?, one(2)?])
    };
    // A letter with a digit may be anything.
    let counted = VELOCITIES
        .into_iter()
        .filter(|head| head.len() > 1)
        .flat_map(|head| [['0', '1', '2'], ['1', '2', '3']].map(|axes| (head, axes)));
    VELOCITIES.into_iter().map(|head| (head, ['x', 'y', 'z'])).chain(counted).find_map(named)
}

#[cfg(test)]
mod tests {
    use super::*;
    use frame::Column;

    fn table(names: &[&str], values: &[f64]) -> Frame {
        let mut frame = Frame::new(0, 0.0);
        names.iter().zip(values).for_each(|(name, x)| frame.push(name, "", Column::F64(vec![*x])));
        frame
    }

    #[test]
    fn quaternions_are_known_by_name_and_length() {
        for names in [
            ["Qw", "Qx", "Qy", "Qz"],
            ["e0", "e1", "e2", "e3"],
            ["quat_w", "quat_x", "quat_y", "quat_z"],
            ["quatw", "quati", "quatj", "quatk"],
            ["q0", "q1", "q2", "q3"],
        ] {
            assert_eq!(orientation(&table(&names, &[0.6, 0.0, 0.0, -0.8])), Some(names));
            assert_eq!(orientation(&table(&names, &[0.6, 0.0, 0.0, 0.0])), None);
        }
        assert_eq!(orientation(&table(&["e0", "e1", "e2"], &[1.0, 0.0, 0.0])), None);
    }

    #[test]
    fn velocities_are_known_by_name_and_unit() {
        let text = |names: [&str; 3], unit: f64| {
            let frame = table(&names, &[1.0, 2.0, 3.0]);
            let place = ["x", "y", "z"].map(|column| Length { column, factor: unit, origin: 0.0 });
            velocity(&frame, &place).map(|v| v.map(|v| (v.column.to_string(), v.factor)))
        };
        for names in [
            ["vx", "vy", "vz"],
            ["v_x", "v_y", "v_z"],
            ["velocity_x", "velocity_y", "velocity_z"],
            ["velocity:0", "velocity:1", "velocity:2"],
            ["Velocity X (m/s)", "Velocity Y (m/s)", "Velocity Z (m/s)"],
            ["vel_1", "vel_2", "vel_3"],
        ] {
            assert_eq!(text(names, 1.0), Some(names.map(|name| (name.to_string(), 1.0))));
        }
        assert_eq!(text(["vx", "vy", "vz"], 0.001).unwrap()[2].1, 0.001);
        assert_eq!(text(["vx [mm/s]", "vy [mm/s]", "vz [mm/s]"], 1.0).unwrap()[0].1, 0.001);
        assert_eq!(text(["vx [rpm]", "vy [rpm]", "vz [rpm]"], 1.0), None);
        assert_eq!(text(["v1", "v2", "v3"], 1.0), None);
    }
}
