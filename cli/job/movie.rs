//! The job of `scree movie`.

use crate::args::MovieArgs;
use crate::report::{Exit, Failure, Outcome};
use frame::{Fault, FaultKind};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// A movie to encode.
pub struct MovieJob {
    /// The images, in order.
    pub images: Vec<PathBuf>,
    /// The movie's file.
    pub output: MovieFile,
    /// Frames per second.
    pub frame_rate: f64,
    /// Frames between the images that have no image.
    pub n_missing: u64,
}

/// The file of a movie.
pub enum MovieFile {
    /// A file whose ending names its kind.
    OfKind(MovieKind, PathBuf),
    /// A path without ending: `.mp4` is added, or `.apng` where ffmpeg is not installed.
    Stem(PathBuf),
}

/// A kind of movie file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MovieKind {
    /// MPEG-4.
    Mp4,
    /// QuickTime.
    Mov,
    /// Matroska.
    Mkv,
    /// WebM.
    Webm,
    /// Animated GIF.
    Gif,
    /// Animated PNG.
    Apng,
}

/// The endings of movies, and their kinds.
const ENDINGS: [(&str, MovieKind); 7] = [
    ("mp4", MovieKind::Mp4),
    ("mov", MovieKind::Mov),
    ("mkv", MovieKind::Mkv),
    ("webm", MovieKind::Webm),
    ("gif", MovieKind::Gif),
    ("apng", MovieKind::Apng),
    ("png", MovieKind::Apng),
];

/// The most images per second of a GIF: its delays are whole hundredths of a second, and players show one hundredth as ten.
const MAX_GIF_RATE: f64 = 50.0;

impl MovieJob {
    /// Check the arguments: find the images, and the kind of movie by the ending of its file.
    pub fn check(args: MovieArgs) -> Outcome<MovieJob> {
        let MovieArgs { images: folder, output, frame_rate, keep_gaps } = args;
        let output = match output {
            Some(path) => MovieFile::of(&path, &folder)?,
            None => MovieFile::Stem(default_stem(&folder)),
        };
        if let MovieFile::OfKind(MovieKind::Gif, path) = &output
            && frame_rate > MAX_GIF_RATE
        {
            let message = format!(
                "{}: a GIF has at most {MAX_GIF_RATE} images per second, and --frame-rate is {frame_rate}",
                path.display()
            );
            return Err(Failure::new(Exit::Usage, message));
        }
        check_folder(&folder)?;
        let found = frame::sequence::find(&folder.join("*.png"))?;
        if let MovieFile::OfKind(_, path) = &output
            && guard::is_one_of(path, found.values())
        {
            let message = format!("--output {}: is one of the images", path.display());
            return Err(Failure::new(Exit::Usage, message));
        }
        let missing = missing_frames(&found.keys().copied().collect::<Vec<_>>());
        if !missing.is_empty() && !keep_gaps {
            return Err(gap_fault(&folder, &missing).into());
        }
        let n_missing = missing.iter().map(|m| m.count).sum();
        Ok(MovieJob { images: found.into_values().collect(), output, frame_rate, n_missing })
    }
}

impl MovieFile {
    /// The file that `-o` names.
    fn of(path: &Path, folder: &Path) -> Outcome<MovieFile> {
        let refuse = |message: &str| Err(Failure::new(Exit::Usage, format!("--output {}: {message}", path.display())));
        if path.as_os_str().to_string_lossy().ends_with(['/', '\\']) || path.file_name().is_none() {
            return refuse("is a folder; name the movie's file");
        }
        let Some(ending) = path.extension().and_then(OsStr::to_str).filter(|e| is_ending(e)) else {
            return Ok(MovieFile::Stem(path.into()));
        };
        let Some((_, kind)) = ENDINGS.iter().find(|(e, _)| ending.eq_ignore_ascii_case(e)) else {
            let known: Vec<String> = ENDINGS.iter().map(|(e, _)| format!(".{e}")).collect();
            return refuse(&format!(
                "`.{ending}` is no kind of movie; expected {} (animated), or no ending for .mp4",
                known.join(", ")
            ));
        };
        if path.is_dir() {
            return refuse("is a folder; name the movie's file");
        }
        let beside = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if ending.eq_ignore_ascii_case("png") && is_same_folder(beside, folder) {
            return refuse("would be taken for one of the images of its folder; write it elsewhere, or as .apng");
        }
        Ok(MovieFile::OfKind(*kind, path.into()))
    }
}

/// Whether what follows the last dot of a name is meant as a file's ending: `friction=0.3` has none.
fn is_ending(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.chars().all(|c| c.is_ascii_alphanumeric())
}

