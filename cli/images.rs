//! The images of a job: those that are not there as they would be drawn again, by the ledger of their folder.

mod workers;

use crate::arrivals::{Arrived, EndedEarly};
use crate::batch::movie_images;
use crate::device::Drawer;
use crate::displays::{context, report_statistics, write, written};
use crate::failed::{FailedFrames, MissingValues};
use crate::images::workers::Workers;
use crate::interrupt;
use crate::job::{ImageJob, Statistics};
use crate::ledger::{Claim, Hashes, Ledger, Standing};
use crate::overlay::{Overlay, Prepared};
use crate::progress::Progress;
use crate::ranges;
use crate::report::{Exit, Failure, Outcome, Printed};
use bind::data::{Source, Store};
use bind::emit::Missing;
use bind::{Moment, emit};
use frame::run::RunReader;
use frame::{Fault, FaultKind, Frame, list};
use render::film::bucket::Shard;
use render::ri::imprint::Imprint;
use render::{Context, DrawnBy};
use std::collections::{BTreeMap, HashSet};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Render the images of a job, or a shard of each, but for those that are up to date, each as soon as its frame is there; the frames whose
/// data cannot be drawn are returned.
pub fn render(
    job: &mut ImageJob,
    shard: Option<Shard>,
    statistics: Statistics,
    drawer: &mut Drawer,
) -> Outcome<FailedFrames> {
    let mut failed = FailedFrames::new("rendered");
    say_gaps(job);
    ranges::settle(job)?;
    render_pass(job, (shard, statistics), drawer, &mut failed, &mut Printed::default())?;
    Ok(failed)
}

/// Put the images of a job, and those of its passes, into a folder of their own.
pub fn redirect(job: &mut ImageJob, folder: &Path) {
    for pass in &mut job.passes {
        let name = pass.folder.file_name().map(|name| folder.join(name)).unwrap_or_default();
        redirect(pass, &name);
    }
    job.folder = folder.into();
}

/// How the images of a job stand, and where images are cut to `n_shards`, each shard of them; of a frame with passes, the worst of them.
pub fn standings(job: &mut ImageJob, n_shards: usize) -> Outcome<Vec<(u64, Vec<Standing>)>> {
    ranges::settle(job)?;
    standings_of(job, n_shards)
}

fn standings_of(job: &ImageJob, n_shards: usize) -> Outcome<Vec<(u64, Vec<Standing>)>> {
    let progress = Progress::start("checking", job.frames.len() as u64, "images");
    let mut work = Work::new(job, None, Statistics::default())?;
    let mut found = vec![];
    for (done, frame) in job.frames.iter().enumerate() {
        let imprint = job.source.shared(*frame).map_err(Failure::from).and_then(|table| {
            let about = work.about(&table);
            work.imprint(&Moment::of(&job.binding, &job.source, &table)?, &about)
        });
        let whole = work.file(*frame);
        let mut of_frame = vec![];
        for part in 1..=n_shards {
            work.shard = (n_shards > 1).then_some(Shard { part, parts: n_shards });
            of_frame.push(match &imprint {
                Ok(imprint) => work.standing(&work.file(*frame), &whole, imprint),
                Err(_) if !job.folder.join(&whole).is_file() => Standing::Missing,
                Err(failure) => Standing::Undrawable(failure.message.clone()),
            });
        }
        work.shard = None;
        found.push((*frame, of_frame));
        progress.at(done as u64 + 1);
    }
    progress.finish();
    for pass in &job.passes {
        for ((_, all), (_, own)) in found.iter_mut().zip(standings_of(pass, n_shards)?) {
            for (all, own) in all.iter_mut().zip(own) {
                if *all == Standing::Done {
                    *all = own;
                }
            }
        }
    }
    Ok(found)
}

