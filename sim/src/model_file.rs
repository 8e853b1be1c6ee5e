//! The model file: what an engineer writes, checked and resolved into a [`Model`] and a [`State`].
//!
//! Units are SI (m, kg, s, N, rad) but for `rotate.angle`, which is in degrees. Everything but `bodies` or `fills` has a default;
//! [`ModelFile::to_yaml`] writes the model with its defaults filled in.

use crate::{Model, ShapeKind, SolverSettings, SplitMix64, State, fill};
use frame::Fault;
use frame::yaml::Document;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// A model file.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// Name, for messages; the file's stem if not given.
    #[serde(default)]
    pub name: String,
    /// Gravity, m/s².
    #[serde(default = "default_gravity")]
    pub gravity: [f64; 3],
    /// Step size, s.
    #[serde(default = "default_step")]
    pub step: f64,
    /// Time to simulate, s.
    #[serde(default = "default_duration")]
    pub duration: f64,
    /// Frames a second of simulated time.
    #[serde(default = "default_frame_rate")]
    pub frame_rate: f64,
    /// Seed of the generators.
    #[serde(default)]
    pub seed: u64,
    /// How frames are stored.
    #[serde(default)]
    pub format: frame::run::FrameFormat,
    /// The contact solver.
    #[serde(default)]
    pub solver: SolverSettings,
    /// Materials by name.
    #[serde(default)]
    pub materials: BTreeMap<String, MaterialFile>,
    /// Single bodies.
    #[serde(default)]
    pub bodies: Vec<BodyFile>,
    /// Regions filled with spheres.
    #[serde(default)]
    pub fills: Vec<FillFile>,
}

/// A material.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialFile {
    /// Density, kg/m³.
    pub density: f64,
    /// Coefficient of friction; a contact takes the smaller of its two.
    pub friction: f64,
}

/// A body of one shape: exactly one of `sphere`, `box` and `plane`.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyFile {
    /// Name.
    pub name: String,
    /// Class, by which pictures select; the name if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// Material.
    pub material: String,
    /// A ball.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sphere: Option<SphereFile>,
    /// A box.
    #[serde(default, rename = "box", skip_serializing_if = "Option::is_none")]
    pub block: Option<BoxFile>,
    /// A half space, always fixed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane: Option<PlaneFile>,
    /// Centre, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// Orientation, as a turn about an axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate: Option<RotateFile>,
    /// Velocity, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Angular velocity, rad/s, body frame.
    #[serde(default)]
    pub angular_velocity: [f64; 3],
    /// Held in place: a static obstacle.
    #[serde(default)]
    pub fixed: bool,
    /// Mass, kg; from the density if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
}

/// A ball.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereFile {
    /// Radius, m.
    pub radius: f64,
}

/// A box.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxFile {
    /// Edge lengths, m.
    pub size: [f64; 3],
}

/// A half space: all points below the plane through the body's position.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneFile {
    /// The direction that is up.
    pub normal: [f64; 3],
}

/// A turn.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotateFile {
    /// Axis, of any length but zero.
    pub axis: [f64; 3],
    /// Angle, degrees.
    pub angle: f64,
}

/// A region filled with spheres on a jittered lattice, from the bottom up.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FillFile {
    /// Name, and the class of the spheres.
    pub name: String,
    /// Material.
    pub material: String,
    /// How many.
    pub count: usize,
    /// Their radii, m: uniform between two.
    pub radius: [f64; 2],
    /// Least corner of the region, m.
    pub min: [f64; 3],
    /// Greatest corner of the region, m.
    pub max: [f64; 3],
    /// Velocity at the start, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
}

fn default_gravity() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}

fn default_step() -> f64 {
    1e-3
}

fn default_duration() -> f64 {
    1.0
}

fn default_frame_rate() -> f64 {
    24.0
}

/// Read, check and resolve a model file.
pub fn read(path: &Path) -> Result<(ModelFile, Model, State), Fault> {
    let (mut file, doc): (ModelFile, Document) = frame::yaml::read(path)?;
    if file.name.is_empty() {
        file.name = path.file_stem().and_then(|s| s.to_str()).unwrap_or("model").into();
    }
    let (model, state) = file.resolve(&doc)?;
    file.solver.envelope = Some(model.envelope);
    Ok((file, model, state))
}

impl ModelFile {
    /// The model as YAML, with its defaults.
    pub fn to_yaml(&self) -> String {
        serde_yaml::to_string(self).expect("a model is plain data")
    }

    /// Check every value and build the columns.
    pub fn resolve(&self, doc: &Document) -> Result<(Model, State), Fault> {
        self.check_numbers(doc)?;
        let mut build = Builder::new(self);
        for (i, body) in self.bodies.iter().enumerate() {
            build.body(doc, &format!("bodies.{i}"), body)?;
        }
        for (i, fill) in self.fills.iter().enumerate() {
            build.fill(doc, &format!("fills.{i}"), fill)?;
        }
        if build.model.n_bodies() == 0 {
            return Err(doc.fault("bodies", "the model has no bodies: expected `bodies` or `fills`"));
        }
        build.choose_envelope();
        Ok((build.model, build.state))
    }

