//! The threads that draw the frames of a film. What a device draws leaves the processor time, so that several frames are in flight there: one is
//! made ready while another is drawn and a third is written. What the processor draws takes all of it, and goes frame by frame. Beside a
//! simulation these are threads of their own, so that none of its work waits behind theirs.

use crate::device::Drawer;
use crate::report::{Exit, Failure, Outcome};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// The most frames in flight.
const MOST: usize = 4;
/// Threads of the processor for each.
const THREADS: usize = 4;

/// Threads that draw frames: none of their own where frames are drawn one by one.
pub struct Workers {
    /// The threads that each has for parallel work: whatever is read there is noted as its own (`guard::Trace`).
    pools: Vec<ThreadPool>,
}

/// How many frames are begun, and how many of these have ended.
#[derive(Default)]
struct Turns {
    begun: usize,
    ended: usize,
    /// Whether nothing more is to be begun or ended.
    is_over: bool,
}

/// What the threads share.
struct Shared<E> {
    turns: Mutex<Turns>,
    moved: Condvar,
    /// Ends frames, and what has come of the last.
    end: Mutex<(E, Outcome)>,
}

impl Workers {
    /// Those for a number of frames, which may be drawn beside a simulation.
    pub fn new(drawer: &Drawer, n_frames: usize, beside_simulation: bool) -> Outcome<Workers> {
        let n_threads = rayon::current_num_threads();
        let n = if drawer.may_be_device() { (n_threads / THREADS).clamp(2, MOST).min(n_frames) } else { 1 };
        Workers::of(if n > 1 || beside_simulation { n } else { 0 }, n_threads)
    }

    fn of(n: usize, n_threads: usize) -> Outcome<Workers> {
        let pool = |_| {
            let trace = guard::Trace::default();
            let follow = move |_| trace.follow();
            let pool = ThreadPoolBuilder::new().num_threads(n_threads).start_handler(follow).build();
            pool.map_err(|e| Failure::new(Exit::Fault, format!("cannot start {n_threads} threads: {e}")))
        };
        Ok(Workers { pools: (0..n).map(pool).collect::<Outcome<_>>()? })
    }

    /// Begin and end frames: `begin` of several at a time, `end` of one at a time in their order, both of a frame with one trace of files.
    /// The first is alone until it has ended, since what is compiled for it serves the others, and so is each that may not go `beside` others.
    ///
    /// # Errors
    /// The first of `end`, after which no frame is ended.
    pub fn run<B: Send>(
        &self,
        frames: &[u64],
        beside: impl Fn() -> bool + Sync,
        begin: impl Fn(u64) -> B + Sync,
        mut end: impl FnMut(u64, B) -> Outcome + Send,
    ) -> Outcome {
        if self.pools.is_empty() {
            return frames.iter().try_for_each(|frame| end(*frame, begin(*frame)));
        }
        let shared = Shared { turns: Mutex::default(), moved: Condvar::new(), end: Mutex::new((end, Ok(()))) };
        std::thread::scope(|scope| {
            for pool in &self.pools {
                scope.spawn(|| shared.work(pool, frames, &beside, &begin));
            }
        });
        shared.end.into_inner().unwrap_or_else(PoisonError::into_inner).1
    }
}

impl<E> Shared<E> {
    fn work<B: Send>(
        &self,
        pool: &ThreadPool,
        frames: &[u64],
        beside: &(impl Fn() -> bool + Sync),
        begin: &(impl Fn(u64) -> B + Sync),
    ) where
        E: FnMut(u64, B) -> Outcome + Send,
    {
        // Where a thread panics, the others do not wait for its turn.
        let _over = Over(self);
        while let Some((turn, frame)) = self.next(frames, beside) {
            let begun = pool.install(|| begin(frame));
            if self.wait(|turns| turns.ended == turn).is_over {
                return;
            }
            let mut own = self.end.lock().unwrap_or_else(PoisonError::into_inner);
            let (end, outcome) = &mut *own;
            *outcome = pool.install(|| end(frame, begun));
            let mut turns = self.turns();
            turns.ended += 1;
            turns.is_over |= outcome.is_err();
            self.moved.notify_all();
        }
    }

