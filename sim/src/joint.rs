//! Joints, their motors and limits, and springs.
//!
//! A joint has a frame on each of its two bodies; its axis is the frames' z. It locks some of the six relative motions:
//!
//! | kind | locks |
//! |---|---|
//! | spherical | the frames' origins on each other |
//! | revolute | the origins on each other, and B's z parallel to A's z |
//! | universal | the origins on each other, and A's x perpendicular to B's y |
//! | fixed | the origins on each other, and the relative rotation |
//! | cylindrical | B's origin on A's z axis, and B's z parallel to A's z |
//! | prismatic | as cylindrical, and the rotation about z |
//! | point_on_plane | B's origin in A's xy plane |
//! | distance | the distance of the origins |
//! | revolute_spherical | the distance of the origins, and B's origin in A's xy plane |
//!
//! Every locked motion is a row `Ψ = 0` ([`Row`]), with `dΨ/dt = l·(v_B − v_A) + a_B·ω_B − a_A·ω_A`. A motor or a limit acts on the
//! joint's *coordinate*: a free angle or slide, or the length of a link.
//!
//! Source: Negrut et al. 2012, §2; E. J. Haug, *Computer Aided Kinematics and Dynamics of Mechanical Systems* (1989), ch. 9, for
//! the forms of Ψ.

use crate::load::Function;
use crate::pose::Pose;
use crate::twist::Twist;
use glam::DVec3;

/// The kind of a joint, which defines the relative motions that are locked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// Spherical joint: a point of A on a point of B.
    Spherical,
    /// Revolute joint: a hinge about z.
    Revolute,
    /// Prismatic joint: a slide along z.
    Prismatic,
    /// Cylindrical joint: a slide along z with rotation about it.
    Cylindrical,
    /// Universal (cardan) joint: a common point, with rotation about x of A and y of B.
    Universal,
    /// Fixed joint: no relative motion.
    Fixed,
    /// Distance joint: two points at a given distance.
    Distance,
    /// Point on plane: a point of B in the xy plane of A.
    PointOnPlane,
    /// Revolute–spherical joint: a link of given length, with a revolute joint about z on A and a spherical joint on B.
    RevoluteSpherical,
}

/// A motor, which drives a joint's coordinate: the angle about z of revolute and cylindrical, the distance along z of prismatic joints.
#[derive(Clone, Debug, PartialEq)]
pub enum Motor {
    /// Prescribed rate of the coordinate, rad/s or m/s, with any effort, or up to [`Joint::max_effort`].
    Speed(Function),
    /// Prescribed coordinate, rad or m; the same.
    Position(Function),
    /// Prescribed torque, N m, or force, N, on B along the coordinate, and its reaction on A.
    Effort(Function),
}

impl Motor {
    /// Whether the motor drives its joint at time `t`, s: one of effort does not where that is zero.
    pub fn is_on(&self, t: f64) -> bool {
        match self {
            Motor::Speed(_) | Motor::Position(_) => true,
            Motor::Effort(effort) => effort.at(t) != 0.0,
        }
    }
}

/// A joint between two bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name.
    pub name: String,
    /// Kind of the joint.
    pub kind: JointKind,
    /// Ids of bodies A and B.
    pub bodies: [u32; 2],
    /// The frame on A, in A's principal frame.
    pub frame_a: Pose,
    /// The frame on B, in B's principal frame.
    pub frame_b: Pose,
    /// Length over time, m (distance and revolute_spherical); a joint whose length varies is a linear actuator.
    pub length: Function,
    /// Minimum and maximum coordinate, rad for an angle, m for a distance.
    pub limits: Option<[f64; 2]>,
    /// Motor of the coordinate.
    pub motor: Option<Motor>,
    /// Maximum torque, N m, or force, N, over time of a motor of prescribed rate or coordinate, at least 0; any effort without it.
    pub max_effort: Option<Function>,
    /// Time from which it acts, s, inclusive.
    pub from: f64,
    /// Time until which it acts, s, exclusive.
    pub until: f64,
    /// Whether the two bodies touch each other while it acts.
    pub collides: bool,
}

/// Along or about what a spring acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpringKind {
    /// Along the line between two points.
    Line,
    /// On the offset of two points that shall be one, and on its rate, in all directions: a bushing.
    Point,
    /// About the z axis of two frames.
    Angle,
}

