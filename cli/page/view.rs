//! What stands on a page, as its template takes it: texts and numbers as they are read, without any markup.

use serde::Serialize;

/// A page.
#[derive(Default, Serialize)]
pub struct Page {
    /// Its title.
    pub title: String,
    /// What it is of.
    pub kind: String,
    /// A line on how far the run is, and whether that is the whole of it.
    pub state: String,
    /// Whether the state needs attention.
    pub is_open: bool,
    /// What is not shown.
    pub notes: Vec<String>,
    /// What cannot be read.
    pub faults: Vec<String>,
    /// The film.
    pub film: Option<Film>,
    /// Further films.
    pub films: Vec<Link>,
    /// Images.
    pub images: Vec<Image>,
    /// How many images there are.
    pub n_images: String,
    /// Numbers.
    pub figures: Vec<Figure>,
    /// Warnings, by kind.
    pub warnings: Vec<Warning>,
    /// The energy balance.
    pub energy: Option<Table>,
    /// What is to be known of it.
    pub energy_note: String,
    /// How well the contacts were solved.
    pub solver: Option<Table>,
    /// Milliseconds of a step by stage.
    pub stages: Vec<Stage>,
    /// The runs of a sweep.
    pub runs: Vec<Run>,
    /// Their values, in a table to sort.
    pub table: Option<Table>,
    /// Plots, in sections.
    pub sections: Vec<Section>,
    /// What is to be known of the plots.
    pub plot_note: String,
    /// Where the run is from.
    pub provenance: Vec<Figure>,
    /// Its files.
    pub files: Vec<File>,
    /// Its model.
    pub model: Option<String>,
}

/// A film.
#[derive(Serialize)]
pub struct Film {
    /// What shows it: `video`, `image`, `link`, or `none`.
    pub tag: String,
    /// Its address.
    pub source: String,
    /// Its name.
    pub name: String,
    /// What is to be known of it.
    pub note: String,
}

/// A link to a file.
#[derive(Serialize)]
pub struct Link {
    /// What it is called.
    pub name: String,
    /// Its address.
    pub address: String,
}

/// An image.
#[derive(Serialize)]
pub struct Image {
    /// Its address.
    pub source: String,
    /// The address of the whole image.
    pub address: Option<String>,
    /// The file's name and size.
    pub title: String,
    /// What stands below it.
    pub caption: String,
    /// Its width, pixels.
    pub width: u32,
    /// Its height, pixels.
    pub height: u32,
}

/// A value by its name.
#[derive(Serialize)]
pub struct Figure {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: String,
    /// What is to be known of it.
    pub note: String,
}

/// A warning.
#[derive(Serialize)]
pub struct Warning {
    /// Its kind.
    pub kind: String,
    /// Steps that it concerns.
    pub steps: String,
    /// The first of them.
    pub first: String,
    /// What was said of that.
    pub message: String,
}

/// A table.
#[derive(Serialize)]
pub struct Table {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Rows.
    pub rows: Vec<Vec<Cell>>,
}

/// A cell of a table.
#[derive(Clone, Serialize)]
pub struct Cell {
    /// Its text.
    pub text: String,
    /// Its number, by which rows are sorted.
    pub value: Option<f64>,
}

/// A stage of the step.
#[derive(Serialize)]
pub struct Stage {
    /// Its name.
    pub name: String,
    /// Its time.
    pub time: String,
    /// Its part of the step's, percent.
    pub percent: String,
}

/// A run of a sweep.
#[derive(Serialize)]
pub struct Run {
    /// Its name.
    pub name: String,
    /// What is particular to it.
    pub values: Vec<String>,
    /// An image of it.
    pub image: Option<Image>,
    /// Its own page.
    pub page: Option<Link>,
    /// How far it is.
    pub state: String,
    /// Whether the state needs attention.
    pub is_open: bool,
}

/// Plots of one kind.
#[derive(Serialize)]
pub struct Section {
    /// Its heading: `energy`, `solver` and `probes` stand at their own places.
    pub name: String,
    /// Its plots.
    pub plots: Vec<PlotHead>,
}

/// A plot whose data stands in the script.
#[derive(Serialize)]
pub struct PlotHead {
    /// Its index there.
    pub index: usize,
    /// What it shows.
    pub title: String,
    /// What is to be known of its axes.
    pub note: String,
}

/// A file of a run.
#[derive(Serialize)]
pub struct File {
    /// Its name.
    pub name: String,
    /// Its size.
    pub size: String,
    /// Its BLAKE3 hash.
    pub hash: String,
    /// What is to be known of it.
    pub note: String,
}

impl Cell {
    /// A number.
    pub fn number(value: f64) -> Cell {
        Cell { text: super::number::short(value), value: value.is_finite().then_some(value) }
    }

    /// A text. One that is a number is sorted by it.
    pub fn text(text: impl Into<String>) -> Cell {
        let text = text.into();
        Cell { value: text.parse().ok().filter(|x: &f64| x.is_finite()), text }
    }
}

impl Figure {
    /// A value without a note.
    pub fn new(name: &str, value: impl Into<String>) -> Figure {
        Figure { name: name.into(), value: value.into(), note: String::new() }
    }

    /// The same with a note.
    pub fn noted(self, note: impl Into<String>) -> Figure {
        Figure { note: note.into(), ..self }
    }
}
