//! How long commands take, and with it how many of them are submitted at once: drivers end a submission that keeps a device too long.
//!
//! A stage of a recorded list is known by its name and the number of its commands; what is kept of it is the longest time that it has taken.
//! Stages of which nothing is known are submitted alone, others together for [`AIM`]; a stage that takes longer is cut between its commands.

use std::collections::HashMap;

/// Time of a submission that is aimed at, s; none shall take longer than half a second.
const AIM: f64 = 0.1;

/// Time below which none is told from another, s.
const LEAST: f64 = 1e-6;

/// A stage: its name and the number of its commands.
pub(crate) type Key = (&'static str, usize);

/// What is known of the times of commands.
#[derive(Debug)]
pub(crate) struct Pace {
    /// The longest time of each stage, s.
    seen: HashMap<Key, f64>,
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

/// A part of a stage that is submitted whole: that `1 / parts` of it which begins at the command `first`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    /// Its stage.
    pub key: Key,
    /// Number of units of the stage.
    pub parts: usize,
    /// Index of the first command.
    pub first: usize,
    /// Index after the last.
    pub end: usize,
}

impl Pace {
    /// The time that a stage may take, s, if it is known.
    pub fn of(&self, key: Key) -> Option<f64> {
        self.seen.get(&key).map(|seconds| seconds * self.growth)
    }

    /// Cut stages into submissions: lists of units, each with the index of its stage.
    pub fn plan(&self, stages: &[Key]) -> Vec<Vec<(usize, Unit)>> {
        let mut submissions: Vec<Vec<(usize, Unit)>> = vec![];
        // Time that is left in the last submission.
        let mut left = 0.0;
        for (stage, key) in stages.iter().copied().enumerate() {
            let known = self.of(key);
            let parts = (known.unwrap_or(0.0) / AIM).ceil().clamp(1.0, key.1.max(1) as f64) as usize;
            for part in 0..parts {
                let [first, end] = [part, part + 1].map(|k| key.1 * k / parts);
                let unit = (stage, Unit { key, parts, first, end });
                let seconds = known.map_or(f64::INFINITY, |seconds| seconds / parts as f64);
                match submissions.last_mut() {
                    Some(last) if seconds <= left => last.push(unit),
                    _ => {
                        submissions.push(vec![unit]);
                        left = if known.is_some() { AIM } else { 0.0 };
                    }
                }
                left -= seconds;
            }
        }
        submissions
    }

    /// Units that have been submitted together have taken this time, s.
    pub fn observe(&mut self, units: &[Unit], seconds: f64) {
        let known = |unit: &Unit| self.seen.get(&unit.key).map_or(LEAST, |s| s / unit.parts as f64);
        let expected: f64 = units.iter().map(known).sum();
        let factor = seconds / expected.max(LEAST);
        let mut keys: Vec<Key> = units.iter().map(|unit| unit.key).collect();
        keys.sort_unstable();
        keys.dedup();
        for key in keys {
            let own = self.seen.entry(key).or_insert(LEAST);
            *own *= factor.max(1.0);
        }
    }

    /// A submission has taken this time, s.
    pub fn submission(&mut self, seconds: f64) {
        self.longest = self.longest.max(seconds);
    }

    /// Whether a submission is to be waited for, where there are no timestamps: what it holds is not known, or it is long since.
    pub fn is_due(&mut self, submission: &[(usize, Unit)]) -> bool {
        /// Submissions from one that is waited for to the next.
        const PERIOD: u32 = 64;
        self.n_untimed += 1;
        let is_due = self.n_untimed >= PERIOD || submission.iter().any(|(_, unit)| !self.seen.contains_key(&unit.key));
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

    fn whole(key: Key) -> Unit {
        Unit { key, parts: 1, first: 0, end: key.1 }
    }

    #[test]
    fn what_is_not_known_is_submitted_alone_and_the_rest_together() {
        let mut pace = Pace::default();
        assert_eq!(pace.plan(&[SORT, SOLVE, SOLVE]).len(), 3);
        pace.observe(&[whole(SOLVE)], 0.01);
        assert_eq!(
            pace.plan(&[SORT, SOLVE, SOLVE]),
            [vec![(0, whole(SORT))], vec![(1, whole(SOLVE)), (2, whole(SOLVE))]]
        );
        // Ten of a hundredth of a second are one submission, the eleventh begins another.
        assert_eq!(pace.plan(&[SOLVE; 11]).iter().map(Vec::len).collect::<Vec<_>>(), [10, 1]);
        pace.growth = 5.0;
        assert_eq!(pace.plan(&[SOLVE; 5]).iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 1]);
    }

    #[test]
    fn long_stages_are_cut_between_commands_and_times_are_those_of_the_longest_run() {
        let mut pace = Pace::default();
        pace.observe(&[whole(SORT)], 0.25);
        pace.observe(&[whole(SORT)], 0.01);
        let plan = pace.plan(&[SORT]);
        let cuts: Vec<_> = plan.iter().flatten().map(|(_, unit)| (unit.first, unit.end)).collect();
        assert_eq!(cuts, [(0, 10), (10, 20), (20, 30)]);
        // A third that takes as long as the whole did: all may take three times as long.
        pace.observe(&[plan[0][0].1], 0.25);
        assert!((pace.of(SORT).unwrap() - 0.75).abs() < 1e-9);
        // Not more parts than commands, and a stage without any is one.
        pace.observe(&[whole(SOLVE)], 10.0);
        assert_eq!(pace.plan(&[SOLVE]).len(), 4);
        assert_eq!(pace.plan(&[("none", 0)]).len(), 1);
        // Runs of the same list together tell the time of one.
        let mut pace = Pace::default();
        pace.observe(&[whole(SOLVE)], 0.001);
        pace.observe(&[whole(SOLVE); 10], 0.05);
        assert!((pace.of(SOLVE).unwrap() - 0.005).abs() < 1e-9);
    }
}
