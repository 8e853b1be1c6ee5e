//! Frames written as files of other programs.

use crate::cli::{scratch, scree};

#[test]
fn exports_are_tables_again() {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    for i in [3, 4, 12] {
        let text = format!("x,y,z,radius,vel_x,vel_y,vel_z,kind\n0,0,{i},0.1,1,2,3,stone\n0.5,0,1,0.2,0,0,0,brick\n");
        std::fs::write(work.path().join(format!("p_{i}.csv")), text).unwrap();
    }
    for (format, pattern) in
        [("vtu", "p.pvd"), ("vtu", "*.vtu"), ("ply", "*.ply"), ("parquet", "*.parquet"), ("csv", "*.csv")]
    {
        let folder = at(&format!("as {format}"));
        scree(&["export", &at("p_*.csv"), "--to", format, "-o", &folder]).ok();
        let said = scree(&["inspect", &format!("{folder}/{pattern}"), "-f", "12"]).ok();
        assert!(said.contains("3 frames from 3 to 12") && said.contains("1 to 12"), "{format}: {said}");
        assert!(said.contains("vel_y") && said.contains("radius"), "{format}: {said}");
    }
    // Inputs, runs and frames that cannot be written.
    assert!(scree(&["export", &at("p_*.csv"), "--to", "obj"]).fails(2).contains("vtu"));
    assert!(scree(&["export", &at("p_*.csv"), "--to", "vtu", "-f", "5"]).fails(2).contains("--frames"));
    std::fs::write(work.path().join("p_000004.csv"), "x,y,z\n1,2,3\n").unwrap();
    std::fs::remove_file(work.path().join("p_4.csv")).unwrap();
    scree(&["export", &at("p_*.csv"), "--to", "csv", "-o", work.path().to_str().unwrap()]).fails(2);
    assert_eq!(std::fs::read_to_string(work.path().join("p_000004.csv")).unwrap(), "x,y,z\n1,2,3\n");
    std::fs::write(work.path().join("p_12.csv"), "x,y,z\n1,2\n").unwrap();
    let said = scree(&["export", &at("p_*.csv"), "--to", "vtu", "-o", &at("rest")]).fails(5);
    assert!(said.contains("1 of 3 frames could not be exported (12)"), "{said}");
    assert!(work.path().join("rest/p_000003.vtu").is_file() && !work.path().join("rest/p_000012.vtu").exists());
}
