//! `scree schema`: JSON Schemas of models and metadata, so that editors complete and check them.

use crate::args::{SchemaArgs, SchemaOf};
use crate::report::{Exit, Failure, Outcome};
use frame::atomic;

/// The command.
pub fn command(args: &SchemaArgs) -> Outcome {
    let schema = match args.of {
        SchemaOf::Model => schemars::schema_for!(sim::model_file::ModelFile),
        SchemaOf::Metadata => schemars::schema_for!(bind::metadata::Metadata),
    };
    let text = serde_json::to_string_pretty(&schema)
        .map_err(|e| Failure::new(Exit::Fault, format!("the schema cannot be written: {e}")))?;
    match &args.output {
        Some(path) => atomic::write(path, format!("{text}\n").as_bytes())?,
        None => println!("{text}"),
    }
    Ok(())
}
