//! Scenes and jobs of others: primitives against their areas, the library's scenes, the jobs of Chrono::Render.

use crate::cli::{images, scratch, scree};
use std::f64::consts::PI;
use std::path::Path;

/// The area, in square units, that a primitive covers in a parallel view along z of the square from −2 to 2.
fn covered(primitive: &str) -> f64 {
    let work = scratch();
    let scene = work.path().join("scene.rib");
    let rib = format!(
        "Format 128 128 1\nPixelSamples 4 4\nPixelFilter \"box\" 1 1\nDisplay \"a.png\" \"png\" \"rgb\"\nQuantize \"rgba\" 255 0 255 0
        Projection \"orthographic\"\nScreenWindow -2 2 -2 2\nTranslate 0 0 10\nWorldBegin\nSurface \"constant\"\nColor 1 1 1\n{primitive}\nWorldEnd\n"
    );
    std::fs::write(&scene, rib).unwrap();
    scree(&["render", scene.to_str().unwrap(), "-o", work.path().to_str().unwrap()]).ok();
    let image = image::open(work.path().join("a.png")).unwrap().to_rgb8();
    image.pixels().map(|p| p.0[0] as f64 / 255.0).sum::<f64>() * (4.0 / 128.0) * (4.0 / 128.0)
}

#[test]
fn primitives_cover_their_areas() {
    // Turned so that z of the primitive is up in the image.
    let side = "Rotate 90 1 0 0";
    let circle = "NuPatch 9 3 [0 0 0 0.25 0.25 0.5 0.5 0.75 0.75 1 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"Pw\" [1 0 0 1 0.70711 0.70711 0 0.70711 0 1 0 1 -0.70711 0.70711 0 0.70711 -1 0 0 1 -0.70711 -0.70711 0 0.70711 0 -1 0 1 0.70711 -0.70711 0 0.70711 1 0 0 1 0 0 0 1 0 0 0 0.70711 0 0 0 1 0 0 0 0.70711 0 0 0 1 0 0 0 0.70711 0 0 0 1 0 0 0 0.70711 0 0 0 1]";
    let square = "\"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]";
    let cases: Vec<(String, f64)> = vec![
        ("Sphere 1.5 -1.5 1.5 360".into(), PI * 2.25),
        ("Disk 0 1.2 270".into(), PI * 1.44 * 0.75),
        (format!("{side} Cylinder 0.5 -1 1 360"), 2.0),
        (format!("{side} Cone 2 1 360"), 2.0),
        (format!("{side} Paraboloid 1 0 1.5 360"), 4.0 / 3.0 * 1.5),
        // A line from (1, 0) to (0, 1) about z: its outline is the hyperbola of the square's middle radius.
        ("Torus 1.2 0.4 0 360 360".into(), PI * (1.6f64.powi(2) - 0.8f64.powi(2))),
        ("Hyperboloid 1.5 0 0 0.5 0 1 360".into(), PI * (2.25 - 0.25)),
        ("Polygon \"P\" [-1 -1 0 1 -1 0 0 0 0 1 1 0 -1 1 0]".into(), 3.0),
        ("GeneralPolygon [4 3] \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0 -0.5 -0.5 0 0.5 -0.5 0 0 0.5 0]".into(), 3.5),
        (circle.into(), PI),
        (format!("SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"interpolateboundary\"] [0 0] [] [] {square}"), 4.0),
        ("Points \"P\" [-1 0 0 1 0 0] \"width\" [0.8 1.2]".into(), PI * (0.16 + 0.36)),
        ("Curves \"linear\" [2] \"nonperiodic\" \"P\" [-1.5 0 0 1.5 0 0] \"constantwidth\" [0.5]".into(), 1.5),
        ("Patch \"bilinear\" \"P\" [-1 -1 0 1 -1 0 -1.5 1 0 1.5 1 0]".into(), 5.0),
        (
            "TrimCurve [1] [2] [0 0 1 2 3 4 4] [0] [4] [5] [0.25 0.75 0.75 0.25 0.25] [0.25 0.25 0.75 0.75 0.25] [1 1 1 1 1]
             NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [-2 -2 0 2 -2 0 -2 2 0 2 2 0]"
                .into(),
            4.0,
        ),
        // One leaf: the field (1 − r²)³ has the surface's value at r² = 1 − 0.421875^⅓ = ¼.
        ("Blobby 1 [1001 0] [2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1] [\"\"]".into(), PI),
        ("ObjectBegin 1 Disk 0 0.5 360 ObjectEnd Translate -1 0 0 ObjectInstance 1 Translate 2 0 0 ObjectInstance 1".into(), PI * 0.5),
        ("Skew 45 0 1 0 1 0 0 Polygon \"P\" [-0.5 -0.5 0 0.5 -0.5 0 0.5 0.5 0 -0.5 0.5 0]".into(), 1.0),
    ];
    for (primitive, area) in cases {
        let found = covered(&primitive);
        assert!((found - area).abs() < 0.012 * area + 0.01, "{primitive}: {found}, expected {area}");
    }
}

