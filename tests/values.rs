//! The corpus of values: small scenes and expressions of shaders, each with what it must give, computed by hand from the RISpec 3.2.

use crate::cli::{scratch, scree};
use crate::rendering::{ORTHO, Rendered, render_with};
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/values")
}

fn text(name: &str) -> String {
    std::fs::read_to_string(folder().join(name)).unwrap()
}

/// A grey image as PNG, of a value for each column.
fn columns(values: impl Iterator<Item = u8>) -> Vec<u8> {
    let row: Vec<u8> = values.collect();
    let image = image::GrayImage::from_fn(row.len() as u32, 16, |x, _| image::Luma([row[x as usize]]));
    let mut bytes = std::io::Cursor::new(vec![]);
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// The shaders of the corpus and the images that they look up.
fn files() -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder()).unwrap().map(|e| e.unwrap().path());
    let shaders = entries.filter(|path| path.extension().is_some_and(|e| e == "sl"));
    let named = |path: PathBuf| (path.file_name().unwrap().to_str().unwrap().into(), std::fs::read(&path).unwrap());
    let ramp = ("ramp.png".to_string(), columns((0..=255).map(|k| k as u8)));
    let edge = ("edge.png".to_string(), columns((0..64).map(|k| if k < 32 { 0 } else { 255 })));
    shaders.map(named).chain([ramp, edge]).collect()
}

/// The mean of the four pixels around a place of the plane that [`ORTHO`] looks at.
fn around(image: &Rendered, x: f32, y: f32) -> [f32; 4] {
    let (i, j) = ((40.0 * (x + 1.0)).round() as usize, (40.0 * (1.0 - y)).round() as usize);
    let four = [(i - 1, j - 1), (i, j - 1), (i - 1, j), (i, j)].map(|(i, j)| image.at(i, j));
    [0, 1, 2, 3].map(|c| four.iter().map(|p| p[c]).sum::<f32>() / 4.0)
}

/// What is wrong with an expectation about an image, if anything.
fn miss(image: &Rendered, expected: &str, tolerance: f32) -> Option<String> {
    let (place, values) = expected.split_once(':').unwrap_or_else(|| panic!("`{expected}` has no colon"));
    let number = |word: &str| word.parse::<f32>().unwrap_or_else(|_| panic!("`{word}` of `{expected}` is no number"));
    if place == "area" {
        let mut words = values.split_whitespace();
        let wanted = number(words.next().unwrap());
        let channel = words.nth(1).map_or(0, |c| c.parse().unwrap());
        let found = image.pixels.iter().map(|p| p[channel]).sum::<f32>() / 1600.0;
        return ((found - wanted).abs() > tolerance * wanted.max(1.0))
            .then(|| format!("area {found}, expected {wanted}"));
    }
    let place: Vec<f32> = place.split_whitespace().map(number).collect();
    let found = around(image, place[0], place[1]);
    let is_near = |(c, word): (usize, &str)| {
        word == "_" || (found[c] - number(word)).abs() <= tolerance * number(word).abs().max(1.0)
    };
    let near = values.split_whitespace().enumerate().all(is_near);
    (!near).then(|| format!("{found:?} at {place:?}, expected {values}"))
}

#[test]
fn scenes_have_the_values_of_the_specification() {
    let files = files();
    let files: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())).collect();
    let text = text("rib.txt");
    let (mut n, mut wrong) = (0, vec![]);
    for case in text.split("\n## ").skip(1) {
        let (name, rest) = case.split_once('\n').unwrap();
        let of = |mark: &str| rest.lines().filter_map(|l| l.strip_prefix(mark)).collect::<Vec<&str>>();
        let further = of("+ ").first().map(|more| ORTHO.replace("Translate 0 0 5", more));
        let options = of("* ").first().map(|all| all.to_string()).or(further).unwrap_or(ORTHO.into());
        let tolerance = of("~ ").first().map_or(0.01, |t| t.parse().unwrap());
        let is_world = |l: &&str| !["+ ", "* ", "~ ", "= "].iter().any(|mark| l.starts_with(mark));
        let world: Vec<&str> = rest.lines().filter(is_world).collect();
        let image = render_with(&files, &options, &world.join("\n"));
        let expected = of("= ");
        assert!(!expected.is_empty(), "{name} expects nothing");
        wrong.extend(expected.into_iter().filter_map(|e| Some(format!("{name}: {}", miss(&image, e, tolerance)?))));
        n += 1;
    }
    assert!(n >= 120, "{n} scenes");
    assert!(wrong.is_empty(), "{} of {n} scenes: {wrong:#?}", wrong.len());
}

