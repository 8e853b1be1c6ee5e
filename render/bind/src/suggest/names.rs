//! Names that columns of positions and sizes go by in other programs.

use super::columns::{is_numeric, only, simplified};
use super::lengths::{Length, near_origin};
use super::motion;
use frame::{Column, Frame};

/// Names of positions that are looked for first, as they are.
const POSITIONS: [[&str; 3]; 4] = [["pos_x", "pos_y", "pos_z"], ["x", "y", "z"], ["X", "Y", "Z"], ["px", "py", "pz"]];

/// Names of a radius that are looked for first, as they are.
const RADII: [&str; 5] = ["radius", "r", "R", "rad", "half_x"];

/// What stands before the axis in names of positions, in small letters and without other characters: `Points:0`, `Position_X`, `X (m)`.
const PLACES: [&str; 19] = [
    "",
    "pos",
    "p",
    "position",
    "positions",
    "point",
    "points",
    "coord",
    "coords",
    "coordinate",
    "coordinates",
    "center",
    "centre",
    "centroid",
    "centerofmass",
    "centreofmass",
    "location",
    "particleposition",
    "particlecoordinates",
];

/// What stands behind the axis in names of positions.
const BEHIND: [&str; 7] = ["", "coordinate", "coord", "position", "pos", "center", "centre"];

/// The last letters of the three columns of a vector.
const AXES: [[char; 3]; 3] = [['x', 'y', 'z'], ['0', '1', '2'], ['1', '2', '3']];

/// The columns from which places and sizes are read.
pub(super) struct Names<'a> {
    pub(super) position: [Length<'a>; 3],
    pub(super) radius: Option<Length<'a>>,
    /// A quaternion w, x, y, z.
    pub(super) orientation: Option<[&'a str; 4]>,
    pub(super) velocity: Option<[Length<'a>; 3]>,
}

impl<'a> Names<'a> {
    /// The columns of a frame, and what had to be guessed or converted, in a sentence each. An error if there are no positions, or if
    /// a column that has them, or the radii, has words.
    pub(super) fn of(frame: &'a Frame) -> Result<(Names<'a>, Vec<String>), String> {
        let unnamed = unnamed(frame);
        let orientation = unnamed.as_ref().map_or_else(|| motion::orientation(frame), |unnamed| unnamed.orientation);
        let mut remarks = vec![];
        let (position, radius) = match unnamed {
            Some(Unnamed { position, radius, orientation }) => {
                let size = radius.map_or(String::new(), |name| format!(", and {name} for the radius"));
                let turn = orientation.map(|q| format!(", and {} for a quaternion w, x, y, z", q.join(", ")));
                let size = size + &turn.unwrap_or_default();
                remarks
                    .push(format!("the columns have no names: {} are taken for x, y and z{size}", position.join(", ")));
                (Some(position), radius.map(|name| (name, 1.0)))
            }
            None => (position_of(frame, is_numeric), radius_of(frame, has_numbers)),
        };
        let any = |_: &Frame, name: &str| !name.contains('`');
        let position = position.ok_or_else(|| {
            let misread = position_of(frame, any).and_then(|names| names.iter().find_map(|name| misread(frame, name)));
            misread.or_else(|| plane_of(frame)).unwrap_or_else(|| {
                let names = frame::listed(&frame.names());
                format!("no columns of positions were found (as pos_x, pos_y, pos_z or x, y, z); the data has {names}")
            })
        })?;
        if radius.is_none()
            && let Some((name, _)) = radius_of(frame, any)
            && let Some(fault) = misread(frame, name)
        {
            return Err(fault);
        }
        let position = near_origin(frame, position.map(|name| Length::of(frame, name, 1.0)));
        let radius = radius.map(|(name, share)| Length::of(frame, name, share));
        let mut units: Vec<String> = position.iter().chain(&radius).filter_map(|length| length.remark(frame)).collect();
        units.dedup();
        remarks.extend(units);
        if position.iter().any(|p| p.origin != 0.0) {
            let [x, y, z] = position.map(|p| p.origin);
            remarks.push(format!("positions are far from the origin, and count from ({x}, {y}, {z})"));
        }
        remarks.extend(several_times(frame));
        let velocity = motion::velocity(frame, &position);
        Ok((Names { position, radius, orientation, velocity }, remarks))
    }

    /// What is to be said of the columns that tell neither position nor radius, but for ids.
    pub(super) fn unused(&self, frame: &Frame) -> Option<String> {
        /// Names that are written.
        const WRITTEN: usize = 12;
        let lengths = || self.position.iter().chain(&self.radius).chain(self.velocity.iter().flatten());
        let turns = |name: &str| self.orientation.is_some_and(|names| names.contains(&name));
        let drawn = |name: &str| turns(name) || lengths().any(|length| length.column == name);
        let others: Vec<&str> =
            frame.names().into_iter().filter(|name| !drawn(name) && simplified(name) != "id").collect();
        let more = others.len().saturating_sub(WRITTEN);
        let more = if more == 0 { String::new() } else { format!(" and {more} more") };
        let names = others.iter().take(WRITTEN).copied().collect::<Vec<_>>().join(", ");
        (!others.is_empty()).then(|| {
            let are = if others.len() == 1 { "is the column" } else { "are the columns" };
            format!(
                "rows are drawn as spheres; not used, but there to select, turn or colour them, {are} {names}{more}"
            )
        })
    }
}

/// Why data of two dimensions has no positions, and the way to draw it.
fn plane_of(frame: &Frame) -> Option<String> {
    let (position, axis) = match ["x", "y", "z"].map(|axis| position_axis(frame, axis)) {
        [Some(x), Some(y), None] => (format!("[{x}, {y}, 0]"), "z"),
        [Some(x), None, Some(z)] => (format!("[{x}, 0, {z}]"), "y"),
        _ => return None,
    };
    Some(format!(
        "the data has no column of {axis}: it is of two dimensions; write a metadata file with `position: {position}` for its objects, or add a column of zeros"
    ))
}

/// The column of an axis, by its name alone or with `pos`.
fn position_axis<'a>(frame: &'a Frame, axis: &str) -> Option<&'a str> {
    only(frame, axis, is_numeric).or_else(|| only(frame, &format!("pos{axis}"), is_numeric))
}

