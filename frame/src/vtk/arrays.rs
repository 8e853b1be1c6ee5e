//! Arrays of VTK files: tuples of numbers of a type, from bytes or text, and the table of points that they make.

use crate::{Column, Fault, FaultKind, Field, Frame, csv};
use std::collections::HashSet;
use std::path::Path;

/// Most components of a tuple.
const COMPONENTS: usize = 1 << 10;

/// A file that is read, and its bytes.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) path: &'a Path,
    pub(super) bytes: &'a [u8],
}

impl Source<'_> {
    /// A fault at a byte: with its line where the file is text until there.
    pub(super) fn fault(&self, at: usize, message: impl Into<String>) -> Fault {
        /// Bytes of a line that is shown.
        const SHOWN: usize = 1 << 12;
        let at = at.min(self.bytes.len());
        let (before, after) = self.bytes.split_at(at);
        if memchr::memchr(0, before).is_some() {
            return Fault::whole(FaultKind::Data, self.path, format!("{}, at byte {at}", message.into()));
        }
        let start = memchr::memrchr(b'\n', before).map_or(0, |end| end + 1);
        let end = at + memchr::memchr(b'\n', after).unwrap_or(after.len());
        let column = 1 + String::from_utf8_lossy(&before[start..]).chars().count();
        let line = 1 + memchr::memchr_iter(b'\n', before).count();
        let shown = if end - start > SHOWN { &[] } else { &self.bytes[start..end] };
        let text = String::from_utf8_lossy(shown).trim_end().to_string();
        Fault { text, line, column, ..Fault::whole(FaultKind::Data, self.path, message) }
    }
}

/// The order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Order {
    Little,
    Big,
}

