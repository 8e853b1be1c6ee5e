//! Resolution of a model file to the columns of a model: every value is checked, and every fault has its key.

mod base;
mod bodies;
mod fills;
mod joints;
mod loads;
mod probes;
mod start;

use super::shape::{self, Shape, at_most_one, direction, finite, not_negative, orientation, positive};
use super::types::*;
use super::{Probes, Resolved};
use crate::checkpoint;
use crate::contacts::Contacts;
use crate::geometry::{Surface, principal, solid_of};
use crate::joint::{Joint, JointKind, Spring, SpringKind, SpringState};
use crate::load::{Function, Load};
use crate::sleep;
use crate::terrain::Ground;
use crate::{ContactLaw, Model, Pose, Scheduled, ShapeKind, SplitMix64, State, fill};
use frame::Fault;
use frame::sequence::matches;
use frame::yaml::Document;
use glam::{DMat3, DQuat, DVec3};
use start::Keys;
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

/// The most steps of a run: a million bodies, or one, take longer than anybody waits for.
const MAX_STEPS: f64 = 1e12;

/// The most frames that repeat the state after one step.
const MAX_FRAMES_PER_STEP: f64 = 100.0;

/// From this relaxation factor on, no sweep converges.
const MAX_OMEGA: f64 = 2.0;

/// Longest name of a stage, bytes: that of its checkpoint has an ending, too, and systems take 255.
const LONGEST_NAME: usize = 200;

impl ModelFile {
    /// The model as YAML, with its defaults filled in.
    pub fn to_yaml(&self) -> String {
        serde_yaml::to_string(self).expect("a model is plain data")
    }

    /// Duration of the run, s: `duration`, or the sum of the stages' durations if there are stages.
    pub fn whole_duration(&self) -> f64 {
        if self.stages.is_empty() { self.duration } else { self.stages.iter().map(|s| s.duration).sum() }
    }

    /// Check every value and build the columns; `doc` is the document that the file was read from.
    ///
    /// # Errors
    /// The first fault, with the line and column of its key in `doc`.
    pub fn resolve(&self, doc: &Document) -> Result<Resolved, Fault> {
        let (mut resolved, keys) = self.build(doc)?;
        start::overlaps(&mut resolved, doc, &keys)?;
        start::jumps(&mut resolved, doc, &keys);
        start::stiff_springs(&mut resolved, doc, &keys);
        Ok(resolved)
    }

