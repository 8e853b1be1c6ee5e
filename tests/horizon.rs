//! Ground to the horizon: at 16 samples a pixel it shows neither grain nor moiré, and keeps its mean brightness.

use crate::rendering::{Rendered, render_with};

/// The eye 1.6 over ground that goes on for kilometres, its horizon in the middle of the image.
const EYE: &str = "Format 160 120 1 PixelSamples 4 4 PixelFilter \"gaussian\" 2 2 Projection \"perspective\" \"fov\" 50
    ConcatTransform [1 0 0 0  0 0 1 0  0 1 0 0  0 0 0 1] Translate 0 0 -1.6";

fn ground(files: &[(&str, &[u8])], surface: &str) -> Rendered {
    turned(files, surface, "")
}

/// The same, the ground turned about the eye's foot.
fn turned(files: &[(&str, &[u8])], surface: &str, turn: &str) -> Rendered {
    let texture = if files.is_empty() {
        ""
    } else {
        "MakeTexture \"board.png\" \"board\" \"periodic\" \"periodic\" \"gaussian\" 2 2"
    };
    let light = "LightSource \"ambientlight\" 1 \"intensity\" [0.3] LightSource \"distantlight\" 2 \"intensity\" [0.7] \"from\" [0 0 0] \"to\" [0.3 0.2 -1]";
    let plane = "Polygon \"P\" [-5000 -10 0 5000 -10 0 5000 5000 0 -5000 5000 0] \"st\" [-5000 -10 5000 -10 5000 5000 -5000 5000]";
    render_with(
        files,
        &format!("{EYE} {texture}"),
        &format!("{light} Color 0.6 0.6 0.6 {turn} Surface {surface} {plane}"),
    )
}

/// Of rows of an image: the mean, and the mean difference of neighbours along a row and between rows, by the mean.
fn grain(image: &Rendered, rows: std::ops::Range<usize>) -> (f32, f32) {
    let green = |x: usize, y: usize| image.at(x, y)[1];
    let all: Vec<(usize, usize)> = rows.clone().flat_map(|y| (4..150).map(move |x| (x, y))).collect();
    let mean = all.iter().map(|(x, y)| green(*x, *y)).sum::<f32>() / all.len() as f32;
    // What is smooth has no second difference.
    let bent = |a: f32, b: f32, c: f32| (a - 2.0 * b + c).abs();
    let rough = all.iter().map(|(x, y)| bent(green(x - 1, *y), green(*x, *y), green(x + 1, *y))).sum::<f32>();
    (mean, rough / all.len() as f32 / mean)
}

#[test]
fn ground_shaders_fade_to_their_mean() {
    for shader in ["gravel", "sand", "regolith", "rock", "ground", "concrete", "clay", "dust"] {
        let image = ground(&[], &format!("\"{shader}\""));
        // From the horizon's row down to 20 m away and nearer; in the foreground patterns are wide.
        let (far, rough) = grain(&image, 62..72);
        let (near, _) = grain(&image, 85..118);
        assert!(rough < 0.02, "{shader}: grain {rough} below the horizon");
        // Lunar soil is brighter the flatter it is looked at: 1 / (μ₀ + μ).
        assert!((far / near - 1.0).abs() < 0.12 || shader == "regolith", "{shader}: {far} far away, {near} near by");
    }
}

#[test]
fn fine_textures_fade_to_their_mean() {
    // A checkerboard of a metre, 64 texels: half of it is white, half black.
    let mut bytes = std::io::Cursor::new(vec![]);
    let board = image::GrayImage::from_fn(64, 64, |x, y| image::Luma([if (x / 8 + y / 8) % 2 == 0 { 255 } else { 0 }]));
    board.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    let show = b"surface show() { Oi = 1; Ci = color texture(\"board\"); }";
    let files: [(&str, &[u8]); 2] = [("board.png", bytes.get_ref()), ("show.sl", show)];
    let image = ground(&files, "\"show\"");
    let (mean, rough) = grain(&image, 62..72);
    assert!((mean - 0.5).abs() < 0.02 && rough < 0.02, "mean {mean}, grain {rough}");
}

#[test]
fn textures_seen_askew_fade_to_their_mean() {
    // A checkerboard of half a metre, seen along neither of its axes: rows and columns of the grid are near each other on the image.
    let mut bytes = std::io::Cursor::new(vec![]);
    let board =
        image::GrayImage::from_fn(64, 64, |x, y| image::Luma([if (x / 32 + y / 32) % 2 == 0 { 255 } else { 0 }]));
    board.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    let show = b"surface show() { Oi = 1; Ci = color texture(\"board\"); }";
    let files: [(&str, &[u8]); 2] = [("board.png", bytes.get_ref()), ("show.sl", show)];
    let image = turned(&files, "\"show\"", "Rotate 22 0 0 1");
    // Nearer by there are rows of squares that line up, as they should.
    let (mean, rough) = grain(&image, 62..64);
    assert!((mean - 0.5).abs() < 0.02 && rough < 0.01, "mean {mean}, grain {rough}");
}
