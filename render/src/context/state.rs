//! The state between calls, and what all calls change it by: transformations, and primitives that are added to the scene.

use crate::context::copies::Copies;
use crate::context::geometry::Geometry;
use crate::context::motion_block::{Keys, MotionBlock, Moving, Place};
use crate::context::open_object::{Group, OpenObject, Uniform};
use crate::context::open_solid::OpenSolid;
use crate::context::result::RenderResult;
use crate::film::bucket::Shard;
use crate::gprim::perspective::{is_projective, projected};
use crate::gpu::render::Renderer;
use crate::scene::attached::Attached;
use crate::scene::attributes::{Attribute, Attributes};
use crate::scene::motion;
use crate::scene::options::{Hider, Options};
use crate::scene::patch::{Patch, TEXTURE_CORNERS};
use crate::scene::shape::Shape;
use crate::scene::source::{Part, Source, SourceShape, Wholes, instance_variables, repeats};
use crate::scene::variables::{VariableName, VariableNames};
use crate::scene::world::Scene;
use crate::texture;
use crate::warnings::Spot;
use glam::{Mat4, Vec3};
use ri::files::Files;
use ri::{Fail, Instances, RiResult};
use sl::ir::{Kind, Program};
use sl::machine::{BoundShader, VariableSlots};
use std::collections::HashMap;
use std::sync::Arc;

/// The greatest coordinate of a primitive, in the world and from the eye: squares of areas are numbers up to there.
const FARTHEST: f32 = 1e12;

/// A function that is called with the buckets done and in all.
type Progress = Box<dyn Fn(usize, usize) + Sync + Send>;

/// Options, attributes and lights before a frame.
type Saved = (Options, (Attributes, Geometry), Vec<(String, Arc<BoundShader>)>);

/// The renderer: takes the calls of the RenderMan Interface ([`ri::Ri`]), holds options, attributes and the scene between them, and
/// renders an image at each `WorldEnd`.
pub struct Context {
    pub(super) files: Files,
    pub(super) programs: HashMap<String, Arc<Program>>,
    pub(super) options: Options,
    /// What holds again after a frame: options, attributes and lights.
    pub(super) saved: Option<Saved>,
    pub(super) frame: i32,
    pub(super) attributes: Attributes,
    pub(super) attribute_stack: Vec<(Attributes, Place, Geometry)>,
    /// The current transformation, as the shutter opens.
    pub(super) transform: Mat4,
    /// Its keys over time, by the time of motion blocks; none if it stands still.
    pub(super) moves: Keys,
    pub(super) transform_stack: Vec<Place>,
    pub(super) to_camera: Option<Mat4>,
    pub(super) camera_moves: Keys,
    /// Attributes that primitives are made by.
    pub(super) geometry: Geometry,
    /// Count of the changes of attributes.
    pub(super) changes: u64,
    /// Solids that are open, the outermost first.
    pub(super) open_solids: Vec<OpenSolid>,
    /// Count of the primitives that were given, to the scene and to objects.
    pub(super) n_given: u64,
    /// Lights that were made, on or off, by their handles.
    pub(super) known_lights: Vec<(String, Arc<BoundShader>)>,
    /// Lights and spaces that were known before the world, in camera space.
    pub(super) before_world: (Vec<(String, Arc<BoundShader>)>, HashMap<String, Mat4>),
    /// Types of variables that `Declare` gave.
    pub(super) declared: HashMap<String, Kind>,
    pub(super) motion: Option<MotionBlock>,
    pub(super) made: texture::Made,
    /// What textures were made of since the last world began, by their names, and where: these files are still to be looked for.
    pub(super) sought: Vec<(String, texture::Source, Option<Spot>)>,
    pub(super) scene: Scene,
    pub(super) copies: Copies,
    /// The attributes that the patches of one primitive have in common, and the whole that these are parts of.
    pub(super) of_patches: Option<(Arc<Attributes>, Wholes)>,
    /// The wholes of the instances of an object.
    pub(super) of_instances: Option<Wholes>,
    /// Attributes and transformations that were kept when the world began.
    pub(super) outside: [usize; 2],
    pub(super) objects: HashMap<String, Arc<Vec<Group>>>,
    pub(super) open_object: Option<OpenObject>,
    pub(super) progress: Progress,
    /// The shard of each image to render; the whole image if not given.
    pub shard: Option<Shard>,
    /// Metadata for the image files, as keys and values.
    pub about: Vec<(String, String)>,
    /// The file of the image, which the caller names and which may be anywhere.
    pub image: Option<String>,
    /// Whether displays may be written outside of the folder that their names count from, by an absolute name or `..`.
    pub allow_outside: bool,
    /// The graphics device that images are drawn on; the processor draws them if there is none, and those that the device cannot draw.
    pub device: Option<Arc<Renderer>>,
    /// Whether the identities of what samples see are kept, to compare back ends.
    pub keep_ids: bool,
    /// Take all calls but render nothing: a check of a scene.
    pub dry: bool,
    /// Render results, one pushed at each `WorldEnd`; the caller takes them out.
    pub results: Vec<RenderResult>,
}

