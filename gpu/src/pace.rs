//! How long commands take, and with it how many of them are submitted at once: drivers end a submission that keeps a device too long.
//!
//! A stage of a recorded list is known by its name and the number of its commands; what is kept of it is the longest time that each of them has
//! taken. Commands of which nothing is known are submitted alone, others together for [`AIM`]: a stage that takes longer is cut between them.

use std::collections::HashMap;

/// Time of a submission that is aimed at, s; none shall take longer than half a second.
const AIM: f64 = 0.1;

/// Time below which none is told from another, s.
const LEAST: f64 = 1e-7;

/// A stage: its name and the number of its commands.
pub(crate) type Key = (&'static str, usize);

/// What is known of the times of commands.
#[derive(Debug)]
pub(crate) struct Pace {
    /// The longest time of each command of a stage, s; infinite if it is not known.
    seen: HashMap<Key, Vec<f64>>,
    /// By how much all may grow before it is measured again.
    pub growth: f64,
    /// The longest submission so far, s.
    pub longest: f64,
    /// Submissions since times were last taken without timestamps.
    n_untimed: u32,
}

impl Default for Pace {
    fn default() -> Self {
        Pace { seen: HashMap::new(), growth: 1.0, longest: 0.0, n_untimed: 0 }
    }
}

/// Commands of a stage that are submitted together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    /// Its stage.
    pub key: Key,
    /// Index of the first command.
    pub first: usize,
    /// Index after the last.
    pub end: usize,
}

impl Unit {
    /// A whole stage.
    pub fn whole(key: Key) -> Unit {
        Unit { key, first: 0, end: key.1 }
    }
}

impl Pace {
    /// The time that a command may take, s; infinite if it is not known.
    fn of(&self, key: Key, command: usize) -> f64 {
        self.seen.get(&key).map_or(f64::INFINITY, |seconds| seconds[command] * self.growth)
    }

    /// Cut stages into submissions: lists of units, each with the index of its stage.
    pub fn plan(&self, stages: &[Key]) -> Vec<Vec<(usize, Unit)>> {
        let mut submissions: Vec<Vec<(usize, Unit)>> = vec![];
        // Time that is left in the last submission.
        let mut left = 0.0;
        for (stage, key) in stages.iter().copied().enumerate() {
            for command in 0..key.1 {
                let seconds = self.of(key, command);
                let more = Unit { key, first: command, end: command + 1 };
                match submissions.last_mut() {
                    Some(submission) if seconds <= left => match submission.last_mut() {
                        Some((last, unit)) if *last == stage => unit.end = command + 1,
                        _ => submission.push((stage, more)),
                    },
                    _ => {
                        submissions.push(vec![(stage, more)]);
                        left = if seconds.is_finite() { AIM } else { 0.0 };
                    }
                }
                left -= seconds;
            }
        }
        submissions
    }

    /// Whether nothing is known of a command of a unit.
    fn is_new(&self, unit: &Unit) -> bool {
        (unit.first..unit.end).any(|command| self.of(unit.key, command) == f64::INFINITY)
    }

    /// Units that have been submitted together have taken this time, s.
    pub fn observe(&mut self, units: &[Unit], seconds: f64) {
        let least = |seconds: f64| if seconds.is_finite() { seconds } else { LEAST };
        let known = |unit: &Unit| match self.seen.get(&unit.key) {
            Some(own) => own[unit.first..unit.end].iter().map(|s| least(*s)).sum(),
            None => LEAST * (unit.end - unit.first) as f64,
        };
        let expected: f64 = units.iter().map(known).sum();
        let factor = (seconds / expected.max(LEAST)).max(1.0);
        // Each command once, however often it has run.
        let mut units = units.to_vec();
        units.sort_unstable_by_key(|unit| (unit.key, unit.first));
        let mut done = (("", 0), 0);
        for unit in units {
            let own = self.seen.entry(unit.key).or_insert_with(|| vec![f64::INFINITY; unit.key.1]);
            let first = if done.0 == unit.key { unit.first.max(done.1) } else { unit.first };
            own.iter_mut().take(unit.end).skip(first).for_each(|seconds| *seconds = least(*seconds) * factor);
            done = (unit.key, unit.end.max(first));
        }
    }

