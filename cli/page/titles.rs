//! What plots are called: the quantity of curves that share one, and which plots tell more than others.

use crate::job::Plot;

/// The unit of an error of a joint's distances and angles, of which it is the greatest.
const MIXED_UNIT: &str = "m or rad";

/// The title of a plot: that of a single column is its name; that of several says what they are of.
pub fn title(plot: &Plot) -> String {
    if !plot.quantity.is_empty() {
        let is_there = plot.title.ends_with(&plot.quantity);
        return if is_there { plot.title.clone() } else { format!("{}.{}", plot.title, plot.quantity) };
    }
    let Some(quantity) = quantity(plot) else { return plot.title.clone() };
    let in_frame = [("_joint", "in the joint's frame"), ("_world", "in the world's frame")];
    for (ending, words) in in_frame {
        let has_frame = plot.curves.iter().all(|c| c.label.ends_with(ending));
        if let (Some(owner), true) = (plot.title.strip_suffix(ending), has_frame) {
            return format!("{owner}: {quantity} {words}");
        }
    }
    format!("{}: {quantity}", plot.title)
}

/// What the vertical axis of a plot says.
pub fn axis(plot: &Plot) -> String {
    let name = match plot.quantity.as_str() {
        "" => quantity(plot).unwrap_or(""),
        name => name,
    };
    let unit = if plot.unit.is_empty() || plot.unit == "1" { String::new() } else { format!("[{}]", plot.unit) };
    format!("{name} {unit}").trim().to_string()
}

/// The unit of the values of a plot, where they have one.
pub fn unit(plot: &Plot) -> &str {
    if plot.unit == "1" { "" } else { &plot.unit }
}

/// What is to be known of the unit of a plot.
pub fn unit_note(plot: &Plot) -> &'static str {
    if plot.unit == MIXED_UNIT {
        "the greatest error of the locked motions: of distances in m, of angles in rad"
    } else {
        ""
    }
}

/// The quantity that the curves of a plot have in common, if they are parts of one that we know.
fn quantity(plot: &Plot) -> Option<&'static str> {
    let are = |first: &[&str]| plot.curves.iter().all(|c| first.iter().any(|f| c.label.starts_with(f)));
    Some(match plot.unit.as_str() {
        "m" if are(&["x", "y", "z"]) => "position",
        "1" | "" if are(&["qw", "qx", "qy", "qz"]) => "orientation",
        "m/s" if are(&["vx", "vy", "vz"]) => "velocity",
        "rad/s" if are(&["wx", "wy", "wz"]) => "angular velocity",
        "N" => "force",
        "N m" | "N·m" => "torque",
        _ => return None,
    })
}

/// The rank of a plot among those of a page that has not room for all: energies, contacts and forces are first, then what moves, places
/// and orientations last.
pub fn rank(plot: &Plot) -> u8 {
    let part = match plot.quantity.as_str() {
        "" => plot.curves.first().map_or("", |c| c.label.as_str()),
        part => part,
    };
    match (plot.unit.as_str(), part) {
        ("J", _) => 0,
        _ if plot.title.starts_with("contacts") => 0,
        ("N" | "N m", _) => 1,
        (_, "x" | "y" | "z") => 3,
        (_, "qw" | "qx" | "qy" | "qz") => 4,
        _ => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Curve;

    fn plot(title: &str, unit: &str, labels: &[&str]) -> Plot {
        let curve = |label: &&str| Curve { label: label.to_string(), points: vec![], has_start: true };
        let quantity = if labels.len() == 1 { labels[0].to_string() } else { String::new() };
        let curves = labels.iter().map(curve).collect();
        Plot { name: String::new(), title: title.into(), quantity, unit: unit.into(), curves }
    }

    #[test]
    fn titles_say_what_is_shown() {
        let force = plot("drive_joint", "N", &["fx_joint", "fy_joint"]);
        let torque = plot("drive_world", "N m", &["tx_world", "ty_world"]);
        assert_eq!(title(&force), "drive: force in the joint's frame");
        assert_eq!(title(&torque), "drive: torque in the world's frame");
        assert_eq!(
            (title(&plot("block", "m", &["x", "y"])), title(&plot("block", "m", &["x"]))),
            ("block: position".into(), "block.x".into())
        );
        assert_eq!((axis(&force), axis(&plot("block", "1", &["qx"]))), ("force [N]".into(), "qx".into()));
        assert!(rank(&force) < rank(&plot("block", "m", &["x"])) && rank(&plot("energy", "J", &["kinetic"])) == 0);
    }
}
