//! The frames of a run that is being simulated: how far it has come, for those who draw them meanwhile.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// The frames of a run that is being simulated, as they arrive.
#[derive(Default)]
pub struct Arrivals {
    state: Mutex<State>,
    changed: Condvar,
}

/// How far a run has come.
#[derive(Default)]
struct State {
    /// Number of frames that are there, from frame 0 on.
    written: u64,
    /// Whether there will be no more, and whether the run is whole; none while it goes on.
    is_whole: Option<bool>,
    /// Number of frames that are being drawn.
    drawn: usize,
}

/// A frame that has arrived, and is drawn until this is dropped.
pub struct Arrived<'a>(&'a Arrivals);

impl Drop for Arrived<'_> {
    fn drop(&mut self) {
        self.0.state().drawn -= 1;
    }
}

/// That a simulation has ended before its run was whole.
#[derive(Debug)]
pub struct EndedEarly;

impl Arrivals {
    /// Tell that a number of frames is there.
    pub fn written(&self, n_frames: u64) {
        self.state().written = n_frames;
        self.changed.notify_all();
    }

    /// Number of frames that are there.
    pub fn n_written(&self) -> u64 {
        self.state().written
    }

    /// Tell that the simulation has ended; what was told first holds. Returns the number of frames that are being drawn: where the run is not
    /// whole no more are begun.
    pub fn end(&self, is_whole: bool) -> usize {
        let mut state = self.state();
        state.is_whole.get_or_insert(is_whole);
        self.changed.notify_all();
        state.drawn
    }

    /// Whether the simulation still goes on.
    pub fn goes_on(&self) -> bool {
        self.state().is_whole.is_none()
    }

    /// Wait until a frame is there, or the run is whole. While the simulation takes much of the memory it is waited for: what draws needs its own.
    ///
    /// # Errors
    /// The simulation has ended early: of frames that are there, too.
    pub fn wait(&self, frame: u64) -> Result<Arrived<'_>, EndedEarly> {
        let has_room = || guard::memory::used() < guard::memory::limit() / 4;
        let waits = |state: &mut State| state.is_whole.is_none() && !(frame < state.written && has_room());
        let mut state = self.changed.wait_while(self.state(), waits).unwrap_or_else(PoisonError::into_inner);
        if state.is_whole == Some(false) {
            return Err(EndedEarly);
        }
        state.drawn += 1;
        Ok(Arrived(self))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Ends a simulation early for those who wait, unless it has ended: where its thread panics, too.
pub struct Ends<'a>(pub &'a Arrivals);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.end(false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;
    use std::time::Duration;

    /// Who waits for frames has each as soon as it is there and not before, and all once the run is whole; none where it ends early.
    #[test]
    fn frames_are_waited_for() {
        for is_whole in [true, false] {
            let arrivals = Arrivals::default();
            std::thread::scope(|scope| {
                let _ends = Ends(&arrivals);
                let (tell, told) = channel();
                let all = &arrivals;
                scope.spawn(move || (0..4).for_each(|frame| tell.send((frame, all.wait(frame).is_ok())).unwrap()));
                let next = |within| told.recv_timeout(Duration::from_millis(within)).ok();
                assert_eq!(next(20), None);
                arrivals.written(2);
                assert_eq!([next(5000), next(5000), next(20)], [Some((0, true)), Some((1, true)), None]);
                assert!(arrivals.goes_on());
                arrivals.end(is_whole);
                assert_eq!([next(5000), next(5000)], [Some((2, is_whole)), Some((3, is_whole))]);
                assert!(!arrivals.goes_on());
            });
        }
    }

    /// Frames are drawn from their arrival until they are let go of.
    #[test]
    fn frames_that_are_drawn_are_counted() {
        let arrivals = Arrivals::default();
        arrivals.written(2);
        let [first, second] = [0, 1].map(|frame| arrivals.wait(frame).unwrap());
        drop(first);
        assert_eq!((arrivals.n_written(), arrivals.end(false)), (2, 1));
        drop(second);
        assert!(arrivals.wait(0).is_err() && arrivals.end(false) == 0);
    }

    #[test]
    fn a_simulation_that_panics_leaves_nobody_waiting() {
        let arrivals = Arrivals::default();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let outcome = std::panic::catch_unwind(|| {
                    let _ends = Ends(&arrivals);
                    panic!("it ends")
                });
                assert!(outcome.is_err());
            });
            assert!(arrivals.wait(0).is_err());
        });
    }
}
