//! Threads that go through many short phases side by side, as through the colours of a sweep. They are those of the thread pool; between
//! phases, which may be shorter than it takes to wake a thread, they stay awake. Which thread does a task never matters to the result.

use std::cell::{Cell, UnsafeCell};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// The tasks of a phase.
type Task = dyn Fn(usize) + Sync;

/// How long a thread waits before it lets others have its processor between two looks.
const POLITE: Duration = Duration::from_micros(10);
/// How long a thread without work stays.
const STAY: Duration = Duration::from_micros(500);
/// How long the lead waits, and over the time of how many tasks, before other programs are taken to have the processors.
const CROWDED: (Duration, u32) = (Duration::from_micros(100), 4);

/// Whether other programs leave a team its processors: where they do not, a thread that waits for one that has none loses more than the
/// team gains.
#[derive(Default)]
pub struct Pace {
    /// Teams that the next ones are without.
    pause: u32,
    /// Those that the next such pause will have.
    next: u32,
}

impl Pace {
    const LONGEST: u32 = 64;

    fn is_paused(&mut self) -> bool {
        let is_paused = self.pause > 0;
        self.pause = self.pause.saturating_sub(1);
        is_paused
    }

    fn end(&mut self, was_crowded: bool) {
        match was_crowded {
            true => {
                self.next = (2 * self.next).clamp(1, Self::LONGEST);
                self.pause = self.next;
            }
            false => self.next -= self.next.div_ceil(16),
        }
    }
}

/// What one thread of a team has, in cache lines of its own.
struct Seat {
    share: Share,
    done: Done,
}

/// The tasks that are left of a thread's share of a phase.
#[repr(align(128))]
struct Share {
    /// The phase in the high half, the next task in the low.
    next: AtomicU64,
    /// The end of the share.
    end: AtomicU64,
    /// What the tasks of the phase are.
    task: UnsafeCell<Option<*const Task>>,
}

/// The phase that a thread has worked in last, in the high half, and the number of its tasks that it ran, in the low.
#[repr(align(128))]
struct Done(AtomicU64);

/// A team, as its lead sees it.
pub struct Team {
    /// The seats, the first of which is the lead's.
    seats: Vec<Seat>,
    has_ended: AtomicBool,
    /// The phase that went on last.
    phase: Cell<u64>,
    /// Whether other programs have the processors, so that the lead works alone.
    is_crowded: Cell<bool>,
}

/// The part of a team that its threads share.
struct Shared<'a>(&'a Team);
// SAFETY: of what is not atomic, the cells of the team are the lead's alone, and `task` is written by the lead while no task of a phase is
// left, and read by threads that have claimed one.
unsafe impl Sync for Shared<'_> {}
// SAFETY: as above.
unsafe impl Send for Shared<'_> {}

/// Number of processors that this process may use.
fn n_processors() -> usize {
    static N: OnceLock<usize> = OnceLock::new();
    *N.get_or_init(|| std::thread::available_parallelism().map_or(1, |n| n.get()))
}

/// Run `lead` with the threads of the pool at its side, of which there are no more than processors, or alone where its work `is_small`.
pub fn gather<R>(pace: &mut Pace, is_small: bool, lead: impl FnOnce(&Team) -> R) -> R {
    let n_threads = rayon::current_num_threads();
    let n = if is_small || pace.is_paused() { 1 } else { n_threads.min(n_processors()) };
    let seat = |_| Seat {
        share: Share { next: AtomicU64::new(0), end: AtomicU64::new(0), task: UnsafeCell::new(None) },
        done: Done(AtomicU64::new(0)),
    };
    let team = Team {
        seats: (0..n).map(seat).collect(),
        has_ended: AtomicBool::new(false),
        phase: Cell::new(0),
        is_crowded: Cell::new(false),
    };
    if n == 1 {
        return lead(&team);
    }
    let shared = Shared(&team);
    let result = rayon::in_place_scope(|scope| {
        let own = rayon::current_thread_index().unwrap_or(0);
        let shared = &shared;
        scope.spawn_broadcast(move |_, at| {
            // The lead's own part comes to it while it waits for others, or at the end.
            let seat = (at.index() + n_threads - own) % n_threads;
            if seat > 0 && seat < n {
                shared.0.help(seat);
            }
        });
        let _end = End(&team.has_ended);
        lead(&team)
    });
    pace.end(team.is_crowded.get());
    result
}

