//! How far a run came: finished, running, interrupted, stopped, diverged, or unfinished without a word, and how it stands for that.

use super::number;
use super::view::Tone;
use crate::job::RunData;
use frame::run::EndKind;

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    Finished,
    Running,
    /// It ended before its end, and says how.
    Early(EndKind),
    /// It ended before its end without a word, as one that was killed.
    Unfinished,
}

fn end(run: &RunData) -> End {
    let index = &run.run.index;
    match &index.ended {
        _ if index.complete && index.frames.len() as u64 >= index.expected_frames => End::Finished,
        _ if run.is_running => End::Running,
        Some(ended) => End::Early(ended.by),
        None => End::Unfinished,
    }
}

/// How far a run is, in a word or two, without numbers.
pub fn word(run: &RunData) -> String {
    let mut word = match end(run) {
        End::Finished => "finished",
        End::Running => "running",
        End::Early(EndKind::Diverged) => "diverged",
        End::Early(EndKind::Stopped) => "stopped",
        End::Early(EndKind::Interrupted) => "interrupted",
        End::Unfinished => "unfinished",
    }
    .to_string();
    if !run.run.index.warnings.is_empty() {
        word += " with warnings";
    }
    if !run.faults.is_empty() {
        word += ", parts not readable";
    }
    word
}

/// How far a run is, and how many parts of its data cannot be read.
pub fn state(run: &RunData, n_faults: usize) -> String {
    let index = &run.run.index;
    let n = index.frames.len() as u64;
    let of = format!("{} of {} frames", number::count(n), number::count(index.expected_frames));
    let (step, time) = index.ended.as_ref().map_or((0, 0.0), |ended| (ended.step, ended.time));
    let at = format!("at step {} ({})", number::count(step), number::quantity(time, "s"));
    let mut state = match end(run) {
        End::Finished => format!("finished, {}", number::counted(n, "frame")),
        End::Running => format!("running: {of}"),
        End::Early(EndKind::Diverged) => format!("diverged {at}: {of}"),
        End::Early(EndKind::Stopped) => format!("stopped by a warning {at}: {of}"),
        End::Early(EndKind::Interrupted) => format!("interrupted {at}: {of}"),
        End::Unfinished => format!("unfinished: {of}"),
    };
    if !index.warnings.is_empty() {
        state += &format!(", {}", number::counted(index.warnings.len() as u64, "kind") + " of warnings");
    }
    if n_faults > 0 {
        state += &format!(", {} of the data cannot be read", number::counted(n_faults as u64, "part"));
    }
    state
}

/// How a run stands.
pub fn tone(run: &RunData, n_faults: usize) -> Tone {
    match end(run) {
        End::Early(EndKind::Diverged | EndKind::Stopped) => Tone::Bad,
        _ if n_faults > 0 => Tone::Bad,
        End::Finished if run.run.index.warnings.is_empty() => Tone::Good,
        _ => Tone::Open,
    }
}

/// Why a run ended before its end, in a sentence or two; empty of one that did not.
pub fn cause(run: &RunData) -> String {
    let Some(ended) = run.run.index.ended.as_ref().filter(|_| matches!(end(run), End::Early(_))) else {
        return String::new();
    };
    let at = format!("at step {}, {}", number::count(ended.step), number::quantity(ended.time, "s"));
    let why = &ended.why;
    match ended.by {
        EndKind::Diverged => {
            format!("The simulation diverged {at}: {why}. Frames before that are kept; a shorter step may help.")
        }
        EndKind::Stopped => format!(
            "The simulation stopped {at}, since `on_divergence` of its model is `stop`: {why}. Frames before that are kept."
        ),
        EndKind::Interrupted => format!("The simulation was interrupted {at}: --resume goes on from there."),
    }
}

/// What is said of a run without warnings.
pub fn without_warnings(run: &RunData) -> &'static str {
    match end(run) {
        End::Finished => "None: residual, joints and energy stayed within their bounds in every step.",
        End::Early(EndKind::Diverged) => "None was counted before the simulation diverged, which is said above.",
        _ => "None so far; the run has not come to its end.",
    }
}
