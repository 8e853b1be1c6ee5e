//! Programs and objects of scenes that have no end of their own.

use crate::cli::{scratch, scree};
use crate::rendering::ORTHO;

#[test]
fn programs_that_answer_without_end_are_said() {
    // RISpec 5.8: a program's answer is RIB, which may ask the program again. One asks for itself in each answer, one twice, one never
    // ends its answer.
    let work = scratch();
    let place = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let asks = |times: usize| {
        let ask =
            format!("Procedural \\\"RunProgram\\\" [ \\\"{}\\\" \\\"x\\\" ] [-1 1 -1 1 -1 1] ", place("again.sh"));
        format!("#!/bin/sh\nwhile read -r line; do printf '%s\\377' \"{}\"; done\n", ask.repeat(times))
    };
    // A request that is longer than a pipe holds.
    let request = "x".repeat(1 << 20);
    for (script, said) in [
        ("#!/bin/sh\nexec sleep 100\n".into(), "gave no answer within 2 s; --program-seconds gives it more"),
        ("#!/bin/sh\nwhile true; do printf x; sleep 0.1; done\n".into(), "gave no answer within 2 s"),
        (asks(1), "ask each other more than 32 deep"),
        (asks(2), "ask each other more than 32 deep"),
        ("#!/bin/sh\nexec yes\n".into(), "answers without end"),
    ] {
        std::fs::write(place("again.sh"), &script).unwrap();
        #[cfg(unix)]
        std::fs::set_permissions(place("again.sh"), std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
        let asked = if script.contains("sleep") { request.as_str() } else { "x" };
        let world = format!("Procedural \"RunProgram\" [\"{}\" \"{asked}\"] [-1 1 -1 1 -1 1]", place("again.sh"));
        std::fs::write(
            place("t.rib"),
            format!("Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\n{world}\nWorldEnd\n"),
        )
        .unwrap();
        let begun = std::time::Instant::now();
        let allowed = ["--allow-programs", "--program-seconds", "2"];
        let answer = scree(&[&["render", &place("t.rib"), "-o", &place("")], &allowed[..]].concat());
        let errors = answer.errors();
        assert!(errors.contains(said), "{script}: {}", &errors[..errors.len().min(2000)]);
        assert!(begun.elapsed().as_secs() < 60, "{script}: {:?}", begun.elapsed());
    }
}

/// RISpec 5.7 sets no end to objects within objects: ten of ten of ten … are many soon.
#[test]
fn objects_of_objects_have_an_end() {
    let work = scratch();
    let place = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let objects = |levels: usize| {
        let instances = |k: usize| format!("ObjectInstance {k} ").repeat(10);
        let object = |k: usize| format!("ObjectBegin {} {} ObjectEnd\n", k + 1, instances(k));
        let all: String = (1..=levels).map(object).collect();
        format!("ObjectBegin 1 Sphere .1 -.1 .1 360 ObjectEnd\n{all}ObjectInstance {}\n", levels + 1)
    };
    for (levels, expected) in
        [(4, None), (12, Some("t.rib:11:32: the object `8` is made of objects with more than 1048576 parts"))]
    {
        let text = format!("Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\n{}WorldEnd\n", objects(levels));
        std::fs::write(place("t.rib"), text).unwrap();
        let answer = scree(&["render", &place("t.rib"), "-o", &place("")]);
        match expected {
            Some(said) => {
                let errors = answer.fails(3);
                assert!(errors.contains(said), "{errors}");
            }
            None => {
                answer.ok();
            }
        }
    }
}