impl Context {
    /// Set a function that is called after each bucket with the count of buckets done and the count of all; it is called from any
    /// thread.
    pub fn on_progress(&mut self, progress: impl Fn(usize, usize) + Sync + Send + 'static) {
        self.progress = Box::new(progress);
    }

    /// Whether a `WorldBegin` waits for its `WorldEnd`.
    pub fn is_world_open(&self) -> bool {
        self.to_camera.is_some()
    }

    /// The warnings about the scene so far.
    pub fn warnings(&self) -> Vec<String> {
        self.scene.warnings.list()
    }

    /// Object to world: the current transformation after `WorldBegin`.
    pub(super) fn to_world(&self) -> Mat4 {
        self.transform
    }

    /// s and t of the corners of primitives that have no others; those of an object that sets none have them where they are instanced.
    pub(super) fn texture_corners(&self) -> [f32; 8] {
        let waits = self.open_object.is_some() && !self.attributes.set.has(Attribute::TextureCorners);
        if waits { TEXTURE_CORNERS } else { self.attributes.texture_corners }
    }

    /// Note that an attribute is set.
    pub(super) fn sets(&mut self, attribute: Attribute) {
        if let Some(block) = &mut self.motion {
            block.n_set += 1;
            if block.n_set == 2 {
                block.first = Some(Box::new(self.attributes.clone()));
            }
        }
        self.changes += 1;
        self.attributes.set.note(attribute, self.changes);
    }

    /// When the shutter opens and closes; what blurs nothing opens it for no time.
    pub(super) fn open_shutter(&self) -> [f32; 2] {
        let [open, close] = self.options.shutter;
        if self.options.hider == Hider::Depth { [open, open] } else { [open, close] }
    }

    /// Refuse what stands outside the world.
    pub(super) fn in_world(&self, what: &str) -> RiResult {
        if self.to_camera.is_some() {
            Ok(())
        } else {
            Err(Fail::new(format!("{what} stands outside the world, expected between WorldBegin and WorldEnd")))
        }
    }

    /// A primitive of no points.
    pub(super) fn draw_nothing(&mut self, what: &str) -> RiResult {
        if let Some(block) = &mut self.motion {
            block.n_set += 1;
        }
        self.in_world(what)
    }

    /// Another transformation in place of the current one.
    pub(super) fn set_transform(&mut self, m: Mat4) -> RiResult {
        match &mut self.motion {
            Some(block) => block.calls.push(Moving::Set(m)),
            None => (self.transform, self.moves) = (m, vec![]),
        }
        Ok(())
    }

    pub(super) fn place(&self) -> Place {
        (self.transform, self.moves.clone())
    }

    /// Say that a transformation has no inverse: a scale of 0 makes all that follows flat or a point.
    pub(super) fn say_flat(&self, m: &Mat4, what: &str) {
        if m.determinant() == 0.0 {
            self.scene.warn(format!("{what} cannot be inverted: what it holds for has no volume and may not be seen"));
        }
    }

