//! Files of others: opening them runs no programs, writes nothing outside of the folder that was named, and takes neither the time nor
//! the memory of the machine.
//!
//! The files in `hostile/` are hostile in one way each; `expected.txt` there has the command for each, the exit code and a part of what
//! is said. In a file `<<1000 x TEXT>>` stands for a text that is repeated.

use crate::cli::{scratch, scree};
use rayon::prelude::*;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A scene that asks a program for a sphere. The program leaves a mark where it has run.
fn scene_with_program(folder: &Path) -> (String, String) {
    let program = folder.join("answer.sh");
    let mark = folder.join("ran");
    let answer = "printf 'Sphere 1 -1 1 360\\377'";
    std::fs::write(&program, format!("#!/bin/sh\ntouch '{}'\nread line\n{answer}\nsleep 100\n", mark.display()))
        .unwrap();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    }
    let scene = folder.join("scene.rib");
    let rib = format!(
        "Format 16 16 1\nDisplay \"a.png\" \"file\" \"rgb\"\nTranslate 0 0 5\nWorldBegin\nProcedural \"RunProgram\" [\"{}\" \"x\"] [-1 1 -1 1 -1 1]\nWorldEnd\n",
        program.display()
    );
    std::fs::write(&scene, rib).unwrap();
    (scene.to_str().unwrap().into(), program.to_str().unwrap().into())
}

#[cfg(unix)]
#[test]
fn programs_run_only_where_they_are_allowed() {
    let work = scratch();
    let (scene, program) = scene_with_program(work.path());
    let out = work.path().join("out");
    let render = |more: &[&str]| scree(&[&["render", &scene, "-o", out.to_str().unwrap()], more].concat());
    let said = render(&[]).fails(3);
    assert!(said.contains("scene.rib:5:1: would run the program") && said.contains("answer.sh"), "{said}");
    assert!(said.contains("--allow-program"), "{said}");
    let answer = scree(&["check", &scene]);
    answer.ok();
    assert!(answer.errors().contains("is not run in a check"), "{}", answer.errors());
    // A permission is for one program, wherever its name leads.
    assert!(render(&["--allow-program", "sh"]).fails(3).contains("would run the program"));
    assert!(render(&["--allow-program", "no-such-program"]).fails(2).contains("there is no such program"));
    assert!(!work.path().join("ran").exists(), "it ran without permission");
    for more in [&["--allow-program", &program][..], &["--allow-programs"]] {
        render(more).ok();
        assert!(work.path().join("ran").exists());
        let image = image::open(out.join("a.png")).unwrap().to_rgb8();
        assert_ne!(image.get_pixel(8, 8), image.get_pixel(0, 0), "{more:?}");
        std::fs::remove_file(work.path().join("ran")).unwrap();
    }
    // The scene of a metadata file is a file of others, too.
    let table = work.path().join("p_0.csv");
    std::fs::write(&table, "x,y,z\n0,0,0\n").unwrap();
    let text = std::fs::read_to_string(&scene)
        .unwrap()
        .replace("Display \"a.png\" \"file\" \"rgb\"\n", "#scree override Display\n");
    let text = text
        .replace("WorldEnd", "#scree inject objects\nWorldEnd")
        .replace("Translate 0 0 5\n", "#scree inject camera\n");
    std::fs::write(work.path().join("own.rib"), text).unwrap();
    let metadata = work.path().join("md.yaml");
    let rest = "camera: {eye: [0, -5, 0], look_at: [0, 0, 0]}\nobjects: [{name: a, position: [x, y, z], geometry: {sphere: {radius: 1}}}]\n";
    std::fs::write(&metadata, format!("data: {{csv: 'p_*.csv'}}\nscene: own.rib\n{rest}")).unwrap();
    let render =
        |more: &[&str]| scree(&[&["render", metadata.to_str().unwrap(), "-o", out.to_str().unwrap()], more].concat());
    assert!(render(&[]).fails(3).contains("would run the program"));
    scree(&["rib", metadata.to_str().unwrap(), "-f", "0"]).fails(3);
    scree(&["check", metadata.to_str().unwrap()]).ok();
    assert!(!work.path().join("ran").exists(), "it ran without permission");
    render(&["--allow-programs"]).ok();
}

