//! Motors whose torque or force has a maximum τ, as rows of the joints.
//!
//! A motor that reaches the rate u* at which it aims with |λ| ≤ h τ is a row like any other. One that does not is *at its maximum*: its impulse
//! is ± h τ whatever the joint does, a load. That is the row u + C (λ ∓ h τ) = 0 with a compliance C far above its response, so that the
//! structure of the factor is the same. Which motors are at their maximum is found by rounds ([`super::pivoting`]): those whose row
//! asks for more are let go, and those that come to their rate are held ([`Motors::wrong`]).
//!
//! A motor of a coordinate that is behind comes back along the curve on which half of its torque would stop it in its place, v = √(τ w |e|) with
//! the rate w that a unit impulse of it gives its joint while all that are behind move freely, and at most in one step. Without that it would arrive
//! with all the speed that it can gain, pass its place, and swing about it. It aims once a step: what followed the sides of others would have
//! the rounds go on for ever, and motors of one mechanism give hundreds of times their maximum.

use super::pivoting::Wrong;
use super::response::Response;
use crate::cpu::masses::Masses;
use crate::joint::Row;

/// Compliance of the row of a motor at its maximum, over the response of the two bodies.
pub const FREE: f64 = 1e12;

/// What is rounding, over the impulse or the rates that are compared.
const ROUNDING: f64 = 1e-9;

/// A rate, m/s or rad/s, by which a coordinate that is behind comes back anyway.
const SLOW: f64 = 1e-9;

/// A motor of a prescribed rate or coordinate with a maximum effort.
#[derive(Clone, Copy, Debug)]
pub struct Motor {
    /// Id of the joint.
    pub joint: u32,
    /// Its row among those of the joints.
    pub row: u32,
    /// h τ, N s or N m s.
    pub most: f64,
    /// Prescribed rate, m/s or rad/s.
    pub rate: f64,
    /// How far the coordinate is ahead of what is prescribed, m or rad; 0 for a prescribed rate.
    pub ahead: f64,
    /// Sign of the effort of a motor at its maximum; 0 for one that reaches its rate.
    pub side: f64,
    /// u*: the rate at which it aims, m/s or rad/s.
    pub aim: f64,
}

/// The motors with a maximum effort of a step, by their joints.
#[derive(Default)]
pub struct Motors {
    motors: Vec<Motor>,
    /// Step size, s.
    step: f64,
    /// Whether the motors know at what they aim in this step.
    have_aims: bool,
    scratch: Response,
}

impl Motors {
    /// For a step of `step`, s.
    pub fn start(&mut self, step: f64) {
        self.motors.clear();
        (self.step, self.have_aims) = (step, false);
    }

    /// Add a motor, `row` with the response `response` to a unit impulse, on a joint that has the rate `speed` without it: where that is too far from
    /// what it aims at, it is taken to be at its maximum.
    pub fn push(&mut self, mut motor: Motor, (response, speed): (f64, f64)) {
        motor.aim_by(response, self.step);
        let lack = motor.aim - speed;
        // The response of the joint is at most that of its two bodies.
        if motor.side == 0.0 && lack.abs() > 2.0 * motor.most * response {
            motor.side = lack.signum();
        }
        self.motors.push(motor);
    }

    /// Whether no motor has a maximum effort.
    pub fn is_empty(&self) -> bool {
        self.motors.is_empty()
    }

    /// Number of motors.
    pub fn len(&self) -> usize {
        self.motors.len()
    }

    /// The motor of a joint.
    pub fn of_joint(&self, joint: u32) -> Option<&Motor> {
        self.motors.binary_search_by_key(&joint, |motor| motor.joint).ok().map(|i| &self.motors[i])
    }

    /// Let the rows be those of motors that are at their maximum, or are not.
    pub fn soften(&self, rows: &mut [Row], masses: &Masses) {
        self.soften_where(rows, masses, Motor::is_free);
    }

    /// Let the rows be those of motors that are behind and move freely, and of the others that reach their rate. Returns whether any is behind without
    /// an aim in this step.
    pub fn soften_lagging(&mut self, rows: &mut [Row], masses: &Masses) -> bool {
        let is_asked = !std::mem::replace(&mut self.have_aims, true);
        let step = self.step;
        let lags = |motor: &Motor| motor.lags(step);
        if !is_asked || !self.motors.iter().any(lags) {
            return false;
        }
        self.soften_where(rows, masses, lags);
        true
    }

    fn soften_where(&self, rows: &mut [Row], masses: &Masses, is_free: impl Fn(&Motor) -> bool) {
        for motor in &self.motors {
            let row = &mut rows[motor.row as usize];
            row.softness = if is_free(motor) { FREE * masses.response(row) } else { 0.0 };
        }
    }

    /// Aim, where a coordinate is behind, at what the motor can brake, once a step: aims that followed the sides would have these change for ever.
    /// `response` has the rate that a unit impulse of a motor gives its joint, where all that are behind move freely.
    pub fn aim(&mut self, mut response: impl FnMut(&Motor, &mut Response) -> f64) {
        let step = self.step;
        for motor in self.motors.iter_mut().filter(|motor| motor.lags(step)) {
            let response = response(motor, &mut self.scratch);
            motor.aim_by(response, step);
        }
    }

    /// Set the bias of the rows: that of the rates at which the motors aim, or of their maximum.
    pub fn set_bias(&self, rows: &[Row], bias: &mut [f64]) {
        for motor in &self.motors {
            let row = motor.row as usize;
            bias[row] = if motor.is_free() { -rows[row].softness * motor.side * motor.most } else { -motor.aim };
        }
    }

    /// The motors that are on the wrong side in a response: those that give more than their maximum, and those that have passed their rate at it.
    /// What is less than `error`, m/s or rad/s, is not seen.
    pub fn wrong(&self, rows: &[Row], masses: &Masses, response: &Response, error: f64) -> Vec<Wrong> {
        let of = |(index, motor): (usize, &Motor)| {
            let row = &rows[motor.row as usize];
            let (impulse, speed) = (response.lambda[motor.row as usize], row.speed_in(&response.twist));
            if motor.most == 0.0 {
                return None;
            }
            let (excess, side) = if motor.side == 0.0 {
                let excess = impulse.abs() - motor.most * (1.0 + ROUNDING);
                (excess * masses.response(row), impulse.signum())
            } else {
                let rounding = ROUNDING * (speed.abs() + motor.aim.abs());
                ((speed - motor.aim) * motor.side - rounding, 0.0)
            };
            (excess > error).then_some(Wrong { index, side, excess })
        };
        self.motors.iter().enumerate().filter_map(of).collect()
    }

    /// Put a motor on its other side.
    pub fn set(&mut self, wrong: &Wrong) {
        self.motors[wrong.index].side = wrong.side;
    }
}

impl Motor {
    /// Whether the joint moves freely, under a given effort.
    pub fn is_free(&self) -> bool {
        self.side != 0.0 || self.most == 0.0
    }

    /// Whether the coordinate is behind, or ahead, at the start of a step `step`, s.
    fn lags(&self, step: f64) -> bool {
        self.ahead.abs() > SLOW * step
    }

    /// Aim at the prescribed rate, and back at what is prescribed, where a unit impulse gives the joint the rate `response`.
    fn aim_by(&mut self, response: f64, step: f64) {
        let brakes = (self.most / step * response * self.ahead.abs()).sqrt();
        self.aim = self.rate - self.ahead.signum() * (self.ahead.abs() / step).min(brakes);
    }
}
