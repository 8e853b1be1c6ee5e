//! Overlays of images: each over every camera at three sizes, what they say, the layer of an EXR, shards, and what is refused.

use crate::cli::{scratch, scree};
use image::RgbImage;
use std::path::Path;

/// All overlays, each in a corner of its own as it is by default.
const ALL: [&str; 6] = [
    "title: Stones that fall",
    "time: {per_frame: 0.25}",
    "scale_bar: true",
    "legend: {label: speed, unit: m/s}",
    "axes: true",
    "plot: {columns: [load], file: probes.csv}",
];

const CAMERAS: [&str; 3] = [
    "{eye: [1, -3, 1.4], look_at: [0.2, 0, 0.25]}",
    "{view: side, orthographic: 1.5, look_at: [0, 0, 0.4]}",
    "{eye: [0, -2, 1], look_at: [0, 0, 0], follow: id == 2, orbit: 30, fov: 50}",
];

/// The other kinds, of which some move.
const OTHERS: [&str; 4] = [
    "{view: top, orthographic: 2, look_at: [0, 0, 0]}",
    "{view: front, orthographic: 1.5, look_at: [0, 0, 0.4]}",
    "{eye: [1, -3, 1.4], look_at: [0.2, 0, 0.25], turns: 1, stereo: 0.065, lens: {f_stop: 2.8, focal_length: 0.05}}",
    "{eye: [1, -3, 0.3], look_at: [0, 0, 0.3], keys: [{frame: 0}, {frame: 1, eye: [2, -2, 0.3], fov: 24}]}",
];

/// Two frames of stones, a table over time, and metadata with overlays.
fn metadata(folder: &Path, camera: &str, overlays: &[&str], output: &str) -> String {
    for frame in 0..2 {
        let rows = format!("id,pos_x,pos_y,pos_z,r,v\n1,0,0,0.3,0.3,1\n2,0.{frame}5,0.1,0.3,0.3,2\n");
        std::fs::write(folder.join(format!("s_{frame}.csv")), rows).unwrap();
    }
    std::fs::write(folder.join("probes.csv"), "time [s],load [N],lift [m]\n0,0,1\n0.1,3,1\n0.25,2,1\n0.5,5,1\n")
        .unwrap();
    let block = if overlays.is_empty() { String::new() } else { format!("overlays:\n  {}\n", overlays.join("\n  ")) };
    let text = format!(
        "data: {{files: 's_*.csv'}}\ncamera: {camera}\nobjects:
  - {{name: stones, geometry: {{sphere: {{radius: r}}}}, color: {{column: v, range: [0, 4]}}}}\n{block}output: {{quality: draft{output}}}\n"
    );
    let path = folder.join("m.yaml");
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().into()
}

/// The image of a frame.
fn draw(camera: &str, overlays: &[&str], size: [u32; 2], frame: u32) -> RgbImage {
    let work = scratch();
    let (file, out) = (metadata(work.path(), camera, overlays, ""), work.path().join("o"));
    let [res, frame_list] = [format!("{}x{}", size[0], size[1]), frame.to_string()];
    scree(&["render", &file, "-o", out.to_str().unwrap(), "--res", &res, "-f", &frame_list]).ok();
    image::open(out.join(format!("{frame:06}.png"))).unwrap().to_rgb8()
}

/// The boxes of what differs between two images: left, top, right, bottom of each connected region.
fn regions(a: &RgbImage, b: &RgbImage) -> Vec<[u32; 4]> {
    let (w, h) = a.dimensions();
    let mut open: Vec<bool> = a.pixels().zip(b.pixels()).map(|(p, q)| p != q).collect();
    let mut boxes = vec![];
    for start in 0..open.len() {
        let mut stack = if open[start] { vec![start] } else { continue };
        let mut found = [w, h, 0, 0];
        open[start] = false;
        while let Some(k) = stack.pop() {
            let [x, y] = [k as u32 % w, k as u32 / w];
            found = [found[0].min(x), found[1].min(y), found[2].max(x), found[3].max(y)];
            let near = [
                (x > 0, k.wrapping_sub(1)),
                (x + 1 < w, k + 1),
                (y > 0, k.wrapping_sub(w as usize)),
                (y + 1 < h, k + w as usize),
            ];
            for (_, next) in near.into_iter().filter(|(is_inside, _)| *is_inside) {
                if std::mem::take(&mut open[next]) {
                    stack.push(next);
                }
            }
        }
        boxes.push(found);
    }
    boxes
}

