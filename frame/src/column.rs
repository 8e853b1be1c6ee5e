//! Named, typed, unit-carrying columns, and the table of one instant that they make.

use std::collections::HashSet;

/// Name and unit of a column; the unit is SI text such as `m/s`, or empty for a pure number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Column name, such as `pos_x`.
    pub name: String,
    /// Unit, such as `m`.
    pub unit: String,
}

impl Field {
    /// A field of a name and a unit.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Field {
        Field { name: name.into(), unit: unit.into() }
    }
}

/// The values of a column, one per row.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Double precision.
    F64(Vec<f64>),
    /// Single precision.
    F32(Vec<f32>),
    /// Integers.
    I64(Vec<i64>),
    /// Words from a short list of categories: the word of a row is `names[codes[row]]`.
    Category {
        /// Index into `names`; `[n_rows]`.
        codes: Vec<u32>,
        /// The words of the categories.
        names: Vec<String>,
    },
}

impl Column {
    /// Count of rows.
    pub fn len(&self) -> usize {
        match self {
            Column::F64(v) => v.len(),
            Column::F32(v) => v.len(),
            Column::I64(v) => v.len(),
            Column::Category { codes, .. } => codes.len(),
        }
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The name of the column's type, as in `run.json` and messages: `f64`, `f32`, `i64` or `category`.
    pub fn kind(&self) -> &'static str {
        match self {
            Column::F64(_) => "f64",
            Column::F32(_) => "f32",
            Column::I64(_) => "i64",
            Column::Category { .. } => "category",
        }
    }

    /// The value of a row as a number; `None` for a word.
    pub fn number(&self, row: usize) -> Option<f64> {
        match self {
            Column::F64(v) => Some(v[row]),
            Column::F32(v) => Some(v[row] as f64),
            Column::I64(v) => Some(v[row] as f64),
            Column::Category { .. } => None,
        }
    }

    /// The value of a row as text.
    pub fn text(&self, row: usize) -> String {
        match self {
            Column::F64(v) => format!("{}", v[row]),
            Column::F32(v) => format!("{}", v[row]),
            Column::I64(v) => format!("{}", v[row]),
            Column::Category { codes, names } => names[codes[row] as usize].clone(),
        }
    }

    /// Minimum and maximum of the column, NaN ignored; `None` for words and empty columns.
    pub fn range(&self) -> Option<(f64, f64)> {
        let mut range: Option<(f64, f64)> = None;
        for row in 0..self.len() {
            let x = self.number(row)?;
            if !x.is_nan() {
                let (lo, hi) = range.unwrap_or((x, x));
                range = Some((lo.min(x), hi.max(x)));
            }
        }
        range
    }
}

/// The table of one instant: columns of equal length.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The frame's number, which identifies it.
    pub number: u64,
    /// Time, s.
    pub time: f64,
    /// The columns, all of the same length.
    pub columns: Vec<(Field, Column)>,
}

impl Frame {
    /// A frame without columns; `time` in s.
    pub fn new(number: u64, time: f64) -> Frame {
        Frame { number, time, columns: Vec::new() }
    }

    /// Add a column. Its length is that of the frame's other columns.
    pub fn push(&mut self, name: &str, unit: &str, column: Column) {
        debug_assert!(self.columns.is_empty() || self.rows() == column.len());
        self.columns.push((Field::new(name, unit), column));
    }

    /// Reduce the frame to the rows of these indices, in this order.
    pub fn keep(&mut self, rows: &[usize]) {
        fn some<T: Copy>(v: &mut Vec<T>, rows: &[usize]) {
            *v = rows.iter().map(|r| v[*r]).collect();
        }
        for (_, column) in &mut self.columns {
            match column {
                Column::F64(v) => some(v, rows),
                Column::F32(v) => some(v, rows),
                Column::I64(v) => some(v, rows),
                Column::Category { codes, .. } => some(codes, rows),
            }
        }
    }

    /// Count of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, c)| c.len())
    }

    /// The column of this name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|(f, _)| f.name == name).map(|(_, c)| c)
    }

    /// All column names, in order.
    pub fn names(&self) -> Vec<&str> {
        self.columns.iter().map(|(f, _)| f.name.as_str()).collect()
    }
}

/// The index of the first name that stands before already.
pub fn repeated<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<usize> {
    let mut seen = HashSet::new();
    names.into_iter().position(|name| !seen.insert(name))
}

/// The number of names for a message, and the names if they are few.
pub(crate) fn counted(names: &[&str]) -> String {
    /// Names beside which a fault is still seen.
    const FEW: usize = 24;
    if names.len() > FEW { names.len().to_string() } else { format!("{} ({})", names.len(), listed(names)) }
}

/// Names for a message, the first few of many, in one line.
pub fn listed(names: &[&str]) -> String {
    /// Names that are written out.
    const FEW: usize = 40;
    /// Characters of a name that are.
    const LONGEST: usize = 60;
    let short = |name: &str| match name.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.into(),
    };
    let shown: Vec<String> = names.iter().take(FEW).map(|name| short(name)).collect();
    let more = if names.len() > FEW { format!(", … ({} in all)", names.len()) } else { String::new() };
    guard::text::line(&shown.join(", ")) + &more
}
