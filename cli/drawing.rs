//! The images of frames that exist, or that a model is simulated for first: while it is, if the metadata says all that the whole run would
//! tell, and else once the run is there.

use crate::arrivals::{Arrivals, Ends};
use crate::batch::MadeOf;
use crate::device::Drawer;
use crate::failed::FailedFrames;
use crate::job::{self, FramesJob, ImageJob, ImageOptions, ModelRun, Origin, Statistics};
use crate::ledger::Ledger;
use crate::model_run::{self, Onward};
use crate::report::{Exit, Failure, Outcome};
use crate::{images, library};
use bind::data::{Source, Store};
use bind::{Binding, emit};
use frame::list;
use frame::run::RunReader;
use render::film::bucket::Shard;
use sim::run::n_frames;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How images are drawn.
pub struct Drawing<'a> {
    /// The folder of the images.
    pub folder: PathBuf,
    /// Choices of the command line.
    pub options: &'a ImageOptions,
    /// The shard to render; whole images if not given.
    pub shard: Option<Shard>,
    /// The statistics wanted.
    pub statistics: Statistics,
}

/// Provide the frames of a job, and draw their images. Returns the images, and the frames that could not be drawn.
pub fn draw(frames: FramesJob, how: Drawing, drawer: &mut Drawer) -> Outcome<(ImageJob, FailedFrames)> {
    let (input, home) = (frames.input.clone(), frames.home.clone());
    let of = (input.as_path(), home.as_path());
    match frames {
        FramesJob { origin: Origin::Model(model), binding: Some(binding), .. } if may_be_drawn_along(&binding) => {
            along((model, binding), of, how, drawer)
        }
        frames => {
            let (binding, source) = model_run::provide(frames)?;
            images((binding, source, None), of, how, drawer)
        }
    }
}

/// Whether images can be drawn before the run is whole; what they wait for is said.
fn may_be_drawn_along(binding: &Binding) -> bool {
    let files = binding.files(library::files(&binding.folder()));
    let open = emit::open_keys(binding, &files);
    if !open.is_empty() {
        eprintln!(
            "note: the images are drawn once the simulation has ended: {} {} on the whole run",
            list::words(&open),
            if open.len() == 1 { "depends" } else { "depend" }
        );
    }
    open.is_empty()
}

/// Draw the images of data whose frames exist or arrive.
fn images(
    (binding, source, arrivals): (Binding, Source, Option<Arc<Arrivals>>),
    of: (&Path, &Path),
    how: Drawing,
    drawer: &mut Drawer,
) -> Outcome<(ImageJob, FailedFrames)> {
    let Drawing { folder, options, shard, statistics } = how;
    let mut job = ImageJob::of_run(binding, (source, arrivals), folder, options)?;
    let frames = (&job.frames[..], job.is_all);
    MadeOf::write(&Ledger::of(&job.folder), of, options.choices.clone(), frames)?;
    let failed = images::render(&mut job, shard, statistics, drawer)?;
    Ok((job, failed))
}

/// Simulate a model, and draw its frames meanwhile. Where the simulation ends early, so does the drawing, and where no more can be drawn, the
/// simulation goes on.
fn along(
    (model, binding): (Box<ModelRun>, Binding),
    of: (&Path, &Path),
    how: Drawing,
    drawer: &mut Drawer,
) -> Outcome<(ImageJob, FailedFrames)> {
    let expected = n_frames(model.span.end(&model.resolved.model), model.resolved.model.frame_rate);
    job::frames(&binding, &(0..expected).collect::<Vec<u64>>(), how.options)?;
    let (home, arrivals) = (of.1, Arc::new(Arrivals::default()));
    std::thread::scope(|scope| {
        let _ends = Ends(&arrivals);
        let drawing = scope.spawn(|| {
            drop(arrivals.wait(0).map_err(|_| images::ended_early(0, 0))?);
            let source = Store::Run(RunReader::open(home)?).into();
            let drawn = images((binding, source, Some(arrivals.clone())), of, how, drawer);
            if let Err(failure) = &drawn
                && arrivals.goes_on()
            {
                eprintln!("error: {failure}\n  = the simulation goes on");
            }
            drawn
        });
        let simulated = model_run::simulate(*model, Onward::Again, Some(&arrivals));
        let n_drawn = arrivals.end(simulated.is_ok());
        if simulated.is_err() && n_drawn > 0 {
            eprintln!("note: the simulation has ended early; images that are being drawn are finished");
        }
        let drawn = drawing.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        match (simulated, drawn) {
            (Ok(()), Ok((mut job, failed))) => {
                job.complete(&RunReader::open(home)?);
                Ok((job, failed))
            }
            (Ok(()), Err(failure)) => Err(failure),
            (Err(failure), Err(drawn)) if drawn.exit == Exit::Interrupted && arrivals.n_written() > 0 => {
                let draws = format!("; `scree render {} -o DIR` draws the frames that are there", word(home));
                let way = if failure.exit == Exit::Interrupted { "" } else { &draws };
                Err(Failure { message: format!("{failure}\n  = {drawn}{way}"), ..failure })
            }
            (Err(failure), _) => Err(failure),
        }
    })
}

/// A path as a word of a command.
fn word(path: &Path) -> String {
    guard::text::shell_word(&path.display().to_string())
}
