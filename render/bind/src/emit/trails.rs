//! Trails: curves through the last places of bodies.

use super::rows::{Rows, exprs};
use crate::binding::{Binding, Color, Object, Reach, Trail};
use crate::moment::Moment;
use frame::{Column, Fault, Frame};
use ri::{Class, Declaration, Param, Params, Ri, RiResult, Type, Values};
use std::collections::HashMap;

/// Curves of the trails of an object.
#[derive(Default)]
pub struct Curves {
    /// Count of vertices of each; the first and the last stand twice.
    n_vertices: Vec<i32>,
    points: Vec<f32>,
    /// At each place of a trail: width, opacity and, if the object is coloured by a value, colour.
    widths: Vec<f32>,
    opacities: Vec<f32>,
    colors: Vec<f32>,
}

/// A place of a body.
#[derive(Clone)]
struct Place {
    at: [f32; 3],
    color: Option<[f32; 3]>,
    /// How far back it is, from 0 to 1 at the trail's end.
    age: f32,
}

/// The trails of the `i`th object.
pub(super) fn prepare(
    binding: &Binding,
    i: usize,
    object: &Object,
    trail: Trail,
    moment: &Moment,
) -> Result<Curves, Fault> {
    let mut curves = Curves::default();
    let width = super::camera::width(binding, i, "trail", trail.width)?;
    let age = |k: usize, frame: &Frame| match trail.reach {
        Reach::Time(seconds) => ((moment.frame.time - frame.time) / seconds) as f32,
        Reach::Frames(n) => k as f32 / n as f32,
    };
    // The bodies of the present, and where they were, the latest place first.
    let mut trails: Vec<(Key, Vec<Place>)> = vec![];
    let mut index = HashMap::new();
    for (k, frame) in std::iter::once(moment.frame).chain(moment.before.iter().rev().map(|table| &**table)).enumerate()
    {
        if frame.rows() == 0 {
            break;
        }
        let rows = if k == 0 { Rows::of(binding, i, object, frame)? } else { Rows::all(binding, i, frame) };
        let age = age(k, frame);
        for (key, place) in places(&rows, object, age)? {
            if k == 0 {
                index.insert(key, trails.len());
                trails.push((key, vec![place]));
            } else if let Some(at) = index.get(&key) {
                let trail = &mut trails[*at].1;
                // A body that was away starts anew.
                if trail.len() == k {
                    trail.push(place);
                }
            }
        }
    }
    for (_, places) in &mut trails {
        cut(places);
        if places.len() > 1 {
            curves.add(places, width, trail.fade);
        }
    }
    Ok(curves)
}

/// What tells a row from others in all frames: its `id` and `part`, or its place where the data has no ids.
type Key = (u64, u64);

/// The places of rows.
fn places(rows: &Rows, object: &Object, age: f32) -> Result<Vec<(Key, Place)>, Fault> {
    let at = rows.vectors("position", exprs(&object.position))?;
    let colors = match &object.color {
        Color::By { value, map, range } => Some(rows.colors(value, *map, *range)?.0),
        Color::Rgb(_) => None,
    };
    let [id, part] = ["id", "part"].map(|name| rows.frame.column(name));
    let key = |row: usize| {
        let number = |column: Option<&Column>| match column? {
            // Of large ones a number in double precision would be that of others, too.
            Column::I64(whole) => whole.get(row).map(|k| *k as u64),
            other => other.number(row).map(f64::to_bits),
        };
        (number(id).unwrap_or(row as u64), number(part).unwrap_or(0))
    };
    let place = |k: usize| {
        let color = colors.as_ref().map(|param| [0, 1, 2].map(|c| param.numbers()[3 * k + c]));
        (key(rows.rows[k]), Place { at: at[k], color, age })
    };
    Ok((0..at.len()).filter(|k| at[*k].iter().all(|x| x.is_finite())).map(place).collect())
}

/// Cut a trail at its end, within the last step.
fn cut(places: &mut [Place]) {
    let [.., before, last] = places else { return };
    if last.age > 1.0 && before.age < 1.0 {
        let part = (1.0 - before.age) / (last.age - before.age);
        last.at = [0, 1, 2].map(|c| before.at[c] + part * (last.at[c] - before.at[c]));
        last.age = 1.0;
    }
}

impl Curves {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.n_vertices.is_empty()
    }

    fn add(&mut self, places: &[Place], width: f32, fade: bool) {
        let n = places.len();
        self.n_vertices.push(n as i32 + 2);
        for k in std::iter::once(0).chain(0..n).chain([n - 1]) {
            self.points.extend(places[k].at);
        }
        for place in places {
            let rest = if fade { (1.0 - place.age).clamp(0.0, 1.0) } else { 1.0 };
            self.widths.push(width * (0.35 + 0.65 * rest));
            self.opacities.extend([rest; 3]);
            self.colors.extend(place.color.iter().flatten());
        }
    }

    /// Draw them.
    pub(super) fn draw(&self, opacity: f32, ri: &mut dyn Ri) -> RiResult {
        /// The basis of curves that go through their points.
        const THROUGH: [f32; 16] =
            [-0.5, 1.5, -1.5, 0.5, 1.0, -2.5, 2.0, -0.5, -0.5, 0.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0];
        let param = |name: &str, class, ty, values: Vec<f32>| Param {
            decl: Declaration::new(name, class, ty),
            values: Values::Floats(values),
        };
        let mut params: Params = vec![
            param("P", Class::Vertex, Type::Point, self.points.clone()),
            param("width", Class::Varying, Type::Float, self.widths.clone()),
            param("Os", Class::Varying, Type::Color, self.opacities.iter().map(|o| o * opacity).collect()),
        ];
        if !self.colors.is_empty() {
            params.push(param("Cs", Class::Varying, Type::Color, self.colors.clone()));
        }
        // They fade along few pixels, whatever the quality.
        ri.shading_rate(1.0)?;
        ri.basis(THROUGH, 1, THROUGH, 1)?;
        ri.curves("cubic", self.n_vertices.clone(), "nonperiodic", params)
    }
}
