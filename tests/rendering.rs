//! Images against answers known on paper, then against a golden one.

use crate::cli::{scratch, scree};
use crate::golden;
use glam::DVec3;
use std::path::Path;

/// Where this variable of the environment is set, images are drawn on the first graphics adapter.
pub const ON_DEVICE: &str = "IMAGES_OF_A_DEVICE";

/// A rendered image: floats, red green blue coverage.
pub struct Rendered {
    pub width: usize,
    pub pixels: Vec<[f32; 4]>,
}

impl Rendered {
    pub fn at(&self, x: usize, y: usize) -> [f32; 4] {
        self.pixels[y * self.width + x]
    }

    pub fn coverage(&self) -> f32 {
        self.pixels.iter().map(|p| p[3]).sum()
    }
}

/// Render the world part of a RIB after options, as floats.
fn render(options: &str, world: &str) -> Rendered {
    render_with(&[], options, world)
}

/// Render with shaders and other files beside the RIB.
pub fn render_with(files: &[(&str, &[u8])], options: &str, world: &str) -> Rendered {
    let work = scratch();
    for (name, bytes) in files {
        std::fs::write(work.path().join(name), bytes).unwrap();
    }
    let path = work.path().join("t.rib");
    let text = format!("Display \"t.exr\" \"exr\" \"rgba\"\n{options}\nWorldBegin\n{world}\nWorldEnd\n");
    std::fs::write(&path, text).unwrap();
    let own = ["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()];
    let device: &[&str] =
        if std::env::var_os(ON_DEVICE).is_some() { &["--backend", "gpu", "--adapter", "0"] } else { &[] };
    let answer = scree(&[&own[..], device].concat());
    assert!(device.is_empty() || !answer.errors().contains("the processor has drawn"), "{}", answer.errors());
    answer.ok();
    let image = image::open(work.path().join("t.exr")).unwrap().to_rgba32f();
    let width = image.width() as usize;
    Rendered { width, pixels: image.pixels().map(|p| p.0).collect() }
}

/// Looking along z from −5, ±1 across the image.
pub const ORTHO: &str =
    "Format 80 80 1 PixelSamples 8 8 PixelFilter \"box\" 1 1 Projection \"orthographic\" Translate 0 0 5";

#[test]
fn a_sphere_is_lit_by_lamberts_law() {
    // The light comes from the eye: at distance r from the axis the cosine is √(1 − r²/R²).
    let p = render(
        ORTHO,
        "LightSource \"distantlight\" 1 \"to\" [0 0 1] Surface \"matte\" \"Ka\" 0 \"Kd\" 1 Color .8 .6 .4 Sphere .9 -.9 .9 360",
    );
    for y in 4..76 {
        for x in 4..76 {
            let (dx, dy) = ((x as f32 + 0.5) / 40.0 - 1.0, (y as f32 + 0.5) / 40.0 - 1.0);
            let r2 = (dx * dx + dy * dy) / 0.81;
            if r2 < 0.9 {
                let cosine = (1.0 - r2).sqrt();
                let [r, g, b, a] = p.at(x, y);
                for (value, color) in [(r, 0.8), (g, 0.6), (b, 0.4), (a, 1.0 / cosine)] {
                    assert!((value - color * cosine).abs() < 0.01, "({x}, {y}): {value}, expected {}", color * cosine);
                }
            }
        }
    }
}

#[test]
fn a_disc_covers_its_area_and_has_no_facets() {
    for radius in [0.05f32, 0.31, 0.9] {
        let p = render(ORTHO, &format!("Surface \"constant\" Sphere {radius} -{radius} {radius} 360"));
        let expected = std::f32::consts::PI * (radius * 40.0).powi(2);
        let error = (p.coverage() - expected).abs() / expected;
        assert!(error < 0.01, "radius {radius}: {} pixels covered, expected {expected}", p.coverage());
    }
}

#[test]
fn a_half_plane_covers_half_through_every_filter() {
    for filter in ["box", "triangle", "gaussian", "catmull-rom", "sinc", "mitchell"] {
        let width = if filter == "box" { 1 } else { 4 };
        let options = ORTHO.replace("\"box\" 1 1", &format!("\"{filter}\" {width} {width}"));
        // The edge runs through the middle of pixel column 40: x from 0 to 0.025.
        let p = render(&options, "Surface \"constant\" Polygon \"P\" [0.0125 -2 0 4 -2 0 4 2 0 0.0125 2 0]");
        for y in 10..70 {
            assert!((p.at(40, y)[3] - 0.5).abs() < 0.13, "{filter}: {}", p.at(40, y)[3]);
            assert!(p.at(34, y)[3].abs() < 1e-3 && (p.at(46, y)[3] - 1.0).abs() < 1e-3, "{filter}");
        }
        let mean = (10..70).map(|y| p.at(40, y)[3]).sum::<f32>() / 60.0;
        assert!((mean - 0.5).abs() < 0.02, "{filter}: mean {mean}");
    }
}

/// RISpec appendix E: of r = √(x² + y²), within the rectangle of the widths.
#[test]
fn catmull_rom_is_a_filter_of_the_distance() {
    let cubic = |r: f64| match r {
        r if r < 1.0 => 1.5 * r * r * r - 2.5 * r * r + 1.0,
        r if r < 2.0 => -0.5 * r * r * r + 2.5 * r * r - 4.0 * r + 2.0,
        _ => 0.0,
    };
    // What is right of an edge: the filter's sum there by that of the whole, with steps of 1/100 pixel.
    let beyond = |edge: f64, [width, height]: [i32; 2]| {
        let (mut sum, mut all) = (0.0, 0.0);
        for i in -50 * width..50 * width {
            for j in -50 * height..50 * height {
                let [x, y] = [i, j].map(|k| (k as f64 + 0.5) / 100.0);
                let value = cubic(x.hypot(y));
                all += value;
                sum += if x > edge { value } else { 0.0 };
            }
        }
        (sum / all) as f32
    };
    for widths in [[4, 4], [2, 2], [3, 4]] {
        let [width, height] = widths;
        let options = format!(
            "Format 32 32 1 PixelSamples 32 32 PixelFilter \"catmull-rom\" {width} {height} Projection \"orthographic\" Translate 0 0 5"
        );
        let p = render(&options, "Surface \"constant\" Polygon \"P\" [0 -2 0 4 -2 0 4 2 0 0 2 0]");
        for x in 12..20 {
            let expected = beyond(15.5 - x as f64, widths);
            let found = p.at(x, 16)[0];
            assert!((found - expected).abs() < 4e-3, "{widths:?}, column {x}: {found}, expected {expected}");
        }
    }
}

#[test]
fn a_plane_that_reaches_far_behind_the_eye_is_split_in_depth() {
    // Halves of 5,000 units before and behind the eye meet in its plane, where rounding leaves them as near to it as they like.
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    for (k, net) in
        ["-5000 0 -5000 5000 0 -5000 -5000 0 5000 5000 0 5000", "-5000 0 -5000 -5000 0 5000 5000 0 -5000 5000 0 5000"]
            .into_iter()
            .enumerate()
    {
        let scene = format!(
            "Display \"t{k}.png\" \"file\" \"rgb\" Format 64 48 1 Projection \"perspective\" \"fov\" [60] Translate 0 -1.5 0
            WorldBegin Surface \"constant\" Patch \"bilinear\" \"P\" [{net}] WorldEnd"
        );
        std::fs::write(at("t.rib"), scene).unwrap();
        scree(&["render", &at("t.rib"), "--stats", "-o", &at("")]).ok();
        let stats = std::fs::read(at(&format!("t{k}.png.stats.json"))).unwrap();
        let stats: serde_json::Value = serde_json::from_slice(&stats).unwrap();
        let splits = stats["stats"]["splits"].as_u64().unwrap();
        assert!(splits > 10 && splits < 20_000, "{splits} splits");
        // Below the horizon all is plane.
        let image = image::open(at(&format!("t{k}.png"))).unwrap().to_rgb8();
        assert!((0..64).all(|x| image.get_pixel(x, 27).0 == [255; 3] && image.get_pixel(x, 20).0 == [0; 3]));
    }
}

#[test]
fn a_crop_window_is_cut_from_the_whole_image() {
    let world = "Surface \"constant\" Color 1 .5 .25 Sphere .9 -.9 .9 360";
    let whole = render(ORTHO, world);
    // 80 pixels: 0.21 and 0.6 start at pixels 17 and 48, 0.5 and 0.99 at 40 and 80.
    let part = render(&format!("{ORTHO} CropWindow 0.21 0.6 0.5 0.99"), world);
    assert_eq!((part.width, part.pixels.len()), (31, 31 * 40));
    for y in 0..40 {
        (0..31).for_each(|x| assert_eq!(part.at(x, y), whole.at(x + 17, y + 40)));
    }
}

#[test]
fn half_transparent_layers_multiply() {
    let square = |z: f32| format!("Polygon \"P\" [-2 -2 {z} 2 -2 {z} 2 2 {z} -2 2 {z}]");
    let world = format!(
        "Surface \"constant\" Opacity .25 .25 .25 Color 0 1 0 {} Opacity .5 .5 .5 Color 1 0 0 {} Opacity 1 1 1 Color 0 0 1 {}",
        square(1.0),
        square(0.0),
        square(2.0)
    );
    let p = render(ORTHO, &world);
    // Red at ½ before green at ¼ before blue: ½, ½·¼, ½·¾.
    for (value, expected) in p.at(40, 40).iter().zip([0.5, 0.125, 0.375, 1.0]) {
        assert!((value - expected).abs() < 1e-4, "{:?}", p.at(40, 40));
    }
}

#[test]
fn a_camera_inside_displaced_things_comes_to_an_end() {
    let p = render(
        "Format 64 48 1 PixelSamples 2 2 Projection \"perspective\" \"fov\" 60",
        "Surface \"constant\" Sphere 2 -2 2 360
         Displacement \"rock\" \"uniform float Km\" 0.2 \"uniform float size\" 0.5 Attribute \"displacementbound\" \"sphere\" 0.2
         TransformBegin Translate 0 0 1.2 Sphere 0.5 -0.5 0.5 360 TransformEnd
         TransformBegin Translate 0.1 0 0.1 Sphere 0.3 -0.1 0.3 200 TransformEnd
         Patch \"bilinear\" \"P\" [-9 -.1 -9 9 -.1 -9 -9 -.1 9 9 -.1 9]",
    );
    // The ball of radius 2 is all around: no pixel is open.
    assert!(p.pixels.iter().all(|p| p[3] > 0.999));
}

#[test]
fn given_normals_are_shaded_with() {
    let square = "Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]";
    let world = format!(
        "LightSource \"distantlight\" 1 \"to\" [0 0 1] Surface \"matte\" \"Ka\" 0 \"Kd\" 1 {square} \"N\" [1 0 1 -1 0 1 -1 0 1 1 0 1]"
    );
    let p = render(ORTHO, &world);
    for x in [2, 20, 40, 70] {
        // The normal is (−x, 0, 1) across the image, on the side of the polygon's own, and is turned to the eye with it.
        let nx = (x as f32 + 0.5) / 40.0 - 1.0;
        let expected = 1.0 / (1.0 + nx * nx).sqrt();
        assert!((p.at(x, 40)[0] - expected).abs() < 0.01, "{x}: {}, expected {expected}", p.at(x, 40)[0]);
    }
}

#[test]
fn a_one_sided_polygon_is_seen_from_its_outside_only() {
    let square = "Polygon \"P\" [-.5 -.5 0 .5 -.5 0 .5 .5 0 -.5 .5 0]";
    let seen =
        |attributes: &str| render(ORTHO, &format!("Surface \"constant\" {attributes} {square}")).coverage() / 1600.0;
    assert!((seen("Sides 2") - 1.0).abs() < 0.01);
    let (outside, inside) = (seen("Sides 1"), seen("Sides 1 ReverseOrientation"));
    assert!((outside + inside - 1.0).abs() < 0.01 && (outside - inside).abs() > 0.9, "{outside} {inside}");
    // Of a ball from outside, both ways of drawing show the same.
    let ball =
        |sides: i32| render(ORTHO, &format!("Surface \"constant\" Sides {sides} Sphere .5 -.5 .5 360")).coverage();
    assert!((ball(1) - ball(2)).abs() < 0.03 * ball(2));
}

#[test]
fn a_sphere_casts_its_shadow_the_right_way() {
    // Light travels along +x +z: the shadow of a ball before a wall lies to the right of it.
    let p = render(
        ORTHO,
        "LightSource \"distantlight\" 1 \"to\" [1 0 1] Surface \"matte\" \"Ka\" 0
         Polygon \"P\" [-2 -2 1 2 -2 1 2 2 1 -2 2 1] TransformBegin Translate -.5 0 0 Sphere .2 -.2 .2 360 TransformEnd",
    );
    let lit = 0.5f32.sqrt();
    // The ball's centre at x −0.5, z 0 falls on the wall z = 1 at x 0.5: pixel 60.
    assert!(p.at(60, 40)[0] < 1e-3, "{:?}", p.at(60, 40));
    assert!((p.at(40, 40)[0] - lit).abs() < 1e-3 && (p.at(60, 10)[0] - lit).abs() < 1e-3);
    // The shadow is a circle in the light's cross-section, stretched by 1/cos 45° on the wall.
    let dark = (0..80).filter(|x| p.at(*x, 40)[0] < 0.3 * lit && p.at(*x, 40)[3] > 0.99 && *x > 45).count() as f32;
    assert!((dark - 0.4 * 40.0 * 2f32.sqrt()).abs() < 2.0, "{dark} pixels");
}

#[test]
fn every_library_surface_draws_spheres_of_all_sizes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/surface");
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().path().file_stem().unwrap().to_string_lossy().to_string();
        let mut world = format!(
            "LightSource \"distantlight\" 1 \"to\" [1 -1 2] LightSource \"pointlight\" 2 \"from\" [0 0 -4] LightSource \"ambientlight\" 3 \"intensity\" .2
             Color .8 .5 .3 Surface \"{name}\" "
        );
        for (i, radius) in [0.02, 0.05, 0.1, 0.2, 0.3, 0.03, 0.15].into_iter().enumerate() {
            let (x, y) = (i as f32 * 0.27 - 0.8, (i % 3) as f32 * 0.5 - 0.5);
            world +=
                &format!("TransformBegin Translate {x} {y} 0 Sphere {radius} -{radius} {radius} 360 TransformEnd ");
        }
        let p = render(ORTHO, &world);
        let bright = p.pixels.iter().flat_map(|p| &p[..3]).fold(0.0f32, |a, x| a.max(*x));
        assert!(bright > 0.1 && p.pixels.iter().flatten().all(|x| x.is_finite()), "{name}: {bright}");
    }
}

