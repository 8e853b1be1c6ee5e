//! Spheres whose caps the device dices.

use super::{CAMERA, Compared, LIT, balls, compare, device, render};
use render::{DeviceRenderer, DrawnBy};
use std::sync::Arc;

/// Spheres whose caps the device dices: every sample sees the triangle that it sees on the processor, and what goes to the device is what caps
/// follow from, not their points. One-sided ones are diced by the processor.
#[test]
fn caps_of_spheres_are_diced_on_a_device() {
    let Some(device) = device() else { return };
    let near = "TransformBegin Translate 0.4 0.2 -2 Scale 1 0.6 1.3 Sphere 1.5 -1.5 1.5 360 TransformEnd";
    let moving = "MotionBegin [0 0.4 1] Translate 0 0 0 Translate 0.2 0.1 0 Translate 0.3 0.1 0.2 MotionEnd";
    for (name, options, motion) in [
        ("still", "", ""),
        ("motion", "Shutter 0 1", moving),
        ("lens", "DepthOfField 4 0.3 5.5", ""),
        ("parallel", "Projection \"orthographic\" ScreenWindow -3 3 -2 2", ""),
    ] {
        let camera = CAMERA.replacen("Translate", &format!("{options} Translate"), 1);
        let rib = |sides: u32| {
            format!(
                "{camera}{LIT}Sides {sides} ShadingRate 0.1 {motion} {} Color [0.3 0.9 0.4] {near} WorldEnd",
                balls(40)
            )
        };
        let c @ Compared { ids, pixels, holes, seen, .. } = compare(&rib(2), &device);
        let is_same = c.agrees() && seen > 1000 && (ids == 1.0 || name != "still");
        assert!(is_same, "{name}: ids {ids}, pixels {pixels}, holes {holes}, {seen} samples see something");
        let bytes = |sides: u32| {
            let stats = render(&rib(sides), Some(device.clone()), None).stats;
            let device = stats.device.expect("an image of a device");
            assert!(device.waits > 0 && device.submissions > 0 && device.bytes_read > 0);
            assert!(stats.micropolygons > 10_000, "{} micropolygons", stats.micropolygons);
            device.bytes_written as f64 / stats.micropolygons as f64
        };
        let [two, one] = [bytes(2), bytes(1)];
        eprintln!("{name}: {two} and {one} bytes a micropolygon");
        // A point and a micropolygon are 32 bytes.
        assert!(name == "parallel" || two + 20.0 < one, "{name}: {two} and {one} bytes a micropolygon");
    }
}

/// What is within a bound, and is hidden, is not sampled, whoever dices it: caps behind a wall, and beside the image.
#[test]
fn caps_that_are_hidden_are_counted_on_a_device() {
    if device().is_none() {
        return;
    }
    let mut device = DeviceRenderer::open(&gpu::Choice::Any).unwrap();
    (device.limits.wave, device.limits.round) = ([64, 64], 8);
    let device = Arc::new(device);
    let wall = "Patch \"bilinear\" \"P\" [-4 -4 -3 4 -4 -3 -4 4 -3 4 4 -3]";
    let own = render(&format!("{CAMERA}{LIT}{} {wall} WorldEnd", balls(40)), Some(device.clone()), None);
    let open = render(&format!("{CAMERA}{LIT}{} WorldEnd", balls(40)), Some(device), None);
    let sampled = |stats: &render::Stats| (stats.grids - stats.grids_hidden, stats.micropolygons);
    assert!(own.stats.grids_hidden > 0, "{:?}", own.stats);
    assert!(sampled(&own.stats) < sampled(&open.stats), "{:?} {:?}", own.stats, open.stats);
}

