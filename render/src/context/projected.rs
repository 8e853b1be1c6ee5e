//! Spheres, points and instances under a transformation with a perspective: patches where that leads them (RISpec 5.2).

use crate::context::objects::variables_of;
use crate::context::open_object::Uniform;
use crate::context::state::Context;
use crate::gprim::perspective::projected;
use crate::gprim::quadric::whole_sphere;
use crate::scene::shape::Shape;
use crate::scene::source::{SourceShape, Wholes};
use crate::scene::variables::{VariableName, VariableNames};
use glam::Mat4;
use ri::{Fail, RiResult};
use std::sync::Arc;

/// The most of them: each becomes many patches.
const MAX_PROJECTED: usize = 1 << 16;

/// One of them, in the space before the perspective.
struct Projected {
    place: Mat4,
    shape: Shape,
    /// Its variables.
    own: Uniform,
    /// The primitive that it is a part of, if that is one of an object.
    whole: Option<Wholes>,
}

impl Context {
    /// Add primitives under a transformation with a perspective, each by itself.
    pub(super) fn push_projected(&mut self, shape: SourceShape, uniform: &Uniform) -> RiResult {
        let (m, moves) = (self.transform, std::mem::take(&mut self.moves));
        if !moves.is_empty() {
            self.scene.warn("what moves under a `Perspective` is drawn as it is when the shutter opens".into());
        }
        let of_instances = self.of_instances.take();
        let all: Vec<Projected> = match shape {
            SourceShape::One(shape) => vec![Projected { place: m, shape, own: vec![], whole: of_instances }],
            SourceShape::Spheres(columns) => {
                let one = |i: usize| Projected {
                    place: m * columns.matrix(i),
                    shape: Shape::Sphere,
                    own: variables_of(&columns, i),
                    whole: None,
                };
                (0..columns.len().min(MAX_PROJECTED + 1)).map(one).collect()
            }
            SourceShape::Objects(columns, parts) => {
                // A part stays one of its primitive in its instance, and of no other.
                let whole_of = |i: usize, whole: u32| {
                    of_instances.map(|all| Wholes { first: all.of_instance(i).wrapping_add(whole), ..all })
                };
                let part = |k: usize| {
                    let (i, part) = (k / parts.len(), &parts[k % parts.len()]);
                    Projected {
                        place: m * columns.matrix(i) * part.place,
                        shape: part.shape.clone(),
                        own: variables_of(&columns, i),
                        whole: whole_of(i, part.whole),
                    }
                };
                (0..(columns.len() * parts.len()).min(MAX_PROJECTED + 1)).map(part).collect()
            }
        };
        if all.len() > MAX_PROJECTED {
            let message =
                format!("more than {MAX_PROJECTED} points or instances under a `Perspective` are not supported");
            return Err(Fail::new(message));
        }
        self.transform = Mat4::IDENTITY;
        let done = all.into_iter().try_for_each(|Projected { place, shape, own, whole }| {
            let uniform: Uniform = uniform.iter().cloned().chain(own).collect();
            self.of_instances = whole;
            self.push_one_projected(&place, &shape, uniform)
        });
        self.of_instances = of_instances;
        (self.transform, self.moves) = (m, moves);
        done
    }

    fn push_one_projected(&mut self, place: &Mat4, shape: &Shape, uniform: Uniform) -> RiResult {
        let none = Arc::new(VariableNames::default());
        let (patches, names) = match shape {
            Shape::Sphere => (whole_sphere(), &none),
            Shape::Patches(patches, names) => (patches.as_slice(), names),
        };
        let Some(there) = patches.iter().map(|patch| projected(patch, place)).collect::<Option<Vec<_>>>() else {
            self.say_behind(place);
            return Ok(());
        };
        let own: Vec<VariableName> = uniform.iter().map(|(name, _)| name.clone()).collect();
        let attached = self.attach(&own, names);
        let shape = Shape::Patches(Arc::new(there.concat()), names.clone());
        self.push(SourceShape::One(shape), uniform, vec![attached])
    }
}
