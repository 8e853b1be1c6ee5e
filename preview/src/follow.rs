//! Sending what is there, and following what is added: frames, probes and reports of a run that is being simulated.

use crate::args::Args;
use crate::blueprint;
use crate::bodies::{self, Bodies, SendError};
use crate::curves::Series;
use crate::fault::Failure;
use crate::sink::Sink;
use crate::source::{self, Input};
use bind::data::{Source, Store};
use frame::run::RunReader;
use rerun::RecordingStream;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How often a run is looked at.
const INTERVAL: Duration = Duration::from_millis(250);

/// Send the frames of an input, and those that are added, until the run is complete or the program is interrupted.
pub fn show(args: &Args, input: &mut Input, sink: &Sink) -> Result<(), Failure> {
    let ended = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, ended.clone()).map_err(|e| Failure::machine(e.to_string()))?;
    }
    let is_ended = || ended.load(Ordering::Relaxed);
    wait_for_frames(args, input, &is_ended)?;
    if is_ended() {
        return Ok(());
    }
    source::settle_ranges(input)?;
    let mut shown = Shown::new(args, input);
    shown.begin(input, &sink.stream)?;
    loop {
        shown.frames(args, input, &sink.stream, &is_ended)?;
        shown.curves(&sink.stream)?;
        if is_ended() || !shown.goes_on(args, input) {
            break;
        }
        std::thread::sleep(INTERVAL);
        if let Some(folder) = &input.run {
            shown.look(folder, &mut input.source);
        }
    }
    shown.close(args, input)?;
    if sink.serves() && !is_ended() {
        eprintln!("all is sent; Ctrl-C ends the server");
        while !is_ended() {
            std::thread::sleep(INTERVAL);
        }
    }
    Ok(())
}

/// Wait for the first frame of a run that has just begun.
fn wait_for_frames(args: &Args, input: &mut Input, is_ended: &dyn Fn() -> bool) -> Result<(), Failure> {
    let Some(folder) = &input.run else { return Ok(()) };
    while input.source.numbers().is_empty() && !args.no_follow && !is_ended() {
        std::thread::sleep(INTERVAL);
        if let Ok(run) = RunReader::open(folder) {
            input.source.store = Store::Run(run);
        }
    }
    match input.source.numbers().is_empty() && !is_ended() {
        true => Err(Failure::data(format!("{} has no frames yet", folder.display()))),
        false => Ok(()),
    }
}

/// What has been sent of an input.
struct Shown {
    bodies: Bodies,
    series: Vec<Series>,
    /// The frames that were sent, and what told each from another of its number.
    frames: BTreeMap<u64, String>,
    /// Frames that could not be sent.
    failed: BTreeMap<u64, String>,
    /// Whether the run was missing when it was last looked at.
    is_lost: bool,
    /// Whether frames tell their times.
    has_times: bool,
}

impl Shown {
    fn new(args: &Args, input: &Input) -> Shown {
        Shown {
            bodies: Bodies::new(&input.binding, args.most as usize, args.velocities),
            series: input.run.as_deref().map(Series::of_run).unwrap_or_default(),
            frames: BTreeMap::new(),
            failed: BTreeMap::new(),
            is_lost: false,
            has_times: tells_times(&input.source),
        }
    }

    /// Send what does not change: the layout of the viewer, and which way is up.
    fn begin(&self, input: &Input, stream: &RecordingStream) -> Result<(), Failure> {
        // The times that count are those of the run.
        stream.set_log_time_enabled(false);
        stream.set_log_tick_enabled(false);
        stream.log_static("/", &rerun::ViewCoordinates::RIGHT_HAND_Z_UP())?;
        let first = input.source.numbers().first().and_then(|number| input.source.read(*number).ok());
        let timeline = if self.has_times { "time" } else { "frame" };
        blueprint::send(&input.binding, first.as_ref(), &self.series, timeline, stream)
    }

