//! Text as a part of an HTML page: as content or as the value of an attribute, as data within a `<script>`, as the address of a link.

use super::is_hidden;

/// Text as content, or as the value of an attribute in double or single quotes: what would begin a tag, a reference or an end of the value
/// is written as a reference. Control characters and marks that turn the order of reading are written out, as `\u{1b}`.
pub fn text(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c if is_hidden(c) => out.extend(c.escape_default()),
            c => out.push(c),
        }
    }
    out
}

/// JSON as the content of a `<script type="application/json">`: nothing of it ends the element or begins a comment, and it is read as
/// the same value. In JSON these characters stand in strings alone.
pub fn script(json: &str) -> String {
    let mut out = String::with_capacity(json.len() + 16);
    for c in json.chars() {
        let is_escaped = matches!(c, '<' | '>' | '&' | '\u{7f}' | '\u{2028}' | '\u{2029}')
            || (is_hidden(c) && !c.is_ascii() && u32::from(c) <= 0xffff);
        if is_escaped {
            out.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            out.push(c);
        }
    }
    out
}

/// A relative path with `/` as the address of a link: it names that file and nothing else, no scheme, query or place in a page.
pub fn address(path: &str) -> String {
    let mut out = String::with_capacity(path.len());
    for byte in path.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) {
            out.push(char::from(byte));
        } else {
            out.push_str(&format!("%{byte:02X}"));
        }
    }
    // What begins with two strokes would name a machine.
    if out.starts_with('/') { format!(".{out}") } else { out }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_and_attributes_hold_no_tags() {
        assert_eq!(text("a < b & c"), "a &lt; b &amp; c");
        assert_eq!(text("\"><b onclick='x'>"), "&quot;&gt;&lt;b onclick=&#39;x&#39;&gt;");
        assert_eq!(text("a\u{1b}[2J\u{202e}\0ä\n"), "a\\u{1b}[2J\\u{202e}\\u{0}ä\n");
    }

    #[test]
    fn scripts_hold_their_data_and_the_same_value() {
        let json = "[\"</script><!--\",\"<script>\",\"]]>&amp;\",\"\u{2028}\u{7f}\u{202e}\"]";
        let escaped = script(json);
        assert!(!escaped.contains(['<', '>', '&', '\u{2028}', '\u{7f}', '\u{202e}']), "{escaped}");
        assert_eq!(
            escaped,
            "[\"\\u003c/script\\u003e\\u003c!--\",\"\\u003cscript\\u003e\",\"]]\\u003e\\u0026amp;\",\"\\u2028\\u007f\\u202e\"]"
        );
        assert_eq!(script("[1,\"ä\"]"), "[1,\"ä\"]");
    }

    #[test]
    fn addresses_are_relative_paths() {
        assert_eq!(address("../a b/m#1?.mp4"), "../a%20b/m%231%3F.mp4");
        assert_eq!(address("javascript:alert(1)"), "javascript%3Aalert%281%29");
        assert_eq!(address("//host/ä"), ".//host/%C3%A4");
    }
}