/// What a program has started ends with it.
#[cfg(target_os = "linux")]
#[test]
fn programs_end_with_their_children() {
    let work = scratch();
    let (scene, program) = scene_with_program(work.path());
    let child = work.path().join("child");
    let text = std::fs::read_to_string(&program).unwrap();
    let text = text.replace("read line", &format!("sleep 1000 &\necho $! > '{}'\nread line", child.display()));
    std::fs::write(&program, text).unwrap();
    scree(&["render", &scene, "-o", work.path().to_str().unwrap(), "--allow-programs"]).ok();
    let id = std::fs::read_to_string(&child).unwrap();
    let state = || std::fs::read_to_string(format!("/proc/{}/stat", id.trim())).unwrap_or_default();
    let is_there = || state().rsplit(')').next().is_some_and(|rest| !rest.is_empty() && !rest.trim().starts_with('Z'));
    for _ in 0..100 {
        if !is_there() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("the program's child still runs: {}", state());
}

#[test]
fn displays_stay_in_the_output_folder() {
    let work = scratch();
    let (scene, out) = (work.path().join("s.rib"), work.path().join("out"));
    std::fs::create_dir_all(out.join("deep")).unwrap();
    let absolute = work.path().join("absolute.png");
    let render = |name: &str, more: &[&str]| {
        let world = "WorldBegin\nSphere 1 -1 1 360\nWorldEnd\n";
        std::fs::write(&scene, format!("Format 8 8 1\nDisplay \"{name}\" \"file\" \"rgb\"\n{world}")).unwrap();
        scree(&[&["render", scene.to_str().unwrap(), "-o", out.join("deep").to_str().unwrap()], more].concat())
    };
    for name in [absolute.to_str().unwrap(), "../up.png", "a/../../up.png", "/up.png"] {
        let said = render(name, &[]).fails(3);
        assert!(said.contains("s.rib:2:1: the display") && said.contains("outside of the output folder"), "{said}");
        assert!(scree(&["check", scene.to_str().unwrap()]).fails(3).contains("outside of the output folder"));
    }
    assert!(!absolute.exists() && !out.join("up.png").exists());
    render("below/a.png", &[]).ok();
    // An input is no output, even where it is allowed to be elsewhere.
    std::fs::copy(work.path().join("s.rib"), work.path().join("kept.rib")).unwrap();
    let said = render("../../s.rib", &["--allow-outside"]).fails(3);
    assert!(said.contains("would replace a file that the scene is made of"), "{said}");
    render("../up.png", &["--allow-outside"]).ok();
    assert!(out.join("deep/below/a.png").exists() && out.join("up.png").exists());
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(work.path(), out.join("deep/link")).unwrap();
        assert!(render("link/linked.png", &[]).fails(3).contains("a link leads out of the output folder"));
        assert!(!work.path().join("linked.png").exists());
    }
}

#[test]
fn runs_and_models_name_no_files_outside() {
    let work = scratch();
    let run = work.path().join("run");
    let model = work.path().join("m.yaml");
    let text = "step: 0.01\nduration: 0.1\nframe_rate: 50\nmaterials: {m: {density: 1000, friction: 0.5}}\nbodies: [{name: ball, material: m, sphere: {radius: 0.1}}]\n";
    std::fs::write(&model, text).unwrap();
    let simulate =
        |more: &[&str]| scree(&[&["simulate", model.to_str().unwrap(), "-o", run.to_str().unwrap()], more].concat());
    simulate(&["--until", "0.05"]).ok();
    // Resuming removes frames after the checkpoint: an index that names another file must not have that removed.
    let victim = work.path().join("victim.arrow");
    std::fs::write(&victim, "mine").unwrap();
    let index = std::fs::read_to_string(run.join("run.json")).unwrap();
    for name in ["../victim.arrow", "frames/model.yaml", victim.to_str().unwrap()] {
        std::fs::write(run.join("run.json"), index.replace("frames/000002.arrow", name)).unwrap();
        for said in [simulate(&["--resume"]).fails(4), scree(&["inspect", run.to_str().unwrap()]).fails(4)] {
            assert!(said.contains("is no table in its folder"), "{said}");
        }
    }
    assert_eq!(std::fs::read_to_string(&victim).unwrap(), "mine");
    std::fs::write(&model, format!("{text}stages: [{{name: ../../up, duration: 0.1}}]\n")).unwrap();
    assert!(scree(&["check", model.to_str().unwrap()]).fails(3).contains("m.yaml:6:"));
}

