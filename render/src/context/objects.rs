//! Retained objects (RISpec 5.7): what stands between `ObjectBegin` and `ObjectEnd` is kept, and drawn at each instance.
//!
//! A part has the attributes that hold where it is instanced, but for those that were set within the object. What is set there ends
//! with the object.

use crate::context::motion_block::{Keys, Place};
use crate::context::open_object::{Group, OpenObject, OpenPart, Uniform};
use crate::context::state::Context;
use crate::gprim::quadric::whole_sphere;
use crate::scene::attached::Attached;
use crate::scene::attributes::{Attribute, Attributes, SetAttributes};
use crate::scene::motion;
use crate::scene::patch::TEXTURE_CORNERS;
use crate::scene::shape::Shape;
use crate::scene::source::{Part, SourceShape, Wholes, instance_variables, transform};
use crate::scene::variables::{VariableName, VariableNames};
use glam::{Mat4, Vec3};
use ri::{Fail, InstanceShape, Instances, Param, RiResult, Type};
use std::collections::HashMap;
use std::sync::Arc;

/// The most parts of an object.
const MAX_PARTS: usize = 1 << 22;

/// The most parts of an object that are copies of those of others: objects may be made of objects, which multiply.
const MAX_COPIES: usize = 1 << 20;

impl Context {
    /// `ObjectBegin`.
    pub(super) fn open_object(&mut self, handle: &str) -> RiResult {
        if self.open_object.is_some() {
            return Err(Fail::new("ObjectBegin within ObjectBegin"));
        }
        let outer = (self.attributes.clone(), self.place(), self.geometry.clone());
        let depths = [self.attribute_stack.len(), self.transform_stack.len()];
        self.open_object = Some(OpenObject {
            handle: handle.into(),
            parts: vec![],
            n_copies: 0,
            n_wholes: 0,
            base: self.transform,
            outer,
            depths,
        });
        self.moves.clear();
        self.attributes.set = SetAttributes::default();
        Ok(())
    }

    /// `ObjectEnd`.
    pub(super) fn close_object(&mut self) -> RiResult {
        let Some(object) = self.open_object.take() else { return Err(Fail::new("ObjectEnd without ObjectBegin")) };
        let OpenObject { handle, parts, base, outer, depths, .. } = object;
        let is_open = [self.attribute_stack.len(), self.transform_stack.len()] != depths;
        self.attribute_stack.truncate(depths[0]);
        self.transform_stack.truncate(depths[1]);
        (self.attributes, (self.transform, self.moves), self.geometry) = outer;
        self.open_solids.retain(|solid| solid.depth < depths[0]);
        self.objects.insert(handle, Arc::new(groups(parts, base)));
        if is_open { Err(Fail::new("ObjectEnd within a block that began in the object")) } else { Ok(()) }
    }

    /// Add a primitive to the object that is open.
    pub(super) fn add_part(&mut self, part: Part, moves: Keys, uniform: Uniform) -> RiResult {
        self.n_given += 1;
        let attributes = if self.attributes.set.any() { Some(self.shared_attributes()) } else { None };
        let Some(object) = &mut self.open_object else { return Ok(()) };
        if object.parts.len() >= MAX_PARTS {
            return Err(Fail::new(format!("the object `{}` has more than {MAX_PARTS} parts", object.handle)));
        }
        object.parts.push(OpenPart { part, moves, uniform, attributes });
        Ok(())
    }

    /// The current attributes, shared with the part before if they are still the same.
    fn shared_attributes(&self) -> Arc<Attributes> {
        let last = self.open_object.as_ref().and_then(|object| object.parts.last()?.attributes.clone());
        last.filter(|last| last.set.same(&self.attributes.set)).unwrap_or_else(|| Arc::new(self.attributes.clone()))
    }

    /// The current place as one in the object that is open.
    pub(super) fn place_in_object(&self) -> Place {
        let home = self.open_object.as_ref().map_or(Mat4::IDENTITY, |object| object.base.inverse());
        (home * self.transform, self.moves.iter().map(|(time, key)| (*time, home * *key)).collect())
    }

