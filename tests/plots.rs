//! `scree plot`: what stands in plots, read from the SVG, of runs, sweeps and tables.

use crate::cli::{scratch, scree};
use std::path::{Path, PathBuf};

/// Write the probes of a run.
fn write_run(folder: &Path, header: &str, row: impl Fn(f64) -> String) {
    std::fs::create_dir_all(folder).unwrap();
    let rows: Vec<String> = (0..50).map(|i| format!("{},{}", i as f64 * 0.01, row(i as f64 * 0.01))).collect();
    std::fs::write(folder.join("probes.csv"), format!("time [s],{header}\n{}\n", rows.join("\n"))).unwrap();
}

/// Plot, and give the folder of the plots.
fn plot(run: &Path, more: &[&str]) -> PathBuf {
    scree(&[&["plot", run.to_str().unwrap()], more].concat()).ok();
    run.join("plots")
}

/// The texts of a plot.
fn texts(plots: &Path, name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(plots.join(format!("{name}.svg"))).unwrap_or_else(|e| panic!("{name}: {e}"));
    let texts = text.split("<text").skip(1).map(|t| t.split_once('>').unwrap().1.split_once("</text>").unwrap().0);
    texts.map(|t| t.trim().to_string()).collect()
}

fn has(texts: &[String], text: &str) -> bool {
    texts.iter().any(|t| t == text)
}

/// The name of the note's text.
fn note(texts: &[String]) -> Option<&String> {
    texts.iter().find(|t| t.starts_with("Outside the vertical range"))
}

#[test]
fn curves_and_axes_are_named() {
    let work = scratch();
    let run = work.path().join("swing");
    let header = "hinge.fx [N],hinge.fy [N],hinge.angle [rad],still,odd [m]";
    write_run(&run, header, |t| {
        format!("{},{},{},7,{}", 3e-7 * t, -2e-7 * t, t.sin(), if t < 0.3 { "nan" } else { "1" })
    });
    let plots = plot(&run, &[]);
    let forces = texts(&plots, "hinge_N");
    for text in ["hinge  (swing)", "fx", "fy", "time [s]", "[1e−9 N]", "0.05", "0", "−50", "150"] {
        assert!(has(&forces, text), "{text} in {forces:?}");
    }
    // A single curve is named, too.
    let angle = texts(&plots, "hinge_rad");
    assert!(has(&angle, "angle") && has(&angle, "angle [rad]"), "{angle:?}");
    let still = texts(&plots, "still_number");
    assert!(has(&still, "still [-]") && has(&still, "7") && note(&still).is_none(), "{still:?}");
    let odd = texts(&plots, "odd_m");
    assert!(has(&odd, "odd"), "{odd:?}");
    let png = image::open(plots.join("hinge_N.png")).unwrap();
    assert_eq!((png.width(), png.height()), (1200, 700));
}

