//! Tables of other programs, as their users meet them: inspected, rendered, and answered where they cannot be.

use crate::cli::{images, scratch, scree};
use std::path::Path;

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Inspect a table of these bytes, write metadata for it and render that: what `inspect` prints, the metadata, and what `render` warns of.
fn drawn(name: &str, bytes: &[u8]) -> (String, String, String) {
    let work = scratch();
    let (table, metadata, out) = (work.path().join(name), work.path().join("md.yaml"), work.path().join("o"));
    std::fs::write(&table, bytes).unwrap();
    let shown = scree(&["inspect", text(&table), "--write", text(&metadata)]).ok();
    let answer = scree(&["render", text(&metadata), "--res", "32x24", "--samples", "1", "-o", text(&out)]);
    answer.ok();
    assert_eq!(images(&out).len(), 1, "{name}");
    (shown, std::fs::read_to_string(&metadata).unwrap(), answer.errors())
}

#[test]
fn tables_of_other_programs_are_drawn() {
    let latin = b"x [\xb5m];y [\xb5m];z [\xb5m];angle [\xb0]\n0,1;0;0;3\n0,2;0;0;4\n".to_vec();
    let utf16: Vec<u8> = "\u{feff}x\ty\tz\tradius\r\n0,5\t0\t0\t0,1\r\n1\t0\t0\t0,1\r\n"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    for (name, bytes, shown, suggested) in [
        (
            "remark.txt",
            b"# LIGGGHTS\n# id x y z radius\n1 0 0 0 0.1\n2 0.3 0 0 0.1\n".to_vec(),
            "radius",
            "radius: radius",
        ),
        ("europe.csv", b"x;y;z;r\n0,5;1,5;0;0,1\n1,5;1;0;0,1\n".to_vec(), "0.5 to 1.5", "radius: r"),
        ("latin.csv", latin, "lengths in µm are read as 0.000001 m each", "- 0.000001 * x"),
        ("excel.txt", utf16, "0.5 to 1", "radius: radius"),
        (
            "fortran.dat",
            b" 1.0D+00 0.5d-1 1.0-100 1.0D-01\n 2.0D+00 0.0D0 0.0D0 1.0D-01\n".to_vec(),
            "1 to 2",
            "radius: c4",
        ),
        (
            "paraview.csv",
            b"\"Diameter\",\"Points:0\",\"Points:1\",\"Points:2\"\n0.2,0,0,0\n0.2,1,0,0\n".to_vec(),
            "Points:0",
            "- '`Points:0`'",
        ),
        (
            "edem.csv",
            b"Position X (m),Position Y (m),Position Z (m),Diameter\n0,0,0,1\n2,0,0,1\n".to_vec(),
            "Diameter",
            "0.5 * Diameter",
        ),
    ] {
        let (said, metadata, errors) = drawn(name, &bytes);
        assert!(said.contains(shown) && said.contains("2 rows"), "{name}: {said}");
        assert!(metadata.contains(suggested), "{name}: {metadata}");
        assert!(!errors.contains("warning"), "{name}: {errors}");
    }
}

#[test]
fn numbers_that_are_not_written_alike_are_placed() {
    let work = scratch();
    let table = work.path().join("p_1.csv");
    let inspect = |rows: &str| {
        std::fs::write(&table, format!("x;y;z\n{rows}")).unwrap();
        scree(&["inspect", text(&table), "--write", text(&work.path().join("md.yaml"))]).fails(4)
    };
    let said = inspect("1.5;0;0\n1,5;0;0\n");
    assert!(said.contains("p_1.csv:3:1: has `1,5` with a comma, and `1.5` of the same column has a point"), "{said}");
    let said = inspect("1.5;0;0\n1.234.567;0;0\n");
    assert!(said.contains("p_1.csv: column `x` has `1.234.567` in row 2, which is no number"), "{said}");
}