    /// Spheres by columns, as parts of the object that is open.
    pub(super) fn add_sphere_parts(&mut self, spheres: &Instances, uniform: &Uniform, particle: bool) -> RiResult {
        let (place, moves) = self.place_in_object();
        let first = self.take_wholes(spheres.len() as u32);
        for i in 0..spheres.len() {
            let own = [uniform.clone(), variables_of(spheres, i)].concat();
            let keys = keys_of(&(place, moves.clone()), spheres, i, &[]);
            let whole = first.wrapping_add(i as u32);
            let part = Part {
                shape: Shape::Sphere,
                place: place * spheres.matrix(i),
                space: place,
                fit: self.attributes.fit,
                whole,
                particle,
            };
            self.add_part(part, keys, own)?;
        }
        Ok(())
    }

    /// Instances of an object.
    pub(super) fn draw_object_instances(&mut self, instances: Instances, handle: &str) -> RiResult {
        let groups = self.objects.get(handle).cloned().ok_or(Fail::new(format!("there is no object `{handle}`")))?;
        let has_solids = |group: &Group| group.attributes.as_ref().is_some_and(|own| own.set.has(Attribute::Solid));
        if groups.iter().any(has_solids) {
            // Each instance is a solid of its own.
            return (0..instances.len()).try_for_each(|i| self.draw_groups(&one_of(&instances, i), &groups));
        }
        self.draw_groups(&instances, &groups)
    }

    /// The groups of an object at the places of some instances.
    fn draw_groups(&mut self, instances: &Instances, groups: &[Group]) -> RiResult {
        let solid = self.enter_part();
        let mut copied = HashMap::new();
        let parts = || groups.iter().flat_map(|group| group.parts.iter());
        let per_instance = parts().map(|part| part.whole + 1).max().unwrap_or(0);
        let first = self.take_wholes((instances.len() as u32).wrapping_mul(per_instance));
        let wholes = Wholes { first, per_instance, shared: parts().count() > per_instance as usize };
        for group in groups {
            let textured = self.textured(group);
            let group = textured.as_ref().unwrap_or(group);
            let outer = group.attributes.as_ref().map(|own| {
                let mut over = own.over(&self.attributes, self.transform * group.base.inverse());
                if self.open_object.is_some() {
                    // What is set within an object is set within those that it is a part of.
                    self.changes += 1;
                    over.set.join(&own.set, self.changes);
                }
                if let Some(own) = own.solid.filter(|_| own.set.has(Attribute::Solid)) {
                    over.solid = Some(self.scene.solids.copy(own, solid, &mut copied));
                }
                std::mem::replace(&mut self.attributes, over)
            });
            if group.attributes.as_ref().is_some_and(|own| own.set.has(Attribute::Detail)) {
                self.find_level();
            }
            self.of_instances = Some(wholes);
            let done = if self.open_object.is_some() {
                self.add_group_parts(instances, group, wholes)
            } else if group.moves.is_empty() {
                self.push_group(instances.clone(), group.parts.clone(), &group.uniform)
            } else {
                self.push_moving(instances, group, wholes)
            };
            self.of_instances = None;
            if let Some(outer) = outer {
                self.attributes = outer;
            }
            done?;
        }
        self.attributes.solid = solid;
        Ok(())
    }

    /// A group whose parts have the texture coordinates of where they are instanced, if these are not the usual ones and the object
    /// sets none.
    fn textured(&self, group: &Group) -> Option<Group> {
        let corners = self.texture_corners();
        let is_set = group.attributes.as_ref().is_some_and(|own| own.set.has(Attribute::TextureCorners));
        if is_set || corners == TEXTURE_CORNERS {
            return None;
        }
        let of = |part: &Part| {
            let (patches, names) = match &part.shape {
                Shape::Sphere => (whole_sphere(), Arc::default()),
                Shape::Patches(patches, names) => (patches.as_slice(), names.clone()),
            };
            let mut own = patches.to_vec();
            own.iter_mut().for_each(|patch| patch.set_corners(&corners));
            Part { shape: Shape::Patches(Arc::new(own), names), ..part.clone() }
        };
        Some(Group { parts: Arc::new(group.parts.iter().map(of).collect()), ..group.clone() })
    }