/// Whether a frame has a column of this name with numbers that are not missing.
fn has_numbers(frame: &Frame, name: &str) -> bool {
    is_numeric(frame, name) && frame.column(name).is_some_and(|c| c.range().is_some())
}

/// Why a column is one of words: its first cell that is no number.
fn misread(frame: &Frame, name: &str) -> Option<String> {
    let column = frame.column(name).filter(|c| matches!(c, Column::Category { .. }))?;
    let row = (0..frame.rows()).find(|row| frame::csv::number(&column.text(*row)).is_none())?;
    Some(format!("column `{name}` has `{}` in row {}, which is no number", column.text(row), row + 1))
}

/// What is to be said of a table in which time goes on from row to row.
fn several_times(frame: &Frame) -> Option<String> {
    let name =
        frame.names().into_iter().find(|name| ["time", "timestep", "step"].contains(&simplified(name).as_str()))?;
    let (lo, hi) = frame.column(name)?.range().filter(|(lo, hi)| lo < hi)?;
    Some(format!(
        "`{name}` goes from {lo} to {hi} within a table: all of its rows are in one image; --time '{name}' makes a frame of each time"
    ))
}

/// The columns of a table without names of columns.
struct Unnamed<'a> {
    position: [&'a str; 3],
    radius: Option<&'a str>,
    orientation: Option<[&'a str; 4]>,
}

/// The columns that are taken for positions, radius and orientation in a table without names of columns: the first three of numbers
/// after ids and other whole numbers; then four that are quaternions of length 1, or else the one behind them if it may be a radius.
fn unnamed(frame: &Frame) -> Option<Unnamed<'_>> {
    let names = frame.names();
    let is_named = |(k, name): (usize, &&str)| *name != format!("c{}", k + 1);
    if names.iter().enumerate().any(is_named) {
        return None;
    }
    let numbers: Vec<&str> = names.into_iter().filter(|name| is_numeric(frame, name)).collect();
    // Whole numbers, or those that count the rows: NumPy writes them with decimals.
    let is_whole = |name: &str| match frame.column(name) {
        Some(Column::I64(_)) => true,
        Some(column) if frame.rows() > 3 => {
            let at = |row: usize| column.number(row).unwrap_or(f64::NAN);
            (at(0) == 0.0 || at(0) == 1.0) && (1..frame.rows()).all(|row| at(row) - at(row - 1) == 1.0)
        }
        _ => false,
    };
    let n_leading = numbers.iter().take_while(|name| is_whole(name)).count();
    let skip = if numbers.len() >= n_leading + 3 { n_leading } else { 0 };
    let position: [&str; 3] = numbers.get(skip..skip + 3)?.try_into().ok()?;
    let range = |name: &str| frame.column(name).and_then(Column::range);
    let width = position.iter().filter_map(|name| range(name)).map(|(lo, hi)| hi - lo).fold(0.0, f64::max);
    let behind = numbers.get(skip + 3..skip + 7).and_then(|names| names.try_into().ok());
    let orientation = behind.filter(|names| motion::is_unit(frame, names));
    let may_be_radius =
        |name: &&&str| orientation.is_none() && range(name).is_some_and(|(lo, hi)| lo > 0.0 && hi < 0.5 * width);
    let radius = numbers.get(skip + 3).filter(may_be_radius).copied();
    Some(Unnamed { position, radius, orientation })
}