/// The type of the numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scalar {
    Bit,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    /// The type of a name in legacy files.
    pub(super) fn of_legacy(name: &str) -> Option<Scalar> {
        Some(match name.to_ascii_lowercase().as_str() {
            "bit" => Scalar::Bit,
            "char" | "signed_char" => Scalar::I8,
            "unsigned_char" => Scalar::U8,
            "short" => Scalar::I16,
            "unsigned_short" => Scalar::U16,
            // Ids are written as 32 bits, whatever they are in memory.
            "int" | "vtkidtype" => Scalar::I32,
            "unsigned_int" => Scalar::U32,
            "long" | "vtktypeint64" => Scalar::I64,
            "unsigned_long" | "vtktypeuint64" => Scalar::U64,
            "float" => Scalar::F32,
            "double" => Scalar::F64,
            _ => return None,
        })
    }

    /// The type of a name in XML files.
    pub(super) fn of_xml(name: &str) -> Option<Scalar> {
        Some(match name {
            "Int8" => Scalar::I8,
            "UInt8" => Scalar::U8,
            "Int16" => Scalar::I16,
            "UInt16" => Scalar::U16,
            "Int32" => Scalar::I32,
            "UInt32" => Scalar::U32,
            "Int64" => Scalar::I64,
            "UInt64" => Scalar::U64,
            "Float32" => Scalar::F32,
            "Float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Bytes of a count of numbers.
    pub(super) fn bytes(self, n: usize) -> Option<usize> {
        match self {
            Scalar::Bit => Some(n.div_ceil(8)),
            Scalar::I8 | Scalar::U8 => Some(n),
            Scalar::I16 | Scalar::U16 => n.checked_mul(2),
            Scalar::I32 | Scalar::U32 | Scalar::F32 => n.checked_mul(4),
            Scalar::I64 | Scalar::U64 | Scalar::F64 => n.checked_mul(8),
        }
    }

    /// The columns of tuples of `width` numbers; of bits, the first `n`.
    pub(super) fn columns(self, bytes: &[u8], n: usize, width: usize, order: Order) -> Vec<Column> {
        macro_rules! columns {
            ($T:ty, $column:ident, $to:ty) => {
                match order {
                    Order::Little => split(bytes, width, |b| <$T>::from_le_bytes(b) as $to),
                    Order::Big => split(bytes, width, |b| <$T>::from_be_bytes(b) as $to),
                }
                .into_iter()
                .map(Column::$column)
                .collect()
            };
        }
        match self {
            Scalar::Bit => {
                let bit = |k: usize| i64::from(bytes[k / 8] >> (7 - k % 8) & 1);
                (0..width).map(|c| Column::I64((0..n).map(|row| bit(row * width + c)).collect())).collect()
            }
            Scalar::I8 => columns!(i8, I64, i64),
            Scalar::U8 => columns!(u8, I64, i64),
            Scalar::I16 => columns!(i16, I64, i64),
            Scalar::U16 => columns!(u16, I64, i64),
            Scalar::I32 => columns!(i32, I64, i64),
            Scalar::U32 => columns!(u32, I64, i64),
            Scalar::I64 => columns!(i64, I64, i64),
            Scalar::U64 => {
                let whole: Vec<Column> = columns!(u64, I64, i64);
                // Those beyond what a whole number may be here are numbers nevertheless.
                let is_whole = |c: &Column| matches!(c, Column::I64(v) if v.iter().all(|x| *x >= 0));
                if whole.iter().all(is_whole) { whole } else { columns!(u64, F64, f64) }
            }
            Scalar::F32 => columns!(f32, F32, f32),
            Scalar::F64 => columns!(f64, F64, f64),
        }
    }
}

/// Numbers of N bytes in tuples → the numbers of each component.
fn split<const N: usize, T>(bytes: &[u8], width: usize, number: impl Fn([u8; N]) -> T) -> Vec<Vec<T>> {
    let component = |k: usize| {
        let tuples = bytes.chunks_exact(N * width);
        tuples.map(|tuple| number(*tuple[k * N..].first_chunk().expect("a tuple has its numbers"))).collect()
    };
    (0..width).map(component).collect()
}

/// Words between blanks, from a byte of a file to another.
pub(super) struct Words<'a> {
    pub(super) source: Source<'a>,
    pub(super) at: usize,
    pub(super) end: usize,
}

impl<'a> Words<'a> {
    /// The next word, and where it begins.
    fn next(&mut self) -> Option<(usize, &'a [u8])> {
        let bytes = &self.source.bytes[..self.end];
        let start = self.at + bytes.get(self.at..)?.iter().position(|b| !b.is_ascii_whitespace())?;
        let length = bytes[start..].iter().position(u8::is_ascii_whitespace);
        self.at = length.map_or(self.end, |length| start + length);
        Some((start, &bytes[start..self.at]))
    }

    /// Whether there is no further word.
    pub(super) fn is_empty(&mut self) -> bool {
        let at = self.at;
        let is_empty = self.next().is_none();
        self.at = at;
        is_empty
    }

    /// The columns of `n` tuples of `width` numbers of a type; `what` they are, for faults.
    pub(super) fn columns(&mut self, kind: Scalar, n: usize, width: usize, what: &str) -> Result<Vec<Column>, Fault> {
        let left = (self.end - self.at).div_ceil(2);
        let count = n.checked_mul(width).filter(|count| *count <= left && *count as u64 <= guard::memory::room() / 8);
        let count = count.ok_or_else(|| {
            let message = format!("{what} has not the {n} × {width} numbers that are said to be there");
            self.source.fault(self.at, message).hint("the file was cut off, or its counts are wrong")
        })?;
        macro_rules! columns {
            ($column:ident, $parse:expr, $expected:literal) => {{
                let mut columns: Vec<Vec<_>> = (0..width).map(|_| Vec::with_capacity(n)).collect();
                for k in 0..count {
                    let (at, word) = self.next().ok_or_else(|| {
                        let message = format!("{what} ends after {k} of {count} numbers");
                        self.source.fault(self.end, message).hint("the file was cut off, or its counts are wrong")
                    })?;
                    let number = std::str::from_utf8(word).ok().and_then($parse);
                    columns[k % width].push(number.ok_or_else(|| {
                        let message = format!("expected {} of {what}, number {} of {count}", $expected, k + 1);
                        self.source.fault(at, message)
                    })?);
                }
                Ok(columns.into_iter().map(Column::$column).collect())
            }};
        }
        match kind {
            Scalar::F32 => columns!(F32, |w| w.parse::<f32>().ok().or_else(|| nan(w).map(|x| x as f32)), "a number"),
            Scalar::F64 => columns!(F64, |w| w.parse::<f64>().ok().or_else(|| nan(w)), "a number"),
            _ => {
                let (lo, hi) = kind.extent();
                columns!(I64, |w| whole(w).filter(|x| (lo..=hi).contains(x)), "a whole number within its type")
            }
        }
    }
}

impl Scalar {
    /// The least and the greatest whole number of a type.
    fn extent(self) -> (i64, i64) {
        match self {
            Scalar::Bit => (0, 1),
            Scalar::I8 => (i8::MIN.into(), i8::MAX.into()),
            Scalar::U8 => (0, u8::MAX.into()),
            Scalar::I16 => (i16::MIN.into(), i16::MAX.into()),
            Scalar::U16 => (0, u16::MAX.into()),
            Scalar::I32 => (i32::MIN.into(), i32::MAX.into()),
            Scalar::U32 => (0, u32::MAX.into()),
            Scalar::U64 => (0, i64::MAX),
            Scalar::I64 | Scalar::F32 | Scalar::F64 => (i64::MIN, i64::MAX),
        }
    }
}

/// Not-a-number as the C libraries of systems write it: `-nan(ind)`, `1.#QNAN`.
fn nan(word: &str) -> Option<f64> {
    csv::number(word).filter(|x| x.is_nan() && word.len() > 4)
}

/// A whole number, which some writers write with a fraction of zero.
fn whole(word: &str) -> Option<i64> {
    /// Whole numbers that a float has without loss.
    const EXACT: f64 = 9007199254740992.0;
    let float = || word.parse::<f64>().ok().filter(|x| x.fract() == 0.0 && x.abs() <= EXACT);
    word.parse().ok().or_else(|| float().map(|x| x as i64))
}

/// An array of a table: a name, and the column of each component.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Array {
    pub(super) name: String,
    pub(super) columns: Vec<Column>,
}

