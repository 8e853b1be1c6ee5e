//! One-sided primitives on a device: the sides that each sample sees are those that it sees on the processor.

use super::{CAMERA, LIT, compare, device, render};

#[test]
fn the_same_sides_are_seen_on_a_device() {
    let Some(device) = device() else { return };
    let torus = "Rotate 30 1 0 0 Torus 1.2 0.5 0 360 270 ";
    let moves = "MotionBegin [0 1] Translate -0.2 0 0 Translate 0.2 0.1 0.3 MotionEnd ";
    let turns = "MotionBegin [0 1] Rotate -50 1 0.3 0 Rotate 70 1 0.3 0 MotionEnd ";
    for sides in ["Sides 1 ", "Sides 1 ReverseOrientation ", "Sides 1 Scale -1 1 1 "] {
        for (options, place) in [
            ("", ""),
            ("Shutter 0 1 ", moves),
            ("Shutter 0 1 ", turns),
            ("DepthOfField 2 0.5 6 ", ""),
            ("Shutter 0 1 DepthOfField 2 0.5 6 ", turns),
        ] {
            for opacity in ["", "Opacity [0.5 0.5 0.5] "] {
                let shadows = "Attribute \"visibility\" \"string transmission\" \"transparent\" ";
                let of = |sides: &str| {
                    let points = "Points \"P\" [-2 0.5 0 2 0.5 0] \"constantwidth\" 0.6 ";
                    format!("{options}{CAMERA}{LIT}{shadows}{opacity}{sides}{place}{torus}{points}WorldEnd")
                };
                let found = compare(&of(sides), &device);
                assert!(
                    found.agrees() && (found.seen > 1000 || !opacity.is_empty()),
                    "{}: ids {}, pixels {}",
                    of(sides),
                    found.ids,
                    found.pixels
                );
                let (one, both) =
                    (render(&of(sides), None, None), render(&of(&sides.replace("Sides 1 ", "")), None, None));
                assert!(one.image.pixels != both.image.pixels, "{}", of(sides));
            }
        }
    }
}
