//! How images from metadata look: the three qualities, film and data, stones by their ids, edges that catch light.

use crate::cli::{scratch, scree};
use crate::rendering::{ORTHO, render_with};
use serde_json::Value;
use std::path::Path;

/// Two stones on a ground, in a scene of the library.
fn metadata(folder: &Path, output: &str) -> String {
    std::fs::write(folder.join("s_0.csv"), "id,pos_x,pos_y,pos_z,r\n1,0,0,0.3,0.3\n2,0.55,0.1,0.3,0.3\n").unwrap();
    let text = format!(
        "data: {{files: 's_0.csv'}}\nscene: desert_noon.rib\ncamera: {{eye: [1, -3, 1.4], look_at: [0.2, 0, 0.25]}}\nobjects:
  - {{name: stones, geometry: {{sphere: {{radius: r}}}}, surface: {{name: gravel}}, displacement: {{name: stone, bound: 0.12, traced: false}}}}
output: {{resolution: [96, 54]{output}}}\n"
    );
    let path = folder.join("m.yaml");
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().into()
}

/// The image's bytes and its statistics.
fn draw(output: &str, args: &[&str]) -> (Vec<u8>, Value) {
    let work = scratch();
    let (file, out) = (metadata(work.path(), output), work.path().join("o"));
    scree(&[&["render", &file, "-o", out.to_str().unwrap(), "--stats"], args].concat()).ok();
    let stats = std::fs::read(out.join("000000.png.stats.json")).unwrap();
    let image = image::open(out.join("000000.png")).unwrap().to_rgb8().into_raw();
    (image, serde_json::from_slice(&stats).unwrap())
}

/// The mean difference of two images, of 255.
fn difference(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b) as f64).sum::<f64>() / a.len() as f64
}

#[test]
fn the_qualities_cost_more_each_and_show_the_same() {
    let all = ["draft", "normal", "final"].map(|q| draw("", &["--image-quality", q]));
    let cost = |k: usize, what: &str| {
        let stats = &all[k].1;
        stats["stats"][what].as_u64().unwrap_or_else(|| panic!("no {what} in {stats}"))
    };
    for what in ["shaded_points", "samples"] {
        assert!(cost(0, what) < cost(1, what) && cost(1, what) < cost(2, what), "{what} grow from draft to final");
    }
    let [draft, normal, last] = all.each_ref().map(|(image, _)| image);
    assert!(difference(normal, last) < 6.0, "normal is near final: {}", difference(normal, last));
    assert!(difference(draft, normal) < 20.0, "a draft shows the same scene: {}", difference(draft, normal));
    assert!(draft != normal && normal != last);
}

#[test]
fn a_quality_is_chosen_by_the_file_or_the_command_line() {
    // The key and the option are the same; normal is what is taken without; what is given beside the key goes before it.
    assert!(draw(", quality: draft", &[]).0 == draw("", &["--image-quality", "draft"]).0);
    assert!(draw("", &[]).0 == draw(", quality: normal", &[]).0);
    assert!(
        draw(", quality: draft, samples: [3, 3], shading_rate: 2", &["--image-quality", "normal"]).0 == draw("", &[]).0
    );
    assert!(
        draw(", quality: draft, samples: [2, 2]", &[]).0 == draw("", &["--image-quality", "draft", "--samples", "2"]).0
    );
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let file = metadata(work.path(), ", quality: fine");
    let said = scree(&["render", &file, "-o", &at("o")]).fails(3);
    assert!(said.contains("fine") && said.contains("draft") && said.contains("m.yaml:"), "{said}");
    std::fs::write(at("t.rib"), "# A scene.\nDisplay \"t.png\" \"png\" \"rgb\"\nWorldBegin\nWorldEnd\n").unwrap();
    let said = scree(&["render", &at("t.rib"), "--image-quality", "draft"]).fails(2);
    assert!(said.contains("--image-quality"), "{said}");
}

/// The stone of an id from the eye: a picture of radius 0.8, over nothing.
fn stone(id: u32, turn: &str) -> Vec<[f32; 4]> {
    let world = format!(
        "Surface \"constant\" Displacement \"stone\" Attribute \"displacementbound\" \"float sphere\" [0.35] {turn}
         Sphere 0.8 -0.8 0.8 360 \"uniform float id\" [{id}]"
    );
    render_with(&[], ORTHO, &world).pixels
}