    fn check_numbers(&self, doc: &Document) -> Result<(), Fault> {
        let s = &self.solver;
        for (key, value) in [
            ("step", self.step),
            ("duration", self.duration),
            ("frame_rate", self.frame_rate),
            ("solver.omega", s.omega),
            ("solver.lambda", s.lambda),
            ("solver.iterations", s.iterations as f64),
            ("solver.recovery_speed", s.recovery_speed),
        ] {
            positive(doc, key, value)?;
        }
        finite(doc, "gravity", &self.gravity)?;
        if !(s.tolerance >= 0.0) || s.envelope.is_some_and(|e| !(e >= 0.0)) {
            let key = if s.tolerance >= 0.0 { "solver.envelope" } else { "solver.tolerance" };
            return Err(doc.fault(key, "must not be negative"));
        }
        if self.step > 0.1 {
            return Err(doc.fault("step", format!("a step of {} s is too long, expected at most 0.1 s", self.step)));
        }
        for (name, material) in &self.materials {
            positive(doc, &format!("materials.{name}.density"), material.density)?;
            if !(material.friction >= 0.0 && material.friction.is_finite()) {
                return Err(doc.fault(&format!("materials.{name}.friction"), "must be a number of at least 0"));
            }
        }
        Ok(())
    }
}

fn positive(doc: &Document, key: &str, value: f64) -> Result<(), Fault> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(doc.fault(key, format!("is {value}, expected a number above 0")))
}

fn finite(doc: &Document, key: &str, values: &[f64]) -> Result<(), Fault> {
    match values.iter().find(|v| !v.is_finite()) {
        Some(v) => Err(doc.fault(key, format!("has a component {v}, expected finite numbers"))),
        None => Ok(()),
    }
}

/// Columns under construction.
struct Builder<'a> {
    file: &'a ModelFile,
    random: SplitMix64,
    model: Model,
    state: State,
}

/// One body on its way into the columns.
struct NewBody {
    class: u32,
    kind: ShapeKind,
    size: DVec3,
    friction: f64,
    /// `None` is held in place.
    mass: Option<f64>,
    position: DVec3,
    orientation: DQuat,
    velocity: DVec3,
    angular_velocity: DVec3,
}

impl<'a> Builder<'a> {
    fn new(file: &'a ModelFile) -> Builder<'a> {
        let model = Model {
            name: file.name.clone(),
            gravity: file.gravity.into(),
            step: file.step,
            duration: file.duration,
            frame_rate: file.frame_rate,
            seed: file.seed,
            solver: file.solver.clone(),
            envelope: 0.0,
            inv_mass: vec![],
            inv_inertia: vec![],
            class: vec![],
            class_names: vec![],
            shape_body: vec![],
            shape_kind: vec![],
            shape_size: vec![],
            shape_friction: vec![],
        };
        Builder { file, random: SplitMix64(file.seed), model, state: State::default() }
    }

    fn material(&self, doc: &Document, key: &str, name: &str) -> Result<&'a MaterialFile, Fault> {
        let known: Vec<&str> = self.file.materials.keys().map(String::as_str).collect();
        self.file.materials.get(name).ok_or_else(|| doc.unknown(&format!("{key}.material"), "material", name, &known))
    }

    fn class(&mut self, name: &str) -> u32 {
        let names = &mut self.model.class_names;
        names.iter().position(|n| n == name).unwrap_or_else(|| {
            names.push(name.into());
            names.len() - 1
        }) as u32
    }

    fn body(&mut self, doc: &Document, key: &str, body: &BodyFile) -> Result<(), Fault> {
        let material = self.material(doc, key, &body.material)?;
        for (name, values) in
            [("position", body.position), ("velocity", body.velocity), ("angular_velocity", body.angular_velocity)]
        {
            finite(doc, &format!("{key}.{name}"), &values)?;
        }
        if let Some(mass) = body.mass {
            positive(doc, &format!("{key}.mass"), mass)?;
        }
        let mut orientation = DQuat::IDENTITY;
        if let Some(rotate) = &body.rotate {
            let axis = direction(doc, &format!("{key}.rotate.axis"), rotate.axis)?;
            finite(doc, &format!("{key}.rotate.angle"), &[rotate.angle])?;
            orientation = DQuat::from_axis_angle(axis, rotate.angle.to_radians());
        }
        let (kind, size) = match (&body.sphere, &body.block, &body.plane) {
            (Some(sphere), None, None) => {
                positive(doc, &format!("{key}.sphere.radius"), sphere.radius)?;
                (ShapeKind::Sphere, DVec3::splat(sphere.radius))
            }
            (None, Some(block), None) => {
                for length in block.size {
                    positive(doc, &format!("{key}.box.size"), length)?;
                }
                (ShapeKind::Box, DVec3::from_array(block.size) * 0.5)
            }
            (None, None, Some(plane)) => {
                let normal = direction(doc, &format!("{key}.plane.normal"), plane.normal)?;
                orientation = DQuat::from_rotation_arc(DVec3::Z, normal);
                (ShapeKind::Plane, DVec3::ZERO)
            }
            _ => {
                let message = format!("body `{}` needs exactly one shape: `sphere`, `box` or `plane`", body.name);
                return Err(doc.fault(key, message));
            }
        };
        let fixed = body.fixed || kind == ShapeKind::Plane;
        for (name, motion) in [("velocity", body.velocity), ("angular_velocity", body.angular_velocity)] {
            if fixed && motion != [0.0; 3] {
                return Err(doc.fault(
                    &format!("{key}.{name}"),
                    format!("body `{}` is held in place and cannot move", body.name),
                ));
            }
        }
        let mass = body.mass.unwrap_or_else(|| material.density * volume(kind, size));
        let class = self.class(body.class.as_deref().unwrap_or(&body.name));
        self.add(NewBody {
            class,
            kind,
            size,
            friction: material.friction,
            mass: (!fixed).then_some(mass),
            position: body.position.into(),
            orientation,
            velocity: body.velocity.into(),
            angular_velocity: body.angular_velocity.into(),
        });
        Ok(())
    }