/// What was found and done of the images of a pass.
#[derive(Default)]
struct Tally {
    /// Images that were up to date.
    kept: usize,
    /// Why others were drawn again, and how many.
    again: BTreeMap<String, usize>,
    /// Why the processor has drawn images in a device's stead, and how many.
    fallen_back: BTreeMap<String, usize>,
}

fn render_pass(
    job: &ImageJob,
    (shard, statistics): (Option<Shard>, Statistics),
    drawer: &mut Drawer,
    failed: &mut FailedFrames,
    printed: &mut Printed,
) -> Outcome {
    let mut frames: Vec<u64> = job.frames.iter().filter(|f| !failed.contains(**f)).copied().collect();
    let (ledger, n) = (Ledger::of(&job.folder), frames.len());
    frame::atomic::sweep(&job.folder);
    frame::atomic::sweep(&ledger.folder());
    let claims = ledger.claims();
    let progress = Progress::start("rendering", n as u64, "frames");
    let work = Work::new(job, shard, statistics)?;
    let workers = Workers::new(drawer, n, job.arrivals.is_some())?;
    let drawer = Mutex::new(drawer);
    let mut pass = Pass {
        tally: Tally::default(),
        values: MissingValues::default(),
        made: vec![],
        failed: &mut *failed,
        printed: &mut *printed,
    };
    let (mut proven, mut done) = (false, 0);
    // Images that another process is drawing are looked at again when it is done with them.
    while !frames.is_empty() {
        let mut busy = vec![];
        let begin = |frame: u64| {
            let (source, arrived) = work.source_with(frame)?;
            let file = work.file(frame);
            let Some(claim) = claims.claim(&file) else { return Ok(None) };
            Ok(Some(Begun { _held: (claim, arrived), drawn: work.drawn(frame, &file, &source, &drawer), file }))
        };
        let end = |frame: u64, begun: Result<Option<Begun<'_>>, EndedEarly>| {
            let Some(Begun { _held, drawn, file }) = begun.map_err(|_| ended_early(done, n))? else {
                busy.push(frame);
                return Ok(());
            };
            match drawn.and_then(|drawn| work.finish(frame, &file, drawn, &mut pass)) {
                Ok(()) => proven = true,
                Err(failure) => {
                    work.ledger.note_failure(&file, &failure.message)?;
                    pass.failed.note(frame, failure, proven, job.frames.len())?;
                }
            }
            done += 1;
            interrupt::remark(format!("{done} of {n} images are done; the same command goes on"));
            progress.at(done);
            Ok(())
        };
        interrupt::remark(format!("{} of {n} images are done; the same command goes on", n - frames.len()));
        // What the processor draws takes all of it.
        let beside = || locked(&drawer).is_open() && guard::memory::room() > guard::memory::used();
        workers.run(&frames, beside, begin, end)?;
        if busy.len() == frames.len() {
            std::thread::sleep(Duration::from_millis(100));
        }
        frames = busy;
    }
    interrupt::remark(String::new());
    progress.finish();
    pass.tally.say(n);
    pass.values.warn(pass.printed);
    work.check_others(&pass.made)?;
    let drawer = drawer.into_inner().unwrap_or_else(PoisonError::into_inner);
    job.passes.iter().try_for_each(|pass| render_pass(pass, (shard, statistics), drawer, failed, printed))
}

/// Why no more images are drawn of a simulation that has ended before its run was whole.
pub fn ended_early(done: u64, n: usize) -> Failure {
    let message =
        if done == 0 { "no image is drawn".into() } else { format!("{done} of {n} images are done, and stay") };
    Failure::new(Exit::Interrupted, message)
}

/// What has come of the images of a pass so far, in the order of their frames.
struct Pass<'a> {
    tally: Tally,
    values: MissingValues,
    /// The images that are done, and the hash of what each was made of.
    made: Vec<(String, String)>,
    failed: &'a mut FailedFrames,
    printed: &'a mut Printed,
}

