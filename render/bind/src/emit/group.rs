//! Instances of one shape.

use ri::{Instances, Param, Values};

/// Instances of one shape.
pub struct Group<'a> {
    /// The retained object that they repeat, if they are not spheres.
    pub handle: Option<String>,
    /// The file of that object, if it is from one.
    pub archive: Option<&'a str>,
    /// Whether it is the heads of arrows.
    pub is_head: bool,
    /// One set, but three for a capsule: its middle and its ends.
    pub instances: Vec<Instances>,
}

/// Some of the instances.
pub(super) fn select(all: &Instances, chosen: &[usize]) -> Instances {
    fn of<T: Copy>(values: &[T], chosen: &[usize]) -> Vec<T> {
        if values.is_empty() { vec![] } else { chosen.iter().map(|i| values[*i]).collect() }
    }
    let param = |param: &Param| match &param.values {
        Values::Floats(values) => {
            let width = values.len() / all.len().max(1);
            let own = chosen.iter().flat_map(|i| &values[i * width..(i + 1) * width]).copied().collect::<Vec<f32>>();
            Param { decl: param.decl.clone(), values: Values::Floats(own) }
        }
        _ => param.clone(),
    };
    Instances {
        shape: all.shape.clone(),
        position: of(&all.position, chosen),
        orientation: of(&all.orientation, chosen),
        scale: of(&all.scale, chosen),
        offset: of(&all.offset, chosen),
        params: all.params.iter().map(param).collect(),
        moved: all.moved.as_ref().map(|(times, to)| (*times, of(to, chosen))),
    }
}