    /// Say that a primitive is not before the eye of a transformation with a perspective.
    pub(super) fn say_behind(&self, m: &Mat4) {
        let what = if m.determinant() == 0.0 {
            "a primitive under a transformation that cannot be inverted is not drawn"
        } else {
            "a primitive goes behind the eye of a `Perspective` and is not drawn"
        };
        self.scene.warn(what.into());
    }

    /// Another transformation after the current one.
    pub(super) fn concat(&mut self, m: Mat4, what: &str) -> RiResult {
        if !m.is_finite() {
            return Err(Fail::new("the transformation is not finite"));
        }
        self.say_flat(&m, what);
        if let Some(block) = &mut self.motion {
            block.calls.push(Moving::Concat(m));
            return Ok(());
        }
        self.transform *= m;
        self.moves.iter_mut().for_each(|(_, key)| *key *= m);
        Ok(())
    }

    /// The variables of a primitive, attached to the current shaders; those that fit no parameter of their name are said.
    pub(super) fn attach(&self, own: &[VariableName], patches: &VariableNames) -> Arc<Attached> {
        let attached = Attached::new(&self.attributes, own, patches);
        let a = &self.attributes;
        let shaders = [Some(&*a.surface), a.displacement.as_deref(), a.atmosphere.as_deref()];
        for shader in shaders.into_iter().flatten() {
            for (name, width, wanted) in VariableSlots::misfits(&shader.program, attached.names()) {
                let wanted = wanted.map_or("a string".into(), |n| format!("one of {n}"));
                let shader = &shader.program.name;
                self.scene.warn(format!(
                    "the variable `{name}` of a primitive has a value of {width} numbers, and the parameter of the shader `{shader}` {wanted}: it does not take it"
                ));
            }
        }
        Arc::new(attached)
    }

    /// Add patches with variables of these names, each a primitive of its own, so that each can be found hidden by itself.
    pub(super) fn add_patches(&mut self, patches: Vec<Patch>, names: VariableNames) -> RiResult {
        let counts = (names.uniform.len(), names.varying.len());
        assert!(
            patches.iter().all(|p| (p.uniform.len(), p.varying.len()) == counts),
            "patches without some of {names:?}"
        );
        if let Some(block) = &mut self.motion {
            block.calls.push(Moving::Patches(patches, names));
            return Ok(());
        }
        if patches.iter().any(|p| p.p.iter().any(|p| !p.is_finite())) {
            return Err(Fail::new("the primitive has a point that is not a finite number"));
        }
        if is_projective(&self.transform) {
            return self.add_projected(patches, names);
        }
        let attached = self.attach(&[], &names);
        let (names, solid) = (Arc::new(names), self.enter_part());
        let corners = self.texture_corners();
        let shared = patches.len() > 1;
        let whole = self.take_wholes(1);
        self.of_patches = Some((self.opened_attributes(), Wholes { first: whole, per_instance: 1, shared }));
        let done = patches.into_iter().try_for_each(|mut patch| {
            patch.trim.clone_from(&self.geometry.trim);
            patch.set_corners(&corners);
            self.add(Shape::Patches(Arc::new(vec![patch]), names.clone()), vec![], attached.clone(), whole)
        });
        self.of_patches = None;
        self.attributes.solid = solid;
        done
    }

    /// Add patches under a transformation with a perspective: in the world, where that leads them.
    fn add_projected(&mut self, patches: Vec<Patch>, names: VariableNames) -> RiResult {
        let m = self.transform;
        if patches.iter().any(|p| !p.moves.is_empty()) || !self.moves.is_empty() {
            self.scene.warn("what moves under a `Perspective` is drawn as it is when the shutter opens".into());
        }
        let Some(there) = patches.iter().map(|patch| projected(patch, &m)).collect::<Option<Vec<_>>>() else {
            self.say_behind(&m);
            return Ok(());
        };
        let before = std::mem::take(&mut self.moves);
        self.transform = Mat4::IDENTITY;
        let done = self.add_patches(there.concat(), names);
        (self.transform, self.moves) = (m, before);
        done
    }

