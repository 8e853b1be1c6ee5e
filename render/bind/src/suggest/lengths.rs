//! Columns of lengths: their units, and the place that large coordinates count from.

use crate::expr;
use crate::metadata::Quantity;
use frame::Frame;

/// A column of lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Length<'a> {
    pub(super) column: &'a str,
    /// Metres over the column's value: the column's unit, and a half for diameters.
    pub(super) factor: f64,
    /// The column's value that is 0 m.
    pub(super) origin: f64,
}

/// Units of length, m, by their signs.
const UNITS: [(&str, f64); 13] = [
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
    ("inch", 0.0254),
    ("ft", 0.3048),
    ("feet", 0.3048),
];

/// The unit of a column: that of its field, or what stands in brackets in its name.
fn unit<'a>(frame: &'a Frame, name: &'a str) -> Option<&'a str> {
    let field = frame.columns.iter().map(|(field, _)| field).find(|field| field.name == name)?;
    let bracketed = || Some(name.rsplit_once(['(', '['])?.1.trim_end_matches([')', ']']));
    // `x_mm`, of the units that are not letters of other names.
    let behind = || Some(name.rsplit_once('_')?.1).filter(|unit| ["mm", "cm", "um", "nm", "km"].contains(unit));
    let unit = if field.unit.is_empty() { bracketed().or_else(behind)? } else { &field.unit };
    Some(unit.trim()).filter(|unit| !matches!(*unit, "" | "-" | "1"))
}

impl<'a> Length<'a> {
    /// The lengths of a column of which `share` is wanted.
    pub(super) fn of(frame: &'a Frame, column: &'a str, share: f64) -> Length<'a> {
        let known = unit(frame, column).and_then(|sign| UNITS.into_iter().find(|(unit, _)| *unit == sign));
        Length { column, factor: share * known.map_or(1.0, |(_, metres)| metres), origin: 0.0 }
    }

    /// The velocities of a column, m/s; without a unit they are in that of the positions, over seconds. None if the unit is another.
    pub(super) fn of_velocity(frame: &'a Frame, column: &'a str, position: &Length<'_>) -> Option<Length<'a>> {
        let factor = match unit(frame, column) {
            None => position.factor,
            Some(sign) => {
                let length = sign.strip_suffix("/s")?;
                UNITS.into_iter().find(|(unit, _)| *unit == length)?.1
            }
        };
        Some(Length { column, factor, origin: 0.0 })
    }

    /// What is to be said of the column's unit.
    pub(super) fn remark(&self, frame: &Frame) -> Option<String> {
        let sign = unit(frame, self.column)?;
        match UNITS.into_iter().find(|(unit, _)| *unit == sign) {
            Some((_, 1.0)) => None,
            Some((_, metres)) => Some(format!("lengths in {sign} are read as {metres} m each")),
            None => Some(format!("`{sign}` is no unit of length that scree knows: its numbers are read as metres")),
        }
    }

    /// The length of a value of the column, m.
    pub(super) fn metres(&self, value: f64) -> f64 {
        (value - self.origin) * self.factor
    }

    /// The length as a metadata file has it.
    pub(super) fn quantity(self) -> Quantity {
        let column = expr::quoted(self.column);
        let (sign, origin) = if self.origin < 0.0 { ("+", -self.origin) } else { ("-", self.origin) };
        Quantity::Expression(match (self.factor == 1.0, origin == 0.0) {
            (true, true) => column,
            (true, false) => format!("{column} {sign} {origin}"),
            (false, true) => format!("{} * {column}", self.factor),
            (false, false) => format!("{} * ({column} {sign} {origin})", self.factor),
        })
    }
}

/// Count positions from a place among them if they are so far from the origin that single precision tells them hardly apart.
pub(super) fn near_origin<'a>(frame: &Frame, position: [Length<'a>; 3]) -> [Length<'a>; 3] {
    /// Distance from the origin over the width of the data from which on it matters.
    const FAR: f64 = 1000.0;
    let ranges = position.map(|p| frame.column(p.column).and_then(|c| c.range()).unwrap_or((0.0, 0.0)));
    let width = ranges.iter().map(|(lo, hi)| hi - lo).fold(0.0, f64::max);
    let width = if width > 0.0 && width.is_finite() { width } else { 1.0 };
    let step = 10f64.powf(width.log10().ceil());
    let mut axes = position.into_iter().zip(ranges).map(|(length, (lo, hi))| {
        let middle = 0.5 * (lo + hi);
        let is_far = middle.is_finite() && middle.abs() > FAR * width;
        Length { origin: if is_far { (middle / step).round() * step } else { 0.0 }, ..length }
    });
    std::array::from_fn(|k| axes.next().unwrap_or(position[k]))
}
