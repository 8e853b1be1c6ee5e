//! Wounded files for every reader: none may panic, hang or take the memory of the machine.
//!
//! `cargo bench --bench mutate [-- N [FORMAT]]`, N inputs (a million) of all formats or of one; the same ones every time. Prints the
//! inputs by format, how many of them were sound, and the most memory. An input that makes a reader panic is kept in the working
//! folder, as `mutate.FORMAT.INDEX`, and the exit code is 1.

mod formats;
mod wounds;

use formats::{FORMATS, Format};
use guard::memory::{Bytes, Counting};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;
use wounds::Random;

#[global_allocator]
static MEMORY: Counting = Counting;

/// What all readers together may take, bytes.
const MEMORY_LIMIT: u64 = 1 << 30;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let n: u64 = args.first().map_or(1_000_000, |n| n.parse().expect("a number of inputs"));
    let formats: Vec<&Format> = FORMATS.iter().filter(|f| args.get(1).is_none_or(|name| name == f.name)).collect();
    let shares: u64 = formats.iter().map(|f| f.share).sum();
    assert!(shares > 0, "there is no format of this name");
    guard::memory::set_limit(MEMORY_LIMIT, 4);
    // The message of a panic is kept with the input.
    std::panic::set_hook(Box::new(|info| eprintln!("panic: {info}")));
    let work = tempfile::tempdir().expect("a folder for the inputs");
    let (mut n_all, mut n_bad) = (0, 0);
    for format in formats {
        let count = Count::of(format, n * format.share / shares, work.path());
        println!(
            "{:10} {:8} inputs, {:7} sound, {} panics, {:.0} s",
            format.name, count.inputs, count.sound, count.panics, count.seconds
        );
        n_all += count.inputs;
        n_bad += count.panics;
    }
    println!("{n_all} inputs, {n_bad} panics, at most {}", Bytes(peak()));
    std::process::exit(i32::from(n_bad > 0));
}

/// What came of the inputs of a format.
#[derive(Default)]
struct Count {
    inputs: u64,
    sound: u64,
    panics: u64,
    seconds: f64,
}

impl Count {
    /// Feed `n` wounded inputs to the reader of a format.
    fn of(format: &Format, n: u64, work: &Path) -> Count {
        /// A time that no small file takes, s.
        const LONG: f64 = 10.0;
        let samples = (format.samples)(work);
        let path = work.join(format!("wounded.{}", format.ending));
        std::fs::write(&path, &samples[0]).expect("the sample is written");
        assert!((format.read)(&path, &samples[0]), "the first sample of {} is not sound", format.name);
        let mut random = Random::new(format.name);
        let start = Instant::now();
        let mut count = Count { inputs: n, ..Count::default() };
        for i in 0..n {
            let mut bytes = wounds::wounded(&samples, format.is_text, &mut random);
            if let Some(mend) = format.mend {
                mend(&mut bytes, &mut random);
            }
            std::fs::write(&path, &bytes).expect("the input is written");
            guard::memory::doing(&format!("input {i} of"), Path::new(format.name));
            let begin = Instant::now();
            match catch_unwind(AssertUnwindSafe(|| (format.read)(&path, &bytes))) {
                Ok(is_sound) => count.sound += u64::from(is_sound),
                Err(_) => {
                    count.panics += 1;
                    keep(format, i, &bytes);
                }
            }
            if begin.elapsed().as_secs_f64() > LONG {
                println!("input {i} of {} took {:.0} s", format.name, begin.elapsed().as_secs_f64());
                keep(format, i, &bytes);
            }
        }
        count.seconds = start.elapsed().as_secs_f64();
        count
    }
}

fn keep(format: &Format, i: u64, bytes: &[u8]) {
    let kept = format!("mutate.{}.{i}", format.name);
    std::fs::write(&kept, bytes).expect("the input is kept");
    println!("kept in {kept}");
}

/// The most memory that this process has had, bytes; 0 where nobody says.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    line.and_then(|l| l.split_whitespace().next()?.parse::<u64>().ok()).unwrap_or(0) * 1024
}