/// A spring and damper between two bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// Name.
    pub name: String,
    /// Ids of bodies A and B.
    pub bodies: [u32; 2],
    /// The frame on A, in A's principal frame; all but springs about an axis use the frame's origin alone.
    pub frame_a: Pose,
    /// The frame on B, in B's principal frame.
    pub frame_b: Pose,
    /// Along or about what it acts.
    pub kind: SpringKind,
    /// Stiffness, N/m or N m/rad.
    pub stiffness: f64,
    /// Damping, N s/m or N m s/rad.
    pub damping: f64,
    /// Free length, m, or free angle, rad.
    pub rest: f64,
    /// Additional force, N, or torque, N m, over time; positive pulls B towards A, or turns B back about z.
    pub preload: Function,
    /// Time from which it acts, s, inclusive.
    pub from: f64,
    /// Time until which it acts, s, exclusive.
    pub until: f64,
}

/// The reaction, coordinate and constraint violation of a joint in the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct JointState {
    /// Reaction force of B on A, N, in the joint's frame on A.
    pub force: DVec3,
    /// Reaction torque of B on A, N m, about the origin of the joint's frame on A and in that frame.
    pub torque: DVec3,
    /// The same force, N, world.
    pub force_world: DVec3,
    /// The same torque, N m, about the same origin, world.
    pub torque_world: DVec3,
    /// Coordinate: angle, rad, unwrapped over full turns, or distance, m.
    pub coordinate: f64,
    /// Rate of the coordinate, rad/s or m/s.
    pub rate: f64,
    /// The force on A in the step before, N, world.
    pub force_before: DVec3,
    /// Constraint violation: the maximum |Ψ| of the joint's rows, locked and driven, and what is beyond its limits, m or rad.
    pub violation: f64,
    /// Sign of the effort of a motor that was at its maximum; 0 otherwise.
    pub motor_side: f64,
    /// Whether the minimum and the maximum limit held in the last step.
    pub held: [bool; 2],
    /// Torque, N m, or force, N, of what drives the joint on B along the coordinate: a motor, or a length that changes.
    pub effort: f64,
    /// The work that this has done so far, J.
    pub work: f64,
}

/// The force and coordinate of a spring in the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SpringState {
    /// Force, N, or torque, N m; positive pulls B towards A, or turns B back about z.
    pub force: f64,
    /// The force in the step before, N or N m.
    pub force_before: f64,
    /// Length, m, or angle, rad, unwrapped over full turns.
    pub coordinate: f64,
    /// The work that changes of the preload have done so far, J.
    pub work: f64,
}

/// A row: a scalar constraint `Ψ = 0` between two bodies, in the world frame; [the module](self) has `dΨ/dt`.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Row {
    /// Ids of bodies A and B.
    pub bodies: [u32; 2],
    /// l: coefficient of the relative velocity, unit or zero.
    pub linear: DVec3,
    /// a_A: coefficient of A's angular velocity, m (lengths) or 1 (angles).
    pub angular_a: DVec3,
    /// a_B: coefficient of B's angular velocity, m (lengths) or 1 (angles).
    pub angular_b: DVec3,
    /// Ψ, m or rad, of the poses at the step's start and the prescribed functions of time at its end.
    pub psi: f64,
    /// Prescribed dΨ/dt, m/s or rad/s.
    pub rate: f64,
    /// Compliance divided by the squared step size, 1/kg or 1/(kg m²); zero for a locked motion.
    pub softness: f64,
}

impl Row {
    /// dΨ/dt, m/s or rad/s, from the velocities of A and B.
    #[inline]
    pub fn speed(&self, a: Twist, b: Twist) -> f64 {
        self.linear.dot(b.v - a.v) + self.angular_b.dot(b.w) - self.angular_a.dot(a.w)
    }
    /// The speeds that two bodies have by turning, at the arms of the row, and against each other, m/s or rad/s: summed, whatever their directions.
    pub fn speeds(&self, a: Twist, b: Twist) -> f64 {
        let turning = self.angular_a.length() * a.w.length() + self.angular_b.length() * b.w.length();
        turning + self.linear.length() * (b.v - a.v).length()
    }

