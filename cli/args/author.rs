//! Arguments of the commands for authors of models, metadata, scenes and shaders: `check`, `schema` and `shader`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

const CHECK_EXAMPLES: &str = "\
Example:
  scree check sim/models/pour.yaml metadata/quickstart.yaml";

/// Arguments of `scree check`.
#[derive(Args, Debug)]
#[command(after_help = CHECK_EXAMPLES)]
pub struct CheckArgs {
    /// Models and metadata (.yaml, .yml), RIB scenes (.rib, .rib.gz, .ribz)
    /// and shaders (.sl).
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// List the files that these read: archives, shaders, textures, tables,
    /// meshes.
    #[arg(long)]
    pub list_files: bool,
}

const SCHEMA_EXAMPLES: &str = "\
Example:
  scree schema model -o model.schema.json";

/// Arguments of `scree schema`.
#[derive(Args, Debug)]
#[command(after_help = SCHEMA_EXAMPLES)]
pub struct SchemaArgs {
    /// Kind of file that the schema describes.
    #[arg(value_name = "KIND")]
    pub kind: SchemaKind,
    /// File to write [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Kinds of file that have a schema.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum SchemaKind {
    /// Model, read by `scree simulate`.
    Model,
    /// Metadata file, read by `scree render`.
    Metadata,
}

const SHADER_EXAMPLES: &str = "\
Examples:
  scree shader gravel
  scree shader mine.sl --ir";

/// Arguments of `scree shader`.
#[derive(Args, Debug)]
#[command(after_help = SHADER_EXAMPLES)]
pub struct ShaderArgs {
    /// Shader files (.sl), or names of shaders of the library, as gravel.
    #[arg(required = true, value_name = "SHADER")]
    pub files: Vec<PathBuf>,
    /// Print the compiler's intermediate representation instead.
    #[arg(long)]
    pub ir: bool,
}
