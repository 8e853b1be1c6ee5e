//! The cells of a column → numbers, one at a time, as long as all of them are plain ones: most columns need no other look at their text.

use super::values::{Decimal, plain_number};
use crate::Column;

/// A column of plain numbers, as far as it has been read: whole ones, or real ones as soon as one is not whole.
#[derive(Clone, Debug, Default)]
pub(crate) struct Numbers {
    whole: Vec<i64>,
    real: Vec<f64>,
    is_real: bool,
    has_point: bool,
    /// Whether a whole number is written `-0`, whose sign would be lost.
    has_minus_zero: bool,
    is_other: bool,
}

impl Numbers {
    /// Read the next cell.
    #[inline]
    pub(crate) fn push(&mut self, cell: &str) {
        if !self.is_real && !self.is_other {
            match whole_number(cell) {
                Some(k) => {
                    self.has_minus_zero |= k == 0 && cell.starts_with('-');
                    self.whole.push(k);
                    return;
                }
                None => self.go_real(),
            }
        }
        if self.is_other {
            return;
        }
        match plain_number(cell) {
            Some(x) => {
                self.has_point = self.has_point || cell.contains('.');
                self.real.push(x);
            }
            None => *self = Numbers { is_other: true, ..Numbers::default() },
        }
    }

    #[cold]
    fn go_real(&mut self) {
        if self.has_minus_zero {
            *self = Numbers { is_other: true, ..Numbers::default() };
            return;
        }
        let whole = std::mem::take(&mut self.whole);
        self.real = whole.into_iter().map(|k| k as f64).collect();
        self.is_real = true;
    }

    /// Whether a cell was no plain number, and the column is to be read as a whole.
    pub(crate) fn is_other(&self) -> bool {
        self.is_other
    }

    /// The column, and the sign that its numbers have.
    pub(crate) fn column(self) -> (Column, Decimal<'static>) {
        match self.is_real {
            true => (Column::F64(self.real), if self.has_point { Decimal::Point } else { Decimal::None }),
            false => (Column::I64(self.whole), Decimal::None),
        }
    }
}

/// A whole number, of few digits without detours.
#[inline]
fn whole_number(cell: &str) -> Option<i64> {
    let bytes = cell.as_bytes();
    let (is_negative, digits) = match bytes {
        [b'-', rest @ ..] => (true, rest),
        _ => (false, bytes),
    };
    if digits.is_empty() || digits.len() > 18 {
        return cell.parse().ok();
    }
    let mut k = 0i64;
    for byte in digits {
        match byte.wrapping_sub(b'0') {
            digit @ 0..10 => k = 10 * k + digit as i64,
            // Signs that are seldom written.
            _ if byte == &b'+' => return cell.parse().ok(),
            _ => return None,
        }
    }
    Some(if is_negative { -k } else { k })
}

#[cfg(test)]
mod tests {
    use super::super::values::column;
    use super::*;

    #[test]
    fn columns_are_those_of_the_cells_together() {
        for cells in [
            &["1", "-20", "+3", "9223372036854775807"][..],
            &["1", "2.5", "-3e2", "nan"],
            &["1", "9223372036854775808"],
            &["1", "-0"],
            &["9007199254740993", "0.5"],
            &["1e3", "7"],
            &["-0.0", "inf"],
            &[],
        ] {
            let mut numbers = Numbers::default();
            cells.iter().for_each(|cell| numbers.push(cell));
            assert!(!numbers.is_other(), "{cells:?}");
            // Not-a-numbers differ from themselves.
            assert_eq!(format!("{:?}", numbers.column()), format!("{:?}", column(cells).unwrap()));
        }
        for cells in
            [&["1", "NA"][..], &["-0", "0.5"], &["1", ""], &["1.5", "1,5"], &["a"], &["1", "a", "2"], &["1.0D+3"]]
        {
            let mut numbers = Numbers::default();
            cells.iter().for_each(|cell| numbers.push(cell));
            assert!(numbers.is_other(), "{cells:?}");
        }
    }
}