/// A line of `expected.txt`.
struct Case<'a> {
    command: &'a str,
    file: &'a str,
    exit: i32,
    message: &'a str,
}

fn cases(text: &str) -> Vec<Case<'_>> {
    let case = |line: &'_ str| -> Option<(usize, usize, usize)> {
        let mut ends = line.match_indices(' ').filter(|(i, _)| !line[..*i].ends_with(' ')).map(|(i, _)| i);
        Some((ends.next()?, ends.next()?, ends.next().unwrap_or(line.len())))
    };
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let of = |line| {
        let (a, b, c) = case(line).expect("command, file, exit code, message");
        let exit = line[b..c].trim().parse().expect("an exit code");
        Case { command: &line[..a], file: line[a..b].trim(), exit, message: line[c..].trim() }
    };
    lines.map(of).collect()
}

/// Copy a folder, with what its files repeat written out.
fn expand(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().flatten() {
        let goal = to.join(entry.file_name());
        if entry.path().is_dir() {
            expand(&entry.path(), &goal);
        } else {
            std::fs::write(goal, repeated(&std::fs::read(entry.path()).unwrap())).unwrap();
        }
    }
}

fn repeated(bytes: &[u8]) -> Vec<u8> {
    if std::str::from_utf8(bytes).is_err() {
        return bytes.into();
    }
    let find = |from: usize, what: &[u8]| bytes[from..].windows(what.len()).position(|w| w == what).map(|k| from + k);
    let (mut out, mut at) = (vec![], 0);
    while let Some(start) = find(at, b"<<") {
        let (cross, end) = (find(start, b" x ").unwrap(), find(start, b">>").unwrap());
        let n = std::str::from_utf8(&bytes[start + 2..cross]).unwrap().parse().unwrap();
        out.extend_from_slice(&bytes[at..start]);
        out.extend(bytes[cross + 3..end].repeat(n));
        at = end + 2;
    }
    out.extend_from_slice(&bytes[at..]);
    out
}

/// Files that are packed, which the tree need not have.
fn packed(folder: &Path) {
    let pack = |name: &str, n: usize, keep: usize| {
        let mut packer = flate2::write::GzEncoder::new(vec![], flate2::Compression::fast());
        let part = vec![b' '; 1 << 20];
        (0..n).for_each(|_| std::io::Write::write_all(&mut packer, &part).unwrap());
        let mut bytes = packer.finish().unwrap();
        bytes.truncate(keep);
        std::fs::write(folder.join(name), bytes).unwrap();
    };
    pack("spaces.rib.gz", 1500, usize::MAX);
    pack("truncated.rib.gz", 1, 40);
}

/// Run a command on a file, with 1 GiB of address space: its exit code if it ends in time, and what it says.
fn run(case: &Case<'_>, files: &Path, work: &Path) -> (Option<i32>, String) {
    const PATIENCE: Duration = Duration::from_secs(10);
    let file = files.join(case.file);
    let more: &[&str] = match case.command {
        "render" => &["-o", "out"],
        "inspect" => &["--write", "md.yaml"],
        "movie" => &["-o", "movie.apng"],
        _ => &[],
    };
    let said = work.join("said");
    let mut child = Command::new("sh")
        .args(["-c", "ulimit -v 1048576; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_scree"), case.command])
        .arg(&file)
        .args(more)
        .current_dir(work)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(&said).unwrap())
        .spawn()
        .unwrap();
    let start = Instant::now();
    let exit = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status.code();
        }
        if start.elapsed() > PATIENCE {
            let _ = child.kill();
            let _ = child.wait();
            break None;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    (exit, String::from_utf8_lossy(&std::fs::read(said).unwrap()).into_owned())
}

