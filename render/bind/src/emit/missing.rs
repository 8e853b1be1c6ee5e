//! What the rows of a frame lack of what is drawn of them.

use crate::binding::{Binding, Object};
use frame::{Column, Frame};

/// Rows of a frame that lack values of what is drawn of them.
#[derive(Clone, Debug, Default)]
pub struct Missing {
    /// Rows without a place or a size, or with a size that is not above 0, which are not drawn.
    pub undrawn: Lack,
    /// Rows without a value of their colour, which are magenta.
    pub uncolored: Lack,
    /// Names of the objects that no row of the frame is of.
    pub absent: Vec<String>,
    /// What the binding asks for and the frame has no columns of, each with its place in the file.
    pub columns: Vec<String>,
}

/// The columns of orientations and velocities that stand for those of objects that give none.
pub(super) const ORIENTATION: [&str; 4] = ["quat_w", "quat_x", "quat_y", "quat_z"];
pub(super) const VELOCITY: [&str; 3] = ["vel_x", "vel_y", "vel_z"];

/// What is not drawn as the binding asks, since the frame has not all columns of it: orientations of which some columns are there, and the
/// motion while the shutter is open.
pub(super) fn columns(binding: &Binding, frame: &Frame) -> Vec<String> {
    if frame.rows() == 0 {
        return vec![];
    }
    let names = frame.names();
    let lacking = |of: &[&'static str]| of.iter().copied().filter(|name| !names.contains(name)).collect::<Vec<_>>();
    let say = |key: &str, message: String, lacking: &[&str]| {
        let (line, column) = binding.doc.place(key);
        let others = || names.iter().copied().filter(|name| !ORIENTATION.contains(name) && !VELOCITY.contains(name));
        let near = lacking.first().and_then(|name| frame::nearest(name, others()));
        let near =
            near.map_or(String::new(), |near| format!("; did you mean `{near}`, which `data: {{rename: …}}` renames?"));
        format!("{}:{line}:{column}: {message}{near}", binding.doc.path.display())
    };
    let mut said = vec![];
    let own = || binding.objects.iter().enumerate().filter(|(_, object)| !object.of_contacts);
    let turns = lacking(&ORIENTATION);
    if let Some((i, object)) = own().find(|(_, object)| object.orientation.is_none())
        && (1..4).contains(&turns.len())
    {
        let missing = frame::listed(&turns);
        let message =
            format!("the object `{}` is drawn without its orientation: the data has no {missing}", object.name);
        said.push(say(&format!("objects.{i}"), message, &turns));
    }
    let moves = lacking(&VELOCITY);
    if binding.output.shutter > 0.0 && !moves.is_empty() && own().all(|(_, object)| object.velocity.is_none()) {
        let missing = frame::listed(&moves);
        let message =
            format!("nothing moves while the shutter is open: the data has no {missing}, and no object a `velocity`");
        said.push(say("output.shutter", message, &moves));
    }
    said.extend(rounded(binding, frame));
    said
}

/// The whole numbers that expressions round, one for each column: they count in double precision.
fn rounded(binding: &Binding, frame: &Frame) -> Vec<String> {
    /// Beyond it, not every whole number is one in double precision.
    const EXACT: u64 = 1 << f64::MANTISSA_DIGITS;
    let of_data =
        binding.data.iter().flat_map(|data| data.derive.iter().map(|(_, formula)| formula).chain(&data.select));
    let own = binding.objects.iter().filter(|object| !object.of_contacts).flat_map(Object::formulas);
    let mut seen: Vec<&str> = vec![];
    let mut said = vec![];
    for formula in of_data.chain(own) {
        for name in formula.expr.columns() {
            let Some(Column::I64(whole)) = frame.column(name).filter(|_| !seen.contains(&name.as_str())) else {
                continue;
            };
            seen.push(name);
            if let Some(k) = whole.iter().find(|k| k.unsigned_abs() > EXACT) {
                let (line, column) = binding.doc.place(&formula.key);
                let file = binding.doc.path.display();
                said.push(format!(
                    "{file}:{line}:{column}: `{name}` has {k}: expressions round whole numbers beyond {EXACT}, so that different ones may be taken for equal"
                ));
            }
        }
    }
    said
}

/// Rows that lack a value.
#[derive(Clone, Debug, Default)]
pub struct Lack {
    /// Number of rows.
    pub rows: usize,
    /// The first of them, from 1, and the expression that has no value.
    pub first: Option<(usize, String)>,
}

impl Lack {
    /// Add the rows of another object or frame.
    pub fn add(&mut self, other: &Lack) {
        self.rows += other.rows;
        self.first = self.first.take().or(other.first.clone());
    }
}
