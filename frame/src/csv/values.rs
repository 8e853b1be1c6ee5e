//! The cells of a column → numbers or words.
//!
//! Numbers may have a decimal comma (`1,5`), an exponent as Fortran writes it (`1.0D+03`, `1.0+100`), or be missing (empty, `NA`).

use crate::Column;
use std::collections::HashMap;

/// What a cell is by itself.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum CellKind {
    Number,
    Missing,
    Word,
}

/// What a cell is by itself.
pub(super) fn kind_of(cell: &str) -> CellKind {
    match plain_number(cell).or_else(|| unusual_number(cell)) {
        Some(x) if !x.is_nan() => CellKind::Number,
        Some(_) => CellKind::Missing,
        None if is_missing(cell) => CellKind::Missing,
        None => CellKind::Word,
    }
}

/// Words that stand for no value, but for those that are read as not-a-numbers anyway; an empty cell is one more.
const MISSING: [&str; 14] = [
    "na",
    "n/a",
    "#n/a",
    "<na>",
    "null",
    "none",
    "-",
    "--",
    "nan(ind)",
    "-nan(ind)",
    "1.#ind",
    "-1.#ind",
    "1.#qnan",
    "-1.#qnan",
];

fn is_missing(cell: &str) -> bool {
    cell.is_empty() || (cell.len() <= 9 && MISSING.iter().any(|word| cell.eq_ignore_ascii_case(word)))
}

/// A word as a number, not-a-number if it stands for a missing value.
pub fn number(word: &str) -> Option<f64> {
    plain_number(word).or_else(|| unusual_number(word)).or_else(|| is_missing(word).then_some(f64::NAN))
}

/// A number as programs write it: a point, an exponent.
#[inline]
pub(super) fn plain_number(cell: &str) -> Option<f64> {
    short_number(cell.as_bytes()).or_else(|| cell.parse().ok())
}

/// A number of few digits without an exponent. Its digits and the power of ten are exact, and so their quotient is rounded once, as
/// it is where numbers are parsed else (Clinger, "How to read floating point numbers accurately", 1990).
#[inline]
fn short_number(cell: &[u8]) -> Option<f64> {
    const TENS: [f64; 16] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
    let (is_negative, cell) = match cell {
        [b'-', rest @ ..] => (true, rest),
        _ => (false, cell),
    };
    // Fifteen digits and a point.
    if cell.len() > TENS.len() {
        return None;
    }
    let (mut digits, mut whole, mut n) = (0u64, None, 0);
    for byte in cell {
        let digit = byte.wrapping_sub(b'0');
        if digit < 10 {
            digits = 10 * digits + digit as u64;
            n += 1;
        } else if *byte == b'.' && whole.is_none() {
            whole = Some(n);
        } else {
            return None;
        }
    }
    // Without a point a cell may have sixteen digits, which are exact if they are few enough.
    if n == 0 || digits > 1 << f64::MANTISSA_DIGITS {
        return None;
    }
    let x = digits as f64 / TENS[n - whole.unwrap_or(n)];
    Some(if is_negative { -x } else { x })
}

/// A number with a decimal comma or an exponent of Fortran's, rewritten in place.
fn unusual_number(cell: &str) -> Option<f64> {
    let bytes = cell.as_bytes();
    let is_part = |b: &u8| matches!(b, b'0'..=b'9' | b'+' | b'-' | b'.' | b',' | b'e' | b'E' | b'd' | b'D');
    // The letter of an exponent is added.
    let mut text = [0u8; 48];
    if bytes.len() >= text.len() || !bytes.iter().all(is_part) {
        return None;
    }
    let mut n = 0;
    let mut has_point = false;
    for (i, b) in bytes.iter().enumerate() {
        let exponent_alone = matches!(b, b'+' | b'-') && i > 0 && matches!(bytes[i - 1], b'0'..=b'9' | b'.' | b',');
        let byte = match b {
            b',' | b'.' if has_point => return None,
            b',' | b'.' => {
                has_point = true;
                b'.'
            }
            b'd' | b'D' if !has_point => return None,
            b'd' | b'D' => b'e',
            _ if exponent_alone => {
                // Fortran leaves the letter out where the exponent needs three digits.
                if !has_point || bytes.len() - i != 4 {
                    return None;
                }
                text[n] = b'e';
                n += 1;
                *b
            }
            _ => *b,
        };
        text[n] = byte;
        n += 1;
    }
    // A comma has digits on its right.
    let comma = bytes.iter().position(|b| *b == b',');
    if comma.is_some_and(|at| !bytes.get(at + 1).is_some_and(u8::is_ascii_digit)) {
        return None;
    }
    std::str::from_utf8(&text[..n]).ok()?.parse().ok()
}