#[test]
fn stones_differ_by_id_and_stay_within_their_sphere() {
    let (first, again, other) = (stone(1, ""), stone(1, ""), stone(2, ""));
    assert!(first == again && first != other, "an id has one shape");
    assert!(first != stone(1, "Rotate 40 1 1 0"), "which turns with the body");
    for shape in [&first, &other] {
        let covered: f32 = shape.iter().map(|p| p[3]).sum();
        let sphere = std::f32::consts::PI * 32.0 * 32.0;
        assert!(covered > 0.5 * sphere && covered < 0.97 * sphere, "{covered} of {sphere} pixels");
        for (k, p) in shape.iter().enumerate().filter(|(_, p)| p[3] > 0.0) {
            let [x, y] = [k % 80, k / 80].map(|i| i as f32 + 0.5 - 40.0);
            assert!(x.hypot(y) < 32.8, "({x}, {y}) is out of the sphere: {p:?}");
        }
    }
}

#[test]
fn film_darkens_what_is_bright_and_leaves_data_alone() {
    let value = |grey: f32, options: &str| {
        let options = format!("{ORTHO} {options} Imager \"film\"");
        let wall = "Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]";
        let world = format!("Surface \"constant\" Color [{grey} {grey} {grey}] {wall}");
        render_with(&[], &options, &world).at(40, 40)[0]
    };
    let [white, bright, grey, shadow] = [4.0, 2.0, 0.18, 0.02].map(|grey| value(grey, ""));
    assert!((white - 1.0).abs() < 1e-3 && bright > 0.8 && bright < 1.0, "white and nearly so: {white}, {bright}");
    assert!((grey - 0.18).abs() < 0.02, "grey stays grey: {grey}");
    assert!(shadow < 0.019, "shadows are deep: {shadow}");
    let data = "Option \"film\" \"float view\" [0]";
    assert!((value(2.0, data) - 2.0).abs() < 1e-3 && (value(0.18, data) - 0.18).abs() < 1e-3, "data is as it was");
}

#[test]
fn edges_of_boxes_turn_to_the_light() {
    // A face that looks at the eye, and a light from beside it: the face is dark, its rounded edges are not.
    let row = |kind: u32| {
        let world = format!(
            "LightSource \"distantlight\" \"lamp\" \"to\" [-1 0 0] Attribute \"shape\" \"float kind\" [{kind}]
             Surface \"concrete\" \"float bevel\" [0.2] Scale 0.8 0.8 0.8 Polygon \"P\" [-1 -1 -1  -1 1 -1  1 1 -1  1 -1 -1]"
        );
        render_with(&[], ORTHO, &world)
    };
    let edged = row(1);
    assert!(edged.at(40, 40)[0] < 0.02, "the face: {:?}", edged.at(40, 40));
    assert!(edged.at(70, 40)[0] > 0.1, "its edge: {:?}", edged.at(70, 40));
    assert!(row(0).at(70, 40)[0] < 0.02, "no box, no edge");
}

#[test]
fn edges_that_are_narrower_than_a_pixel_are_seen() {
    // The sum of light over a face's edge is in proportion to its width down to that of a pixel, and no less, as thin as it may be.
    let sum = |bevel: f32| {
        let world = format!(
            "LightSource \"distantlight\" \"lamp\" \"to\" [-1 0 0] Attribute \"shape\" \"float kind\" [1]
             Surface \"concrete\" \"float bevel\" [{bevel}] Scale 0.8 0.8 0.8 Polygon \"P\" [-1 -1 -1  -1 1 -1  1 1 -1  1 -1 -1]"
        );
        let p = render_with(&[], ORTHO, &world);
        (60..76).map(|x| p.at(x, 40)[0]).sum::<f32>()
    };
    // Pixels are 0.03 of the half edge wide.
    let [wide, thin, thinner] = [0.1, 0.006, 0.003].map(sum);
    assert!(thin > 0.2 * wide && thin < 0.6 * wide, "{thin} of {wide}");
    assert!((thinner / thin - 1.0).abs() < 0.1, "{thinner} of {thin}");
}

#[test]
fn what_covers_a_part_of_a_pixel_covers_as_much_of_the_screen() {
    let at = |opacity: f32| {
        let options = format!("{ORTHO} Imager \"film\" \"color bgcolor\" [0.5 0.5 0.5]");
        let world = format!(
            "Surface \"constant\" Color [0.18 0.18 0.18] Opacity [{opacity} {opacity} {opacity}] Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]"
        );
        render_with(&[], &options, &world).at(40, 40)[0]
    };
    let [none, half, whole] = [0.0, 0.5, 1.0].map(at);
    assert!((half - 0.5 * (none + whole)).abs() < 2e-3, "{none}, {half}, {whole}");
}