/// Ends a team, even where its lead panics.
struct End<'a>(&'a AtomicBool);

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Tasks of a phase that a thread has claimed, which have ended when this goes.
struct Claimed<'a> {
    done: &'a AtomicU64,
    phase: u64,
    n: u64,
}

impl Drop for Claimed<'_> {
    fn drop(&mut self) {
        if self.n > 0 {
            self.done.store(self.phase << 32 | self.n, Ordering::Release);
        }
    }
}

impl Team {
    /// Number of threads that take part.
    pub fn n_threads(&self) -> usize {
        if self.is_crowded.get() { 1 } else { self.seats.len() }
    }

    /// Run the tasks `0..n` of a phase, each once.
    pub fn run(&self, n: usize, task: &(dyn Fn(usize) + Sync)) {
        /// Waits until the tasks of others have ended, which borrow what the lead has, even where a task of its own panics.
        struct Wait<'a>(&'a Team, u64, u64);
        impl Drop for Wait<'_> {
            fn drop(&mut self) {
                while !self.0.has_done(self.1, self.2) {
                    std::thread::yield_now();
                }
            }
        }
        if n <= 1 || self.n_threads() == 1 {
            return (0..n).for_each(task);
        }
        let phase = self.phase.get() + 1;
        self.phase.set(phase);
        let part = |k: usize| (k * n / self.seats.len()) as u64;
        for (k, Seat { share, .. }) in self.seats.iter().enumerate() {
            // SAFETY: no task of another phase is left, so that no thread reads it; it is read by those that have claimed a task of this phase
            // alone, which end before this returns.
            unsafe {
                *share.task.get() = Some(std::mem::transmute::<*const (dyn Fn(usize) + Sync + '_), *const Task>(task))
            };
            share.end.store(part(k + 1), Ordering::Relaxed);
            share.next.store(phase << 32 | part(k), Ordering::Release);
        }
        let wait = Wait(self, phase, n as u64);
        let begun = Instant::now();
        let done = self.work(0, phase);
        if self.has_done(phase, n as u64) {
            return;
        }
        let own = begun.elapsed();
        let most = CROWDED.0 + own * CROWDED.1 / (done as u32).max(1);
        let mut k = 0u32;
        while !self.has_done(phase, n as u64) {
            std::hint::spin_loop();
            k += 1;
            if k.is_multiple_of(64) {
                let waited = begun.elapsed() - own;
                self.is_crowded.set(self.is_crowded.get() || waited > most);
                if waited > POLITE {
                    std::thread::yield_now();
                }
            }
        }
        drop(wait);
    }

    /// Whether all `n` tasks of a phase have ended.
    fn has_done(&self, phase: u64, n: u64) -> bool {
        let of_phase = |seat: &Seat| {
            let done = seat.done.0.load(Ordering::Acquire);
            if done >> 32 == phase { done & u32::MAX as u64 } else { 0 }
        };
        self.seats.iter().map(of_phase).sum::<u64>() == n
    }

    /// Claim tasks of a phase until none is left, those of the thread's own share first. Returns their number.
    fn work(&self, seat: usize, phase: u64) -> u64 {
        let n = self.seats.len();
        let mut claimed = Claimed { done: &self.seats[seat].done.0, phase, n: 0 };
        for Seat { share, .. } in (seat..seat + n).map(|k| &self.seats[k % n]) {
            loop {
                let at = share.next.load(Ordering::Acquire);
                let next = at & u32::MAX as u64;
                if at >> 32 != phase || next >= share.end.load(Ordering::Relaxed) {
                    break;
                }
                if share.next.compare_exchange(at, at + 1, Ordering::AcqRel, Ordering::Relaxed).is_ok() {
                    claimed.n += 1;
                    // SAFETY: a task of this phase has been claimed and not ended.
                    let task = unsafe { &*(*share.task.get()).expect("the tasks of a phase that goes on") };
                    task(next as usize);
                }
            }
        }
        claimed.n
    }

    /// Work through the phases until the team ends, or there is nothing to do for a while.
    fn help(&self, seat: usize) {
        let (mut seen, mut idle, mut k) = (0, Instant::now(), 0u32);
        while !self.has_ended.load(Ordering::Acquire) {
            let phase = self.seats[seat].share.next.load(Ordering::Acquire) >> 32;
            if phase != seen {
                seen = phase;
                if self.work(seat, phase) > 0 {
                    idle = Instant::now();
                }
                continue;
            }
            std::hint::spin_loop();
            k += 1;
            if k.is_multiple_of(32) {
                if rayon::yield_now() == Some(rayon::Yield::Executed) {
                    idle = Instant::now();
                }
                let waited = idle.elapsed();
                if waited > STAY {
                    return;
                }
                if waited > POLITE {
                    std::thread::yield_now();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU32;

    fn on_threads<R: Send>(n: usize, work: impl FnOnce() -> R + Send) -> R {
        rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads").install(work)
    }

    #[test]
    fn each_task_runs_once_in_each_phase() {
        for threads in [1, 2, 3, 8] {
            on_threads(threads, || {
                let runs: Vec<AtomicU32> = (0..100).map(|_| AtomicU32::new(0)).collect();
                gather(&mut Pace::default(), false, |team| {
                    for phase in 1..=2000 {
                        let n = phase % 100;
                        team.run(n, &|k| {
                            runs[k].fetch_add(1, Ordering::Relaxed);
                        });
                        // What the tasks have written is the lead's to read.
                        assert!(
                            (0..n).all(|k| runs[k].swap(0, Ordering::Relaxed) == 1),
                            "{threads} threads, phase {phase}"
                        );
                    }
                });
            });
        }
    }

    #[test]
    fn threads_that_leave_miss_nothing_and_parallel_loops_still_have_them() {
        use rayon::prelude::*;
        on_threads(2, || {
            gather(&mut Pace::default(), false, |team| {
                std::thread::sleep(20 * STAY);
                let sum = AtomicU64::new(0);
                team.run(1000, &|k| {
                    sum.fetch_add(k as u64, Ordering::Relaxed);
                });
                assert_eq!(sum.into_inner(), 499_500);
                assert_eq!((0..1000u32).into_par_iter().with_max_len(1).sum::<u32>(), 499_500);
            });
        });
    }

    #[test]
    fn a_task_that_panics_ends_the_team() {
        for bad in [0, 9] {
            let outcome = std::panic::catch_unwind(|| {
                on_threads(2, || {
                    gather(&mut Pace::default(), false, |team| team.run(10, &|k| assert!(k != bad, "task {k}")));
                });
            });
            assert!(outcome.is_err());
        }
    }

    #[test]
    fn a_crowded_machine_pauses_teams_ever_longer_and_a_free_one_forgets_it() {
        let mut pace = Pace::default();
        let mut pauses = vec![];
        for _ in 0..8 {
            assert!(!pace.is_paused());
            pace.end(true);
            let mut n = 0;
            while pace.is_paused() {
                n += 1;
            }
            pauses.push(n);
        }
        assert_eq!(pauses, [1, 2, 4, 8, 16, 32, 64, 64]);
        (0..200).for_each(|_| pace.end(false));
        pace.end(true);
        assert_eq!(pace.next, 1);
    }
}
