//! `scree report`: what stands on pages, what is refused, and that a browser opens them: plots are drawn, nothing is loaded from
//! elsewhere, no error is said, and a phone is wide enough.

use crate::cli::{scratch, scree};
use image::{Rgb, RgbImage};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A run as its simulation would leave it: `columns` of its probes, all the same wave, over so many steps.
fn write_run(folder: &Path, n_steps: usize, columns: &[&str]) {
    std::fs::create_dir_all(folder.join("frames")).unwrap();
    let table = "id,class,shape,pos_x [m]\n0,<b>stone</b>,sphere,0\n1,floor,plane,0\n2,rod,spring,1\n";
    std::fs::write(folder.join("frames/000000.csv"), table).unwrap();
    let hash = blake3::hash(table.as_bytes()).to_hex().to_string();
    let index = serde_json::json!({
        "format_version": 1, "program": "scree 0.1.0", "model_hash": "abc", "seed": 3, "step_size": 0.001, "backend": "cpu",
        "adapter": "cpu", "units": "SI: m, kg, s, rad", "expected_frames": 1, "complete": true, "columns": [],
        "warnings": [{"kind": "joint", "steps": 7, "first_step": 2, "first_time": 0.002, "message": "<i>joint</i> is off"}],
        "frames": [{"number": 0, "time": 0.0, "file": "frames/000000.csv", "rows": 3, "hash": hash}],
    });
    std::fs::write(folder.join("run.json"), index.to_string()).unwrap();
    std::fs::write(folder.join("model.yaml"), "# <script>alert(1)</script>\nstep: 0.001\n").unwrap();
    let mut probes = format!("time [s]{}\n", columns.iter().map(|c| format!(",\"{c}\"")).collect::<String>());
    let mut report = "step,time [s],contacts,iterations,residual [m/s],worst_penetration [m],bounds [ms],\
        contact_solve [ms]\n"
        .to_string();
    for i in 0..n_steps {
        let t = i as f64 * 1e-3;
        write!(probes, "{t:.9}").unwrap();
        columns.iter().enumerate().for_each(|(k, _)| write!(probes, ",{:.9e}", ((k + 1) as f64 * t).sin()).unwrap());
        probes.push('\n');
        writeln!(report, "{},{t:.9},{},20,{:e},1e-6,0.1,0.3", i + 1, i % 50, 1e-9 * (1.0 + (i % 5000) as f64)).unwrap();
    }
    std::fs::write(folder.join("probes.csv"), probes).unwrap();
    std::fs::write(folder.join("report.csv"), report).unwrap();
}

const COLUMNS: [&str; 4] = ["block.x [m]", "block.y [m]", "energy.kinetic [J]", "energy.potential [J]"];

/// Images of noise, which no format makes small.
fn write_images(folder: &Path, n: u32, [width, height]: [u32; 2]) {
    std::fs::create_dir_all(folder).unwrap();
    for i in 0..n {
        let noise =
            |x: u32, y: u32| x.wrapping_mul(2_654_435_761).wrapping_add(y.wrapping_mul(40_503 + i)).rotate_left(9);
        let image = RgbImage::from_fn(width, height, |x, y| {
            let v = noise(x, y);
            Rgb([(x * 200 / width) as u8 + (v % 32) as u8, (y * 200 / height) as u8 + (v >> 8) as u8 % 32, i as u8])
        });
        image.save(folder.join(format!("{i:06}.png"))).unwrap();
    }
}

fn text(path: &Path) -> String {
    path.to_str().unwrap().into()
}

/// Make the page of a run, and give its text.
fn page(run: &Path, more: &[&str]) -> String {
    let path = scree(&[&["report", run.to_str().unwrap()], more].concat()).ok().trim().to_string();
    std::fs::read_to_string(path).unwrap()
}

/// The data of a page's plots.
fn plots(page: &str) -> Vec<serde_json::Value> {
    let (_, rest) = page.split_once("id=\"data\">").unwrap();
    let data: serde_json::Value = serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap();
    data["plots"].as_array().unwrap().clone()
}

