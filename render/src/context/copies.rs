//! Primitives that stand where others like them do: what hides behind these is not kept.

use crate::scene::shape::Shape;
use crate::scene::source::{Source, SourceShape};
use glam::Mat4;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};

/// The primitives of a scene by where they are and what they let through.
#[derive(Default)]
pub struct Copies {
    /// By the hash of a primitive: the first of it, and how many there are.
    known: HashMap<u64, (u32, u32)>,
}

/// The part of light that counts as none.
const NONE: f64 = 1.0 / (1u64 << 60) as f64;

impl Copies {
    /// Whether nothing of a primitive is seen, since enough of others like it stand in its place; counts it if not.
    pub fn hide(&mut self, sources: &[Source], new: &Source) -> bool {
        if !stays(new) {
            return false;
        }
        let Some(hash) = hash_of(new) else { return false };
        let (first, count) = self.known.entry(hash).or_insert((sources.len() as u32, 0));
        if *count > 0 && !sources.get(*first as usize).is_some_and(|first| is_alike(first, new)) {
            return false;
        }
        let left = |o: &f32| f64::from(1.0 - o).abs().powi(*count as i32);
        let is_hidden = *count > 0 && new.attributes.opacity.iter().all(|o| left(o) < NONE);
        *count += !is_hidden as u32;
        is_hidden
    }
}

/// Whether a primitive stays as its attributes say.
fn stays(source: &Source) -> bool {
    let a = &source.attributes;
    let is_fixed = a.displacement.is_none() && a.solid.is_none() && a.area_light.is_none();
    is_fixed && a.keeps_opacity() && source.attached.iter().all(|attached| attached.opacity.is_none())
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
        _ => false,
    };
    has_form && is_there(&a.to_world, &b.to_world) && keys(a) == keys(b) && seen_by(a) == seen_by(b)
}
