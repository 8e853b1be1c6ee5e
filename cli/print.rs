//! Printing that goes on where nobody reads, and in which names from files only stand there: the command's own `println` and
//! `eprintln`.

/// Print a line on standard error. That nobody reads it, as when a pipe is closed, stops no work.
macro_rules! eprintln {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), "{}", guard::text::terminal(&format!($($part)*)));
    }};
}

/// Print a line on standard output. That nobody reads it, as when a pipe is closed, stops no work.
macro_rules! println {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), "{}", guard::text::terminal(&format!($($part)*)));
    }};
}
