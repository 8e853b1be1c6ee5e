//! What files of others leave as it is: what links lead to, inputs, files that are no images; and what is made of runs and shards that
//! lie: nothing.

use crate::cli::{scratch, scree};
use std::process::Command;

/// A model of a ball above the ground, without what it is to have besides.
const BALL: &str = "step: 0.01\nduration: 0.1\nframe_rate: 50\nmaterials: {m: {density: 1000, friction: 0.5}}\nbodies: [{name: ground, material: m, plane: {normal: [0, 0, 1]}}, {name: ball, material: m, sphere: {radius: 0.1}, position: [0, 0, 0.1]}]\n";

#[cfg(unix)]
#[test]
fn links_lead_no_run_out_of_its_folder() {
    use std::os::unix::fs::symlink;
    let work = scratch();
    let (model, run, beyond) = (work.path().join("m.yaml"), work.path().join("run"), work.path().join("beyond"));
    std::fs::write(&model, BALL).unwrap();
    let (model, home) = (model.to_str().unwrap(), run.to_str().unwrap());
    scree(&["simulate", model, "-o", home, "--until", "0.05"]).ok();
    for part in ["frames", "checkpoints", "contacts", "images", "plots"] {
        let _ = std::fs::remove_dir_all(&beyond);
        let own = run.join(part);
        std::fs::create_dir_all(&own).unwrap();
        std::fs::rename(&own, &beyond).unwrap();
        std::fs::write(beyond.join("precious.csv"), "mine").unwrap();
        symlink("../beyond", &own).unwrap();
        let before = std::fs::read_dir(&beyond).unwrap().count();
        let writers: &[&[&str]] = match part {
            "images" => &[&["render", home, "-f", "0", "--res", "16x16"], &["run", model, "-o", home]],
            "plots" => &[&["plot", home]],
            _ => &[&["simulate", model, "-o", home, "--resume"], &["simulate", model, "-o", home, "--fresh"]],
        };
        for writer in writers {
            let said = scree(writer).fails(2);
            assert!(said.contains("a link leads out of"), "{writer:?}: {said}");
        }
        assert_eq!(std::fs::read_dir(&beyond).unwrap().count(), before, "{part}");
        std::fs::remove_file(&own).unwrap();
        std::fs::remove_file(beyond.join("precious.csv")).unwrap();
        std::fs::rename(&beyond, &own).unwrap();
    }
    scree(&["simulate", model, "-o", home, "--resume"]).ok();
}

/// A finished run that has lost frames since is not simulated again unasked: the others are drawn, and it is said how it is repaired.
#[test]
fn a_finished_run_that_lost_frames_is_drawn_without_them() {
    let work = scratch();
    let (model, run) = (work.path().join("m.yaml"), work.path().join("run"));
    std::fs::write(&model, BALL).unwrap();
    let (model, home) = (model.to_str().unwrap(), run.to_str().unwrap());
    let draw = |more: &[&str]| scree(&[&["run", model, "-o", home, "--res", "16x16", "--samples", "1"], more].concat());
    scree(&["simulate", model, "-o", home]).ok();
    let sound = std::fs::read(run.join("frames/000003.arrow")).unwrap();
    std::fs::write(run.join("frames/000003.arrow"), &sound[..sound.len() / 2]).unwrap();
    std::fs::remove_file(run.join("frames/000001.arrow")).unwrap();
    let said = draw(&[]).fails(5);
    let repairs = format!("2 frames from 1 to 3 of {home} are lost or damaged: `scree run {model} -o {home} --fresh`");
    assert!(said.contains(&repairs) && said.contains("2 of 5 frames could not be rendered (1, 3)"), "{said}");
    assert!(!said.contains("simulating"), "{said}");
    assert_eq!(crate::cli::images(&run.join("images")).len(), 3);
    draw(&["-f", "0"]).ok();
    // What goes on from its checkpoint needs them.
    let said = scree(&["simulate", model, "-o", home, "--resume"]).fails(4);
    assert!(said.contains("frames/000001.arrow"), "{said}");
    // Of a run without a frame that can be read, nothing is done.
    let frames = || std::fs::read_dir(run.join("frames")).unwrap().flatten().map(|entry| entry.path());
    frames().for_each(|path| std::fs::write(path, &sound[..99]).unwrap());
    let said = draw(&["--redraw"]).fails(4);
    assert!(said.contains("none of the 5 frames can be read; frame 0: "), "{said}");
    let said = draw(&["--fresh"]);
    said.ok();
    assert!(said.errors().contains("which is simulated again\n"), "{}", said.errors());
    assert!(
        crate::cli::images(&run.join("images")).len() == 5
            && sound == std::fs::read(run.join("frames/000003.arrow")).unwrap()
    );
}

