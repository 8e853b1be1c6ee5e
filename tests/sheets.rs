//! The effects of the renderer on one sheet: `docs/sheets/effects/*.rib`, drawn small and held against `tests/golden/effects.png`.
//! With `SCREE_UPDATE=1` both that and the sheet of the documentation, `docs/sheets/effects.png`, are made anew: look at them.

use crate::cli::{scratch, scree};
use crate::outputs::Layers;
use image::{Rgb, RgbImage};
use std::path::{Path, PathBuf};

/// Panels, row by row; the last three are of the variables of one picture.
const EFFECTS: [&str; 6] =
    ["soft_shadows", "occlusion", "depth_of_field", "motion_blur", "displacement", "transparency"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).into()
}

/// Draw a scene of the sheet at some size into a folder.
fn draw(name: &str, [w, h]: [u32; 2], folder: &Path) {
    let from = root().join("docs/sheets/effects");
    let text = std::fs::read_to_string(from.join(format!("{name}.rib"))).unwrap();
    assert!(text.contains("Format 480 320 1"), "{name}.rib is not of the sheet's size");
    std::fs::write(folder.join("t.rib"), text.replace("Format 480 320 1", &format!("Format {w} {h} 1"))).unwrap();
    std::fs::copy(from.join("gravel.rib"), folder.join("gravel.rib")).unwrap();
    let answer = scree(&["render", folder.join("t.rib").to_str().unwrap(), "-o", folder.to_str().unwrap()]);
    answer.ok();
    assert!(!answer.errors().contains("warning"), "{name}: {}", answer.errors());
}

/// A colour of its own for every number.
fn color_of(number: u32) -> Rgb<u8> {
    let h = number.wrapping_mul(0x9e37_79b9);
    let h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    Rgb([h, h >> 8, h >> 16].map(|x| 64 + (x & 0xff) as u8 / 4 * 3))
}

/// All panels at some size each.
fn sheet(size: [u32; 2]) -> RgbImage {
    let [w, h] = size;
    let work = scratch();
    let mut sheet = RgbImage::new(3 * w, 3 * h);
    let mut put = |k: u32, at: &dyn Fn(u32, u32) -> Rgb<u8>| {
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            sheet.put_pixel(k % 3 * w + x, k / 3 * h + y, at(x, y));
        }
    };
    for (k, name) in EFFECTS.iter().enumerate() {
        draw(name, size, work.path());
        let picture = image::open(work.path().join("out.png")).unwrap().to_rgb8();
        put(k as u32, &|x, y| *picture.get_pixel(x, y));
    }
    draw("variables", size, work.path());
    let all = Layers::read(&work.path().join("out.exr"));
    let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
    put(6, &|x, y| {
        // Near is light.
        let z = all.at("Z", x as usize, y as usize);
        Rgb([byte(1.0 - (z - 3.8) / 4.0); 3])
    });
    put(7, &|x, y| {
        let n = ["N.X", "N.Y", "N.Z"].map(|c| all.at(c, x as usize, y as usize));
        let length = n.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-6);
        Rgb(n.map(|x| byte(0.5 + 0.5 * x / length)))
    });
    put(8, &|x, y| color_of(all.at("id", x as usize, y as usize) as u32));
    sheet
}

#[test]
fn effects_look_as_they_did() {
    let golden = root().join("tests/golden/effects.png");
    let now = sheet([120, 80]);
    if std::env::var_os("SCREE_UPDATE").is_some() {
        now.save(&golden).unwrap();
        sheet([480, 320]).save(root().join("docs/sheets/effects.png")).unwrap();
    }
    let golden = image::open(&golden).unwrap_or_else(|e| panic!("{}: {e}", golden.display())).to_rgb8();
    assert_eq!(now.dimensions(), golden.dimensions());
    for k in 0..9 {
        let (x0, y0) = (k % 3 * 120, k / 3 * 80);
        let mut off = 0.0;
        for (x, y) in (0..80).flat_map(|y| (0..120).map(move |x| (x0 + x, y0 + y))) {
            off += (0..3).map(|c| now.get_pixel(x, y)[c].abs_diff(golden.get_pixel(x, y)[c]) as f64).sum::<f64>();
        }
        let off = off / (120 * 80 * 3) as f64;
        assert!(off < 1.0, "panel {k} is {off} of 255 away from the golden one on average");
    }
}