    /// Name primitives, of the object that is open or of the scene: the first of their names.
    pub(super) fn take_wholes(&mut self, n: u32) -> u32 {
        let next = match &mut self.open_object {
            Some(object) => &mut object.n_wholes,
            None => &mut self.scene.n_wholes,
        };
        let first = *next;
        *next = first.wrapping_add(n);
        first
    }

    /// Spheres by columns, or as parts of the object that is open; `particles` are those of `Points`.
    pub(super) fn add_spheres(&mut self, instances: Instances, uniform: Uniform, particles: bool) -> RiResult {
        if let Some(block) = &mut self.motion {
            block.calls.push(Moving::Spheres(instances, uniform, particles));
            return Ok(());
        }
        let of_instances = instance_variables(&instances).map(|p| VariableName::of(&p.decl));
        let own: Vec<_> = uniform.iter().map(|(name, _)| name.clone()).chain(of_instances).collect();
        let attached = self.attach(&own, &VariableNames::default());
        let solid = self.enter_part();
        let done = if self.open_object.is_none() {
            self.push_in(SourceShape::Spheres(instances), uniform, vec![attached], [true, particles])
        } else {
            self.add_sphere_parts(&instances, &uniform, particles)
        };
        self.attributes.solid = solid;
        done
    }

    /// Add a primitive, to the scene or to the object that is open, as a part of a whole.
    fn add(&mut self, shape: Shape, uniform: Uniform, attached: Arc<Attached>, whole: u32) -> RiResult {
        if self.open_object.is_some() {
            let (place, moves) = self.place_in_object();
            return self.add_part(
                Part { shape, place, space: place, fit: self.attributes.fit, whole, particle: false },
                moves,
                uniform,
            );
        }
        self.push(SourceShape::One(shape), uniform, vec![attached])
    }

    /// Add a source of primitives to the scene, of which spheres have object spaces of their own.
    pub(super) fn push(&mut self, shape: SourceShape, uniform: Uniform, attached: Vec<Arc<Attached>>) -> RiResult {
        self.push_in(shape, uniform, attached, [false; 2])
    }

    /// Add a source of primitives to the scene; its spheres may share the current object space, and be `Points`.
    fn push_in(
        &mut self,
        shape: SourceShape,
        uniform: Uniform,
        attached: Vec<Arc<Attached>>,
        [shares_space, particles]: [bool; 2],
    ) -> RiResult {
        self.in_world("a primitive")?;
        self.n_given += 1;
        let [from, until] = self.attributes.seen;
        if from >= until {
            return Ok(());
        }
        if is_projective(&self.transform) {
            return self.push_projected(shape, &uniform);
        }
        if self.reaches_too_far(&shape) {
            self.scene.warn(format!("a primitive that reaches farther than {FARTHEST:e} units is not drawn"));
            return Ok(());
        }
        self.shine(&shape);
        let shutter = self.open_shutter();
        let (attributes, wholes) = match (self.of_patches.clone(), self.of_instances) {
            (Some(own), _) => own,
            (None, Some(wholes)) => (self.opened_attributes(), wholes),
            (None, None) => {
                let first = self.take_wholes(shape.n_instances() as u32);
                (self.opened_attributes(), Wholes { first, per_instance: 1, shared: false })
            }
        };
        let (to_world, moves) =
            if self.moves.is_empty() { (self.transform, vec![]) } else { motion::in_shutter(&self.moves, shutter) };
        let mut shape = shape;
        if let SourceShape::Spheres(columns) | SourceShape::Objects(columns, _) = &mut shape
            && let Some(([a, b], to)) = columns.moved.take()
        {
            let keys =
                columns.position.iter().zip(to).map(|(from, to)| motion::in_shutter(&[(a, *from), (b, to)], shutter));
            let (position, later): (Vec<_>, Vec<_>) = keys.unzip();
            columns.position = position;
            let closing = later.into_iter().filter_map(|keys| keys.last().map(|(_, p)| *p)).collect::<Vec<_>>();
            columns.moved = (closing.len() == columns.position.len()).then_some(([0.0, 1.0], closing));
        }
        let is_opaque = attributes.stays_opaque() && attached.iter().all(|a| a.opacity.is_none());
        let mut repeats = match &shape {
            SourceShape::Spheres(columns) | SourceShape::Objects(columns, _)
                if columns.len() > 1 && attributes.solid.is_none() =>
            {
                repeats(columns, !is_opaque || attributes.displacement.is_some())
            }
            _ => vec![],
        };
        if is_opaque {
            repeats.iter_mut().for_each(|n| *n = (*n).min(1));
        }
        let spot = self.scene.warnings.spot();
        let first_id = self.scene.n_items + 1;
        let source = Source {
            shape,
            to_world,
            moves,
            attributes,
            uniform,
            shares_space,
            particles,
            wholes,
            first_id,
            repeats,
            attached,
            spot,
        };
        self.scene.n_items += source.len();
        if !self.copies.hide(&mut self.scene.sources, &source) {
            self.scene.sources.push(source);
        }
        Ok(())
    }