    /// The row of -Ψ.
    pub fn reversed(&self) -> Row {
        let Row { bodies, linear, angular_a, angular_b, psi, rate, softness } = *self;
        Row { bodies, linear: -linear, angular_a: -angular_a, angular_b: -angular_b, psi: -psi, rate: -rate, softness }
    }

    /// dΨ/dt, m/s or rad/s, from the velocities of all bodies (n_bodies).
    #[inline]
    pub fn speed_in(&self, motion: &[Twist]) -> f64 {
        let [a, b] = self.bodies.map(|b| motion[b as usize]);
        self.speed(a, b)
    }
}

/// The frames of a joint or a spring on its bodies A and B, world.
pub struct Frames {
    /// Frame on A, world.
    pub a: Pose,
    /// Frame on B, world.
    pub b: Pose,
    /// From the centres of mass of A and B to the frames' origins, m.
    arm: [DVec3; 2],
}

impl Frames {
    /// The frames in the world, from the poses of A and B, world, and the frames on A and B, principal frames.
    pub fn of([a, b]: [Pose; 2], frame_a: &Pose, frame_b: &Pose) -> Frames {
        let (fa, fb) = (a.place(frame_a), b.place(frame_b));
        Frames { arm: [fa.position - a.position, fb.position - b.position], a: fa, b: fb }
    }

    /// Reaction force, N, and torque, N m, on A of `rows` with the multipliers `lambda`, N s or N m s, over a step `h`, s; world, the torque
    /// about the origin of the frame on A.
    pub fn reaction(&self, rows: &[Row], lambda: &[f64], h: f64) -> (DVec3, DVec3) {
        let sum =
            |part: &dyn Fn(&Row) -> DVec3| rows.iter().zip(lambda).map(|(r, l)| part(r) * (-l / h)).sum::<DVec3>();
        let force = sum(&|r| r.linear);
        let torque = sum(&|r| r.angular_a) - self.arm[0].cross(force);
        (force, torque)
    }

    /// From the centres of mass of A and B to the frames' origins, m.
    pub fn arms(&self) -> [DVec3; 2] {
        self.arm
    }

    /// From the origin of A's frame to that of B's, m.
    pub fn offset(&self) -> DVec3 {
        self.b.position - self.a.position
    }

    /// Angle from A's x to B's x about A's z, rad, in (−π, π].
    fn angle(&self) -> f64 {
        let x = self.b.orientation * DVec3::X;
        x.dot(self.a.orientation * DVec3::Y).atan2(x.dot(self.a.orientation * DVec3::X))
    }

    /// Row of the offset along a direction that is fixed to A.
    fn along(&self, direction: DVec3) -> Row {
        Row {
            linear: direction,
            angular_a: (self.arm[0] + self.offset()).cross(direction),
            angular_b: self.arm[1].cross(direction),
            psi: self.offset().dot(direction),
            ..Row::default()
        }
    }

    /// Row of the cosine between an axis of A and one of B, which is 0 where they are perpendicular.
    fn perpendicular(&self, of_a: DVec3, of_b: DVec3) -> Row {
        let (a, b) = (self.a.orientation * of_a, self.b.orientation * of_b);
        let axis = b.cross(a);
        Row { angular_a: axis, angular_b: axis, psi: a.dot(b), ..Row::default() }
    }

    /// Row of the distance between the origins; along A's z where they coincide.
    fn distance(&self) -> Row {
        let d = self.offset();
        let length = d.length();
        let direction = if length > 1e-12 { d / length } else { self.a.orientation * DVec3::Z };
        Row { psi: length, ..self.along(direction) }
    }

    /// Row of the rotation of B relative to A about A's z.
    fn about(&self) -> Row {
        let z = self.a.orientation * DVec3::Z;
        Row { angular_a: z, angular_b: z, psi: self.angle(), ..Row::default() }
    }
}

impl JointKind {
    /// Kind of the joint's coordinate; none for kinds of joints without a coordinate.
    pub fn coordinate(self) -> Option<Coordinate> {
        match self {
            JointKind::Revolute | JointKind::Cylindrical => Some(Coordinate::Angle),
            JointKind::Prismatic => Some(Coordinate::Slide),
            JointKind::Distance | JointKind::RevoluteSpherical => Some(Coordinate::Length),
            _ => None,
        }
    }
}