#[test]
fn perspective_puts_points_where_they_belong() {
    // fov 90°, image 80×80: a ball at (1, 0.5, 2) shows at x/z = 0.5, y/z = 0.25.
    let p = render(
        "Format 80 80 1 PixelSamples 4 4 PixelFilter \"box\" 1 1 Projection \"perspective\" \"fov\" 90",
        "Surface \"constant\" Translate 1 .5 2 Sphere .08 -.08 .08 360",
    );
    let total = p.coverage();
    let mean = |f: &dyn Fn(usize) -> f32| (0..6400).map(|k| f(k) * p.pixels[k][3]).sum::<f32>() / total;
    assert!((mean(&|k| (k % 80) as f32 + 0.5) - 60.0).abs() < 0.15);
    assert!((mean(&|k| (k / 80) as f32 + 0.5) - 30.0).abs() < 0.15);
}

#[test]
fn no_background_shows_between_grids() {
    // Everything is inside a displaced ball, and in front of it a sheet of curved patches that share edges.
    let mut world = String::from(
        "Surface \"constant\" Displacement \"rock\" \"uniform float Km\" [.08] \"uniform float size\" [.3] Attribute \"displacementbound\" \"sphere\" [.08] Sphere 1.6 -1.6 1.6 360 ",
    );
    let height = |x: f32, y: f32| (7.0 * x).sin() * (5.0 * y).cos() * 0.2;
    for j in 0..4 {
        for i in 0..4 {
            let mut p = String::new();
            for b in 0..4 {
                for a in 0..4 {
                    let (x, y) = ((3 * i + a) as f32 / 5.0 - 1.2, (3 * j + b) as f32 / 5.0 - 1.2);
                    p += &format!("{x} {y} {} ", -2.5 + height(x, y));
                }
            }
            world += &format!("Patch \"bicubic\" \"P\" [{p}] ");
        }
    }
    for (rate, view) in
        [(1.0, "Translate 0 0 5"), (0.3, "Translate .1 0 5 Rotate 20 1 .3 0"), (4.0, "Translate 0 0 0.2")]
    {
        let camera = "Projection \"perspective\" \"fov\" 14";
        let p = render(
            &format!("Format 96 96 1 PixelSamples 8 8 PixelFilter \"box\" 1 1 {camera} {view}"),
            &format!("ShadingRate {rate} {world}"),
        );
        let open = p.pixels.iter().filter(|p| p[3] < 1.0).count();
        assert_eq!(open, 0, "{view}: background shows in {open} pixels");
    }
}