    /// Add a primitive to the area light that primitives become, if they do.
    fn shine(&mut self, shape: &SourceShape) {
        if let Some(light) = self.attributes.area_light {
            if !self.moves.is_empty() {
                self.scene.warn("an area light shines from where it is when the shutter opens".into());
            }
            let (area, to_world) = (&mut self.scene.area_lights[light].area, self.transform);
            let reversed = self.attributes.reversed;
            match shape {
                SourceShape::One(shape) => area.add(shape, to_world, reversed),
                SourceShape::Spheres(columns) => {
                    (0..columns.len()).for_each(|i| area.add(&Shape::Sphere, to_world * columns.matrix(i), reversed))
                }
                SourceShape::Objects(columns, parts) => (0..columns.len()).for_each(|i| {
                    let place = to_world * columns.matrix(i);
                    parts.iter().for_each(|part| area.add(&part.shape, place * part.place, reversed));
                }),
            }
        }
    }

    /// The attributes of a primitive that is added to the scene.
    fn opened_attributes(&self) -> Arc<Attributes> {
        let mut attributes = self.attributes.clone();
        // What shines does not stand in its own way.
        attributes.casts_shadows &= attributes.area_light.is_none();
        attributes.open(self.open_shutter());
        Arc::new(attributes)
    }
}

impl Context {
    /// Whether a primitive reaches farther from the world's origin or from the eye than single precision can draw.
    fn reaches_too_far(&self, shape: &SourceShape) -> bool {
        let places = [self.transform, self.to_camera.unwrap_or(Mat4::IDENTITY) * self.transform];
        // Of many instances the places are not looked at: there is nothing to split in what is far away.
        let one = |columns: &Instances| if columns.len() == 1 { columns.matrix(0) } else { Mat4::IDENTITY };
        let is_far = |shape: &Shape, own: Mat4| {
            let far = |p: Vec3, place: &Mat4| !(place.transform_point3(p).abs().max_element() <= FARTHEST);
            let all = places.map(|place| place * own);
            match shape {
                Shape::Patches(patches, _) => {
                    all.iter().any(|place| patches.iter().flat_map(|patch| patch.p).any(|p| far(p, place)))
                }
                Shape::Sphere => {
                    all.iter().any(|place| Vec3::AXES.into_iter().any(|p| far(p, place) || far(-p, place)))
                }
            }
        };
        match shape {
            SourceShape::One(shape) => is_far(shape, Mat4::IDENTITY),
            SourceShape::Spheres(columns) => is_far(&Shape::Sphere, one(columns)),
            SourceShape::Objects(columns, parts) => {
                parts.iter().any(|part| is_far(&part.shape, one(columns) * part.place))
            }
        }
    }
}

/// An error unless a number is above 0.
pub(super) fn positive(value: f32, what: &str) -> RiResult {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Fail::new(format!("{what} is {value}, expected a number above 0")))
    }
}
