//! Joints, their motors and limits, and springs.
//!
//! A joint has a frame on each of its two bodies; its axis is the frames' z. It locks some of the six relative motions:
//!
//! | kind | locks |
//! |---|---|
//! | spherical | the frames' origins on each other |
//! | revolute | origins, and z on z |
//! | universal | origins, and A's x square to B's y |
//! | fixed | origins and all turning |
//! | cylindrical | B's origin on A's z axis, and z on z |
//! | prismatic | as cylindrical, and no turning about z |
//! | point_on_plane | B's origin in A's xy plane |
//! | distance | the origins' distance |
//! | revolute_spherical | the origins' distance, and B's origin in A's xy plane |
//!
//! Every locked motion is a row `Ψ = 0`, with `dΨ/dt = l·(v_B − v_A) + a_B·ω_B − a_A·ω_A`. Source: paper §2; Haug,
//! Computer Aided Kinematics and Dynamics, ch. 9 for the forms of Ψ.

use crate::load::Function;
use crate::pose::Pose;
use crate::twist::Twist;
use glam::DVec3;

/// What a joint leaves free.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// Ball joint.
    Spherical,
    /// Hinge about z.
    Revolute,
    /// Slide along z.
    Prismatic,
    /// Slide along z and turn about it.
    Cylindrical,
    /// Cardan joint.
    Universal,
    /// Weld.
    Fixed,
    /// Two points at a constant distance.
    Distance,
    /// A point in a plane.
    PointOnPlane,
    /// A link of constant length, hinged about A's z and with a ball on B.
    RevoluteSpherical,
}

/// What drives a joint's free motion: an angle about z for revolute and cylindrical, a distance along z for prismatic joints.
#[derive(Clone, Debug, PartialEq)]
pub enum Motor {
    /// Speed, rad/s or m/s, whatever it takes.
    Speed(Function),
    /// Angle, rad, or distance, m, whatever it takes.
    Position(Function),
    /// Torque, N m, or force, N, on B (and against it on A).
    Effort(Function),
}

/// A joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: JointKind,
    /// Bodies A and B.
    pub bodies: [u32; 2],
    /// The frame on A, in A's principal frame.
    pub frame_a: Pose,
    /// The frame on B, in B's principal frame.
    pub frame_b: Pose,
    /// Length over time, m (distance and revolute_spherical); a linear actuator where it changes.
    pub length: Function,
    /// Least and greatest coordinate: angle, rad, or distance, m.
    pub limits: Option<[f64; 2]>,
    /// Motor.
    pub motor: Option<Motor>,
    /// It holds from this time on, s.
    pub from: f64,
    /// And until this, s.
    pub until: f64,
}

/// A spring with a damper, along the line between two points or about the z axis of two frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// Name.
    pub name: String,
    /// Bodies A and B.
    pub bodies: [u32; 2],
    /// The frame on A, in A's principal frame; a linear spring uses its origin alone.
    pub frame_a: Pose,
    /// The frame on B, in B's principal frame.
    pub frame_b: Pose,
    /// Whether it is about z rather than along a line.
    pub rotational: bool,
    /// Stiffness, N/m or N m/rad.
    pub stiffness: f64,
    /// Damping, N s/m or N m s/rad.
    pub damping: f64,
    /// Length, m, or angle, rad, without force.
    pub rest: f64,
    /// Force, N, or torque, N m, in addition, pulling B to A where positive.
    pub preload: Function,
    /// It acts from this time on, s.
    pub from: f64,
    /// And until this, s.
    pub until: f64,
}

/// What a joint did in the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct JointState {
    /// Force that B puts on A through the joint, N, in the joint's frame on A.
    pub force: DVec3,
    /// Torque that B puts on A through the joint, N m, about the origin of the joint's frame on A and in that frame.
    pub torque: DVec3,
    /// Angle, rad, counted on through whole turns, or distance, m.
    pub coordinate: f64,
    /// Its rate.
    pub rate: f64,
    /// How far the locked motions are off, m and rad: the greatest |Ψ|.
    pub violation: f64,
}

/// What a spring did in the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SpringState {
    /// Force, N, that pulls the points together, or torque, N m, that turns B back.
    pub force: f64,
    /// Length, m, or angle, rad, counted on through whole turns.
    pub coordinate: f64,
}

