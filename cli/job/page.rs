//! The job of `scree report`: the series, images and film of a run, or of the runs of a folder, and the page to write.

use super::plot::names::{labels, name_of};
use super::plot::table::{self, TimeTable};
use super::plot::{choose, of_owners, overlay};
use super::run_folder::spare_link;
use super::{Curve, Plot};
use crate::args::ReportArgs;
use crate::ledger::Claims;
use crate::report::{Exit, Failure, Outcome};
use frame::run::RunReader;
use frame::{Fault, FaultKind};
use rayon::prelude::*;
use serde::Deserialize;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// A page to make.
pub struct ReportJob {
    /// What it is of.
    pub subject: Subject,
    /// The page's file.
    pub output: PathBuf,
    /// Bytes of the largest film that is put into the page.
    pub embed_film: u64,
    /// Images that the page of a run shows.
    pub n_images: usize,
}

/// What a page is of.
pub enum Subject {
    /// A run.
    Run(Box<RunData>),
    /// The runs of a folder, in the order of their names, and the plots of their probes laid over each other.
    Sweep {
        /// The folder's name.
        name: String,
        /// The runs.
        runs: Vec<RunData>,
        /// A plot for each column of the probes, with a curve for each run that has it.
        plots: Vec<Plot>,
        /// Columns that some of the runs have not.
        notes: Vec<String>,
        /// Runs that cannot be read.
        faults: Vec<String>,
    },
}

/// The energies of a run and the work that it was given, J; none of what its model has not.
pub struct Energies {
    /// Of the bodies' motion.
    pub kinetic: Curve,
    /// Of gravity.
    pub potential: Curve,
    /// Of springs.
    pub elastic: Option<Curve>,
    /// Of bodies that have come, as they did.
    pub arrived: Option<Curve>,
    /// Work of motors, and of loads.
    pub work: [Option<Curve>; 2],
}

/// What is read of a run.
pub struct RunData {
    /// Its name: that of its folder.
    pub name: String,
    /// What differs between its name and those of the other runs.
    pub label: String,
    /// The name of its model; empty if it has none.
    pub model: String,
    /// Its index.
    pub run: RunReader,
    /// Whether a process simulates into it.
    pub is_running: bool,
    /// The plots of its probes; of a sweep none, since they are laid over each other.
    pub plots: Vec<Plot>,
    /// The energies among its probes, if they are there.
    pub energies: Option<Energies>,
    /// The columns of its report, with the milliseconds of the stages.
    pub report: Vec<Curve>,
    /// Its images, by frame.
    pub images: Vec<(u64, PathBuf)>,
    /// Its films, the one by its own name first.
    pub films: Vec<PathBuf>,
    /// What of it is not shown.
    pub notes: Vec<String>,
    /// What of it cannot be read.
    pub faults: Vec<String>,
}

/// What the head of a page of ours has, by which it is known.
pub const MARK: &str = "<meta name=\"generator\" content=\"scree report\">";

/// The name of a run's page.
pub const PAGE: &str = "report.html";

/// What a page takes of a model.
#[derive(Default, Deserialize)]
struct Model {
    #[serde(default)]
    name: String,
    #[serde(default)]
    joints: Vec<Joint>,
}

/// A joint of it.
#[derive(Deserialize)]
struct Joint {
    name: String,
    kind: String,
}

/// Joints that lock distances alone, and no angle.
const WITHOUT_ANGLES: [&str; 3] = ["spherical", "distance", "point_on_plane"];

/// The unit of an error of a joint's distances and angles, of which it is the greatest.
const MIXED_UNIT: &str = "m or rad";

const PROBES: &str = "probes.csv";
const REPORT: &str = "report.csv";

/// The endings of films, those that browsers play best first.
const FILMS: [&str; 6] = ["mp4", "webm", "mov", "apng", "gif", "mkv"];

impl ReportJob {
    /// Check the arguments: find the runs, read their series, choose among the columns.
    pub fn check(args: ReportArgs) -> Outcome<ReportJob> {
        let ReportArgs { run: folder, columns, output, embed_film, images: n_images } = args;
        let folders = find(&folder)?;
        let output = match output {
            Some(path) => path,
            None => {
                spare_link(&folder.join(PAGE), &folder)?;
                folder.join(PAGE)
            }
        };
        check_output(&output)?;
        let places = (output, embed_film, n_images);
        if !RunReader::is_run(&folder) {
            return ReportJob::of_sweep(&folder, &folders, &columns, places);
        }
        let (run, table) = read(&folder)?;
        let mut tables = [table];
        choose(&mut tables, &columns)?;
        let plots = tables.into_iter().flat_map(of_owners).collect();
        Ok(ReportJob::new(Subject::Run(Box::new(RunData { plots, ..run })), places))
    }

    fn new(subject: Subject, (output, embed_film, n_images): (PathBuf, u64, usize)) -> ReportJob {
        ReportJob { subject, output, embed_film, n_images }
    }

