//! The vehicle of Negrut et al. 2012, sections 5.1 and 5.2: a chassis on two tracks of shoes, each with rollers, an idler and a sprocket.
//!
//! The paper drops a ring of shoes on the wheels and tightens it with the idler. Here the ring is laid along the belt around
//! the wheels, and the idler is moved until the last shoe meets the first: the track is tight and free of force at the start.

use super::parts::{DimensionError, Parts, body, joint, part, positive};
use crate::joint::JointKind;
use crate::model_file::{BoxFile, CylinderFile, FunctionFile, MotorFile, RotateFile, ShapeFile, SpringFile};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, TAU};

/// A tracked vehicle (Negrut et al. 2012, §5.1): a chassis on two tracks of shoes, each with rollers, an idler and a sprocket. The vehicle
/// heads along x, and its tracks touch the plane z = `position[2]` below the middle of the rollers.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TrackedVehicle {
    /// Name of the material of the wheels and the chassis.
    pub material: String,
    /// Name of the material of the shoes.
    pub shoe_material: String,
    /// Position, m, world: the middle of the rollers along x and y, the ground under the tracks along z.
    pub position: [f64; 3],
    /// Number of shoes of a track.
    pub shoes: usize,
    /// Distance of a shoe's two pins, m.
    pub pitch: f64,
    /// Mass of a shoe, kg.
    pub shoe_mass: f64,
    /// Width of a shoe, m.
    pub shoe_width: f64,
    /// Thickness of a shoe's plate, m.
    pub shoe_thickness: f64,
    /// Number of rollers of a track.
    pub rollers: usize,
    /// Radius of the rollers, m.
    pub roller_radius: f64,
    /// Distance between rollers, m.
    pub roller_distance: f64,
    /// Number of teeth of the sprocket; its radius follows from the pitch.
    pub teeth: usize,
    /// Radius of the idler, m.
    pub idler_radius: f64,
    /// Height of the idler's and the sprocket's axes over the rollers', m.
    pub wheel_height: f64,
    /// Distance from the last roller back to the sprocket's axis, m.
    pub sprocket_distance: f64,
    /// Mass of a roller, an idler or a sprocket, kg.
    pub wheel_mass: f64,
    /// Distance between the middles of the tracks, m.
    pub gauge: f64,
    /// Edge lengths of the chassis, m.
    pub chassis_size: [f64; 3],
    /// Mass of the chassis, kg.
    pub chassis_mass: f64,
    /// Whether the idler sits on a slide with a spring rather than on a fixed axle.
    pub idler_spring: bool,
    /// Stiffness of the idler's spring, N/m.
    pub idler_stiffness: f64,
    /// Damping of the idler's spring, N s/m.
    pub idler_damping: f64,
    /// Preload of the idler's spring, N, which tightens the track.
    pub idler_preload: f64,
    /// Torques on the left and on the right sprocket, N m, over time; positive drives forward.
    pub torque: [FunctionFile; 2],
}

impl Default for TrackedVehicle {
    fn default() -> TrackedVehicle {
        let torque = FunctionFile::Step { step: crate::model_file::StepFile { at: 1.0, before: 0.0, after: 100.0 } };
        TrackedVehicle {
            material: "steel".into(),
            shoe_material: "steel".into(),
            position: [0.0; 3],
            shoes: 61,
            pitch: 0.08,
            shoe_mass: 0.34,
            shoe_width: 0.3,
            shoe_thickness: 0.02,
            rollers: 5,
            roller_radius: 0.1,
            roller_distance: 0.28,
            teeth: 16,
            idler_radius: 0.18,
            wheel_height: 0.16,
            sprocket_distance: 0.36,
            wheel_mass: 15.0,
            gauge: 1.0,
            chassis_size: [1.5, 0.6, 0.3],
            chassis_mass: 200.0,
            idler_spring: false,
            idler_stiffness: 2e5,
            idler_damping: 2e3,
            idler_preload: 2000.0,
            torque: [torque.clone(), torque],
        }
    }
}

/// A wheel in the plane of a track: centre (x, z), m, and the radius of the pins around it, m.
#[derive(Clone, Copy, Debug)]
struct Circle {
    center: [f64; 2],
    radius: f64,
}

