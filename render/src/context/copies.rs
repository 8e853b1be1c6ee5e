//! Primitives that stand where others like them do: what hides behind these is not kept, and what is alike in all is kept once.

use crate::scene::shape::Shape;
use crate::scene::source::{Source, SourceShape};
use glam::Mat4;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};
use std::sync::Arc;

/// The primitives of a scene by where they are and what they let through.
#[derive(Default)]
pub struct Copies {
    /// By the hash of a primitive, and the count of those there before that differ from it.
    known: HashMap<u64, Known>,
}

/// A primitive that was given.
struct Known {
    source: u32,
    /// How many there are that hide together.
    count: u32,
}

/// The part of light that counts as none.
const NONE: f64 = 1.0 / (1u64 << 60) as f64;

/// Primitives that differ in one place, of which each is compared with the next.
const MOST: u32 = 8;

impl Copies {
    /// Whether a primitive need not be kept: nothing of it is seen, since enough of others like it stand in its place, or it is as one
    /// before it, which then stands for both.
    pub fn hide(&mut self, sources: &mut [Source], new: &Source) -> bool {
        let a = &new.attributes;
        if a.solid.is_some() || a.area_light.is_some() {
            return false;
        }
        let Some(hash) = hash_of(new) else { return false };
        let stays = stays(new);
        for k in 0..MOST {
            // The next that differs is by another number.
            let key = hash.wrapping_add(u64::from(k).wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let Some(known) = self.known.get_mut(&key) else {
                self.known.insert(key, Known { source: sources.len() as u32, count: 1 });
                return false;
            };
            let Some(first) = sources.get_mut(known.source as usize) else { return false };
            if stays != self::stays(first) || !is_alike(first, new) || !stays && !has_one_look(first, new) {
                continue;
            }
            if stays {
                let left = |o: &f32| f64::from(1.0 - o).abs().powi(known.count as i32);
                let is_hidden = a.opacity.iter().all(|o| left(o) < NONE);
                known.count += !is_hidden as u32;
                return is_hidden;
            }
            if !(keeps_opacity(new) && a.opacity == [1.0; 3]) {
                first.repeats.resize(1, 1);
                first.repeats[0] = first.repeats[0].saturating_add(1);
            }
            return true;
        }
        false
    }
}

/// Whether the opacity of a primitive is the attribute's.
fn keeps_opacity(source: &Source) -> bool {
    source.attributes.keeps_opacity() && source.attached.iter().all(|attached| attached.opacity.is_none())
}

/// Whether a primitive stays as its attributes say, in its place and in what it lets through.
fn stays(source: &Source) -> bool {
    keeps_opacity(source) && source.attributes.displacement.is_none()
}

/// Whether shaders make the same of two primitives of one form and place.
fn has_one_look(a: &Source, b: &Source) -> bool {
    let has_same_values = match (&a.shape, &b.shape) {
        (SourceShape::One(Shape::Patches(a, _)), SourceShape::One(Shape::Patches(b, _))) => {
            a.iter().zip(b.iter()).all(|(a, b)| a.has_values_of(b))
        }
        (SourceShape::Spheres(a), SourceShape::Spheres(b))
        | (SourceShape::Objects(a, _), SourceShape::Objects(b, _)) => a.params == b.params && a.offset == b.offset,
        _ => true,
    };
    let names = |source: &Source| source.attached.iter().map(|attached| attached.names().to_vec()).collect::<Vec<_>>();
    let own = |source: &Source| (source.shares_space, source.particles);
    has_same_values
        && a.uniform == b.uniform
        && own(a) == own(b)
        && (Arc::ptr_eq(&a.attributes, &b.attributes) || a.attributes.is_as(&b.attributes))
        && names(a) == names(b)
}

/// A hash of where a primitive is and of its opacity; none of what is many or trimmed.
fn hash_of(source: &Source) -> Option<u64> {
    let mut hasher = DefaultHasher::new();
    let mut add = |numbers: &[f32]| numbers.iter().for_each(|x| hasher.write_u32(x.to_bits()));
    match &source.shape {
        SourceShape::One(Shape::Patches(patches, _)) => {
            let [patch] = patches.as_slice() else { return None };
            if patch.trim.is_some() {
                return None;
            }
            patch.p.iter().for_each(|p| add(&p.to_array()));
        }
        SourceShape::Spheres(columns) if columns.len() == 1 => {
            add(&columns.position[0]);
            columns.scale.iter().for_each(|x| add(x));
            columns.orientation.iter().for_each(|x| add(x));
        }
        SourceShape::Objects(columns, parts) if columns.len() == 1 => {
            add(&columns.position[0]);
            columns.scale.iter().for_each(|x| add(x));
            columns.orientation.iter().for_each(|x| add(x));
            // Instances of one object share its parts.
            parts.first().iter().for_each(|part| add(&part.place.to_cols_array()));
            add(&[parts.len() as f32]);
        }
        _ => return None,
    }
    add(&source.to_world.to_cols_array());
    add(&source.attributes.opacity);
    Some(hasher.finish())
}

/// Whether two primitives have one form and place, and are seen by the same rays and from the same sides.
fn is_alike(a: &Source, b: &Source) -> bool {
    let seen_by = |source: &Source| {
        let a = &source.attributes;
        let flags = [
            a.visible,
            a.casts_shadows,
            a.whole_shadows,
            a.shadows_of_opacity,
            a.matte,
            a.reversed,
            a.two_sided,
            a.traces(),
        ];
        (flags, a.seen, a.shading_rate, a.opacity)
    };
    let keys = |source: &Source| source.moves.iter().map(|(t, m)| (*t, m.to_cols_array())).collect::<Vec<_>>();
    let is_there = |a: &Mat4, b: &Mat4| a.to_cols_array() == b.to_cols_array();
    let has_form = match (&a.shape, &b.shape) {
        (SourceShape::One(Shape::Patches(a, _)), SourceShape::One(Shape::Patches(b, _))) => {
            a.len() == b.len() && a.iter().zip(b.iter()).all(|(a, b)| a.p == b.p && a.moves == b.moves)
        }
        (SourceShape::Spheres(a), SourceShape::Spheres(b)) => {
            (&a.position, &a.scale, &a.orientation) == (&b.position, &b.scale, &b.orientation) && a.moved == b.moved
        }
        (SourceShape::Objects(a, p), SourceShape::Objects(b, q)) => {
            let is_place = (&a.position, &a.scale, &a.orientation) == (&b.position, &b.scale, &b.orientation);
            is_place && a.moved == b.moved && Arc::ptr_eq(p, q)
        }
        _ => false,
    };
    has_form && is_there(&a.to_world, &b.to_world) && keys(a) == keys(b) && seen_by(a) == seen_by(b)
}