/// The sign between whole part and fraction of a column's numbers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Decimal<'a> {
    /// All are whole, or the column has words.
    None,
    /// A point.
    Point,
    /// A comma, as in the cell.
    Comma(&'a str),
}

/// Numbers of a column with a comma and with a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mixed<'a> {
    pub(super) comma: &'a str,
    pub(super) point: &'a str,
}

/// A column of cells: numbers if every cell that is not missing is one, else words. An error if they are numbers, but not all are
/// written alike.
pub(super) fn column<'a>(cells: &[&'a str]) -> Result<(Column, Decimal<'a>), Mixed<'a>> {
    if let Some(whole) = cells.iter().map(|c| c.parse::<i64>().ok()).collect::<Option<Vec<_>>>() {
        return Ok((Column::I64(whole), Decimal::None));
    }
    if let Some((numbers, decimal)) = numbers(cells) {
        return Ok((Column::F64(numbers), decimal));
    }
    let is_number = |cell: &&&str| kind_of(cell) == CellKind::Number;
    let with = |sign: char| cells.iter().filter(is_number).find(|cell| cell.contains(sign)).copied();
    match (with(','), with('.')) {
        (Some(comma), Some(point)) if cells.iter().all(|cell| kind_of(cell) != CellKind::Word) => {
            Err(Mixed { comma, point })
        }
        _ => Ok((words(cells), Decimal::None)),
    }
}

/// The first of the cells with a comma, if each of these may be a whole number with separators of thousands, as `1,200`, as well as one with a
/// decimal comma: nothing tells which.
pub(super) fn grouped<'a>(cells: &[&'a str]) -> Option<&'a str> {
    let may_be = |cell: &str| {
        let (whole, fraction) = cell.trim_start_matches(['+', '-']).split_once(',').unwrap_or_default();
        let digits = |part: &str| part.bytes().all(|b| b.is_ascii_digit());
        let is_group = fraction.len() == 3 && digits(fraction);
        is_group && (1..=3).contains(&whole.len()) && digits(whole) && !whole.starts_with('0')
    };
    let mut with_comma = cells.iter().copied().filter(|cell| cell.contains(','));
    let first = with_comma.next().filter(|cell| may_be(cell))?;
    // Words with commas are no numbers at all.
    with_comma.all(may_be).then_some(first)
}

fn numbers<'a>(cells: &[&'a str]) -> Option<(Vec<f64>, Decimal<'a>)> {
    let mut decimal = Decimal::None;
    // A column of blanks alone has missing numbers, one of `-` alone has words.
    let mut is_numeric = cells.iter().all(|c| c.is_empty());
    let mut numbers = Vec::with_capacity(cells.len());
    for cell in cells {
        let plain = plain_number(cell);
        is_numeric |= plain.is_some();
        if plain.is_some() {
            if decimal == Decimal::None && cell.contains('.') {
                decimal = Decimal::Point;
            }
        } else if let Some(x) = unusual_number(cell) {
            is_numeric = true;
            let own = if cell.contains(',') { Decimal::Comma(cell) } else { Decimal::Point };
            match (decimal, own) {
                (Decimal::None, own) => decimal = own,
                (Decimal::Point, Decimal::Comma(_)) | (Decimal::Comma(_), Decimal::Point) => return None,
                _ => {}
            }
            numbers.push(x);
            continue;
        }
        if matches!(decimal, Decimal::Comma(_)) && cell.contains('.') {
            return None;
        }
        numbers.push(plain.or_else(|| is_missing(cell).then_some(f64::NAN))?);
    }
    is_numeric.then_some((numbers, decimal))
}