#[test]
fn a_guessed_radius_is_half_the_spacing_and_said() {
    let grid: Vec<String> = (0..1000).map(|k| format!("{},{},{}", k % 10, k / 10 % 10, k / 100)).collect();
    let (shown, metadata, _) = drawn("grid.csv", format!("x,y,z\n{}\n", grid.join("\n")).as_bytes());
    let remark = "no column tells a radius: 0.5 m is guessed from the distances between the rows";
    assert!(shown.contains(&format!("note: {remark}")) && metadata.contains(&format!("# {remark}")), "{shown}");
    assert!(metadata.contains("radius: 0.5\n"), "{metadata}");
    // Few points stay points, and rows in one place can be looked at.
    let (_, metadata, _) = drawn("few.csv", b"x,y,z\n0,0,0\n1,0,0\n0,1,0\n0,0,1\n");
    assert!(metadata.contains("radius: 0.06"), "{metadata}");
    let (_, metadata, _) = drawn("one.csv", b"x,y,z\n3,0,0\n3,0,0\n");
    assert!(metadata.contains("radius: 0.1\n"), "{metadata}");
}

#[test]
fn what_is_taken_for_something_is_said() {
    for (name, text, remark, written) in [
        (
            "plain.txt",
            "1 0.5 0 0 0.1\n2 0.7 1.5 0.1 0.1\n",
            "c2, c3, c4 are taken for x, y and z, and c5 for the radius",
            "radius: c5",
        ),
        (
            "inch.csv",
            "x [inch],y [inch],z [inch],r [inch]\n0,0,0,1\n9,0,0,1\n",
            "in inch are read as 0.0254 m",
            "0.0254 * x",
        ),
        ("odd.csv", "x [px],y [px],z [px],r [px]\n0,0,0,1\n9,0,0,1\n", "`px` is no unit of length", "- x"),
        ("path.csv", "time,x,y,z,r\n0,0,0,0,1\n1,9,0,0,1\n", "`time` goes from 0 to 1 within a table", "- x"),
        (
            "utm.csv",
            "x,y,z,r\n450122.5,5000000.1,301,0.2\n450123.5,5000000.9,300,0.2\n",
            "count from (450123, 5000001, 0)",
            "x - 450123",
        ),
        (
            "wear.csv",
            "id,type,x,y,z,r,wear\n1,2,0,0,0,1,0.5\n2,2,3,0,0,1,0.7\n",
            "there to select, turn or colour them, are the columns type, wear",
            "# or {column: wear, map",
        ),
    ] {
        let (shown, metadata, errors) = drawn(name, text.as_bytes());
        assert!(shown.contains("note: ") && shown.contains(remark), "{name}: {shown}");
        assert!(metadata.contains(remark) && metadata.contains(written), "{name}: {metadata}");
        assert!(!errors.contains("warning"), "{name}: {errors}");
    }
    let work = scratch();
    let at = |name: &str| work.path().join(name);
    std::fs::write(at("p_0.csv"), "x,y,z,radius\n0,0,0,0.1\n1,0,0,#INF\n").unwrap();
    let inspect = || scree(&["inspect", text(&at("p_*.csv")), "--write", text(&at("md.yaml"))]);
    assert!(inspect().fails(4).contains("column `radius` has `#INF` in row 2, which is no number"));
    // What cannot be drawn of the data is said as soon as the file is written.
    std::fs::write(at("p_0.csv"), "x,y,z,radius\n0,0,0,0.1\n1,0,0,0\n").unwrap();
    assert!(
        inspect().errors().contains("1 row not drawn for want of a value or a size; the first is row 2 of frame 0")
    );
    std::fs::write(at("p_0.csv"), "x,y,z,radius\n0,0,0,0.1\n1,0,0,-1\n").unwrap();
    assert!(
        inspect().errors().contains("1 row not drawn for want of a value or a size; the first is row 2 of frame 0")
    );
    std::fs::write(at("p_1.csv"), "x,y,z,radius\n0,0,0,0.1\n1,0,0,some\n").unwrap();
    let answer = inspect();
    answer.ok();
    assert!(
        answer.errors().contains("frame 1 cannot be drawn") && answer.errors().contains("row 2"),
        "{}",
        answer.errors()
    );
    for (from, to) in [("p_0.csv", "t_1.9.csv"), ("t_1.9.csv", "t_1.10.csv")] {
        std::fs::copy(at(from), at(to)).unwrap();
    }
    assert!(scree(&["inspect", text(&at("t_*.csv"))]).fails(4).contains("a number with a point in its name"));
}

