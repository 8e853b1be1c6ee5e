//! Syntax of flag values: a parser for each, with the value as it is used.

use clap::ValueEnum;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// A value set over a model's: `solver.iterations=80`.
#[derive(Clone, Debug)]
pub struct Assignment {
    /// The key's path in the model.
    pub path: String,
    /// The value, as YAML.
    pub value: String,
}

/// An axis, or against it.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Axis {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
    /// Against x.
    #[value(name = "-x")]
    MinusX,
    /// Against y.
    #[value(name = "-y")]
    MinusY,
    /// Against z.
    #[value(name = "-z")]
    MinusZ,
}

/// Width and height of an image, pixels.
pub type Resolution = [u32; 2];

/// A shard of an image: the `index`-th, from 1, of `n_shards`.
#[derive(Clone, Copy, Debug)]
pub struct ShardArg {
    /// The shard's index, from 1.
    pub index: usize,
    /// The number of shards.
    pub n_shards: usize,
}

/// An interval of time, s.
#[derive(Clone, Copy, Debug)]
pub struct Interval {
    /// Its start, s.
    pub from: f64,
    /// Its end, s.
    pub to: f64,
}

/// Parse an assignment, `PATH=VALUE`.
pub fn assignment(text: &str) -> Result<Assignment, String> {
    match text.split_once('=') {
        Some((path, value)) if !path.trim().is_empty() => {
            Ok(Assignment { path: path.trim().into(), value: value.trim().into() })
        }
        _ => Err("expected PATH=VALUE, as solver.iterations=80".into()),
    }
}

/// Parse a resolution, `1280x720`.
pub fn resolution(text: &str) -> Result<Resolution, String> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parsed
        .filter(|r: &Resolution| r.iter().all(|n| (1..=65_536).contains(n)))
        .ok_or_else(|| "expected width and height in pixels, 1 to 65536 each, as 1280x720".into())
}

/// Parse a shard, `2/8`: the second of eight.
pub fn shard(text: &str) -> Result<ShardArg, String> {
    let parsed =
        text.split_once('/').and_then(|(i, n)| Some(ShardArg { index: i.parse().ok()?, n_shards: n.parse().ok()? }));
    parsed
        .filter(|s| (1..=s.n_shards).contains(&s.index) && s.n_shards <= 100_000)
        .ok_or_else(|| "expected I/N with I from 1 to N and N at most 100000, as 2/8".into())
}

/// Parse a size of memory, bytes: `8GiB`, `8G`, `500MiB`.
pub fn size(text: &str) -> Result<u64, String> {
    /// Less than this holds no scene.
    const LEAST: u64 = 64 << 20;
    let fault = || "expected a size of at least 64MiB, as 8GiB or 500MiB".to_string();
    let end = text.find(|c: char| c.is_ascii_alphabetic()).ok_or_else(fault)?;
    let (number, unit) = (text[..end].trim().parse::<f64>().map_err(|_| fault())?, text[end..].to_lowercase());
    let shift = match unit.as_str() {
        "m" | "mb" | "mib" => 20,
        "g" | "gb" | "gib" => 30,
        "t" | "tb" | "tib" => 40,
        _ => return Err(fault()),
    };
    let bytes = number * (1u64 << shift) as f64;
    if bytes >= LEAST as f64 && bytes < 1e18 { Ok(bytes as u64) } else { Err(fault()) }
}

/// Parse a size of a file, bytes: `16MiB`, `500kB`, `0`.
pub fn file_size(text: &str) -> Result<u64, String> {
    let fault = || "expected the size of a file, as 16MiB, 500KiB or 0".to_string();
    let end = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let number = text[..end].trim().parse::<f64>().map_err(|_| fault())?;
    let shift = match text[end..].to_lowercase().as_str() {
        "" | "b" => 0,
        "k" | "kb" | "kib" => 10,
        "m" | "mb" | "mib" => 20,
        "g" | "gb" | "gib" => 30,
        _ => return Err(fault()),
    };
    let bytes = number * (1u64 << shift) as f64;
    if (0.0..1e18).contains(&bytes) { Ok(bytes as u64) } else { Err(fault()) }
}

/// Parse an interval of time, `0.5-2`.
pub fn interval(text: &str) -> Result<Interval, String> {
    let number = |text: &str| text.parse().ok().filter(|x: &f64| !x.is_nan());
    // The dash may also be one of a number: 1e-3-2.
    let at = |i: usize| Some(Interval { from: number(&text[..i])?, to: number(&text[i + 1..])? });
    match text.match_indices('-').find_map(|(i, _)| at(i)) {
        Some(Interval { from, to }) if from > to => {
            Err(format!("the two times are swapped: {from} is after {to}; expected FROM-TO, as {to}-{from}"))
        }
        Some(i) if i.to > i.from => Ok(i),
        _ => Err("expected FROM-TO in seconds, as 0.5-2".into()),
    }
}

/// Parse a word that a scheduler reads: a time, a size, a name.
pub fn word(text: &str) -> Result<String, String> {
    let fits = |c: char| c.is_ascii_alphanumeric() || "._:-+@/=,".contains(c);
    if !text.is_empty() && text.chars().all(fits) {
        return Ok(text.into());
    }
    Err("expected a word of letters, numbers and . _ : - + @ / = ,".into())
}

/// Parse text that stays in one line.
pub fn one_line(text: &str) -> Result<String, String> {
    if text.chars().any(char::is_control) { Err("expected one line".into()) } else { Ok(text.into()) }
}

/// Parse a number.
pub fn number<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| "expected a number".into())
}

/// Parse a finite number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite());
    parsed.ok_or_else(|| "expected a number above 0".into())
}

/// Parse a frame rate: frames per second.
pub fn frame_rate(text: &str) -> Result<f64, String> {
    positive(text).ok().filter(|x| *x <= 1000.0).ok_or_else(|| "expected a number above 0 and at most 1000".into())
}

/// A parser of whole numbers in a range.
pub fn whole<T: TryFrom<u64>>(range: RangeInclusive<u64>) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let parsed = text.parse().ok().filter(|n| range.contains(n)).and_then(|n| T::try_from(n).ok());
        parsed.ok_or_else(|| match (*range.start(), *range.end()) {
            (0, u64::MAX) => "expected a whole number".into(),
            (min, u64::MAX) => format!("expected a whole number, at least {min}"),
            (min, max) => format!("expected a whole number from {min} to {max}"),
        })
    }
}

/// A parser of whole numbers from 0.
pub fn index<T: TryFrom<u64>>() -> impl Fn(&str) -> Result<T, String> + Clone {
    whole(0..=u64::MAX)
}

/// Back ends.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// Graphics adapter for large models, where there is one that is no software
    /// adapter and can simulate the model; else processor.
    Auto,
    /// Processor.
    Cpu,
    /// Graphics adapter.
    Gpu,
}