/// A heap of stones against a pale block on soil, in the morning, with as many frames as there are places for a stone that moves.
fn heap(folder: &Path, places: &[f32]) -> String {
    for (frame, x) in places.iter().enumerate() {
        let mut rows = format!("id,kind,pos_x,pos_y,pos_z,r\n0,block,0.9,0.5,0.3,0.3\n99,stone,{x},-1.2,0.1,0.1\n");
        for k in 0..40 {
            let [x, y, z] = [(k % 4) as f32 * 0.17, (k / 4 % 5) as f32 * 0.17 - 0.4, 0.1 + (k / 20) as f32 * 0.16];
            rows += &format!("{},stone,{x},{y},{z},0.1\n", k + 1);
        }
        std::fs::write(folder.join(format!("h_{frame}.csv")), rows).unwrap();
    }
    let text = "data: {files: 'h_*.csv'}\nscene: quarry.rib\ncamera: {eye: [1, -3, 1.4], look_at: [0.4, 0, 0.2], fov: 30}\nobjects:
  - {name: stones, select: kind == 'stone', geometry: {sphere: {radius: r}}, surface: {name: gravel}, displacement: {name: stone, bound: 0.04, traced: false}, color: [0.4, 0.36, 0.3]}
  - {name: block, select: kind == 'block', geometry: {box: {half: [r, r, r]}}, orientation: [0.966, 0, 0.259, 0], surface: {name: concrete}, color: [0.72, 0.7, 0.67]}
  - {name: soil, select: kind == 'block', geometry: {plane: {half: 900}}, position: [0, 0, 0], surface: {name: ground, line: 0}, color: [0.43, 0.33, 0.23]}
output: {resolution: [320, 180]}\n";
    let path = folder.join("m.yaml");
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().into()
}

/// The images of a metadata file's frames.
fn images(file: &str, frames: usize, more: &[&str]) -> Vec<image::RgbImage> {
    let out = scratch();
    scree(&[&["render", file, "-o", out.path().to_str().unwrap()], more].concat()).ok();
    (0..frames).map(|k| image::open(out.path().join(format!("{k:06}.png"))).unwrap().to_rgb8()).collect()
}

#[test]
fn films_have_blacks_and_highlights() {
    let work = scratch();
    let file = heap(work.path(), &[0.5]);
    let image = &images(&file, 1, &[])[0];
    let light = |p: &image::Rgb<u8>| (54 * p[0] as u32 + 183 * p[1] as u32 + 19 * p[2] as u32) >> 8;
    let share = |is: fn(u32) -> bool| image.pixels().filter(|p| is(light(p))).count() as f64 / (320.0 * 180.0);
    let (black, bright, middle) = (share(|l| l <= 12), share(|l| l >= 240), share(|l| (40..220).contains(&l)));
    assert!(black >= 1e-3 && bright >= 1e-3 && middle > 0.7, "{black} black, {bright} bright, {middle} between");
}

#[test]
fn what_rests_does_not_flicker() {
    let work = scratch();
    let file = heap(work.path(), &[-0.9, -0.8, -0.7]);
    let all = images(&file, 3, &[]);
    for pair in all.windows(2) {
        // The stone that moves, and its shadow, are in the lower left.
        let still = |x: u32, y: u32| x > 160 || y < 60;
        let change =
            |x, y| (0..3).map(|c| pair[0].get_pixel(x, y)[c].abs_diff(pair[1].get_pixel(x, y)[c]) as u32).max();
        let pixels = (0..180).flat_map(|y| (0..320).map(move |x| (x, y))).filter(|(x, y)| still(*x, *y));
        let changes: Vec<u32> = pixels.filter_map(|(x, y)| change(x, y)).collect();
        let mean = changes.iter().sum::<u32>() as f64 / changes.len() as f64;
        assert!(mean <= 0.05 && changes.iter().all(|c| *c <= 12), "{mean}, at most {:?}", changes.iter().max());
        assert!(pair[0] != pair[1], "the stone moves");
    }
}

