//! Which bounds of the joints hold: limits that are met, and motors that give their maximum effort.
//!
//! That is found by rounds, with a solve in each: all bounds that are wrong change sides, as long as they become fewer. Where that does not come to an
//! end, limits are found together ([`super::joints::Joints::settle_limits`]) before it goes on; at last one bound changes sides in each round.
//! Source: Júdice and Pires, *A block principal pivoting algorithm for large-scale strictly monotone linear complementarity problems* (1994);
//! the last rounds: Murty (1974).

/// Rounds in which those that are wrong need not become fewer.
const IN_VAIN: usize = 6;

/// Rounds before limits are found together.
const ALONE: usize = 4;

/// How often limits are found together.
const MOST_SETTLED: usize = 5;

/// Bounds of which each may change sides twice in rounds of one.
const MOST_BOUNDS: usize = 50;

/// A bound that is on the wrong side.
#[derive(Clone, Copy, Debug)]
pub struct Wrong {
    /// Its index among the bounds of its kind.
    pub index: usize,
    /// Its other side: 0 where its row is to hold.
    pub side: f64,
    /// The rate that the joint has, or is given, too much, m/s or rad/s.
    pub excess: f64,
}

/// What is to come after a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Nothing: the sides are as they may be.
    End,
    /// That many of the bounds on the wrong side change.
    Turn(usize),
    /// All limits are found together; for the first time, or not.
    Settle { is_first: bool },
}

/// The rounds of a step.
#[derive(Debug)]
pub struct Rounds {
    n: usize,
    least: usize,
    in_vain: usize,
    n_settled: usize,
    /// The bounds that alone have changed sides after the last two rounds, the later first.
    turned: [Option<Wrong>; 2],
    is_last: bool,
}

impl Default for Rounds {
    fn default() -> Rounds {
        Rounds { n: 0, least: usize::MAX, in_vain: 0, n_settled: 0, turned: [None; 2], is_last: false }
    }
}

impl Rounds {
    /// What comes after a round that has found `wrong` of `bounds` bounds on the wrong side, of which `n_limits` are limits. One that is wrong on either
    /// side, as where joints bend otherwise on the one than on the other, has that of the lesser excess.
    pub fn next(&mut self, wrong: &[Wrong], [bounds, n_limits]: [usize; 2]) -> Next {
        self.n += 1;
        if wrong.len() < self.least {
            (self.least, self.in_vain) = (wrong.len(), 0);
        }
        self.in_vain += 1;
        if wrong.is_empty() || self.is_last || self.n > MOST_SETTLED * IN_VAIN + 2 * bounds.min(MOST_BOUNDS) {
            return Next::End;
        }
        if let (&[wrong], [Some(last), Some(before)]) = (wrong, self.turned)
            && wrong.index == last.index
            && (wrong.index, wrong.side) == (before.index, before.side)
        {
            if wrong.excess <= last.excess {
                return Next::End;
            }
            self.is_last = true;
        }
        let are_all = self.in_vain <= IN_VAIN;
        let is_settled = self.n_settled > 0;
        if (self.n > ALONE || is_settled) && wrong.len() > 1 && n_limits > 1 && self.n_settled < MOST_SETTLED {
            (self.least, self.in_vain, self.turned) = (usize::MAX, 0, [None; 2]);
            self.n_settled += 1;
            return Next::Settle { is_first: !is_settled };
        }
        let n = if are_all { wrong.len() } else { 1 };
        self.turned = [(n == 1).then_some(wrong[0]), self.turned[0]];
        Next::Turn(n)
    }
}
