//! Solids that stand where others before them do, and hide behind them.

use crate::scene::shape::Shape;
use crate::scene::source::{Source, SourceShape};
use crate::scene::world::Scene;
use glam::Mat4;
use ri::Instances;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Mark the primitives of opaque solids that have the shapes and places of a solid before them as duplicates of its primitives.
pub fn hide_twins(scene: &mut Scene) {
    let roots: Vec<u32> = scene.solids.roots().collect();
    if roots.len() < 2 {
        return;
    }
    let mut sources: HashMap<u32, Vec<usize>> = HashMap::new();
    for (k, source) in scene.sources.iter().enumerate() {
        if let Some(leaf) = source.attributes.solid {
            sources.entry(leaf).or_default().push(k);
        }
    }
    let described = |root: u32| {
        let mut words = vec![];
        describe(scene, &sources, root, &mut words).then_some(words)
    };
    // By a hash of their descriptions, which are made again where two are alike: those of many solids may be long.
    let mut first: HashMap<u64, Vec<u32>> = HashMap::new();
    let mut twins = vec![];
    for root in roots {
        let Some(words) = described(root) else { continue };
        let mut hasher = DefaultHasher::new();
        words.hash(&mut hasher);
        let alike = first.entry(hasher.finish()).or_default();
        if alike.iter().any(|other| described(*other).as_ref() == Some(&words)) {
            twins.push(root);
        } else {
            alike.push(root);
        }
    }
    let mut hidden = vec![];
    while let Some(id) = twins.pop() {
        twins.extend(scene.solids.parts(id));
        hidden.extend(sources.get(&id).into_iter().flatten().copied());
    }
    for source in hidden {
        let source = &mut scene.sources[source];
        source.repeats = vec![0; source.shape.n_instances()];
    }
}

/// Describe a solid by all that tells where its surfaces are and who sees them; whether they hide what is behind and stay where they are.
fn describe(scene: &Scene, sources: &HashMap<u32, Vec<usize>>, id: u32, words: &mut Vec<u32>) -> bool {
    let own = sources.get(&id).map_or(&[][..], Vec::as_slice);
    let parts = scene.solids.parts(id);
    words.extend([scene.solids.operation(id) as u32, own.len() as u32, parts.len() as u32]);
    own.iter().all(|k| describe_source(&scene.sources[*k], words))
        && parts.iter().all(|part| describe(scene, sources, *part, words))
}

fn describe_source(source: &Source, words: &mut Vec<u32>) -> bool {
    let a = &source.attributes;
    let seen_by = [a.visible, a.casts_shadows, a.whole_shadows, a.shadows_of_opacity, a.matte, a.reversed, a.traces()];
    words.push(seen_by.iter().fold(0, |bits, flag| bits << 1 | *flag as u32));
    words.extend(a.seen.map(f32::to_bits));
    place(&source.to_world, words);
    keys(&source.moves, words, place);
    let is_open = match &source.shape {
        SourceShape::One(shape) => describe_shape(shape, words),
        SourceShape::Spheres(columns) => describe_columns(columns, words),
        SourceShape::Objects(columns, parts) => {
            describe_columns(columns, words)
                && parts.iter().all(|part| {
                    place(&part.place, words);
                    describe_shape(&part.shape, words)
                })
        }
    };
    let hides = a.stays_opaque() && a.displacement.is_none() && a.area_light.is_none();
    is_open && hides && source.attached.iter().all(|attached| attached.opacity.is_none())
}

fn describe_columns(columns: &Instances, words: &mut Vec<u32>) -> bool {
    words.extend([columns.len(), columns.scale.len(), columns.orientation.len()].map(|n| n as u32));
    words.extend(columns.position.iter().chain(&columns.scale).flatten().map(|x| x.to_bits()));
    words.extend(columns.orientation.iter().flatten().map(|x| x.to_bits()));
    if let Some((times, to)) = &columns.moved {
        words.extend(times.iter().chain(to.iter().flatten()).map(|x| x.to_bits()));
    }
    words.push(columns.moved.is_some() as u32);
    true
}

/// What is trimmed is not compared.
fn describe_shape(shape: &Shape, words: &mut Vec<u32>) -> bool {
    let Shape::Patches(patches, _) = shape else {
        words.push(0);
        return true;
    };
    words.push(patches.len() as u32);
    for patch in patches.iter() {
        words.extend(patch.p.iter().flat_map(|p| p.to_array()).map(f32::to_bits));
        keys(&patch.moves, words, |p, words| words.extend(p.iter().flat_map(|p| p.to_array()).map(f32::to_bits)));
    }
    patches.iter().all(|patch| patch.trim.is_none())
}

fn place(m: &Mat4, words: &mut Vec<u32>) {
    words.extend(m.to_cols_array().map(f32::to_bits));
}

fn keys<T>(keys: &[(f32, T)], words: &mut Vec<u32>, describe: impl Fn(&T, &mut Vec<u32>)) {
    words.push(keys.len() as u32);
    for (time, key) in keys {
        words.push(time.to_bits());
        describe(key, words);
    }
}
