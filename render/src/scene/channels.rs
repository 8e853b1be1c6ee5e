//! What displays take besides colour and nothing in a scene provides.

use crate::film::display::Aov;
use crate::scene::world::Scene;
use sl::Global;

/// The variables that the renderer has of every point, besides those of shaders.
const OWN: [&str; 4] = ["z", "id", "motion", "Ng"];

/// Warn of variables that no surface shader puts out, and no primitive has: they are 0 all over the image.
pub fn say_unprovided(scene: &Scene, aovs: &[Aov]) {
    for aov in aovs {
        let name = aov.name.as_str();
        if OWN.contains(&name) || Global::of_name(name).is_some() {
            continue;
        }
        let mut others: Vec<String> = vec![];
        let mut is_there = false;
        for source in &scene.sources {
            let params = source.attributes.surface.program.params.iter().filter(|p| p.output && p.array.is_none());
            let outputs = params.map(|p| (p.name.as_str(), p.kind.width()));
            let variables = source.attached.iter().flat_map(|attached| attached.names());
            let variables = variables.map(|(name, width)| (name.as_str(), *width));
            for (other, width) in outputs.chain(variables) {
                is_there |= other == name && width == aov.width();
                let shown = if other == name { format!("{other} (of {width} numbers)") } else { other.into() };
                if !others.contains(&shown) {
                    others.push(shown);
                }
            }
            if is_there {
                break;
            }
        }
        if !is_there {
            others.sort();
            let known =
                if others.is_empty() { "there are none".into() } else { format!("there are {}", others.join(", ")) };
            scene.warn(format!(
                "nothing provides the channel `{} {name}`, which is 0 everywhere: it names no output parameter of a surface shader and no variable of a primitive ({known})",
                aov.kind.name()
            ));
        }
    }
}
