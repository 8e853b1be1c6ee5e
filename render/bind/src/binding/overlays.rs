//! Overlays of images, as a metadata file has them under `overlays`: title, time stamp, scale bar, colour legend, axis triad and a plot
//! that grows with time. Each is a map of its settings, or `true` for all defaults; the title and the plot may be a text.

use super::object::{Color, Object};
use frame::Fault;
use frame::yaml::Document;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt::Formatter;
use std::marker::PhantomData;
use std::path::PathBuf;

/// What is written over the images.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a map")]
pub struct Overlays {
    /// A title: a text, or a map.
    #[serde(deserialize_with = "switch", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Switch<Title>>")]
    pub title: Option<Title>,
    /// The time of the frame: true, or a map.
    #[serde(deserialize_with = "switch", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Switch<TimeStamp>>")]
    pub time: Option<TimeStamp>,
    /// A scale bar: true, or a map.
    #[serde(deserialize_with = "switch", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Switch<ScaleBar>>")]
    pub scale_bar: Option<ScaleBar>,
    /// The colours of an object's values: true, or a map.
    #[serde(deserialize_with = "switch", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Switch<Legend>>")]
    pub legend: Option<Legend>,
    /// The directions of the axes: true, or a map.
    #[serde(deserialize_with = "switch", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Switch<Axes>>")]
    pub axes: Option<Axes>,
    /// A plot that grows with time: the name of a column, or a map.
    #[serde(deserialize_with = "switch", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Switch<GrowingPlot>>")]
    pub plot: Option<GrowingPlot>,
    /// Factor of the size of all of them, which goes with the image's size.
    pub size: f32,
    /// What is behind their texts: `dark`, `light` or `none`.
    pub panel: Panel,
}

/// What is behind the texts of overlays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Panel {
    /// A dark panel, through which the image is seen.
    #[default]
    Dark,
    /// A light panel.
    Light,
    /// None: pale texts have a dark rim.
    None,
}

/// A corner of the image. Overlays of one corner are stacked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Corner {
    /// Upper left.
    TopLeft,
    /// Upper right.
    TopRight,
    /// Lower left.
    BottomLeft,
    /// Lower right.
    BottomRight,
}

/// A title.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Title {
    /// The text.
    pub text: String,
    /// Corner of the image.
    #[serde(default = "top_left")]
    pub corner: Corner,
}

/// The time of the frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a map")]
pub struct TimeStamp {
    /// What stands before the time.
    pub label: String,
    /// Unit, `s`, `ms`, `us`, `min` or `h`.
    pub unit: String,
    /// Decimals; if not given, as many as tell the frames apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimals: Option<usize>,
    /// Time from a frame to the next, s, for data that has no times; the frame 0 is at 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_frame: Option<f64>,
    /// Corner of the image.
    pub corner: Corner,
}

/// A scale bar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a map")]
pub struct ScaleBar {
    /// Length, m; if not given, a round length about a fifth of the image's width.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Corner of the image.
    pub corner: Corner,
}

/// The colours of an object's values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a map")]
pub struct Legend {
    /// Name of the object; the only one that is coloured by a column if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// What the values are; the column if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Unit of the values; the column's if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Corner of the image.
    pub corner: Corner,
}

/// The directions of the axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a map")]
pub struct Axes {
    /// Corner of the image.
    pub corner: Corner,
}

/// A plot that grows with time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct GrowingPlot {
    /// Columns of one unit.
    pub columns: Vec<String>,
    /// A CSV with a column `time`, relative to this file's folder; the probes and the report of the run if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// What the values are; the columns if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Unit of the values; the first column's if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Corner of the image.
    #[serde(default = "bottom_right")]
    pub corner: Corner,
}

/// Units of time, and the seconds in each.
pub const TIME_UNITS: [(&str, f64); 5] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("min", 60.0), ("h", 3600.0)];

/// The most columns of a plot.
const MOST_COLUMNS: usize = 4;

impl Overlays {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        let Overlays { title, time, scale_bar, legend, axes, plot, .. } = self;
        title.is_none() && time.is_none() && scale_bar.is_none() && legend.is_none() && axes.is_none() && plot.is_none()
    }

    /// Check the settings; the legend gets the name of its object. `is_placed` says whether the file places the camera. An error is at the
    /// key of the first bad value.
    pub fn check(&mut self, doc: &Document, is_placed: bool, objects: &[Object]) -> Result<(), Fault> {
        if !(0.3..=4.0).contains(&self.size) {
            return Err(doc.fault("overlays.size", "expected a number from 0.3 to 4"));
        }
        if self.title.as_ref().is_some_and(|title| title.text.trim().is_empty()) {
            return Err(doc.fault("overlays.title", "is empty, expected a text"));
        }
        self.check_time(doc)?;
        if self.scale_bar.as_ref().and_then(|bar| bar.length).is_some_and(|l| !(l > 0.0 && l.is_finite())) {
            return Err(doc.fault("overlays.scale_bar.length", "expected metres, more than 0"));
        }
        for (key, is_on) in [("scale_bar", self.scale_bar.is_some()), ("axes", self.axes.is_some())] {
            if is_on && !is_placed {
                let message = "needs a `camera` with `eye` and `look_at`, or with a `view`";
                return Err(doc.fault(&format!("overlays.{key}"), message));
            }
        }
        if let Some(plot) = &self.plot
            && !(1..=MOST_COLUMNS).contains(&plot.columns.len())
        {
            return Err(doc.fault("overlays.plot.columns", format!("expected 1 to {MOST_COLUMNS} names of columns")));
        }
        self.legend.as_mut().map_or(Ok(()), |legend| legend.find(doc, objects))
    }

    fn check_time(&self, doc: &Document) -> Result<(), Fault> {
        let Some(time) = &self.time else { return Ok(()) };
        let units = TIME_UNITS.map(|(name, _)| name);
        if !units.contains(&time.unit.as_str()) {
            return Err(doc.unknown("overlays.time.unit", "unit of time", &time.unit, &units));
        }
        if time.decimals.is_some_and(|n| n > 9) {
            return Err(doc.fault("overlays.time.decimals", "expected a whole number from 0 to 9"));
        }
        if time.per_frame.is_some_and(|s| !(s > 0.0 && s.is_finite())) {
            return Err(doc.fault("overlays.time.per_frame", "expected seconds, more than 0"));
        }
        Ok(())
    }
}