impl TrackedVehicle {
    /// The bodies, joints, springs and loads of a vehicle; `name` is the prefix of their names.
    ///
    /// # Errors
    /// A dimension that is out of range, or too few shoes to go round the wheels.
    pub(crate) fn build(&self, name: &str) -> Result<Parts, DimensionError> {
        self.check()?;
        let idler = self.place_idler()?;
        let mut parts = Parts::default();
        let [x, y, z] = self.position;
        let axle = z + self.shoe_thickness + self.roller_radius;
        let mut chassis =
            body(format!("{name}_chassis"), &format!("{name}_chassis"), &self.material, [x, y, 0.0], self.chassis_mass);
        chassis.position[2] = axle + self.wheel_height + 0.5 * self.chassis_size[2];
        chassis.shapes = Some(vec![part(
            ShapeFile { block: Some(BoxFile { size: self.chassis_size }), ..ShapeFile::default() },
            [0.0; 3],
            None,
        )]);
        // The hull does not rub on its own running gear.
        chassis.group = Some(format!("{name}_hull"));
        parts.bodies.push(chassis);
        for group in ["wheels", "shoes"] {
            parts.pass_through.push([format!("{name}_hull"), format!("{name}_{group}")]);
        }
        parts.pass_through.push([format!("{name}_wheels"), format!("{name}_wheels")]);
        for (side, at) in [("left", 0.5 * self.gauge), ("right", -0.5 * self.gauge)] {
            self.track(&mut parts, name, side, [x, y + at, axle], idler);
        }
        Ok(parts)
    }

    fn check(&self) -> Result<(), DimensionError> {
        positive(&[
            ("pitch", self.pitch),
            ("shoe_mass", self.shoe_mass),
            ("shoe_width", self.shoe_width),
            ("shoe_thickness", self.shoe_thickness),
            ("roller_radius", self.roller_radius),
            ("roller_distance", self.roller_distance),
            ("idler_radius", self.idler_radius),
            ("wheel_mass", self.wheel_mass),
            ("gauge", self.gauge),
            ("chassis_mass", self.chassis_mass),
            ("chassis_size", self.chassis_size.into_iter().fold(f64::INFINITY, f64::min)),
            ("sprocket_distance", self.sprocket_distance),
        ])?;
        if !(8..=200).contains(&self.teeth) {
            return Err(("teeth", format!("is {}, expected 8 to 200", self.teeth)));
        }
        if self.rollers == 0 || self.rollers > 50 {
            return Err(("rollers", format!("is {}, expected 1 to 50", self.rollers)));
        }
        if !(20..=1000).contains(&self.shoes) {
            return Err(("shoes", format!("is {}, expected 20 to 1000", self.shoes)));
        }
        Ok(())
    }

    /// x of a roller from the middle of all, m.
    fn roller_x(&self, k: usize) -> f64 {
        (k as f64 - 0.5 * (self.rollers - 1) as f64) * self.roller_distance
    }

    fn turns_belt(&self, roller: usize) -> bool {
        roller == 0 || roller + 1 == self.rollers
    }

    /// Height of a roller over the middle ones, m.
    fn roller_z(&self, k: usize) -> f64 {
        let r = self.roller_radius + 0.5 * self.shoe_thickness;
        if self.turns_belt(k) { r.hypot(0.5 * self.pitch) - r } else { 0.0 }
    }

    fn sprocket_x(&self) -> f64 {
        self.roller_x(0) - self.sprocket_distance
    }

    /// Radius of the sprocket's drum, m: shoes lie flat on it with their pins on the pitch circle.
    fn sprocket_radius(&self) -> f64 {
        0.5 * self.pitch / (std::f64::consts::PI / self.teeth as f64).tan() - 0.5 * self.shoe_thickness
    }

    /// The wheels of a track, from the rollers' middle; the sprocket is first, the idler last.
    fn circles(&self, idler: f64) -> Vec<Circle> {
        let half = 0.5 * self.shoe_thickness;
        let round = |r: f64| ((r + half).powi(2) + (0.5 * self.pitch).powi(2)).sqrt();
        let mut circles =
            vec![Circle { center: [self.sprocket_x(), self.wheel_height], radius: round(self.sprocket_radius()) }];
        circles.extend((0..self.rollers).map(|k| {
            // The belt turns on the first and the last roller: shoes need more room there, and the roller stands higher.
            let radius = if self.turns_belt(k) { round(self.roller_radius) } else { self.roller_radius + half };
            Circle { center: [self.roller_x(k), self.roller_z(k)], radius }
        }));
        circles.push(Circle { center: [idler, self.wheel_height], radius: round(self.idler_radius) });
        circles
    }

