//! Metadata files: object space is in metres for every geometry, and what a file asks for in vain is told with its place.

use crate::cli::{scratch, scree};
use std::path::{Path, PathBuf};

/// A scene that shows the objects alone.
const SCENE: &str = "#scree override Format\n#scree override Display\n#scree override PixelSamples\n#scree override PixelFilter\nExposure 1 1\n\
     #scree inject camera\nWorldBegin\n#scree override ShadingRate\n#scree inject objects\nWorldEnd\n";

/// Places in object space as colours.
const TELL: &str = "surface tell() { point q = transform(\"object\", P); Oi = 1; Ci = color(0.5, 0.5, 0.5) + 0.4 * color(xcomp(q), ycomp(q), zcomp(q)); }\n";

/// Write a file into a folder.
fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().into()
}

/// Metadata of a body at (1, 2, 0), seen from above, 2 m across; its rows have a size of their own.
fn seen_from_above(folder: &Path, geometry: &str, more: &str) -> String {
    write(folder, "plain.rib", SCENE);
    write(folder, "tell.sl", TELL);
    write(folder, "tile.obj", "v -10 -20 0\nv 10 -20 0\nv 10 20 0\nv -10 20 0\nf 1 2 3 4\n");
    write(folder, "b_0.csv", "pos_x,pos_y,pos_z,size\n1,2,0,0.3\n1,2,-5,0.1\n");
    let head = "data: {csv: b_0.csv}\nscene: plain.rib\ncamera: {view: top, orthographic: 2, look_at: [1, 2, 0]}";
    let object = format!("  - {{name: body, geometry: {geometry}, surface: {{name: tell}}{more}}}");
    let output = "output: {resolution: [40, 40], format: exr, filter: {name: box, width: 1}, shading_rate: 0.25}";
    write(folder, "m.yaml", &format!("{head}\nobjects:\n{object}\n{output}\n"))
}

/// The pixels of an image of 40 by 40, which is 2 m across: where each is, from the middle, and its colour.
fn pixels(image: &Path) -> Vec<([f32; 2], [f32; 4])> {
    let image = image::open(image).unwrap().to_rgba32f();
    let place = |k: u32| (k as f32 + 0.5) / 20.0 - 1.0;
    image.enumerate_pixels().map(|(x, y, p)| ([place(x), -place(y)], p.0)).collect()
}

/// Render a metadata file.
fn drawn(file: &str, folder: &Path) -> PathBuf {
    scree(&["render", file, "-o", folder.to_str().unwrap(), "--backend", "cpu"]).ok();
    folder.join("000000.exr")
}

#[test]
fn object_space_is_in_metres_for_every_geometry() {
    let along_x = ", orientation: [0.70710678, 0, 0.70710678, 0]";
    for (geometry, more) in [
        ("{sphere: {radius: size}}", ""),
        ("{ellipsoid: {half: [2 * size, size, 0.2]}}", ""),
        ("{box: {half: [2 * size, size, 0.2]}}", ""),
        ("{cylinder: {radius: size, half: 0.2}}", ""),
        ("{cone: {radius: size, half: 0.2}}", ""),
        ("{plane: {half: size}}", ""),
        ("{archive: {file: tile.obj, scale: size / 15}}", ""),
        ("{capsule: {radius: size, half: 0.5}}", along_x),
        ("{cylinder: {radius: size, half: 2 * size}}", along_x),
    ] {
        let work = scratch();
        let file = seen_from_above(work.path(), geometry, more);
        let image = drawn(&file, &work.path().join("o"));
        let found = pixels(&image);
        let body: Vec<_> = found.iter().filter(|(_, c)| c[0] + c[1] + c[2] != 0.0).collect();
        assert!(body.len() > 60, "{geometry}: {} pixels", body.len());
        for ([x, y], [r, g, b, _]) in &body {
            // Turned about y, the body's own z is along x.
            let along = (if more.is_empty() { r } else { b } - 0.5) / 0.4;
            let across = (g - 0.5) / 0.4;
            let is_inside = body.iter().filter(|([u, v], _)| (u - x).abs() + (v - y).abs() < 0.11).count() == 13;
            let off = (along - x).abs().max((across - y).abs());
            assert!(!is_inside || off < 0.02, "{geometry}: at ({x}, {y}) object space has ({along}, {across})");
        }
        // As RIB the frame is the same image.
        let rib = work.path().join("frame.rib");
        std::fs::write(&rib, scree(&["rib", &file, "-f", "0"]).ok()).unwrap();
        let out = work.path().join("r");
        scree(&["render", rib.to_str().unwrap(), "-o", out.to_str().unwrap(), "--backend", "cpu"]).ok();
        let again = &crate::cli::images(&out)[0];
        assert!(again.extension().is_some_and(|ending| ending == "exr"), "{again:?}");
        let again = pixels(again);
        let differ = found.iter().zip(&again).filter(|(a, b)| (0..3).any(|c| (a.1[c] - b.1[c]).abs() > 0.02)).count();
        assert!(differ < 8, "{geometry}: {differ} pixels of the RIB differ");
    }
}

