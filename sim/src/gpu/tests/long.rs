//! What takes minutes on a software adapter: `tests/gpu_full.sh` runs it.

use super::whole::{on_device, settings};
use crate::Method;
use crate::simulation::Simulation;
use crate::workload::{self, Workload, build};
use glam::DVec3;

/// No submission of the first steps of large beds takes longer than half a second, though nothing is known of their times. `tests/gpu_full.sh`
/// runs it, on a machine that does nothing else.
#[test]
#[ignore = "takes minutes on a software adapter"]
fn submissions_of_large_beds_are_short() {
    let (spheres, solids) = (100_000, 10_000);
    for method in [Method::Apgd, Method::GaussSeidel] {
        let bed_of_solids = workload::mixed(solids).simulation().unwrap();
        let (mut of_solids, mut state) = (bed_of_solids.model, bed_of_solids.state);
        // Drawn together, until neighbours touch.
        state.position.iter_mut().for_each(|p| *p *= 0.7);
        of_solids.solver = workload::solver(method, 20);
        let (of_spheres, drawn) = build(Workload::S, spheres, workload::solver(method, 20), 1.5e-3);
        let mut drawn = drawn;
        for b in (0..of_spheres.n_bodies()).filter(|b| of_spheres.inv_mass[*b] > 0.0) {
            drawn.position[b] *= 0.955;
        }
        for (name, (model, state)) in [("spheres", (of_spheres, drawn)), ("solids", (of_solids, state))] {
            let Some(mut own) = on_device(&model, &state) else { return };
            let mut contacts = 0;
            for _ in 0..4 {
                contacts = own.step().contacts;
            }
            let longest = own.device_usage().unwrap().longest_submission;
            eprintln!("{method:?}, {name}: {contacts} contacts, {longest:.3} s");
            assert!(longest <= 0.5, "{method:?}, {name}: {longest} s");
        }
    }
}

/// `tests/gpu_full.sh` runs it.
#[test]
#[ignore = "takes minutes on a software adapter"]
fn a_bed_settles_as_on_the_cpu() {
    for method in [Method::GaussSeidel, Method::Apgd, Method::Jacobi] {
        let (mut model, state) = build(Workload::S, 2000, settings(method, 50, 1e-7), 1e-3);
        model.solver.recovery_speed = 0.3;
        let Some(mut own) = on_device(&model, &state) else { return };
        let mut cpu = Simulation::new(model, state);
        let mut worst = [0.0f64; 2];
        for _ in 0..500 {
            let reports = [own.step(), cpu.step()];
            for (worst, report) in worst.iter_mut().zip(&reports) {
                *worst = worst.max(report.worst_penetration);
                assert!(report.broken.is_none(), "{report:?}");
            }
        }
        own.fetch().unwrap();
        let grains = |s: &Simulation| -> Vec<DVec3> {
            (0..s.model.n_bodies()).filter(|b| s.state.moves(*b)).map(|b| s.state.position[b]).collect()
        };
        let mean = |s: &Simulation| grains(s).iter().sum::<DVec3>() / 2000.0;
        let height = |s: &Simulation| grains(s).iter().map(|p| p.z).fold(0.0, f64::max);
        let (centres, heights) = ([&own, &cpu].map(mean), [&own, &cpu].map(height));
        let potential = [&own, &cpu].map(|s| s.state.potential_energy(&s.model));
        eprintln!("{method:?}: centres {centres:?}, heights {heights:?}, potential {potential:?}, worst {worst:?}");
        assert!((centres[0] - centres[1]).length() < 0.01 * centres[1].z, "{method:?}: {centres:?}");
        assert!((heights[0] / heights[1] - 1.0).abs() < 0.01, "{method:?}: {heights:?}");
        assert!((potential[0] / potential[1] - 1.0).abs() < 0.01, "{method:?}: {potential:?}");
        assert!(worst[0] < 1.2 * worst[1] + 1e-4, "{method:?}: {worst:?}");
    }
}