/// The kind of a joint's coordinate, on which motors and limits act: a free motion, or the length of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Angle of B relative to A about z, rad.
    Angle,
    /// Distance of B's origin from A's along z, m.
    Slide,
    /// Distance between the origins, m.
    Length,
}

impl Joint {
    /// The pair of bodies that do not touch each other while the joint acts, the lower id first; none where they do.
    pub fn exclusion(&self) -> Option<[u32; 2]> {
        let [a, b] = self.bodies;
        (!self.collides).then_some([a.min(b), a.max(b)])
    }

    /// Whether the joint acts at a time, s.
    pub fn acts(&self, t: f64) -> bool {
        t >= self.from && t < self.until
    }

    /// The coordinate at which equal limits lock the joint, rad or m. Those of a joint that a motor of prescribed rate or coordinate drives
    /// lock nothing: they stay unilateral.
    pub fn locked_at(&self) -> Option<f64> {
        let is_driven = matches!(self.motor, Some(Motor::Speed(_) | Motor::Position(_)));
        self.limits.filter(|[lo, hi]| lo == hi && !is_driven).map(|[at, _]| at)
    }

    /// Whether the joint has the length [`Joint::length`]; with limits it has any between them, as a rope.
    pub fn has_length(&self) -> bool {
        self.kind.coordinate() == Some(Coordinate::Length) && self.limits.is_none()
    }

    /// Append the rows of the locked motions and of a motor of prescribed rate or coordinate to `rows`. `f` are the frames at the step's
    /// start, `known` is the joint's state in the last step, and `t` the time at the end of the step `h`, s.
    pub fn rows(&self, f: &Frames, known: &JointState, (t, h): (f64, f64), rows: &mut Vec<Row>) {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        let axes = [x, y, z].map(|e| f.a.orientation * e);
        let first = rows.len();
        match self.kind {
            JointKind::Spherical | JointKind::Revolute | JointKind::Universal | JointKind::Fixed => {
                rows.extend(axes.map(|e| f.along(e)));
            }
            JointKind::Prismatic | JointKind::Cylindrical => rows.extend([f.along(axes[0]), f.along(axes[1])]),
            JointKind::PointOnPlane => rows.push(f.along(axes[2])),
            JointKind::Distance | JointKind::RevoluteSpherical => {
                rows.extend(self.has_length().then(|| self.fixed_length(f, t)));
                rows.extend((self.kind == JointKind::RevoluteSpherical).then(|| f.along(axes[2])));
            }
        }
        match self.kind {
            JointKind::Revolute | JointKind::Cylindrical => rows.extend([f.perpendicular(x, z), f.perpendicular(y, z)]),
            JointKind::Fixed | JointKind::Prismatic => {
                rows.extend([f.perpendicular(x, z), f.perpendicular(y, z), f.perpendicular(x, y)]);
            }
            JointKind::Universal => rows.push(f.perpendicular(x, y)),
            _ => {}
        }
        match (&self.motor, self.kind.coordinate()) {
            (Some(Motor::Speed(speed)), Some(c)) => {
                let rate = self.rate_within_limits(speed.at(t), self.coordinate(f, known), h);
                rows.push(Row { psi: 0.0, rate, ..self.free_row(f, c) });
            }
            (Some(Motor::Position(goal)), Some(c)) => {
                let row = self.free_row(f, c);
                rows.push(Row { psi: self.coordinate(f, known) - self.within_limits(goal.at(t)), ..row });
            }
            (_, Some(c)) => {
                let at = self.locked_at().into_iter();
                rows.extend(at.map(|at| Row { psi: self.coordinate(f, known) - at, ..self.free_row(f, c) }));
            }
            (_, None) => {}
        }
        for row in &mut rows[first..] {
            row.bodies = self.bodies;
        }
    }

    /// Whether a motor or a length that changes drives the joint.
    pub fn is_driven(&self) -> bool {
        self.motor.is_some() || self.is_actuator()
    }

    /// Whether the length of the joint changes.
    fn is_actuator(&self) -> bool {
        self.has_length() && !matches!(self.length, Function::Constant(_))
    }