/// Files within a folder, but for what commands here are asked to write.
fn strays(folder: &Path, inside: &Path) -> Vec<PathBuf> {
    let mut found = vec![];
    for path in std::fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path()) {
        if path.is_dir() && path != inside {
            found.extend(strays(&path, inside));
        } else if path.is_file() {
            found.push(path);
        }
    }
    found
}

#[cfg(target_os = "linux")]
#[test]
fn hostile_files_end_with_an_error() {
    let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hostile");
    let text = std::fs::read_to_string(home.join("expected.txt")).unwrap();
    let cases = cases(&text);
    assert!(cases.len() >= 60, "{} files", cases.len());
    let files = scratch();
    expand(&home, files.path());
    packed(&files.path().join("rib"));
    let fault = |case: &Case<'_>| {
        let work = scratch();
        let inner = work.path().join("a");
        std::fs::create_dir(&inner).unwrap();
        let (exit, said) = run(case, files.path(), &inner);
        let stray = strays(work.path(), &inner);
        let ran = inner.join("ran").exists();
        let is_right = exit == Some(case.exit) && said.contains(case.message) && stray.is_empty() && !ran;
        let mut text = String::new();
        if !is_right {
            let said: String = said.chars().take(500).collect();
            let Case { command, file, exit: expected, message } = case;
            let _ = writeln!(
                text,
                "{command} {file}: exit {exit:?}, expected {expected} and `{message}`: {stray:?}\n{said}"
            );
        }
        text
    };
    let faults: String = cases.par_iter().map(fault).collect();
    assert!(faults.is_empty(), "{faults}");
    // All files are tried.
    let tried = |path: &Path| {
        cases.iter().any(|case| {
            files.path().join(case.file).starts_with(path) || path.starts_with(files.path().join(case.file))
        })
    };
    for room in ["rib", "shader", "yaml", "data"] {
        for entry in std::fs::read_dir(files.path().join(room)).unwrap().flatten() {
            let name = entry.file_name();
            let is_part = ["p_0.csv", "painted.sl", "archive_circle_b.rib"].iter().any(|part| name == *part);
            let is_used = name
                .to_string_lossy()
                .strip_suffix(".sl")
                .is_some_and(|stem| text.contains(&format!("shader_{stem}.rib")));
            assert!(is_part || is_used || tried(&entry.path()), "{room}/{} is not tried", name.to_string_lossy());
        }
    }
}

