//! A table's text → its rows, and each row's cells as slices of the text.
//!
//! A cell that begins with a quote ends at the next single quote: separators, line ends and doubled quotes stand in it for themselves.

/// Rows of a table that are still to be read.
#[derive(Clone)]
pub(super) struct Rows<'a> {
    text: &'a str,
    at: usize,
    line: usize,
    delimiter: u8,
    /// The remark in the line before the last row, if there is one.
    pub(super) remark: Option<&'a str>,
}

/// A row that was read.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Row {
    /// Its first line, from 1.
    pub(super) line: usize,
    /// Whether the text ends just behind one of its separators.
    pub(super) is_cut: bool,
}

/// The line, from 1, of a text's quote that is never closed, and the byte where it stands.
#[derive(Debug)]
pub(super) struct Unclosed {
    pub(super) line: usize,
    pub(super) at: usize,
}

impl<'a> Rows<'a> {
    pub(super) fn new(text: &'a str, delimiter: u8) -> Rows<'a> {
        Rows { text, at: 0, line: 0, delimiter, remark: None }
    }

    /// Read the next row's cells, trimmed and unquoted; none at the end. Empty lines and remarks are passed over.
    pub(super) fn read(&mut self, cells: &mut Vec<&'a str>) -> Result<Option<Row>, Unclosed> {
        cells.clear();
        self.remark = None;
        while self.at < self.text.len() {
            let rest = &self.text[self.at..];
            let end = rest.find('\n').unwrap_or(rest.len());
            let line = &rest[..end];
            self.line += 1;
            let remark = remark(line);
            if line.trim().is_empty() || remark.is_some() {
                self.remark = remark;
                self.at += end + 1;
                continue;
            }
            let row = self.line;
            if line.contains('"') {
                self.read_quoted(cells)?;
            } else {
                split_plain(line, self.delimiter, cells);
                self.at += end + 1;
            }
            let is_cut = self.at > self.text.len() && self.text.trim_end_matches(' ').ends_with(self.delimiter as char);
            return Ok(Some(Row { line: row, is_cut }));
        }
        Ok(None)
    }

    /// Read a row that has quotes, from its first byte.
    fn read_quoted(&mut self, cells: &mut Vec<&'a str>) -> Result<(), Unclosed> {
        let (text, bytes) = (self.text, self.text.as_bytes());
        let blanks = self.delimiter == b' ';
        let is_blank = |b: u8| b == b' ' || (b == b'\t' && self.delimiter != b'\t');
        let ends = |b: u8| b == b'\n' || b == self.delimiter || (blanks && b == b'\t');
        let mut at = self.at;
        loop {
            let open = at + bytes[at..].iter().take_while(|b| is_blank(**b)).count();
            let mut end = open;
            let mut cell = None;
            if bytes.get(open) == Some(&b'"') {
                end = closing(bytes, open).ok_or(Unclosed { line: self.line, at: open })? + 1;
                self.line += text[open..end].matches('\n').count();
                cell = Some(&text[open + 1..end - 1]);
            }
            let after = end;
            end += bytes[end..].iter().take_while(|b| !ends(**b)).count();
            match cell.filter(|_| text[after..end].trim().is_empty()) {
                Some(cell) => cells.push(cell),
                None if blanks && text[open..end].trim().is_empty() => {}
                None => cells.push(text[open..end].trim()),
            }
            at = end + 1;
            if bytes.get(end).is_none_or(|b| *b == b'\n') {
                self.at = at;
                return Ok(());
            }
        }
    }
}

/// The quote that closes the one at `open`: quotes within are doubled.
fn closing(bytes: &[u8], open: usize) -> Option<usize> {
    let mut at = open + 1;
    loop {
        at += bytes[at..].iter().position(|b| *b == b'"')?;
        if bytes.get(at + 1) != Some(&b'"') {
            return Some(at);
        }
        at += 2;
    }
}

fn split_plain<'a>(line: &'a str, delimiter: u8, cells: &mut Vec<&'a str>) {
    if delimiter == b' ' {
        cells.extend(line.split([' ', '\t', '\r']).filter(|cell| !cell.is_empty()));
    } else {
        let mut start = 0;
        for (at, byte) in line.bytes().enumerate() {
            if byte == delimiter {
                cells.push(trimmed(&line[start..at]));
                start = at + 1;
            }
        }
        cells.push(trimmed(&line[start..]));
    }
}