    /// Send the frames that were not sent yet, or have been replaced.
    fn frames(
        &mut self,
        args: &Args,
        input: &Input,
        stream: &RecordingStream,
        is_ended: &dyn Fn() -> bool,
    ) -> Result<(), Failure> {
        let all = input.source.numbers();
        let chosen = match &args.frames {
            // Of frames that are still to come, none is missing.
            Some(list) => list.select(&all).or_else(|m| if self.goes_on(args, input) { Ok(vec![]) } else { Err(m) }),
            None => Ok(all),
        };
        let chosen = chosen.map_err(|message| Failure::usage(format!("--frames: {message}")))?;
        let started = Instant::now();
        let mut n = 0;
        for number in chosen {
            let stamp = input.source.stamp(number);
            if self.frames.get(&number) == Some(&stamp) {
                continue;
            }
            if is_ended() {
                break;
            }
            match self.frame(args, number, &input.source, stream) {
                Ok(()) => drop(self.failed.remove(&number)),
                Err(SendError::Frame(fault)) => {
                    if self.failed.insert(number, stamp.clone()).as_ref() != Some(&stamp) {
                        eprintln!("warning: frame {number} is left out: {fault}");
                    }
                }
                Err(SendError::Stream(e)) => return Err(e.into()),
            }
            self.frames.insert(number, stamp);
            n += 1;
        }
        if n > 1 {
            let seconds = started.elapsed().as_secs_f64();
            eprintln!("{n} frames in {seconds:.1} s, {:.0} a second", n as f64 / seconds.max(1e-9));
        }
        Ok(())
    }

    fn frame(&mut self, args: &Args, number: u64, source: &Source, stream: &RecordingStream) -> Result<(), SendError> {
        let table = source.read(number)?;
        stream.set_time_sequence("frame", number as i64);
        if self.has_times {
            stream.set_duration_secs("time", table.time);
        }
        self.bodies.send(&table, stream)?;
        if let (Some(length), Store::Run(run)) = (args.contacts, &source.store) {
            let path = run.folder.join(format!("contacts/{number:06}.csv"));
            if path.is_file() {
                let contacts = frame::csv::read(&path, number, &frame::csv::Layout::default())?;
                bodies::contacts(&contacts, length, args.most as usize, stream)?;
            }
        }
        stream.reset_time();
        Ok(())
    }

    fn curves(&mut self, stream: &RecordingStream) -> Result<(), Failure> {
        self.series.iter_mut().try_for_each(|series| series.send(stream)).map_err(Failure::from)
    }

    /// Whether more frames are to be expected.
    fn goes_on(&self, args: &Args, input: &Input) -> bool {
        let is_complete = match &input.source.store {
            Store::Run(run) => run.index.complete,
            Store::Files { .. } => true,
        };
        !args.no_follow && !is_complete
    }

    /// Look at a run again: it may have more frames, be gone on with from before its end, be another, or be gone.
    fn look(&mut self, folder: &Path, source: &mut Source) {
        let run = match RunReader::open(folder) {
            Ok(run) => run,
            Err(_) => {
                if !std::mem::replace(&mut self.is_lost, true) {
                    eprintln!("warning: {} is gone or cannot be read; waiting for it", folder.display());
                }
                return;
            }
        };
        self.is_lost = false;
        if let Store::Run(before) = &source.store
            && before.index.model_hash != run.index.model_hash
        {
            eprintln!("warning: {} is the run of another model now: its frames replace those shown", folder.display());
            self.frames.clear();
        }
        // Frames that the run no longer has are sent again when they come back.
        let there = run.numbers();
        if self.frames.keys().any(|number| !there.contains(number)) {
            eprintln!("note: {} goes on from frame {}", folder.display(), there.last().copied().unwrap_or(0));
            self.frames.retain(|number, _| there.contains(number));
        }
        source.store = Store::Run(run);
        if self.series.is_empty() {
            self.series = Series::of_run(folder);
        }
    }

    /// The end: what could not be shown.
    fn close(&self, args: &Args, input: &Input) -> Result<(), Failure> {
        if !self.failed.is_empty() {
            let message = format!("{} of {} frames could not be shown", self.failed.len(), self.frames.len());
            return Err(Failure::partial(message));
        }
        if self.goes_on(args, input) {
            eprintln!("note: the run was not complete when the preview ended");
        }
        Ok(())
    }
}

/// Whether the frames of a source tell their times: those of a run do, and tables of which not all are at 0 s.
fn tells_times(source: &Source) -> bool {
    /// Tables that are looked at.
    const SOME: usize = 3;
    let is_later = |number: &u64| source.read(*number).is_ok_and(|table| table.time != 0.0);
    matches!(source.store, Store::Run(_)) || source.numbers().iter().take(SOME).any(is_later)
}