#[test]
fn scenes_of_the_library_draw_data() {
    let work = scratch();
    let at = |name: &str| work.path().join(name);
    std::fs::write(at("p_0007.csv"), "pos_x,pos_y,pos_z,r\n0,0,0.5,0.5\n0.8,0,0.3,0.3\n").unwrap();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut n = 0;
    for scene in std::fs::read_dir(scenes).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()) {
        for camera in
            ["eye: [3, -4, 2], look_at: [0, 0, 0.3], orbit: 3, follow: r > 0.4", "view: side, orthographic: 3"]
        {
            let yaml = format!(
                "data: {{csv: p_0007.csv}}\nscene: {scene}\ncamera: {{{camera}}}\nobjects:\n  - {{name: balls, geometry: {{sphere: {{radius: r}}}}}}\noutput: {{resolution: [48, 30], samples: [2, 2]}}\n"
            );
            std::fs::write(at("md.yaml"), yaml).unwrap();
            scree(&["render", at("md.yaml").to_str().unwrap(), "-o", at("out").to_str().unwrap()]).ok();
            let image = image::open(at("out/000007.png")).unwrap().to_rgb8();
            let corner = image.get_pixel(0, 0).0;
            let differ = image.pixels().filter(|p| (0..3).any(|c| p.0[c].abs_diff(corner[c]) > 12)).count();
            assert!(differ > 15, "{scene} {camera}: {differ}");
            n += 1;
        }
    }
    assert!(n >= 18);
}