#[test]
fn tables_of_others_are_plotted_by_their_own_names_and_units() {
    let work = scratch();
    let write = |name: &str, text: &str| {
        let path = work.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let path = write("one.csv", "time [ms],a\n0,1\n1000,2\n2000,3\n");
    let plots = work.path().join("plots");
    scree(&["plot", path.to_str().unwrap()]).ok();
    let axis = texts(&plots, "one_a_number");
    assert!(has(&axis, "time [s]") && has(&axis, "2.0") && !has(&axis, "2000"), "{axis:?}");
    let other = write("two.csv", "time,a\n0,1\n1,2\n");
    scree(&["plot", other.to_str().unwrap()]).ok();
    assert!(plots.join("one_a_number.png").exists() && plots.join("two_a_number.png").exists());
    for name in ["Time", "t", "TIME [s]", "Time (s)"] {
        let other = write("three.csv", &format!("{name},a\n0,1\n1,2\n"));
        scree(&["plot", other.to_str().unwrap()]).ok();
        assert!(plots.join("three_a_number.png").exists(), "{name}");
        std::fs::remove_file(plots.join("three_a_number.png")).unwrap();
    }
    for (table, says) in [
        ("time,a\n1,1\n0,2\n", "goes back from 1 to 0 s in row 2"),
        ("time [year],a\n1,1\n", "has the unit [year]"),
        ("time,a\n0,x\n1,y\n", "has no columns of numbers beside the times"),
        ("x,a\n0,1\n", "has no column of times, `time` or `t`"),
    ] {
        assert!(scree(&["plot", write("bad.csv", table).to_str().unwrap()]).fails(4).contains(says), "{says}");
    }
    let empty = scree(&["plot", write("empty.csv", "time,a\n0,NaN\n1,NaN\n").to_str().unwrap()]);
    empty.ok();
    assert!(empty.errors().contains("has no values: its plot is empty"), "{}", empty.errors());
}

#[test]
fn a_spike_at_the_start_is_clipped_and_said() {
    let work = scratch();
    let run = work.path().join("run");
    write_run(&run, "a.fx [N],b.fx [N]", |t| {
        let (first, later) = (if t == 0.0 { 5000.0 } else { 10.0 + t }, if t == 0.2 { 5000.0 } else { 10.0 + t });
        format!("{first},{later}")
    });
    let plots = plot(&run, &[]);
    let spike = texts(&plots, "a_N");
    assert_eq!(
        note(&spike).unwrap(),
        "Outside the vertical range: the first instant, t = 0 s (fx = 5000 N). --full-range shows it."
    );
    assert!(has(&spike, "10.40") && !has(&spike, "5000"), "{spike:?}");
    let outlier = texts(&plots, "b_N");
    assert!(has(&outlier, "5000") && note(&outlier).is_none(), "{outlier:?}");
    let full = texts(&plot(&run, &["--full-range"]), "a_N");
    assert!(has(&full, "5000") && note(&full).is_none(), "{full:?}");
    // Later instants are no start.
    let later = texts(&plot(&run, &["--times", "0.1-0.3"]), "b_N");
    assert!(has(&later, "5000") && note(&later).is_none(), "{later:?}");
}

#[test]
fn curves_without_values_and_of_one_instant_are_plotted() {
    let work = scratch();
    let run = work.path().join("run");
    write_run(&run, "none [N],all [N]", |_| "nan,1".into());
    let none = texts(&plot(&run, &["none"]), "none_N");
    assert!(has(&none, "none (no finite value)") && has(&none, "no finite value"), "{none:?}");
    let one = plot(&run, &["all", "--times", "0.095-0.105"]);
    assert!(std::fs::read_to_string(one.join("all_N.svg")).unwrap().contains("<circle"));
    let said = scree(&["plot", run.to_str().unwrap(), "--times", "5-6"]).fails(2);
    assert!(said.contains("no instant in this interval; the data has 0 to 0.49 s"), "{said}");
    let said = scree(&["plot", run.to_str().unwrap(), "--times", "2-0.5"]).fails(2);
    assert!(said.contains("swapped") && said.contains("0.5-2"), "{said}");
    assert!(scree(&["plot", work.path().join("no").to_str().unwrap()]).fails(4).contains("does not exist"));
}

#[test]
fn runs_of_a_sweep_are_overlaid() {
    let work = scratch();
    let sweep = work.path().join("sweep");
    for friction in [0.1, 0.25, 10.0] {
        let run = sweep.join(format!("gravity=0_0_-9.81_friction={friction}"));
        write_run(&run, "hinge.fx [N],block.vx [m/s]", |t| format!("{},{}", friction * t, t));
    }
    let plots = plot(&sweep, &["hinge"]);
    let found = texts(&plots, "hinge_fx_N");
    for text in ["hinge.fx", "fx [N]", "friction=0.1", "friction=0.25", "friction=10"] {
        assert!(has(&found, text), "{text} in {found:?}");
    }
    let place = |text: &str| found.iter().position(|t| t == text);
    assert!(place("friction=0.25") < place("friction=10"), "{found:?}");
    assert!(!plots.join("block_vx_m_s.svg").exists());
    // One more run, which has not all of the columns.
    let other = work.path().join("other");
    write_run(&other, "block.vx [m/s]", |t| format!("{}", 2.0 * t));
    let call = ["plot", sweep.to_str().unwrap(), "--with", other.to_str().unwrap()];
    let said = scree(&call);
    said.ok();
    assert!(said.errors().contains("other has no column `hinge.fx`"), "{}", said.errors());
    let found = texts(&plots, "block_vx_m_s");
    assert!(has(&found, "other") && has(&found, "gravity=0_0_-9.81, friction=0.1"), "{found:?}");
    write_run(&other, "block.vx [km/h]", |t| format!("{t}"));
    let said = scree(&call).fails(4);
    assert!(said.contains("`block.vx` has the unit [km/h] in") && said.contains("[m/s]"), "{said}");
    let nothing = work.path().join("nothing");
    std::fs::create_dir(&nothing).unwrap();
    assert!(scree(&["plot", nothing.to_str().unwrap()]).fails(4).contains("is no run directory"));
}

#[test]
fn many_curves_go_into_several_plots_and_tables_are_plotted() {
    let work = scratch();
    let header: Vec<String> = (0..15).map(|i| format!("sum.c{i} [J]")).collect();
    write_run(work.path(), &header.join(","), |t| vec![t.to_string(); 15].join(","));
    let table = work.path().join("probes.csv");
    scree(&["plot", table.to_str().unwrap()]).ok();
    let plots = work.path().join("plots");
    let (first, second) = (texts(&plots, "sum_J_1"), texts(&plots, "sum_J_2"));
    assert!(has(&first, "sum  (probes.csv), 1 of 2") && has(&first, "c11") && !has(&first, "c12"), "{first:?}");
    assert!(has(&second, "c12") && has(&second, "c14"), "{second:?}");
    std::fs::write(&table, "x,y\n1,2\n").unwrap();
    assert!(scree(&["plot", table.to_str().unwrap()]).fails(4).contains("no column of times, `time` or `t`"));
}
