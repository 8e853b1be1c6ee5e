//! `scree run`: the whole way, from a model or a metadata file to a movie.

use crate::args::RunArgs;
use crate::job::{self, Pictures, Yaml};
use crate::report::Outcome;
use crate::{movie, render, simulate, source};
use std::path::{Path, PathBuf};

/// The command.
pub fn run(args: &RunArgs) -> Outcome {
    let home = args.output.clone().unwrap_or_else(|| job::default_output(&args.input));
    let mut is_simulated = true;
    let (checked, data) = match job::kind_of(&args.input)? {
        Yaml::Model => {
            source::ensure_run(&args.input, &home, args.fresh)?;
            job::metadata_of_run(&home)?
        }
        Yaml::Metadata => {
            let checked = bind::read(&args.input)?;
            // Everything that can be checked before hours of work is checked first.
            job::check_library(&checked, &checked.files(crate::library::files(&checked.folder())))?;
            is_simulated = checked.data.is_none();
            let data = source::data_of(&checked, &home, args.fresh)?;
            (checked, data)
        }
    };
    let pictures = Pictures::resolve(checked, data, home.join("images"), &args.pictures)?;
    render::pictures_of(&pictures, None, args.pictures.missing, render::Telling::default())?;
    println!("images: {} in {}", pictures.frames.len(), pictures.folder.display());
    encode(&pictures, &home.join(job::stem(&args.input)))?;
    render::missing_frames(&pictures)?;
    if is_simulated { simulate::warned(&home) } else { Ok(()) }
}

fn encode(pictures: &Pictures, goal: &Path) -> Outcome {
    let images: Vec<PathBuf> = pictures.frames.iter().map(|f| pictures.image(*f)).collect();
    if images.first().is_some_and(|i| i.extension().is_some_and(|e| e != "png")) {
        eprintln!("movies are made of PNG pictures; these are EXR: no movie");
        return Ok(());
    }
    let movie = movie::encode(&images, goal, pictures.checked.frame_rate)?;
    println!("movie: {}", movie.display());
    Ok(())
}