#[test]
fn a_check_finds_what_every_image_would_fail_for() {
    let work = scratch();
    let (table, metadata) = (work.path().join("p_0.csv"), work.path().join("md.yaml"));
    std::fs::write(&table, "x,y,z,kind\n0,0,0,a\n").unwrap();
    let object = "objects: [{name: a, position: [x, y, z], geometry: {sphere: {radius: 1}}, select: kind == 'q'}]\n";
    let check = |more: &str| {
        std::fs::write(&metadata, format!("\u{feff}data: {{csv: 'p_*.csv'}}\n{object}{more}")).unwrap();
        scree(&["check", text(&metadata)])
    };
    assert!(check("").fails(3).contains("the scene wants a camera"));
    let camera = "camera: {eye: [1, -5, 1], look_at: [1, 0, 0]}\n";
    let said = check(&format!("{camera}output: {{frames: '7'}}\n")).fails(3);
    assert!(said.contains("md.yaml:4:10"), "{said}");
    let answer = check(camera);
    answer.ok();
    assert!(answer.errors().contains("the object `a` has no rows in the frame"), "{}", answer.errors());
}

#[test]
fn rows_without_values_are_counted() {
    let work = scratch();
    let (metadata, out) = (work.path().join("md.yaml"), work.path().join("o"));
    std::fs::write(work.path().join("p_1.csv"), "x,y,z,r,speed\n0,0,0,0.1,1\n").unwrap();
    std::fs::write(
        work.path().join("p_2.csv"),
        "x,y,z,r,speed\n0,0,0,0.1,\n1,NA,0,0.1,2\n2,0,0,,3\n3,0,0,0,3\n4,0,0,0.1,4\n5,0,0,1e300,4\n",
    )
    .unwrap();
    let head = "data: {csv: 'p_*.csv'}\ncamera: {eye: [1, -5, 1], look_at: [1, 0, 0]}\nobjects:\n  - name: a\n    position: [x, y, z]\n";
    let body = "    geometry: {sphere: {radius: r}}\n    color: {column: speed, range: [5, 0]}\n";
    std::fs::write(&metadata, format!("{head}{body}")).unwrap();
    let answer = scree(&["render", text(&metadata), "--res", "64x24", "--samples", "2", "-o", text(&out)]);
    answer.ok();
    let said = answer.errors();
    assert!(
        said.contains("4 rows not drawn for want of a value or a size; the first is row 2 of frame 2, in `y`"),
        "{said}"
    );
    assert!(
        said.contains("1 row drawn in magenta for want of a value of the colour; the first is row 1 of frame 2"),
        "{said}"
    );
    let rib = scree(&["rib", text(&metadata), "-f", "2"]).ok();
    assert_eq!(rib.matches("Sphere ").count(), 2, "{rib}");
}

#[test]
fn an_empty_frame_is_the_bare_scene() {
    let work = scratch();
    let (metadata, out) = (work.path().join("md.yaml"), work.path().join("o"));
    std::fs::write(work.path().join("p_0.csv"), "x,y,z,radius\n").unwrap();
    std::fs::write(work.path().join("p_1.csv"), "x,y,z,radius\n0,0,0.1,0.1\n1,0,0.1,0.1\n").unwrap();
    let pattern = work.path().join("p_*.csv");
    let shown = scree(&["inspect", text(&pattern), "--write", text(&metadata)]).ok();
    assert!(shown.contains("frame 0 has 0 rows") && shown.contains("radius"), "{shown}");
    scree(&["render", text(&metadata), "--res", "64x36", "--samples", "1", "-o", text(&out)]).ok();
    let image = |name: &str| image::open(out.join(name)).unwrap().to_rgb8();
    assert_ne!(image("000000.png"), image("000001.png"));
    std::fs::write(work.path().join("p_1.csv"), "x,y,z,radius\n").unwrap();
    assert!(scree(&["inspect", text(&pattern), "--write", text(&metadata)]).fails(4).contains("no rows"));
    for (name, code) in [("p_0.csv", 5), ("p_1.csv", 4)] {
        std::fs::write(work.path().join(name), "").unwrap();
        assert!(scree(&["inspect", text(&pattern)]).fails(code).contains("p_0.csv:1:1: is empty"));
    }
}