    /// A submission has taken this time, s.
    pub fn submission(&mut self, seconds: f64) {
        self.longest = self.longest.max(seconds);
    }

    /// Whether a submission is to be waited for, where there are no timestamps: what it holds is not known, or it is long since.
    pub fn is_due(&mut self, submission: &[Unit]) -> bool {
        /// Submissions from one that is waited for to the next.
        const PERIOD: u32 = 64;
        self.n_untimed += 1;
        let is_due = self.n_untimed >= PERIOD || submission.iter().any(|unit| self.is_new(unit));
        if is_due {
            self.n_untimed = 0;
        }
        is_due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SORT: Key = ("sort", 30);
    const SOLVE: Key = ("solve", 4);

    /// The units of a plan by their ends.
    fn cuts(plan: &[Vec<(usize, Unit)>]) -> Vec<Vec<(usize, usize, usize)>> {
        plan.iter().map(|own| own.iter().map(|(stage, unit)| (*stage, unit.first, unit.end)).collect()).collect()
    }

    #[test]
    fn commands_that_are_not_known_are_submitted_alone_and_the_rest_together() {
        let mut pace = Pace::default();
        assert_eq!(cuts(&pace.plan(&[SOLVE])), [[(0, 0, 1)], [(0, 1, 2)], [(0, 2, 3)], [(0, 3, 4)]]);
        pace.observe(&[Unit::whole(SOLVE)], 0.0099);
        assert_eq!(pace.plan(&[SORT, SOLVE, SOLVE]).len(), 31);
        assert_eq!(cuts(&pace.plan(&[SORT, SOLVE, SOLVE]))[30], [(1, 0, 4), (2, 0, 4)]);
        // Ten of a hundredth of a second are one submission, the eleventh begins another.
        let ends: Vec<usize> = pace.plan(&[SOLVE; 11]).iter().map(|own| own.len()).collect();
        assert_eq!(ends, [10, 1]);
        pace.growth = 5.0;
        assert_eq!(pace.plan(&[SOLVE; 5]).iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 1]);
        assert!(pace.plan(&[("none", 0)]).is_empty());
    }

    #[test]
    fn long_stages_are_cut_between_commands_and_times_are_those_of_the_longest_run() {
        let mut pace = Pace::default();
        pace.observe(&[Unit::whole(SORT)], 0.24);
        pace.observe(&[Unit::whole(SORT)], 0.01);
        let plan = pace.plan(&[SORT]);
        assert_eq!(cuts(&plan), [[(0, 0, 12)], [(0, 12, 24)], [(0, 24, 30)]]);
        // Twelve that take longer than the whole did take that themselves, and the others what they took.
        pace.observe(&[plan[0][0].1], 0.25);
        let cut = [[(0, 0, 4)], [(0, 4, 8)], [(0, 8, 14)], [(0, 14, 26)], [(0, 26, 30)]];
        assert_eq!(cuts(&pace.plan(&[SORT])), cut);
        // A command that takes longer than all is alone.
        pace.observe(&[Unit { key: SOLVE, first: 2, end: 3 }], 0.4);
        assert_eq!(pace.plan(&[SOLVE]).len(), 4);
        pace.observe(&[Unit::whole(SOLVE)], 0.4);
        assert_eq!(cuts(&pace.plan(&[SOLVE])), [[(0, 0, 2)], [(0, 2, 3)], [(0, 3, 4)]]);
        // Runs of the same list together tell the time of one.
        let mut pace = Pace::default();
        pace.observe(&[Unit::whole(SOLVE)], 0.001);
        pace.observe(&[Unit::whole(SOLVE); 10], 0.05);
        let seconds: f64 = (0..4).map(|command| pace.of(SOLVE, command)).sum();
        assert!((seconds - 0.005).abs() < 1e-9);
    }
}
