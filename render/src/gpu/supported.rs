//! What of a frame is not built for devices.

use crate::scene::source::{Source, SourceShape};
use crate::scene::world::Scene;

/// Whether what is of a source may let a part of what is behind it be seen.
pub fn is_translucent(source: &Source) -> bool {
    !source.attributes.stays_opaque() || source.attached.iter().any(|attached| attached.opacity.is_some())
}

/// Why a frame cannot be drawn on a device, as far as its scene says without its shaders: the first reason.
pub fn refused(scene: &Scene) -> Option<String> {
    let is_solid = |source: &Source| source.len() > 0 && source.attributes.solid.is_some();
    let has_solids = scene.sources.iter().any(is_solid);
    let what = match () {
        () if has_solids => "solids",
        () if scene.sources.iter().any(|source| source.repeats.iter().any(|n| *n > 1)) => {
            "translucent primitives in one place"
        }
        () => return None,
    };
    Some(format!("the scene has {what}, which is not built for graphics devices"))
}

/// Why rays of shaders cannot be answered, as a sentence: what is in their way is more than surfaces whose opacities are known.
pub fn refused_rays(scene: &Scene, are_open: bool) -> Option<String> {
    let casts = |source: &&Source| source.attributes.casts_shadows && source.len() > 0;
    let asks = |source: &&Source| !source.blocks_light() && !source.shadow_is_known();
    let what = match scene.sources.iter().filter(casts).find(asks) {
        Some(source) => {
            format!(
                "the shader `{}` says how much light gets through its primitives",
                source.attributes.surface.program.name
            )
        }
        None if !are_open => "rays meet solids".into(),
        None if scene.sources.iter().filter(casts).any(|source| !source.blocks_light() && has_particles(source)) => {
            "rays meet translucent `Points`".into()
        }
        None => return None,
    };
    Some(format!("{what}, which is not built for graphics devices"))
}

/// Whether some items of a source are `Points`.
fn has_particles(source: &Source) -> bool {
    match &source.shape {
        SourceShape::Objects(_, parts) => parts.iter().any(|part| part.particle),
        SourceShape::One(_) | SourceShape::Spheres(_) => source.particles,
    }
}