    /// Positions (x, z) of the pins of a track around the wheels, m, and the closure error of the ring along the belt, m: positive where
    /// the last link ends past the first pin.
    fn lay(&self, idler: f64) -> (Vec<[f64; 2]>, f64) {
        const SIDES: usize = 20_000;
        let circles = self.circles(idler);
        // The belt is the hull of the wheels: in each direction the farthest of them.
        let belt: Vec<[f64; 2]> = (0..SIDES)
            .map(|k| {
                let (s, c) = (FRAC_PI_2 - k as f64 * TAU / SIDES as f64).sin_cos();
                let far = |w: &Circle| w.center[0] * c + w.center[1] * s + w.radius;
                let w = circles.iter().max_by(|a, b| far(a).total_cmp(&far(b))).expect("a track has wheels");
                [w.center[0] + w.radius * c, w.center[1] + w.radius * s]
            })
            .collect();
        let distance = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
        // The ring closes from any start on the sprocket.
        let start = self.start_on_belt(&belt);
        let mut pins = vec![belt[start]];
        // `at` is the last pin, `here` where the rest of the belt's side k begins.
        let (mut at, mut here, mut k, mut travelled) = (belt[start], belt[start], start, 0usize);
        while pins.len() <= self.shoes && travelled < 2 * SIDES {
            let next = (k + 1) % SIDES;
            let there = belt[next];
            if distance(at, there) >= self.pitch {
                // Where the side leaves the circle of a pitch around the last pin.
                let (mut lo, mut hi) = (0.0, 1.0);
                for _ in 0..60 {
                    let t = 0.5 * (lo + hi);
                    let p = [here[0] + t * (there[0] - here[0]), here[1] + t * (there[1] - here[1])];
                    if distance(at, p) < self.pitch { lo = t } else { hi = t }
                }
                at = [here[0] + hi * (there[0] - here[0]), here[1] + hi * (there[1] - here[1])];
                here = at;
                pins.push(at);
                continue;
            }
            (k, here) = (next, there);
            travelled += 1;
        }
        let last = *pins.last().expect("there is a first pin");
        let turns = travelled as f64 - SIDES as f64;
        let closure = if turns.abs() < 50.0 {
            // Near the start: how far past it, along the belt.
            let ahead = belt[(start + 1) % SIDES];
            let side = distance(ahead, belt[start]).max(1e-300);
            ((last[0] - pins[0][0]) * (ahead[0] - pins[0][0]) + (last[1] - pins[0][1]) * (ahead[1] - pins[0][1])) / side
        } else {
            turns.signum() * distance(last, pins[0])
        };
        pins.truncate(self.shoes);
        (pins, closure)
    }

    /// A corner of the belt on the sprocket, as far round it as the belt goes.
    fn start_on_belt(&self, belt: &[[f64; 2]]) -> usize {
        let behind = |p: &[f64; 2]| p[0];
        (0..belt.len()).min_by(|a, b| behind(&belt[*a]).total_cmp(&behind(&belt[*b]))).unwrap_or(0)
    }

    /// x of the idler for which the ring closes, m.
    fn place_idler(&self) -> Result<f64, DimensionError> {
        let min = self.roller_x(self.rollers - 1) + 0.2 * self.roller_radius;
        let (mut lo, mut hi) = (min, min + self.shoes as f64 * self.pitch);
        // Too short a belt: the shoes go round more than once.
        if self.lay(lo).1 < 0.0 {
            let message = format!("is {}, too few to go round the wheels", self.shoes);
            return Err(("shoes", message));
        }
        for _ in 0..60 {
            let middle = 0.5 * (lo + hi);
            if self.lay(middle).1 > 0.0 { lo = middle } else { hi = middle }
        }
        Ok(lo)
    }