/// The three columns of positions, of those that are accepted, if the frame has any.
fn position_of(frame: &Frame, accepts: fn(&Frame, &str) -> bool) -> Option<[&str; 3]> {
    let exact =
        POSITIONS.into_iter().find(|p| p.iter().all(|name| frame.column(name).is_some() && accepts(frame, name)));
    let all = |name: &dyn Fn(char) -> String, axes: [char; 3]| {
        let found = axes.map(|axis| only(frame, &name(axis), accepts));
        Some([found[0]?, found[1]?, found[2]?])
    };
    let alike = || {
        PLACES.into_iter().flat_map(|place| AXES.map(|axes| (place, axes))).find_map(|(place, axes)| {
            // Numbers alone are no names of axes.
            let is_named = !place.is_empty() || axes[0] == 'x';
            all(&|axis| format!("{place}{axis}"), axes).filter(|_| is_named)
        })
    };
    // The axis first: `X-Coordinate`, `Particle X`, `x_pos`.
    let turned = || {
        let names = ["", "particle"].into_iter().flat_map(|whose| BEHIND.map(|behind| (whose, behind)));
        let mut names = names.filter(|(whose, behind)| !(whose.is_empty() && behind.is_empty()));
        names.find_map(|(whose, behind)| all(&|axis| format!("{whose}{axis}{behind}"), AXES[0]))
    };
    exact.or_else(alike).or_else(turned)
}

/// The column of the radius, or else of the diameter, of those that are accepted, if the frame has any; with the radius over its value.
fn radius_of(frame: &Frame, accepts: fn(&Frame, &str) -> bool) -> Option<(&str, f64)> {
    let exact = RADII.into_iter().find(|name| frame.column(name).is_some() && accepts(frame, name));
    let alike = |names: &[&str]| names.iter().find_map(|name| only(frame, name, accepts));
    let radius = exact.or_else(|| alike(&["radius", "particleradius", "rad", "r"]));
    let diameter = || alike(&["diameter", "particlediameter", "diam", "dia", "d", "particlesize", "size"]);
    radius.map(|column| (column, 1.0)).or_else(|| diameter().map(|column| (column, 0.5)))
}