#[test]
fn no_background_shows_where_patches_are_split_unevenly() {
    // Smooth meshes of bicubic patches at random, seen in sharp perspective: neighbours are split to different depths.
    let n = 10;
    for seed in 0..4u32 {
        let noise = |k: usize| {
            let h = (k as u32 + 977 * seed).wrapping_mul(0x9e37_79b9);
            ((h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d) >> 8) as f32 / (1 << 24) as f32
        };
        let mut p: Vec<[f32; 3]> = (0..n * n)
            .map(|k| [(k % n) as f32 * 0.49 - 2.2, (k / n) as f32 * 0.49 - 2.2, 1.8 * noise(k) - 0.9])
            .collect();
        // Points that patches share lie in the middle of those beside them, so that the mesh has no edges.
        for (step, line) in [(1, n), (n, 1)] {
            for (at, along) in [3, 6].into_iter().flat_map(|at| (0..n).map(move |along| (at, along))) {
                let k = at * step + along * line;
                p[k] = [0, 1, 2].map(|c| 0.5 * (p[k - step][c] + p[k + step][c]));
            }
        }
        let points: String = p.iter().flatten().map(|x| format!("{x} ")).collect();
        let mesh = format!(
            "Basis \"bezier\" 3 \"bezier\" 3 PatchMesh \"bicubic\" {n} \"nonperiodic\" {n} \"nonperiodic\" \"P\" [{points}]"
        );
        let rock = "Displacement \"rock\" \"uniform float Km\" 0.12 \"uniform float size\" 0.3 Attribute \"displacementbound\" \"sphere\" 0.3";
        for displacement in ["", rock] {
            let p = render(
                &format!(
                    "Format 160 100 1 PixelSamples 8 8 PixelFilter \"box\" 1 1 Projection \"perspective\" \"fov\" 40 Translate 0 0 2.6 Rotate {} 1 0 0 Rotate {} 0 0 1",
                    25 + 9 * seed,
                    20 * seed
                ),
                &format!("Surface \"constant\" {displacement} {mesh}"),
            );
            // A pixel that is open in part though all about it is covered.
            let at = |x: usize, y: usize| p.pixels[y * 160 + x][3];
            let leaks = |x: usize, y: usize| {
                let about = (y - 4..=y + 4).flat_map(|v| (x - 4..=x + 4).map(move |u| (u, v)));
                at(x, y) < 1.0 && about.filter(|(u, v)| at(*u, *v) == 1.0).count() > 70
            };
            let found = (4..96).flat_map(|y| (4..156).map(move |x| (x, y))).filter(|(x, y)| leaks(*x, *y)).count();
            assert_eq!(found, 0, "mesh {seed} {displacement}");
        }
    }
}