#[test]
fn a_simulated_run_has_a_page() {
    let work = scratch();
    let run = work.path().join("pour");
    scree(&["simulate", "sim/models/pour.yaml", "--until", "0.1", "-o", &text(&run)]).ok();
    write_images(&run.join("images"), 3, [1600, 900]);
    std::fs::write(run.join("pour.mp4"), [7; 1000]).unwrap();
    let made = page(&run, &[]);
    for part in [
        "<meta name=\"generator\" content=\"scree report\">",
        "data:video/mp4;base64,",
        "pour.mp4, 1000 B: embedded in this page.",
        "width=\"720\" height=\"405\"",
        "Energy balance",
        "contact_solve",
        "simulated by",
        "model hash",
        "finished, 3 frames",
        "None: residual, joints and energy",
    ] {
        assert!(made.contains(part), "{part}");
    }
    assert_eq!(made.matches("data:image/jpeg").count(), 3);
    let linked = page(&run, &["--embed-film", "0", "--images", "1", "-o", &text(&work.path().join("p.html"))]);
    assert!(linked.contains("src=\"pour/pour.mp4\"") && linked.contains("linked, since it is larger than 0 B"));
    assert!(linked.contains("href=\"pour/images/000002.png\"") && linked.matches("data:image/jpeg").count() == 1);
    // The same run gives the same page.
    assert_eq!(made, page(&run, &[]));
}

#[test]
fn text_from_data_is_only_text() {
    let work = scratch();
    let run = work.path().join("<b>run&");
    let hostile = "</script><script>alert(1)</script><!--.x [m]";
    write_run(&run, 20, &[hostile, "<img src=x onerror=alert(1)>.y [<b>]"]);
    std::fs::write(run.join("\"><b>.webm"), "x").unwrap();
    let made = page(&run, &["--embed-film", "0"]);
    for wrong in ["<script>alert", "<img src=x", "<b>", "<!--", "<i>"] {
        assert!(!made.contains(wrong), "{wrong} stands on the page");
    }
    assert_eq!(made.matches("<script").count(), 2, "its data and its own script");
    assert_eq!(made.matches("</script").count(), 2);
    assert!(made.contains("&lt;b&gt;run&amp;") && made.contains("\\u003cb\\u003e"));
    assert!(made.contains("src=\"%22%3E%3Cb%3E.webm\""), "the address of the film");
    let axes: Vec<String> = plots(&made).iter().map(|p| p["axis"].as_str().unwrap().into()).collect();
    assert!(axes.contains(&"y [<b>]".to_string()), "{axes:?}");
    // No address of another place is loaded: those that are there are links and remarks of the plotting library.
    let loads = ["src=\"http", "src=\"//", "href=\"http", "url(", "@import", "fetch(", "XMLHttpRequest"];
    assert!(!loads.iter().any(|load| made.contains(load)));
}

#[test]
fn a_run_of_2000_steps_fits_into_3_mb_and_long_curves_keep_their_extremes() {
    let work = scratch();
    let run = work.path().join("long");
    let names: Vec<String> = (0..36).map(|k| format!("body{}.x{k} [m]", k / 3)).collect();
    let columns: Vec<&str> = names.iter().map(String::as_str).collect();
    write_run(&run, 2000, &columns);
    write_images(&run.join("images"), 20, [960, 540]);
    let made = page(&run, &[]);
    assert!(made.len() < 3_000_000, "{} bytes", made.len());
    assert!(!made.contains("Long curves are thinned"), "2000 steps are drawn whole");
    // A spike of one step in very many.
    let mut probes = "time [s],a.x [m]\n".to_string();
    (0..200_000).for_each(|i| writeln!(probes, "{},{}", i as f64 * 1e-3, if i == 77_777 { 9 } else { i % 3 }).unwrap());
    std::fs::write(run.join("probes.csv"), probes).unwrap();
    let made = page(&run, &[]);
    assert!(made.len() < 3_000_000 && made.contains("Long curves are thinned"), "{} bytes", made.len());
    let all = plots(&made);
    let spike = all.iter().find(|p| p["labels"][0] == "x").unwrap();
    let values = spike["tables"][0][1].as_array().unwrap();
    let at = values.iter().position(|v| v.as_f64() == Some(9.0)).expect("the spike is there");
    assert_eq!(spike["tables"][0][0][at].as_f64(), Some(77.777));
    assert!(values.len() <= 6002);
}