    /// [`ModelFile::resolve`] but for the checks of the state at the start, which take the keys.
    pub(super) fn build(&self, doc: &Document) -> Result<(Resolved, Keys), Fault> {
        self.check_numbers(doc)?;
        let mut build = Builder::new(self, doc);
        build.warnings = self.doubts(doc);
        if let Some(base) = &self.base {
            build.base(base)?;
        }
        build.content("", self.content(), 0.0)?;
        let mut begin = 0.0;
        for (i, stage) in self.stages.iter().enumerate() {
            let key = format!("stages.{i}");
            positive(doc, &format!("{key}.duration"), stage.duration)?;
            // Its checkpoint is a file of this name.
            let is_bad = |c: char| c.is_control() || c == '/' || c == '\\';
            if stage.name.is_empty() || stage.name.contains(is_bad) || stage.name.len() > LONGEST_NAME {
                let message =
                    format!("names a file: expected letters, digits and signs but / and \\, at most {LONGEST_NAME}");
                return Err(doc.fault(&format!("{key}.name"), message));
            }
            if let Some(first) = self.stages[..i].iter().position(|s| s.name == stage.name) {
                let message = format!("stage {} has this name too: each has a checkpoint of its own name", first + 1);
                return Err(doc.fault(&format!("{key}.name"), message));
            }
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

    /// Warnings of values that are sound, but hardly meant.
    fn doubts(&self, doc: &Document) -> Vec<String> {
        /// Density below which it is taken for one in g/cm³, kg/m³. Foams have more, and no solid has as much in g/cm³.
        const MIN_DENSITY: f64 = 23.0;
        let mut doubts = vec![];
        for (name, m) in self.materials.iter().filter(|(_, m)| m.density < MIN_DENSITY) {
            let message = format!("a density of {} kg/m³ is that of a light foam", m.density);
            let hint = format!("densities are in kg/m³: {} g/cm³ is {}", m.density, (m.density * 1e6).round() / 1e3);
            doubts.push(doc.fault(&format!("materials.{name}.density"), message).hint(hint));
        }
        if self.frame_rate * self.step > 1.0 + 1e-9 {
            let steps = (1e3 / self.step).round() / 1e3;
            let message = format!("{} frames a second are more than the {steps} steps: frames repeat", self.frame_rate);
            // What is not written has no line; of the two, either may be a default or the quality's.
            let key = ["frame_rate", "step", "quality"].into_iter().find(|key| doc.has(key)).unwrap_or("frame_rate");
            doubts.push(doc.fault(key, message).hint("take fewer frames, or a shorter `step`"));
        }
        doubts.iter().map(Fault::to_string).collect()
    }

    fn check_numbers(&self, doc: &Document) -> Result<(), Fault> {
        let s = &self.solver;
        for (key, value) in [
            ("step", self.step),
            ("duration", self.duration),
            ("frame_rate", self.frame_rate),
            ("solver.omega", s.omega.unwrap_or(1.0)),
            ("solver.lambda", s.lambda),
            ("solver.iterations", s.iterations.unwrap_or(1) as f64),
            ("solver.start_iterations", s.start_iterations.unwrap_or(1) as f64),
            ("solver.overlap_tolerance", s.overlap_tolerance.unwrap_or(1.0)),
            ("solver.settling_tolerance", s.settling_tolerance.unwrap_or(1.0)),
            ("solver.recovery_speed", s.recovery_speed),
            ("checkpoint_interval", self.checkpoint_interval.unwrap_or(1.0)),
            ("probes.interval", self.probes.interval.unwrap_or(1.0)),
        ] {
            positive(doc, key, value)?;
        }
        let steps = self.whole_duration() / self.step;
        if steps > MAX_STEPS {
            let message =
                format!("{:.0e} s in steps of {:.0e} s are {steps:.0e} steps", self.whole_duration(), self.step);
            return Err(doc.fault("step", message).hint("times are in seconds"));
        }
        if self.frame_rate * self.step > MAX_FRAMES_PER_STEP {
            let message =
                format!("{:e} frames a second are {:.0e} of each step", self.frame_rate, self.frame_rate * self.step);
            return Err(doc.fault("frame_rate", message).hint("expected frames per second, as 25"));
        }
        let frames = self.whole_duration() * self.frame_rate;
        if frames > frame::run::MAX_FRAMES as f64 {
            let message = format!("{:e} frames a second are {frames:.0e} frames", self.frame_rate);
            return Err(doc.fault("frame_rate", message).hint("expected frames per second, as 25"));
        }
        finite(doc, "gravity", &self.gravity)?;
        let lengths = [
            ("tolerance", Some(s.tolerance)),
            ("envelope", s.envelope),
            ("recycle", s.recycle),
            ("rest_gap", Some(s.rest_gap)),
            ("rest_speed", Some(s.rest_speed)),
            ("sleep", s.sleep),
        ];
        for (key, value) in lengths.into_iter().filter_map(|(key, value)| Some((key, value?))) {
            not_negative(doc, &format!("solver.{key}"), value)?;
        }
        if let Some(omega) = s.omega.filter(|omega| *omega >= MAX_OMEGA) {
            return Err(doc.fault("solver.omega", format!("is {omega}, expected less than {MAX_OMEGA}")));
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
            at_most_one(doc, &key("restitution"), m.restitution)?;
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
    stages: Vec<(String, f64)>,
    keys: Keys,
    /// Bodies, joints and springs that are probed by default.
    probe_bodies: Vec<u32>,
    probe_joints: Vec<u32>,
    probe_springs: Vec<u32>,
    warnings: Vec<String>,
    /// Indices of the hulls, by the bits of their vertices.
    hulls: HashMap<Vec<[u64; 3]>, u32>,
    /// Hulls that were made, by what they were made of.
    made: shape::Hulls,
    class_names: Names,
    group_names: Names,
    joint_names: Names,
    spring_names: Names,
}

/// The names of a column so far, those of its first `n` rows, with the row that was first to have each.
#[derive(Default)]
struct Names {
    known: HashMap<String, u32>,
    n: usize,
}

impl Names {
    /// The first row with a name; the column may have become longer.
    fn find<T>(&mut self, column: &[T], name_of: impl Fn(&T) -> &String, name: &str) -> Option<u32> {
        for (i, row) in column.iter().enumerate().skip(self.n) {
            self.known.entry(name_of(row).clone()).or_insert(i as u32);
        }
        self.n = column.len();
        self.known.get(name).copied()
    }

    /// The row of a name, which is added if it is missing.
    fn id(&mut self, names: &mut Vec<String>, name: &str) -> u32 {
        self.find(names, |name| name, name).unwrap_or_else(|| {
            names.push(name.into());
            names.len() as u32 - 1
        })
    }
}

/// A shape to be added to the columns.
struct NewShape {
    shape: Shape,
    pose: Pose,
    material: u32,
    density: f64,
    group: u32,
}

/// A body to be added to the columns.
struct NewBody {
    class: u32,
    /// Pose of the file's body frame, world.
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
            part: 1.0,
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
            stages: vec![],
            keys: Keys::default(),
            probe_bodies: vec![],
            probe_joints: vec![],
            probe_springs: vec![],
            warnings: vec![],
            hulls: HashMap::new(),
            made: HashMap::new(),
            class_names: Names::default(),
            group_names: Names::default(),
            joint_names: Names::default(),
            spring_names: Names::default(),
        }
    }

    /// Set the contact laws of all pairs of materials.
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
            at_most_one(self.doc, &format!("{key}.restitution"), pair.restitution.unwrap_or(0.0))?;
            for (i, j) in [(index[0], index[1]), (index[1], index[0])] {
                let law = &mut laws[i * n + j];
                law.friction = pair.friction.unwrap_or(law.friction);
                law.restitution = pair.restitution.unwrap_or(law.restitution);
                law.cohesion = pair.cohesion.unwrap_or(law.cohesion);
                law.rolling = pair.rolling.unwrap_or(law.rolling);
                law.spinning = pair.spinning.unwrap_or(law.spinning);
            }
        }
        self.model.laws = laws;
        Ok(())
    }