/// A cell without blanks at its ends.
#[inline]
fn trimmed(cell: &str) -> &str {
    let ends_in_blanks = |byte: Option<&u8>| !byte.is_some_and(u8::is_ascii_graphic);
    if ends_in_blanks(cell.as_bytes().first()) || ends_in_blanks(cell.as_bytes().last()) { cell.trim() } else { cell }
}

/// What a line says if it is a remark: behind `#`, or `%` as MATLAB writes it.
pub(super) fn remark(line: &str) -> Option<&str> {
    line.trim_start().strip_prefix(['#', '%'])
}

/// The cells of a line that stands alone, such as a header in a remark.
pub(super) fn split(line: &str, delimiter: u8) -> Vec<&str> {
    let mut cells = Vec::new();
    match Rows::new(line, delimiter).read(&mut cells) {
        Ok(_) => cells,
        Err(_) => Vec::new(),
    }
}

/// The separator of a line: the first of tab, semicolon, bar and comma that it has outside quotes, else blanks. Commas within numbers that
/// blanks separate are decimal: `0,5 1,5`.
pub(super) fn sniff(line: &str) -> u8 {
    let mut found = b' ';
    for byte in line.split('"').step_by(2).flat_map(str::bytes) {
        match byte {
            b'\t' => return b'\t',
            b';' => found = b';',
            b'|' if found != b';' => found = b'|',
            b',' if found != b';' && found != b'|' => found = b',',
            _ => {}
        }
    }
    if found == b',' && has_decimal_commas(line) { b' ' } else { found }
}

/// Whether blanks separate numbers with decimal commas: all words are numbers, and between two commas there are several.
fn has_decimal_commas(line: &str) -> bool {
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    let is_number = |word: &str| {
        let (whole, fraction) = word.split_once(',').unwrap_or((word, "0"));
        let whole = whole.strip_prefix(['+', '-']).unwrap_or(whole);
        digits(whole) && digits(fraction.split(['e', 'E']).next().unwrap_or(""))
    };
    let several = |part: &str| part.split_whitespace().count() > 1;
    line.split_whitespace().all(is_number) && line.split(',').any(several)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str, delimiter: u8) -> Vec<Vec<String>> {
        let (mut rows, mut cells, mut all) = (Rows::new(text, delimiter), vec![], vec![]);
        while rows.read(&mut cells).unwrap().is_some() {
            all.push(cells.iter().map(|c| c.to_string()).collect());
        }
        all
    }

    #[test]
    fn quoted_cells_hold_separators_and_line_ends() {
        assert_eq!(rows("a, \"b,c\" ,d\r\n", b','), [["a", "b,c", "d"]]);
        assert_eq!(rows("\"a\nb\",\"c\"\"d\"\n1,2\n", b','), [["a\nb", "c\"\"d"], ["1", "2"]]);
        assert_eq!(rows("5\" 6\n  \"a b\"  \"\" c \n", b' '), [vec!["5\"", "6"], vec!["a b", "", "c"]]);
        assert_eq!(rows("a;;\"\"\n# b\n\n;2;\n", b';'), [["a", "", ""], ["", "2", ""]]);
        let mut rows = Rows::new("a\n\"b\nc\n", b',');
        let mut cells = vec![];
        rows.read(&mut cells).unwrap();
        assert_eq!(rows.read(&mut cells).unwrap_err().line, 2);
    }

    #[test]
    fn separators_are_found_out() {
        for (line, expected) in [
            ("a;b,c", b';'),
            ("\"a;b\",c", b','),
            ("1, 2, 3", b','),
            ("1,2", b','),
            ("1,2,3", b','),
            ("0,5 1,5 2,5", b' '),
            ("10 -20,5 3", b' '),
            ("1,2 ,3", b','),
            ("2020-01-01 12:00,1,2", b','),
            ("a b,c", b','),
            ("a\tb;c", b'\t'),
            ("a|1,5|b", b'|'),
            ("a b", b' '),
        ] {
            assert_eq!(sniff(line) as char, expected as char, "{line}");
        }
    }
}