    /// The next frame, with its turn, as soon as it may begin; none once all are begun.
    fn next(&self, frames: &[u64], beside: &impl Fn() -> bool) -> Option<(usize, u64)> {
        let mut turns = self.wait(|turns| {
            let is_alone = turns.begun == turns.ended;
            turns.begun == frames.len() || is_alone || turns.ended > 0 && beside()
        });
        let frame = frames.get(turns.begun).filter(|_| !turns.is_over)?;
        turns.begun += 1;
        Some((turns.begun - 1, *frame))
    }

    /// Wait until something is so, or all is over.
    fn wait(&self, is_so: impl Fn(&Turns) -> bool) -> MutexGuard<'_, Turns> {
        let waits = |turns: &mut Turns| !turns.is_over && !is_so(turns);
        self.moved.wait_while(self.turns(), waits).unwrap_or_else(PoisonError::into_inner)
    }

    fn turns(&self) -> MutexGuard<'_, Turns> {
        self.turns.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Ends all where its thread panics.
struct Over<'a, E>(&'a Shared<E>);

impl<E> Drop for Over<'_, E> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.turns().is_over = true;
            self.0.moved.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use std::sync::Barrier;
    use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

    /// What is begun beside others is ended in order, with the files that it has read and no others.
    #[test]
    fn frames_in_flight_end_in_their_order_with_their_own_files() {
        let workers = Workers::of(3, 2).unwrap();
        let frames: Vec<u64> = (0..10).collect();
        // Those after the first go three at a time.
        let three = Barrier::new(3);
        let mut ended = vec![];
        let begin = |frame: u64| {
            guard::trace();
            let read = |part: &str| guard::look_for(&Path::new(part).join(frame.to_string()));
            rayon::join(|| read("a"), || read("b"));
            if frame > 0 {
                three.wait();
            }
            read("c");
            frame
        };
        let end = |frame: u64, begun: u64| {
            let files: Vec<String> = guard::trace().iter().map(|file| file.display().to_string()).collect();
            assert_eq!(files, ["a", "b", "c"].map(|part| format!("{part}/{frame}")));
            ended.push([frame, begun]);
            Ok(())
        };
        assert!(workers.run(&frames, || true, begin, end).is_ok());
        assert_eq!(ended, frames.iter().map(|frame| [*frame; 2]).collect::<Vec<_>>());
    }

    /// Frames that may not go beside others are begun when those before have ended.
    #[test]
    fn frames_that_may_not_go_beside_others_go_alone() {
        let workers = Workers::of(3, 1).unwrap();
        let frames: Vec<u64> = (0..10).collect();
        let ended = AtomicU64::new(0);
        let begin = |frame: u64| assert_eq!(ended.load(Relaxed), frame);
        let end = |_: u64, _: ()| {
            ended.fetch_add(1, Relaxed);
            Ok(())
        };
        assert!(workers.run(&frames, || false, begin, end).is_ok());
        assert_eq!(ended.load(Relaxed), 10);
    }

    /// A failure ends the run: frames after it are not ended.
    #[test]
    fn no_frame_ends_after_one_that_fails() {
        for n in [0, 1, 3] {
            let workers = Workers::of(n, 1).unwrap_or_else(|e| panic!("{}", e.message));
            let mut ended = vec![];
            let end = |frame: u64, _: ()| {
                ended.push(frame);
                if frame == 4 { Err(Failure::new(Exit::Data, "four")) } else { Ok(()) }
            };
            let frames: Vec<u64> = (0..10).collect();
            let message = workers.run(&frames, || true, |_| (), end).err().map(|failure| failure.message);
            assert_eq!((message.as_deref(), &ended[..]), (Some("four"), &[0, 1, 2, 3, 4][..]));
        }
    }
}
