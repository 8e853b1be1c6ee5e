//! What of a frame is not built for devices.

use crate::film::display::aovs;
use crate::scene::attributes::Attributes;
use crate::scene::options::Options;
use crate::scene::source::{Item, Source};
use crate::scene::world::Scene;

/// Why a frame cannot be drawn on a device, as far as its scene says without its shaders: the first reason.
pub fn refused(scene: &Scene, options: &Options) -> Option<String> {
    let no = |what: &str| Some(format!("{what}, which is not built for graphics devices"));
    if let Some(aov) = aovs(&options.displays).first() {
        return no(&format!("a display takes the variable `{}`", aov.name));
    }
    if !options.clipping_planes.is_empty() {
        return no("the scene has clipping planes");
    }
    scene.sources.iter().enumerate().filter(|(_, s)| s.len() > 0).find_map(|(k, source)| {
        let attached = scene.view(Item { source: k as u32, index: 0 }).attached;
        let is_seen_through = !source.attributes.stays_opaque() || attached.opacity.is_some();
        of_source(source, is_seen_through).and_then(|what| no(&what))
    })
}

fn of_source(source: &Source, is_seen_through: bool) -> Option<String> {
    let a: &Attributes = &source.attributes;
    if a.solid.is_some() {
        return Some("the scene has solids".into());
    }
    if a.visible && a.seen != [0.0, 1.0] {
        return Some("the scene has levels of detail that fade".into());
    }
    if a.visible && a.fades() {
        return Some("a colour or opacity moves".into());
    }
    (a.visible && is_seen_through)
        .then(|| format!("primitives with the surface `{}` may be translucent", a.surface.program.name))
}

/// Why rays of shaders cannot be answered, as a sentence: what is in their way is more than surfaces.
pub fn refused_rays(scene: &Scene, are_plain: bool) -> Option<String> {
    let casts = |source: &&Source| source.attributes.casts_shadows && source.len() > 0;
    let translucent = scene.sources.iter().filter(casts).find(|source| !source.blocks_light());
    let what = match translucent {
        Some(source) => {
            format!("light gets through primitives with the surface `{}`", source.attributes.surface.program.name)
        }
        None if !are_plain => "rays meet displaced surfaces".into(),
        None => return None,
    };
    Some(format!("{what}, which is not built for graphics devices"))
}
