//! Joints, motors and springs between named bodies.

use super::*;
use crate::joint::Motor;

/// By what a joint may begin beyond its limits, degrees or m, or off its plane: the rounding of positions that are written by hand.
const ROUNDING: f64 = 1e-6;

impl Builder<'_> {
    /// Id of a body by name; the fixed body `world` is added at its first use.
    pub(super) fn find(&mut self, key: &str, name: &str) -> Result<u32, Fault> {
        if let Some(id) = self.model.body_names.get(name) {
            return Ok(id);
        }
        if name == "world" {
            let class = self.class("world");
            let body = NewBody {
                class,
                place: Pose::default(),
                velocity: DVec3::ZERO,
                angular_velocity: DVec3::ZERO,
                fixed: true,
                mass: None,
                inertia: None,
                center: None,
                appears: 0.0,
                moves: 0.0,
            };
            let id = self.add(body, vec![]).expect("a fixed body needs no mass");
            self.model.body_names.insert("world".into(), id);
            return Ok(id);
        }
        let mut known: Vec<&str> = self.model.body_names.iter().map(|(name, _)| name).collect();
        if self.model.body_names.get("world").is_none() {
            known.push("world");
        }
        Err(self.doc.unknown(key, "body", name, &known))
    }

    pub(super) fn ends(&mut self, key: &str, a: &str, b: &str) -> Result<[u32; 2], Fault> {
        let pair = [self.find(&format!("{key}.a"), a)?, self.find(&format!("{key}.b"), b)?];
        if pair[0] == pair[1] {
            return Err(self.doc.fault(&format!("{key}.b"), format!("connects `{a}` to itself")));
        }
        if pair.iter().all(|b| !self.moves_ever(*b)) {
            return Err(self.doc.fault(&format!("{key}.b"), format!("`{a}` and `{b}` are both held in place")));
        }
        Ok(pair)
    }

    /// A world pose in a body's principal frame.
    pub(super) fn in_body(&self, body: u32, world: Pose) -> Pose {
        let b = body as usize;
        Pose { position: self.state.position[b], orientation: self.state.orientation[b] }.inverse().place(&world)
    }

    pub(super) fn interval(
        &self,
        key: &str,
        from: Option<f64>,
        until: Option<f64>,
        begins: f64,
    ) -> Result<[f64; 2], Fault> {
        let (from, until) = (from.unwrap_or(begins), until.unwrap_or(f64::INFINITY));
        if !(from >= 0.0) || !(until > from) {
            return Err(self.doc.fault(
                &format!("{key}.until"),
                format!("acts from {from} s until {until} s, expected the earlier time first and not before 0 s"),
            ));
        }
        Ok([from, until])
    }

    pub(super) fn joint(&mut self, key: &str, file: &JointFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let at = |part: &str| format!("{key}.{part}");
        if self.joint_names.find(&self.model.joints, |j| &j.name, &file.name).is_some() {
            return Err(doc.fault(&at("name"), format!("there is a joint `{}` already", file.name)));
        }
        let bodies = self.ends(key, &file.a, &file.b)?;
        finite(doc, &at("position"), &file.position)?;
        let z = direction(doc, &at("axis"), file.axis)?;
        let orientation = match file.axis_x {
            Some(x) => {
                let x = direction(doc, &at("axis_x"), x)?;
                let x = x.reject_from_normalized(z).try_normalize().filter(|_| x.dot(z).abs() < 0.999).ok_or_else(
                    || doc.fault(&at("axis_x"), "is along `axis`: expected a direction perpendicular to it"),
                )?;
                DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z))
            }
            None => DQuat::from_rotation_arc(DVec3::Z, z),
        };
        let pa = DVec3::from(file.position);
        let pb = file.position_b.map_or(pa, DVec3::from);
        finite(doc, &at("position_b"), &pb.to_array())?;
        let two_points =
            matches!(file.kind, JointKind::Distance | JointKind::RevoluteSpherical | JointKind::PointOnPlane);
        if file.position_b.is_some() && !two_points {
            return Err(
                doc.fault(&at("position_b"), "is only for distance, revolute_spherical and point_on_plane joints")
            );
        }
        let long = matches!(file.kind, JointKind::Distance | JointKind::RevoluteSpherical);
        let length = self.length(key, file, (long, (pb - pa).length()))?;
        // A rope may begin anywhere within its length.
        let is_rope = file.kind == JointKind::Distance && file.limits.is_some() && file.motor.is_none();
        if long && !is_rope && !(length.at(0.0) > 0.0) {
            let (part, says) = match file.length {
                Some(_) => ("length", "is not above 0 at the start"),
                None => ("position_b", "the joint's two points coincide: it has no length"),
            };
            return Err(doc.fault(&at(part), says));
        }
        let [from, until] = self.interval(key, file.from, file.until, begins)?;
        let [least, _] = length.range([from, until]);
        if long && least < 0.0 {
            let message = format!("comes down to {least:.4} m while the joint acts, expected lengths from 0");
            return Err(doc.fault(&at("length"), message));
        }
        self.check_plane(key, file, (pb - pa, z), from <= 0.0)?;
        let (motor, max_effort) = match &file.motor {
            Some(m) => (Some(self.motor(&at("motor"), file.kind, m)?), self.max_effort(&at("motor"), file.kind, m)?),
            None => (None, None),
        };
        let orientation_b = self.shaft(key, file, orientation)?;
        let limits = file.limits.map(|limits| {
            let begins_at = if long { (pb - pa).length() } else { 0.0 };
            self.limits(&at("limits"), file.kind, limits, (from <= 0.0).then_some(begins_at))
        });
        let limits = limits.transpose()?;
        if let (Some(Motor::Position(motion)), Some(limits), None) = (&motor, limits, &max_effort) {
            self.check_reach(&at("motor"), file.kind, (motion.range([from, until]), limits));
        }
        let joint = Joint {
            name: file.name.clone(),
            kind: file.kind,
            bodies,
            frame_a: self.in_body(bodies[0], Pose { position: pa, orientation }),
            frame_b: self.in_body(bodies[1], Pose { position: pb, orientation: orientation_b }),
            length,
            limits,
            motor,
            max_effort,
            from,
            until,
            collides: file.collide,
        };
        self.keys.joints.insert(self.model.joints.len() as u32, key.into());
        self.model.joints.push(joint);
        Ok(())
    }

    /// Length over time of a joint, m, that is `now` at the start; of those that are not `long` it has no meaning.
    fn length(&self, key: &str, file: &JointFile, (long, now): (bool, f64)) -> Result<Function, Fault> {
        let at = |part: &str| format!("{key}.{part}");
        let length = match &file.length {
            Some(f) if long => self.function(&at("length"), f)?,
            Some(_) => return Err(self.doc.fault(&at("length"), "is only for distance and revolute_spherical joints")),
            None => Function::Constant(now),
        };
        if file.length.is_some() && file.limits.is_some() {
            return Err(self.doc.fault(&at("limits"), "bound the length that `length` gives: expected one of the two"));
        }
        Ok(length)
    }

    /// Check that the point on B, `way` from that on A, is in the plane through that on A across `z` of a joint that keeps it there; that of
    /// `point_on_plane` may come to it later.
    fn check_plane(&self, key: &str, file: &JointFile, (way, z): (DVec3, DVec3), at_start: bool) -> Result<(), Fault> {
        let height = way.dot(z).abs();
        match file.kind {
            JointKind::RevoluteSpherical if way.normalize().dot(z).abs() > 1e-6 => {
                let message = "is not perpendicular to the line between the joint's two points";
                Err(self.doc.fault(&format!("{key}.axis"), message))
            }
            JointKind::PointOnPlane if at_start && height > ROUNDING * (1.0 + way.length()) => {
                let message = format!("is {height:.6} m off the plane at the start");
                let hint = "the plane goes through `position`, perpendicular to `axis`";
                Err(self.doc.fault(&format!("{key}.position_b"), message).hint(hint))
            }
            _ => Ok(()),
        }
    }

    /// Orientation of a joint's frame on B, world, where that on A is `on_a`: the same, but for the shaft of a universal joint, whose pin is
    /// perpendicular to it and to the pin on A.
    fn shaft(&self, key: &str, file: &JointFile, on_a: DQuat) -> Result<DQuat, Fault> {
        let at = format!("{key}.axis_b");
        let Some(axis) = file.axis_b else { return Ok(on_a) };
        if file.kind != JointKind::Universal {
            return Err(self.doc.fault(&at, "is only for universal joints"));
        }
        let z = direction(self.doc, &at, axis)?;
        let pin_of_a = on_a * DVec3::X;
        let y = z.cross(pin_of_a).try_normalize().filter(|_| z.dot(pin_of_a).abs() < 0.999).ok_or_else(|| {
            self.doc
                .fault(&at, "is along the joint's pin on A, with which the shaft of B cannot turn")
                .hint("turn that pin with `axis_x`")
        })?;
        Ok(DQuat::from_mat3(&DMat3::from_cols(y.cross(z), y, z)))
    }

    fn motor(&self, key: &str, kind: JointKind, m: &MotorFile) -> Result<Motor, Fault> {
        let doc = self.doc;
        let rotates = matches!(kind, JointKind::Revolute | JointKind::Cylindrical);
        if !rotates && kind != JointKind::Prismatic {
            return Err(doc
                .fault(key, "only revolute, cylindrical and prismatic joints have motors")
                .hint("a distance joint becomes a linear actuator by its `length`"));
        }
        match (&m.speed, &m.motion, &m.torque, &m.force) {
            (Some(f), None, None, None) => Ok(Motor::Speed(self.function(&format!("{key}.speed"), f)?)),
            (None, Some(f), None, None) => Ok(Motor::Position(self.function(&format!("{key}.motion"), f)?)),
            (None, None, Some(f), None) if rotates => Ok(Motor::Effort(self.function(&format!("{key}.torque"), f)?)),
            (None, None, None, Some(f)) if !rotates => Ok(Motor::Effort(self.function(&format!("{key}.force"), f)?)),
            (None, None, Some(_), None) => {
                Err(doc.fault(&format!("{key}.torque"), "is for what turns").hint("a motor that slides has a `force`"))
            }
            (None, None, None, Some(_)) => {
                Err(doc.fault(&format!("{key}.force"), "is for what slides").hint("a motor that turns has a `torque`"))
            }
            _ => {
                let effort = if rotates { "torque" } else { "force" };
                Err(doc.fault(key, format!("needs exactly one of `speed`, `motion` and `{effort}`")))
            }
        }
    }

    /// Maximum torque, N m, or force, N, over time of a motor.
    fn max_effort(&self, key: &str, kind: JointKind, m: &MotorFile) -> Result<Option<Function>, Fault> {
        let doc = self.doc;
        let (own, other, moves) = match kind {
            JointKind::Prismatic => (("max_force", &m.max_force), ("max_torque", &m.max_torque), "slides"),
            _ => (("max_torque", &m.max_torque), ("max_force", &m.max_force), "turns"),
        };
        if other.1.is_some() {
            let unlike = if moves == "turns" { "slides" } else { "turns" };
            let message = format!("is for what {unlike}");
            return Err(doc
                .fault(&format!("{key}.{}", other.0), message)
                .hint(format!("a motor that {moves} has a `{}`", own.0)));
        }
        let Some(file) = own.1 else { return Ok(None) };
        let key = format!("{key}.{}", own.0);
        if let Some(given) = m.torque.as_ref().map(|_| "torque").or(m.force.as_ref().map(|_| "force")) {
            return Err(doc
                .fault(&key, "is for motors by `speed` or `motion`")
                .hint(format!("one by `{given}` gives what that says")));
        }
        let most = self.function(&key, file)?;
        let least = most.least();
        if least < 0.0 {
            let message = format!("goes down to {least}, expected a size, which is not negative");
            return Err(doc.fault(&key, message).hint("it bounds the motor in both directions"));
        }
        Ok(Some(most))
    }

    /// Warn of a motor by `motion` without a maximum that goes beyond the limits of its joint, rad or m.
    fn check_reach(&mut self, key: &str, kind: JointKind, (motion, limits): ([f64; 2], [f64; 2])) {
        let is_angle = kind != JointKind::Prismatic;
        let is_beyond = motion[0] < limits[0] - ROUNDING || motion[1] > limits[1] + ROUNDING;
        if !is_beyond {
            return;
        }
        let (unit, most) = if is_angle { ("rad", "max_torque") } else { ("m", "max_force") };
        let [[a, b], [lo, hi]] = [motion, limits];
        let message = format!(
            "goes from {a:.4} to {b:.4} {unit}, beyond the joint's `limits` of {lo:.4} and {hi:.4} {unit}, where it stops"
        );
        let doubt = self.doc.fault(&format!("{key}.motion"), message);
        self.warnings.push(doubt.hint(format!("with a `{most}` it presses against them")).to_string());
    }

    /// Limits of a joint's coordinate, rad or m, which must hold `begins_at`, the coordinate with which it begins.
    fn limits(
        &self,
        key: &str,
        kind: JointKind,
        [lo, hi]: [f64; 2],
        begins_at: Option<f64>,
    ) -> Result<[f64; 2], Fault> {
        if kind.coordinate().is_none() {
            return Err(self.doc.fault(key, "this kind of joint has no coordinate to limit"));
        }
        if !(lo <= hi) {
            return Err(self.doc.fault(key, format!("run from {lo} to {hi}, expected the smaller first")));
        }
        if let Some(at) = begins_at.filter(|at| *at < lo - ROUNDING || *at > hi + ROUNDING) {
            let message = format!("run from {lo} to {hi}, but the joint begins at {at:.6}");
            return Err(self.doc.fault(key, message).hint("angles and slides count from the start, lengths from 0"));
        }
        let is_angle = matches!(kind, JointKind::Revolute | JointKind::Cylindrical);
        Ok(if is_angle { [lo.to_radians(), hi.to_radians()] } else { [lo, hi] })
    }

    pub(super) fn spring(&mut self, key: &str, file: &SpringFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let at = |part: &str| format!("{key}.{part}");
        if self.spring_names.find(&self.model.springs, |s| &s.name, &file.name).is_some() {
            return Err(doc.fault(&at("name"), format!("there is a spring `{}` already", file.name)));
        }
        let bodies = self.ends(key, &file.a, &file.b)?;
        finite(doc, &at("position"), &file.position)?;
        not_negative(doc, &at("stiffness"), file.stiffness)?;
        not_negative(doc, &at("damping"), file.damping)?;
        let pa = DVec3::from(file.position);
        let pb = file.position_b.map_or(pa, DVec3::from);
        finite(doc, &at("position_b"), &pb.to_array())?;
        let orientation = match file.about {
            Some(axis) => DQuat::from_rotation_arc(DVec3::Z, direction(doc, &at("about"), axis)?),
            None => DQuat::IDENTITY,
        };
        let kind = match file.about {
            Some(_) => SpringKind::Angle,
            None if pb == pa => SpringKind::Point,
            None => SpringKind::Line,
        };
        // Two points on each other have no line to act along, but a spring that pulls them together needs none.
        if kind == SpringKind::Point {
            let fault =
                |part: &str, says: &str| doc.fault(&at(part), format!("the spring's two points coincide: {says}"));
            match (file.rest, &file.preload) {
                (Some(0.0), None) => {}
                (Some(0.0), Some(_)) => return Err(fault("preload", "it has no line along which to pull")),
                (Some(_), _) => return Err(fault("rest", "it has no line along which to push them apart")),
                (None, _) => {
                    return Err(fault("position_b", "it has no line to act along")
                        .hint("give the point on B as `position_b`, or `rest: 0` for a spring that pulls the two points together"));
                }
            }
        }
        let rest = match (file.rest, file.about) {
            (Some(degrees), Some(_)) => degrees.to_radians(),
            (Some(length), None) => length,
            (None, Some(_)) => 0.0,
            (None, None) => (pb - pa).length(),
        };
        finite(doc, &at("rest"), &[rest])?;
        let preload = match &file.preload {
            Some(f) => self.function(&at("preload"), f)?,
            None => Function::Constant(0.0),
        };
        let [from, until] = self.interval(key, file.from, file.until, begins)?;
        self.keys.springs.insert(self.model.springs.len() as u32, key.into());
        self.model.springs.push(Spring {
            name: file.name.clone(),
            bodies,
            frame_a: self.in_body(bodies[0], Pose { position: pa, orientation }),
            frame_b: self.in_body(bodies[1], Pose { position: pb, orientation }),
            kind,
            stiffness: file.stiffness,
            damping: file.damping,
            rest,
            preload,
            from,
            until,
        });
        Ok(())
    }
}