#[test]
fn runs_that_lack_something_have_pages_that_say_so() {
    let work = scratch();
    let run = work.path().join("run");
    write_run(&run, 20, &[]);
    let made = page(&run, &[]);
    assert!(
        made.contains("no columns of probes") && made.contains("has no images yet") && made.contains("no_energies")
    );
    assert!(
        made.contains("7") && made.contains("&lt;i&gt;joint&lt;/i&gt; is off") && made.contains("1 kind of warnings")
    );
    // Interrupted after its first line.
    let index = std::fs::read_to_string(run.join("run.json")).unwrap();
    let index = index
        .replace("\"complete\":true", "\"complete\":false")
        .replace("\"expected_frames\":1", "\"expected_frames\":40");
    std::fs::write(run.join("run.json"), index).unwrap();
    std::fs::write(run.join("probes.csv"), "time [s],a.x [m]\n").unwrap();
    std::fs::remove_file(run.join("report.csv")).unwrap();
    let made = page(&run, &[]);
    assert!(made.contains("unfinished: 1 of 40 frames") && made.contains("has taken no step yet"), "unfinished");
    // What is damaged is named.
    std::fs::write(run.join("probes.csv"), "time [s],a.x [m]\n0,1\n1\n").unwrap();
    std::fs::write(run.join("frames/000000.csv"), "id\n").unwrap();
    let said = scree(&["report", &text(&run)]).fails(5);
    assert!(said.contains("probes.csv:3") && said.contains("000000.csv") && said.contains("2 parts"), "{said}");
    let made = std::fs::read_to_string(run.join("report.html")).unwrap();
    assert!(made.contains("note fault") && made.contains("probes.csv"));
}

/// A ball under a load that no step can follow.
const DIVERGING: &str = "name: far\nstep: 0.01\nduration: 1\nframe_rate: 20\nmaterials: {m: {density: 1000, friction: 0.4}}\n\
    bodies: [{name: ball, material: m, position: [0, 0, 1], sphere: {radius: 0.1}}]\n\
    loads: [{body: ball, force: [1, 0, 0], value: 1.0e+12}]\n";

#[test]
fn how_a_run_ended_is_recorded_and_said() {
    let work = scratch();
    let (model, run) = (work.path().join("far.yaml"), work.path().join("far_run"));
    std::fs::write(&model, DIVERGING).unwrap();
    let said = scree(&["simulate", &text(&model), "-o", &text(&run)]).fails(4);
    assert!(said.contains("diverged at step"), "{said}");
    let index = |run: &Path| -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(run.join("run.json")).unwrap()).unwrap()
    };
    let ended = &index(&run)["ended"];
    assert!(ended["by"] == "diverged" && ended["why"].as_str().unwrap().contains("ball"), "{ended}");
    let made = page(&run, &[]);
    for part in [
        "class=\"state bad\"",
        "The simulation diverged at step",
        "<h1>far</h1>",
        "folder far_run",
        "None was counted before",
    ] {
        assert!(made.contains(part), "{part}");
    }
    assert!(!made.contains("stayed within their bounds"));
    // An interruption is said, and gone once the run goes on.
    let run = work.path().join("pour");
    scree(&["simulate", "sim/models/pour.yaml", "--until", "0.1", "-o", &text(&run)]).ok();
    let whole = std::fs::read_to_string(run.join("run.json")).unwrap();
    let cut = whole.replace(
        "\"complete\": true",
        "\"complete\": false, \"ended\": {\"by\": \"interrupted\", \"step\": 40, \"time\": 0.08}",
    );
    std::fs::write(run.join("run.json"), cut).unwrap();
    let made = page(&run, &[]);
    assert!(made.contains("class=\"state open\"") && made.contains("interrupted at step 40 (0.08 s): 3 of 3 frames"));
    scree(&["simulate", "sim/models/pour.yaml", "--until", "0.1", "--resume", "-o", &text(&run)]).ok();
    assert_eq!(std::fs::read_to_string(run.join("run.json")).unwrap(), whole);
    // A finished run that has lost a file is no sound run.
    std::fs::remove_file(run.join("report.csv")).unwrap();
    let said = scree(&["report", &text(&run)]).fails(5);
    assert!(said.contains("report.csv: is not there"), "{said}");
    let made = std::fs::read_to_string(run.join("report.html")).unwrap();
    assert!(made.contains("class=\"state bad\"") && made.contains("1 part of the data cannot be read"));
    let sweep = scree(&["report", &text(work.path())]).fails(5);
    assert!(sweep.contains("report.csv"), "{sweep}");
    let made = std::fs::read_to_string(work.path().join("report.html")).unwrap();
    assert!(made.contains("2 runs: 1 diverged; 1 finished, parts not readable") && made.contains("<h2>Provenance"));
}