    fn fill(&mut self, doc: &Document, key: &str, fill: &FillFile) -> Result<(), Fault> {
        let material = self.material(doc, key, &fill.material)?;
        let [least, most] = fill.radius;
        positive(doc, &format!("{key}.radius"), least)?;
        finite(doc, &format!("{key}.radius"), &fill.radius)?;
        if most < least {
            return Err(doc.fault(
                &format!("{key}.radius"),
                format!("runs from {least} to {most}, expected the smaller radius first"),
            ));
        }
        for (name, values) in [("min", fill.min), ("max", fill.max), ("velocity", fill.velocity)] {
            finite(doc, &format!("{key}.{name}"), &values)?;
        }
        let places =
            fill::lattice(fill.min.into(), fill.max.into(), most, fill.count, &mut self.random).map_err(|fits| {
                doc.fault(
                    &format!("{key}.count"),
                    format!("{} spheres are asked for, but {fits} of radius {most} m fit in the region", fill.count),
                )
                .hint("enlarge the region between `min` and `max`, or ask for fewer")
            })?;
        let class = self.class(&fill.name);
        for position in places {
            let radius = self.random.between(least, most);
            let orientation = self.random.rotation();
            self.add(NewBody {
                class,
                kind: ShapeKind::Sphere,
                size: DVec3::splat(radius),
                friction: material.friction,
                mass: Some(material.density * volume(ShapeKind::Sphere, DVec3::splat(radius))),
                position,
                orientation,
                velocity: fill.velocity.into(),
                angular_velocity: DVec3::ZERO,
            });
        }
        Ok(())
    }

    fn add(&mut self, body: NewBody) {
        let (model, state) = (&mut self.model, &mut self.state);
        model.shape_body.push(model.inv_mass.len() as u32);
        model.shape_kind.push(body.kind);
        model.shape_size.push(body.size);
        model.shape_friction.push(body.friction);
        model.inv_mass.push(body.mass.map_or(0.0, |m| 1.0 / m));
        model.inv_inertia.push(body.mass.map_or(DVec3::ZERO, |m| inertia(body.kind, body.size, m).recip()));
        model.class.push(body.class);
        state.position.push(body.position);
        state.orientation.push(body.orientation);
        state.velocity.push(if body.mass.is_some() { body.velocity } else { DVec3::ZERO });
        state.angular_velocity.push(if body.mass.is_some() { body.angular_velocity } else { DVec3::ZERO });
    }

    /// The envelope as given, or a fiftieth of the least half length of what moves.
    fn choose_envelope(&mut self) {
        let moving = |s: &usize| self.model.inv_mass[self.model.shape_body[*s] as usize] > 0.0;
        let least = (0..self.model.n_shapes())
            .filter(moving)
            .map(|s| self.model.shape_size[s].min_element())
            .fold(f64::INFINITY, f64::min);
        let default = if least.is_finite() { 0.02 * least } else { 1e-3 };
        self.model.envelope = self.file.solver.envelope.unwrap_or(default);
    }
}

fn direction(doc: &Document, key: &str, v: [f64; 3]) -> Result<DVec3, Fault> {
    finite(doc, key, &v)?;
    DVec3::from_array(v).try_normalize().ok_or_else(|| doc.fault(key, "is zero, expected a direction"))
}

fn volume(kind: ShapeKind, size: DVec3) -> f64 {
    match kind {
        ShapeKind::Sphere => 4.0 / 3.0 * std::f64::consts::PI * size.x.powi(3),
        ShapeKind::Box => 8.0 * size.element_product(),
        ShapeKind::Plane => 0.0,
    }
}

/// Principal moments of inertia of a solid shape, kg m².
fn inertia(kind: ShapeKind, size: DVec3, mass: f64) -> DVec3 {
    match kind {
        ShapeKind::Sphere => DVec3::splat(0.4 * mass * size.x * size.x),
        ShapeKind::Box => {
            let s = size * size;
            DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y) * (mass / 3.0)
        }
        ShapeKind::Plane => DVec3::ZERO,
    }
}