impl Tally {
    /// Say which of `n` images were kept, and why others were not.
    fn say(&self, n: usize) {
        if self.kept > 0 {
            eprintln!("{} of {n} images were up to date; --redraw draws them again", self.kept);
        }
        for (why, count) in &self.again {
            eprintln!("{count} of {n} images were drawn again: {why}");
        }
        for (why, count) in &self.fallen_back {
            eprintln!("the processor has drawn {count} of {n} images: {why}");
        }
    }
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The images of a pass as they are drawn, by several threads.
struct Work<'a> {
    job: &'a ImageJob,
    /// The data, with the frames that have arrived.
    source: Mutex<Arc<Source>>,
    shard: Option<Shard>,
    statistics: Statistics,
    ledger: Ledger,
    hashes: Mutex<Hashes>,
    overlays: Prepared,
}

/// An image that this process has a claim on, its frame, where that has just arrived, and its file.
struct Begun<'a> {
    _held: (Claim<'a>, Option<Arrived<'a>>),
    drawn: Outcome<Drawn>,
    file: String,
}

/// An image before it is written.
struct Drawn {
    standing: Standing,
    imprint: String,
    /// None if it is up to date.
    rendered: Option<Rendered>,
    started: Instant,
}

/// A frame that is rendered: its table, the renderer with its image, and what the rows of the table lack.
struct Rendered {
    table: Arc<Frame>,
    context: Context,
    missing: Missing,
}

impl<'a> Work<'a> {
    /// No image yet.
    fn new(job: &'a ImageJob, shard: Option<Shard>, statistics: Statistics) -> Outcome<Work<'a>> {
        let ledger = Ledger::made_from(&job.folder, &job.binding.folder());
        let overlays = Prepared::find(&job.binding, &job.source)?;
        let source = Mutex::new(Arc::new(job.source.clone()));
        Ok(Work { job, source, shard, statistics, ledger, hashes: Mutex::default(), overlays })
    }

    /// The data, once it has a frame. A run that cannot be read has those that it had.
    ///
    /// # Errors
    /// The simulation has ended before.
    fn source_with(&self, frame: u64) -> Result<(Arc<Source>, Option<Arrived<'a>>), EndedEarly> {
        let Some(arrivals) = &self.job.arrivals else { return Ok((locked(&self.source).clone(), None)) };
        let arrived = arrivals.wait(frame)?;
        let mut source = locked(&self.source);
        if let Store::Run(run) = &source.store
            && !run.has(frame)
            && let Ok(run) = RunReader::open(&run.folder)
        {
            *source = Arc::new(source.grown(run));
        }
        Ok((source.clone(), Some(arrived)))
    }

    fn hashes(&self) -> MutexGuard<'_, Hashes> {
        locked(&self.hashes)
    }

