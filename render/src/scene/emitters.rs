//! Area lights in the light lists of primitives: each point of a light stands there as a light of its own.

use crate::scene::area::{AreaLight, Emitter};
use crate::scene::attributes::Attributes;
use crate::scene::world::Scene;
use sl::machine::{Answer, BoundShader};
use std::collections::HashMap;
use std::sync::Arc;

/// Put every point of an area light in the place of the light itself, in the lists of all primitives. A parameter `area` of its
/// shader is told the light's.
pub fn expand(scene: &mut Scene) {
    let told = |light: &AreaLight| {
        let mut shader = (*light.shader).clone();
        if let Some(i) = shader.program.params.iter().position(|p| p.name == "area") {
            shader.set(i, Answer::Numbers(vec![light.area.area()]));
        }
        Arc::new(shader)
    };
    let shaders: Vec<Arc<BoundShader>> = scene.area_lights.iter().map(told).collect();
    type Lists = (Arc<Vec<Arc<BoundShader>>>, Arc<Vec<Emitter>>);
    let mut known: HashMap<*const Vec<Arc<BoundShader>>, Lists> = HashMap::new();
    for source in &mut scene.sources {
        let list = source.attributes.light_list.clone();
        let which = |light: &Arc<BoundShader>| scene.area_lights.iter().position(|a| Arc::ptr_eq(&a.shader, light));
        if !list.iter().any(|light| which(light).is_some()) {
            continue;
        }
        let (lights, emitters) = known.entry(Arc::as_ptr(&list)).or_insert_with(|| {
            let (mut lights, mut emitters) = (vec![], vec![]);
            for light in list.iter() {
                match which(light) {
                    Some(k) => (0..scene.area_lights[k].samples as u32).for_each(|sample| {
                        lights.push(shaders[k].clone());
                        emitters.push(Some((k as u32, sample)));
                    }),
                    None => {
                        lights.push(light.clone());
                        emitters.push(None);
                    }
                }
            }
            (Arc::new(lights), Arc::new(emitters))
        });
        let attributes: &mut Attributes = Arc::make_mut(&mut source.attributes);
        (attributes.light_list, attributes.emitters) = (lights.clone(), emitters.clone());
    }
}