    /// Whether row `k` of the `n` rows of [`Joint::rows`] is that of a motor of prescribed rate or coordinate, or of a length that changes.
    pub fn drives(&self, k: usize, n: usize) -> bool {
        let has_motor_row = matches!(self.motor, Some(Motor::Speed(_) | Motor::Position(_)));
        has_motor_row && k + 1 == n || self.is_actuator() && k == 0
    }

    /// Violation |Ψ|, m or rad, of `row` at the step's start, and whether it is the row of a motor, which locks no motion. `row` is row `k`
    /// of the `n` rows of [`Joint::rows`] and has what is prescribed at the step's end `t_end`, s; the violation is that of what is
    /// prescribed at the step's start `t`, s.
    pub fn error(&self, row: &Row, k: usize, n: usize, t: f64, t_end: f64) -> (f64, bool) {
        let is_last = k + 1 == n;
        let has_length = self.has_length() && k == 0;
        let (change, is_motor) = match &self.motor {
            Some(Motor::Position(goal)) if is_last => (self.within_limits(goal.at(t_end)) - goal.at(t), true),
            Some(Motor::Speed(_)) if is_last => (0.0, true),
            _ if has_length => (self.length.at(t_end) - self.length.at(t), false),
            _ => (0.0, false),
        };
        ((row.psi + change).abs(), is_motor)
    }

    /// How far a coordinate is beyond the limits, rad or m.
    pub fn beyond_limits(&self, at: f64) -> f64 {
        let limits = self.limits.filter(|_| self.locked_at().is_none());
        limits.map_or(0.0, |[lo, hi]| (lo - at).max(at - hi).max(0.0))
    }

    /// How far a coordinate is from the maximum limit, or from the minimum one; negative beyond. m or rad
    pub fn room(&self, at: f64, is_most: bool) -> f64 {
        let [least, most] = self.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        if is_most { most - at } else { at - least }
    }

    /// The row of a limit, Ψ the room that is left, from that of the free motion ([`Joint::free_row`]) at the coordinate `at`.
    pub fn limit_row(&self, free: &Row, at: f64, is_most: bool) -> Row {
        let row = if is_most { free.reversed() } else { *free };
        Row { psi: self.room(at, is_most), ..row }
    }

    /// What a motor of any effort prescribes ends at the limits, which it cannot pass: it would tear the joint. With a maximum effort it presses.
    fn within_limits(&self, goal: f64) -> f64 {
        self.limits.filter(|_| self.max_effort.is_none()).map_or(goal, |[lo, hi]| goal.clamp(lo, hi))
    }

    /// The rate of a motor of prescribed rate and any effort, which ends at the limits within a step `h`, s, from a coordinate `at`, rad or m.
    fn rate_within_limits(&self, rate: f64, at: f64, h: f64) -> f64 {
        let limits = self.limits.filter(|_| self.max_effort.is_none());
        limits.map_or(rate, |[lo, hi]| rate.clamp(((lo - at) / h).min(0.0), ((hi - at) / h).max(0.0)))
    }

    /// What the motor prescribes at a time `t`, s, and what the state `now` at that time has instead: rates, rad/s or m/s, or coordinates,
    /// rad or m. None for a motor of prescribed effort, and without a motor.
    pub fn driven(&self, now: &JointState, t: f64) -> Option<[f64; 2]> {
        match &self.motor {
            Some(Motor::Speed(speed)) => Some([speed.at(t), now.rate]),
            Some(Motor::Position(goal)) => Some([goal.at(t), now.coordinate]),
            _ => None,
        }
    }

    fn fixed_length(&self, f: &Frames, t: f64) -> Row {
        let row = f.distance();
        Row { psi: row.psi - self.length.at(t), ..row }
    }

    /// Row along the joint's coordinate, of the kind `coordinate`, on which limits and efforts of motors act; Ψ is the coordinate, rad
    /// or m, not unwrapped.
    pub fn free_row(&self, f: &Frames, coordinate: Coordinate) -> Row {
        let row = match coordinate {
            Coordinate::Angle => f.about(),
            Coordinate::Slide => f.along(f.a.orientation * DVec3::Z),
            Coordinate::Length => f.distance(),
        };
        Row { bodies: self.bodies, ..row }
    }

    /// The coordinate, rad or m, unwrapped over full turns from that of the last step's state `known`; 0 for a joint without a coordinate.
    pub fn coordinate(&self, f: &Frames, known: &JointState) -> f64 {
        match self.kind.coordinate() {
            Some(Coordinate::Angle) => unwrapped(f.angle(), known.coordinate),
            Some(c) => self.free_row(f, c).psi,
            None => 0.0,
        }
    }