    /// Parts of an object within the object that is open.
    fn add_group_parts(&mut self, instances: &Instances, group: &Group, wholes: Wholes) -> RiResult {
        let place = self.place_in_object();
        if let Some(object) = &mut self.open_object {
            object.n_copies = object.n_copies.saturating_add(instances.len().saturating_mul(group.parts.len()));
            if object.n_copies > MAX_COPIES {
                let name = &object.handle;
                return Err(Fail::new(format!(
                    "the object `{name}` is made of objects with more than {MAX_COPIES} parts"
                )));
            }
        }
        for i in 0..instances.len() {
            let object = place.0 * instances.matrix(i);
            for Part { shape, place: own, space, fit, whole, particle } in group.parts.iter() {
                let keys = keys_of(&place, instances, i, &group.moves);
                let keys = if group.moves.is_empty() {
                    keys.into_iter().map(|(time, key)| (time, key * *own)).collect()
                } else {
                    keys
                };
                let part = Part {
                    shape: shape.clone(),
                    place: object * *own,
                    space: object * *space,
                    fit: self.attributes.fit.of(instances.fit(i)).of(*fit),
                    whole: wholes.of_instance(i).wrapping_add(*whole),
                    particle: *particle,
                };
                // What the instance has is of the space that it is placed in.
                let of_instance = placed(variables_of(instances, i), &(part.space.inverse() * place.0));
                self.add_part(part, keys, [group.uniform.clone(), of_instance].concat())?;
            }
        }
        Ok(())
    }

    /// Parts of an object that keep their places in it.
    fn push_group(&mut self, instances: Instances, parts: Arc<Vec<Part>>, uniform: &Uniform) -> RiResult {
        let own = uniform.iter().map(|(name, _)| name.clone());
        let own: Vec<VariableName> =
            own.chain(instance_variables(&instances).map(|p| VariableName::of(&p.decl))).collect();
        let attached = self.attach_parts(&own, &parts);
        self.push(SourceShape::Objects(instances, parts), uniform.clone(), attached)
    }

    /// A part that moves in its object: each instance is a source of its own, with its places over time.
    fn push_moving(&mut self, instances: &Instances, group: &Group, wholes: Wholes) -> RiResult {
        let outer = self.place();
        for i in 0..instances.len() {
            let moves = keys_of(&outer, instances, i, &group.moves);
            (self.transform, self.moves) = (motion::at(&moves, self.options.shutter[0]), moves);
            let params = instances.params.iter().map(|param| instances.param_of(param, i)).collect();
            let one = Instances {
                shape: InstanceShape::Sphere,
                position: vec![[0.0; 3]],
                orientation: vec![],
                scale: vec![],
                offset: vec![],
                params,
                moved: None,
            };
            // Its place is in the keys.
            let placed = |part: &Part| Part {
                shape: part.shape.clone(),
                place: Mat4::IDENTITY,
                space: part.place.inverse() * part.space,
                fit: instances.fit(i).of(part.fit),
                ..part.clone()
            };
            let parts = group.parts.iter().map(placed).collect();
            self.of_instances = Some(Wholes { first: wholes.of_instance(i), ..wholes });
            let done = self.push_group(one, Arc::new(parts), &group.uniform);
            (self.transform, self.moves) = outer.clone();
            done?;
        }
        Ok(())
    }