    /// Name of the file that is written of a frame.
    fn file(&self, frame: u64) -> String {
        let path = written(&self.job.image(frame), self.shard);
        path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Render a frame, unless its image is up to date. The files that this reads, and those that [`Work::finish`] does, are in the trace of
    /// the thread.
    fn drawn(&self, frame: u64, file: &str, source: &Source, drawer: &Mutex<&mut Drawer>) -> Outcome<Drawn> {
        let started = Instant::now();
        let table = source.shared(frame)?;
        // The metadata fits the data's first frame: a column that this one lacks is missing in the data.
        self.job.binding.check_columns(&table).map_err(|fault| Fault { kind: FaultKind::Data, ..fault })?;
        let about = self.about(&table);
        let moment = Moment::of(&self.job.binding, source, &table)?;
        let imprint = self.imprint(&moment, &about)?;
        let whole = self.job.image(frame).file_name().unwrap_or_default().to_string_lossy().into_owned();
        let standing = if self.job.redraw { Standing::Changed } else { self.standing(file, &whole, &imprint) };
        let lacks_statistics = || self.statistics.write && !self.job.folder.join(format!("{file}.stats.json")).exists();
        if standing == Standing::Done && !lacks_statistics() {
            return Ok(Drawn { standing, imprint, rendered: None, started });
        }
        guard::trace();
        let (context, missing) = self.draw(&moment, about, drawer)?;
        let rendered = Rendered { table: table.clone(), context, missing };
        Ok(Drawn { standing, imprint, rendered: Some(rendered), started })
    }

    /// Write the image of a frame and record it.
    fn finish(&self, frame: u64, file: &str, drawn: Drawn, pass: &mut Pass<'_>) -> Outcome {
        let Drawn { standing, imprint, rendered, started } = drawn;
        let Some(Rendered { table, context, missing }) = rendered else {
            pass.tally.kept += 1;
            self.ledger.forget_failure(file);
            pass.made.push((file.into(), imprint));
            return Ok(());
        };
        match &standing {
            Standing::Missing | Standing::Done => {}
            _ if self.job.redraw => {}
            why => *pass.tally.again.entry(why.to_string()).or_default() += 1,
        }
        pass.values.add(table.number, &missing);
        let no_world = || Failure::new(Exit::Input, "the scene has no WorldBegin and WorldEnd: there is no image");
        let overlay = self.overlay(&table)?;
        let result = write(context, &self.job.folder, Some(&overlay), pass.printed)?.pop().ok_or_else(no_world)?;
        if let DrawnBy::Fallback(why) = &result.drawn_by {
            *pass.tally.fallen_back.entry(why.clone()).or_default() += 1;
        }
        let read = guard::trace();
        report_statistics(&result, frame, &written(&self.job.image(frame), self.shard), self.statistics)?;
        let seconds = started.elapsed().as_secs_f64();
        self.ledger.record(file, &imprint, read, seconds, &mut self.hashes())?;
        pass.made.push((file.into(), imprint));
        Ok(())
    }

    /// Fail if another command has drawn images again since they were done, from other data or with other settings.
    fn check_others(&self, made: &[(String, String)]) -> Outcome {
        let is_other = |(file, imprint): &&(String, String)| {
            self.ledger.entry(file).is_some_and(|entry| entry.imprint != *imprint)
        };
        let mut others = made.iter().filter(is_other);
        let Some((first, _)) = others.next() else { return Ok(()) };
        let message = format!(
            "another command has drawn {} of the {} images in {} again, from other data or with other settings (the first: {first}); \
             give each a folder of its own with -o, and draw these again",
            1 + others.count(),
            made.len(),
            self.job.folder.display()
        );
        Err(Failure::new(Exit::Partial, message))
    }

    /// How the file of an image or of a shard stands: a shard of a `whole` image that is up to date is not needed.
    fn standing(&self, file: &str, whole: &str, imprint: &str) -> Standing {
        let own = self.ledger.standing(file, Some(imprint), &mut self.hashes());
        let is_needed = own != Standing::Done && file != whole;
        if is_needed && self.ledger.standing(whole, Some(imprint), &mut self.hashes()) == Standing::Done {
            return Standing::Done;
        }
        own
    }

    /// What is written into the file of an image beside its pixels.
    fn about(&self, table: &Frame) -> Vec<(String, String)> {
        let mut about = vec![("frame".into(), table.number.to_string()), ("time".into(), table.time.to_string())];
        about.extend(self.job.source.run_hash().map(|hash| ("run".into(), hash.into())));
        about
    }

    /// A hash of all that is drawn: the program, and every call to the renderer, which has data, metadata and scene in it.
    fn imprint(&self, moment: &Moment, about: &[(String, String)]) -> Outcome<String> {
        let mut hasher = blake3::Hasher::new();
        hasher.update(env!("CARGO_PKG_VERSION").as_bytes()).update(self.job.library.as_bytes());
        hasher.update(format!("{about:?}").as_bytes());
        hasher.update(self.overlay(moment.frame)?.imprint().as_bytes());
        let mut ri = Imprint::new(hasher);
        emit::frame(&self.job.binding, moment, "image", &self.job.files, &mut ri)?;
        Ok(ri.into_inner().finalize().to_hex().to_string())
    }

    /// What is written over the image of a frame.
    fn overlay(&self, table: &Frame) -> Outcome<Overlay<'a>> {
        Ok(Overlay::of(&self.job.binding, &self.overlays, table)?)
    }