/// Buffers stay from frame to frame: the next frames need no copies of what grows and no more memory, and nothing is seen in them of what they held.
#[test]
fn buffers_are_kept_from_frame_to_frame() {
    if device().is_none() {
        return;
    }
    let open = || DeviceRenderer::open(&gpu::Choice::Any).unwrap();
    let scene = |n: usize| format!("{CAMERA}{LIT}ShadingRate 0.1 {} WorldEnd", balls(n));
    let bits = |rib: &str, device: &Arc<DeviceRenderer>| {
        let drawn = render(rib, Some(device.clone()), None);
        let bits: Vec<u32> = drawn.image.pixels.iter().flatten().map(|x| x.to_bits()).collect();
        (bits, drawn.identities, drawn.stats.device.expect("an image of a device").submissions)
    };
    let device = Arc::new(open());
    let (many, ids, first) = bits(&scene(60), &device);
    let few = bits(&scene(8), &device);
    let (again, same_ids, second) = bits(&scene(60), &device);
    assert!(many == again && ids == same_ids && second < first, "{first} and {second} submissions");
    let memory = device.most_memory();
    bits(&scene(60), &device);
    assert_eq!(device.most_memory(), memory);
    let alone = bits(&scene(8), &Arc::new(open()));
    assert!(few.0 == alone.0 && few.1 == alone.1 && few.0 != many);
    // Where memory is limited, none are kept.
    let mut limited = open();
    limited.limit_memory(256 << 20);
    let limited = Arc::new(limited);
    let [before, after] = [0; 2].map(|_| bits(&scene(60), &limited));
    assert!(before.0 == many && after.0 == many);
}

/// Frames that several threads draw on one device at once are as each is alone: none writes to a buffer that commands of another, which are not
/// sent yet, are to use.
#[test]
fn frames_of_several_threads_are_each_its_own() {
    if device().is_none() {
        return;
    }
    let device = Arc::new(DeviceRenderer::open(&gpu::Choice::Any).unwrap());
    let scenes = [5, 20, 40].map(|n| format!("{CAMERA}{LIT}ShadingRate 0.2 {} WorldEnd", balls(n)));
    let draw = |rib: &String| render(rib, Some(device.clone()), None).image;
    let alone = scenes.each_ref().map(draw);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            for (rib, alone) in scenes.iter().zip(&alone) {
                let draw = &draw;
                scope.spawn(move || (0..8).for_each(|k| assert!(draw(rib) == *alone, "frame {k}")));
            }
        }
    });
}

/// What is nearest at a sample is found in one pass where a device has atomics of 64 bits, else in two: the same bits. Several waves and several
/// flushes of them, so that what is equally deep meets what has its colour.
#[test]
fn one_pass_of_sampling_sees_what_two_see() {
    let open = || gpu::Device::open(&gpu::Choice::Any).unwrap();
    if device().is_none() {
        return;
    }
    let wall = "Patch \"bilinear\" \"P\" [-2 -2 0 2 -2 0 -2 2 0 2 2 0] Color [0.2 0.4 0.9]";
    let glass = "Opacity [0.5 0.3 0.8] Sphere 1.2 -1.2 1.2 360";
    let moving = "MotionBegin [0 1] Translate 0 0 0 Translate 0.3 0.1 0 MotionEnd";
    for (name, options, motion) in
        [("still", "", ""), ("motion", "Shutter 0 1", moving), ("lens", "DepthOfField 4 0.3 5.5", "")]
    {
        let camera = CAMERA.replacen("Translate", &format!("{options} Translate"), 1);
        let rib = format!("{camera}{LIT}{motion} {wall} {wall} {wall} {} {glass} WorldEnd", balls(40));
        let images = [open(), open().without_wide_atomics()].map(|device| {
            let mut own = DeviceRenderer::new(device).unwrap();
            (own.limits.wave, own.limits.points) = ([1 << 10, 1 << 11], 1 << 12);
            render(&rib, Some(Arc::new(own)), None)
        });
        let [one, two] = &images;
        assert!(images.iter().all(|image| image.drawn_by == DrawnBy::Gpu), "{name}");
        assert!(one.identities == two.identities && one.image == two.image, "{name}");
        assert!(one.identities.iter().any(|id| *id != 0), "{name}");
    }
}