/// What renders the golden image of the poured stones.
const POUR: &str =
    "scree simulate sim/models/pour.yaml --until 0.5 -o run && scree render run -f 11 --res 128x96 --samples 4 -o out";

/// The run of the poured stones up to its frame 11, as CSV.
fn pour(folder: &Path) -> String {
    let run = folder.join("run");
    scree(&["simulate", "sim/models/pour.yaml", "--until", "0.5", "--csv", "-o", run.to_str().unwrap()]).ok();
    run.to_str().unwrap().into()
}

/// Render frames at the golden image's size.
fn small(data: &str, frames: &str, out: &Path) {
    scree(&["render", data, "-f", frames, "--res", "128x96", "--samples", "4", "-o", out.to_str().unwrap()]).ok();
}

#[test]
fn the_golden_image_is_as_it_was() {
    let work = scratch();
    let out = work.path().join("o");
    small(&pour(work.path()), "11", &out);
    let now = image::open(out.join("000011.png")).unwrap().to_rgb8();
    golden::hold("pour_000011", &now, golden::STEADY, POUR).unwrap_or_else(|e| panic!("{e}"));
}

/// A stone of a table: its line, its columns, place and radius.
struct Stone {
    line: usize,
    cells: Vec<String>,
    at: DVec3,
    radius: f64,
}