    /// Maximum torque, N m, or force, N, at a time `t`, s, of a motor of prescribed rate or coordinate; none without one.
    pub fn max_effort(&self, t: f64) -> Option<f64> {
        let is_driven = matches!(self.motor, Some(Motor::Speed(_) | Motor::Position(_)));
        self.max_effort.as_ref().filter(|_| is_driven).map(|most| most.at(t).max(0.0))
    }

    /// The rate, m/s or rad/s, that the motor prescribes from time `t` to `t_end`, s, and how far the coordinate is ahead of what it prescribes at
    /// `t`, m or rad: 0 for a motor of prescribed rate. `row` is its row, with what is prescribed at `t_end`.
    pub fn prescribed(&self, row: &Row, t: f64, t_end: f64) -> [f64; 2] {
        match &self.motor {
            Some(Motor::Position(goal)) => {
                let way = goal.at(t_end) - goal.at(t);
                [way / (t_end - t), row.psi + way]
            }
            _ => [row.rate, 0.0],
        }
    }

    /// The state of the joint with the frames `f` at a time `t`, s, before any step, where its bodies have the velocities `motion`, world: no force is
    /// known.
    pub fn at_start(&self, f: &Frames, t: f64, motion: [Twist; 2]) -> JointState {
        let coordinate = self.coordinate(f, &JointState::default());
        let mut now = JointState { coordinate, ..JointState::default() };
        if let Some(c) = self.kind.coordinate() {
            now.rate = self.free_row(f, c).speed(motion[0], motion[1]);
        }
        if self.acts(t) {
            let mut rows = vec![];
            self.rows(f, &now, (t, 1.0), &mut rows);
            let errors = rows.iter().enumerate().map(|(k, row)| self.error(row, k, rows.len(), t, t).0);
            now.violation = errors.fold(self.beyond_limits(coordinate), f64::max);
        }
        now
    }

    /// Torque, N m, or force, N, of the motor on B along the coordinate at a time, s; 0 without a motor of prescribed effort.
    pub fn effort(&self, t: f64) -> f64 {
        match &self.motor {
            Some(Motor::Effort(effort)) => effort.at(t),
            _ => 0.0,
        }
    }
}

/// The angle nearest to `before` of those that differ from `angle` by full turns, rad.
fn unwrapped(angle: f64, before: f64) -> f64 {
    let n_turns = ((before - angle) / std::f64::consts::TAU).round();
    angle + n_turns * std::f64::consts::TAU
}

impl Spring {
    /// Whether the spring acts at a time, s.
    pub fn acts(&self, t: f64) -> bool {
        t >= self.from && t < self.until
    }

    /// Force, N, or torque, N m, of stiffness and preload at a length, m, or angle, rad, `psi` and a time `t`, s; positive pulls B
    /// towards A, or turns B back about z.
    pub fn tension(&self, psi: f64, t: f64) -> f64 {
        self.stiffness * (psi - self.rest) + self.preload.at(t)
    }

    /// Rows along which the spring acts, one, or three of a point; Ψ is the length, m, a component of the offset, m, or the angle, rad,
    /// unwrapped from that of the last step's state `known`.
    pub fn rows(&self, f: &Frames, known: &SpringState) -> impl Iterator<Item = Row> {
        let rows = match self.kind {
            SpringKind::Line => [Some(f.distance()), None, None],
            SpringKind::Point => [DVec3::X, DVec3::Y, DVec3::Z].map(|e| Some(f.along(e))),
            SpringKind::Angle => {
                let row = f.about();
                [Some(Row { psi: unwrapped(row.psi, known.coordinate), ..row }), None, None]
            }
        };
        let bodies = self.bodies;
        rows.into_iter().flatten().map(move |row| Row { bodies, ..row })
    }

    /// Length, m, or angle, rad, of values Ψ of the rows.
    pub fn coordinate(&self, psi: impl Iterator<Item = f64>) -> f64 {
        match self.kind {
            SpringKind::Point => psi.map(|x| x * x).sum::<f64>().sqrt(),
            _ => psi.sum(),
        }
    }
}
