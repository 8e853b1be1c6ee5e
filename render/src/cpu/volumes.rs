//! Volume shaders on rays that are traced: of what a ray goes through up to where it meets something (RISpec 5.1.6).
//!
//! A ray that meets a surface from within has gone through the inside of that primitive, whose interior shader is run. Where that has
//! none, or is met from outside, a ray that left the surface that it started from or passed last outwards runs the exterior shader of
//! that; by the normal there the way of the ray decides. What meets nothing goes through no volume that ends.

use crate::cpu::bvh::Bvh;
use crate::cpu::rays::{is_open, still_facets};
use crate::scene::attributes::Attributes;
use crate::scene::source::{Item, Source, SourceShape};
use crate::scene::world::Scene as World;
use glam::{Mat4, Vec3};
use sl::Global;
use sl::machine::{BoundShader, Machine, Points, Scene, VariableSlots};
use std::sync::Arc;

/// A ray from where it started or passed a surface last, up to where it meets another.
pub struct Leg<'a> {
    /// Where it begins and ends, world space.
    pub from: Vec3,
    /// Where it ends.
    pub to: Vec3,
    /// Whether it leaves the surface where it begins outwards.
    pub outwards: bool,
    /// Whether it meets the surface where it ends from within.
    pub within: bool,
    /// Attributes of the surface where it begins, and of that where it ends.
    pub attributes: [&'a Attributes; 2],
}

impl<'a> Leg<'a> {
    /// The shader of what it goes through.
    fn volume(&self) -> Option<&'a (Arc<BoundShader>, Mat4)> {
        let [first, last] = self.attributes;
        let inside = last.interior.as_ref().filter(|_| self.within);
        inside.or(first.exterior.as_ref().filter(|_| self.outwards))
    }

    /// Run its volume shader over what comes along it, a colour and an opacity; `scene_of` has the scene as a shader of a space
    /// sees it.
    pub fn pass<S: Scene>(&self, [ci, oi]: [[f32; 3]; 2], scene_of: impl Fn(Mat4) -> S) -> [[f32; 3]; 2] {
        let Some((shader, space)) = self.volume() else { return [ci, oi] };
        let mut points = Points::new(1, 1, 1.0);
        let ends = [(Global::P, self.to), (Global::I, self.to - self.from), (Global::E, self.from)];
        ends.into_iter().for_each(|(global, value)| points.set(global, value.to_array().to_vec()));
        points.set(Global::Ci, ci.to_vec());
        points.set(Global::Oi, oi.to_vec());
        Machine::new().run_with(shader, &VariableSlots::default(), &mut points, &scene_of(*space));
        let triple = |global| match points.get(global) {
            Some(&[r, g, b]) => [r, g, b],
            _ => [0.0; 3],
        };
        [triple(Global::Ci), triple(Global::Oi)]
    }
}

/// Say of volume shaders that do nothing, or less than they may be meant to: no shader traces rays, or what has an interior encloses nothing.
pub fn say_idle(scene: &World) {
    let has_volumes = |source: &&Source| source.attributes.has_volumes();
    let Some(first) = scene.sources.iter().find(has_volumes) else { return };
    if scene.sources.iter().all(|source| !source.attributes.traces()) {
        let message =
            "`Interior` and `Exterior` are for rays that shaders trace, and no shader here traces any: they do nothing";
        scene.warnings.add_at(first.spot, message.into());
        return;
    }
    // What has one interior may enclose a volume together. Spheres enclose theirs.
    let mut groups: Vec<(&Arc<BoundShader>, Vec<usize>)> = vec![];
    for (s, source) in scene.sources.iter().enumerate() {
        let a = &source.attributes;
        let Some((interior, _)) = a.interior.as_ref().filter(|_| a.solid.is_none()) else { continue };
        if matches!(source.shape, SourceShape::Spheres(_)) {
            continue;
        }
        match groups.iter_mut().find(|(known, _)| Arc::ptr_eq(known, interior)) {
            Some((_, sources)) => sources.push(s),
            None => groups.push((interior, vec![s])),
        }
    }
    for (interior, sources) in groups {
        let of = |s: &usize| {
            let source = *s as u32;
            (0..scene.sources[*s].len()).map(move |i| Item { source, index: i as u32 })
        };
        let items: Vec<Item> = sources.iter().flat_map(of).collect();
        let bvh = Bvh::of(scene, items.iter().copied());
        let facets: Vec<_> = items.iter().flat_map(|item| still_facets(scene, *item)).collect();
        let count = |from: Vec3, dir: Vec3, bias: f32| {
            let mut met = vec![];
            bvh.crossings(None, from, dir, [bias; 2], &mut met);
            met.len()
        };
        if is_open(&facets, &count) {
            let message = format!(
                "what has the interior `{}` does not enclose a volume: it is run for rays that meet it from behind alone",
                interior.program.name
            );
            scene.warnings.add_at(scene.sources[sources[0]].spot, message);
        }
    }
}