    /// One track: shoes, wheels and their joints. `at` is the middle of the rollers' axes.
    fn track(&self, parts: &mut Parts, name: &str, side: &str, at: [f64; 3], idler: f64) {
        let (pins, _) = self.lay(idler);
        let chassis = format!("{name}_chassis");
        let across = [0.0, 1.0, 0.0];
        let world = |p: [f64; 2]| [at[0] + p[0], at[1], at[2] + p[1]];
        for k in 0..self.shoes {
            let (p, q) = (pins[k], pins[(k + 1) % self.shoes]);
            let middle = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
            let angle = -(q[1] - p[1]).atan2(q[0] - p[0]).to_degrees();
            let mut shoe = body(
                format!("{name}_{side}_shoe_{k}"),
                &format!("{name}_shoe"),
                &self.shoe_material,
                world(middle),
                self.shoe_mass,
            );
            shoe.rotate = Some(RotateFile { axis: across, angle });
            shoe.shapes = Some(self.shoe_shapes());
            shoe.group = Some(format!("{name}_shoes"));
            parts.bodies.push(shoe);
        }
        for k in 0..self.shoes {
            let (a, b) = (
                format!("{name}_{side}_shoe_{}", (k + self.shoes - 1) % self.shoes),
                format!("{name}_{side}_shoe_{k}"),
            );
            for (pin, y) in [("outer", 0.4), ("inner", -0.4)] {
                let mut place = world(pins[k]);
                place[1] += y * self.shoe_width;
                parts.joints.push(joint(
                    format!("{name}_{side}_pin_{k}_{pin}"),
                    JointKind::Spherical,
                    [&a, &b],
                    place,
                    [0.0, 0.0, 1.0],
                ));
            }
        }
        let mut wheel = |part_name: String, place: [f64; 2], radius: f64, class: &str| {
            let mut w = body(
                format!("{name}_{side}_{part_name}"),
                &format!("{name}_{class}"),
                &self.material,
                world(place),
                self.wheel_mass,
            );
            w.shapes = Some(self.wheel_shapes(radius));
            w.group = Some(format!("{name}_wheels"));
            parts.bodies.push(w);
        };
        for k in 0..self.rollers {
            wheel(format!("roller_{k}"), [self.roller_x(k), self.roller_z(k)], self.roller_radius, "roller");
        }
        let high = self.wheel_height;
        wheel("idler".into(), [idler, high], self.idler_radius, "idler");
        wheel("sprocket".into(), [self.sprocket_x(), high], self.sprocket_radius(), "sprocket");
        let sprocket = parts.bodies.last_mut().expect("just made");
        // A tooth points between the first two pins.
        let toward =
            [0.5 * (pins[0][0] + pins[1][0]) - self.sprocket_x(), 0.5 * (pins[0][1] + pins[1][1]) - self.wheel_height];
        let teeth = self.tooth_shapes((-toward[1]).atan2(toward[0]));
        sprocket.shapes.get_or_insert_default().extend(teeth);
        let mut axle = |part_name: &str, carrier: &str, place: [f64; 2]| {
            let wheel = format!("{name}_{side}_{part_name}");
            let names = [carrier, &wheel];
            parts.joints.push(joint(
                format!("{name}_{side}_{part_name}_axle"),
                JointKind::Revolute,
                names,
                world(place),
                across,
            ));
        };
        for k in 0..self.rollers {
            axle(&format!("roller_{k}"), &chassis, [self.roller_x(k), self.roller_z(k)]);
        }
        axle("sprocket", &chassis, [self.sprocket_x(), high]);
        let drive = parts.joints.last_mut().expect("just made");
        let torque = self.torque[usize::from(side == "right")].clone();
        drive.motor = Some(MotorFile { torque: Some(torque), ..MotorFile::default() });
        if self.idler_spring {
            self.idler_slide(parts, name, side, world([idler, high]));
        } else {
            let idler_name = format!("{name}_{side}_idler");
            let names = [chassis.as_str(), idler_name.as_str()];
            parts.joints.push(joint(
                format!("{name}_{side}_idler_axle"),
                JointKind::Revolute,
                names,
                world([idler, high]),
                across,
            ));
        }
    }