const JOB: &str = "chronorender:
  rendersettings: {searchpaths: './', framerange: 3 3}
  camera: [{filename: cam.rib}]
  lighting: {filename: light.rib}
  renderpass: {name: main, settings: {resolution: 60 40, pixelsamples: 2 2, display: {output: out.tif}}}
  simulation:
    data:
      datasource: {type: csv, name: d, resource: ./data/*.dat, delim: ',', fields: [[id, integer], [pos_x, float], [pos_y, float], [pos_z, float], [euler_x, float], [euler_y, float], [euler_z, float]]}
    renderobject:
      - {name: ball, condition: 1 <= id <= 1 and not id == 7, color: 1 0 0, geometry: {type: sphere, radius: 0.5}, shader: {name: constant.sl}}
      - {name: bar, condition: id == 2, color: 0 1 0, geometry: [{type: box, xlength: 1, ylength: 0.1, zlength: 0.1}], shader: [{name: constant.sl}]}
";

#[test]
fn jobs_of_chrono_render() {
    let work = scratch();
    let at = |name: &str| work.path().join(name);
    std::fs::create_dir(at("data")).unwrap();
    // The bar is turned about the line of sight by −90°: it stands upright.
    std::fs::write(at("data/frame_3.dat"), "1,-1,0,0,0,0,0\n2,1,0,0,0,0,-90\n").unwrap();
    std::fs::write(at("cam.rib"), "Projection \"orthographic\"\nScreenWindow -3 3 -2 2\nTranslate 0 0 5\n").unwrap();
    std::fs::write(at("light.rib"), "LightSource \"ambientlight\" 1\n").unwrap();
    std::fs::write(at("job.yaml"), JOB).unwrap();
    scree(&["render", at("job.yaml").to_str().unwrap(), "-o", at("out").to_str().unwrap()]).ok();
    let image = image::open(at("out/000003.png")).unwrap().to_rgb8();
    let of = |x: u32, y: u32| image.get_pixel(x, y).0;
    // The bar is thinner than the filter is wide.
    let green = |x: u32, y: u32| of(x, y)[1] > 200 && of(x, y)[0] == 0;
    assert_eq!(of(20, 20), [255, 0, 0]);
    // Up along the bar there is bar, beside it nothing.
    assert!(green(40, 20) && green(40, 12), "{:?} {:?}", of(40, 20), of(40, 12));
    assert_eq!(of(44, 20), [0, 0, 0]);
    let fault = |from: &str, to: &str, part: &str| {
        std::fs::write(at("bad.yaml"), JOB.replace(from, to)).unwrap();
        let said = scree(&["render", at("bad.yaml").to_str().unwrap(), "-o", at("x").to_str().unwrap()]).fails(3);
        assert!(said.contains(part), "{said}");
    };
    fault("type: sphere", "type: shpere", "sphere");
    // What the original takes and nobody knows is warned of; the rest is drawn.
    let warned = |from: &str, to: &str, part: &str| {
        std::fs::write(at("odd.yaml"), JOB.replace(from, to)).unwrap();
        let answer = scree(&["render", at("odd.yaml").to_str().unwrap(), "-o", at("odd").to_str().unwrap()]);
        assert!(answer.errors().contains(part), "{}", answer.errors());
        answer.ok();
        image::open(at("odd/000003.png")).unwrap().to_rgb8().get_pixel(20, 20).0
    };
    assert_eq!(warned("radius: 0.5", "raduis: 0.5", "radius"), [255, 0, 0]);
    assert_eq!(warned("{filename: light.rib}", "{script: {file: a.py}}", "Python"), [255, 0, 0]);
    assert_eq!(warned("name: main,", "name: main, wobble: 3,", "wobble"), [255, 0, 0]);
    // What is known and changes nothing, too.
    let rest = "chronorender:\n";
    for (from, to, said) in [
        (rest, "chronorender:\n  movie: {framerate: 24}\n", "`movie` has no effect"),
        (rest, "chronorender:\n  distributed: {nodes: 2}\n", "`distributed` has no effect"),
        (
            "name: main,",
            "name: main, display: {output: a.tif},",
            "written as PNG, named by the number of the frame, and not as `a.tif`",
        ),
        ("name: main,", "name: main, display: {output: a.png, outtype: tiff},", "`outtype` has no effect"),
        ("name: main,", "name: main, display: {output: a.png, mode: z},", "`mode` has no effect"),
        ("radius: 0.5", "radius: 0.5, dims: 1 2", "`dims` has no effect"),
        ("name: ball,", "name: ball, range: 1 2,", "`range` has no effect"),
    ] {
        assert_eq!(warned(from, to, said), [255, 0, 0], "{to}");
    }
    for key in ["out", "fileformat", "padding", "renderer", "verbosity", "path"] {
        let job = JOB.replace("rendersettings: {", &format!("rendersettings: {{{key}: a, "));
        std::fs::write(at("idle.yaml"), job).unwrap();
        let answer = scree(&["render", at("idle.yaml").to_str().unwrap(), "-o", at("idle").to_str().unwrap()]);
        assert_eq!(answer.errors().matches(&format!("`{key}` has no effect")).count(), 1, "{}", answer.errors());
        answer.ok();
    }
    // Sizes from the data are asked for by the geometry, or by its object.
    let sizes = |from: &str, to: &str| {
        let fields = JOB.replace(from, to).replace("radius: 0.5", "radius: 9");
        std::fs::write(at("sizes.yaml"), fields).unwrap();
        let answer = scree(&["render", at("sizes.yaml").to_str().unwrap(), "-o", at("sizes").to_str().unwrap()]);
        assert!(answer.errors().contains("ep1"), "{}", answer.errors());
    };
    sizes("radius: 0.5", "radius: 9, changingparams: true");
    sizes("name: ball,", "name: ball, changingparams: true,");
    assert_eq!(warned("name: main,", "name: main, script: {file: a.py},", "Python"), [255, 0, 0]);
    assert_eq!(warned("{name: constant.sl}}", "{name: constant.sl, Kq: 5}}", "Kq"), [255, 0, 0]);
    // Attributes of an object: it is there, and not seen.
    let hidden = "shader: {name: constant.sl}, attribute: [{name: visibility, int camera: 0}]}\n      - {name: bar";
    let job = JOB.replace("shader: {name: constant.sl}}\n      - {name: bar", hidden);
    assert_ne!(job, JOB);
    std::fs::write(at("hidden.yaml"), job).unwrap();
    scree(&["render", at("hidden.yaml").to_str().unwrap(), "-o", at("hidden").to_str().unwrap()]).ok();
    assert_eq!(image::open(at("hidden/000003.png")).unwrap().to_rgb8().get_pixel(20, 20).0, [0, 0, 0]);
}

/// How many pixels of an image are of each of three colours, by what channel is brightest; the filter makes edges of both.
fn pixels_of(path: &Path) -> [f64; 3] {
    let mut n = [0.0; 3];
    for pixel in image::open(path).unwrap().to_rgb8().pixels() {
        n[(0..3).max_by_key(|c| pixel.0[*c]).unwrap()] += 1.0;
    }
    n
}

#[test]
fn jobs_of_chrono_render_from_folders() {
    let work = scratch();
    let out = work.path().join("out");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/chronorender");
    let draw = |job: &Path, res: &[&str]| {
        let _ = std::fs::remove_dir_all(&out);
        scree(&[&["render", job.to_str().unwrap(), "-o", out.to_str().unwrap()], res].concat()).ok();
        images(&out)
    };
    // Ten pixels to the unit: two balls of radius 0.5 in each of two frames; then a ball of 0.4 and an upright box in one.
    for (job, frames, areas) in [("plain.yml", 2, [2.0 * PI * 25.0, 0.0]), ("passes.yml", 1, [PI * 16.0, 8.0 * 16.0])] {
        let images = draw(&folder.join(job), &[]);
        assert_eq!(images.len(), frames, "{job}");
        for image in images {
            let found = pixels_of(&image);
            (0..2).for_each(|c| assert!((found[c] - areas[c]).abs() < 12.0, "{job}: {found:?}, expected {areas:?}"));
        }
    }
    // Where the files of the old program lie beside the tree, they are drawn too.
    let theirs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/chronorender");
    for job in ["default.yml", "2.yaml"].map(|j| theirs.join(j)).into_iter().filter(|j| j.is_file()) {
        assert!(!draw(&job, &["--res", "64x48"]).is_empty());
    }
}

#[test]
fn tables_of_other_programs_are_drawn_or_named() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/foreign");
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    // Yade writes no header but remarks: x, y, z, radius, velocity and id are columns by their place.
    for frame in ["yade_000.txt", "yade_001.txt"] {
        std::fs::copy(folder.join(frame), at(frame)).unwrap();
    }
    let said = scree(&["inspect", &at("yade_*.txt"), "--write", &at("m.yaml")]).ok();
    // The folder's name is by chance.
    let columns = said.replace(work.path().to_str().unwrap(), "");
    assert!(columns.contains("3 rows") && columns.contains("c8") && !columns.contains("c9"), "{said}");
    scree(&["render", &at("m.yaml"), "--res", "64x48", "--samples", "2", "-o", &at("o")]).ok();
    let [first, second] = [0, 1].map(|k| image::open(at(&format!("o/00000{k}.png"))).unwrap().to_rgb8());
    assert!(crate::golden::worst_block(&first, &second).error > 20.0, "the first ball has fallen between the frames");
    // A dump of LIGGGHTS tells its columns; several time steps of one file are as many frames.
    let dump = std::fs::read_to_string(folder.join("dump100.fill")).unwrap();
    let next = dump.replacen("100", "250", 1).replace("-0.25 0 0.2 0", "-0.25 0 0.6 0");
    std::fs::write(at("all.dump"), dump + &next).unwrap();
    let said = scree(&["inspect", &at("all.dump"), "--write", &at("d.yaml")]).ok();
    assert!(said.contains("2 frames") && said.contains("radius"), "{said}");
    scree(&["check", &at("d.yaml")]).ok();
    scree(&["render", &at("d.yaml"), "--res", "64x48", "--samples", "2", "-o", &at("d")]).ok();
    let [first, second] = ["100", "250"].map(|k| image::open(at(&format!("d/000{k}.png"))).unwrap().to_rgb8());
    assert!(crate::golden::worst_block(&first, &second).error > 20.0, "the first ball is higher in the second frame");
    let said = scree(&["inspect", folder.join("part100.vtk").to_str().unwrap()]).ok();
    assert!(said.contains("radius"), "{said}");
}

/// Two passes, a camera that moves, and data that is worked on first: the ball of row 2 alone is left, twice as large as it says.
const PASSES: &str = "chronorender:
  rendersettings: {searchpaths: './'}
  camera: {filename: cam.rib, moving_camera: true}
  renderpass:
    - {type: shadow, name: shadows, settings: {display: {output: s.z}}}
    - {name: beauty, settings: {resolution: 60 40, pixelsamples: 2 2}}
    - {name: shade, type: ao, shader: {name: occlusionsurf, samples: 4}, settings: {resolution: 30 20, pixelsamples: 1 1}}
  simulation:
    data:
      datasource: {type: csv, resource: ./data/*.dat, fields: [[id, integer], [pos_x, float], [pos_y, float], [pos_z, float], [r, float]]}
      dataprocess:
        - {type: derive, formula: 2 * r, field_name: ep1}
        - {type: select, condition: id == 2}
    renderobject: {name: ball, color: 1 0 0, geometry: {type: sphere, changingparams: true}, shader: {name: constant}}
";

#[test]
fn passes_processes_and_moving_cameras_of_chrono_render() {
    let work = scratch();
    let at = |name: &str| work.path().join(name);
    std::fs::create_dir(at("data")).unwrap();
    for frame in [4, 5] {
        std::fs::write(at(&format!("data/f_{frame}.dat")), "1,-1,0,0,0.5\n2,1,0,0,0.25\n").unwrap();
        let camera = format!("Projection \"orthographic\"\nScreenWindow -3 3 -2 2\nTranslate {} 0 5\n", frame - 5);
        std::fs::write(at(&format!("cam_{frame:02}.rib")), camera).unwrap();
    }
    std::fs::write(at("job.yaml"), PASSES).unwrap();
    let said = scree(&["render", at("job.yaml").to_str().unwrap(), "-o", at("out").to_str().unwrap()]).ok();
    assert!(said.contains("shade") && !at("out/shadows").exists(), "{said}");
    for (frame, middle) in [(4, 30), (5, 40)] {
        let image = image::open(at(&format!("out/00000{frame}.png"))).unwrap().to_rgb8();
        let red = |x: u32| image.get_pixel(x, 20).0 == [255, 0, 0];
        // The ball is 0.5 in radius, five pixels.
        assert!(
            red(middle - 3) && red(middle + 3) && !red(middle - 7) && !red(middle + 7) && !red(20),
            "frame {frame}"
        );
        let shade = image::open(at(&format!("out/shade/00000{frame}.png"))).unwrap().to_rgb8();
        assert_eq!(shade.dimensions(), (30, 20));
        // Nothing is near the ball: it is white where nothing is occluded.
        assert!(shade.get_pixel(middle / 2, 10).0[0] > 240);
    }
    // What is said of a file is said once, in whatever pass it is read again.
    std::fs::write(at("cam_04.rib"), "Projection \"orthographic\"\nZoom 3\nTranslate 0 0 5\n").unwrap();
    let again = scree(&["render", at("job.yaml").to_str().unwrap(), "-o", at("again").to_str().unwrap()]).errors();
    assert_eq!(again.matches("unknown request `Zoom`").count(), 1, "{again}");
    std::fs::write(at("bad.yaml"), PASSES.replace("id == 2", "di == 2")).unwrap();
    let said = scree(&["render", at("bad.yaml").to_str().unwrap(), "-o", at("x").to_str().unwrap()]).fails(3);
    assert!(said.contains("di"), "{said}");
}

#[test]
fn tables_of_the_exporter_for_blender() {
    let work = scratch();
    let at = |name: &str| work.path().join(name);
    std::fs::write(
        at("parts_000.dat"),
        "a,1,-2,0,0,1,0,0,0,sphere,0.5
a,2,0,0,0,1,0,0,0,box,0.5,0.25,0.1
b,3,2,0,0,1,0,0,0,obj,square.obj
b,4,0,1.5,0,1,0,0,0,cylinder,0.2,0.4
",
    )
    .unwrap();
    std::fs::write(at("square.obj"), "v -0.5 -0.5 0\nv 0.5 -0.5 0\nv 0.5 0.5 0\nv -0.5 0.5 0\nf 1 2 3 4\n").unwrap();
    std::fs::write(at("cam.rib"), "Projection \"orthographic\"\nScreenWindow -3 3 -2 2\nTranslate 0 0 5\n").unwrap();
    let job = "chronorender:
  camera: {filename: cam.rib}
  renderpass: {name: main, settings: {resolution: 120 80, pixelsamples: 2 2}}
  simulation:
    data: {datasource: {type: csv, resource: ./parts_*.dat}}
    renderobject: {name: all, condition: 1 <= id <= 3, color: 0 1 0, shader: {name: constant}}
";
    std::fs::write(at("job.yaml"), job).unwrap();
    scree(&["render", at("job.yaml").to_str().unwrap(), "-o", at("out").to_str().unwrap()]).ok();
    let image = image::open(at("out/000000.png")).unwrap().to_rgb8();
    let green = image.pixels().filter(|p| p.0[1] > 128).count() as f64 / 400.0;
    // A circle, a box and a square; the cylinder is not among the rows.
    let expected = PI * 0.25 + 0.5 + 1.0;
    assert!((green - expected).abs() < 0.05 * expected, "{green}, expected {expected}");
}

#[test]
fn schemas_know_the_keys_of_the_files() {
    for (of, keys) in [("model", ["bodies", "fills", "solver"]), ("metadata", ["objects", "scene", "camera"])] {
        let schema: serde_json::Value = serde_json::from_str(&scree(&["schema", of]).ok()).unwrap();
        for key in keys {
            assert!(schema["properties"][key].is_object(), "{of} {key}");
        }
        assert_eq!(schema["additionalProperties"], false);
    }
}