#[test]
fn plots_are_called_by_what_they_show() {
    let work = scratch();
    let run = work.path().join("run");
    let columns = [
        "drive.fx_joint [N]",
        "drive.fy_joint [N]",
        "drive.tx_joint [N m]",
        "drive.ty_joint [N m]",
        "drive.violation [m or rad]",
    ];
    write_run(&run, 400, &[&columns[..], &["eye.violation [m or rad]", "rod.x [m]"]].concat());
    let model = "name: a machine\njoints: [{name: eye, kind: spherical}, {name: drive, kind: prismatic}]\n";
    std::fs::write(run.join("model.yaml"), model).unwrap();
    // Noise beside a length, a constant, and a needle.
    let mut probes =
        "time [s],rod.x [m],rod.y [m],rod.mass [kg],hook.fx [N],eye.violation [m or rad],drive.violation [m or rad]\n"
            .to_string();
    for i in 0..400 {
        let (x, noise, force) =
            (f64::from(i).sin(), 1e-14 * f64::from(i % 3), if i == 200 { 5000.0 } else { f64::from(i % 7) });
        writeln!(probes, "{},{x},{noise},2.5,{force},{x},{x}", f64::from(i) * 1e-3).unwrap();
    }
    let before = page(&run, &[]);
    for title in
        ["drive: force in the joint&#x27;s frame", "drive: torque in the joint&#x27;s frame", "<h1>a machine</h1>"]
    {
        assert!(before.contains(title) || before.contains(&title.replace("&#x27;", "&#39;")), "{title}");
    }
    std::fs::write(run.join("probes.csv"), probes).unwrap();
    let made = page(&run, &[]);
    let axes: Vec<String> = plots(&made).iter().map(|p| p["axis"].as_str().unwrap().into()).collect();
    assert!(axes.contains(&"violation [m]".into()) && axes.contains(&"violation [m or rad]".into()), "{axes:?}");
    assert!(
        made.contains("<strong>rod.mass</strong> = 2.5 kg")
            && made.contains("up to 5000 N, are outside of the vertical range")
    );
    let hook = plots(&made).into_iter().find(|p| p["axis"] == "fx [N]").unwrap();
    assert!(hook["range"][1].as_f64().unwrap() < 100.0);
}

#[test]
fn what_is_no_run_and_what_is_no_page_is_refused() {
    let work = scratch();
    let path = |name: &str| work.path().join(name);
    let report = |args: &[&str]| scree(&[&["report"], args].concat());
    assert!(report(&[&text(&path("none"))]).fails(4).contains("does not exist"));
    std::fs::create_dir(path("tables")).unwrap();
    assert!(report(&[&text(&path("tables"))]).fails(2).contains("scree simulate model.yaml"));
    std::fs::write(path("tables/p_1.csv"), "x,y\n1,2\n").unwrap();
    let said = report(&[&text(&path("tables"))]).fails(2);
    assert!(said.contains("has 1 table") && said.contains("scree plot") && said.contains("scree inspect"), "{said}");
    let run = path("run");
    write_run(&run, 5, &COLUMNS);
    assert!(report(&[&text(&run.join("run.json"))]).fails(2).contains("scree report"));
    assert!(report(&[&text(&run), "blok.x"]).fails(2).contains("did you mean `block.x`"));
    assert!(report(&[&text(&run), "--embed-film", "big"]).fails(2).contains("expected the size of a file"));
    // Files of others stay; pages of ours are replaced.
    for name in ["notes.html", "run/model.yaml", "run/run.json"] {
        if name == "notes.html" {
            std::fs::write(path(name), "<html>mine</html>").unwrap();
        }
        let before = std::fs::read(path(name)).unwrap();
        let said = report(&[&text(&run), "-o", &text(&path(name))]).fails(2);
        assert!(said.contains("no page of `scree report`") && said.contains("--output"), "{said}");
        assert_eq!(std::fs::read(path(name)).unwrap(), before);
    }
    assert!(report(&[&text(&run), "-o", &text(work.path())]).fails(2).contains("is a folder"));
    let only = page(&run, &["block.x", "-o", &text(&path("page.html"))]);
    let again = page(&run, &["-o", &text(&path("page.html"))]);
    let n_curves = |page: &str| plots(page).iter().map(|p| p["labels"].as_array().unwrap().len()).sum::<usize>();
    assert!(n_curves(&only) < n_curves(&again));
    #[cfg(unix)]
    {
        std::fs::write(path("film.mp4"), "x").unwrap();
        std::os::unix::fs::symlink(path("film.mp4"), run.join("film.mp4")).unwrap();
        let said = report(&[&text(&run)]).fails(5);
        assert!(said.contains("a link leads out of the run"), "{said}");
    }
}

