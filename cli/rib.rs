//! `scree rib`: a frame as RIB, standard calls only.

use crate::args::RibArgs;
use crate::library;
use crate::report::{Exit, Failure, Outcome};
use crate::source;
use bind::emit;
use render::ri::writer::Writer;
use std::io::Write;

/// The command.
pub fn command(args: &RibArgs) -> Outcome {
    let (checked, data, _) = source::open(&args.input)?;
    let existing = data.numbers();
    if !existing.contains(&args.frame) {
        let message = format!("--frame {}: the data has {}", args.frame, bind::frames::describe(&existing));
        return Err(Failure::new(Exit::Usage, message));
    }
    let table = data.read(args.frame)?;
    checked.check_columns(&table)?;
    let files = checked.files(library::files(&checked.folder()));
    let mut writer = Writer::new(Vec::new()).map_err(|f| Failure::new(Exit::Fault, f.message))?;
    emit::frame(&checked, &table, &format!("{:06}.png", args.frame), &files, &mut writer)?;
    let bytes = writer.into_inner();
    match &args.output {
        Some(path) => Ok(frame::atomic::write(path, &bytes)?),
        None => match std::io::stdout().lock().write_all(&bytes) {
            // Whoever reads has had enough.
            Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
            done => done.map_err(|e| Failure::new(Exit::Fault, format!("standard output: {e}"))),
        },
    }
}
