//! `scree rib`: a frame as RIB, standard requests only.

use crate::failed::MissingValues;
use crate::job::RibJob;
use crate::levels;
use crate::library;
use crate::model_run;
use crate::ranges;
use crate::report::{Exit, Failure, Outcome, Printed};
use bind::binding::ImageFormat;
use bind::{Moment, emit};
use frame::list;
use render::ri::writer::Writer;
use std::io::Write;
use std::path::Path;

/// Run `scree rib`.
pub fn run(job: RibJob) -> Outcome {
    let (mut binding, source) = model_run::provide(job.frames)?;
    let existing = source.numbers();
    if !existing.contains(&job.frame) {
        let message = format!("--frame {}: the data has {}", job.frame, list::describe(&existing));
        return Err(Failure::new(Exit::Usage, message));
    }
    let table = source.read(job.frame)?;
    binding.check_columns(&table)?;
    ranges::of_data(&mut binding, &source, None)?;
    let files = binding.files(library::files(&binding.folder()));
    levels::settle(&mut binding, &source, &files);
    let mut writer = Writer::new(Vec::new()).map_err(|f| Failure::new(Exit::Fault, f.message))?;
    // A name that ends otherwise would have the image written in another format.
    let ending = if binding.output.format == ImageFormat::Exr { "exr" } else { "png" };
    let missing = emit::frame(
        &binding,
        &Moment::of(&binding, &source, &table)?,
        &format!("{:06}.{ending}", job.frame),
        &files,
        &mut writer,
    )?;
    let mut values = MissingValues::default();
    values.add(job.frame, &missing);
    values.warn(&mut Printed::default());
    let bytes = writer.into_inner();
    match &job.output {
        Some(path) if guard::was_seen(path) => {
            let message = format!("--output {}: is one of the files that the frame is made of", path.display());
            Err(Failure::new(Exit::Usage, message))
        }
        Some(path) if is_other(path) => {
            let message = format!("--output {}: is a file that is no RIB, which is not replaced", path.display());
            Err(Failure::new(Exit::Usage, message))
        }
        Some(path) => Ok(frame::atomic::write(path, &bytes)?),
        None => match std::io::stdout().lock().write_all(&bytes) {
            // A reader may stop early, as `head` does.
            Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
            written => written.map_err(|e| Failure::new(Exit::Fault, format!("standard output: {e}"))),
        },
    }
}

/// Whether a file is there that is no RIB, as a table of a run.
fn is_other(path: &Path) -> bool {
    let bytes = std::fs::read(guard::place_of(path)).unwrap_or_default();
    let is_rib = bytes.is_empty() || bytes.starts_with(b"##RenderMan") || bytes.starts_with(b"version");
    guard::place_of(path).is_file() && !is_rib
}