#[test]
fn inputs_are_not_replaced_by_what_is_made_of_them() {
    let work = scratch();
    let path = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let metadata = "data: {csv: t.csv}\ncamera: {eye: [0, -5, 0], look_at: [0, 0, 0]}\nobjects: [{name: a, position: [x, y, z], geometry: {sphere: {radius: 1}}}]\n";
    let files = [
        ("t.csv", "x,y,z\n0,0,0\n"),
        ("md.yaml", metadata),
        ("s.rib", "Format 8 8 1\nDisplay \"s.rib\" \"file\" \"rgb\"\nWorldBegin\nWorldEnd\n"),
        ("other.rib", "Format 8 8 1\nDisplay \"t.csv\" \"file\" \"rgb\"\nWorldBegin\nWorldEnd\n"),
    ];
    files.iter().for_each(|(name, text)| std::fs::write(path(name), text).unwrap());
    for name in ["t.csv", "md.yaml", "nd/../t.csv", "nd/../md.yaml"] {
        let said = scree(&["rib", &path("md.yaml"), "-f", "0", "-o", &path(name)]).fails(2);
        assert!(said.contains("is one of the files that the frame is made of"), "{said}");
    }
    let said = scree(&["rib", &path("md.yaml"), "-f", "0", "-o", &path("other.yaml")]);
    said.ok();
    std::fs::write(path("other.yaml"), "mine: 1\n").unwrap();
    let said = scree(&["rib", &path("md.yaml"), "-f", "0", "-o", &path("nd/../other.yaml")]).fails(2);
    assert!(said.contains("is a file that is no RIB"), "{said}");
    for name in ["t.csv", "other.yaml"] {
        let said = scree(&["inspect", &path("t.csv"), "--write", &path(&format!("nd/../{name}"))]).fails(2);
        assert!(said.contains("may have been edited"), "{said}");
    }
    std::fs::remove_file(path("other.yaml")).unwrap();
    let home = path("");
    let said = scree(&["render", &path("s.rib"), "-o", &home]).fails(3);
    assert!(said.contains("would replace a file that the scene is made of"), "{said}");
    assert!(scree(&["render", &path("other.rib"), "-o", &home]).fails(3).contains("is a file that is no image"));
    #[cfg(target_os = "linux")]
    {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scree"));
        command.args(["render", "-"]).current_dir(work.path()).stdin(std::fs::File::open(path("s.rib")).unwrap());
        assert_eq!(command.output().unwrap().status.code(), Some(3));
    }
    for (name, text) in files {
        assert_eq!(std::fs::read_to_string(path(name)).unwrap(), text, "{name}");
    }
}