#[test]
fn a_bad_frame_is_reported_and_the_others_are_rendered() {
    let work = scratch();
    let (metadata, out) = (work.path().join("md.yaml"), work.path().join("o"));
    let good = "x,y,z,radius\n0,0,0.1,0.1\n1,0,0.1,0.1\n";
    for k in 0..4 {
        std::fs::write(work.path().join(format!("p_{k}.csv")), good).unwrap();
    }
    scree(&["inspect", text(&work.path().join("p_*.csv")), "--write", text(&metadata)]).ok();
    std::fs::write(work.path().join("p_0.csv"), "x,y,z,radius\n0,0,0.1,0.1\n1,0\n").unwrap();
    std::fs::write(work.path().join("p_2.csv"), "x,y,z\n0,0,0.1\n").unwrap();
    std::fs::write(work.path().join("p_3.csv"), "x,y,z,radius\n0,0,0.1,0.1\n1,0,0.1,big\n").unwrap();
    let render =
        |command: &str| scree(&[command, text(&metadata), "--res", "32x24", "--samples", "1", "-o", text(&out)]);
    let said = render("render").fails(5);
    assert!(said.contains("error: frame 0: ") && said.contains("p_0.csv:3:3: row has 2 cells"), "{said}");
    assert!(said.contains("unknown column `radius`") && said.contains("row 2 of frame 3: "), "{said}");
    assert!(said.contains("3 of 4 frames could not be rendered (0, 2, 3); the others were rendered"), "{said}");
    assert!(images(&out) == [out.join("000001.png")]);
    assert!(render("run").fails(5).contains("no movie is written"));
    let again = work.path().join("again.yaml");
    let said = scree(&["inspect", text(&work.path().join("p_*.csv")), "--write", text(&again)]).fails(5);
    assert!(said.contains("error: frame 0: ") && said.contains("could not be read (0); frame 1 is shown"), "{said}");
    assert_eq!(std::fs::read(&again).unwrap(), std::fs::read(&metadata).unwrap());
    assert!(scree(&["check", text(&metadata)]).fails(4).contains("p_0.csv:3:3"));
    assert!(!out.join("md.mp4").exists() && !out.join("md.apng").exists());
    for k in 0..4 {
        std::fs::write(work.path().join(format!("p_{k}.csv")), "x,y,z,radius\n0,0\n").unwrap();
    }
    assert!(render("render").fails(4).contains("p_0.csv:2:3: row has 2 cells, expected 4"));
}

#[test]
fn what_is_no_table_is_named() {
    let work = scratch();
    for (name, bytes, expected, way) in [
        ("part.vtk", &b"# vtk DataFile Version 3.0\na\nASCII\nDATASET POLYDATA\n"[..], "expected `POINTS`", "cut off"),
        ("dump100.liggghts", b"ITEM: TIMESTEP\n100\n", "ends here, expected `ITEM: ATOMS`", "interrupted"),
        ("table.csv", b"PK\x03\x04\0\0xl/workbook.xml", "an Excel workbook", "as CSV"),
        ("data.h5", b"\0\0\0\x01", "an HDF5 file", "to_csv"),
        ("data.bin", b"x\0\x01\x02", "is not text", "UTF-8"),
    ] {
        let path = work.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let said = scree(&["inspect", text(&path)]).fails(4);
        assert!(said.contains(expected) && said.contains(way), "{name}: {said}");
    }
    let table = work.path().join("p_1.csv");
    std::fs::write(&table, "x,y,z\n1,2,3\n").unwrap();
    assert!(scree(&["render", text(&table)]).fails(3).contains("scree inspect"));
    for name in ["table.csv", "part.vtk", "dump100.liggghts"] {
        std::fs::remove_file(work.path().join(name)).unwrap();
    }
    for command in ["inspect", "render"] {
        let said = scree(&[command, text(work.path())]).fails(4);
        assert!(said.contains("1 file that is a table") && said.contains("p_*.csv"), "{said}");
    }
}