#[test]
fn nothing_is_read_outside_of_the_root() {
    let work = scratch();
    let write = |name: &str, text: &str| {
        let path = work.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_string()
    };
    write("secret.rib", "Sphere 1 -1 1 360\n");
    write("secret.csv", "x,y,z\n0,0,0\n");
    write("secret.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    write("job/own.rib", "Sphere 1 -1 1 360\n");
    let root = work.path().join("job");
    let root = root.to_str().unwrap();
    let scene = |name: &str, archive: &str| write(name, &format!("WorldBegin\nReadArchive \"{archive}\"\nWorldEnd\n"));
    let inside = scene("job/inside.rib", "own.rib");
    let outside = scene("job/outside.rib", "../secret.rib");
    let model = write(
        "job/model.yaml",
        "step: 0.01\nduration: 0.1\nframe_rate: 50\nmaterials: {m: {density: 1000, friction: 0.5}}\nbodies: [{name: b, material: m, mesh: {file: ../secret.obj}}]\n",
    );
    let table = write(
        "job/table.yaml",
        "data: {csv: ../secret.csv}\ncamera: {eye: [0, -5, 0], look_at: [0, 0, 0]}\nobjects: [{name: a, position: [x, y, z], geometry: {sphere: {radius: 0.1}}}]\n",
    );
    scree(&["check", &inside, "--root", root]).ok();
    for (file, exit) in [(&outside, 3), (&model, 3), (&table, 4)] {
        scree(&["check", file]).ok();
        let said = scree(&["check", file, "--root", root]).fails(exit);
        assert!(said.contains("where --root keeps reading"), "{said}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(work.path().join("secret.rib"), work.path().join("job/link.rib")).unwrap();
        let link = scene("job/linked.rib", "link.rib");
        assert!(scree(&["check", &link, "--root", root]).fails(3).contains("where --root keeps reading"));
    }
    assert!(scree(&["check", &inside, "--root", "/no/such"]).fails(2).contains("there is no such folder"));
    // What the command writes itself it may read again.
    let plain = write(
        "job/plain.yaml",
        "step: 0.01\nduration: 0.04\nframe_rate: 50\nmaterials: {m: {density: 1000, friction: 0.5}}\nbodies: [{name: b, material: m, sphere: {radius: 0.1}}]\n",
    );
    let out = work.path().join("out");
    let out = out.to_str().unwrap();
    scree(&["run", &plain, "-o", out, "--root", root, "--res", "32x32", "-f", "0"]).ok();
    // What is read is listed.
    let listed = |file: &str| scree(&["check", file, "--list-files"]).ok();
    assert!(listed(&outside).contains("secret.rib") && listed(&model).contains("secret.obj"));
    assert!(listed(&table).contains("secret.csv"));
    let painted = write(
        "job/painted.rib",
        "MakeTexture \"a.png\" \"a.tex\" \"black\" \"black\" \"box\" 1 1\nWorldBegin\nSurface \"paint\" \"string map\" [\"b.png\"]\nReadArchive \"own.rib\"\nWorldEnd\n",
    );
    write("job/paint.sl", "surface paint(string map = \"\") { Ci = color texture(map) + color texture(\"a.tex\"); }");
    write("job/a.png", "x");
    write("job/b.png", "x");
    let list = listed(&painted);
    for name in ["paint.sl", "own.rib", "a.png", "b.png"] {
        assert!(list.contains(&format!("job/{name}")), "{name}: {list}");
    }
}

#[test]
fn memory_is_bounded_by_what_is_allowed() {
    let work = scratch();
    let scene = work.path().join("s.rib");
    // Each of a size of its own: of what is alike in one place one is kept.
    let spheres: String = (1..=200_000).map(|k| format!("Sphere {k} -{k} {k} 360\n")).collect();
    std::fs::write(
        &scene,
        format!("Display \"a.png\" \"file\" \"rgb\"\nFormat 8 8 1\nWorldBegin\n{spheres}WorldEnd\n"),
    )
    .unwrap();
    let check = |memory: &str| scree(&["check", scene.to_str().unwrap(), "--memory", memory]);
    let said = check("80MiB").fails(3);
    assert!(said.contains("s.rib:") && said.contains("more than 80 MiB of memory; --memory allows more"), "{said}");
    check("2GiB").ok();
    for wrong in ["5", "0GiB", "1KiB", "many"] {
        assert!(check(wrong).fails(2).contains("expected a size"), "{wrong}");
    }
}

#[test]
fn names_of_models_only_stand_in_tables() {
    let work = scratch();
    let (model, run) = (work.path().join("m.yaml"), work.path().join("run"));
    let body = "bodies: [{name: \"a,b\\\"c\\nd\", class: \"x,\\\"y\\nz\\e[2J\", material: m, sphere: {radius: 0.1}}]\nprobes: {interval: 0.01, bodies: [\"a,b\\\"c\\nd\"]}\n";
    let head = "step: 0.01\nduration: 0.1\nframe_rate: 50\nmaterials: {m: {density: 1000, friction: 0.5}}\n";
    std::fs::write(&model, format!("{head}{body}")).unwrap();
    let (model, run) = (model.to_str().unwrap(), run.to_str().unwrap());
    for format in [&[][..], &["--csv"]] {
        scree(&[&["simulate", model, "-o", run, "--fresh", "--until", "0.05"], format].concat()).ok();
        scree(&[&["simulate", model, "-o", run, "--resume"], format].concat()).ok();
        let probes = std::fs::read_to_string(work.path().join("run/probes.csv")).unwrap();
        assert_eq!(probes.lines().count(), 12, "{probes}");
        assert!(probes.contains(",\"a,b\"\"c d.x [m]\","), "{probes}");
        scree(&["plot", run]).ok();
        assert!(!scree(&["inspect", run]).ok().contains('\u{1b}'));
        scree(&["render", run, "-f", "0", "--res", "16x16"]).ok();
    }
}