/// How many pixels of the golden image show each stone, by rays through their middles.
fn seen(stones: &[Stone]) -> Vec<usize> {
    let (eye, look_at) = (DVec3::new(-1.41, -3.12, 2.142), DVec3::new(-0.006267, -0.0004572, 0.5828));
    let ahead = (look_at - eye).normalize();
    let right = ahead.cross(DVec3::Z).normalize();
    let up = right.cross(ahead);
    let half = 17.5f64.to_radians().tan();
    let mut n = vec![0; stones.len()];
    for (x, y) in (0..96).flat_map(|y| (0..128).map(move |x| (x as f64 + 0.5, y as f64 + 0.5))) {
        let way = (ahead + right * half * (x - 64.0) / 48.0 + up * half * (48.0 - y) / 48.0).normalize();
        let met = stones.iter().enumerate().filter_map(|(i, stone)| {
            let from = eye - stone.at;
            let along = from.dot(way);
            let inside = along * along - from.length_squared() + stone.radius * stone.radius;
            (inside > 0.0).then(|| (-along - inside.sqrt(), i))
        });
        if let Some((_, i)) = met.min_by(|a, b| a.0.total_cmp(&b.0)) {
            n[i] += 1;
        }
    }
    n
}

#[test]
fn the_golden_image_misses_a_stone_that_moves_or_vanishes() {
    let work = scratch();
    let run = pour(work.path());
    let table = std::fs::read_to_string(format!("{run}/frames/000011.csv")).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    let column = |name: &str| lines[0].split(',').position(|head| head.split(' ').next() == Some(name)).unwrap();
    let [x, y, z, size] = ["pos_x", "pos_y", "pos_z", "half_x"].map(column);
    let rows = lines.iter().enumerate().filter(|(_, line)| line.contains(",stones,"));
    let stones: Vec<Stone> = rows
        .map(|(line, row)| {
            let cells: Vec<String> = row.split(',').map(String::from).collect();
            let number = |c: usize| cells[c].parse::<f64>().unwrap();
            let (at, radius) = (DVec3::new(number(x), number(y), number(z)), number(size));
            Stone { line, cells, at, radius }
        })
        .collect();
    // The table as it is, then with one of some stones gone or moved by its radius.
    let plain = seen(&stones).into_iter().zip(&stones).filter(|(n, _)| *n >= 5).map(|(_, stone)| stone);
    let some: Vec<&Stone> = plain.step_by(19).collect();
    assert!(some.len() >= 6, "{} stones", some.len());
    let changed = some.iter().flat_map(|stone| {
        let mut moved = stone.cells.clone();
        moved[x] = (stone.at.x + stone.radius).to_string();
        [None, Some(moved.join(","))].map(|row| (stone.line, row))
    });
    let changed: Vec<(usize, Option<String>)> = changed.collect();
    for (frame, change) in std::iter::once(None).chain(changed.iter().map(Some)).enumerate() {
        let mut lines: Vec<&str> = lines.clone();
        match change {
            Some((line, Some(row))) => lines[*line] = row,
            Some((line, None)) => drop(lines.remove(*line)),
            None => {}
        }
        std::fs::write(work.path().join(format!("p_{frame:06}.csv")), lines.join("\n") + "\n").unwrap();
    }
    let metadata = std::fs::read_to_string(format!("{run}/metadata.yaml")).unwrap();
    let own = work.path().join("m.yaml");
    // The levels of the film of the golden image.
    let metadata = metadata.replacen("output:\n", "output:\n  levels: [0.17, 0.78]\n", 1);
    std::fs::write(&own, metadata.replacen("  run: .", "  csv: p_*.csv", 1)).unwrap();
    let out = work.path().join("o");
    small(own.to_str().unwrap(), &format!("0-{}", changed.len()), &out);
    let at = |frame: usize| image::open(out.join(format!("{frame:06}.png"))).unwrap().to_rgb8();
    let whole = at(0);
    golden::hold("pour_000011", &whole, golden::STEADY, POUR).unwrap_or_else(|e| panic!("{e}"));
    let errors = (1..=changed.len()).map(|frame| golden::worst_block(&at(frame), &whole).error);
    let errors: Vec<f64> = errors.collect();
    for (error, (line, row)) in errors.iter().zip(&changed) {
        let how = row.as_deref().unwrap_or("gone");
        assert!(*error > golden::STEADY, "nobody would see that the stone of line {line} is {how}: {error}");
    }
}
