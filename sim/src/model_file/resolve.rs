//! From the file's types to columns: every value is checked here, and every fault has its place.

use super::shape::{self, Shape, direction, finite, not_negative, orientation, positive};
use super::types::*;
use super::{Probes, Resolved};
use crate::checkpoint;
use crate::geometry::{Surface, principal, solid_of};
use crate::joint::{Frames, Joint, JointKind, JointState, Motor, Spring};
use crate::load::{Function, Load};
use crate::terrain::Ground;
use crate::{ContactLaw, Late, Model, Pose, ShapeKind, SplitMix64, State, fill};
use frame::Fault;
use frame::sequence::matches;
use frame::yaml::Document;
use glam::{DMat3, DQuat, DVec3};
use std::collections::BTreeMap;
use std::path::PathBuf;

impl ModelFile {
    /// The model as YAML, with its defaults.
    pub fn to_yaml(&self) -> String {
        serde_yaml::to_string(self).expect("a model is plain data")
    }

    /// The whole run's duration, s.
    pub fn whole_duration(&self) -> f64 {
        if self.stages.is_empty() { self.duration } else { self.stages.iter().map(|s| s.duration).sum() }
    }

    /// Check every value and build the columns.
    pub fn resolve(&self, doc: &Document) -> Result<Resolved, Fault> {
        self.check_numbers(doc)?;
        let mut build = Builder::new(self, doc);
        if let Some(base) = &self.base {
            build.base(base)?;
        }
        build.content("", self.content(), 0.0)?;
        let mut begin = 0.0;
        for (i, stage) in self.stages.iter().enumerate() {
            let key = format!("stages.{i}");
            positive(doc, &format!("{key}.duration"), stage.duration)?;
            build.content(&format!("{key}."), stage.content(), begin)?;
            for (k, name) in stage.release.iter().enumerate() {
                build.release(&format!("{key}.release.{k}"), name, begin)?;
            }
            begin += stage.duration;
            build.stages.push((stage.name.clone(), begin));
        }
        if build.model.n_bodies() == 0 {
            return Err(doc.fault("bodies", "the model has no bodies: expected `bodies`, `fills` or `assemblies`"));
        }
        build.finish()
    }

    fn check_numbers(&self, doc: &Document) -> Result<(), Fault> {
        let s = &self.solver;
        for (key, value) in [
            ("step", self.step),
            ("duration", self.duration),
            ("frame_rate", self.frame_rate),
            ("solver.omega", s.omega.unwrap_or(1.0)),
            ("solver.lambda", s.lambda),
            ("solver.iterations", s.iterations as f64),
            ("solver.recovery_speed", s.recovery_speed),
            ("checkpoint_interval", self.checkpoint_interval.unwrap_or(1.0)),
            ("probes.interval", self.probes.interval.unwrap_or(1.0)),
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
        for (name, m) in &self.materials {
            let key = |part: &str| format!("materials.{name}.{part}");
            positive(doc, &key("density"), m.density)?;
            for (part, value) in [
                ("friction", m.friction),
                ("restitution", m.restitution),
                ("cohesion", m.cohesion),
                ("rolling", m.rolling),
                ("spinning", m.spinning),
            ] {
                not_negative(doc, &key(part), value)?;
            }
            if m.restitution > 1.0 {
                return Err(doc.fault(&key("restitution"), format!("is {}, expected 0 to 1", m.restitution)));
            }
        }
        Ok(())
    }
}

/// Columns under construction.
struct Builder<'a> {
    file: &'a ModelFile,
    doc: &'a Document,
    random: SplitMix64,
    model: Model,
    state: State,
    materials: BTreeMap<String, MaterialFile>,
    groups_pass: Vec<[u32; 2]>,
    apart: Vec<[u32; 2]>,
    stages: Vec<(String, f64)>,
    /// Where the bodies that have names stand in the file.
    key_of_body: BTreeMap<u32, String>,
    /// What probes watch unless told otherwise.
    probe_bodies: Vec<u32>,
    probe_joints: Vec<u32>,
    probe_springs: Vec<u32>,
    warnings: Vec<String>,
}

/// A shape on its way into the columns.
struct NewShape {
    shape: Shape,
    pose: Pose,
    material: u32,
    density: f64,
    group: u32,
}

/// A body on its way into the columns.
struct NewBody {
    class: u32,
    /// The file's frame in the world.
    place: Pose,
    velocity: DVec3,
    angular_velocity: DVec3,
    fixed: bool,
    mass: Option<f64>,
    inertia: Option<DMat3>,
    center: Option<DVec3>,
    appears: f64,
    moves: f64,
}

