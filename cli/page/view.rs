//! What stands on a page, as its template takes it: texts and numbers as they are read, without any markup.

use serde::Serialize;

/// A page.
#[derive(Default, Serialize)]
pub struct Page {
    /// Its title.
    pub title: String,
    /// What it is of.
    pub kind: String,
    /// The folder; empty if the title is its name.
    pub folder: String,
    /// A line on how far the run is, and whether that is the whole of it.
    pub state: String,
    /// How it stands for that.
    pub tone: Tone,
    /// Why it ended before its end; empty if it did not.
    pub cause: String,
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
    /// What is said where there are none.
    pub no_warnings: String,
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
    /// Whether some of the runs have an image.
    pub has_images: bool,
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

/// How a run stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// As it should be.
    #[default]
    Good,
    /// It goes on, or has warnings: it needs attention.
    Open,
    /// It is not to be used as it is.
    Bad,
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
    /// The run of a sweep that it is of; empty on the page of a run.
    pub run: String,
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
    /// How it stands for that.
    pub tone: Tone,
}

/// Plots of one kind.
#[derive(Serialize)]
pub struct Section {
    /// Its heading: `energy`, `solver` and `probes` stand at their own places.
    pub name: String,
    /// Its plots.
    pub plots: Vec<PlotHead>,
    /// What is not plotted, since it is constant.
    pub constants: Vec<Constant>,
}

/// A value that stays what it is.
#[derive(Serialize)]
pub struct Constant {
    /// What it is of.
    pub name: String,
    /// The value.
    pub value: String,
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
    /// Whether its vertical range leaves something out.
    pub is_cut: bool,
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
