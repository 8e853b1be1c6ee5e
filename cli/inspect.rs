//! `scree inspect`: what data holds, and a metadata file to start from.

use crate::args::InspectArgs;
use crate::report::{Exit, Failure, Outcome};
use bind::data::Source;
use bind::metadata::Data;
use frame::{Column, Frame};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The command.
pub fn command(args: &InspectArgs) -> Outcome {
    let source = Source::open(&args.data)?;
    let numbers = source.numbers();
    let number = match args.frame {
        Some(n) if !numbers.contains(&n) => {
            return Err(Failure::new(
                Exit::Usage,
                format!("--frame {n}: the data has {}", bind::frames::describe(&numbers)),
            ));
        }
        Some(n) => n,
        None => *numbers.first().ok_or_else(|| Failure::new(Exit::Data, "the data has no frames yet"))?,
    };
    let table = source.read(number)?;
    if args.json {
        println!("{}", json(&numbers, &table));
    } else {
        print(&numbers, &table);
    }
    match &args.write {
        Some(path) => write(args, &table, path),
        None => Ok(()),
    }
}

fn print(numbers: &[u64], table: &Frame) {
    println!(
        "{}; frame {} at {} s has {} rows",
        bind::frames::describe(numbers),
        table.number,
        table.time,
        table.rows()
    );
    let width = table.names().iter().map(|n| n.len()).max().unwrap_or(0);
    for (field, column) in &table.columns {
        let unit = if field.unit.is_empty() { String::new() } else { format!(" {}", field.unit) };
        let values = match column {
            Column::Category { names, .. } => {
                format!("words: {}", names.iter().take(8).cloned().collect::<Vec<_>>().join(", "))
            }
            _ => column.range().map_or("no numbers".into(), |(lo, hi)| format!("{lo} to {hi}{unit}")),
        };
        println!("  {:width$}  {:8}  {values}", field.name, column.kind());
    }
}

fn json(numbers: &[u64], table: &Frame) -> serde_json::Value {
    let column = |(field, column): &(frame::Field, Column)| {
        let range = column.range().map(|(lo, hi)| [lo, hi]);
        serde_json::json!({"name": field.name, "unit": field.unit, "type": column.kind(), "range": range})
    };
    serde_json::json!({
        "frames": numbers, "frame": table.number, "time": table.time, "rows": table.rows(),
        "columns": table.columns.iter().map(column).collect::<Vec<_>>(),
    })
}

fn write(args: &InspectArgs, table: &Frame, path: &Path) -> Outcome {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let from_there = relative(folder, &args.data)?;
    let mut data = Data { rename: BTreeMap::new(), ..Data::default() };
    if args.data.is_dir() {
        data.run = Some(from_there);
    } else {
        data.csv = Some(from_there);
    }
    let metadata = bind::suggest::metadata(data, &[table])
        .map_err(|m| Failure::new(Exit::Data, format!("{}: {m}", args.data.display())))?;
    frame::atomic::write(path, bind::suggest::to_yaml(&metadata, table).as_bytes())?;
    println!("wrote {}: draw it with `scree render {}`", path.display(), path.display());
    Ok(())
}

/// `target` as it is named from `folder`: as it is if they share the working folder, else absolute.
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