/// Three runs of a sweep, the last of which has a page of its own.
fn write_sweep(folder: &Path) {
    for (k, friction) in ["0.1", "0.25", "10"].iter().enumerate() {
        let run = folder.join(format!("velocity=1_0_0_friction={friction}"));
        write_run(&run, 50 + k, &COLUMNS);
        write_images(&run.join("images"), 1, [640, 360]);
    }
    let last = folder.join("velocity=1_0_0_friction=10");
    page(&last, &[]);
}

#[test]
fn runs_of_a_sweep_have_a_page() {
    let work = scratch();
    let sweep = work.path().join("sweep");
    write_sweep(&sweep);
    let made = page(&sweep, &[]);
    assert!(made.contains("friction = 0.25") && made.contains("href=\"velocity%3D1_0_0_friction%3D10/report.html\""));
    assert_eq!(made.matches("data:image/jpeg").count(), 3);
    assert!(made.contains("data-value=\"0.25\"") && made.contains("3 runs, all finished with warnings"));
    let all = plots(&made);
    let x = all.iter().find(|p| p["axis"] == "x [m]").unwrap();
    assert_eq!(x["labels"], serde_json::json!(["friction=0.1", "friction=0.25", "friction=10"]));
    let lengths: Vec<usize> = (0..3).map(|k| x["tables"][k][0].as_array().unwrap().len()).collect();
    assert_eq!(lengths, [50, 51, 52]);
    // A run that cannot be read is named, and the others are there.
    std::fs::write(sweep.join("velocity=1_0_0_friction=0.1/run.json"), "{").unwrap();
    let said = scree(&["report", &text(&sweep)]).fails(5);
    assert!(said.contains("friction=0.1 is left out"), "{said}");
    assert!(!std::fs::read_to_string(sweep.join("report.html")).unwrap().contains("data-value=\"0.1\""));
}

/// The browser; none where it is not installed, which under CI is a failure.
fn chromium() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found =
        names.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success()));
    if found.is_none() {
        let is_gate = std::env::var("CI").is_ok_and(|value| value == "true");
        assert!(!is_gate, "Chromium is not on PATH: apt-get install chromium");
        eprintln!("skipped: Chromium is not on PATH");
    }
    found
}

/// Open a page in a window of a width, and give what it says on its console and its document as it is then.
fn open(browser: &str, page: &Path, width: u32, more: &[&str]) -> (String, String) {
    let home = scratch();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"])
        .args(["--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", "--hide-scrollbars"])
        .args(["--enable-logging=stderr", "--v=0", "--virtual-time-budget=4000"])
        .arg(format!("--user-data-dir={}", home.path().display()))
        .arg(format!("--window-size={width},2000"))
        .args(more)
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    let log = String::from_utf8_lossy(&output.stderr).to_string();
    assert!(output.status.success(), "{log}");
    let console: Vec<&str> = log.lines().filter(|line| line.contains("CONSOLE")).collect();
    (console.join("\n"), String::from_utf8_lossy(&output.stdout).to_string())
}

/// A copy of a page with one more script at its end, which may write to its document.
fn with_script(page: &str, script: &str, folder: &Path) -> PathBuf {
    let path = folder.join("tried.html");
    std::fs::write(&path, page.replace("</body>", &format!("<script>{script}</script></body>"))).unwrap();
    path
}