#[test]
fn shards_that_lie_make_no_image() {
    let work = scratch();
    let path = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let scene = "Format 8 8 1\nDisplay \"a.png\" \"file\" \"rgb\"\nWorldBegin\nWorldEnd\n";
    std::fs::write(path("s.rib"), scene).unwrap();
    let home = path("");
    scree(&["render", &path("s.rib"), "-o", &home, "--bucket", "1/1"]).ok();
    let shard = path("a.png.part-1-of-1");
    let sound = std::fs::read(&shard).unwrap();
    let end = sound.iter().position(|b| *b == b'\n').unwrap();
    let header = String::from_utf8(sound[..end].to_vec()).unwrap();
    let lies = [
        ("\"width\":8", "\"width\":0", "describes no image"),
        ("\"height\":8", "\"height\":18446744073709551615", "describes no image"),
        ("\"one\":255", "\"one\":127", "truncated or changed"),
        ("\"scree_part\":4", "\"scree_part\":3", "another version"),
    ];
    for (from, to, message) in lies {
        assert!(header.contains(from), "{header}");
        let lie = header.replace(from, to);
        std::fs::write(&shard, [lie.as_bytes(), &sound[end..]].concat()).unwrap();
        let said = scree(&["stitch", &home]).fails(4);
        assert!(said.contains(message), "{to}: {said}");
    }
    // Names of no image, and of more shards than there are.
    std::fs::remove_file(&shard).unwrap();
    for (name, exit, message) in [
        ("s.rib.part-1-of-1", 3, "is a file that is no image"),
        ("a.png.part-1-of-1000000000", 4, "there are no shard files"),
        ("a.png.part-0-of-1", 4, "there are no shard files"),
    ] {
        std::fs::write(path(name), &sound).unwrap();
        let said = scree(&["stitch", &home]).fails(exit);
        assert!(said.contains(message), "{name}: {said}");
        std::fs::remove_file(path(name)).unwrap();
    }
    assert_eq!(std::fs::read_to_string(path("s.rib")).unwrap(), scene);
    std::fs::write(&shard, &sound).unwrap();
    scree(&["stitch", &home]).ok();
}

/// A manifold of two shapes with a number of points.
fn manifold(end: u32, shapes: [u32; 2]) -> sim::manifolds::Kept {
    let (position, orientation) = (glam::DVec3::X, glam::DQuat::IDENTITY);
    let corners = Default::default();
    sim::manifolds::Kept {
        pair: 0,
        end,
        shapes,
        position,
        orientation,
        axis: position,
        corners,
        reach: 0.1,
        gap: 0.0,
        slack: 0.0,
    }
}

#[test]
fn checkpoints_that_lie_resume_nothing() {
    use sim::{State, checkpoint};
    let work = scratch();
    let (model, run) = (work.path().join("m.yaml"), work.path().join("run"));
    std::fs::write(&model, BALL).unwrap();
    let (model, home) = (model.to_str().unwrap(), run.to_str().unwrap());
    scree(&["simulate", model, "-o", home, "--until", "0.05"]).ok();
    let path = checkpoint::latest(&run).unwrap().unwrap();
    let (state, of) = checkpoint::read(&path).unwrap();
    assert!(!state.contacts.is_empty() && state.fat_aabb.is_some());
    let lies: [(&str, fn(&mut State)); 10] = [
        ("bodies", |s| s.activity.clear()),
        ("nowhere", |s| s.position[1].z = 1e300),
        ("nowhere", |s| s.orientation[1] *= 2.0),
        ("not around it", |s| s.fat_aabb.as_mut().unwrap()[1].max.x = -1e30),
        ("expected the model's", |s| s.fat_aabb.as_mut().unwrap().clear()),
        ("a contact 0", |s| s.contacts.key[0][1] = 77),
        ("a contact 0", |s| s.contacts.law[0] = 77),
        ("different lengths", |s| s.contacts.gap.clear()),
        ("manifolds of part 0", |s| s.manifolds.parts[0].kept.push(manifold(1, [0, 77]))),
        ("manifolds of part 0", |s| s.manifolds.parts[0].kept.push(manifold(1, [0, 1]))),
    ];
    for (message, lie) in lies {
        let mut state = state.clone();
        lie(&mut state);
        checkpoint::write(&path, &state, &of).unwrap();
        let said = scree(&["simulate", model, "-o", home, "--resume"]).fails(4);
        assert!(said.contains(message) && said.contains(".state"), "{message}: {said}");
    }
    checkpoint::write(&path, &state, &of).unwrap();
    scree(&["simulate", model, "-o", home, "--resume"]).ok();
}
