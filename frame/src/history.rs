//! Histories: tables whose rows are of different times, of one body a file or of all in one, turned into a frame for each time.
//!
//! A frame has the rows of its time, file by file; its number is the place of its time among all times. Where there are several files,
//! the column `body` has the number in the file's name.

use crate::{Column, Fault, FaultKind, Field, Frame, sequence};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// Histories, read whole: they are in memory together.
#[derive(PartialEq)]
pub struct Histories {
    /// The files.
    pub files: Vec<PathBuf>,
    /// What tells the files from any others that stood in their place.
    stamp: String,
    /// The distinct times, ascending.
    times: Vec<f64>,
    /// All rows of all files, in columns.
    columns: Vec<(Field, Column)>,
    /// The rows of each time.
    rows: Vec<Vec<usize>>,
}

impl fmt::Debug for Histories {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Histories({})", self.stamp)
    }
}

/// Difference of two times over their size below which they are one.
const ROUNDING: f64 = 1e-9;

impl Histories {
    /// Read the files of a pattern by `read`, whose rows have their time in the column `time`. An error as of [`sequence::find`], if a file
    /// cannot be read, has no such column, or has other columns than the first.
    pub fn read(
        pattern: &Path,
        read: impl Fn(&Path, u64) -> Result<Frame, Fault>,
        time: &str,
    ) -> Result<Histories, Fault> {
        let files = sequence::find(pattern)?;
        let mut stamp = blake3::Hasher::new();
        let (mut times, mut bodies) = (vec![], vec![]);
        let mut columns: Vec<(Field, Joined)> = vec![];
        for (body, path) in &files {
            let table = read(path, *body)?;
            let meta = path.metadata().map(|m| (m.len(), m.modified().ok()));
            stamp.update(format!("{path:?}{:?}", meta.unwrap_or_default()).as_bytes());
            times.extend(times_of(&table, path, time)?);
            bodies.extend(std::iter::repeat_n(*body as i64, table.rows()));
            if columns.is_empty() {
                columns = table.columns.iter().map(|(field, _)| (field.clone(), Joined::default())).collect();
            }
            if !table.columns.iter().map(|(field, _)| field).eq(columns.iter().map(|(field, _)| field)) {
                let names: Vec<&str> = columns.iter().map(|(field, _)| field.name.as_str()).collect();
                let message = format!("has other columns than the first file, expected {}", crate::listed(&names));
                return Err(Fault::whole(FaultKind::Data, path, message));
            }
            columns.iter_mut().zip(&table.columns).for_each(|((_, all), (_, column))| all.add(column));
        }
        let mut columns: Vec<(Field, Column)> = columns.into_iter().map(|(field, all)| (field, all.column())).collect();
        if files.len() > 1 && columns.iter().all(|(field, _)| field.name != "body") {
            columns.push((Field::new("body", ""), Column::I64(bodies)));
        }
        let mut order: Vec<usize> = (0..times.len()).collect();
        order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
        // What differs by rounding is one time.
        let is_same = |a: f64, b: f64| (a - b).abs() <= ROUNDING * a.abs().max(b.abs());
        let rows: Vec<Vec<usize>> =
            order.chunk_by(|a, b| is_same(times[*a], times[*b])).map(<[usize]>::to_vec).collect();
        let times = rows.iter().map(|rows| times[rows[0]]).collect();
        let (files, stamp) = (files.into_values().collect(), stamp.finalize().to_hex().to_string());
        Ok(Histories { files, stamp, times, columns, rows })
    }

    /// Count of distinct times.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there are no rows at all.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// The rows of the time of an index, as the frame of that number.
    pub fn frame(&self, index: usize) -> Frame {
        let rows = &self.rows[index];
        let some = |column: &Column| match column {
            Column::F64(v) => Column::F64(rows.iter().map(|r| v[*r]).collect()),
            Column::F32(v) => Column::F32(rows.iter().map(|r| v[*r]).collect()),
            Column::I64(v) => Column::I64(rows.iter().map(|r| v[*r]).collect()),
            Column::Category { codes, names } => {
                Column::Category { codes: rows.iter().map(|r| codes[*r]).collect(), names: names.clone() }
            }
        };
        let columns = self.columns.iter().map(|(field, column)| (field.clone(), some(column))).collect();
        Frame { number: index as u64, time: self.times[index], columns }
    }
}

