//! `scree schema`: JSON Schemas of models and metadata, so that editors complete and check them.

use crate::job::{SchemaJob, SchemaKind};
use crate::report::{Exit, Failure, Outcome};
use frame::atomic;

/// Run `scree schema`.
pub fn run(job: SchemaJob) -> Outcome {
    let schema = match job.kind {
        SchemaKind::Model => schemars::schema_for!(sim::model_file::ModelFile),
        SchemaKind::Metadata => schemars::schema_for!(bind::metadata::Metadata),
    };
    let text = serde_json::to_string_pretty(&schema)
        .map_err(|e| Failure::new(Exit::Fault, format!("the schema cannot be written: {e}")))?;
    match &job.output {
        Some(path) => atomic::write(path, format!("{text}\n").as_bytes())?,
        None => println!("{text}"),
    }
    Ok(())
}
