//! How long a step may be for what its joints bend: joints hold on the arcs of a step (`cpu/arcs.rs`) as long as their bodies turn by little in it.
//!
//! Where a link turns by a fifth of a radian, or is jerked round, or where there is no solution, the step begins again and is taken in parts, up to
//! [`MOST`] ([`crate::parts`]). So a mechanism that whirls for a while does not set the step of the whole run. Parts of the least length are
//! taken as they are. What a step of constant length keeps is the energy and a term of the second order in that length, so that a length that goes
//! with the phase of a turn adds energy, or takes it, in every turn: parts become longer once a whole turn has not asked for short ones.

use std::f64::consts::TAU;

/// The most parts of a step.
pub const MOST: u32 = 32;

/// How far joints are from linear in a step: how their bodies turn, and what follows from it.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Bend {
    /// The greatest turn of a body on joints, rad.
    pub turn: f64,
    /// The greatest rate Ψ/h that linear rows leave at the step's end, over the speed of the joint's bodies. A link that turns by θ about an end that
    /// stands still leaves θ/4; a wheel on its axle nothing.
    pub bent: f64,
    /// The greatest change of the rate at which a body on joints turns, times the step, rad.
    pub change: f64,
    /// The work that the forces of joints would do on what linear rows leave, over the kinetic energy of their mechanism and what it gains
    /// by falling for a step: greatest of the mechanisms. It goes with the square of the step, as (ω h)² for what swings by ω under the forces.
    pub strain: f64,
    /// Whether no solution was found on the arcs, so that rows were linear.
    pub is_lost: bool,
}

impl Bend {
    /// The greater ones of two.
    pub(crate) fn and(self, other: Bend) -> Bend {
        Bend {
            turn: self.turn.max(other.turn),
            bent: self.bent.max(other.bent),
            change: self.change.max(other.change),
            strain: self.strain.max(other.strain),
            is_lost: self.is_lost || other.is_lost,
        }
    }

    /// The parts in which a step that is too long is expected to be short enough: what bends goes with the length, what changes with its square.
    pub fn parts(&self) -> u32 {
        // Without a solution the bend is not known.
        let by_bend = (self.bent / IN_PART.bent).max((self.change / IN_PART.change).sqrt());
        let by_bend = if self.is_lost { 0.0 } else { by_bend };
        let parts = by_bend.max((self.strain / STRAIN_OF_PART).sqrt()).clamp(2.0, f64::from(MOST));
        (parts.ceil() as u32).next_power_of_two()
    }

    /// Whether something turns, and joints feel it.
    fn is_felt(&self) -> bool {
        self.turn > TURNED && self.bent > BENT
    }

    /// What is expected in a step of twice the length.
    fn over_twice_the_time(&self) -> Bend {
        Bend {
            turn: 2.0 * self.turn,
            bent: 2.0 * self.bent,
            change: 4.0 * self.change,
            strain: 4.0 * self.strain,
            ..*self
        }
    }
}

/// Turn of a body on joints from which on a step may be too long for it, rad.
const TURNED: f64 = 0.02;
/// What linear rows leave of a joint ([`Bend::bent`]) from which on it feels the turn.
const BENT: f64 = 0.01;

/// The same of which bodies feel nothing at any point of a turn, as wheels on their axles.
const EVEN: f64 = 1e-4;

/// [`Bend::strain`] from which on a step without a solution is too long where bodies turn by so much, rad: taut bridges and chains, whose links turn
/// by the angle that they hang through. What a part is expected to have.
const STRAIN: f64 = 0.01;
const STRAINED: f64 = 2e-3;
const STRAIN_OF_PART: f64 = 0.05;

/// What a step is too long for, where bodies turn by [`TURNED`].
#[derive(Clone, Copy)]
pub struct Coarse {
    /// [`Bend::bent`].
    bent: f64,
    /// [`Bend::change`] where the joints feel it: what turns evenly keeps its energy in longer steps.
    change: f64,
    /// The same over the turn, as at a dead centre, where a light crank whirls for a step.
    jerk: f64,
}

/// Of a whole step.
pub const IN_STEP: Coarse = Coarse { bent: 0.04, change: 0.02, jerk: 0.05 };
/// Of a part. What is jerked round in one is so in shorter ones.
pub const IN_PART: Coarse = Coarse { bent: 0.05, change: 0.005, jerk: f64::INFINITY };
/// Of parts that are to become longer.
const GROWN: Coarse = Coarse { bent: 0.03, change: 0.003, jerk: f64::INFINITY };

impl Coarse {
    /// Whether a step is too long for what its joints bend.
    pub fn is_too_long(&self, bend: &Bend) -> bool {
        let is_jerked = bend.change > self.change || bend.change > self.jerk * bend.turn;
        let is_bent = is_jerked || bend.bent > self.bent || bend.is_lost;
        bend.is_felt() && is_bent || bend.is_lost && bend.strain > STRAIN && bend.turn > STRAINED
    }
}

/// The parts that steps are taken in, and how joints have bent in them.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Pace {
    /// Number of parts that the next step begins with; 0 before the first.
    parts: u32,
    /// The turn of bodies on joints since this number was another, rad.
    turned: f64,
    /// The greatest bend of a part since then.
    bend: Bend,
}

impl Pace {
    /// The pace after a step in `parts` parts; none of them bent by more than `bend`. What is divided at one point of a turn and not at another has
    /// more energy or less after each turn: parts become longer once a turn has not asked for short ones, or where hardly anything turns.
    pub fn after(self, parts: u32, bend: Bend) -> Pace {
        let (turned, since) = match parts == self.parts {
            true => (self.turned, self.bend.and(bend)),
            false => (0.0, bend),
        };
        let turned = turned + f64::from(parts) * bend.turn;
        let twice = bend.over_twice_the_time();
        let is_still =
            (twice.turn < TURNED || twice.bent < EVEN) && (twice.turn < STRAINED || twice.strain < STRAIN_OF_PART);
        let is_calm = turned > TAU && !GROWN.is_too_long(&since.over_twice_the_time());
        match parts > 1 && (is_still || is_calm) {
            true => Pace { parts: parts / 2, ..Pace::default() },
            false if turned > TAU => Pace { parts, ..Pace::default() },
            false => Pace { parts, turned, bend: since },
        }
    }

    /// Number of parts that the next step begins with.
    pub fn parts(&self) -> u32 {
        self.parts.max(1)
    }

    /// Whether it is one of steps.
    pub fn is_sound(&self) -> bool {
        let numbers = [self.turned, self.bend.turn, self.bend.bent, self.bend.change, self.bend.strain];
        (self.parts == 0 || self.parts.is_power_of_two() && self.parts <= MOST) && !numbers.iter().any(|x| x.is_nan())
    }
}