#[test]
fn a_browser_draws_every_plot_and_says_no_error() {
    let Some(browser) = chromium() else { return };
    let work = scratch();
    let run = work.path().join("a <b>run");
    write_run(&run, 300, &[&COLUMNS[..], &["still [m]", "</script><b>.x [m]"]].concat());
    write_images(&run.join("images"), 8, [640, 360]);
    let sweep = work.path().join("sweep");
    write_sweep(&sweep);
    for (made, n_sections) in [(page(&run, &[]), 7), (page(&sweep, &[]), 3)] {
        let n = plots(&made).len();
        assert!(n > 2 && made.matches("<h2>").count() >= n_sections, "{n} plots");
        let (console, document) = open(browser, &with_script(&made, "", work.path()), 1280, &["--dump-dom"]);
        assert_eq!(console, "", "what the console says");
        assert!(document.contains(&format!("data-plots=\"{n} of {n}\"")), "plots are not drawn");
        assert_eq!(document.matches("<canvas").count(), n);
        // A window is never as narrow as a phone: the page stands in a frame.
        for width in [1280, 360] {
            let measure = "const wide = [...document.querySelectorAll('main *')].filter((e) => !e.closest('.wide') && \
                !e.closest('pre') && e.getBoundingClientRect().right > innerWidth + 1).length; \
                console.log('measured', innerWidth, document.documentElement.scrollWidth, wide, document.documentElement.dataset.plots);";
            let name = with_script(&made, measure, work.path()).file_name().unwrap().to_string_lossy().into_owned();
            let frame = work.path().join("frame.html");
            let html = format!(
                "<body style='margin: 0'><iframe src='{name}' style='width: {width}px; height: 900px; border: 0'>"
            );
            std::fs::write(&frame, html).unwrap();
            let (console, _) = open(browser, &frame, 1400, &["--dump-dom"]);
            assert!(
                console.contains(&format!("\"measured {width} {width} 0 {n} of {n}\"")),
                "{width} pixels: {console}"
            );
            assert_eq!(console.lines().count(), 1, "{console}");
        }
        let path = with_script(&made, "", work.path());
        let shot = work.path().join("shot.png");
        let (console, _) = open(browser, &path, 360, &[&format!("--screenshot={}", shot.display())]);
        assert_eq!(console, "");
        let image = image::open(&shot).unwrap().to_rgb8();
        let mut colors: Vec<[u8; 3]> = image.pixels().map(|p| p.0).collect();
        colors.sort_unstable();
        colors.dedup();
        assert!(image.width() == 360 && colors.len() > 100, "{} colors", colors.len());
    }
}

#[test]
fn a_drag_over_a_plot_zooms_all_of_them() {
    let Some(browser) = chromium() else { return };
    let work = scratch();
    let run = work.path().join("run");
    write_run(&run, 300, &COLUMNS);
    let drag = "setTimeout(() => { \
        const canvases = [...document.querySelectorAll('canvas')]; const shown = () => canvases.map((c) => c.toDataURL()); \
        const first = shown(); const over = document.querySelector('.u-over'); const box = over.getBoundingClientRect(); \
        const send = (kind, x, to) => to.dispatchEvent(new MouseEvent(kind, { bubbles: true, button: 0, view: window, \
            clientX: box.left + x, clientY: box.top + 40, movementX: 9, movementY: 1 })); \
        send('mouseenter', 50, over); send('mousemove', 50, over); send('mousedown', 50, over); send('mousemove', 120, over); \
        send('mousemove', 200, over); send('mouseup', 200, document); \
        setTimeout(() => { const near = shown(); document.getElementById('reset').click(); \
            setTimeout(() => { const last = shown(); const count = (a, b) => a.filter((c, k) => c !== b[k]).length; \
                document.body.dataset.zoom = [count(near, first), count(last, first), canvases.length].join(' '); }, 300); }, 300); }, 300);";
    let made = page(&run, &[]);
    let n = plots(&made).len();
    let (console, document) = open(browser, &with_script(&made, drag, work.path()), 1280, &["--dump-dom"]);
    assert_eq!(console, "");
    let found = document.split_once("data-zoom=\"").map(|(_, rest)| rest.split('"').next().unwrap_or("").to_string());
    assert_eq!(found, Some(format!("{n} 0 {n}")), "plots that are zoomed, that are not as before, all");
}

#[test]
fn a_click_sorts_the_runs_by_numbers() {
    let Some(browser) = chromium() else { return };
    let work = scratch();
    let sweep = work.path().join("sweep");
    write_sweep(&sweep);
    let click = "const head = [...document.querySelectorAll('th')].find((h) => h.textContent === 'friction'); \
        const order = () => [...document.querySelectorAll('.sortable tbody tr')].map((r) => r.cells[0].textContent).join(' '); \
        head.querySelector('button').click(); const up = order(); head.querySelector('button').click(); \
        document.body.dataset.order = up + ', ' + order() + ', ' + head.getAttribute('aria-sort');";
    let path = with_script(&page(&sweep, &[]), click, work.path());
    let (console, document) = open(browser, &path, 800, &["--dump-dom"]);
    assert_eq!(console, "");
    assert!(document.contains("data-order=\"0.1 0.25 10, 10 0.25 0.1, descending\""), "the order of the rows");
}