    /// Render a frame; the renderer then has its image.
    fn draw(
        &self,
        moment: &Moment,
        about: Vec<(String, String)>,
        drawer: &Mutex<&mut Drawer>,
    ) -> Outcome<(Context, Missing)> {
        let (job, table) = (self.job, moment.frame);
        let mut context = context(&job.files)?;
        (context.shard, context.about) = (self.shard, about);
        context.device = locked(drawer).device()?;
        let image = job.image(table.number).to_string_lossy().to_string();
        context.image = Some(image.clone());
        context.allow_outside = job.allow_outside;
        let missing = emit::frame(&job.binding, moment, &image, &job.files, &mut context)?;
        Ok((context, missing))
    }
}

/// What a movie of a job is made of: a hash of its images, by what their ledger has of them, and their rate.
pub fn hash(job: &ImageJob) -> String {
    let names: Vec<String> =
        job.images().into_iter().map(|p| p.file_name().unwrap_or_default().to_string_lossy().into_owned()).collect();
    let images = movie_images(&Ledger::of(&job.folder), names.iter().map(String::as_str));
    format!("{images} at {}", job.binding.frame_rate)
}

/// Fail if the data of a film has lost frames; the others are rendered.
pub fn check_lost(job: &ImageJob) -> Outcome {
    if job.lacking.is_empty() {
        return Ok(());
    }
    let message = format!(
        "the data has lost {} of the film's frames: {}; bring them back, or submit the film again without them",
        job.lacking.len(),
        list::describe(&job.lacking)
    );
    Err(Failure::new(Exit::Data, message))
}

/// Say which frames are missing between those of the data, and which images are of frames that it does not have.
fn say_gaps(job: &ImageJob) {
    let numbers = if job.arrivals.is_some() { job.source.expected() } else { job.source.numbers() };
    if let Some(gaps) = list::describe_gaps(&numbers) {
        eprintln!("warning: {gaps}: a movie jumps over them");
    }
    let ending = |file: &String| Path::new(file).extension().map(|e| e.to_os_string());
    let number = |file: &String| Path::new(file).file_stem()?.to_str()?.parse::<u64>().ok();
    let files = Ledger::of(&job.folder).files();
    let of_frames = files.iter().filter(|file| ending(file) == job.image(0).extension().map(|e| e.to_os_string()));
    let known: HashSet<u64> = numbers.iter().chain(&job.lacking).copied().collect();
    let is_gone = |file: &&String| number(file).is_some_and(|n| !known.contains(&n));
    let gone: Vec<&String> = of_frames.filter(is_gone).filter(|file| job.folder.join(file).is_file()).collect();
    if let Some(first) = gone.first() {
        eprintln!(
            "warning: {} in {} of frames that the data does not have (the first: {first}): what is there stays",
            if gone.len() == 1 { "1 image is".to_string() } else { format!("{} images are", gone.len()) },
            job.folder.display()
        );
    }
}

/// Fail if frames are missing, as they are of an interrupted run; the others are rendered.
pub fn check_missing(job: &ImageJob) -> Outcome {
    let missing = &job.lacking;
    match (missing.first(), missing.last()) {
        (Some(first), Some(last)) => Err(Failure::new(
            Exit::Partial,
            format!(
                "the simulation was interrupted: {} of {} frames are missing ({first} to {last}); the others were rendered",
                missing.len(),
                missing.len() + job.frames.len()
            ),
        )),
        _ => Ok(()),
    }
}