#[test]
fn swapped_ranges_and_tabs_are_explained() {
    let work = scratch();
    let model = work.path().join("m.yaml");
    let check = |text_of: &str| {
        std::fs::write(&model, text_of).unwrap();
        scree(&["check", text(&model)]).fails(3)
    };
    let fill = |rest: &str| {
        check(&format!(
            "materials: {{m: {{density: 1000, friction: 0.5}}}}\nfills:\n  - {{name: f, material: m, count: 1, {rest}}}\n"
        ))
    };
    let said = fill("radius: [0.05, 0.03], min: [0, 0, 0], max: [1, 1, 1]");
    assert!(said.contains("runs from 0.05 to 0.03, expected the smaller radius first"), "{said}");
    let said = fill("radius: [0.03, 0.05], min: [0, 2, 0], max: [1, 1, 1]");
    assert!(said.contains("`min` and `max` are swapped along y: `min` is 2, `max` is 1"), "{said}");
    let said = scree(&["plot", text(work.path()), "--times", "2-0.5"]).fails(2);
    assert!(said.contains("swapped: 2 is after 0.5"), "{said}");
    let said = scree(&["render", text(&model), "-f", "9-2"]).fails(2);
    assert!(said.contains("swapped") && said.contains("9 comes before 2"), "{said}");
    let said = check("materials:\n\tm: {density: 1000, friction: 0.5}\n");
    assert!(said.contains("m.yaml:2:1: a tab") && said.contains("use spaces"), "{said}");
}

#[test]
fn a_joint_is_told_where_it_may_not_begin() {
    let work = scratch();
    let model = work.path().join("m.yaml");
    let check = |joint: &str| {
        let text_of = format!(
            "duration: 0.01\nbodies:\n  - {{name: cart, shapes: [], mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}}\n\
             joints:\n  - {{name: j, a: world, b: cart, {joint}}}\n"
        );
        std::fs::write(&model, text_of).unwrap();
        scree(&["check", text(&model)])
    };
    let said = check("kind: prismatic, axis: [1, 0, 0], limits: [-0.5, -0.1]").fails(3);
    assert!(said.contains("m.yaml:5:") && said.contains("from -0.5 to -0.1, but the joint begins at 0.0"), "{said}");
    let said = check("kind: revolute, limits: [5, 90]").fails(3);
    assert!(said.contains("angles and slides count from the start"), "{said}");
    // What begins at its limit, and what acts only later, is well.
    check("kind: revolute, limits: [0, 90]").ok();
    check("kind: revolute, from: 0.005, limits: [5, 90]").ok();
    // A point that is to stay on a plane, which it may come to later.
    let said = check("kind: point_on_plane, position: [1, 0, 0], position_b: [1, 2, -0.25]").fails(3);
    assert!(
        said.contains("m.yaml:5:") && said.contains("position_b") && said.contains("is 0.250000 m off the plane"),
        "{said}"
    );
    check("kind: point_on_plane, position: [1, 0, 0], position_b: [1, 2, -0.25], from: 0.005").ok();
    check("kind: point_on_plane, position_b: [0.6, 0.8, 0], axis: [0.8, -0.6, 0]").ok();
    check("kind: point_on_plane, position_b: [0.707107, 0.707107, 3], axis: [0.577, -0.577, 0]").ok();
    // A length that begins elsewhere is taken to, as a motor's motion.
    let length = |m: f64| check(&format!("kind: distance, position_b: [1, 0, 0], length: {m}")).errors();
    assert!(length(0.8).contains("the length of joint `j` begins at 0.800 m, where the joint is at 1.000 m"));
    assert!(length(0.8).contains("m.yaml:5:73: "), "{}", length(0.8));
    assert!(!length(1.0).contains("begins at"));
}

