//! Printing that goes on where nobody reads, and in which names from files only stand there: the command's own `println` and
//! `eprintln`, whose lines stay above the bars of what is going on.

use indicatif::MultiProgress;
use std::io::IsTerminal;
use std::sync::OnceLock;

/// Print a line on standard error, with what it begins with (`error:`, `warning:`, `note:`) in colour on a terminal. That nobody reads
/// it, as when a pipe is closed, stops no work.
macro_rules! eprintln {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let text = format!($($part)*);
        let text = guard::text::message(&text);
        let text = guard::text::terminal(&text);
        let text = crate::print::painted(&text, crate::print::has_colors());
        crate::print::above_bars(|| drop(writeln!(std::io::stderr(), "{text}")));
    }};
}

/// Print a line on standard output. That nobody reads it, as when a pipe is closed, stops no work.
macro_rules! println {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let text = format!($($part)*);
        let text = guard::text::terminal(&text);
        crate::print::above_bars(|| drop(writeln!(std::io::stdout(), "{text}")));
    }};
}

/// The bars on the terminal, if there have been any.
static BARS: OnceLock<MultiProgress> = OnceLock::new();

/// The bars on the terminal, one below the other.
pub fn bars() -> &'static MultiProgress {
    BARS.get_or_init(MultiProgress::new)
}

/// Write a line where it stays above the bars.
pub fn above_bars(write: impl FnOnce()) {
    match BARS.get() {
        Some(bars) => bars.suspend(write),
        None => write(),
    }
}

/// Whether standard error shows colours: it is a terminal that has them, and its user wants them (<https://no-color.org>).
pub fn has_colors() -> bool {
    static COLORS: OnceLock<bool> = OnceLock::new();
    *COLORS.get_or_init(|| {
        let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        let is_dumb = std::env::var_os("TERM").is_none_or(|term| term.is_empty() || term == "dumb");
        std::io::stderr().is_terminal() && !is_set("NO_COLOR") && !is_dumb
    })
}

/// A text with what it begins with in bold and colour.
pub fn painted(text: &str, has_colors: bool) -> String {
    let colors = [("error:", 31), ("warning:", 33), ("note:", 36)];
    match colors.into_iter().find_map(|(head, color)| Some((head, color, text.strip_prefix(head)?))) {
        Some((head, color, rest)) if has_colors => format!("\x1b[1;{color}m{head}\x1b[0m{rest}"),
        _ => text.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::painted;

    #[test]
    fn heads_have_colours() {
        assert_eq!(painted("error: no data", true), "\x1b[1;31merror:\x1b[0m no data");
        assert_eq!(painted("error: no data", false), "error: no data");
        assert_eq!(painted("no error: data", true), "no error: data");
    }
}