/// An overlay's box is in the image with room around, and has pale ink on a dark panel, both enough to be read.
fn assert_legible(image: &RgbImage, [x0, y0, x1, y1]: [u32; 4], what: &str) {
    let (w, h) = image.dimensions();
    assert!(x0 > 4 && y0 > 4 && x1 + 5 < w && y1 + 5 < h, "{what} leaves the image: {x0} {y0} {x1} {y1}");
    assert!(y1 - y0 >= 20.max(h / 30), "{what} is {} pixels high of {h}", y1 - y0);
    let light = |x, y| image.get_pixel(x, y).0.iter().map(|c| *c as u32).sum::<u32>() / 3;
    // The axes are coloured: of ink some channel is bright.
    let brightest = |x, y| image.get_pixel(x, y).0.into_iter().max().unwrap() as u32;
    let all: Vec<(u32, u32)> = (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| (x, y))).collect();
    let share =
        |is: &dyn Fn(u32, u32) -> bool| all.iter().filter(|(x, y)| is(*x, *y)).count() as f64 / all.len() as f64;
    let (ink, panel) = (share(&|x, y| brightest(x, y) > 140), share(&|x, y| light(x, y) < 115));
    assert!(ink > 0.012 && panel > 0.4, "{what} at {w}×{h}: {ink} is ink, {panel} is panel");
}

#[test]
fn all_overlays_have_room_over_every_camera_at_three_sizes() {
    for camera in CAMERAS.into_iter().chain(OTHERS) {
        for size in [[640, 360], [1280, 720], [3840, 2160]] {
            let (with, without) = (draw(camera, &ALL, size, 1), draw(camera, &[], size, 1));
            let found = regions(&with, &without);
            assert_eq!(found.len(), 6, "{size:?} {camera}: apart from each other: {found:?}");
            for part in found {
                assert_legible(&with, part, camera);
            }
        }
    }
}

#[test]
fn each_overlay_is_drawn_in_its_corner_and_nowhere_else() {
    let corners = [[0, 0], [1, 0], [0, 1], [1, 0], [0, 1], [1, 1]];
    for camera in CAMERAS {
        let without = draw(camera, &[], [640, 360], 1);
        for (overlay, corner) in ALL.into_iter().zip(corners) {
            let with = draw(camera, &[overlay], [640, 360], 1);
            let found = regions(&with, &without);
            assert_eq!(found.len(), 1, "{overlay}: {found:?}");
            let [x0, y0, x1, y1] = found[0];
            let middle = [(x0 + x1) / 2 / 320, (y0 + y1) / 2 / 180];
            assert_eq!(middle, corner, "{overlay} {camera}: {found:?}");
            assert_legible(&with, found[0], overlay);
        }
    }
    let moved = draw(CAMERAS[0], &["title: {text: Moved, corner: bottom-right}"], [640, 360], 1);
    let found = regions(&moved, &draw(CAMERAS[0], &[], [640, 360], 1));
    assert!(found[0][0] > 320 && found[0][1] > 180, "{found:?}");
}

#[test]
fn a_scale_bar_is_as_long_as_it_says() {
    // Across the shorter side, 360 pixels, are 1.5 m: 0.25 m more are 60 pixels more, whatever the ends of the bar look like.
    let longest = |length: &str| {
        let overlays = [format!("scale_bar: {{length: {length}}}"), "panel: light".into()];
        let with = draw(CAMERAS[1], &overlays.each_ref().map(|s| s.as_str()), [640, 360], 0);
        let dark = |x, y| with.get_pixel(x, y).0.iter().all(|c| *c < 90);
        (200..360).map(|y| (0..200).filter(|x| dark(*x, y)).count()).max().unwrap()
    };
    let (short, long) = (longest("0.25"), longest("0.5"));
    assert!((60..68).contains(&short) && (59..=61).contains(&(long - short)), "{short} and {long} pixels");
}

#[test]
fn time_and_curve_go_on_with_the_frames() {
    let camera = CAMERAS[1];
    let [first, second] = [0, 1].map(|frame| draw(camera, &["time: {per_frame: 0.25}"], [640, 360], frame));
    let bare = [0, 1].map(|frame| draw(camera, &[], [640, 360], frame));
    let [a, b] = [regions(&first, &bare[0])[0], regions(&second, &bare[1])[0]];
    assert_eq!(a, b, "the time stays where it is");
    assert!((a[0]..a[2]).any(|x| (a[1]..a[3]).any(|y| first.get_pixel(x, y) != second.get_pixel(x, y))));
    let curve = |frame| {
        let image = draw(camera, &ALL[5..], [640, 360], frame);
        let of = |overlay: &[&str]| {
            let image = draw(camera, &[&ALL[5..], overlay].concat(), [640, 360], frame);
            image.enumerate_pixels().filter(|(x, y, p)| *x > 320 && *y > 180 && p[2] as i32 - p[0] as i32 > 90).count()
        };
        (image.dimensions(), of(&[]), of(&["time: {per_frame: 0.25}"]))
    };
    let (start, late) = (curve(0), curve(1));
    assert!(late.2 > start.2 + 40, "the curve grows with the time of the frames: {start:?}, {late:?}");
}