/// A scalar constraint between two bodies in the world frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Row {
    /// Bodies A and B.
    pub bodies: [u32; 2],
    /// l: direction of the relative velocity.
    pub linear: DVec3,
    /// a_A.
    pub angular_a: DVec3,
    /// a_B.
    pub angular_b: DVec3,
    /// Ψ, m or rad, at the step's start but for what is prescribed, which is taken at its end.
    pub psi: f64,
    /// What is prescribed for dΨ/dt beyond Ψ, m/s or rad/s.
    pub rate: f64,
    /// Compliance over h², 1/kg: zero for a locked motion.
    pub softness: f64,
}

impl Row {
    /// dΨ/dt for the velocities of A and B.
    #[inline]
    pub fn speed(&self, a: Twist, b: Twist) -> f64 {
        self.linear.dot(b.v - a.v) + self.angular_b.dot(b.w) - self.angular_a.dot(a.w)
    }

    /// dΨ/dt for the velocities of all bodies.
    #[inline]
    pub fn speed_in(&self, motion: &[Twist]) -> f64 {
        let [a, b] = self.bodies.map(|b| motion[b as usize]);
        self.speed(a, b)
    }
}

/// The frames of a joint in the world.
pub struct Frames {
    /// On A.
    pub a: Pose,
    /// On B.
    pub b: Pose,
    /// From A's and B's centres to the frames' origins.
    arm: [DVec3; 2],
}

impl Frames {
    /// Where two frames are, given in those of A and B.
    pub fn of([a, b]: [Pose; 2], frame_a: &Pose, frame_b: &Pose) -> Frames {
        let (fa, fb) = (a.place(frame_a), b.place(frame_b));
        Frames { arm: [fa.position - a.position, fb.position - b.position], a: fa, b: fb }
    }

    /// Force and torque of rows on A over a step h, at A's origin and in A's frame.
    pub fn reaction(&self, rows: &[Row], lambda: &[f64], h: f64) -> (DVec3, DVec3) {
        let sum =
            |part: &dyn Fn(&Row) -> DVec3| rows.iter().zip(lambda).map(|(r, l)| part(r) * (-l / h)).sum::<DVec3>();
        let force = sum(&|r| r.linear);
        let torque = sum(&|r| r.angular_a) - self.arm[0].cross(force);
        let into = self.a.orientation.inverse();
        (into * force, into * torque)
    }

    /// From A's origin to B's.
    fn apart(&self) -> DVec3 {
        self.b.position - self.a.position
    }

    /// Angle of B's x against A's x about A's z, in (−π, π].
    fn angle(&self) -> f64 {
        let x = self.b.orientation * DVec3::X;
        x.dot(self.a.orientation * DVec3::Y).atan2(x.dot(self.a.orientation * DVec3::X))
    }

    /// B's origin against A's along a direction that turns with A.
    fn along(&self, direction: DVec3) -> Row {
        Row {
            linear: direction,
            angular_a: (self.arm[0] + self.apart()).cross(direction),
            angular_b: self.arm[1].cross(direction),
            psi: self.apart().dot(direction),
            ..Row::default()
        }
    }

    /// The cosine between an axis of A and one of B.
    fn square(&self, of_a: DVec3, of_b: DVec3) -> Row {
        let (a, b) = (self.a.orientation * of_a, self.b.orientation * of_b);
        let turn = b.cross(a);
        Row { angular_a: turn, angular_b: turn, psi: a.dot(b), ..Row::default() }
    }

    /// The distance between the origins; along A's z where they coincide.
    fn distance(&self) -> Row {
        let d = self.apart();
        let length = d.length();
        let direction = if length > 1e-12 { d / length } else { self.a.orientation * DVec3::Z };
        Row { psi: length, ..self.along(direction) }
    }

    /// The turn of B against A about A's z.
    fn about(&self) -> Row {
        let z = self.a.orientation * DVec3::Z;
        Row { angular_a: z, angular_b: z, psi: self.angle(), ..Row::default() }
    }
}

impl JointKind {
    /// Whether its free coordinate is an angle, a distance along z, or none.
    pub fn coordinate(self) -> Option<Coordinate> {
        match self {
            JointKind::Revolute | JointKind::Cylindrical => Some(Coordinate::Angle),
            JointKind::Prismatic => Some(Coordinate::Slide),
            JointKind::Distance | JointKind::RevoluteSpherical => Some(Coordinate::Length),
            _ => None,
        }
    }
}

/// What a joint's coordinate measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Angle about z, rad.
    Angle,
    /// Distance along z, m.
    Slide,
    /// Distance of the origins, m.
    Length,
}

impl Joint {
    /// Whether it holds at a time.
    pub fn holds(&self, t: f64) -> bool {
        t >= self.from && t < self.until
    }