/// A function of time from a CSV file: in all dialects, and in no units but SI.
#[test]
fn functions_of_time_are_read_from_csv_files() {
    let work = scratch();
    let at = |name: &str| work.path().join(name);
    let model = "duration: 0.5\nstep: 0.01\ngravity: [0, 0, 0]\nbodies:\n  - {name: cart, shapes: [], mass: 1, inertia: [1, 1, 1]}\n\
                 loads:\n  - {body: cart, force: [1, 0, 0], value: {csv: f.csv}}\nprobes: {interval: 0.5, no_energies: true}\n";
    std::fs::write(at("m.yaml"), model).unwrap();
    // A force that rises from 0 to 3 N in 1 s: v = 3/2 t².
    for file in [
        "0,0\n1,3\n",
        "time [s],force [N]\n0,0\n1,3\n",
        "\u{feff}t;F\r\n0,0;0,0\r\n0,5;1,5\r\n1,0;3,0\r\n",
        "# t F\n0 0\n1 3\n",
    ] {
        std::fs::write(at("f.csv"), file).unwrap();
        scree(&["simulate", text(&at("m.yaml")), "-o", text(&at("run")), "--fresh"]).ok();
        let probes = std::fs::read_to_string(at("run/probes.csv")).unwrap();
        let column = probes.lines().next().unwrap().split(',').position(|name| name == "cart.vx [m/s]").unwrap();
        let v: f64 = probes.lines().last().unwrap().split(',').nth(column).unwrap().parse().unwrap();
        assert!((v - 0.375).abs() < 1e-6, "{file}: {v} m/s");
    }
    for (file, says) in [
        ("time [ms],force [N]\n0,0\n1000,3\n", "`time` is in ms, expected s"),
        ("time [s],force [kN]\n0,0\n1,3\n", "`force` is in kN, expected N"),
        ("force,time\n0,0\n3,1\n", "the second column is `time`, expected the time first"),
        ("t,x,y\n0,0,0\n1,3,0\n", "has 3 columns, expected two, time and value"),
        ("0,0\n1,NaN\n", "`c2` has no number in row 2"),
        ("0,0\n1\n", "f.csv:2:1: row has 1 cell, expected 2"),
        ("0,0\n1,3\n1,4\n", "has times that do not ascend"),
        ("", "f.csv:1:1: is empty"),
    ] {
        std::fs::write(at("f.csv"), file).unwrap();
        let said = scree(&["check", text(&at("m.yaml"))]).fails(3);
        assert!(said.contains("m.yaml:7:") && said.contains(says), "{file}: {said}");
    }
}

/// What is warned of has the line of what is written; of defaults, that of what they are set against.
#[test]
fn doubts_about_a_model_have_their_lines() {
    let work = scratch();
    let model = work.path().join("m.yaml");
    let said = |head: &str, position: f64| {
        let of_balls = format!(
            "{head}duration: 0.01\nmaterials: {{s: {{density: 2600, friction: 0.5}}}}\nbodies:\n\
             \x20 - {{name: a, material: s, sphere: {{radius: 0.1}}}}\n\
             \x20 - {{name: b, material: s, sphere: {{radius: 0.1}}, position: [{position}, 0, 0]}}\n"
        );
        std::fs::write(&model, of_balls).unwrap();
        let answer = scree(&["check", text(&model)]);
        answer.ok();
        answer.errors()
    };
    let repeat = "frames repeat";
    for (head, place) in [
        ("name: balls\nframe_rate: 2000\n", "m.yaml:2:1: "),
        ("name: balls\nstep: 0.05\n", "m.yaml:2:1: "),
        ("name: balls\nstep: 0.05\nframe_rate: 25\n", "m.yaml:3:1: "),
    ] {
        let said = said(head, 1.0);
        assert!(said.contains(place) && said.contains(repeat), "{head}: {said}");
    }
    let said = said("", 0.17);
    assert!(said.contains("m.yaml:5:5: bodies `a` and `b` overlap by 3.000e-2 m at the start"), "{said}");
}

