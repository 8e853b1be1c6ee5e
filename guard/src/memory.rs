//! The memory of this process: how much it takes, and how much it may.
//!
//! Memory is counted where it is allocated, in [`Counting`], the allocator of the program; elsewhere, as in tests of a crate alone,
//! nothing is counted and there is no limit. Readers ask ([`check`], [`room`]) before they go on, and name the place in their file.
//! What none of them has foreseen, such as a header that lies to the decoder of another library, ends the program with a message
//! and an exit code, rather than by the system's choice of a victim.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::fmt::{self, Write};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicI32, AtomicI64, Ordering::Relaxed};

/// The system's allocator, with what it gives counted: `#[global_allocator] static MEMORY: Counting = Counting;`.
pub struct Counting;

/// Bytes that a thread keeps to itself before it tells the others.
const GRAIN: i64 = 1 << 16;

/// Bytes allocated, within [`GRAIN`] a thread.
static USED: AtomicI64 = AtomicI64::new(0);
/// Bytes that may be allocated.
static LIMIT: AtomicI64 = AtomicI64::new(i64::MAX);
/// The exit code of a program that would take more.
static EXIT: AtomicI32 = AtomicI32::new(1);
/// What the program is doing, and its length.
static DOING: Mutex<Line> = Mutex::new(Line { bytes: [0; 1024], len: 0 });

thread_local! {
    static PENDING: Cell<i64> = const { Cell::new(0) };
}

/// That the memory which may be taken is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Full;

impl fmt::Display for Full {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "it takes more than {} of memory; --memory allows more", Bytes(limit()))
    }
}

/// A count of bytes, written as `1.5 GiB`.
pub struct Bytes(pub u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [&str; 4] = ["bytes", "KiB", "MiB", "GiB"];
        let unit = (0..3).rev().find(|k| self.0 >= 1 << (10 * (k + 1))).map_or(0, |k| k + 1);
        let value = self.0 as f64 / (1u64 << (10 * unit)) as f64;
        let value = (value * 10.0).round() / 10.0;
        write!(f, "{value} {}", UNITS[unit])
    }
}

/// Let the process take a number of bytes, and end with this exit code if it would take more.
pub fn set_limit(bytes: u64, exit: i32) {
    LIMIT.store(i64::try_from(bytes).unwrap_or(i64::MAX), Relaxed);
    EXIT.store(exit, Relaxed);
}

/// Bytes that the process may take.
pub fn limit() -> u64 {
    LIMIT.load(Relaxed) as u64
}

/// Bytes that the process has taken.
pub fn used() -> u64 {
    USED.load(Relaxed).max(0) as u64
}

/// Bytes that readers may still take: an eighth of the limit is kept for the program itself.
pub fn room() -> u64 {
    let limit = LIMIT.load(Relaxed);
    (limit - limit / 8 - USED.load(Relaxed)).max(0) as u64
}

/// An error if readers may take no more.
#[inline]
pub fn check() -> Result<(), Full> {
    if room() > 0 { Ok(()) } else { Err(Full) }
}

/// Tell what the program begins to do, for the message of one that runs out of memory: `reading` a file.
pub fn doing(verb: &str, path: &Path) {
    let mut line = DOING.lock().unwrap_or_else(|e| e.into_inner());
    line.len = 0;
    let _ = write!(line, "{verb} {}", path.display());
}

/// Text of limited length, which takes no memory.
struct Line {
    bytes: [u8; 1024],
    len: usize,
}

impl Write for Line {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for c in text.chars() {
            // What ends up in a terminal has no control characters.
            let c = if c.is_control() && c != '\n' { '?' } else { c };
            let end = self.len + c.len_utf8();
            let place = self.bytes.get_mut(self.len..end).ok_or(fmt::Error)?;
            c.encode_utf8(place);
            self.len = end;
        }
        Ok(())
    }
}

/// Count bytes that are taken, or given back. Never fails in a thread that is ending.
#[inline]
fn count(bytes: i64) {
    let publish = |bytes: i64| {
        let used = USED.fetch_add(bytes, Relaxed) + bytes;
        if bytes > 0 && used > LIMIT.load(Relaxed) {
            end();
        }
    };
    let kept = PENDING.try_with(|pending| {
        let sum = pending.get() + bytes;
        let is_small = sum.abs() < GRAIN;
        pending.set(if is_small { sum } else { 0 });
        if is_small { 0 } else { sum }
    });
    match kept {
        Ok(0) => {}
        Ok(sum) => publish(sum),
        Err(_) => publish(bytes),
    }
}

/// End the program with a message. Takes no memory.
#[cold]
fn end() -> ! {
    let mut line = Line { bytes: [0; 1024], len: 0 };
    let _ = match DOING.try_lock() {
        Ok(doing) if doing.len > 0 => {
            let doing = std::str::from_utf8(&doing.bytes[..doing.len]).unwrap_or("reading");
            write!(line, "error: {doing}: ")
        }
        _ => write!(line, "error: "),
    };
    let _ = writeln!(line, "{Full}");
    #[cfg(unix)]
    // SAFETY: the bytes are the line's own; `_exit` runs nothing that could allocate.
    unsafe {
        libc::write(2, line.bytes.as_ptr().cast(), line.len);
        libc::_exit(EXIT.load(Relaxed));
    }
    #[cfg(not(unix))]
    std::process::abort();
}

// SAFETY: every call is the system's own; counting neither allocates nor unwinds.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        // SAFETY: as the caller promises.
        given(unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as i64);
        // SAFETY: as the caller promises.
        given(unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        count(-(layout.size() as i64));
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size as i64 - layout.size() as i64);
        // SAFETY: as the caller promises.
        given(unsafe { System.realloc(at, layout, size) })
    }
}

/// Memory that the system has given; where it gave none, the program ends with a message.
#[inline]
fn given(at: *mut u8) -> *mut u8 {
    if at.is_null() {
        end();
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_written_with_units() {
        let text: Vec<String> =
            [0, 1023, 1 << 10, 3 << 29, 1 << 30, 47 << 30].map(|n| Bytes(n).to_string()).into_iter().collect();
        assert_eq!(text, ["0 bytes", "1023 bytes", "1 KiB", "1.5 GiB", "1 GiB", "47 GiB"]);
    }

    #[test]
    fn lines_are_cut_and_have_no_control_characters() {
        let mut line = Line { bytes: [0; 1024], len: 0 };
        assert!(write!(line, "a\x1b[31m{}", "ü".repeat(600)).is_err());
        let text = std::str::from_utf8(&line.bytes[..line.len]).unwrap();
        assert!(text.starts_with("a?[31mü") && text.len() <= 1024, "{text}");
    }
}