    /// The locked and driven motions, into `rows`; `t` is the time at the step's end.
    pub fn rows(&self, f: &Frames, known: &JointState, t: f64, rows: &mut Vec<Row>) {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        let axes = [x, y, z].map(|e| f.a.orientation * e);
        let first = rows.len();
        match self.kind {
            JointKind::Spherical | JointKind::Revolute | JointKind::Universal | JointKind::Fixed => {
                rows.extend(axes.map(|e| f.along(e)));
            }
            JointKind::Prismatic | JointKind::Cylindrical => rows.extend([f.along(axes[0]), f.along(axes[1])]),
            JointKind::PointOnPlane => rows.push(f.along(axes[2])),
            JointKind::Distance => rows.push(self.fixed_length(f, t)),
            JointKind::RevoluteSpherical => rows.extend([self.fixed_length(f, t), f.along(axes[2])]),
        }
        match self.kind {
            JointKind::Revolute | JointKind::Cylindrical => rows.extend([f.square(x, z), f.square(y, z)]),
            JointKind::Fixed | JointKind::Prismatic => {
                rows.extend([f.square(x, z), f.square(y, z), f.square(x, y)]);
            }
            JointKind::Universal => rows.push(f.square(x, y)),
            _ => {}
        }
        match (&self.motor, self.kind.coordinate()) {
            (Some(Motor::Speed(speed)), Some(c)) => {
                rows.push(Row { psi: 0.0, rate: speed.at(t), ..self.free_row(f, c) });
            }
            (Some(Motor::Position(goal)), Some(c)) => {
                let row = self.free_row(f, c);
                rows.push(Row { psi: self.coordinate(f, known) - goal.at(t), ..row });
            }
            _ => {}
        }
        for row in &mut rows[first..] {
            row.bodies = self.bodies;
        }
    }

    /// By how much row `k` of `n` of the joint is off at time `t`, a step's start, at whose end `t_end` what is prescribed for it is
    /// taken; none for a motor's row, which is no locked motion.
    pub fn error(&self, row: &Row, k: usize, n: usize, t: f64, t_end: f64) -> Option<f64> {
        let is_motor = matches!(self.motor, Some(Motor::Speed(_) | Motor::Position(_))) && k + 1 == n;
        let has_length = matches!(self.kind, JointKind::Distance | JointKind::RevoluteSpherical) && k == 0;
        let change = if has_length { self.length.at(t_end) - self.length.at(t) } else { 0.0 };
        (!is_motor).then_some((row.psi + change).abs())
    }

    fn fixed_length(&self, f: &Frames, t: f64) -> Row {
        let row = f.distance();
        Row { psi: row.psi - self.length.at(t), ..row }
    }

    /// The row of the free coordinate.
    pub fn free_row(&self, f: &Frames, coordinate: Coordinate) -> Row {
        let row = match coordinate {
            Coordinate::Angle => f.about(),
            Coordinate::Slide => f.along(f.a.orientation * DVec3::Z),
            Coordinate::Length => f.distance(),
        };
        Row { bodies: self.bodies, ..row }
    }

    /// The free coordinate, an angle counted on from the last known one.
    pub fn coordinate(&self, f: &Frames, known: &JointState) -> f64 {
        match self.kind.coordinate() {
            Some(Coordinate::Angle) => unwrapped(f.angle(), known.coordinate),
            Some(c) => self.free_row(f, c).psi,
            None => 0.0,
        }
    }

    /// The torque or force of the motor on B along the coordinate, N m or N.
    pub fn effort(&self, t: f64) -> f64 {
        match &self.motor {
            Some(Motor::Effort(effort)) => effort.at(t),
            _ => 0.0,
        }
    }
}

/// The angle that is nearest to the one before, of all that differ from `angle` by whole turns.
fn unwrapped(angle: f64, before: f64) -> f64 {
    let turns = ((before - angle) / std::f64::consts::TAU).round();
    angle + turns * std::f64::consts::TAU
}

impl Spring {
    /// Whether it acts at a time.
    pub fn acts(&self, t: f64) -> bool {
        t >= self.from && t < self.until
    }

    /// What pulls B to A without damping, N or N m, at a length or angle and a time.
    pub fn tension(&self, psi: f64, t: f64) -> f64 {
        self.stiffness * (psi - self.rest) + self.preload.at(t)
    }

    /// The row along which it pulls; Ψ is its length or angle.
    pub fn row(&self, f: &Frames, known: &SpringState) -> Row {
        let row = if self.rotational { f.about() } else { f.distance() };
        let psi = if self.rotational { unwrapped(row.psi, known.coordinate) } else { row.psi };
        Row { bodies: self.bodies, psi, ..row }
    }
}