impl Array {
    /// Count of tuples.
    pub(super) fn len(&self) -> usize {
        self.columns.first().map_or(0, Column::len)
    }

    /// Names of the columns.
    fn names(&self) -> Vec<String> {
        match self.columns.len() {
            1 => vec![self.name.clone()],
            3 => ["x", "y", "z"].map(|axis| format!("{}_{axis}", self.name)).to_vec(),
            n => (0..n).map(|k| format!("{}_{k}", self.name)).collect(),
        }
    }
}

/// Check a count of components; an error says what is wrong with it.
pub(super) fn check_width(width: usize) -> Result<usize, String> {
    if (1..=COMPONENTS).contains(&width) {
        return Ok(width);
    }
    Err(format!("expected a count of components from 1 to {COMPONENTS}"))
}

/// Points, and the arrays that have a tuple for each.
#[derive(Debug, Default)]
pub(super) struct Points {
    /// The coordinates; none, if there are no points.
    pub(super) place: Vec<Column>,
    pub(super) arrays: Vec<Array>,
    /// Time, s, if it is told.
    pub(super) time: Option<f64>,
}

impl Points {
    /// Count of points.
    pub(super) fn len(&self) -> usize {
        self.place.first().map_or(0, Column::len)
    }

    /// Add the arrays of cells, of which each is one point of those at `point`. They are left out if not every point is one cell.
    pub(super) fn add_cells(&mut self, arrays: Vec<Array>, point: &[i64]) {
        let n = self.len();
        let mut cell_of = vec![usize::MAX; n];
        for (cell, point) in point.iter().enumerate() {
            match usize::try_from(*point).ok().and_then(|point| cell_of.get_mut(point)) {
                Some(place) if *place == usize::MAX => *place = cell,
                _ => return,
            }
        }
        if point.len() != n {
            return;
        }
        let is_in_order = cell_of.is_sorted();
        for mut array in arrays.into_iter().filter(|array| array.len() == n) {
            if !is_in_order {
                let field = Field::new("", "");
                let columns = array.columns.into_iter().map(|column| (field.clone(), column)).collect();
                let mut frame = Frame { number: 0, time: 0.0, columns };
                frame.keep(&cell_of);
                array.columns = frame.columns.into_iter().map(|(_, column)| column).collect();
            }
            self.arrays.push(array);
        }
    }

    /// Add the points of another piece. An error if it has not the same arrays; a piece without points may have none.
    pub(super) fn append(&mut self, other: Points) -> Result<(), String> {
        self.time = self.time.or(other.time);
        if other.len() == 0 && (self.len() > 0 || other.arrays.is_empty()) {
            return Ok(());
        }
        if self.len() == 0 {
            (self.place, self.arrays) = (other.place, other.arrays);
            return Ok(());
        }
        if let Some(missing) = self.arrays.iter().find(|own| other.arrays.iter().all(|array| array.name != own.name)) {
            return Err(format!("has no array `{}`, as the pieces before it have", missing.name));
        }
        extend(&mut self.place, other.place);
        for array in other.arrays {
            let Some(own) = self.arrays.iter_mut().find(|own| own.name == array.name) else {
                return Err(format!("has an array `{}`, and the pieces before it have none", array.name));
            };
            if own.columns.len() != array.columns.len() {
                let (n, expected) = (array.columns.len(), own.columns.len());
                return Err(format!(
                    "has {n} components in `{}`, and the pieces before it have {expected}",
                    array.name
                ));
            }
            extend(&mut own.columns, array.columns);
        }
        let n = self.len();
        match self.arrays.iter().find(|array| array.len() != n) {
            Some(array) => Err(format!("has `{}` twice, or not at all", array.name)),
            None => Ok(()),
        }
    }

    /// The table: x, y and z, and a column for each component of the arrays.
    pub(super) fn frame(self, number: u64) -> Frame {
        let mut frame = Frame::new(number, self.time.unwrap_or(0.0));
        let mut seen = HashSet::new();
        let place = self.place.into_iter().zip(["x", "y", "z"].map(String::from));
        let others = self.arrays.into_iter().flat_map(|array| {
            let names = array.names();
            array.columns.into_iter().zip(names)
        });
        for (column, name) in place.chain(others) {
            let mut own = name.clone();
            let mut k = 2;
            while !seen.insert(own.clone()) {
                own = format!("{name}_{k}");
                k += 1;
            }
            frame.columns.push((Field::new(own, ""), column));
        }
        frame
    }
}

/// Add rows to columns; where their types are not the same, as numbers of double precision.
fn extend(columns: &mut [Column], others: Vec<Column>) {
    for (own, other) in columns.iter_mut().zip(others) {
        match (&mut *own, other) {
            (Column::F64(own), Column::F64(other)) => own.extend(other),
            (Column::F32(own), Column::F32(other)) => own.extend(other),
            (Column::I64(own), Column::I64(other)) => own.extend(other),
            (_, other) => {
                let numbers =
                    |c: &Column| (0..c.len()).map(|row| c.number(row).unwrap_or(f64::NAN)).collect::<Vec<_>>();
                *own = Column::F64([numbers(own), numbers(&other)].concat());
            }
        }
    }
}