/// The image of a table by the metadata that `inspect` wrote for it.
fn image(name: &str, bytes: &[u8], more: &[(&str, &str)]) -> Vec<u8> {
    let work = scratch();
    let path = |name: &str| work.path().join(name);
    std::fs::write(path(name), bytes).unwrap();
    more.iter().for_each(|(name, text)| std::fs::write(path(name), text).unwrap());
    scree(&["inspect", text(&path(name)), "--write", text(&path("md.yaml"))]).ok();
    let metadata = text(&path("md.yaml")).to_string();
    scree(&["render", &metadata, "--res", "64x48", "--samples", "2", "-o", text(&path("o"))]).ok();
    image::open(&images(&path("o"))[0]).unwrap().into_rgb8().into_raw()
}

#[test]
fn grains_of_any_size_are_drawn() {
    // As many pixels of 64x48 are covered by four grains, whether they are 2 m or 1 µm wide.
    let covered = |r: f64| {
        let at = [[0.0, 0.0, 1.0], [3.0, 0.0, 1.0], [3.0, 3.0, 1.0], [0.0, 0.0, 4.0]].map(|p| p.map(|x| x * r));
        let line = |p: [f64; 3]| format!("{:e},{:e},{:e},{r:e}\n", p[0], p[1], p[2]);
        let pixels = image("g.csv", format!("x,y,z,radius\n{}", at.map(line).concat()).as_bytes(), &[]);
        // Grains are greyer than the ground and the sky.
        let is_grain = |p: &&[u8]| p[0].abs_diff(p[2]) < 24 && p[0] > 20;
        pixels.chunks_exact(3).filter(is_grain).count()
    };
    let usual = covered(0.1);
    for r in [1.0, 1e-3, 1e-5, 5e-7] {
        let own = covered(r);
        assert!(usual > 100 && own.abs_diff(usual) * 20 < usual, "{own} and {usual} pixels of grains of {r} m");
    }
}

/// Positions and radii of three grains, m.
const GRAINS: [[f64; 4]; 3] = [[0.0, 0.0, 0.125, 0.125], [0.5, 0.25, 0.125, 0.125], [0.25, 0.5, 0.375, 0.25]];

/// Lines of the three grains, by their index and numbers.
fn rows(line: impl Fn(usize, &[f64; 4]) -> String) -> String {
    GRAINS.iter().enumerate().map(|(k, row)| line(k, row) + "\n").collect()
}

fn join(row: &[f64], by: &str) -> String {
    row.iter().map(f64::to_string).collect::<Vec<_>>().join(by)
}

/// The image of the grains.
fn expected() -> Vec<u8> {
    image("grains.csv", format!("x,y,z,radius\n{}", rows(|_, r| join(r, ","))).as_bytes(), &[])
}

/// Text of other programs gives the image of the same CSV file. What they write is that of: DEM-Engine `writeSpheresAsCsv`
/// (src/DEM/dT.cpp); ParaView "Save Data"; LIGGGHTS legacy VTK and `dump … custom`; YADE `export.text`; MercuryDPM `.data`; OVITO extended
/// XYZ; pandas `to_csv`.
#[test]
fn text_of_other_programs_gives_one_image() {
    let expected = expected();
    let (points, radii) = (rows(|_, r| join(&r[..3], " ")), GRAINS.map(|r| r[3].to_string()).join("\n"));
    for (name, text) in [
        ("DEMdemo_output_0007.csv", format!("X,Y,Z,r\n{}", rows(|_, r| join(r, ",")))),
        (
            "paraview.csv",
            format!(
                "\"Radius\",\"Points:0\",\"Points:1\",\"Points:2\"\n{}",
                rows(|_, r| join(&[r[3], r[0], r[1], r[2]], ","))
            ),
        ),
        (
            "legacy_3.vtk",
            format!(
                "# vtk DataFile Version 3.0\nGenerated by LIGGGHTS\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n{points}VERTICES 3 6\n1 0\n\
                 1 1\n1 2\nPOINT_DATA 3\nSCALARS radius float 1\nLOOKUP_TABLE default\n{radii}\n"
            ),
        ),
        ("yade_3.txt", format!("#format x_y_z_r\n{}", rows(|_, r| join(r, "\t")))),
        (
            "Mill.data",
            format!(
                "3 0.5 0 0 0 1 1 1\n{}",
                rows(|_, r| format!("{} 0 0 0 {} 0 0 0 0 0 0 0", join(&r[..3], " "), r[3]))
            ),
        ),
        (
            "ovito.xyz",
            format!(
                "3\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=species:S:1:pos:R:3:radius:R:1 Time=0.5\n{}",
                rows(|_, r| format!("Si {}", join(r, " ")))
            ),
        ),
        (
            "dump_40.liggghts",
            format!(
                "ITEM: TIMESTEP\n40\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id type x y z radius \n{}",
                rows(|k, r| format!("{} 1 {} ", k + 1, join(r, " ")))
            ),
        ),
        ("pandas.csv", format!(",x,y,z,radius\n{}", rows(|k, r| format!("{k},{}", join(r, ","))))),
        ("europe.csv", format!("x;y;z;radius\n{}", rows(|_, r| join(r, ";"))).replace('.', ",")),
    ] {
        assert!(image(name, text.as_bytes(), &[]) == expected, "{name}");
    }
}