#[test]
fn slow_gradients_have_no_bands() {
    // The studio's backdrop takes many rows for a level of grey: the mean of a row must follow it between the levels.
    let work = scratch();
    std::fs::write(work.path().join("s_0.csv"), "pos_x,pos_y,pos_z\n0,0,0\n").unwrap();
    let text = "data: {files: s_0.csv}\ncamera: {eye: [0, -3, 0], look_at: [0, 0, 0]}
objects: [{name: grain, geometry: {sphere: {radius: 0.001}}}]\noutput: {quality: draft, resolution: [200, 1200]}\n";
    std::fs::write(work.path().join("m.yaml"), text).unwrap();
    let image = &images(work.path().join("m.yaml").to_str().unwrap(), 1, &[])[0];
    let row = |y: u32| (0..90).map(|x| image.get_pixel(x, y)[1] as f64).sum::<f64>() / 90.0;
    let means: Vec<f64> = (0..1200).map(row).collect();
    assert!(means[1100] - means[100] > 30.0, "it brightens downwards");
    let strays = means.windows(17).map(|w| {
        let around = (w[0] + w[16]) / 2.0;
        (w[8] - around).abs()
    });
    let worst = strays.skip(50).take(1000).fold(0.0, f64::max);
    assert!(worst < 0.35, "a row is {worst} levels off its neighbours");
    let is_flat = |y: u32| (1..90).all(|x| image.get_pixel(x, y) == image.get_pixel(0, y));
    assert!((300..900).filter(|y| is_flat(*y)).count() < 200, "levels are dithered");
}

#[test]
fn pebbles_lie_still_on_soil() {
    let work = scratch();
    let file = heap(work.path(), &[0.5, 1.2]);
    let text = std::fs::read_to_string(&file).unwrap();
    // What is drawn before the data, each pebble with its place.
    let pebbles = |frame: &str| {
        let rib = scree(&["rib", &file, "-f", frame]).ok();
        let (_, after) = rib.split_once("displacementbound").unwrap_or_default();
        after.split_once("AttributeEnd\n  AttributeBegin").unwrap_or_default().0.to_string()
    };
    let still = pebbles("0");
    assert!(still.matches("Sphere ").count() > 50 && still == pebbles("1"), "the same in each frame: {still}");
    let spheres = |text: &str| {
        std::fs::write(&file, text).unwrap();
        scree(&["rib", &file, "-f", "0"]).ok().matches("Sphere ").count()
    };
    let bare = text.replace("line: 0", "line: 0, stones: 0");
    let data = spheres(&bare);
    assert!(spheres(&text) > data + 50, "pebbles on soil, but none on bare soil: {data} spheres");
    let draft = text.replace("output: {", "output: {quality: draft, ");
    let channels = text.replace("output: {", "output: {format: exr, channels: [z], ");
    let tilted = text.replace(
        "plane: {half: 900}}, position: [0, 0, 0]",
        "plane: {half: 900}}, orientation: [0.9, 0.3, 0, 0], position: [0, 0, 0]",
    );
    for (other, what) in [(draft, "a draft"), (channels, "an image with channels"), (tilted, "a slope")] {
        assert_eq!(spheres(&other), data, "{what} has none");
    }
}

/// Shares of an image that are at 12 or below, and at 240 or above, of 255.
fn dark_and_bright(image: &image::RgbImage) -> [f64; 2] {
    let light = |p: &image::Rgb<u8>| 0.2126 * p[0] as f64 + 0.7152 * p[1] as f64 + 0.0722 * p[2] as f64;
    let share = |is: &dyn Fn(f64) -> bool| image.pixels().filter(|p| is(light(p))).count() as f64;
    let n = (image.width() * image.height()) as f64;
    [share(&|l| l <= 12.0) / n, share(&|l| l >= 240.0) / n]
}

/// Bricks in a wall, over which a ball goes: nothing of it is dark by itself.
fn wall(folder: &Path) -> String {
    for frame in 0..3 {
        let mut rows = format!("id,kind,pos_x,pos_y,pos_z,r\n0,ball,{},-0.6,0.3,0.2\n", frame as f64 * 0.3 - 0.3);
        for k in 0..24 {
            let [x, z] = [(k % 6) as f64 * 0.4 + (k / 6 % 2) as f64 * 0.2 - 1.0, (k / 6) as f64 * 0.2 + 0.1];
            rows += &format!("{},brick,{x},0,{z},0.1\n", k + 1);
        }
        std::fs::write(folder.join(format!("w_{frame}.csv")), rows).unwrap();
    }
    let text = "data: {files: 'w_*.csv'}\nscene: studio.rib\ncamera: {eye: [-2, -5.8, 2.9], look_at: [0.2, 0, 0.3], fov: 32}\nground_height: 0\nobjects:
  - {name: ball, select: kind == 'ball', geometry: {sphere: {radius: r}}, surface: {name: matte}, color: [0.56, 0.48, 0.4]}
  - {name: bricks, select: kind == 'brick', geometry: {box: {half: [0.2, 0.1, 0.1]}}, surface: {name: paintedmetal, wear: 0.1}, color: [0.03, 0.18, 0.42]}
output: {resolution: [320, 180]}\n";
    let path = folder.join("m.yaml");
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().into()
}

