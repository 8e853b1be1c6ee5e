//! What goes to a device, and how often.

use super::{CAMERA, LIT, balls, compare, device, render};
use render::DeviceRenderer;
use std::sync::Arc;

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

/// Of an image the waves, the dispatches and the memory are counted: less memory takes more waves, and is kept within.
#[test]
fn waves_dispatches_and_memory_are_counted() {
    if device().is_none() {
        return;
    }
    let camera = CAMERA.replace("Format 96 72", "Format 320 240");
    let rib = format!("{camera}{LIT}ShadingRate 0.1 {} WorldEnd", balls(200));
    let counted = |limit: Option<u64>| {
        let mut own = DeviceRenderer::open(&gpu::Choice::Any).unwrap();
        limit.iter().for_each(|bytes| own.limit_memory(*bytes));
        let own = Arc::new(own);
        let first = render(&rib, Some(own.clone()), None);
        let stats = first.stats.device.unwrap_or_else(|| panic!("{:?}", first.drawn_by));
        assert_eq!(stats.device_bytes, own.most_memory());
        assert!(stats.dispatches > 5 && stats.waves > 0, "{stats:?}");
        assert!(stats.largest_buffer_bytes > 0 && stats.largest_buffer_bytes < stats.device_bytes, "{stats:?}");
        // Another image counts its own.
        let again = render(&rib, Some(own), None).stats.device.expect("an image of a device");
        assert!(
            again.waves == stats.waves
                && again.dispatches <= stats.dispatches
                && again.device_bytes >= stats.device_bytes
        );
        (stats, first.image)
    };
    let ((all, image), (few, same)) = (counted(None), counted(Some(render::LEAST_DEVICE_MEMORY)));
    assert!(image == same);
    assert!(few.device_bytes <= render::LEAST_DEVICE_MEMORY && few.device_bytes < all.device_bytes, "{few:?} {all:?}");
    assert!(few.waves > all.waves && few.dispatches > all.dispatches, "{few:?} {all:?}");
}
