//! Arguments of the commands for authors of models, metadata, scenes and shaders, and for their shells and machines: `check`, `schema`,
//! `shader`, `init`, `completions`, `man` and `doctor`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

const CHECK_EXAMPLES: &str = "\
Example:
  scree check model.yaml metadata.yaml";

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
    /// Print JSON: of each file its kind, its warnings and its fault with its
    /// place.
    #[arg(long, conflicts_with = "list_files")]
    pub json: bool,
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
    /// Print JSON: of each shader its kind, its name and its parameters.
    #[arg(long, conflicts_with = "ir")]
    pub json: bool,
}

/// Projects to start from.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum StarterArg {
    /// Stones that fall into a box.
    Drop,
    /// A blade that is drawn through a bed of grains, and its force.
    Plough,
}

/// Arguments of `scree init`.
#[derive(Args, Debug)]
pub struct InitArgs {
    /// Folder of the project, which must not exist or be empty.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// What the project begins as.
    #[arg(long, value_name = "NAME", value_enum, default_value = "drop")]
    pub starter: StarterArg,
}

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  scree completions bash > ~/.local/share/bash-completion/completions/scree
  scree completions fish > ~/.config/fish/completions/scree.fish";

/// Arguments of `scree completions`.
#[derive(Args, Debug)]
#[command(after_help = COMPLETIONS_EXAMPLES)]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

/// Arguments of `scree man`.
#[derive(Args, Debug)]
pub struct ManArgs {
    /// Folder of the pages, scree.1 and one of each command.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

const DOCTOR_EXAMPLES: &str = "\
Examples:
  scree doctor
  scree doctor --json /scratch/films";

/// Arguments of `scree doctor`.
#[derive(Args, Debug)]
#[command(after_help = DOCTOR_EXAMPLES)]
pub struct DoctorArgs {
    /// Folder that results would go to: its free space is told, and how fast it
    /// takes a file.
    #[arg(value_name = "DIR", default_value = ".")]
    pub folder: PathBuf,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}