/// A column of words.
pub(crate) fn words(cells: &[&str]) -> Column {
    let mut names: Vec<String> = Vec::new();
    let mut seen: HashMap<&str, u32> = HashMap::new();
    let codes = cells
        .iter()
        .map(|cell| {
            *seen.entry(cell).or_insert_with(|| {
                names.push(cell.replace("\"\"", "\""));
                names.len() as u32 - 1
            })
        })
        .collect();
    Column::Category { codes, names }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_other_programs() {
        for (text, expected) in [
            ("1.0D+03", 1000.0),
            ("1.5d-3", 1.5e-3),
            ("-.25D2", -25.0),
            ("1.0+100", 1e100),
            ("-0.5-101", -0.5e-101),
            ("1,5", 1.5),
            ("-0,25E+1", -2.5),
            (",5", 0.5),
        ] {
            assert_eq!(number(text), Some(expected), "{text}");
        }
        for text in ["1.0+10", "12-345", "1d3", "1,234,567", "1.234,5", "1,", "e5", "d", "+", "1.5e", "1-2.0", "x"] {
            assert_eq!(number(text), None, "{text}");
        }
        assert!(["", "NA", "n/a", "NULL", "None", "-", "nan", "-1.#IND"].iter().all(|t| number(t).unwrap().is_nan()));
    }

    #[test]
    fn what_may_be_thousands_is_told_from_decimal_commas() {
        for (cells, expected) in [
            (&["1,200", "980"][..], Some("1,200")),
            (&["-12,345", "NA", "1,000"], Some("-12,345")),
            (&["1,200", "0,500"], None),
            (&["1,200", "1,25"], None),
            (&["1,5", "980"], None),
            (&["1.200", "980"], None),
            (&["a,bcd"], None),
        ] {
            assert_eq!(grouped(cells), expected, "{cells:?}");
        }
    }

    #[test]
    fn short_numbers_are_rounded_as_all_are() {
        let mut k = 1u64;
        for digits in 1..=17 {
            for point in 0..=digits + 1 {
                k = k.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let mut text = format!("{:020}", k)[20 - digits..].to_string();
                if point <= digits {
                    text.insert(point, '.');
                }
                for text in [format!("-{text}"), text] {
                    let exact: Option<f64> = text.parse().ok();
                    let short = short_number(text.as_bytes());
                    assert!(short.is_none() || short.map(f64::to_bits) == exact.map(f64::to_bits), "{text}");
                    assert_eq!(plain_number(&text).map(f64::to_bits), exact.map(f64::to_bits), "{text}");
                }
            }
        }
        for text in ["", "-", ".", "-.", "1.2.3", "--1", "+1", "1e3", "0x1", "nan"] {
            assert_eq!(short_number(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn a_column_is_of_numbers_if_all_that_is_there_is() {
        let missing = |cells: &[&str]| match column(cells).unwrap().0 {
            Column::F64(v) => v.iter().map(|x| x.is_nan()).collect::<Vec<_>>(),
            other => panic!("{other:?}"),
        };
        assert_eq!(missing(&["1", "", "-", "2.5"]), [false, true, true, false]);
        assert_eq!(missing(&["", ""]), [true, true]);
        let of = |cells: &[&'static str]| column(cells).unwrap();
        for cells in [["-", "NA"], ["1", "a"], ["1,5", "1.234.567"]] {
            assert!(matches!(of(&cells).0, Column::Category { .. }), "{cells:?}");
        }
        for (cells, comma, point) in
            [(["1,5", "2.5"], "1,5", "2.5"), (["2.5", "1,5"], "1,5", "2.5"), (["1,5", "1.0D+1"], "1,5", "1.0D+1")]
        {
            assert_eq!(column(&cells), Err(Mixed { comma, point }), "{cells:?}");
        }
        assert_eq!(of(&["1,5", "3"]).1, Decimal::Comma("1,5"));
        assert_eq!(of(&["3", "1.5"]).1, Decimal::Point);
        assert_eq!(of(&["a\"\"b", ""]).0.text(0), "a\"b");
    }
}
