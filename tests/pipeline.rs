//! The whole way on a small model: run directory, RIB, pictures.

use crate::cli::{scratch, scree};

const MODEL: &str = "# Three stones above the ground.
step: 0.002
duration: 0.2
frame_rate: 20
materials: {m: {density: 2000, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: block, material: m, fixed: true, box: {size: [0.4, 0.4, 0.2]}, position: [0, 0, 0.1]}
fills:
  - {name: stones, material: m, count: 3, radius: [0.04, 0.05], min: [-0.2, -0.2, 0.3], max: [0.2, 0.2, 0.6]}
";

#[test]
fn from_a_model_to_pictures_in_one_command() {
    let work = scratch();
    let model = work.path().join("stones.yaml");
    std::fs::write(&model, MODEL).unwrap();
    let home = work.path().join("out");
    let said =
        scree(&["run", model.to_str().unwrap(), "-o", home.to_str().unwrap(), "--res", "64x36", "--samples", "2"]).ok();
    assert!(said.contains("images: 4"), "{said}");
    let movie = said.lines().find_map(|l| l.strip_prefix("movie: ")).expect("a movie or its fallback");
    assert!(std::fs::metadata(movie).unwrap().len() > 500);
    // A missing or torn picture makes no movie.
    let images = home.join("images");
    let last = images.join("000002.png");
    let whole = std::fs::read(&last).unwrap();
    std::fs::write(&last, &whole[..whole.len() / 2]).unwrap();
    assert!(scree(&["movie", images.to_str().unwrap()]).fails(4).contains("000002.png"));
    std::fs::remove_file(&last).unwrap();
    assert!(scree(&["movie", images.to_str().unwrap()]).fails(4).contains("1 pictures are missing between 0 and 3: 2"));
    std::fs::write(&last, &whole).unwrap();
    for frame in 0..4 {
        let picture = image::open(home.join(format!("images/{frame:06}.png"))).unwrap();
        assert_eq!((picture.width(), picture.height()), (64, 36));
    }
    // The run directory is as its format says.
    let index: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(home.join("run.json")).unwrap()).unwrap();
    assert_eq!(index["format_version"], 1);
    assert_eq!(index["complete"], true);
    assert_eq!(index["frames"].as_array().unwrap().len(), 4);
    let columns: Vec<&str> = index["columns"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert!(
        ["id", "class", "shape", "pos_x", "quat_w", "vel_z", "omega_x", "size_y"].iter().all(|c| columns.contains(c))
    );
    for file in ["model.yaml", "metadata.yaml", "report.csv", "frames/000003.arrow"] {
        assert!(home.join(file).is_file(), "{file}");
    }
    let report = std::fs::read_to_string(home.join("report.csv")).unwrap();
    assert!(report.starts_with("step,time [s],contacts,iterations,residual [m/s],worst_penetration [m]"));
    // The model that was written down runs again, to the same frames.
    let again = work.path().join("again");
    scree(&["simulate", home.join("model.yaml").to_str().unwrap(), "-o", again.to_str().unwrap()]).ok();
    let frame = |folder: &std::path::Path| std::fs::read(folder.join("frames/000003.arrow")).unwrap();
    assert!(frame(&home) == frame(&again));
    // CSV on request has the same columns.
    let tables = work.path().join("tables");
    scree(&["simulate", model.to_str().unwrap(), "--csv", "-o", tables.to_str().unwrap()]).ok();
    let table = std::fs::read_to_string(tables.join("frames/000000.csv")).unwrap();
    assert!(table.starts_with("id,class,shape,pos_x [m],"), "{}", &table[..60]);
    scree(&["render", tables.to_str().unwrap(), "-f", "2", "--res", "32x18", "--samples", "1"]).ok();
}

#[test]
fn the_rib_of_a_frame_is_standard_and_draws_the_same() {
    let work = scratch();
    let model = work.path().join("stones.yaml");
    std::fs::write(&model, MODEL).unwrap();
    let run = work.path().join("run");
    let run = run.to_str().unwrap();
    scree(&["simulate", model.to_str().unwrap(), "-o", run]).ok();
    let rib = work.path().join("frame.rib");
    let text = scree(&["rib", run, "-f", "3"]).ok();
    assert_eq!(text.matches("Sphere ").count(), 3);
    assert!(!text.contains("scree inject") && text.contains("WorldBegin") && text.trim_end().ends_with("WorldEnd"));
    std::fs::write(&rib, &text).unwrap();
    let out = work.path().to_str().unwrap();
    scree(&["render", rib.to_str().unwrap(), "-o", out]).ok();
    scree(&["render", run, "-f", "3", "-o", out, "--missing"]).ok();
    let by_rib = std::fs::read(work.path().join("000003.png")).unwrap();
    let direct = work.path().join("direct");
    scree(&["render", run, "-f", "3", "-o", direct.to_str().unwrap()]).ok();
    let by_data = image::open(direct.join("000003.png")).unwrap().to_rgb8();
    let by_rib = image::load_from_memory(&by_rib).unwrap().to_rgb8();
    let off: u64 = by_rib.as_raw().iter().zip(by_data.as_raw()).map(|(a, b)| a.abs_diff(*b) as u64).sum();
    // Numbers go through text, so that a last bit may differ.
    assert!((off as f64) < 0.05 * by_data.as_raw().len() as f64, "{off}");
}