/// The times of a table's rows.
fn times_of(table: &Frame, path: &Path, name: &str) -> Result<Vec<f64>, Fault> {
    let names = table.names();
    let Some(column) = table.column(name) else {
        let message = format!("has no column `{name}` of times, it has {}", crate::listed(&names));
        return Err(Fault::whole(FaultKind::Data, path, message));
    };
    let time = |row: usize| match column.number(row).filter(|time| time.is_finite()) {
        Some(time) => Ok(time),
        None => {
            let message = format!("row {} has no number for its time in `{name}`: `{}`", row + 1, column.text(row));
            Err(Fault::whole(FaultKind::Data, path, message))
        }
    };
    (0..table.rows()).map(time).collect()
}

/// A column of several files, one behind the other.
#[derive(Default)]
struct Joined {
    numbers: Vec<f64>,
    /// Whether all numbers are whole ones.
    is_whole: Option<bool>,
    /// The words so far, where there are any.
    words: Option<(Vec<u32>, BTreeMap<String, u32>)>,
}

impl Joined {
    fn add(&mut self, column: &Column) {
        let is_whole = matches!(column, Column::I64(_));
        self.is_whole = Some(self.is_whole.unwrap_or(true) && is_whole);
        if let Column::Category { .. } = column
            && self.words.is_none()
        {
            let mut words = (vec![], BTreeMap::new());
            self.numbers.iter().for_each(|x| word(&mut words, x.to_string()));
            self.words = Some(words);
        }
        match &mut self.words {
            Some(words) => (0..column.len()).for_each(|row| word(words, column.text(row))),
            None => self.numbers.extend((0..column.len()).filter_map(|row| column.number(row))),
        }
    }

    fn column(self) -> Column {
        match self.words {
            Some((codes, words)) => {
                let mut names = vec![String::new(); words.len()];
                words.into_iter().for_each(|(word, code)| names[code as usize] = word);
                Column::Category { codes, names }
            }
            None if self.is_whole == Some(true) => Column::I64(self.numbers.iter().map(|x| *x as i64).collect()),
            None => Column::F64(self.numbers),
        }
    }
}

/// Add a word to a column of words.
fn word((codes, words): &mut (Vec<u32>, BTreeMap<String, u32>), text: String) {
    let next = words.len() as u32;
    codes.push(*words.entry(text).or_insert(next));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(files: &[(&str, &str)], time: &str) -> Result<Histories, Fault> {
        let folder = tempfile::tempdir().unwrap();
        files.iter().for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
        let read = |path: &Path, number| crate::csv::read(path, number, &Default::default());
        Histories::read(&folder.path().join("b*"), read, time)
    }

    #[test]
    fn histories_of_bodies_become_frames() {
        let all = read(
            &[("b_3.csv", "t,x,kind\n0,1,a\n0.5,2,a\n"), ("b_7.csv", "t,x,kind\n0.5,30,b\n0,20,b\n1,40,b\n")],
            "t",
        );
        let all = all.unwrap();
        assert_eq!(all.len(), 3);
        let frame = all.frame(1);
        assert_eq!((frame.number, frame.time, frame.rows()), (1, 0.5, 2));
        assert_eq!(frame.column("x"), Some(&Column::I64(vec![2, 30])));
        assert_eq!(frame.column("body"), Some(&Column::I64(vec![3, 7])));
        assert_eq!(frame.column("kind").unwrap().text(1), "b");
        assert_eq!(all.frame(2).rows(), 1);
    }

    #[test]
    fn one_table_of_all_times_needs_no_names_of_bodies() {
        let all = read(&[("b.csv", "time,id,x\n1,1,0\n0,1,5\n1,2,7\n")], "time").unwrap();
        assert_eq!((all.len(), all.frame(1).column("x")), (2, Some(&Column::I64(vec![0, 7]))));
        assert!(all.frame(0).column("body").is_none());
    }

    #[test]
    fn what_is_no_history_is_named() {
        let message = |files: &[(&str, &str)], time: &str| read(files, time).unwrap_err().message;
        assert!(message(&[("b.csv", "t,x\n0,1\n")], "time").contains("no column `time`"));
        assert!(message(&[("b.csv", "t,x\n0,1\nNA,1\n")], "t").contains("row 2 has no number"));
        let two = [("b1.csv", "t,x\n0,1\n"), ("b2.csv", "t,y\n0,1\n")];
        assert!(message(&two, "t").contains("has other columns"));
    }
}
