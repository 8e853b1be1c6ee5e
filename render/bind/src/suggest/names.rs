//! Names that columns of positions and sizes go by in other programs.

use crate::expr;
use crate::metadata::Quantity;
use frame::{Column, Frame};

/// Names of positions that are looked for first, as they are.
const POSITIONS: [[&str; 3]; 5] =
    [["pos_x", "pos_y", "pos_z"], ["x", "y", "z"], ["X", "Y", "Z"], ["px", "py", "pz"], ["c1", "c2", "c3"]];

/// Names of a radius that are looked for first, as they are.
const RADII: [&str; 6] = ["radius", "r", "R", "rad", "half_x", "c4"];

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

/// The last letters of the three columns of a vector.
const AXES: [[char; 3]; 3] = [['x', 'y', 'z'], ['0', '1', '2'], ['1', '2', '3']];

/// The columns from which places and sizes are read.
pub(super) struct Names<'a> {
    pub(super) position: [Length<'a>; 3],
    pub(super) radius: Option<Length<'a>>,
}

/// A column of lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Length<'a> {
    pub(super) column: &'a str,
    /// Metres over the column's value: the column's unit, and a half for diameters.
    pub(super) factor: f64,
}

impl Length<'_> {
    /// The length as a metadata file has it.
    pub(super) fn quantity(self) -> Quantity {
        let column = expr::quoted(self.column);
        Quantity::Expression(if self.factor == 1.0 { column } else { format!("{} * {column}", self.factor) })
    }
}

/// Units of length, m, by their signs.
const UNITS: [(&str, f64); 11] = [
    ("m", 1.0),
    ("dm", 0.1),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("um", 1e-6),
    ("µm", 1e-6),
    ("μm", 1e-6),
    ("nm", 1e-9),
    ("km", 1e3),
    ("in", 0.0254),
    ("ft", 0.3048),
];

/// The unit of a column of lengths that is not the metre, and its length, m: that of its field, or what stands in brackets in its name.
pub(super) fn unit<'a>(frame: &'a Frame, name: &'a str) -> Option<(&'a str, f64)> {
    let field = frame.columns.iter().map(|(field, _)| field).find(|field| field.name == name)?;
    let bracketed = || Some(name.rsplit_once(['(', '['])?.1.trim_end_matches([')', ']']));
    let sign = if field.unit.is_empty() { bracketed()? } else { &field.unit };
    UNITS.into_iter().find(|(unit, _)| *unit == sign.trim()).filter(|(_, metres)| *metres != 1.0)
}

/// A column of lengths; `share` of its values is the length wanted.
fn length<'a>(frame: &'a Frame, column: &'a str, share: f64) -> Length<'a> {
    Length { column, factor: share * unit(frame, column).map_or(1.0, |(_, metres)| metres) }
}

/// Whether a frame has a column of numbers of this name.
pub(super) fn is_numeric(frame: &Frame, name: &str) -> bool {
    // What stands between backticks cannot have one.
    !name.contains('`') && frame.column(name).is_some_and(|c| !matches!(c, Column::Category { .. }))
}

/// The three columns of positions, if the frame has any.
pub(super) fn position(frame: &Frame) -> Option<[Length<'_>; 3]> {
    let exact = POSITIONS.into_iter().find(|p| p.iter().all(|name| is_numeric(frame, name)));
    let alike = || {
        PLACES.into_iter().flat_map(|place| AXES.map(|axes| (place, axes))).find_map(|(place, axes)| {
            // Numbers alone are no names of axes.
            let is_named = !place.is_empty() || axes[0] == 'x';
            let found = axes.map(|axis| only(frame, &format!("{place}{axis}"))).map(|found| found.filter(|_| is_named));
            Some([found[0]?, found[1]?, found[2]?])
        })
    };
    exact.or_else(alike).map(|names| names.map(|name| length(frame, name, 1.0)))
}

/// The column of the radius, or else of the diameter, if the frame has any.
pub(super) fn radius(frame: &Frame) -> Option<Length<'_>> {
    let exact = RADII.into_iter().find(|name| is_numeric(frame, name));
    let radius = exact.or_else(|| ["radius", "particleradius", "rad", "r"].iter().find_map(|name| only(frame, name)));
    let diameter = || ["diameter", "particlediameter", "diam", "dia", "d"].iter().find_map(|name| only(frame, name));
    let halved = || diameter().map(|column| length(frame, column, 0.5));
    radius.map(|column| length(frame, column, 1.0)).or_else(halved)
}

/// Whether a column tells the position or the size.
pub(super) fn is_position_or_size(frame: &Frame, name: &str) -> bool {
    let usual = POSITIONS.iter().flatten().chain(&RADII).any(|n| *n == name);
    usual
        || position(frame).is_some_and(|p| p.iter().any(|p| p.column == name))
        || radius(frame).is_some_and(|r| r.column == name)
}

/// The one column of numbers whose name is this but for capitals, units and characters between letters.
fn only<'a>(frame: &'a Frame, simple: &str) -> Option<&'a str> {
    let mut found = frame.names().into_iter().filter(|name| simplified(name) == simple && is_numeric(frame, name));
    found.next().filter(|_| found.next().is_none())
}

/// A name in small letters, without a unit in brackets and without other characters than letters and digits.
fn simplified(name: &str) -> String {
    let name = name.split_once(['(', '[']).map_or(name, |(name, _)| name);
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(names: &[&str]) -> Frame {
        let mut frame = Frame::new(0, 0.0);
        names.iter().for_each(|name| frame.push(name, "", Column::F64(vec![1.0])));
        frame
    }

    fn columns(frame: &Frame) -> Option<[&str; 3]> {
        position(frame).map(|p| p.map(|length| length.column))
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
        ] {
            assert_eq!(columns(&table(&names)), Some(names));
        }
        assert_eq!(columns(&table(&["id", "X", "y", "Z", "Points:0", "Points:1", "Points:2"])), Some(["X", "y", "Z"]));
        assert_eq!(columns(&table(&["0", "1", "2", "x"])), None);
    }

    #[test]
    fn a_diameter_is_halved_where_there_is_no_radius() {
        let text = |names: &[&str]| match radius(&table(names)).map(Length::quantity) {
            Some(Quantity::Expression(text)) => text,
            _ => String::new(),
        };
        assert_eq!(text(&["Diameter"]), "0.5 * Diameter");
        assert_eq!(text(&["d [m]"]), "0.5 * `d [m]`");
        assert_eq!(text(&["d [mm]"]), "0.0005 * `d [mm]`");
        assert_eq!(text(&["R (µm)"]), "0.000001 * `R (µm)`");
        assert_eq!(text(&["diam", "Radius"]), "Radius");
        assert_eq!(text(&["id"]), "");
    }
}
