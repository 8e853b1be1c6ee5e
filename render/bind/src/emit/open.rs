//! What a binding leaves open that only the whole data tells: images of other frames would be others without it.

use crate::binding::{Arrow, Binding, Camera, Color, ImageFormat, Shape};
use ri::files::Files;

/// Whether the levels of the film are still to be measured: they are not given, the binding's scene takes them, and the image is none of data.
pub fn levels_are_open(binding: &Binding, files: &Files) -> bool {
    let scene = || files.read(&binding.scene, &["scenes"]).is_ok_and(|(_, text)| takes_levels(&text));
    binding.output.levels.is_none() && binding.output.format == ImageFormat::Png && scene()
}

/// Whether a scene takes levels of the film.
pub(super) fn takes_levels(scene: &str) -> bool {
    scene.lines().any(|line| line.trim() == "#scree inject levels")
}

/// The keys of a metadata file that are not given, or depend on values of all frames, so that no image can be drawn before the last frame
/// is there; those of its passes, too.
pub fn open_keys(binding: &Binding, files: &Files) -> Vec<String> {
    let mut keys = vec![];
    for object in &binding.objects {
        if matches!(object.color, Color::By { range: None, .. }) {
            keys.push(format!("the `range` of the colours of `{}`", object.name));
        }
        if matches!(object.shape, Shape::Arrow(Arrow { scale: None, .. })) {
            keys.push(format!("the `scale` of the arrows of `{}`", object.name));
        }
    }
    if matches!(&binding.camera, Some(Camera::Placed(camera)) if camera.is_smoothed()) {
        keys.push("the camera's `damping`".into());
    }
    if levels_are_open(binding, files) {
        keys.push("the output's `levels`".into());
    }
    if binding.overlays.plot.is_some() {
        keys.push("the overlay `plot`".into());
    }
    let of_passes = binding.passes.iter().flat_map(|(_, pass)| open_keys(pass, files));
    keys.extend(of_passes.collect::<Vec<_>>());
    let mut seen = std::collections::BTreeSet::new();
    keys.retain(|key| seen.insert(key.clone()));
    keys
}
