//! Named, typed, unit-carrying columns, and the table of one instant that they make.

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
    /// Whole numbers.
    I64(Vec<i64>),
    /// Words out of a short list: `names[codes[row]]`.
    Category {
        /// Index into `names`, per row.
        codes: Vec<u32>,
        /// The words.
        names: Vec<String>,
    },
}

impl Column {
    /// Number of rows.
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

    /// The type's name, as `run.json` and messages give it.
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

    /// Least and greatest number, `None` for words and empty columns; not-a-numbers are passed over.
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

/// The table of one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The frame's number: its identity, whatever its place in a listing.
    pub number: u64,
    /// Time, s.
    pub time: f64,
    /// The columns, all of the same length.
    pub columns: Vec<(Field, Column)>,
}

impl Frame {
    /// An empty table.
    pub fn new(number: u64, time: f64) -> Frame {
        Frame { number, time, columns: Vec::new() }
    }

    /// Add a column. All columns of a frame have the same length.
    pub fn push(&mut self, name: &str, unit: &str, column: Column) {
        debug_assert!(self.columns.is_empty() || self.rows() == column.len());
        self.columns.push((Field::new(name, unit), column));
    }

    /// Keep some rows, in the order in which they are given.
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

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, c)| c.len())
    }

    /// The column of a name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|(f, _)| f.name == name).map(|(_, c)| c)
    }

    /// All column names, in order.
    pub fn names(&self) -> Vec<&str> {
        self.columns.iter().map(|(f, _)| f.name.as_str()).collect()
    }
}