    /// The variables of the parts of an object, attached to the current shaders; the patches of one primitive share theirs.
    fn attach_parts(&self, own: &[VariableName], parts: &[Part]) -> Vec<Arc<Attached>> {
        let none = Arc::new(VariableNames::default());
        let mut last: Option<(&Arc<VariableNames>, Arc<Attached>)> = None;
        let mut all = Vec::with_capacity(parts.len());
        for part in parts {
            let names = match &part.shape {
                Shape::Sphere => &none,
                Shape::Patches(_, names) => names,
            };
            let attached = match last.take() {
                Some((before, attached)) if Arc::ptr_eq(before, names) => attached,
                _ => self.attach(own, names),
            };
            all.push(attached.clone());
            last = Some((names, attached));
        }
        all
    }
}

/// The parts of an object, those together that have attributes and variables in common; what moves is by itself.
fn groups(parts: Vec<OpenPart>, base: Mat4) -> Vec<Group> {
    let mut groups: Vec<(Group, Vec<Part>)> = vec![];
    for part in parts {
        let is_alike = |group: &Group| {
            let same = match (&group.attributes, &part.attributes) {
                (Some(a), Some(b)) => Arc::ptr_eq(a, b),
                (a, b) => a.is_none() && b.is_none(),
            };
            same && group.uniform == part.uniform && group.moves.is_empty() && part.moves.is_empty()
        };
        match groups.last_mut() {
            Some((group, all)) if is_alike(group) => all.push(part.part),
            _ => {
                let OpenPart { part, moves, uniform, attributes } = part;
                groups.push((Group { parts: Arc::default(), moves, uniform, attributes, base }, vec![part]));
            }
        }
    }
    groups.into_iter().map(|(group, all)| Group { parts: Arc::new(all), ..group }).collect()
}

/// One of some instances.
fn one_of(instances: &Instances, i: usize) -> Instances {
    let row = |column: &[[f32; 3]]| column.get(i).map_or(vec![], |row| vec![*row]);
    Instances {
        shape: instances.shape.clone(),
        position: row(&instances.position),
        orientation: instances.orientation.get(i).map_or(vec![], |q| vec![*q]),
        scale: row(&instances.scale),
        offset: row(&instances.offset),
        params: instances.params.iter().map(|param| instances.param_of(param, i)).collect(),
        moved: instances.moved.as_ref().map(|(times, to)| (*times, row(to))),
    }
}

/// Variables brought to another space.
fn placed(mut variables: Uniform, m: &Mat4) -> Uniform {
    for (name, values) in &mut variables {
        if matches!(name.ty, Type::Point | Type::Vector | Type::Normal | Type::HPoint) {
            transform(values, 1, name.ty, m);
        }
    }
    variables
}

/// The variables of one of some instances.
pub(super) fn variables_of(instances: &Instances, i: usize) -> Uniform {
    let of = |param: &Param| (VariableName::of(&param.decl), instances.param_of(param, i).numbers().to_vec());
    instances.params.iter().filter(|param| !param.numbers().is_empty()).map(of).collect()
}

/// The places over time of one of some instances, or of what moves in it: `inner` are its places there. None if nothing moves.
fn keys_of((transform, moves): &Place, instances: &Instances, i: usize, inner: &[(f32, Mat4)]) -> Keys {
    let mut times: Vec<f32> = moves.iter().chain(inner).map(|(time, _)| *time).collect();
    times.extend(instances.moved.iter().flat_map(|(times, _)| *times));
    times.sort_by(f32::total_cmp);
    times.dedup();
    let placed = |time: f32| {
        let outer = if moves.is_empty() { *transform } else { motion::at(moves, time) };
        let mut matrix = instances.matrix(i);
        if let Some(([from, until], to)) = &instances.moved {
            let place = motion::at(&[(*from, instances.position[i]), (*until, to[i])], time);
            matrix.w_axis = Vec3::from(place).extend(1.0);
        }
        let own = if inner.is_empty() { Mat4::IDENTITY } else { motion::at(inner, time) };
        outer * matrix * own
    };
    times.into_iter().map(|time| (time, placed(time))).collect()
}
