//! The state between calls, and what all calls change it by: transformations, and primitives that are added to the scene.

use crate::context::motion_block::{Keys, MotionBlock, Moving, Place};
use crate::context::result::RenderResult;
use crate::film::bucket::Shard;
use crate::scene::attached::Attached;
use crate::scene::attributes::Attributes;
use crate::scene::motion;
use crate::scene::options::{Hider, Options};
use crate::scene::patch::Patch;
use crate::scene::shape::Shape;
use crate::scene::source::{Source, SourceShape, instance_variables};
use crate::scene::trim::Trim;
use crate::scene::variables::VariableNames;
use crate::scene::world::Scene;
use crate::texture;
use glam::Mat4;
use ri::files::Files;
use ri::{Fail, Instances, RiResult};
use sl::ir::{Kind, Program};
use sl::machine::BoundShader;
use std::collections::HashMap;
use std::sync::Arc;

/// A function that is called with the buckets done and in all.
type Progress = Box<dyn Fn(usize, usize) + Sync + Send>;

/// The renderer: takes the calls of the RenderMan Interface ([`ri::Ri`]), holds options, attributes and the scene between them, and
/// renders an image at each `WorldEnd`.
pub struct Context {
    pub(super) files: Files,
    pub(super) programs: HashMap<String, Arc<Program>>,
    pub(super) options: Options,
    pub(super) saved_options: Option<Options>,
    pub(super) frame: i32,
    pub(super) attributes: Attributes,
    pub(super) attribute_stack: Vec<(Attributes, Place)>,
    /// The current transformation, as the shutter opens.
    pub(super) transform: Mat4,
    /// Its keys over time, by the time of motion blocks; none if it stands still.
    pub(super) moves: Keys,
    pub(super) transform_stack: Vec<Place>,
    pub(super) to_camera: Option<Mat4>,
    pub(super) camera_moves: Keys,
    pub(super) bases: ([f32; 16], [f32; 16]),
    /// Lights that were made, on or off, by their handles.
    pub(super) known_lights: Vec<(String, Arc<BoundShader>)>,
    /// Types of variables that `Declare` gave.
    pub(super) declared: HashMap<String, Kind>,
    pub(super) steps: [usize; 2],
    pub(super) trim: Option<Arc<Trim>>,
    pub(super) motion: Option<MotionBlock>,
    pub(super) made: texture::Made,
    pub(super) scene: Scene,
    pub(super) objects: HashMap<String, Arc<Vec<(Shape, Mat4)>>>,
    pub(super) open_object: Option<(String, Vec<(Shape, Mat4)>, Mat4)>,
    pub(super) progress: Progress,
    /// The shard of each image to render; the whole image if not given.
    pub shard: Option<Shard>,
    /// Metadata for the image files, as keys and values.
    pub about: Vec<(String, String)>,
    /// The file of the image, which the caller names and which may be anywhere.
    pub image: Option<String>,
    /// Whether displays may be written outside of the folder that their names count from, by an absolute name or `..`.
    pub allow_outside: bool,
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

    /// The warnings about the scene so far.
    pub fn warnings(&self) -> Vec<String> {
        self.scene.warnings.list()
    }

    /// Object to world: the current transformation after `WorldBegin`.
    pub(super) fn to_world(&self) -> Mat4 {
        self.transform
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

    /// Another transformation after the current one.
    pub(super) fn concat(&mut self, m: Mat4) -> RiResult {
        if !m.is_finite() {
            return Err(Fail::new("the transformation is not finite"));
        }
        if let Some(block) = &mut self.motion {
            block.calls.push(Moving::Concat(m));
            return Ok(());
        }
        self.transform *= m;
        self.moves.iter_mut().for_each(|(_, key)| *key *= m);
        Ok(())
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
        let attached = Arc::new(Attached::new(&self.attributes, vec![], &names));
        let names = Arc::new(names);
        let corners = self.attributes.texture_corners;
        for mut patch in patches {
            patch.trim.clone_from(&self.trim);
            if patch.st == patch.uv && corners != [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0] {
                let at = |axis: usize, [u, v]: [f32; 2]| {
                    let c = |k: usize| corners[2 * k + axis];
                    (c(0) * (1.0 - u) + c(1) * u) * (1.0 - v) + (c(2) * (1.0 - u) + c(3) * u) * v
                };
                patch.st = patch.uv.map(|uv| [at(0, uv), at(1, uv)]);
            }
            self.add(Shape::Patches(Arc::new(vec![patch]), names.clone()), vec![], attached.clone())?;
        }
        Ok(())
    }

    /// Spheres by columns, or as parts of the object that is open.
    pub(super) fn add_spheres(&mut self, instances: Instances, uniform: Vec<(String, Vec<f32>)>) -> RiResult {
        if let Some(block) = &mut self.motion {
            block.calls.push(Moving::Spheres(instances, uniform));
            return Ok(());
        }
        let of_instances = instance_variables(&instances).map(|p| &p.decl.name);
        let own = uniform.iter().map(|(name, _)| name).chain(of_instances).cloned().collect();
        let attached = Arc::new(Attached::new(&self.attributes, own, &VariableNames::default()));
        if self.open_object.is_none() {
            return self.push(SourceShape::Spheres(instances), uniform, vec![attached]);
        }
        let outer = self.transform;
        for i in 0..instances.len() {
            self.transform = outer * instances.matrix(i);
            self.add(Shape::Sphere, uniform.clone(), attached.clone())?;
        }
        self.transform = outer;
        Ok(())
    }

    /// Add a primitive, to the scene or to the object that is open.
    fn add(&mut self, shape: Shape, uniform: Vec<(String, Vec<f32>)>, attached: Arc<Attached>) -> RiResult {
        if let Some((_, parts, base)) = &mut self.open_object {
            parts.push((shape, base.inverse() * self.transform));
            return Ok(());
        }
        self.push(SourceShape::One(shape), uniform, vec![attached])
    }

    /// Add a source of primitives to the scene.
    pub(super) fn push(
        &mut self,
        shape: SourceShape,
        uniform: Vec<(String, Vec<f32>)>,
        attached: Vec<Arc<Attached>>,
    ) -> RiResult {
        self.in_world("a primitive")?;
        if self.attributes.level <= 0.0 {
            return Ok(());
        }
        let mut attributes = self.attributes.clone();
        attributes.opacity = attributes.opacity.map(|o| o * attributes.level);
        if let Some(light) = attributes.area_light {
            // What shines does not stand in its own way.
            attributes.casts_shadows = false;
            let (area, to_world) = (&mut self.scene.area_lights[light].area, self.transform);
            match &shape {
                SourceShape::One(shape) => area.add(shape, to_world, attributes.reversed),
                SourceShape::Spheres(columns) => (0..columns.len())
                    .for_each(|i| area.add(&Shape::Sphere, to_world * columns.matrix(i), attributes.reversed)),
                SourceShape::Objects(columns, parts) => (0..columns.len()).for_each(|i| {
                    let place = to_world * columns.matrix(i);
                    parts.iter().for_each(|(shape, own)| area.add(shape, place * *own, attributes.reversed));
                }),
            }
        }
        let attributes = Arc::new(attributes);
        let shutter = self.open_shutter();
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
        self.scene.sources.push(Source { shape, to_world, moves, attributes, uniform, attached });
        Ok(())
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