    fn material(&self, key: &str, name: &str) -> Result<(u32, f64), Fault> {
        // The names are in order: they are the keys of the map.
        match self.model.material_names.binary_search_by(|known| known.as_str().cmp(name)) {
            Ok(i) => Ok((i as u32, self.materials[name].density)),
            Err(_) => {
                let known: Vec<&str> = self.materials.keys().map(String::as_str).collect();
                Err(self.doc.unknown(key, "material", name, &known))
            }
        }
    }

    fn class(&mut self, name: &str) -> u32 {
        self.class_names.id(&mut self.model.class_names, name)
    }

    fn group(&mut self, name: Option<&str>) -> u32 {
        name.map_or(0, |n| self.group_names.id(&mut self.model.group_names, n))
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

    fn moves_ever(&self, body: u32) -> bool {
        self.model.inv_mass[body as usize] > 0.0
    }

    fn finish(mut self) -> Result<(Resolved, Keys), Fault> {
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
        self.model.exclude(0.0);
        self.model.scheduled.sort_by_key(|s| s.body);
        self.choose_envelope()?;
        self.joint_states();
        let probes = self.probes()?;
        let model = self.model;
        let (warnings, keys) = (self.warnings, self.keys);
        let resolved = Resolved { model, state: self.state, probes, stages: self.stages, warnings };
        Ok((resolved, keys))
    }

    /// Angles and lengths of the joints and springs at the start.
    fn joint_states(&mut self) {
        for j in &self.model.joints {
            let f = self.state.joint_frames(j);
            let motion = j.bodies.map(|b| self.state.twist(b as usize));
            self.state.joints.push(j.at_start(&f, 0.0, motion));
        }
        for s in &self.model.springs {
            let f = self.state.spring_frames(s);
            let coordinate = s.coordinate(s.rows(&f, &Default::default()).map(|row| row.psi));
            self.state.springs.push(SpringState { coordinate, ..Default::default() });
        }
    }

    /// Set the envelope: as given, or a fiftieth of the smallest half length of a moving shape; and how far contact points are carried.
    ///
    /// # Errors
    /// A gap at rest beyond the envelope.
    fn choose_envelope(&mut self) -> Result<(), Fault> {
        let min = (0..self.model.n_shapes())
            .filter(|s| self.moves_ever(self.model.shape_body[*s]))
            .map(|s| self.model.shape_size[s].min_element())
            .fold(f64::INFINITY, f64::min);
        let default = if min.is_finite() { 0.02 * min } else { 1e-3 };
        self.model.envelope = self.file.solver.envelope.unwrap_or(default);
        self.model.recycle = self.file.solver.recycle.unwrap_or(1e-3 * self.model.envelope);
        let (gap, envelope) = (self.file.solver.rest_gap, self.model.envelope);
        if gap > envelope {
            let message = format!("is {gap} m, above the envelope of {envelope:.3e} m within which contacts are made");
            return Err(self.doc.fault("solver.rest_gap", message).hint("leave it to `quality`"));
        }
        Ok(())
    }
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
