//! Files of others: opening them runs no programs and writes nothing outside of the folder that was named.

use crate::cli::{scratch, scree};
use std::path::Path;

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
    for name in ["../victim.arrow", victim.to_str().unwrap()] {
        std::fs::write(run.join("run.json"), index.replace("frames/000002.arrow", name)).unwrap();
        for said in [simulate(&["--resume"]).fails(4), scree(&["inspect", run.to_str().unwrap()]).fails(4)] {
            assert!(said.contains("outside of the folder"), "{said}");
        }
    }
    assert_eq!(std::fs::read_to_string(&victim).unwrap(), "mine");
    std::fs::write(&model, format!("{text}stages: [{{name: ../../up, duration: 0.1}}]\n")).unwrap();
    assert!(scree(&["check", model.to_str().unwrap()]).fails(3).contains("m.yaml:6:"));
}
