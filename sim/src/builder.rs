//! A model built in code rather than read from a file.

use crate::Simulation;
use crate::joint::JointKind;
use crate::model_file::{
    BodyFile, BoxFile, CylinderFile, EllipsoidFile, JointFile, MaterialFile, ModelFile, PlaneFile, ShapeFile,
    SphereFile,
};
use frame::Fault;
use frame::yaml::Document;

/// Builder of a model in code: a [`ModelFile`] that is filled by calls. Every key of a model file is a field of the values that the
/// calls return, or of [`ModelBuilder::file`].
///
/// ```
/// use sim::{ModelBuilder, joint::JointKind, model_file::ShapeFile};
///
/// let mut model = ModelBuilder::new("pendulum");
/// model.file.step = 1e-3;
/// model.material("steel", 7800.0, 0.3);
/// model.body("ground", "steel", ShapeFile::plane([0.0, 0.0, 1.0]));
/// model.body("bob", "steel", ShapeFile::sphere(0.1)).position = [1.0, 0.0, 2.0];
/// let hinge = model.joint("hinge", JointKind::Revolute, "world", "bob");
/// (hinge.position, hinge.axis) = ([0.0, 0.0, 2.0], [0.0, 1.0, 0.0]);
///
/// let mut sim = model.simulation()?;
/// while sim.state.time < 0.5 {
///     let report = sim.step();
///     assert!(report.residual < 1e-6);
/// }
/// // Columns have one row per body.
/// let bob = sim.model.body_names["bob"] as usize;
/// assert!(sim.state.position[bob].z < 1.2);
/// // The reaction force of the hinge, N, in its frame.
/// assert!(sim.state.joints[0].force.length() > 0.0);
/// # Ok::<(), frame::Fault>(())
/// ```
#[derive(Clone, Debug)]
pub struct ModelBuilder {
    /// The model, in the types of a model file.
    pub file: ModelFile,
}

impl ModelBuilder {
    /// An empty model with a name and the defaults of a model file.
    pub fn new(name: &str) -> ModelBuilder {
        let mut file: ModelFile = serde_yaml::from_str("{}").expect("all keys of a model have defaults");
        file.name = name.into();
        ModelBuilder { file }
    }

    /// Add a material with a density, kg/m³, and a coefficient of friction.
    pub fn material(&mut self, name: &str, density: f64, friction: f64) -> &mut MaterialFile {
        let material = MaterialFile { density, friction, restitution: 0.0, cohesion: 0.0, rolling: 0.0, spinning: 0.0 };
        self.file.materials.insert(name.into(), material);
        self.file.materials.get_mut(name).expect("just put in")
    }

    /// Add a body of one shape, made of a material.
    pub fn body(&mut self, name: &str, material: &str, shape: ShapeFile) -> &mut BodyFile {
        let mut body = BodyFile::named(name);
        body.material = Some(material.into());
        body.set_shape(shape);
        self.file.bodies.push(body);
        self.file.bodies.last_mut().expect("just put in")
    }

    /// Add a joint between the bodies named `a` and `b`; `world` is the fixed world.
    pub fn joint(&mut self, name: &str, kind: JointKind, a: &str, b: &str) -> &mut JointFile {
        self.file.joints.push(JointFile::named(name, kind, a, b));
        self.file.joints.last_mut().expect("just put in")
    }

    /// Check the model and make it ready to run; if it has a `quality`, this chooses the step and the solver.
    ///
    /// # Errors
    /// The faults that a model file with this content would have.
    pub fn simulation(&self) -> Result<Simulation, Fault> {
        self.clone().into_simulation()
    }

    /// [`ModelBuilder::simulation`] of a model that is not needed any more.
    ///
    /// # Errors
    /// The same.
    #[allow(clippy::field_reassign_with_default, reason = "a document's other fields are its own")]
    pub fn into_simulation(mut self) -> Result<Simulation, Fault> {
        let mut doc = Document::default();
        doc.path = self.file.name.clone().into();
        self.file.choose(&doc)?;
        let resolved = self.file.resolve(&doc)?;
        Ok(Simulation::new(resolved.model, resolved.state))
    }
}

impl ShapeFile {
    /// A sphere by its radius, m.
    pub fn sphere(radius: f64) -> ShapeFile {
        ShapeFile { sphere: Some(SphereFile { radius }), ..ShapeFile::default() }
    }

    /// An ellipsoid by its half axes, m.
    pub fn ellipsoid(radii: [f64; 3]) -> ShapeFile {
        ShapeFile { ellipsoid: Some(EllipsoidFile { radii }), ..ShapeFile::default() }
    }

    /// A box by its edge lengths, m.
    pub fn cuboid(size: [f64; 3]) -> ShapeFile {
        ShapeFile { block: Some(BoxFile { size }), ..ShapeFile::default() }
    }

    /// A cylinder about local z by its radius and length, m.
    pub fn cylinder(radius: f64, length: f64) -> ShapeFile {
        ShapeFile { cylinder: Some(CylinderFile { radius, length }), ..ShapeFile::default() }
    }

    /// A capsule: a cylinder about local z by its radius and length, m, with hemispheres on its ends.
    pub fn capsule(radius: f64, length: f64) -> ShapeFile {
        ShapeFile { capsule: Some(CylinderFile { radius, length }), ..ShapeFile::default() }
    }

    /// A half space below the plane through the body's position, by its normal.
    pub fn plane(normal: [f64; 3]) -> ShapeFile {
        ShapeFile { plane: Some(PlaneFile { normal }), ..ShapeFile::default() }
    }
}
