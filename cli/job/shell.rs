//! The jobs of `scree completions` and `scree man`, which are made from the command line itself.

use crate::args::{Args, CompletionsArgs, ManArgs};
use crate::report::{Exit, Failure, Outcome};
use clap::{Command, CommandFactory};
use std::path::PathBuf;

/// Text for a shell, or pages of the manual, to write.
pub struct ShellJob {
    /// The files, with their names; one without a name goes to the standard output.
    pub files: Vec<(Option<PathBuf>, Vec<u8>)>,
}

impl ShellJob {
    /// The completions of a shell.
    pub fn completions(args: CompletionsArgs) -> Outcome<ShellJob> {
        let mut text = vec![];
        clap_complete::generate(args.shell, &mut Args::command(), "scree", &mut text);
        Ok(ShellJob { files: vec![(None, text)] })
    }

    /// The pages of the manual: one of `scree`, and one of each command.
    pub fn man(args: ManArgs) -> Outcome<ShellJob> {
        let mut command = Args::command();
        command.build();
        let mut all = vec![];
        visible(&command, &mut all);
        let pages = all.into_iter().map(|own| {
            let name = own.get_display_name().unwrap_or(own.get_name()).to_string();
            let mut text = vec![];
            // A handful of names for the program's whole life.
            let title: &'static str = Box::leak(name.clone().into_boxed_str());
            let page = clap_mangen::Man::new(own.clone().name(title));
            page.render(&mut text).map_err(|e| Failure::new(Exit::Fault, format!("{name}.1: {e}")))?;
            Ok((Some(args.folder.join(format!("{name}.1"))), text))
        });
        Ok(ShellJob { files: pages.collect::<Outcome<_>>()? })
    }
}

/// A command and those below it that users are shown.
fn visible<'a>(command: &'a Command, all: &mut Vec<&'a Command>) {
    all.push(command);
    let below = command.get_subcommands().filter(|own| !own.is_hide_set() && own.get_name() != "help");
    below.for_each(|own| visible(own, all));
}
