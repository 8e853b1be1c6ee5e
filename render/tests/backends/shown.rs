//! Colours that a display shows as they are, and hollows of curved surfaces under the sky, on a device as on the processor.

use super::{CAMERA, device, same};

/// Marks before and behind what is translucent and beside spheres, through imagers and without one.
#[test]
fn what_is_shown_as_it_is_is_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let world = "WorldBegin LightSource \"distantlight\" \"a\" \"to\" [0.4 -0.5 1] LightSource \"ambientlight\" \"b\" Surface \"matte\"
        Color [0.9 0.8 0.6] Translate -1 0 0 Sphere 0.6 -0.6 0.6 360 Translate 1 0 0 Surface \"mark\" Color [1 0.1 0] Cylinder 0.2 -1.5 1.5 360
        AttributeBegin Opacity [0.4 0.4 0.4] Color [0 0.2 1] Translate 0.5 0 0 Sphere 0.5 -0.5 0.5 360 AttributeEnd
        Surface \"matte\" Opacity [0.5 0.5 0.5] Translate 0 0.5 -1 Sphere 0.7 -0.7 0.7 360 WorldEnd";
    let film = "Exposure 1 2.2 Option \"imager\" \"float exposed\" [0] Imager \"film\" \"uniform float exposure\" [3] \"uniform float white\" [0.6]
        \"uniform color bgcolor\" [0.4 0.5 0.6]\n";
    let mut wrong = String::new();
    for (name, options) in [
        ("film", film),
        ("gain", "Exposure 2 2.2\n"),
        ("background", "Imager \"background\" \"uniform color bgcolor\" [0.2 0.3 0.4]\n"),
    ] {
        wrong += &same(name, &format!("{options}{CAMERA}{world}"), &device);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Tubes and bowls that are seen from within.
#[test]
fn hollows_under_the_sky_are_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let world = "WorldBegin LightSource \"skylight\" \"sky\" LightSource \"sunlight\" \"sun\" Surface \"matte\" Color [0.7 0.6 0.5]
        Translate -1 0 0 Cylinder 0.8 -0.6 0.6 360 Translate 2 0 0 Rotate 90 1 0 0 Sphere 0.8 -0.8 0.2 360 Translate -1 0 -1 Cone -0.8 0.6 360 WorldEnd";
    let wrong = same("hollows", &format!("{CAMERA}{world}"), &device);
    assert!(wrong.is_empty(), "{wrong}");
}