#[test]
fn displacement_bounds_are_in_metres_for_every_geometry() {
    for geometry in ["sphere: {radius: 0.3}", "box: {half: [0.2, 0.3, 0.4]}", "capsule: {radius: 0.3, half: 0.2}"] {
        let work = scratch();
        write(work.path(), "swell.sl", "displacement swell() { P += 0.05 * normalize(N); N = calculatenormal(P); }\n");
        for (bound, is_said) in [(0.04, true), (0.051, false)] {
            let more = format!(", displacement: {{name: swell, bound: {bound}}}");
            let file = seen_from_above(work.path(), &format!("{{{geometry}}}"), &more);
            let out = work.path().join("o");
            let answer = scree(&["render", &file, "-o", out.to_str().unwrap(), "--backend", "cpu"]);
            answer.ok();
            let said = answer.errors();
            assert_eq!(said.contains("displacement: {bound: 0.050"), is_said, "{geometry}, {bound}: {said}");
            assert!(!is_said || said.contains("m.yaml:5:"), "{said}");
        }
    }
}

/// A file with a line in place of another of a good one; what is said of it, and whether it is an error.
struct Case {
    line: (&'static str, &'static str),
    says: &'static [&'static str],
    is_error: bool,
}

/// An error.
fn wrong(from: &'static str, to: &'static str, says: &'static [&'static str]) -> Case {
    Case { line: (from, to), says, is_error: true }
}

/// A warning.
fn warned(from: &'static str, to: &'static str, says: &'static [&'static str]) -> Case {
    Case { line: (from, to), says, is_error: false }
}

const GOOD: &str = "data:
  csv: 'p_*.csv'
  rename: {size: radius}
camera: {eye: [2, -3, 2], look_at: [0, 0, 0], lens: {f_stop: 2.8, focal_length: 0.05}}
objects:
  - {name: grains, geometry: {sphere: {radius: radius}}, color: [0.5, 0.4, 0.3]}
  - name: parts
    geometry: {box: {half: [0.1, 0.1, 0.1]}}
    surface: {name: plastic, Kd: 0.5}
output: {resolution: [16, 9], samples: [1, 1], quality: draft}
";

fn cases() -> Vec<Case> {
    vec![
        wrong(
            "0.05}}",
            "50}}",
            &["m.yaml:4:", "focal_length", "is 50 m, expected less than", "of a lens of 50 mm it is 0.05"],
        ),
        wrong("0.05}}", "0.05, focus: 0.04}}", &["m.yaml:4:", "focal_length", "0.04 m"]),
        wrong("{size: radius}", "{sise: radius}", &["m.yaml:3:12", "unknown column `sise`", "did you mean `size`?"]),
        wrong(
            "{size: radius}",
            "{size: radius}\n  select: kimd == 1",
            &["m.yaml:4:", "unknown column `kimd`", "did you mean `kind`?"],
        ),
        wrong(
            "{size: radius}",
            "{size: radius}\n  derive:\n    - {column: twice, formula: 2 * radiuss}",
            &["m.yaml:5:", "unknown column `radiuss`", "did you mean `radius`?"],
        ),
        wrong("name: parts", "name: grains", &["m.yaml:7:", "two objects are named `grains`"]),
        wrong(
            "[0.5, 0.4, 0.3]",
            "[200, 60, 20]",
            &["m.yaml:6:", "has 200, expected numbers from 0 to 1", "[0.586, 0.041, 0.004]"],
        ),
        wrong("Kd: 0.5", "Kd: [1, 2, 3]", &["m.yaml:9:", "`parts`", "Kd"]),
        wrong("{box: {half: [0.1, 0.1, 0.1]}}", "{archive: {file: blade.obj}}", &["m.yaml:8:", "`parts`", "blade.obj"]),
        wrong(
            "{box: {half: [0.1, 0.1, 0.1]}}",
            "{archive: {file: bad.obj}}",
            &["bad.obj:4:7", "out of bounds", "m.yaml:8:", "`parts`"],
        ),
        wrong("{box: {half: [0.1, 0.1, 0.1]}}", "{archive: {file: bad.rib}}", &["bad.rib:2:", "m.yaml:8:", "`parts`"]),
        wrong("{box: {half: [0.1, 0.1, 0.1]}}", "{trail: {length: 1}}", &["m.yaml:8:", "no times that ascend"]),
        wrong(
            "camera:",
            "scene: some.rib\ncamera:",
            &["m.yaml:8:", "does not take the object `parts`", "#scree inject objects parts"],
        ),
        warned("samples: [1, 1]", "shutter: 0.1", &["m.yaml:10:", "nothing moves", "vel_x, vel_y, vel_z"]),
        warned(
            "rename: {size: radius}",
            "rename: {size: radius, kind: quat_w}",
            &["m.yaml:6:", "without its orientation", "quat_x, quat_y, quat_z"],
        ),
        warned(
            "samples: [1, 1]",
            "format: exr, channels: [z, float foo]",
            &["nothing provides the channel `float foo`"],
        ),
        warned("samples: [1, 1]", "format: exr, channels: [z, color Cs]", &[]),
        warned(
            "name: parts",
            "name: parts\n    select: body == 9007199254740993",
            &["m.yaml:8:", "`body` has 9007199254740993", "round"],
        ),
    ]
}

