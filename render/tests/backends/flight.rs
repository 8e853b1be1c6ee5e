//! Frames that are drawn at a time on one device, and those of a device that is lost.

use crate::{CAMERA, LIT, device, render};
use render::{DeviceRenderer, DrawnBy, RenderResult};
use std::sync::Arc;

fn scene(k: usize) -> String {
    let color = k as f32 / 8.0;
    format!(
        "{CAMERA}{LIT}Color [1 {color} 0.5] Sphere 1 -1 1 360 Translate {color} 1 0 Sphere 0.5 -0.5 0.5 360 WorldEnd"
    )
}

/// Draw scenes, each by a thread of its own.
fn in_flight(device: &Arc<DeviceRenderer>, n: usize) -> Vec<RenderResult> {
    std::thread::scope(|scope| {
        let draw = |k| scope.spawn(move || render(&scene(k), Some(device.clone()), None));
        let threads: Vec<_> = (0..n).map(draw).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

/// Images are those of frames that are drawn one by one, and statistics are each frame's own.
#[test]
fn frames_in_flight_are_as_if_alone() {
    if device().is_none() {
        return;
    }
    let own = Arc::new(DeviceRenderer::open(&gpu::Choice::Any).unwrap());
    // What is compiled for the first serves the others.
    render(&scene(0), Some(own.clone()), None);
    let alone: Vec<RenderResult> = (0..6).map(|k| render(&scene(k), Some(own.clone()), None)).collect();
    for (k, (beside, alone)) in in_flight(&own, 6).iter().zip(&alone).enumerate() {
        assert_eq!((&beside.drawn_by, &alone.drawn_by), (&DrawnBy::Gpu, &DrawnBy::Gpu));
        assert!(beside.image == alone.image && beside.identities == alone.identities, "{k}");
        let bytes = |result: &RenderResult| result.stats.device.map(|d| [d.bytes_written, d.bytes_read]);
        assert_eq!(bytes(beside), bytes(alone), "{k}");
        assert!(bytes(beside).is_some_and(|[written, read]| written > 0 && read > 0));
    }
}

/// Frames that are in flight when their device is lost are drawn by the processor.
#[test]
fn a_device_that_is_lost_loses_no_frame_in_flight() {
    if device().is_none() {
        return;
    }
    let own = Arc::new(DeviceRenderer::open(&gpu::Choice::Any).unwrap());
    let alone: Vec<RenderResult> = (0..4).map(|k| render(&scene(k), Some(own.clone()), None)).collect();
    let drawn = std::thread::scope(|scope| {
        let drawn = scope.spawn(|| in_flight(&own, 4));
        std::thread::sleep(std::time::Duration::from_millis(5));
        own.lose();
        drawn.join().unwrap()
    });
    for (k, drawn) in drawn.iter().enumerate() {
        let expected = match &drawn.drawn_by {
            DrawnBy::Gpu => &alone[k],
            // What was under way may fail before the loss is known, and says so in its own words.
            DrawnBy::Fallback(_) => &render(&scene(k), None, None),
            other => panic!("{other:?}"),
        };
        assert!(drawn.image == expected.image, "{k}");
    }
    // Where all were done before, the loss is known by the next.
    let next = render(&scene(0), Some(own.clone()), None).drawn_by;
    assert!(matches!(&next, DrawnBy::Fallback(_)), "{next:?}");
    assert!(own.has_failed());
}

/// The frame of a device that is lost is drawn by the processor.
#[test]
fn a_lost_device_loses_no_image() {
    if device().is_none() {
        return;
    }
    let own = Arc::new(DeviceRenderer::open(&gpu::Choice::Any).unwrap());
    let rib = format!("{CAMERA}{LIT}Sphere 1 -1 1 360 WorldEnd");
    assert_eq!(render(&rib, Some(own.clone()), None).drawn_by, DrawnBy::Gpu);
    own.lose();
    let drawn = render(&rib, Some(own.clone()), None);
    assert!(matches!(&drawn.drawn_by, DrawnBy::Fallback(why) if why.contains("lost")), "{:?}", drawn.drawn_by);
    assert!(own.has_failed() && drawn.image == render(&rib, None, None).image);
}