impl Legend {
    /// Find the object that it is of.
    fn find(&mut self, doc: &Document, objects: &[Object]) -> Result<(), Fault> {
        let is_by_value = |o: &&Object| matches!(o.color, Color::By { .. });
        let names: Vec<&str> = objects.iter().filter(is_by_value).map(|o| o.name.as_str()).collect();
        match (&self.object, &names[..]) {
            (_, []) => {
                Err(doc.fault("overlays.legend", "no object is coloured by a column: there is nothing to explain"))
            }
            (Some(name), names) if !names.contains(&name.as_str()) => {
                Err(doc.unknown("overlays.legend.object", "object that is coloured by a column", name, names))
            }
            (None, [only]) => {
                self.object = Some(only.to_string());
                Ok(())
            }
            (None, names) => Err(doc
                .fault("overlays.legend", format!("needs `object`: {} are coloured by columns", frame::listed(names)))),
            _ => Ok(()),
        }
    }
}

impl Default for Overlays {
    fn default() -> Overlays {
        let (title, time, scale_bar, legend, axes, plot) = (None, None, None, None, None, None);
        Overlays { title, time, scale_bar, legend, axes, plot, size: 1.0, panel: Panel::Dark }
    }
}

impl Default for TimeStamp {
    fn default() -> TimeStamp {
        let (label, unit) = ("t = ".into(), "s".into());
        TimeStamp { label, unit, decimals: None, per_frame: None, corner: Corner::TopRight }
    }
}

impl Default for ScaleBar {
    fn default() -> ScaleBar {
        ScaleBar { length: None, corner: Corner::BottomLeft }
    }
}

impl Default for Legend {
    fn default() -> Legend {
        Legend { object: None, label: None, unit: None, corner: Corner::TopRight }
    }
}

impl Default for Axes {
    fn default() -> Axes {
        Axes { corner: Corner::BottomLeft }
    }
}

fn top_left() -> Corner {
    Corner::TopLeft
}

fn bottom_right() -> Corner {
    Corner::BottomRight
}

/// An overlay as it may be written.
#[derive(schemars::JsonSchema)]
#[serde(untagged)]
#[allow(dead_code, reason = "for the schema alone")]
enum Switch<T> {
    /// Whether it is there.
    On(bool),
    /// Its text.
    Text(String),
    /// Its settings.
    Map(T),
}

/// An overlay that may be written shorter than by a map.
trait Short: Sized {
    /// What may be written.
    const EXPECTED: &'static str;

    /// What `true` stands for, if it may be written.
    fn on() -> Option<Self> {
        None
    }

    /// What a text stands for, if it may be written.
    fn of_text(_: &str) -> Option<Self> {
        None
    }
}

/// What may be written of an overlay that has defaults for all.
const TRUE_OR_MAP: &str = "true, false or a map";

impl Short for Title {
    const EXPECTED: &'static str = "a text or a map";

    fn of_text(text: &str) -> Option<Title> {
        Some(Title { text: text.into(), corner: top_left() })
    }
}

impl Short for GrowingPlot {
    const EXPECTED: &'static str = "the name of a column or a map";

    fn of_text(text: &str) -> Option<GrowingPlot> {
        let (columns, corner) = (vec![text.into()], bottom_right());
        Some(GrowingPlot { columns, file: None, label: None, unit: None, corner })
    }
}

impl Short for TimeStamp {
    const EXPECTED: &'static str = TRUE_OR_MAP;

    fn on() -> Option<TimeStamp> {
        Some(TimeStamp::default())
    }
}

impl Short for ScaleBar {
    const EXPECTED: &'static str = TRUE_OR_MAP;

    fn on() -> Option<ScaleBar> {
        Some(ScaleBar::default())
    }
}

impl Short for Legend {
    const EXPECTED: &'static str = TRUE_OR_MAP;

    fn on() -> Option<Legend> {
        Some(Legend::default())
    }
}

impl Short for Axes {
    const EXPECTED: &'static str = TRUE_OR_MAP;

    fn on() -> Option<Axes> {
        Some(Axes::default())
    }
}

/// Read an overlay: true, false, a text or a map.
fn switch<'de, D: Deserializer<'de>, T: Short + Deserialize<'de>>(from: D) -> Result<Option<T>, D::Error> {
    struct Any<T>(PhantomData<T>);
    impl<'de, T: Short + Deserialize<'de>> Visitor<'de> for Any<T> {
        type Value = Option<T>;

        fn expecting(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
            f.write_str(T::EXPECTED)
        }

        fn visit_bool<E: Error>(self, on: bool) -> Result<Option<T>, E> {
            let invalid = || E::invalid_type(serde::de::Unexpected::Bool(on), &self);
            let all = T::on().ok_or_else(invalid)?;
            Ok(on.then_some(all))
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<Option<T>, E> {
            let invalid = || E::invalid_type(serde::de::Unexpected::Str(text), &self);
            T::of_text(text).map(Some).ok_or_else(invalid)
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Option<T>, A::Error> {
            T::deserialize(MapAccessDeserializer::new(map)).map(Some)
        }
    }
    from.deserialize_any(Any(PhantomData))
}