impl<'a> Builder<'a> {
    fn new(file: &'a ModelFile, doc: &'a Document) -> Builder<'a> {
        let model = Model {
            name: file.name.clone(),
            gravity: file.gravity.into(),
            step: file.step,
            duration: file.whole_duration(),
            frame_rate: file.frame_rate,
            seed: file.seed,
            solver: file.solver.clone(),
            material_names: file.materials.keys().cloned().collect(),
            group_names: vec!["all".into()],
            ..Model::default()
        };
        Builder {
            file,
            doc,
            random: SplitMix64(file.seed),
            model,
            state: State::default(),
            materials: file.materials.clone(),
            groups_pass: vec![],
            apart: vec![],
            stages: vec![],
            key_of_body: BTreeMap::new(),
            probe_bodies: vec![],
            probe_joints: vec![],
            probe_springs: vec![],
            warnings: vec![],
        }
    }

    /// The laws of all pairs of materials.
    fn laws(&mut self) -> Result<(), Fault> {
        let names = self.model.material_names.clone();
        let n = names.len();
        let of = |name: &String| &self.materials[name];
        let mut laws = vec![ContactLaw::default(); n * n];
        for (i, a) in names.iter().enumerate() {
            for (j, b) in names.iter().enumerate() {
                let (a, b) = (of(a), of(b));
                laws[i * n + j] = ContactLaw {
                    friction: a.friction.min(b.friction),
                    restitution: a.restitution.max(b.restitution),
                    cohesion: a.cohesion.min(b.cohesion),
                    rolling: a.rolling.min(b.rolling),
                    spinning: a.spinning.min(b.spinning),
                };
            }
        }
        for (k, pair) in self.file.contacts.iter().enumerate() {
            let key = format!("contacts.{k}");
            let mut index = [0; 2];
            for (slot, name) in index.iter_mut().zip(&pair.materials) {
                *slot = self.material(&format!("{key}.materials"), name)?.0 as usize;
            }
            let parts = [
                ("friction", pair.friction),
                ("restitution", pair.restitution),
                ("cohesion", pair.cohesion),
                ("rolling", pair.rolling),
                ("spinning", pair.spinning),
            ];
            for (part, value) in parts {
                not_negative(self.doc, &format!("{key}.{part}"), value.unwrap_or(0.0))?;
            }
            for (i, j) in [(index[0], index[1]), (index[1], index[0])] {
                let law = &mut laws[i * n + j];
                law.friction = pair.friction.unwrap_or(law.friction);
                law.restitution = pair.restitution.unwrap_or(law.restitution).min(1.0);
                law.cohesion = pair.cohesion.unwrap_or(law.cohesion);
                law.rolling = pair.rolling.unwrap_or(law.rolling);
                law.spinning = pair.spinning.unwrap_or(law.spinning);
            }
        }
        self.model.laws = laws;
        Ok(())
    }

    fn material(&self, key: &str, name: &str) -> Result<(u32, f64), Fault> {
        let known: Vec<&str> = self.materials.keys().map(String::as_str).collect();
        match self.model.material_names.iter().position(|n| n == name) {
            Some(i) => Ok((i as u32, self.materials[name].density)),
            None => Err(self.doc.unknown(key, "material", name, &known)),
        }
    }

    fn class(&mut self, name: &str) -> u32 {
        number_of(&mut self.model.class_names, name)
    }

    fn group(&mut self, name: Option<&str>) -> u32 {
        name.map_or(0, |n| number_of(&mut self.model.group_names, n))
    }

    fn content(&mut self, prefix: &str, content: Content<'_>, begins: f64) -> Result<(), Fault> {
        for (i, body) in content.bodies.iter().enumerate() {
            let id = self.body(&format!("{prefix}bodies.{i}"), body, begins)?;
            if self.moves_ever(id) {
                self.probe_bodies.push(id);
            }
        }
        for (i, terrain) in content.terrains.iter().enumerate() {
            self.terrain(&format!("{prefix}terrains.{i}"), terrain, begins)?;
        }
        for (i, assembly) in content.assemblies.iter().enumerate() {
            self.assembly(&format!("{prefix}assemblies.{i}"), assembly, begins)?;
        }
        for (i, fill) in content.fills.iter().enumerate() {
            self.fill(&format!("{prefix}fills.{i}"), fill, begins)?;
        }
        for (i, joint) in content.joints.iter().enumerate() {
            self.joint(&format!("{prefix}joints.{i}"), joint, begins)?;
            self.probe_joints.push(self.model.joints.len() as u32 - 1);
        }
        for (i, spring) in content.springs.iter().enumerate() {
            self.spring(&format!("{prefix}springs.{i}"), spring, begins)?;
            self.probe_springs.push(self.model.springs.len() as u32 - 1);
        }
        for (i, load) in content.loads.iter().enumerate() {
            self.load(&format!("{prefix}loads.{i}"), load, begins)?;
        }
        Ok(())
    }

    fn body(&mut self, key: &str, body: &BodyFile, begins: f64) -> Result<u32, Fault> {
        let doc = self.doc;
        let at = |part: &str| format!("{key}.{part}");
        if body.name == "world" {
            return Err(doc.fault(&at("name"), "`world` is the ground's own name: choose another"));
        }
        if self.model.body_names.contains_key(&body.name) {
            return Err(doc.fault(&at("name"), format!("there is a body `{}` already", body.name)));
        }
        for (name, values) in
            [("position", body.position), ("velocity", body.velocity), ("angular_velocity", body.angular_velocity)]
        {
            finite(doc, &at(name), &values)?;
        }
        if let Some(mass) = body.mass {
            positive(doc, &at("mass"), mass)?;
        }
        let place = Pose {
            position: body.position.into(),
            orientation: orientation(doc, key, &body.rotate, &body.orientation)?,
        };
        let group = self.group(body.group.as_deref());
        let mut shapes = vec![];
        let what = format!("body `{}`", body.name);
        let own = body.shape();
        let parts: Vec<(String, ShapeFile, Option<&String>, Pose)> = match &body.shapes {
            Some(_) if shape::count(&own) > 0 => {
                return Err(
                    doc.fault(&at("shapes"), format!("{what} has `shapes` and a shape of its own: expected one"))
                );
            }
            Some(parts) => parts
                .iter()
                .enumerate()
                .map(|(k, part)| {
                    let key = format!("{key}.shapes.{k}");
                    finite(doc, &format!("{key}.position"), &part.position)?;
                    let pose = Pose {
                        position: part.position.into(),
                        orientation: orientation(doc, &key, &part.rotate, &part.orientation)?,
                    };
                    Ok((key, part.shape(), part.material.as_ref(), pose))
                })
                .collect::<Result<_, Fault>>()?,
            None => vec![(key.to_string(), own, None, Pose::default())],
        };
        for (key, file, material, pose) in parts {
            let name = material
                .or(body.material.as_ref())
                .ok_or_else(|| doc.fault(&key, format!("{what} has no material: expected `material: NAME`")))?;
            let (material, density) = self.material(&format!("{key}.material"), name)?;
            let shape = shape::resolve(doc, &key, &what, &file)?;
            shapes.push(NewShape { shape, pose, material, density, group });
        }
        let surface = shapes.iter().any(|s| s.shape.kind.is_surface());
        let fixed = body.fixed || surface;
        for (name, motion) in [("velocity", body.velocity), ("angular_velocity", body.angular_velocity)] {
            if fixed && motion != [0.0; 3] {
                return Err(doc.fault(&at(name), format!("{what} is held in place and cannot move")));
            }
        }
        if surface && body.mass.is_some() {
            return Err(doc.fault(&at("mass"), format!("{what} is a static surface: it has no mass")));
        }
        if shapes.is_empty() && !fixed && body.mass.is_none() {
            return Err(doc.fault(key, format!("{what} has no shapes: expected a `mass` and an `inertia`")));
        }
        if shapes.is_empty() && !fixed && body.inertia.is_none() {
            return Err(doc.fault(key, format!("{what} has no shapes: expected an `inertia`")));
        }
        let inertia = match &body.inertia {
            Some(values) => Some(self.inertia(&at("inertia"), values)?),
            None => None,
        };
        let appears = body.appears.unwrap_or(begins);
        let moves = body.held_until.unwrap_or(0.0).max(appears);
        for (part, value) in [("appears", appears), ("held_until", moves)] {
            not_negative(doc, &at(part), value)?;
        }
        let class = self.class(body.class.as_deref().unwrap_or(&body.name));
        let id = self
            .add(
                NewBody {
                    class,
                    place,
                    velocity: body.velocity.into(),
                    angular_velocity: body.angular_velocity.into(),
                    fixed,
                    mass: body.mass,
                    inertia,
                    center: body.center.map(DVec3::from),
                    appears,
                    moves,
                },
                shapes,
            )
            .map_err(|message| doc.fault(key, format!("{what} {message}")))?;
        self.model.body_names.insert(body.name.clone(), id);
        self.key_of_body.insert(id, key.into());
        Ok(id)
    }

    /// An inertia tensor of three or six numbers, about the centre of mass along the body's axes.
    fn inertia(&self, key: &str, values: &[f64]) -> Result<DMat3, Fault> {
        finite(self.doc, key, values)?;
        let (d, o) = match values {
            [x, y, z] => ([*x, *y, *z], [0.0; 3]),
            [x, y, z, xy, xz, yz] => ([*x, *y, *z], [*xy, *xz, *yz]),
            _ => return Err(self.doc.fault(key, format!("has {} numbers, expected 3 or 6", values.len()))),
        };
        let tensor =
            DMat3::from_cols(DVec3::new(d[0], o[0], o[1]), DVec3::new(o[0], d[1], o[2]), DVec3::new(o[1], o[2], d[2]));
        let (moments, _) = principal(tensor);
        if !(moments.min_element() > 0.0) {
            return Err(self.doc.fault(key, format!("has principal moments {moments}, expected numbers above 0")));
        }
        Ok(tensor)
    }

    /// Put a body into the columns, its frame moved to the centre of mass and turned to the principal axes.
    fn add(&mut self, body: NewBody, shapes: Vec<NewShape>) -> Result<u32, String> {
        let (mut volume_mass, mut first) = (0.0, DVec3::ZERO);
        let solids: Vec<_> = shapes
            .iter()
            .map(|s| {
                let pose = s.pose.place(&Pose { position: s.shape.shift, orientation: s.shape.turn });
                let solid = solid_of(s.shape.kind, s.shape.size, s.shape.hull.as_ref());
                let mass = solid.volume * s.density;
                volume_mass += mass;
                first += (pose.position + pose.orientation * solid.centre) * mass;
                (pose, solid, mass)
            })
            .collect();
        let natural = if volume_mass > 0.0 { first / volume_mass } else { DVec3::ZERO };
        let centre = body.center.unwrap_or(natural);
        let mass = body.mass.unwrap_or(volume_mass);
        let scale = if volume_mass > 0.0 { mass / volume_mass } else { 0.0 };
        let mut tensor = DMat3::ZERO;
        for ((pose, solid, own), s) in solids.iter().zip(&shapes) {
            let r = DMat3::from_quat(pose.orientation);
            let away = pose.position + pose.orientation * solid.centre - centre;
            let steiner = DMat3::from_diagonal(DVec3::splat(away.length_squared()))
                - DMat3::from_cols(away * away.x, away * away.y, away * away.z);
            tensor += (r * (solid.inertia * s.density) * r.transpose() + steiner * *own) * scale;
        }
        let tensor = body.inertia.unwrap_or(tensor);
        let moves_ever = !body.fixed;
        let diagonal = tensor.x_axis.y == 0.0 && tensor.x_axis.z == 0.0 && tensor.y_axis.z == 0.0;
        let (moments, turn) = if diagonal {
            (DVec3::new(tensor.x_axis.x, tensor.y_axis.y, tensor.z_axis.z), DQuat::IDENTITY)
        } else {
            principal(tensor)
        };
        if moves_ever && !(mass > 0.0 && mass.is_finite()) {
            return Err(format!("has a mass of {mass} kg, expected a number above 0"));
        }
        if moves_ever && !(moments.min_element() > 0.0 && moments.is_finite()) {
            return Err("has no moment of inertia: give it shapes or an `inertia`".into());
        }
        let id = self.model.n_bodies() as u32;
        let (inv_mass, inv_inertia) = if moves_ever { (1.0 / mass, moments.recip()) } else { (0.0, DVec3::ZERO) };
        let model = &mut self.model;
        let late = body.appears > 0.0 || (moves_ever && body.moves > 0.0);
        if late {
            model.late.push(Late { body: id, appears: body.appears, moves: body.moves, inv_mass, inv_inertia });
        }
        let held = late && body.moves > 0.0;
        model.inv_mass.push(if held { 0.0 } else { inv_mass });
        model.inv_inertia.push(if held { DVec3::ZERO } else { inv_inertia });
        model.absent.push(body.appears > 0.0);
        model.class.push(body.class);
        // The principal frame in the file's frame, and the other way round.
        let own = Pose { position: centre, orientation: turn };
        model.body_frame.push(own.inverse());
        let world = body.place.place(&own);
        self.state.position.push(world.position);
        self.state.orientation.push(world.orientation.normalize());
        self.state.velocity.push(if moves_ever { body.velocity } else { DVec3::ZERO });
        let spin = turn.inverse() * body.angular_velocity;
        self.state.angular_velocity.push(if moves_ever { spin } else { DVec3::ZERO });
        for (s, (pose, _, _)) in shapes.into_iter().zip(solids) {
            self.add_shape(id, own.inverse().place(&pose), s);
        }
        Ok(id)
    }

    fn add_shape(&mut self, body: u32, pose: Pose, s: NewShape) {
        let model = &mut self.model;
        let mut part = 0;
        if let Some(hull) = s.shape.hull {
            part = model.hulls.iter().position(|h| *h == hull).unwrap_or_else(|| {
                model.hulls.push(hull);
                model.hulls.len() - 1
            });
        }
        if let Some(surface) = s.shape.surface {
            model.surfaces.push(surface);
            part = model.surfaces.len() - 1;
        }
        model.shape_body.push(body);
        model.shape_kind.push(s.shape.kind);
        model.shape_size.push(s.shape.size);
        model.shape_pose.push(pose);
        model.shape_material.push(s.material);
        model.shape_group.push(s.group);
        model.shape_part.push(part as u32);
    }

    /// Draws radii.
    fn radii(&self, key: &str, file: &RadiusFile) -> Result<Radii, Fault> {
        let doc = self.doc;
        let key = format!("{key}.radius");
        match file {
            RadiusFile::Uniform([least, most]) => {
                finite(doc, &key, &[*least, *most])?;
                positive(doc, &key, *least)?;
                if most < least {
                    let message = format!("runs from {least} to {most}, expected the smaller radius first");
                    return Err(doc.fault(&key, message));
                }
                Ok(Radii::Uniform(*least, *most))
            }
            RadiusFile::Normal(n) => {
                positive(doc, &format!("{key}.mean"), n.mean)?;
                not_negative(doc, &format!("{key}.deviation"), n.deviation)?;
                positive(doc, &format!("{key}.least"), n.least)?;
                if !(n.least <= n.mean && n.mean <= n.greatest && n.greatest.is_finite()) {
                    return Err(doc.fault(&key, "expected least ≤ mean ≤ greatest"));
                }
                Ok(Radii::Normal(n.clone()))
            }
            RadiusFile::Sieve(s) => {
                let rises = s.sieve.windows(2).all(|p| p[1][0] > p[0][0] && p[1][1] >= p[0][1]);
                let sound = s.sieve.len() >= 2
                    && rises
                    && s.sieve[0][0] > 0.0
                    && s.sieve[0][1] >= 0.0
                    && s.sieve.last().is_some_and(|p| p[1] == 1.0 && p[0].is_finite());
                if !sound {
                    let message =
                        "expected at least two pairs [mesh width, share passing], both rising, the last share 1";
                    return Err(doc.fault(&format!("{key}.sieve"), message));
                }
                Ok(Radii::sieve(&s.sieve))
            }
        }
    }

    fn fill(&mut self, key: &str, fill: &FillFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let (material, density) = self.material(&format!("{key}.material"), &fill.material)?;
        let radii = self.radii(key, &fill.radius)?;
        for (name, values) in [("min", fill.min), ("max", fill.max), ("velocity", fill.velocity)] {
            finite(doc, &format!("{key}.{name}"), &values)?;
        }
        if let Some(mass) = fill.mass {
            positive(doc, &format!("{key}.mass"), mass)?;
        }
        if let Some(r) = fill.within_radius {
            positive(doc, &format!("{key}.within_radius"), r)?;
        }
        let region = fill::Region { min: fill.min.into(), max: fill.max.into(), within: fill.within_radius };
        let count = fill.count.map_or(fill::Count::AllThatFit, fill::Count::Exactly);
        let most = radii.greatest();
        let places = match fill.packing {
            Packing::Lattice => fill::lattice(&region, most, count, &mut self.random),
            Packing::Hexagonal => fill::hexagonal(&region, most, count),
            Packing::PoissonDisk => fill::poisson_disk(&region, most, count, &mut self.random),
        }
        .map_err(|fits| {
            let asked = fill.count.unwrap_or(0);
            doc.fault(
                &format!("{key}.count"),
                format!("{asked} spheres are asked for, but {fits} of radius {most} m fit in the region"),
            )
            .hint("enlarge the region between `min` and `max`, or ask for fewer")
        })?;
        if places.is_empty() {
            return Err(doc.fault(key, format!("no sphere of radius {most} m fits in the region")));
        }
        let class = self.class(&fill.name);
        let group = self.group(fill.group.as_deref());
        let appears = fill.appears.unwrap_or(begins);
        not_negative(doc, &format!("{key}.appears"), appears)?;
        for position in places {
            let radius = radii.draw(&mut self.random);
            let orientation = self.random.rotation();
            let shape = Shape::simple(ShapeKind::Sphere, DVec3::splat(radius));
            let pose = Pose::default();
            let body = NewBody {
                class,
                place: Pose { position, orientation },
                velocity: fill.velocity.into(),
                angular_velocity: DVec3::ZERO,
                fixed: false,
                mass: fill.mass,
                inertia: None,
                center: None,
                appears,
                moves: appears,
            };
            self.add(body, vec![NewShape { shape, pose, material, density, group }])
                .map_err(|message| doc.fault(key, format!("a sphere of the fill {message}")))?;
        }
        Ok(())
    }

    fn terrain(&mut self, key: &str, t: &TerrainFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let at = |part: &str| format!("{key}.{part}");
        let (material, density) = self.material(&at("material"), &t.material)?;
        for (part, value) in
            [("size", t.size[0]), ("size", t.size[1]), ("spacing", t.spacing), ("wavelength", t.wavelength)]
        {
            positive(doc, &at(part), value)?;
        }
        not_negative(doc, &at("amplitude"), t.amplitude)?;
        not_negative(doc, &at("flat_radius"), t.flat_radius)?;
        finite(doc, &at("position"), &t.position)?;
        if (t.size[0] / t.spacing) * (t.size[1] / t.spacing) > 2e7 {
            return Err(doc.fault(&at("spacing"), "makes a grid of more than 20 million points: expected a wider one"));
        }
        for (i, d) in t.ditches.iter().enumerate() {
            positive(doc, &at(&format!("ditches.{i}.width")), d.width)?;
            finite(doc, &at(&format!("ditches.{i}")), &[d.depth, d.from[0], d.from[1], d.to[0], d.to[1]])?;
        }
        let ground = Ground::new(t, &mut self.random);
        let (heights, n, origin, spacing) = ground.grid();
        let surface = Surface::height_field(&heights, n, origin, spacing);
        let class = self.class(&t.name);
        let place = Pose { position: t.position.into(), orientation: DQuat::IDENTITY };
        let still = |class: u32, place: Pose| NewBody {
            class,
            place,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            fixed: true,
            mass: None,
            inertia: None,
            center: Some(DVec3::ZERO),
            appears: begins,
            moves: begins,
        };
        let pose = Pose::default();
        let shape = shape::surface_shape(ShapeKind::HeightField, surface);
        let id = self
            .add(still(class, place), vec![NewShape { shape, pose, material, density, group: 0 }])
            .map_err(|m| doc.fault(key, m))?;
        self.model.body_names.insert(t.name.clone(), id);
        if let Some(b) = &t.boulders {
            positive(doc, &at("boulders.radius"), b.radius[0])?;
            if !(b.radius[1] >= b.radius[0] && b.radius[1].is_finite()) {
                return Err(doc.fault(&at("boulders.radius"), "expected the smaller radius first"));
            }
            let (material, density) = match &b.material {
                Some(name) => self.material(&at("boulders.material"), name)?,
                None => (material, density),
            };
            let class = self.class(&format!("{}_boulder", t.name));
            for (position, radius) in ground.boulders(&mut self.random) {
                let stretch = [0; 3].map(|_| self.random.between(0.75, 1.0));
                let turn = self.random.rotation();
                let shape = Shape::simple(ShapeKind::Ellipsoid, DVec3::from(stretch) * radius);
                let place = Pose { position: place.position + position, orientation: turn };
                self.add(still(class, place), vec![NewShape { shape, pose, material, density, group: 0 }])
                    .map_err(|m| doc.fault(key, m))?;
            }
        }
        Ok(())
    }

    fn assembly(&mut self, key: &str, file: &AssemblyFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let (kind, parts) = match (&file.tracked_vehicle, &file.helical_anchor) {
            (Some(v), None) => ("tracked_vehicle", v.build(&file.name)),
            (None, Some(a)) => ("helical_anchor", a.build(&file.name)),
            _ => return Err(doc.fault(key, "needs exactly one of `tracked_vehicle` and `helical_anchor`")),
        };
        let key = format!("{key}.{kind}");
        let parts = parts.map_err(|(part, why)| doc.fault(&format!("{key}.{part}"), why))?;
        for body in &parts.bodies {
            self.body(&key, body, begins)?;
        }
        for joint in &parts.joints {
            self.joint(&key, joint, begins)?;
        }
        for spring in &parts.springs {
            self.spring(&key, spring, begins)?;
        }
        for load in &parts.loads {
            self.load(&key, load, begins)?;
        }
        for [a, b] in &parts.pass_through {
            let pair = [self.group(Some(a)), self.group(Some(b))];
            self.groups_pass.push(pair);
        }
        Ok(())
    }

    /// A body by name; `world` is made when it is first asked for.
    fn find(&mut self, key: &str, name: &str) -> Result<u32, Fault> {
        if let Some(id) = self.model.body_names.get(name) {
            return Ok(*id);
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
        let mut known: Vec<&str> = self.model.body_names.keys().map(String::as_str).collect();
        known.push("world");
        Err(self.doc.unknown(key, "body", name, &known))
    }

    fn ends(&mut self, key: &str, a: &str, b: &str) -> Result<[u32; 2], Fault> {
        let pair = [self.find(&format!("{key}.a"), a)?, self.find(&format!("{key}.b"), b)?];
        if pair[0] == pair[1] {
            return Err(self.doc.fault(&format!("{key}.b"), format!("joins `{a}` to itself")));
        }
        if pair.iter().all(|b| !self.moves_ever(*b)) {
            return Err(self.doc.fault(&format!("{key}.b"), format!("`{a}` and `{b}` are both held in place")));
        }
        Ok(pair)
    }

    fn moves_ever(&self, body: u32) -> bool {
        self.model.inv_mass[body as usize] > 0.0 || self.model.late.iter().any(|l| l.body == body && l.inv_mass > 0.0)
    }

    /// A world pose in a body's principal frame.
    fn in_body(&self, body: u32, world: Pose) -> Pose {
        let b = body as usize;
        Pose { position: self.state.position[b], orientation: self.state.orientation[b] }.inverse().place(&world)
    }

    fn interval(&self, key: &str, from: Option<f64>, until: Option<f64>, begins: f64) -> Result<[f64; 2], Fault> {
        let (from, until) = (from.unwrap_or(begins), until.unwrap_or(f64::INFINITY));
        if !(from >= 0.0) || !(until > from) {
            return Err(self.doc.fault(&format!("{key}.until"), format!("acts from {from} s until {until} s")));
        }
        Ok([from, until])
    }

    fn joint(&mut self, key: &str, file: &JointFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let at = |part: &str| format!("{key}.{part}");
        if self.model.joints.iter().any(|j| j.name == file.name) {
            return Err(doc.fault(&at("name"), format!("there is a joint `{}` already", file.name)));
        }
        let bodies = self.ends(key, &file.a, &file.b)?;
        finite(doc, &at("position"), &file.position)?;
        let z = direction(doc, &at("axis"), file.axis)?;
        let turn = match file.axis_x {
            Some(x) => {
                let x = direction(doc, &at("axis_x"), x)?;
                let x =
                    x.reject_from_normalized(z).try_normalize().filter(|_| x.dot(z).abs() < 0.999).ok_or_else(
                        || doc.fault(&at("axis_x"), "is along `axis`: expected a direction square to it"),
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
        let length = match &file.length {
            Some(f) if long => self.function(&at("length"), f)?,
            Some(_) => return Err(doc.fault(&at("length"), "is only for distance and revolute_spherical joints")),
            None => Function::Constant((pb - pa).length()),
        };
        if long && !(length.at(0.0) > 0.0) {
            return Err(doc.fault(&at("position_b"), "the joint's two points coincide: it has no length"));
        }
        if file.kind == JointKind::RevoluteSpherical && (pb - pa).normalize().dot(z).abs() > 1e-6 {
            return Err(doc.fault(&at("axis"), "is not square to the line between the joint's two points"));
        }
        let motor = match &file.motor {
            Some(m) => Some(self.motor(&at("motor"), file.kind, m)?),
            None => None,
        };
        let angle = matches!(file.kind, JointKind::Revolute | JointKind::Cylindrical);
        let limits = match file.limits {
            Some(_) if file.kind.coordinate().is_none() => {
                return Err(doc.fault(&at("limits"), "this kind of joint has no coordinate to limit"));
            }
            Some([lo, hi]) => {
                if !(lo < hi) {
                    return Err(doc.fault(&at("limits"), format!("run from {lo} to {hi}, expected the smaller first")));
                }
                Some(if angle { [lo.to_radians(), hi.to_radians()] } else { [lo, hi] })
            }
            None => None,
        };
        let [from, until] = self.interval(key, file.from, file.until, begins)?;
        let frame = |p: DVec3| Pose { position: p, orientation: turn };
        let joint = Joint {
            name: file.name.clone(),
            kind: file.kind,
            bodies,
            frame_a: self.in_body(bodies[0], frame(pa)),
            frame_b: self.in_body(bodies[1], frame(pb)),
            length,
            limits,
            motor,
            from,
            until,
        };
        self.model.joints.push(joint);
        if !file.collide {
            self.apart.push([bodies[0].min(bodies[1]), bodies[0].max(bodies[1])]);
        }
        Ok(())
    }

    fn motor(&self, key: &str, kind: JointKind, m: &MotorFile) -> Result<Motor, Fault> {
        let doc = self.doc;
        let turns = matches!(kind, JointKind::Revolute | JointKind::Cylindrical);
        if !turns && kind != JointKind::Prismatic {
            return Err(doc
                .fault(key, "only revolute, cylindrical and prismatic joints have motors")
                .hint("a distance joint becomes a linear actuator by its `length`"));
        }
        match (&m.speed, &m.motion, &m.torque, &m.force) {
            (Some(f), None, None, None) => Ok(Motor::Speed(self.function(&format!("{key}.speed"), f)?)),
            (None, Some(f), None, None) => Ok(Motor::Position(self.function(&format!("{key}.motion"), f)?)),
            (None, None, Some(f), None) if turns => Ok(Motor::Effort(self.function(&format!("{key}.torque"), f)?)),
            (None, None, None, Some(f)) if !turns => Ok(Motor::Effort(self.function(&format!("{key}.force"), f)?)),
            _ => {
                let effort = if turns { "torque" } else { "force" };
                Err(doc.fault(key, format!("needs exactly one of `speed`, `motion` and `{effort}`")))
            }
        }
    }

    fn spring(&mut self, key: &str, file: &SpringFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let at = |part: &str| format!("{key}.{part}");
        if self.model.springs.iter().any(|s| s.name == file.name) {
            return Err(doc.fault(&at("name"), format!("there is a spring `{}` already", file.name)));
        }
        let bodies = self.ends(key, &file.a, &file.b)?;
        finite(doc, &at("position"), &file.position)?;
        not_negative(doc, &at("stiffness"), file.stiffness)?;
        not_negative(doc, &at("damping"), file.damping)?;
        let pa = DVec3::from(file.position);
        let pb = file.position_b.map_or(pa, DVec3::from);
        finite(doc, &at("position_b"), &pb.to_array())?;
        let turn = match file.about {
            Some(axis) => DQuat::from_rotation_arc(DVec3::Z, direction(doc, &at("about"), axis)?),
            None => DQuat::IDENTITY,
        };
        if file.about.is_none() && !((pb - pa).length() > 0.0) {
            return Err(doc.fault(&at("position_b"), "the spring's two points coincide: it has no line to act along"));
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
        self.model.springs.push(Spring {
            name: file.name.clone(),
            bodies,
            frame_a: self.in_body(bodies[0], Pose { position: pa, orientation: turn }),
            frame_b: self.in_body(bodies[1], Pose { position: pb, orientation: turn }),
            rotational: file.about.is_some(),
            stiffness: file.stiffness,
            damping: file.damping,
            rest,
            preload,
            from,
            until,
        });
        Ok(())
    }

    fn load(&mut self, key: &str, file: &LoadFile, begins: f64) -> Result<(), Fault> {
        let doc = self.doc;
        let at = |part: &str| format!("{key}.{part}");
        let body = self.find(&at("body"), &file.body)?;
        if !self.moves_ever(body) {
            return Err(doc.fault(&at("body"), format!("`{}` is held in place: a load does nothing to it", file.body)));
        }
        let (torque, v) = match (file.force, file.torque) {
            (Some(f), None) => (false, f),
            (None, Some(t)) => (true, t),
            _ => return Err(doc.fault(key, "needs exactly one of `force` and `torque`")),
        };
        let direction = direction(doc, &at(if torque { "torque" } else { "force" }), v)?;
        let point = match file.point {
            Some(_) if torque => return Err(doc.fault(&at("point"), "a torque has no point")),
            Some(p) => {
                finite(doc, &at("point"), &p)?;
                let frame = self.model.body_frame[body as usize];
                frame.position + frame.orientation * DVec3::from(p)
            }
            None => DVec3::ZERO,
        };
        let [from, until] = self.interval(key, file.from, file.until, begins)?;
        let value = self.function(&at("value"), &file.value)?;
        self.model.loads.push(Load {
            body,
            torque,
            direction,
            follows: file.frame == LoadFrame::Body,
            point,
            value,
            from,
            until,
        });
        Ok(())
    }

    fn function(&self, key: &str, file: &FunctionFile) -> Result<Function, Fault> {
        let doc = self.doc;
        let sound = |values: &[f64]| finite(doc, key, values);
        match file {
            FunctionFile::Constant(x) => {
                sound(&[*x])?;
                Ok(Function::Constant(*x))
            }
            FunctionFile::Step { step } => {
                sound(&[step.before, step.after, step.at])?;
                Ok(Function::Step { before: step.before, after: step.after, at: step.at })
            }
            FunctionFile::Ramp { ramp } => {
                sound(&ramp.values)?;
                sound(&ramp.times)?;
                if !(ramp.times[1] > ramp.times[0]) {
                    return Err(doc.fault(&format!("{key}.ramp.times"), "expected the earlier time first"));
                }
                Ok(Function::Ramp { values: ramp.values, times: ramp.times })
            }
            FunctionFile::Sine { sine } => {
                sound(&[sine.mean, sine.amplitude, sine.frequency, sine.phase])?;
                Ok(Function::Sine {
                    mean: sine.mean,
                    amplitude: sine.amplitude,
                    frequency: sine.frequency,
                    phase: sine.phase.to_radians(),
                })
            }
            FunctionFile::Table { table } => self.table(&format!("{key}.table"), table.clone()),
            FunctionFile::Csv { csv } => {
                let key = format!("{key}.csv");
                let text =
                    std::fs::read_to_string(csv).map_err(|e| doc.fault(&key, format!("{}: {e}", csv.display())))?;
                let mut points = vec![];
                for (i, line) in text.lines().enumerate() {
                    let line = line.trim();
                    if line.is_empty() || line.starts_with('#') {
                        continue;
                    }
                    let cells: Vec<&str> = line.split([',', ';', '\t', ' ']).filter(|c| !c.is_empty()).collect();
                    match cells.iter().take(2).map(|c| c.parse::<f64>()).collect::<Result<Vec<f64>, _>>() {
                        Ok(pair) if pair.len() == 2 => points.push([pair[0], pair[1]]),
                        // The first line may be a header.
                        _ if points.is_empty() && i == 0 => {}
                        _ => {
                            let message =
                                format!("{}, line {}: expected two numbers, time and value", csv.display(), i + 1);
                            return Err(doc.fault(&key, message));
                        }
                    }
                }
                self.table(&key, points)
            }
        }
    }

    fn table(&self, key: &str, points: Vec<[f64; 2]>) -> Result<Function, Fault> {
        points.iter().try_for_each(|p| finite(self.doc, key, p))?;
        if points.is_empty() {
            return Err(self.doc.fault(key, "has no points: expected pairs of time and value"));
        }
        match points.windows(2).find(|p| !(p[1][0] > p[0][0])) {
            Some(p) => Err(self.doc.fault(key, format!("times must rise, but {} s follows {} s", p[1][0], p[0][0]))),
            None => Ok(Function::Table(points)),
        }
    }

    fn release(&mut self, key: &str, name: &str, time: f64) -> Result<(), Fault> {
        let body = self.find(key, name)?;
        let model = &mut self.model;
        match model.late.iter_mut().find(|l| l.body == body) {
            Some(late) => late.moves = late.moves.max(time),
            None => {
                let (inv_mass, inv_inertia) = (model.inv_mass[body as usize], model.inv_inertia[body as usize]);
                if inv_mass == 0.0 {
                    return Err(self.doc.fault(key, format!("`{name}` is fixed and cannot be let go")));
                }
                model.late.push(Late { body, appears: 0.0, moves: time, inv_mass, inv_inertia });
            }
        }
        if time > 0.0 {
            (model.inv_mass[body as usize], model.inv_inertia[body as usize]) = (0.0, DVec3::ZERO);
        }
        Ok(())
    }

    /// The bodies of another run as they were at its last checkpoint, with the joints, springs and loads among them.
    fn base(&mut self, base: &BaseFile) -> Result<(), Fault> {
        let doc = self.doc;
        let fail = |key: &str, message: String| doc.fault(&format!("base.{key}"), message);
        let (file, other): (ModelFile, Resolved) =
            super::read(&base.run.join("model.yaml")).map_err(|f| fail("run", format!("its model: {}", f.message)))?;
        let latest = checkpoint::latest(&base.run).map_err(|f| fail("run", f.message.clone()))?;
        let Some(path) = latest else {
            return Err(fail("run", format!("{} has no checkpoint to go on from", base.run.display())));
        };
        let (state, _) = checkpoint::read(&path).map_err(|f| fail("run", f.message.clone()))?;
        let other_model = crate::Simulation::new(other.model, state.clone()).model;
        if state.position.len() != other_model.n_bodies() {
            return Err(fail("run", "its checkpoint is not of its model".into()));
        }
        for (name, material) in file.materials {
            self.materials.entry(name).or_insert(material);
        }
        self.model.material_names = self.materials.keys().cloned().collect();
        let wanted = |b: usize| {
            let class = &other_model.class_names[other_model.class[b] as usize];
            !other_model.absent[b] && base.classes.as_ref().is_none_or(|c| c.contains(class))
        };
        if let Some(classes) = &base.classes {
            let known: Vec<&str> = other_model.class_names.iter().map(String::as_str).collect();
            if let Some(name) = classes.iter().find(|c| !known.contains(&c.as_str())) {
                return Err(doc.unknown("base.classes", "class", name, &known));
            }
        }
        let mut number = vec![u32::MAX; other_model.n_bodies()];
        for b in (0..other_model.n_bodies()).filter(|b| wanted(*b)) {
            number[b] = self.model.n_bodies() as u32;
            let class = self.class(&other_model.class_names[other_model.class[b] as usize]);
            let model = &mut self.model;
            model.inv_mass.push(other_model.inv_mass[b]);
            model.inv_inertia.push(other_model.inv_inertia[b]);
            model.absent.push(false);
            model.class.push(class);
            model.body_frame.push(other_model.body_frame[b]);
            self.state.position.push(state.position[b]);
            self.state.orientation.push(state.orientation[b]);
            let still = base.at_rest;
            self.state.velocity.push(if still { DVec3::ZERO } else { state.velocity[b] });
            self.state.angular_velocity.push(if still { DVec3::ZERO } else { state.angular_velocity[b] });
        }
        for (name, b) in other_model.body_names.iter().filter(|(_, b)| number[**b as usize] != u32::MAX) {
            self.model.body_names.insert(name.clone(), number[*b as usize]);
        }
        for s in (0..other_model.n_shapes()).filter(|s| number[other_model.shape_body[*s] as usize] != u32::MAX) {
            let (kind, part) = (other_model.shape_kind[s], other_model.shape_part[s] as usize);
            let material = &other_model.material_names[other_model.shape_material[s] as usize];
            let group =
                self.group(Some(&other_model.group_names[other_model.shape_group[s] as usize]).map(|s| s.as_str()));
            let shape = Shape {
                hull: (kind == ShapeKind::Hull).then(|| other_model.hulls[part].clone()),
                surface: matches!(kind, ShapeKind::Mesh | ShapeKind::HeightField)
                    .then(|| other_model.surfaces[part].clone()),
                ..Shape::simple(kind, other_model.shape_size[s])
            };
            let (material, density) = self.material("base", &material.clone())?;
            let new = NewShape { shape, pose: other_model.shape_pose[s], material, density, group };
            self.add_shape(number[other_model.shape_body[s] as usize], other_model.shape_pose[s], new);
        }
        let kept = |bodies: [u32; 2]| {
            let pair = bodies.map(|b| number[b as usize]);
            (!pair.contains(&u32::MAX)).then_some(pair)
        };
        for j in &other_model.joints {
            if let Some(bodies) = kept(j.bodies) {
                self.model.joints.push(Joint { bodies, from: 0.0, ..j.clone() });
            }
        }
        for s in &other_model.springs {
            if let Some(bodies) = kept(s.bodies) {
                self.model.springs.push(Spring { bodies, from: 0.0, ..s.clone() });
            }
        }
        self.apart.extend(other_model.apart.iter().filter_map(|p| kept(*p)).map(|[a, b]| [a.min(b), a.max(b)]));
        let n = other_model.group_names.len();
        for (k, _) in other_model.groups_pass.iter().enumerate().filter(|(_, pass)| **pass) {
            let names = [&other_model.group_names[k / n], &other_model.group_names[k % n]];
            let pair = [self.group(Some(names[0])), self.group(Some(names[1]))];
            self.groups_pass.push(pair);
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Resolved, Fault> {
        self.laws()?;
        for (i, [a, b]) in self.file.pass_through.iter().enumerate() {
            let known: Vec<&str> = self.model.group_names.iter().map(String::as_str).collect();
            for name in [a, b] {
                if !known.contains(&name.as_str()) {
                    return Err(self.doc.unknown(&format!("pass_through.{i}"), "group", name, &known));
                }
            }
            let pair = [self.group(Some(a)), self.group(Some(b))];
            self.groups_pass.push(pair);
        }
        let n = self.model.group_names.len();
        self.model.groups_pass = vec![false; n * n];
        for [a, b] in &self.groups_pass {
            self.model.groups_pass[*a as usize * n + *b as usize] = true;
            self.model.groups_pass[*b as usize * n + *a as usize] = true;
        }
        self.apart.sort_unstable();
        self.apart.dedup();
        self.model.apart = std::mem::take(&mut self.apart);
        self.model.late.sort_by_key(|l| l.body);
        self.choose_envelope();
        self.joint_states();
        let probes = self.probes()?;
        let model = self.model;
        let (warnings, key_of) = (self.warnings, self.key_of_body);
        let mut resolved = Resolved { model, state: self.state, probes, stages: self.stages, warnings };
        overlaps(&mut resolved, self.doc, &key_of)?;
        Ok(resolved)
    }

    /// Angles and lengths of the joints and springs at the start.
    fn joint_states(&mut self) {
        for j in &self.model.joints {
            let f = Frames::of(j.bodies, &j.frame_a, &j.frame_b, &self.state);
            let coordinate = j.coordinate(&f, &JointState::default());
            self.state.joints.push(JointState { coordinate, ..JointState::default() });
        }
        for s in &self.model.springs {
            let f = Frames::of(s.bodies, &s.frame_a, &s.frame_b, &self.state);
            let coordinate = s.row(&f, &Default::default()).psi;
            self.state.springs.push(crate::joint::SpringState { coordinate, ..Default::default() });
        }
    }

    /// The envelope as given, or a fiftieth of the least half length of what moves.
    fn choose_envelope(&mut self) {
        let least = (0..self.model.n_shapes())
            .filter(|s| self.moves_ever(self.model.shape_body[*s]))
            .map(|s| self.model.shape_size[s].min_element())
            .fold(f64::INFINITY, f64::min);
        let default = if least.is_finite() { 0.02 * least } else { 1e-3 };
        self.model.envelope = self.file.solver.envelope.unwrap_or(default);
    }

    fn probes(&self) -> Result<Probes, Fault> {
        let (file, model, doc) = (&self.file.probes, &self.model, self.doc);
        let bodies = match &file.bodies {
            None => self.probe_bodies.clone(),
            Some(patterns) => {
                let mut found = vec![];
                for (i, p) in patterns.iter().enumerate() {
                    let before = found.len();
                    found.extend(model.body_names.iter().filter(|(n, _)| matches(p, n)).map(|(_, b)| *b));
                    if found.len() == before {
                        let known: Vec<&str> = model.body_names.keys().map(String::as_str).collect();
                        return Err(doc.unknown(&format!("probes.bodies.{i}"), "body", p, &known));
                    }
                }
                found
            }
        };
        let (mut joints, mut springs) = (self.probe_joints.clone(), self.probe_springs.clone());
        if let Some(patterns) = &file.joints {
            (joints, springs) = (vec![], vec![]);
            for (i, p) in patterns.iter().enumerate() {
                let before = joints.len() + springs.len();
                joints.extend((0..model.joints.len()).filter(|j| matches(p, &model.joints[*j].name)).map(|j| j as u32));
                springs
                    .extend((0..model.springs.len()).filter(|j| matches(p, &model.springs[*j].name)).map(|j| j as u32));
                if joints.len() + springs.len() == before {
                    let known: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
                    return Err(doc.unknown(&format!("probes.joints.{i}"), "joint or spring", p, &known));
                }
            }
        }
        let mut contacts = vec![];
        for (i, c) in file.contacts.iter().enumerate() {
            let mut pair = [0; 2];
            for (slot, name) in pair.iter_mut().zip(&c.between) {
                let known: Vec<&str> = model.class_names.iter().map(String::as_str).collect();
                *slot = known
                    .iter()
                    .position(|n| n == name)
                    .ok_or_else(|| doc.unknown(&format!("probes.contacts.{i}.between"), "class", name, &known))?
                    as u32;
            }
            contacts.push((c.name.clone(), pair));
        }
        Ok(Probes {
            interval: file.interval.unwrap_or(model.step),
            bodies,
            joints,
            springs,
            contacts,
            energies: !file.no_energies,
            contact_tables: file.contact_tables,
        })
    }
}

/// Radii to draw from.
enum Radii {
    Uniform(f64, f64),
    Normal(NormalFile),
    /// Pairs of radius and the share of all grains, by number, up to it.
    Sieve(Vec<[f64; 2]>),
}

impl Radii {
    /// From shares of mass to shares of number: a fraction's grains are as many as its mass over the cube of its size.
    fn sieve(curve: &[[f64; 2]]) -> Radii {
        let mut number = vec![[0.5 * curve[0][0], 0.0]];
        for pair in curve.windows(2) {
            let ([d0, p0], [d1, p1]) = (pair[0], pair[1]);
            // Sizes are spread evenly between two meshes: the mean of d⁻³ there.
            let mean = 0.5 * (d0.powi(-2) - d1.powi(-2)) / (d1 - d0);
            let before = number.last().map_or(0.0, |n| n[1]);
            number.push([0.5 * d1, before + (p1 - p0) * mean]);
        }
        let all = number.last().map_or(1.0, |n| n[1]);
        number.iter_mut().for_each(|n| n[1] /= all);
        Radii::Sieve(number)
    }

    fn greatest(&self) -> f64 {
        match self {
            Radii::Uniform(_, most) => *most,
            Radii::Normal(n) => n.greatest,
            Radii::Sieve(curve) => curve.last().map_or(0.0, |p| p[0]),
        }
    }

    fn draw(&self, random: &mut SplitMix64) -> f64 {
        match self {
            Radii::Uniform(least, most) => random.between(*least, *most),
            Radii::Normal(n) => loop {
                let (u, v) = (1.0 - random.uniform(), random.uniform());
                let z = (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos();
                let r = n.mean + n.deviation * z;
                if (n.least..=n.greatest).contains(&r) {
                    return r;
                }
            },
            Radii::Sieve(curve) => {
                let u = random.uniform();
                let k = curve.partition_point(|p| p[1] <= u).clamp(1, curve.len() - 1);
                let ([r0, p0], [r1, p1]) = (curve[k - 1], curve[k]);
                // Within a fraction the share by mass is even, so the density by number falls with the cube of the size.
                let t = if p1 > p0 { (u - p0) / (p1 - p0) } else { 0.0 };
                (r0.powi(-2) + t * (r1.powi(-2) - r0.powi(-2))).powf(-0.5)
            }
        }
    }
}

/// The number of a name in a list, which it is added to if need be.
fn number_of(names: &mut Vec<String>, name: &str) -> u32 {
    names.iter().position(|n| n == name).unwrap_or_else(|| {
        names.push(name.into());
        names.len() - 1
    }) as u32
}

/// Bodies that overlap at the start: deeper than a radius is an error, deeper than a tenth of it is told.
fn overlaps(resolved: &mut Resolved, doc: &Document, key_of: &BTreeMap<u32, String>) -> Result<(), Fault> {
    let Resolved { model, state, warnings, .. } = resolved;
    let found = crate::stages::overlaps(model, state);
    let mut told = 0;
    for o in &found {
        let radius = o.shapes.map(|s| match model.shape_kind[s as usize] {
            kind if kind.is_surface() => f64::INFINITY,
            _ => model.shape_size[s as usize].min_element(),
        });
        let least = radius[0].min(radius[1]);
        let [a, b] = o.bodies.map(|b| model.body_label(b as usize));
        let text = format!("bodies {a} and {b} overlap by {:.3e} m at the start", o.depth);
        if o.depth > least {
            let key = o.bodies.iter().rev().find_map(|b| key_of.get(b)).cloned().unwrap_or_default();
            return Err(doc
                .fault(&key, format!("{text}, more than a radius of {least:.3e} m"))
                .hint("move one of them, put them in groups that pass through each other, or join them"));
        }
        if o.depth > 0.1 * least {
            told += 1;
            if told <= 5 {
                warnings.push(text);
            }
        }
    }
    if told > 5 {
        warnings.push(format!("{} more pairs of bodies overlap at the start", told - 5));
    }
    Ok(())
}

impl ModelFile {
    /// Make the paths of all files absolute, so that the resolved model can be read from elsewhere.
    pub fn anchor_paths(&mut self, folder: &std::path::Path) {
        let anchor = |p: &mut PathBuf| {
            let joined = folder.join(&*p);
            *p = std::path::absolute(&joined).unwrap_or(joined);
        };
        if let Some(base) = &mut self.base {
            anchor(&mut base.run);
        }
        let functions = |f: &mut FunctionFile| {
            if let FunctionFile::Csv { csv } = f {
                anchor(csv);
            }
        };
        let stages = self
            .stages
            .iter_mut()
            .map(|s| (&mut s.bodies, &mut s.joints, &mut s.springs, &mut s.loads, &mut s.assemblies));
        let all = std::iter::once((
            &mut self.bodies,
            &mut self.joints,
            &mut self.springs,
            &mut self.loads,
            &mut self.assemblies,
        ));
        for (bodies, joints, springs, loads, assemblies) in all.chain(stages) {
            for body in bodies {
                let parts = body.shapes.iter_mut().flatten();
                let own = (&mut body.hull, &mut body.mesh, &mut body.height_field);
                for (hull, mesh, field) in
                    std::iter::once(own).chain(parts.map(|p| (&mut p.hull, &mut p.mesh, &mut p.height_field)))
                {
                    hull.iter_mut().filter_map(|h| h.file.as_mut()).for_each(anchor);
                    mesh.iter_mut().for_each(|m| anchor(&mut m.file));
                    field.iter_mut().for_each(|f| f.image.iter_mut().chain(&mut f.grid).for_each(anchor));
                }
            }
            for joint in joints {
                joint.length.iter_mut().for_each(functions);
                for m in joint.motor.iter_mut() {
                    for f in [&mut m.speed, &mut m.motion, &mut m.torque, &mut m.force] {
                        f.iter_mut().for_each(functions);
                    }
                }
            }
            springs.iter_mut().flat_map(|s| s.preload.iter_mut()).for_each(functions);
            loads.iter_mut().for_each(|l| functions(&mut l.value));
            for a in assemblies {
                a.tracked_vehicle.iter_mut().flat_map(|v| v.torque.iter_mut()).for_each(functions);
                a.helical_anchor.iter_mut().flat_map(|a| [&mut a.torque, &mut a.pull]).for_each(functions);
            }
        }
    }
}
