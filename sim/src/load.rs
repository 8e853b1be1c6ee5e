//! Loads and the functions of time that drive loads, motors and actuators.

use glam::DVec3;

/// A function of time, s; its values have the unit of the driven quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Function {
    /// A constant value.
    Constant(f64),
    /// `before` until time `at`, then `after`.
    Step {
        /// Value before the step.
        before: f64,
        /// Value from the step on.
        after: f64,
        /// Time of the step, s.
        at: f64,
    },
    /// A linear ramp between two values, constant before and after.
    Ramp {
        /// Values at the start and at the end.
        values: [f64; 2],
        /// Times of the start and of the end, s.
        times: [f64; 2],
    },
    /// `mean + amplitude sin(2π frequency t + phase)`.
    Sine {
        /// Mean.
        mean: f64,
        /// Amplitude.
        amplitude: f64,
        /// Frequency, Hz.
        frequency: f64,
        /// Phase, rad.
        phase: f64,
    },
    /// Points (time, s, and value) with linear interpolation, constant before the first and after the last; times ascend.
    Table(Vec<[f64; 2]>),
}

impl Function {
    /// The greatest size of a value.
    pub fn greatest(&self) -> f64 {
        match self {
            Function::Constant(x) => x.abs(),
            Function::Step { before: a, after: b, .. } | Function::Ramp { values: [a, b], .. } => a.abs().max(b.abs()),
            Function::Sine { mean, amplitude, .. } => mean.abs() + amplitude.abs(),
            Function::Table(points) => points.iter().map(|p| p[1].abs()).fold(0.0, f64::max),
        }
    }

    /// The least value.
    pub fn least(&self) -> f64 {
        match self {
            Function::Constant(x) => *x,
            Function::Step { before: a, after: b, .. } | Function::Ramp { values: [a, b], .. } => a.min(*b),
            Function::Sine { mean, amplitude, .. } => mean - amplitude.abs(),
            Function::Table(points) => points.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min),
        }
    }

    /// The least and the greatest value between two times, s, of which the second may be infinite.
    pub fn range(&self, [from, until]: [f64; 2]) -> [f64; 2] {
        let is_within = |t: &f64| (from..until).contains(t);
        let turns: Vec<f64> = match self {
            Function::Constant(_) => vec![],
            Function::Step { at, .. } => vec![*at],
            Function::Ramp { times, .. } => times.to_vec(),
            Function::Sine { frequency, phase, .. } => {
                // The first two extrema from there on; sin(π − x) is sin x.
                let phase = if *frequency < 0.0 { std::f64::consts::PI - phase } else { *phase };
                let quarters = 4.0 * (frequency.abs() * from + phase / std::f64::consts::TAU);
                let into = quarters.rem_euclid(2.0);
                let first = if into <= 1.0 { 1.0 - into } else { 3.0 - into };
                let time = |more: f64| from + (first + more) / (4.0 * frequency.abs());
                if *frequency == 0.0 { vec![] } else { vec![time(0.0), time(2.0)] }
            }
            Function::Table(points) => points.iter().map(|p| p[0]).collect(),
        };
        let ends = [from, if until.is_finite() { until } else { from }];
        let values = turns.into_iter().filter(is_within).chain(ends).map(|t| self.at(t));
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
    }

    /// The greatest size of a rate of change, but for jumps, 1/s.
    pub fn steepest(&self) -> f64 {
        let slope = |[t, a]: [f64; 2], [u, b]: [f64; 2]| if u > t { (b - a).abs() / (u - t) } else { 0.0 };
        match self {
            Function::Constant(_) | Function::Step { .. } => 0.0,
            Function::Ramp { values: [a, b], times: [t, u] } => slope([*t, *a], [*u, *b]),
            Function::Sine { amplitude, frequency, .. } => (std::f64::consts::TAU * frequency * amplitude).abs(),
            Function::Table(points) => points.windows(2).map(|p| slope(p[0], p[1])).fold(0.0, f64::max),
        }
    }

    /// The value at a time, s.
    pub fn at(&self, t: f64) -> f64 {
        match self {
            Function::Constant(x) => *x,
            Function::Step { before, after, at } => {
                if t < *at {
                    *before
                } else {
                    *after
                }
            }
            Function::Ramp { values: [a, b], times: [t0, t1] } => a + (b - a) * ((t - t0) / (t1 - t0)).clamp(0.0, 1.0),
            Function::Sine { mean, amplitude, frequency, phase } => {
                mean + amplitude * (std::f64::consts::TAU * frequency * t + phase).sin()
            }
            Function::Table(points) => {
                let next = points.partition_point(|p| p[0] <= t);
                match (next.checked_sub(1).and_then(|i| points.get(i)), points.get(next)) {
                    (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * (t - a[0]) / (b[0] - a[0]),
                    (Some(end), None) | (None, Some(end)) => end[1],
                    (None, None) => 0.0,
                }
            }
        }
    }
}