#[test]
fn levels_give_films_that_are_pale_blacks_and_highlights() {
    let work = scratch();
    let file = wall(work.path());
    let text = std::fs::read_to_string(&file).unwrap();
    let all = images(&file, 3, &[]);
    for image in &all {
        let [dark, bright] = dark_and_bright(image);
        assert!((1e-3..0.03).contains(&dark) && (1e-3..0.03).contains(&bright), "{dark} dark, {bright} bright");
    }
    // A frame alone has the levels of its film, whatever the threads; the corner that the ball does not reach is the same in all of them.
    let out = scratch();
    let args = ["render", &file, "-o", out.path().to_str().unwrap(), "-f", "2", "--threads", "1"];
    let said = scree(&args).errors();
    assert!(image::open(out.path().join("000002.png")).unwrap().to_rgb8() == all[2]);
    let corner = |k: usize| (0..320 * 20).map(|i| *all[k].get_pixel(i % 320, i / 320)).collect::<Vec<_>>();
    assert!(corner(0) == corner(2), "what is still is the same");
    // What is said can be given, and is then not measured.
    let (_, levels) = said.split_once("`levels: ").unwrap_or_else(|| panic!("no levels: {said}"));
    let levels = levels.split('`').next().unwrap();
    let with =
        |levels: &str| std::fs::write(&file, text.replace("output: {", &format!("output: {{levels: {levels}, ")));
    with(levels).unwrap();
    assert!(images(&file, 3, &[]) == all);
    // Without, nothing is dark.
    with("[0.04, 0.95]").unwrap();
    assert!(dark_and_bright(&images(&file, 3, &[])[0])[0] < 1e-3);
    let pale = images(&file, 3, &["--image-quality", "draft"]);
    with("[0.9, 0.2]").unwrap();
    let said = scree(&["render", &file]).fails(3);
    assert!(said.contains("output.levels") || said.contains("0.01 to 0.99"), "{said}");
    // A draft has its own.
    std::fs::write(&file, &text).unwrap();
    assert!(dark_and_bright(&images(&file, 3, &["--image-quality", "draft"])[0])[0] >= 1e-3);
    assert!(dark_and_bright(&pale[0])[0] < 1e-3);
    // A scene that has its own tone is left alone, and says so of levels that are given.
    let moon = text.replace("studio.rib", "lunar.rib").replace("ground_height: 0\n", "");
    std::fs::write(&file, &moon).unwrap();
    assert!(!scree(&["rib", &file, "-f", "0"]).ok().contains("levels"));
    std::fs::write(&file, moon.replace("output: {", "output: {levels: [0.1, 0.9], ")).unwrap();
    let said = scree(&["render", &file]).fails(3);
    assert!(said.contains("#scree inject levels"), "{said}");
}

#[test]
fn levels_keep_black_white_and_order() {
    let value = |grey: f32, levels: &str| {
        let options = format!(
            "{ORTHO} Option \"film\" \"float[2] levels\" [{levels}] Imager \"film\" \"color bgcolor\" [{grey} {grey} {grey}]"
        );
        render_with(&[], &options, "").at(40, 40)[0]
    };
    let shown = |grey: f32| grey.powf(2.2);
    for grey in [0.0, 0.2, 0.5, 1.0] {
        assert!((value(grey, "0.04 0.95") - grey).abs() < 1e-6, "these change nothing");
    }
    let row: Vec<f32> = (0..=50).map(|k| value(shown(k as f32 / 50.0), "0.3 0.8").powf(1.0 / 2.2)).collect();
    assert!(row[0] == 0.0 && (row[50] - 1.0).abs() < 1e-4 && row.windows(2).all(|w| w[0] < w[1]), "{row:?}");
    assert!((row[15] - 0.04).abs() < 0.002 && (row[40] - 0.95).abs() < 0.002, "{} {}", row[15], row[40]);
}