/// Whether a column tells the position, the size or the orientation.
pub(super) fn is_position_or_size(frame: &Frame, name: &str) -> bool {
    let usual = POSITIONS.iter().flatten().chain(&RADII).any(|n| *n == name);
    let is_found = |names: Names<'_>| {
        names.position.iter().chain(&names.radius).any(|length| length.column == name)
            || names.orientation.is_some_and(|q| q.contains(&name))
    };
    usual || Names::of(frame).is_ok_and(|(names, _)| is_found(names))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metadata::Quantity;

    fn table(names: &[&str]) -> Frame {
        let mut frame = Frame::new(0, 0.0);
        names.iter().for_each(|name| frame.push(name, "", Column::F64(vec![1.0])));
        frame
    }

    fn columns(frame: &Frame) -> Option<[&str; 3]> {
        Names::of(frame).ok().map(|(names, _)| names.position.map(|length| length.column))
    }

    #[test]
    fn names_of_other_programs_are_known() {
        for names in [
            ["Points:0", "Points:1", "Points:2"],
            ["Position_X", "Position_Y", "Position_Z"],
            ["pos:0", "pos:1", "pos:2"],
            ["coordinates:0", "coordinates:1", "coordinates:2"],
            ["X (m)", "Y (m)", "Z (m)"],
            ["Particle Position X", "Particle Position Y", "Particle Position Z"],
            ["Particle X-Coordinate [m]", "Particle Y-Coordinate [m]", "Particle Z-Coordinate [m]"],
            ["Particle X", "Particle Y", "Particle Z"],
            ["x_pos", "y_pos", "z_pos"],
            ["x_mm", "y_mm", "z_mm"],
            ["Q01 : Particle X Position (m)", "Q02 : Particle Y Position (m)", "Q03 : Particle Z Position (m)"],
        ] {
            assert_eq!(columns(&table(&names)), Some(names));
        }
        assert_eq!(columns(&table(&["id", "X", "y", "Z", "Points:0", "Points:1", "Points:2"])), Some(["X", "y", "Z"]));
        assert_eq!(columns(&table(&["0", "1", "2", "x"])), None);
    }

    #[test]
    fn a_diameter_is_halved_where_there_is_no_radius() {
        let radius =
            |frame: &Frame| radius_of(frame, is_numeric).map(|(name, share)| Length::of(frame, name, share).quantity());
        let text = |names: &[&str]| match radius(&table(names)) {
            Some(Quantity::Expression(text)) => text,
            _ => String::new(),
        };
        assert_eq!(text(&["Diameter"]), "0.5 * Diameter");
        assert_eq!(text(&["d [m]"]), "0.5 * `d [m]`");
        assert_eq!(text(&["d [mm]"]), "0.0005 * `d [mm]`");
        assert_eq!(text(&["r_mm"]), "0.001 * r_mm");
        assert_eq!(text(&["Q04 : Particle Radius (mm)"]), "0.001 * `Q04 : Particle Radius (mm)`");
        assert_eq!(text(&["R (µm)"]), "0.000001 * `R (µm)`");
        assert_eq!(text(&["diam", "Radius"]), "Radius");
        assert_eq!(text(&["id"]), "");
    }

    #[test]
    fn tables_without_names_are_taken_by_their_values() {
        let columns = |columns: &[Column]| {
            let mut frame = Frame::new(0, 0.0);
            columns.iter().enumerate().for_each(|(k, c)| frame.push(&format!("c{}", k + 1), "", c.clone()));
            let (names, remarks) = Names::of(&frame).unwrap();
            assert!(remarks[0].contains("no names"), "{remarks:?}");
            let name = |l: &Length<'_>| l.column.to_string();
            (names.position.iter().map(name).collect::<Vec<_>>().join(" "), names.radius.as_ref().map(name))
        };
        let (ids, place) = (Column::I64(vec![1, 2]), Column::F64(vec![-0.5, 1.5]));
        let (radii, ones) = (Column::F64(vec![0.1, 0.2]), Column::F64(vec![1.0, 1.0]));
        let xyz = [place.clone(), place.clone(), place.clone()];
        assert_eq!(columns(&[&xyz[..], std::slice::from_ref(&radii)].concat()), ("c1 c2 c3".into(), Some("c4".into())));
        assert_eq!(columns(&[std::slice::from_ref(&ids), &xyz[..], &[ones]].concat()), ("c2 c3 c4".into(), None));
        assert_eq!(columns(&[&[ids.clone(), ids.clone()], &xyz[..]].concat()), ("c3 c4 c5".into(), None));
        let [one, none] = [1.0, 0.0].map(|x| Column::F64(vec![x, x]));
        let turned = [&xyz[..], &[one, none.clone(), none.clone(), none]].concat();
        assert_eq!(columns(&turned), ("c1 c2 c3".into(), None));
        // Ids that NumPy has written with decimals.
        let counted = Column::F64((1..6).map(f64::from).collect());
        let many: Vec<Column> =
            (1..5).map(|k| Column::F64((0..5).map(|i| 0.3 * f64::from(i * k % 4)).collect())).collect();
        assert_eq!(columns(&[&[counted], &many[..]].concat()).0, "c2 c3 c4");
        assert_eq!(columns(&[ids.clone(), ids.clone(), ids, radii]), ("c1 c2 c3".into(), Some("c4".into())));
    }

    #[test]
    fn places_far_from_the_origin_count_from_one_among_them() {
        let mut frame = Frame::new(0, 0.0);
        let columns = [vec![450_122.5, 450_123.5], vec![-5e6, -5e6], vec![0.1, 0.2]];
        ["x", "y", "z"].into_iter().zip(columns).for_each(|(name, v)| frame.push(name, "", Column::F64(v)));
        let (names, remarks) = Names::of(&frame).unwrap();
        let text = names.position.map(|p| match p.quantity() {
            Quantity::Expression(text) => text,
            Quantity::Number(x) => x.to_string(),
        });
        assert_eq!(text, ["x - 450123", "y + 5000000", "z"]);
        assert!(remarks[0].contains("(450123, -5000000, 0)"), "{remarks:?}");
    }
}
