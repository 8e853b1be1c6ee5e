//! What goes to a device.

use super::{CAMERA, LIT, compare, device, render};

/// The points, normals and directions of view that a surface's shader is given are there for its atmosphere's: they go to the device once.
#[test]
fn what_an_atmosphere_is_given_as_its_surface_was_stays_on_the_device() {
    let Some(device) = device() else { return };
    let rib = |atmosphere: &str| {
        let patch = "Patch \"bilinear\" \"P\" [-2 -1.5 1 2 -1.5 1 -2 1.5 0 2 1.5 0]";
        format!("{CAMERA}{LIT}{atmosphere} Surface \"plastic\" ShadingRate 0.1 {patch} WorldEnd")
    };
    let fog = rib("Atmosphere \"fog\" \"uniform float distance\" 5");
    assert!(compare(&fog, &device).agrees());
    let written = |rib: &str| {
        let stats = render(rib, Some(device.clone()), None).stats;
        (stats.device.expect("an image of a device").bytes_written as f64, stats.shaded_points as f64)
    };
    let ((with, n), (without, n_without)) = (written(&fog), written(&rib("")));
    // What may be translucent has all points that layers may need.
    assert!(n > 5000.0 && n_without > 0.99 * n, "{n} and {n_without} points");
    // A point, its normal and the direction from the eye are 36 bytes, a colour and an opacity 24.
    let more = (with - without) / n;
    assert!(more < 4.0, "an atmosphere takes {more} bytes a point more");
}