/// An expression of the corpus: statements before it, itself, and its numbers.
fn expressions(text: &str) -> Vec<(&str, &str, Vec<f32>)> {
    let lines = text.lines().filter(|l| !l.is_empty() && !l.starts_with('#'));
    let parts = lines.map(|line| {
        let (left, right) = line.rsplit_once(" = ").unwrap_or_else(|| panic!("`{line}` has no value"));
        let (before, expression) = left.split_once(" |> ").unwrap_or(("", left));
        let numbers = right.split_whitespace().map(|w| w.parse().unwrap_or_else(|_| panic!("`{line}`"))).collect();
        (before, expression, numbers)
    });
    parts.collect()
}

#[test]
fn expressions_have_the_values_of_the_specification() {
    let text = text("shader.txt");
    let all = expressions(&text);
    assert!(all.len() >= 200, "{} expressions", all.len());
    let work = scratch();
    // A pixel each, in one image.
    let mut world = String::new();
    for (k, (before, expression, numbers)) in all.iter().enumerate() {
        let value = if numbers.len() == 1 { expression.to_string() } else { format!("color({expression})") };
        let shader = format!("surface t(float gain = 2;) {{\n{before}\nOi = 1; Ci = {value}; }}");
        std::fs::write(work.path().join(format!("t{k}.sl")), shader).unwrap();
        let [a, b] = [k, k + 1].map(|x| x as f32 / 2.0);
        world += &format!(
            "Surface \"t{k}\" TransformBegin Scale 2 3 0.5 Polygon \"P\" [{a} 0 0 {b} 0 0 {b} 0.3333333 0 {a} 0.3333333 0] TransformEnd\n"
        );
    }
    let (n, path) = (all.len(), work.path().join("t.rib"));
    let scene = format!(
        "Display \"t.exr\" \"exr\" \"rgba\"\nFormat {n} 1 1\nPixelSamples 1 1\nPixelFilter \"box\" 1 1\nClipping 1 100\nShutter 0 1
        Projection \"orthographic\"\nScreenWindow 0 {n} 0 1\nOption \"user\" \"float z\" [3]\nTranslate 0 0 5\nWorldBegin
        LightSource \"ambientlight\" 1 \"intensity\" [0.25]
        LightSource \"distantlight\" 2 \"intensity\" [0.5] \"to\" [0 0 1] \"shadowname\" [\"\"]
        Attribute \"user\" \"float x\" [7] \"string y\" [\"hi\"]\nAttribute \"identifier\" \"name\" [\"me\"]\nColor 0.2 0.4 0.6
        TransformBegin Translate 7 0 0 CoordinateSystem \"mine\" TransformEnd\n{world}\nWorldEnd\n"
    );
    std::fs::write(&path, scene).unwrap();
    scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()]).ok();
    let image = image::open(work.path().join("t.exr")).unwrap().to_rgba32f();
    let mut wrong = vec![];
    for (k, (_, expression, numbers)) in all.iter().enumerate() {
        let found = image.get_pixel(k as u32, 0).0;
        let is_near = |(c, x): (usize, &f32)| (found[c] - x).abs() <= 3e-4 * x.abs().max(1.0);
        if !numbers.iter().enumerate().all(is_near) {
            wrong.push(format!("{expression}: {found:?}, expected {numbers:?}"));
        }
    }
    assert!(wrong.is_empty(), "{} of {n}: {wrong:#?}", wrong.len());
}