/// A force or a torque on a body: a direction times a function of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Id of the body.
    pub body: u32,
    /// Whether the load is a torque, N m, rather than a force, N.
    pub torque: bool,
    /// Unit direction, world; in the model file's body frame if `follows`.
    pub direction: DVec3,
    /// Whether the direction turns with the body.
    pub follows: bool,
    /// Point of application of a force, m, principal frame: relative to the centre of mass.
    pub point: DVec3,
    /// Magnitude over time, N or N m.
    pub value: Function,
    /// Time from which it acts, s, inclusive.
    pub from: f64,
    /// Time until which it acts, s, exclusive.
    pub until: f64,
}

impl Load {
    /// Whether the load acts at time `t`, s, and is not zero then.
    pub fn acts(&self, t: f64) -> bool {
        t >= self.from && t < self.until && self.value.at(t) != 0.0
    }

    /// Force, N, or torque, N m, world, at time `t`, s, with the orientation `frame` of the model file's body frame, body to world; zero
    /// while the load does not act.
    pub fn vector(&self, t: f64, frame: glam::DQuat) -> DVec3 {
        if t < self.from || t >= self.until {
            return DVec3::ZERO;
        }
        let direction = if self.follows { frame * self.direction } else { self.direction };
        direction * self.value.at(t)
    }

    /// Force, N, and torque about the centre of mass, N m, world, at time `t`, s, on a body of the given orientation, principal frame to world,
    /// and the model file's body frame, `frame` in the principal one.
    pub fn wrench(&self, t: f64, orientation: glam::DQuat, frame: glam::DQuat) -> (DVec3, DVec3) {
        let vector = self.vector(t, orientation * frame);
        match self.torque {
            true => (DVec3::ZERO, vector),
            false => (vector, (orientation * self.point).cross(vector)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Function::*;

    #[test]
    fn functions_have_their_values() {
        assert_eq!(Step { before: 1.0, after: 2.0, at: 3.0 }.at(2.999), 1.0);
        assert_eq!(Step { before: 1.0, after: 2.0, at: 3.0 }.at(3.0), 2.0);
        let ramp = Ramp { values: [0.0, 10.0], times: [1.0, 2.0] };
        assert_eq!([0.0, 1.25, 5.0].map(|t| ramp.at(t)), [0.0, 2.5, 10.0]);
        let sine = Sine { mean: 1.0, amplitude: 2.0, frequency: 0.25, phase: 0.0 };
        assert!((sine.at(1.0) - 3.0).abs() < 1e-12);
        let table = Table(vec![[0.0, 1.0], [1.0, 3.0], [2.0, 0.0]]);
        assert_eq!([-1.0, 0.5, 1.5, 9.0].map(|t| table.at(t)), [1.0, 2.0, 1.5, 0.0]);
    }

    #[test]
    fn ranges_are_those_of_the_values_between_two_times() {
        let close = |found: [f64; 2], expected: [f64; 2], what: &str| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{what}: {found:?}");
        };
        let sine = |frequency: f64, phase: f64| Sine { mean: 1.0, amplitude: 2.0, frequency, phase };
        for (frequency, phase) in [(1.0, 0.0), (-1.0, std::f64::consts::PI)] {
            close(sine(frequency, phase).range([0.0, f64::INFINITY]), [-1.0, 3.0], "all of a sine");
            close(sine(frequency, phase).range([0.0, 0.5]), [1.0, 3.0], "its upper half");
            close(sine(frequency, phase).range([0.5, 0.75]), [-1.0, 1.0], "a quarter of it");
            close(sine(frequency, phase).range([0.25, 0.5]), [1.0, 3.0], "another");
        }
        close(sine(0.0, 0.0).range([0.0, 9.0]), [1.0, 1.0], "a sine of no frequency");
        let ramp = Ramp { values: [0.0, 4.0], times: [1.0, 3.0] };
        close(ramp.range([0.0, 2.0]), [0.0, 2.0], "half a ramp");
        close(ramp.range([2.0, f64::INFINITY]), [2.0, 4.0], "the other half");
        let table = Table(vec![[0.0, 1.0], [1.0, 5.0], [2.0, -1.0], [3.0, 0.0]]);
        close(table.range([0.5, 1.5]), [2.0, 5.0], "a part of a table");
        close(table.range([1.5, f64::INFINITY]), [-1.0, 2.0], "the rest of it");
        let step = Step { before: 1.0, after: -3.0, at: 2.0 };
        close(step.range([0.0, 2.0]), [-3.0, 1.0], "a step at the end");
        assert_eq!([step.least(), step.greatest(), sine(1.0, 0.0).least(), table.least()], [-3.0, 3.0, -1.0, -1.0]);
    }
}
