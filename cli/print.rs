//! Printing that goes on where nobody reads: the command's own `println` and `eprintln`.

/// Print a line on standard error. That nobody reads it, as when a pipe is closed, stops no work.
macro_rules! eprintln {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($part)*);
    }};
}

/// Print a line on standard output. That nobody reads it, as when a pipe is closed, stops no work.
macro_rules! println {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($part)*);
    }};
}