fn is_same_folder(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// The path of a folder's movie, without ending: a folder `images` has the movie of the folder that it is in, there; any other has
/// one of its own name, beside it, or in it if the folder around it has the same name.
fn default_stem(folder: &Path) -> PathBuf {
    let absolute = || folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    let (folder, name) = match folder.file_name() {
        Some(name) => (folder.to_path_buf(), name.to_os_string()),
        // `.` and `..`
        None => (absolute(), absolute().file_name().unwrap_or(OsStr::new("movie")).to_os_string()),
    };
    let beside = folder.parent().unwrap_or(Path::new(""));
    let absolute = folder.canonicalize().unwrap_or_else(|_| folder.clone());
    let owner = beside.file_name().or_else(|| absolute.parent().and_then(Path::file_name));
    match owner {
        owner if name == "images" => beside.join(owner.unwrap_or(OsStr::new("movie"))),
        Some(owner) if owner == name => folder.join(name),
        _ => beside.join(name),
    }
}

/// Check that a folder has PNG images.
fn check_folder(folder: &Path) -> Outcome {
    let fault = |message: &str| Fault::whole(FaultKind::Data, folder, message);
    if !folder.exists() {
        return Err(fault("does not exist; expected a folder of PNG images").into());
    }
    if !folder.is_dir() {
        return Err(fault("is a file; expected the folder of the images").into());
    }
    let count = |folder: &Path, ending: &str| {
        let has_ending = |p: &Path| p.extension().is_some_and(|e| e == ending);
        std::fs::read_dir(folder).map_or(0, |all| all.flatten().filter(|e| has_ending(&e.path())).count())
    };
    if count(folder, "png") > 0 {
        return Ok(());
    }
    let n_exr = count(folder, "exr");
    if n_exr > 0 {
        let message = format!("has {n_exr} EXR images and no PNG image: movies are made of PNG images");
        let hint = "render again with `format: png` under `output` of the metadata file, into another folder by `-o`";
        return Err(fault(&message).hint(hint).into());
    }
    let inner = folder.join("images");
    if count(&inner, "png") > 0 {
        let hint = format!("its images are in {0}: `scree movie {0}`", inner.display());
        return Err(fault("has no PNG images").hint(hint).into());
    }
    Err(fault("has no PNG images").hint("`scree render` makes them").into())
}

/// Frames in a row that have no image.
#[derive(Debug, PartialEq)]
struct Missing {
    first: u64,
    last: u64,
    count: u64,
}

/// The gaps between images whose frames are otherwise evenly spaced.
fn missing_frames(frames: &[u64]) -> Vec<Missing> {
    let step = frames.windows(2).map(|w| w[1] - w[0]).min().unwrap_or(1);
    let gap = |w: &[u64]| {
        let count = (w[1] - w[0] - 1) / step;
        (count > 0).then(|| Missing { first: w[0] + step, last: w[0] + count * step, count })
    };
    frames.windows(2).filter_map(gap).collect()
}

fn gap_fault(folder: &Path, missing: &[Missing]) -> Fault {
    let count: u64 = missing.iter().map(|m| m.count).sum();
    let name = |m: &Missing| if m.count == 1 { m.first.to_string() } else { format!("{}-{}", m.first, m.last) };
    let mut names: Vec<String> = missing.iter().take(10).map(name).collect();
    if missing.len() > names.len() {
        names.push("…".into());
    }
    let (noun, verb) = if count == 1 { ("image", "is") } else { ("images", "are") };
    let message = format!("{count} {noun} {verb} missing between the others: frames {}", names.join(", "));
    Fault::whole(FaultKind::Data, folder, message)
        .hint("render them with `scree render …`, or encode the images that are there with `--keep-gaps`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_found_between_evenly_spaced_frames() {
        let found =
            |frames: &[u64]| missing_frames(frames).iter().map(|m| (m.first, m.last, m.count)).collect::<Vec<_>>();
        assert_eq!(found(&[0, 1, 2]), []);
        assert_eq!(found(&[7]), []);
        assert_eq!(found(&[0, 5, 10, 25, 30]), [(15, 20, 2)]);
        assert_eq!(found(&[0, 1, 3, 1_000_000_000_000]), [(2, 2, 1), (4, 999_999_999_999, 999_999_999_996)]);
    }

    #[test]
    fn each_folder_of_a_run_has_a_default_of_its_own() {
        for (folder, movie) in [
            ("runs/a/images", "runs/a/a"),
            ("runs/a/images/", "runs/a/a"),
            ("runs/friction=0.3/images", "runs/friction=0.3/friction=0.3"),
            ("runs/a/wide", "runs/a/wide"),
            ("runs/a/a", "runs/a/a/a"),
            ("runs/a/images/depth", "runs/a/images/depth"),
        ] {
            assert_eq!(default_stem(Path::new(folder)), Path::new(movie), "{folder}");
        }
    }
}