    /// The idler's axle on a slide along x, pushed forward by a spring.
    fn idler_slide(&self, parts: &mut Parts, name: &str, side: &str, place: [f64; 3]) {
        let (chassis, idler, slide) =
            (format!("{name}_chassis"), format!("{name}_{side}_idler"), format!("{name}_{side}_slide"));
        let mut carrier = body(slide.clone(), &format!("{name}_slide"), &self.material, place, 0.2 * self.wheel_mass);
        carrier.inertia = Some(vec![0.01 * self.wheel_mass; 3]);
        parts.bodies.push(carrier);
        parts.joints.push(joint(
            format!("{slide}_guide"),
            JointKind::Prismatic,
            [&chassis, &slide],
            place,
            [1.0, 0.0, 0.0],
        ));
        parts.joints.push(joint(
            format!("{name}_{side}_idler_axle"),
            JointKind::Revolute,
            [&slide, &idler],
            place,
            [0.0, 1.0, 0.0],
        ));
        let behind = [place[0] - 0.3, place[1], place[2]];
        parts.springs.push(SpringFile {
            name: format!("{slide}_spring"),
            a: chassis,
            b: slide,
            position: behind,
            position_b: Some(place),
            about: None,
            stiffness: self.idler_stiffness,
            damping: self.idler_damping,
            rest: Some(0.3),
            preload: Some(FunctionFile::Constant(-self.idler_preload)),
            from: None,
            until: None,
        });
    }

    /// A shoe about the middle of its pins' line: x along the track, +z to the outside. Its ground plate, two guide plates on
    /// the inside that keep the wheels on it, and two rods between which the sprocket's teeth reach.
    fn shoe_shapes(&self) -> Vec<crate::model_file::PartFile> {
        let (p, w, t) = (self.pitch, self.shoe_width, self.shoe_thickness);
        let block = |size: [f64; 3]| ShapeFile { block: Some(BoxFile { size }), ..ShapeFile::default() };
        let rod = CylinderFile { radius: 0.07 * p, length: 0.25 * w };
        let rods = [-0.3 * p, 0.3 * p].map(|x| {
            let shape = ShapeFile { cylinder: Some(rod.clone()), ..ShapeFile::default() };
            part(shape, [x, 0.0, -0.5 * t - 0.07 * p], Some(([1.0, 0.0, 0.0], 90.0)))
        });
        let guides = [-0.46 * w, 0.46 * w].map(|y| part(block([0.5 * p, 0.04 * w, 2.0 * t]), [0.0, y, -1.5 * t], None));
        let mut shapes = vec![part(block([0.9 * p, w, t]), [0.0; 3], None)];
        shapes.extend(guides);
        shapes.extend(rods);
        shapes
    }

    /// Two discs, one on each side of the rods.
    fn wheel_shapes(&self, radius: f64) -> Vec<crate::model_file::PartFile> {
        let w = self.shoe_width;
        [-0.27 * w, 0.27 * w]
            .map(|y| {
                let disc = CylinderFile { radius, length: 0.2 * w };
                let shape = ShapeFile { cylinder: Some(disc), ..ShapeFile::default() };
                part(shape, [0.0, y, 0.0], Some(([1.0, 0.0, 0.0], 90.0)))
            })
            .into()
    }

    /// The sprocket's teeth: slim boxes that reach between a shoe's rods. `phase` is the first one's angle about y, rad.
    fn tooth_shapes(&self, phase: f64) -> Vec<crate::model_file::PartFile> {
        let (r, p) = (self.sprocket_radius(), self.pitch);
        // From well inside the drum to just short of the plate.
        let (inner, outer) = (0.8 * r, r - 0.01 * p);
        (0..self.teeth)
            .map(|k| {
                let angle = phase + k as f64 * TAU / self.teeth as f64;
                let size = [outer - inner, 0.2 * self.shoe_width, 0.34 * p];
                let middle = 0.5 * (inner + outer);
                let shape = ShapeFile { block: Some(BoxFile { size }), ..ShapeFile::default() };
                let place = [middle * angle.cos(), 0.0, -middle * angle.sin()];
                part(shape, place, Some(([0.0, 1.0, 0.0], angle.to_degrees())))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ring_of_shoes_closes_around_the_wheels() {
        let vehicle = TrackedVehicle::default();
        let idler = vehicle.place_idler().unwrap();
        let (pins, _) = vehicle.lay(idler);
        assert_eq!(pins.len(), 61);
        for k in 0..61 {
            let (p, q) = (pins[k], pins[(k + 1) % 61]);
            let length = (p[0] - q[0]).hypot(p[1] - q[1]);
            assert!((length - vehicle.pitch).abs() < 1e-6, "link {k} is {length} m long");
        }
        let lowest = pins.iter().map(|p| p[1]).fold(0.0, f64::min);
        assert!((lowest + vehicle.roller_radius + 0.5 * vehicle.shoe_thickness).abs() < 1e-6);
        assert_eq!(TrackedVehicle { shoes: 25, ..vehicle }.build("v").unwrap_err().0, "shoes");
    }
}