/// XML and binary files of other programs give the image of the same CSV file: MFiX-DEM and LIGGGHTS VTP and VTU, ASCII and appended, with
/// a collection; Blender PLY.
#[test]
fn binary_files_of_other_programs_give_one_image() {
    let expected = expected();
    let array = |name: &str, n: usize, text: &str| {
        format!(
            "<DataArray type=\"Float32\" Name=\"{name}\" NumberOfComponents=\"{n}\" format=\"ascii\">{text}</DataArray>\n"
        )
    };
    let xml = |kind: &str| {
        let radii = array("radius", 1, &GRAINS.map(|r| r[3].to_string()).join(" "));
        let points = array("Points", 3, &rows(|_, r| join(&r[..3], " ")));
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"0.1\" byte_order=\"LittleEndian\">\n<{kind}>\n\
             <Piece NumberOfPoints=\"3\">\n<PointData>\n{radii}</PointData>\n<Points>\n{points}</Points>\n</Piece>\n</{kind}>\n</VTKFile>\n"
        )
    };
    let float = |x: f64| (x as f32).to_le_bytes();
    let bytes = |numbers: &[f64]| numbers.iter().flat_map(|x| float(*x)).collect::<Vec<u8>>();
    let mut raw = b"<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\">\n\
        <PolyData>\n<Piece NumberOfPoints=\"3\">\n<PointData Scalars=\"Diameter\">\n\
        <DataArray type=\"Float32\" Name=\"Diameter\" format=\"appended\" offset=\"0\"/>\n</PointData>\n<Points>\n\
        <DataArray type=\"Float32\" Name=\"Position\" NumberOfComponents=\"3\" format=\"appended\" offset=\"16\"/>\n</Points>\n\
        </Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_"
        .to_vec();
    raw.extend(12u32.to_le_bytes());
    raw.extend(GRAINS.iter().flat_map(|r| float(2.0 * r[3])));
    raw.extend(36u32.to_le_bytes());
    raw.extend(GRAINS.iter().flat_map(|r| bytes(&r[..3])));
    raw.extend(b"\n</AppendedData>\n</VTKFile>\n");
    let mut ply = b"ply\nformat binary_little_endian 1.0\ncomment Created by Blender\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nproperty float radius\nend_header\n"
        .to_vec();
    ply.extend(GRAINS.iter().flat_map(|r| bytes(r)));
    let vtp = xml("PolyData");
    for (name, bytes) in [
        ("DES_0001.vtp", vtp.clone().into_bytes()),
        ("grains_0001.vtu", xml("UnstructuredGrid").into_bytes()),
        ("DES_raw.vtp", raw),
        ("cloud.ply", ply),
    ] {
        assert!(image(name, &bytes, &[]) == expected, "{name}");
    }
    let pvd = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n\
               <DataSet timestep=\"0.5\" group=\"\" part=\"0\" file=\"grains_0.vtp\"/>\n</Collection>\n</VTKFile>\n";
    assert!(image("series.pvd", pvd.as_bytes(), &[("grains_0.vtp", &vtp)]) == expected);
}
