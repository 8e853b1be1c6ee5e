//! What is shown: frames, and the binding that says what each row is drawn as.

use crate::args::Args;
use crate::fault::Failure;
use bind::binding::Color;
use bind::data::{Source, Store};
use bind::{Binding, Moment, Up, emit, suggest};
use frame::run::RunReader;
use frame::table::Kind;
use frame::yaml::Document;
use frame::{Frame, sequence};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Frames, and how they are drawn.
pub struct Input {
    /// Geometry, colours and camera of the rows.
    pub binding: Binding,
    /// The frames.
    pub source: Source,
    /// The run directory, if they are of one.
    pub run: Option<PathBuf>,
    /// Name of the recording.
    pub name: String,
}

/// Open the input of the command line.
pub fn open(args: &Args) -> Result<Input, Failure> {
    let path = &args.input;
    guard::give(path);
    if args.wait {
        wait(path);
    }
    let is_yaml = path.extension().is_some_and(|e| e == "yaml" || e == "yml");
    let input = if path.is_dir() {
        of_run(path)?
    } else if is_yaml && path.is_file() && !sequence::is_table(path) {
        of_metadata(path)?
    } else {
        of_tables(path)?
    };
    Ok(Input { name: path.file_stem().map_or("scree".into(), |stem| stem.to_string_lossy().into_owned()), ..input })
}

/// Wait until there is a run.
fn wait(path: &Path) {
    if !path.join("metadata.yaml").is_file() {
        eprintln!("waiting for {}", path.display());
    }
    while !(RunReader::is_run(path) && path.join("metadata.yaml").is_file()) {
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// A run directory, by the metadata that its simulation wrote.
fn of_run(folder: &Path) -> Result<Input, Failure> {
    let run = RunReader::open(folder)?;
    let metadata = folder.join("metadata.yaml");
    let mut binding = match metadata.is_file() {
        true => bind::read(&metadata)?,
        false => {
            let data = bind::metadata::Data { run: Some(".".into()), ..Default::default() };
            suggested(&Store::Run(run.clone()).into(), data, Up::of_run(folder), &metadata)?
        }
    };
    let source = binding.take_run(run);
    Ok(Input { binding, source, run: Some(folder.into()), name: String::new() })
}

/// A metadata file, and the data or the run of the model that it names.
fn of_metadata(path: &Path) -> Result<Input, Failure> {
    let binding = bind::read(path)?;
    let (source, run) = match &binding.model {
        None => (binding.open_data()?, None),
        Some(_) if binding.data.is_some() => (binding.open_data()?, None),
        Some(model) => {
            let stem = Path::new(path).file_stem().unwrap_or_default();
            let folder = Path::new("runs").join(stem);
            if !RunReader::is_run(&folder) {
                let message = format!(
                    "{} names the model {}, and {} is no run of it yet: simulate it, or name its run",
                    path.display(),
                    model.display(),
                    folder.display()
                );
                return Err(Failure::data(message));
            }
            (Store::Run(RunReader::open(&folder)?).into(), Some(folder))
        }
    };
    let run = run.or_else(|| match &source.store {
        Store::Run(run) => Some(run.folder.clone()),
        Store::Files { .. } => None,
    });
    Ok(Input { binding, source, run, name: String::new() })
}

/// Tables of other programs, by the metadata that is suggested for them.
fn of_tables(path: &Path) -> Result<Input, Failure> {
    let source = Source::open(path, None)?;
    let kind = match &source.store {
        Store::Files { files, .. } => files.values().next().map(|stored| stored.kind),
        Store::Run(_) => None,
    };
    let name: PathBuf = path.file_name().unwrap_or_default().into();
    let mut data = bind::metadata::Data::default();
    *(if kind == Some(Kind::Csv) { &mut data.csv } else { &mut data.files }) = Some(name);
    let binding = suggested(&source, data, Up::default(), &path.with_file_name("metadata.yaml"))?;
    Ok(Input { binding, source, run: None, name: String::new() })
}

/// The binding that is suggested for a source, as if it stood in a file at `path`.
fn suggested(source: &Source, data: bind::metadata::Data, up: Up, path: &Path) -> Result<Binding, Failure> {
    let frames = sample(source)?;
    let suggestion = suggest::metadata(data, &frames, up)
        .map_err(|message| Failure::data(format!("{}: {message}", path.display())))?;
    suggestion.remarks.iter().for_each(|remark| eprintln!("note: {remark}"));
    let (metadata, doc): (bind::Metadata, Document) = frame::yaml::parse(path, suggestion.yaml)?;
    Ok(bind::metadata::check(metadata, doc)?)
}

/// Some frames of a source, those of them that can be read.
fn sample(source: &Source) -> Result<Vec<Frame>, Failure> {
    let numbers = source.numbers();
    let Some(first) = numbers.first() else { return Err(Failure::data("the data has no frames yet")) };
    let rows = source.read(*first).map_or(0, |frame| frame.rows());
    let frames = suggest::sample(&numbers, rows).into_iter().map(|number| source.read(number));
    let read: Vec<Frame> = frames.filter_map(Result::ok).collect();
    match read.is_empty() {
        true => Err(source.read(*first).map(|_| Failure::data("no frame can be read")).unwrap_or_else(Failure::from)),
        false => Ok(read),
    }
}

/// Settle the ranges of colours that the metadata leaves open: those of some frames of the data, of each object.
pub fn settle_ranges(input: &mut Input) -> Result<(), Failure> {
    let is_open = |color: &Color| matches!(color, Color::By { range: None, .. });
    if !input.binding.objects.iter().any(|object| is_open(&object.color)) {
        return Ok(());
    }
    let ranges: Vec<_> =
        sample(&input.source)?.iter().map(|frame| emit::color_ranges(&input.binding, &Moment::alone(frame))).collect();
    for (i, object) in input.binding.objects.iter_mut().enumerate() {
        if let Color::By { range: range @ None, .. } = &mut object.color {
            *range = ranges.iter().filter_map(|all| all[i]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        }
    }
    Ok(())
}