    /// The page of a folder of runs. Those that cannot be read are noted; an error if none can.
    fn of_sweep(
        folder: &Path,
        folders: &[PathBuf],
        columns: &[String],
        places: (PathBuf, u64, usize),
    ) -> Outcome<ReportJob> {
        let (mut runs, mut tables, mut faults) = (vec![], vec![], vec![]);
        let read: Vec<_> = folders.par_iter().map(|folder| read(folder)).collect();
        for (path, found) in folders.iter().zip(read) {
            match found {
                Ok((run, table)) => {
                    runs.push(run);
                    tables.push(table);
                }
                Err(e) => faults.push(format!("{} is left out: {e}", name_of(path))),
            }
        }
        if runs.is_empty() {
            let message = format!("{}: none of its runs can be read\n  = {}", folder.display(), faults.join("\n  = "));
            return Err(Failure::new(Exit::Data, message));
        }
        choose(&mut tables, columns)?;
        let paths: Vec<PathBuf> = runs.iter().map(|run| run.run.folder.clone()).collect();
        for (run, label) in runs.iter_mut().zip(labels(&paths)) {
            run.label = label;
        }
        let (plots, notes) = overlay(&paths, tables)?;
        Ok(ReportJob::new(Subject::Sweep { name: name_of(folder), runs, plots, notes, faults }, places))
    }
}