#[test]
fn an_exr_has_overlays_in_a_layer_and_its_data_as_it_was() {
    let read = |overlays: &[&str]| {
        let work = scratch();
        let file = metadata(work.path(), CAMERAS[0], overlays, ", format: exr, resolution: [320, 180]");
        let out = work.path().join("o");
        scree(&["render", &file, "-o", out.to_str().unwrap(), "-f", "1"]).ok();
        let image = exr::prelude::read_first_flat_layer_from_file(out.join("000001.exr")).unwrap();
        let channels = image.layer_data.channel_data.list;
        channels
            .into_iter()
            .map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect::<Vec<_>>()))
            .collect::<Vec<_>>()
    };
    let (with, without) = (read(&ALL), read(&[]));
    let names: Vec<&str> = with.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["B", "G", "R", "overlay.A", "overlay.B", "overlay.G", "overlay.R"]);
    for (name, values) in &without {
        assert!(with.iter().any(|(n, v)| n == name && v == values), "{name} is data");
    }
    let cover = &with[3].1;
    let covered = cover.iter().filter(|a| **a > 0.3).count() as f64 / cover.len() as f64;
    assert!(covered > 0.1 && covered < 0.6 && cover.contains(&0.0), "{covered}");
}

#[test]
fn shards_have_their_parts_and_changes_are_drawn_again() {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let file = metadata(work.path(), CAMERAS[0], &ALL, "");
    let render = |out: &str, more: &[&str]| {
        let args = ["render", &file, "-o", out, "-f", "1", "--res", "320x180"];
        scree(&[&args[..], more].concat()).ok()
    };
    render(&at("whole"), &[]);
    for part in ["1/2", "2/2"] {
        render(&at("parts"), &["--bucket", part]);
    }
    scree(&["stitch", &at("parts")]).ok();
    let bytes = |folder: &str| std::fs::read(work.path().join(folder).join("000001.png")).unwrap();
    let before = bytes("whole");
    assert!(bytes("parts") == before, "stitched shards are the whole image");
    metadata(work.path(), CAMERAS[0], &[&["title: Another title"], &ALL[1..]].concat(), "");
    render(&at("whole"), &[]);
    assert!(bytes("whole") != before, "another title makes the image stale");
}

#[test]
fn what_is_wrong_is_refused_at_its_place() {
    let cases: [(&str, &[&str]); 16] = [
        ("tiem: true", &["tiem", "`time`", "m.yaml:6:3"]),
        ("time: {uint: s}", &["uint", "`unit`", "m.yaml:6"]),
        ("time: 3", &["true, false or a map", "m.yaml:6"]),
        ("time: {unit: sec}", &["unit of time `sec`", "µ", "m.yaml:6"]),
        ("time: true", &["no times", "per_frame", "m.yaml:6"]),
        ("time: {per_frame: -1}", &["per_frame", "more than 0"]),
        ("title: ''", &["is empty"]),
        ("title: true", &["a text or a map"]),
        ("title: 漢字", &["the fonts have no `漢`", "m.yaml:6"]),
        ("scale_bar: {length: 40}", &["40 m", "pixels", "m.yaml:6"]),
        ("scale_bar: {corner: top}", &["top", "top-left", "m.yaml:6"]),
        ("legend: {object: stone}", &["`stone`", "stones", "m.yaml:6"]),
        ("plot: load", &["needs `file`", "m.yaml:6"]),
        ("plot: {columns: [laod], file: probes.csv}", &["laod", "did you mean `load`", "m.yaml:6"]),
        ("plot: {columns: [load, lift], file: probes.csv}", &["[m]", "[N]", "m.yaml:6"]),
        ("size: 90", &["0.3 to 4", "m.yaml:6"]),
    ];
    for (overlay, expected) in cases {
        let work = scratch();
        let file = metadata(work.path(), CAMERAS[0], &[overlay], "");
        let out = work.path().join("o");
        let drawn = scree(&["render", &file, "-o", out.to_str().unwrap(), "--res", "64x36"]).fails(3);
        // Before a film is drawn, `check` says the same.
        for said in [drawn, scree(&["check", &file]).fails(3)] {
            for part in expected.iter().filter(|part| **part != "µ") {
                assert!(said.contains(part), "{overlay}: `{part}` is missing in {said}");
            }
        }
    }
}