#[test]
fn what_a_file_asks_for_in_vain_is_told_with_its_place() {
    for Case { line: (from, to), says, is_error } in cases() {
        let work = scratch();
        for k in 0..2 {
            write(
                work.path(),
                &format!("p_{k}.csv"),
                "pos_x,pos_y,pos_z,size,kind,body\n0,0,0,0.2,1,9007199254740993\n1,0,0,0.2,2,3\n",
            );
        }
        write(work.path(), "bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
        write(work.path(), "bad.rib", "# a part\nSphere 1 -1 one 360\n");
        write(work.path(), "some.rib", &SCENE.replace("inject objects", "inject objects grains"));
        assert!(GOOD.contains(from), "{from}");
        let file = write(work.path(), "m.yaml", &GOOD.replacen(from, to, 1));
        let out = work.path().join("o");
        let calls = [&["check", &file][..], &["render", &file, "-o", out.to_str().unwrap(), "--backend", "cpu"]];
        for call in calls {
            let answer = scree(call);
            let said = if is_error { answer.errors() } else { answer.ok() + &answer.errors() };
            assert!(!is_error || !answer.output.status.success(), "{to}: {said}");
            for part in says {
                assert!(said.contains(part), "{to}: {} does not say `{part}`: {said}", call[0]);
            }
            assert!(!says.is_empty() || !said.contains("warning"), "{to}: {said}");
        }
    }
}

#[test]
fn a_renamed_column_may_have_its_new_name_already() {
    let work = scratch();
    write(work.path(), "p_0.csv", "pos_x,pos_y,pos_z,size\n0,0,0,0.2\n");
    write(work.path(), "p_1.csv", "pos_x,pos_y,pos_z,radius\n0,0,0,0.2\n");
    // A table without rows may lack all columns.
    write(work.path(), "p_2.csv", "pos_x,pos_y,pos_z\n");
    let file = write(work.path(), "m.yaml", GOOD);
    scree(&["render", &file, "-o", work.path().join("o").to_str().unwrap(), "--backend", "cpu"]).ok();
}

#[test]
fn meshes_that_mix_kinds_of_corners_are_drawn() {
    let work = scratch();
    let mesh = "v -1 -1 -1\nv 1 -1 -1\nv 0 1 -1\nv 0 0 1\nvn 0 0 -1\nf 1//1 3//1 2//1\nf 1 2 4 # side\nf 2 \\\n 3 4\nf 3 1 4#c\n";
    write(work.path(), "part.obj", mesh);
    write(work.path(), "p_0.csv", "pos_x,pos_y,pos_z,size\n0,0,0,0.2\n");
    let file = write(
        work.path(),
        "m.yaml",
        &GOOD.replace("{box: {half: [0.1, 0.1, 0.1]}}", "{archive: {file: part.obj, scale: radius}}"),
    );
    scree(&["render", &file, "-o", work.path().join("o").to_str().unwrap(), "--backend", "cpu"]).ok();
}

#[test]
fn tables_that_say_two_things_are_told_of() {
    let work = scratch();
    let table = write(work.path(), "mm_0.csv", "x [mm],y [mm],z [mm]\n\"1,200\",200,500\n980,205,500\n");
    let said = scree(&["inspect", &table]).fails(4);
    assert!(said.contains("mm_0.csv:2:") && said.contains("`1,200`, which may be a thousand or more"), "{said}");
    write(work.path(), "lc_0.csv", "1,2,3,4\n5,6,7,8\n");
    let text = "data: {csv: lc_0.csv, least_cells: 9, columns: [x, y, z, a]}\ncamera: {eye: [2, -3, 2], look_at: [0, 0, 0]}\n\
         objects: [{name: g, position: [x, y, z], geometry: {sphere: {radius: 0.1}}}]\n";
    let said = scree(&["check", &write(work.path(), "m.yaml", text)]).fails(4);
    assert!(said.contains("at least 9 cells (`least_cells`), but 4 columns are named"), "{said}");
}