/// The run directories of a path: itself, or those in it.
fn find(path: &Path) -> Outcome<Vec<PathBuf>> {
    let usage = |message: String| Err(Failure::new(Exit::Usage, message));
    if !path.exists() {
        let fault = Fault::whole(
            FaultKind::Data,
            path,
            "does not exist; expected a run directory, or a folder of run directories",
        );
        return Err(fault.into());
    }
    if path.is_file() {
        let folder = path.parent().filter(|p| RunReader::is_run(p) && !p.as_os_str().is_empty());
        let hint = folder.map_or("a table is plotted by `scree plot FILE`".into(), |folder| {
            format!("it is a file of a run: scree report {}", folder.display())
        });
        let message =
            format!("{}: is a file; expected a run directory, or a folder of them\n  = {hint}", path.display());
        return usage(message);
    }
    if RunReader::is_run(path) {
        return Ok(vec![path.into()]);
    }
    guard::permit(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    let entries = std::fs::read_dir(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    let entries: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    let runs: Vec<PathBuf> = entries.iter().filter(|p| p.is_dir() && RunReader::is_run(p)).cloned().collect();
    if !runs.is_empty() {
        return Ok(table::in_natural_order(runs));
    }
    let there = format!("{}: has no run.json, and none of its folders has one: it is no run of scree", path.display());
    let tables = entries.iter().filter(|p| p.is_file() && frame::sequence::is_table(p)).count();
    usage(match tables {
        0 => format!("{there}\n  = make a run: scree simulate model.yaml -o {}", path.display()),
        n => format!(
            "{there}, but has {n} {}\n  = plot a table that has a column `time`: scree plot FILE.csv\n  = \
             look at tables of one instant each, and draw them: scree inspect '{}' --write md.yaml",
            if n == 1 { "table" } else { "tables" },
            path.join("NAME_*.csv").display()
        ),
    })
}

/// Refuse to replace what is no page of ours.
fn check_output(path: &Path) -> Outcome {
    let usage = |message: &str| Err(Failure::new(Exit::Usage, format!("{}: {message}", path.display())));
    if path.is_dir() || path.as_os_str().to_string_lossy().ends_with('/') {
        return usage("is a folder; name the page's file: -o FILE (--output)");
    }
    if let Some(folder) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        guard::allow(folder);
    }
    if path.symlink_metadata().is_err() {
        return Ok(());
    }
    /// Bytes in which the mark stands.
    const HEAD: u64 = 1024;
    let mut head = vec![];
    let is_file = path.metadata().is_ok_and(|m| m.is_file());
    let read = || std::fs::File::open(path)?.take(HEAD).read_to_end(&mut head);
    if is_file && { read }().is_ok() && String::from_utf8_lossy(&head).contains(MARK) {
        return Ok(());
    }
    usage("exists and is no page of `scree report`: it is not replaced\n  = write to another file: -o FILE (--output)")
}

/// Read a run and the table of its probes. An error if its index cannot be read; what else cannot be is noted.
fn read(folder: &Path) -> Outcome<(RunData, TimeTable)> {
    let run = RunReader::open(folder)?;
    let (mut notes, mut faults) = (vec![], missing(&run));
    let mut series = |name: &str| {
        let path = folder.join(name);
        if !has_rows(&path) {
            return TimeTable { columns: vec![] };
        }
        table::read(&path).unwrap_or_else(|e| {
            faults.push(e.message);
            TimeTable { columns: vec![] }
        })
    };
    let (mut probes, report) = (series(PROBES), series(REPORT));
    let model = model(folder);
    for column in probes.columns.iter_mut().filter(|c| c.unit == MIXED_UNIT) {
        let owner = column.name.rsplit_once('.').map_or("", |(owner, _)| owner);
        if model.joints.iter().any(|j| j.name == owner && WITHOUT_ANGLES.contains(&j.kind.as_str())) {
            column.unit = "m".into();
        }
    }
    let curve =
        |c: &table::TimeColumn| Curve { label: c.name.clone(), points: c.points.clone(), has_start: c.has_start };
    let named = |name: &str| probes.columns.iter().find(|c| c.name == name && c.unit == "J").map(curve);
    let energies = named("energy.kinetic").zip(named("energy.potential")).map(|(kinetic, potential)| Energies {
        kinetic,
        potential,
        elastic: named("energy.elastic"),
        arrived: named("energy.arrived"),
        work: ["work.motors", "work.loads"].map(named),
    });
    let data = RunData {
        name: name_of(folder),
        label: String::new(),
        model: model.name,
        is_running: is_running(&run),
        plots: vec![],
        energies,
        report: report.columns.iter().map(curve).collect(),
        images: images(folder, &mut notes, &mut faults),
        films: films(folder, &mut faults),
        notes,
        faults,
        run,
    };
    Ok((data, probes))
}

/// What a page takes of a run's model; nothing of one that cannot be read.
fn model(folder: &Path) -> Model {
    let path = folder.join("model.yaml");
    let text = if guard::leads_out(&path, folder) { None } else { guard::read_to_string(&path).ok() };
    text.and_then(|text| serde_yaml::from_str(&text).ok()).unwrap_or_default()
}

/// Whether a process simulates into a run that has not come to its end: it holds the run's lock.
fn is_running(run: &RunReader) -> bool {
    let lock = run.folder.join(".lock");
    let is_open = !run.index.complete && lock.is_file() && !guard::leads_out(&lock, &run.folder);
    is_open && Claims::open(&lock).claim("simulation").is_none()
}

/// Files that a run of this many frames has written, and that are not there.
fn missing(run: &RunReader) -> Vec<String> {
    let n = run.index.frames.len();
    let mut faults = vec![];
    // The series of a run that has just begun may not be there yet.
    if run.index.complete || n > 1 {
        let lost = [REPORT, PROBES].map(|name| run.folder.join(name)).into_iter().filter(|path| !path.exists());
        faults.extend(lost.map(|path| format!("{}: is not there, and the run has written it", path.display())));
    }
    match n - run.n_there() {
        0 => {}
        lost => faults.push(format!("{}: {lost} of {n} frames are not there", run.folder.join("frames").display())),
    }
    faults
}

/// Whether a series has a line below that of its names: that of a run that has just begun has not.
fn has_rows(path: &Path) -> bool {
    let Ok(file) = guard::open(path) else { return path.is_file() };
    BufReader::new(file).lines().take(2).filter(Result::is_ok).count() == 2
}

/// The images of a run that a page can show.
fn images(folder: &Path, notes: &mut Vec<String>, faults: &mut Vec<String>) -> Vec<(u64, PathBuf)> {
    let images = folder.join("images");
    if guard::leads_out(&images, folder) {
        faults.push(format!("{}: a link leads out of the run: its images are not shown", images.display()));
        return vec![];
    }
    let ends_in = |ending: &str| {
        let mut paths = std::fs::read_dir(&images).into_iter().flatten().flatten().map(|entry| entry.path());
        paths.any(|path| path.extension() == Some(OsStr::new(ending)))
    };
    if !ends_in("png") {
        if ends_in("exr") {
            notes.push(format!("{}: the images are EXR, of which none is shown", images.display()));
        }
        return vec![];
    }
    match frame::sequence::find(&images.join("*.png")) {
        Ok(found) => {
            let n = found.len();
            let own: Vec<(u64, PathBuf)> =
                found.into_iter().filter(|(_, path)| !guard::leads_out(path, &images)).collect();
            if own.len() < n {
                faults.push(format!("{}: links lead out of the run: their images are not shown", images.display()));
            }
            own
        }
        Err(fault) => {
            faults.push(fault.to_string());
            vec![]
        }
    }
}

/// The films in a run's folder: that by the folder's name first, then by kind and name. Links that lead out are left out.
fn films(folder: &Path, faults: &mut Vec<String>) -> Vec<PathBuf> {
    let kind = |path: &Path| {
        let ending = path.extension()?.to_str()?.to_lowercase();
        FILMS.iter().position(|film| *film == ending)
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut films: Vec<PathBuf> = entries.filter(|path| path.is_file() && kind(path).is_some()).collect();
    films.retain(|path| {
        let stays = !guard::leads_out(path, folder);
        if !stays {
            faults.push(format!("{}: a link leads out of the run: the film is not shown", path.display()));
        }
        stays
    });
    let own = name_of(folder);
    let is_own = |path: &Path| path.file_stem().is_some_and(|stem| stem.to_string_lossy() == own);
    films.sort_by_cached_key(|path| (!is_own(path), kind(path), path.clone()));
    films
}
