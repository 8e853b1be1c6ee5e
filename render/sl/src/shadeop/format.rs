//! Strings: `format` and `printf`, and patterns.

/// What a format takes.
pub enum Value<'a> {
    /// A number, a triple or a matrix.
    Numbers(Vec<f32>),
    /// Text.
    Text(&'a str),
}

/// Longest text that a shader makes, bytes: one that doubles itself in a loop would take the memory of the machine.
pub const LONGEST: usize = 1 << 16;

/// The text of a format (the first value) and what its `%f`, `%d`, `%s`, `%p`, `%c`, `%m` take; cut where it is too long.
pub fn format(values: &[Value]) -> String {
    let Some((Value::Text(pattern), mut rest)) = values.split_first() else { return String::new() };
    let mut out = String::new();
    let mut chars = pattern.chars().peekable();
    while let Some(c) = chars.next() {
        if out.len() > LONGEST {
            out.truncate(out.floor_char_boundary(LONGEST));
            break;
        }
        if c != '%' {
            out.push(c);
            continue;
        }
        // Widths and precisions: `%5.2f`.
        let mut spec = String::new();
        while let Some(c) = chars.next_if(|c| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | ' ')) {
            spec.push(c);
        }
        let kind = chars.next();
        if kind == Some('%') {
            out.push('%');
            continue;
        }
        let Some((value, after)) = rest.split_first() else { continue };
        rest = after;
        let (width, precision) = spec.split_once('.').unwrap_or((&spec, ""));
        let precision = precision.parse::<usize>().ok().filter(|p| *p <= 32);
        let number = |x: f32| match (kind, precision) {
            (Some('d' | 'i'), _) => (x as i64).to_string(),
            (Some('h' | 'x'), _) => format!("{:x}", x.to_bits()),
            (_, Some(p)) => format!("{x:.p$}"),
            (Some('g'), None) => x.to_string(),
            (_, None) => format!("{x:.6}"),
        };
        let text = match value {
            Value::Text(t) => t.to_string(),
            Value::Numbers(v) => v.iter().map(|x| number(*x)).collect::<Vec<_>>().join(" "),
        };
        let min_width = width.trim_start_matches(['-', '+', ' ']).parse::<usize>().unwrap_or(0).min(1024);
        if width.starts_with('-') {
            out += &format!("{text:<min_width$}");
        } else {
            out += &format!("{text:>min_width$}");
        }
    }
    out
}

/// Whether a text has a part that a regular expression describes; one that cannot be read is taken as plain text.
pub fn matches(pattern: &str, text: &str) -> bool {
    match regex_lite::Regex::new(pattern) {
        Ok(pattern) => pattern.is_match(text),
        Err(_) => text.contains(pattern),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_and_patterns() {
        let values = [Value::Text("%s has %5.2f and %d of %c%%"), Value::Text("a"), Value::Numbers(vec![1.5])];
        assert_eq!(format(&values), "a has  1.50 and  of %");
        assert_eq!(format(&[Value::Text("(%p)"), Value::Numbers(vec![1.0, 2.0, 0.5])]), "(1.000000 2.000000 0.500000)");
        assert!(matches("^gr.*l$", "gravel") && !matches("^s", "gravel") && matches("(", "f(x)"));
    }
}
