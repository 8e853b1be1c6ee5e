//! `scree inspect`: the frames, columns and ranges of data, and a metadata file to render it with.

use crate::failed::MissingValues;
use crate::job::{InspectJob, Suggestion};
use crate::report::{Exit, Failure, Outcome};
use bind::metadata::Data;
use bind::{Moment, emit};
use frame::table::Kind;
use frame::{Column, Frame, list};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Run `scree inspect`.
pub fn run(job: InspectJob) -> Outcome {
    if job.json {
        println!("{}", json(&job.frames, &job.table));
    } else {
        print(&job.frames, &job.table, job.data.is_dir());
    }
    if let Some(suggestion) = &job.suggestion {
        // Beside JSON there is nothing else on the standard output.
        let say = |line: String| if job.json { eprintln!("{line}") } else { println!("{line}") };
        write(&job.data, suggestion, &say)?;
    }
    job.failed.outcome(job.frames.len(), &format!("frame {} is shown", job.table.number))
}

/// Print what a frame has. Tables of other programs tell no time (`is_timed`).
fn print(frames: &[u64], table: &Frame, is_timed: bool) {
    /// Characters of the names that the next column keeps clear of.
    const WIDEST: usize = 40;
    let time = if is_timed { format!(" at {} s", table.time) } else { String::new() };
    let rows = if table.rows() == 1 { "1 row".into() } else { format!("{} rows", table.rows()) };
    println!("{}; frame {}{time} has {rows}", list::describe(frames), table.number);
    if let Some(gaps) = list::describe_gaps(frames) {
        println!("note: {gaps}");
    }
    let width = table.names().iter().map(|n| n.chars().count()).max().unwrap_or(0).min(WIDEST);
    for (field, column) in &table.columns {
        let unit = if matches!(field.unit.as_str(), "" | "1") { "" } else { &format!(" {}", field.unit) };
        let values = match column {
            Column::Category { codes, names } => {
                let used: BTreeSet<u32> = codes.iter().copied().collect();
                let shown = used.iter().take(8).map(|code| guard::text::line(&names[*code as usize]));
                let more = if used.len() > 8 { ", …" } else { "" };
                format!("names: {}{more}", shown.collect::<Vec<_>>().join(", "))
            }
            _ => column.range().map_or("no values".into(), |(lo, hi)| format!("{lo} to {hi}{unit}{}", missing(column))),
        };
        println!("  {:width$}  {:8}  {values}", guard::text::line(&field.name), column.kind());
    }
}

/// How many values of a column of numbers are missing.
fn missing(column: &Column) -> String {
    match (0..column.len()).filter(|row| column.number(*row).is_some_and(f64::is_nan)).count() {
        0 => String::new(),
        n => format!(", {n} missing"),
    }
}

fn json(frames: &[u64], table: &Frame) -> serde_json::Value {
    let column = |(field, column): &(frame::Field, Column)| {
        let range = column.range().map(|(lo, hi)| [lo, hi]);
        serde_json::json!({"name": field.name, "unit": field.unit, "type": column.kind(), "range": range})
    };
    serde_json::json!({
        "frames": frames, "missing": list::gaps(frames).map_or(vec![], |(_, missing)| missing), "frame": table.number, "time": table.time, "rows": table.rows(),
        "columns": table.columns.iter().map(column).collect::<Vec<_>>(),
    })
}

/// Write a metadata file for the data. One of other content is not replaced: it may have been edited.
fn write(data_path: &Path, Suggestion { path, frames, time, kind, up }: &Suggestion, say: &dyn Fn(String)) -> Outcome {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let path_in_file = relative(folder, data_path)?;
    let mut data = Data { time: time.clone(), rename: BTreeMap::new(), ..Data::default() };
    *(match kind {
        None => &mut data.run,
        Some(Kind::Csv) => &mut data.csv,
        Some(_) => &mut data.files,
    }) = Some(path_in_file);
    let suggestion = bind::suggest::metadata(data, frames, *up)
        .map_err(|m| Failure::new(Exit::Data, format!("{}: {m}", data_path.display())))?;
    let path = &guard::place_of(path);
    if path.exists() && std::fs::read_to_string(path).ok().as_ref() != Some(&suggestion.yaml) {
        let message =
            format!("{} exists and may have been edited: remove it, or write to another file", path.display());
        return Err(Failure::new(Exit::Usage, message));
    }
    frame::atomic::write(path, suggestion.yaml.as_bytes())?;
    suggestion.remarks.iter().for_each(|remark| say(format!("note: {remark}")));
    warn_of_faults(path, frames)?;
    let word = guard::text::shell_word(&path.display().to_string());
    say(format!("wrote {}; render it with `scree render {word}`", path.display()));
    Ok(())
}

/// Warn of frames that the metadata file cannot draw, and of rows.
fn warn_of_faults(path: &Path, frames: &[Frame]) -> Outcome {
    /// Frames whose faults are printed.
    const PRINTED: usize = 3;
    let binding = bind::read(path)?;
    let (mut values, mut faults) = (MissingValues::default(), vec![]);
    for frame in frames {
        match binding.check_columns(frame).and_then(|()| emit::check(&binding, &Moment::alone(frame))) {
            Ok(missing) => values.add(frame.number, &missing),
            Err(fault) => faults.push((frame.number, fault)),
        }
    }
    values.warnings().iter().for_each(|warning| eprintln!("warning: {warning}"));
    for (number, fault) in faults.iter().take(PRINTED) {
        eprintln!("warning: frame {number} cannot be drawn: {fault}");
    }
    if faults.len() > PRINTED {
        eprintln!("warning: {} further frames cannot be drawn", faults.len() - PRINTED);
    }
    Ok(())
}

/// The path of `target` for a file in `folder`: unchanged if the file is in the working folder, else absolute, or a name beside it.
fn relative(folder: &Path, target: &Path) -> Outcome<PathBuf> {
    if folder == Path::new(".") || target.is_absolute() {
        return Ok(target.into());
    }
    if let (Some(name), Some(parent)) = (target.file_name(), target.parent())
        && parent == folder
    {
        return Ok(name.into());
    }
    std::path::absolute(target).map_err(|e| Failure::new(Exit::Fault, format!("{}: {e}", target.display())))
}
