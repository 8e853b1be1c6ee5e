//! The effects of the renderer on one sheet: `docs/sheets/effects/*.rib`, drawn small and held to `tests/golden/effects.png`.
//! That and the sheet of the documentation, `docs/sheets/effects.png`, are drawn by an ignored test, looked at and copied by hand.

use crate::cli::{scratch, scree};
use crate::golden::{self, Panel};
use crate::outputs::Layers;
use image::{Rgb, RgbImage};
use std::path::{Path, PathBuf};

/// Panels, row by row; the last three are of the variables of one image.
const EFFECTS: [&str; 6] =
    ["soft_shadows", "occlusion", "depth_of_field", "motion_blur", "displacement", "transparency"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).into()
}

/// The heap of stones of most panels.
fn gravel() -> String {
    std::fs::read_to_string(root().join("docs/sheets/effects/gravel.rib")).unwrap()
}

/// Draw a scene of the sheet with a heap at some size into a folder.
fn draw(name: &str, gravel: &str, [w, h]: [u32; 2], folder: &Path) {
    let from = root().join("docs/sheets/effects");
    let text = std::fs::read_to_string(from.join(format!("{name}.rib"))).unwrap();
    assert!(text.contains("Format 480 320 1"), "{name}.rib is not of the sheet's size");
    std::fs::write(folder.join("t.rib"), text.replace("Format 480 320 1", &format!("Format {w} {h} 1"))).unwrap();
    std::fs::write(folder.join("gravel.rib"), gravel).unwrap();
    let answer = scree(&["render", folder.join("t.rib").to_str().unwrap(), "-o", folder.to_str().unwrap()]);
    answer.ok();
    assert!(!answer.errors().contains("warning"), "{name}: {}", answer.errors());
}

/// A colour of its own for every id.
fn color_of(id: u32) -> Rgb<u8> {
    let h = id.wrapping_mul(0x9e37_79b9);
    let h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    Rgb([h, h >> 8, h >> 16].map(|x| 64 + (x & 0xff) as u8 / 4 * 3))
}

/// The panel of an effect.
fn effect(name: &str, gravel: &str, size: [u32; 2]) -> RgbImage {
    let work = scratch();
    draw(name, gravel, size, work.path());
    image::open(work.path().join("out.png")).unwrap().to_rgb8()
}

/// The panels of the variables of one image: depth, normals, ids.
fn variables(gravel: &str, [w, h]: [u32; 2]) -> [RgbImage; 3] {
    let work = scratch();
    draw("variables", gravel, [w, h], work.path());
    let all = Layers::read(&work.path().join("out.exr"));
    let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
    let depth = |x: usize, y: usize| {
        // Near is light.
        let z = all.at("Z", x, y);
        Rgb([byte(1.0 - (z - 3.8) / 4.0); 3])
    };
    let normal = |x: usize, y: usize| {
        let n = ["N.X", "N.Y", "N.Z"].map(|c| all.at(c, x, y));
        let length = n.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-6);
        Rgb(n.map(|x| byte(0.5 + 0.5 * x / length)))
    };
    let id = |x: usize, y: usize| color_of(all.at("id", x, y) as u32);
    let panels: [&dyn Fn(usize, usize) -> Rgb<u8>; 3] = [&depth, &normal, &id];
    panels.map(|at| RgbImage::from_fn(w, h, |x, y| at(x as usize, y as usize)))
}

/// Names of the panels, row by row, and the tolerance of each: what is a fraction of a pixel's colour where a sample at an edge
/// flips is a whole pixel of a depth or an id, and a normal turns farther than a colour.
const PANELS: [(&str, f64); 9] = [
    (EFFECTS[0], golden::STEADY),
    (EFFECTS[1], golden::STEADY),
    (EFFECTS[2], golden::STEADY),
    (EFFECTS[3], golden::STEADY),
    (EFFECTS[4], golden::STEADY),
    (EFFECTS[5], golden::STEADY),
    ("depth", 7.0),
    ("normals", 3.0),
    ("ids", 13.0),
];

/// Where a panel is on the sheet.
fn place(k: usize, [w, h]: [u32; 2]) -> [u32; 2] {
    [k as u32 % 3 * w, k as u32 / 3 * h]
}

/// All panels at some size each.
fn sheet(size: [u32; 2]) -> RgbImage {
    let gravel = gravel();
    let mut sheet = RgbImage::new(3 * size[0], 3 * size[1]);
    let effects = EFFECTS.iter().map(|name| effect(name, &gravel, size));
    for (k, panel) in effects.chain(variables(&gravel, size)).enumerate() {
        let [x, y] = place(k, size);
        image::imageops::replace(&mut sheet, &panel, x.into(), y.into());
    }
    sheet
}

/// What renders the sheets.
const COMMAND: &str = "cargo test --release --test tests -- --ignored the_sheet_of_effects_is_drawn";

/// Size of a panel of the golden sheet.
const SMALL: [u32; 2] = [120, 80];

#[test]
fn effects_look_as_they_did() {
    let panels: Vec<Panel> = PANELS
        .into_iter()
        .enumerate()
        .map(|(k, (name, tolerance))| (name, place(k, SMALL), SMALL, tolerance))
        .collect();
    golden::hold_panels("effects", &sheet(SMALL), &panels, COMMAND).unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn the_sheet_misses_a_stone_that_vanishes() {
    // The nearest of the heap: near the eye is at low y.
    let gravel = gravel();
    let stones: Vec<&str> = gravel.split_inclusive("AttributeEnd\n").collect();
    let depth = |stone: &str| {
        let line = stone.lines().find(|l| l.trim().starts_with("Translate")).unwrap();
        line.split_whitespace().nth(2).unwrap().parse::<f64>().unwrap()
    };
    let near = (0..stones.len()).min_by(|a, b| depth(stones[*a]).total_cmp(&depth(stones[*b]))).unwrap();
    let rest: String = stones.iter().enumerate().filter(|(i, _)| *i != near).map(|(_, s)| *s).collect();
    let golden = image::open(root().join("tests/golden/effects.png")).unwrap().to_rgb8();
    let colors = [0, 3].map(|k| (k, effect(EFFECTS[k], &rest, SMALL)));
    for (k, now) in colors.into_iter().chain((6..).zip(variables(&rest, SMALL))) {
        let ([x, y], (name, tolerance)) = (place(k, SMALL), PANELS[k]);
        let golden = image::imageops::crop_imm(&golden, x, y, SMALL[0], SMALL[1]).to_image();
        assert!(golden::compare(&now, &golden, tolerance).is_err(), "{name}: nobody would see that a stone is gone");
    }
}

#[test]
#[ignore = "draws the golden sheet and that of the documentation, to be looked at and copied by hand"]
fn the_sheet_of_effects_is_drawn() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sheets");
    std::fs::create_dir_all(&folder).unwrap();
    for (size, goal) in [(SMALL, "tests/golden/effects.png"), ([480, 320], "docs/sheets/effects.png")] {
        let path = folder.join(format!("effects_{}.png", size[0]));
        sheet(size).save(&path).unwrap();
        eprintln!("{} is for {goal}", path.display());
    }
}
