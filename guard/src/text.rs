//! Text from data and models on its way to a place where some characters do more than stand there. There is one function a place.

pub mod html;

use std::borrow::Cow;

/// Whether a character, printed, moves the cursor, changes colours, or turns the order of what is read.
fn is_hidden(c: char) -> bool {
    (c.is_control() && c != '\n' && c != '\t')
        || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

/// Text for a terminal: control characters and marks that turn the order of reading are written out, as `\u{1b}`.
pub fn terminal(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_hidden(c) {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    Cow::Owned(out)
}

/// The most bytes of a word of a message: more than any path has.
const LONGEST_WORD: usize = 8192;

/// A message in which words that are longer than any name or path are cut: their begin and their end alone are there, and how much is not.
pub fn message(text: &str) -> Cow<'_, str> {
    /// Bytes that are kept of the begin, and of the end.
    const KEPT: [usize; 2] = [96, 32];
    if !text.split_whitespace().any(|word| word.len() > LONGEST_WORD) {
        return Cow::Borrowed(text);
    }
    let cut = |word: &str| {
        let [begin, end] = [word.floor_char_boundary(KEPT[0]), word.ceil_char_boundary(word.len() - KEPT[1])];
        format!("{}…({} bytes)…{}", &word[..begin], end - begin, &word[end..])
    };
    let words = text.split_inclusive(char::is_whitespace);
    Cow::Owned(words.map(|word| if word.len() > LONGEST_WORD { cut(word) } else { word.into() }).collect())
}

/// Text for one line, as a comment of a file: all of it stays in the line.
pub fn line(text: &str) -> String {
    terminal(text)
        .chars()
        .map(|c| if matches!(c, '\n' | '\u{85}' | '\u{2028}' | '\u{2029}') { ' ' } else { c })
        .collect()
}

/// Text as a cell of a table with commas, in one line.
pub fn cell(text: &str) -> String {
    let text = line(text);
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

/// Text as one word of a shell script.
pub fn shell(text: &str) -> String {
    format!("'{}'", text.replace('\'', "'\\''"))
}

/// Text as one word of a command that a person may copy: in quotes if it needs them.
pub fn shell_word(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_./=:,+-@%".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) { text.into() } else { shell(text) }
}

/// A path and what follows it, in which Slurm replaces `%a` and its like, as the value of an option in a `#SBATCH` line; `None` if the
/// path has several lines.
pub fn sbatch(text: &str, pattern: &str) -> Option<String> {
    let quoted = text.replace('\\', "\\\\").replace('"', "\\\"").replace('%', "%%");
    (!text.contains(['\n', '\r'])).then(|| format!("\"{quoted}{pattern}\""))
}

/// Text as the name of a file or folder, or a part of one: letters, digits, and the characters in `others`; the rest is replaced by
/// `_`. Never empty, and never a name of a folder above.
pub fn file_name(text: &str, others: &str) -> String {
    /// Longest name, bytes: systems take 255, and a name may be a part of one.
    const LONGEST: usize = 160;
    let fit = |c: char| if c.is_alphanumeric() || others.contains(c) { c } else { '_' };
    let mut name: String = text.chars().map(fit).collect();
    name.truncate(name.floor_char_boundary(LONGEST));
    if name.chars().all(|c| c == '.') { format!("_{name}") } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_are_no_names_are_cut_in_messages() {
        let long = format!("unknown request `é{}´`, expected\ta `name`", "x".repeat(1_000_000));
        let cut = message(&long);
        assert!(
            cut.len() < 300 && cut.starts_with("unknown request `éxxx") && cut.ends_with("´`, expected\ta `name`"),
            "{cut}"
        );
        assert!(cut.contains("…(9998"), "{cut}");
        let path = format!("no file `{}`", "p".repeat(4096));
        assert_eq!(message(&path), path);
    }

    #[test]
    fn text_only_stands_there() {
        assert_eq!(terminal("a\tb\nä"), "a\tb\nä");
        assert_eq!(terminal("\x1b[2J\u{202e}x\x07"), "\\u{1b}[2J\\u{202e}x\\u{7}");
        assert_eq!(line("a\nb: c\r"), "a b: c\\r");
        assert_eq!(["a.x [m]", "a,b\nc", "\""].map(cell), ["a.x [m]", "\"a,b c\"", "\"\"\"\""]);
        assert_eq!(shell("it's $(x)"), "'it'\\''s $(x)'");
        assert_eq!(sbatch("/a \"b\"/%a", "_%a").as_deref(), Some("\"/a \\\"b\\\"/%%a_%a\""));
        assert_eq!(sbatch("a\nrm -rf", ""), None);
        assert_eq!(["../a b", "..", "", "f[x]"].map(|name| file_name(name, ".-")), [".._a_b", "_..", "_", "f_x_"]);
    }
}
