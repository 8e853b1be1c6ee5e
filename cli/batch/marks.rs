//! Marks of the tasks of a film, in `plan/tasks/`: which of them run, and which have ended without having done their work, and why.

use super::plan::{Plan, Task};
use crate::ledger::{Claim, Claims};
use crate::report::Outcome;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// How a task is that has begun and has not done its work.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskState {
    /// It runs.
    Running,
    /// It has failed, or was interrupted, and said why.
    Failed(String),
    /// It has ended without a word: it was killed, or its machine was lost.
    Lost,
}

fn folder(home: &Path) -> PathBuf {
    Plan::folder(home).join("tasks")
}

fn claims(home: &Path) -> Claims {
    Claims::open(&folder(home).join(".lock"))
}

/// Run a task under its mark: one that ends well leaves none.
pub fn run(home: &Path, task: Task, work: impl FnOnce() -> Outcome) -> Outcome {
    let (claims, name) = (claims(home), task.name());
    let Some(_claim) = claims.claim(&name) else { return work() };
    let path = folder(home).join(&name);
    // Without a mark the work can still be done.
    let _ = frame::atomic::write(&path, b"");
    let done = work();
    match &done {
        Ok(()) => drop(std::fs::remove_file(&path)),
        Err(failure) => drop(frame::atomic::write(&path, failure.message.as_bytes())),
    }
    done
}

/// Forget tasks whose work is done, whoever did it, unless they run.
pub fn forget(home: &Path, is_done: impl Fn(Task) -> bool) {
    let done =
        |(name, state): &(String, TaskState)| *state != TaskState::Running && Task::parse(name).is_some_and(&is_done);
    for (name, _) in states(home).into_iter().filter(done) {
        let _ = std::fs::remove_file(folder(home).join(name));
    }
}

/// The tasks that have begun and have not done their work.
pub fn states(home: &Path) -> BTreeMap<String, TaskState> {
    let (claims, entries) = (claims(home), std::fs::read_dir(folder(home)).into_iter().flatten().flatten());
    let mut states = BTreeMap::new();
    for entry in entries {
        let name = entry.file_name().to_string_lossy().into_owned();
        let Ok(why) = std::fs::read_to_string(entry.path()) else { continue };
        if Task::parse(&name).is_none() {
            continue;
        }
        let claim: Option<Claim<'_>> = claims.claim(&name);
        let state = match (claim, why.is_empty()) {
            (None, _) => TaskState::Running,
            (Some(_), true) => TaskState::Lost,
            (Some(_), false) => TaskState::Failed(why),
        };
        states.insert(name, state);
    }
    states
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Exit, Failure};

    #[test]
    fn tasks_that_fail_or_are_lost_are_told() {
        let home = tempfile::tempdir().unwrap();
        let home = home.path();
        let during = |state: TaskState| {
            move || {
                assert_eq!(states(home).get("draw-1"), Some(&state));
                Ok(())
            }
        };
        run(home, Task::Draw(1), during(TaskState::Running)).unwrap();
        assert!(states(home).is_empty());
        assert!(run(home, Task::Draw(2), || Err(Failure::new(Exit::Data, "no data"))).is_err());
        std::fs::write(folder(home).join("finish"), "").unwrap();
        let expected =
            [("draw-2".to_string(), TaskState::Failed("no data".into())), ("finish".into(), TaskState::Lost)];
        assert_eq!(states(home), BTreeMap::from(expected));
        forget(home, |task| task == Task::Finish);
        assert_eq!(states(home).into_keys().collect::<Vec<_>>(), ["draw-2"]);
    }
}
