//! What shall rest rests: beds that a step cannot solve to the end, runs based on them, and light chains under heavy loads.

use crate::analytic::simulation;
use crate::cli::{scratch, scree};
use sim::{Simulation, workload};

/// A bed of 300 spheres in a narrow shaft, 30 layers deep. Its loose grains roll on between the others for 1.8 to 4.1 s
/// (31 of 32 such beds).
const SHAFT: &str = "step: 1e-3
seed: 3
materials: {m: {density: 2500, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: east, material: m, plane: {normal: [-1, 0, 0]}, position: [0.17, 0, 0]}
  - {name: west, material: m, plane: {normal: [1, 0, 0]}, position: [-0.17, 0, 0]}
  - {name: north, material: m, plane: {normal: [0, -1, 0]}, position: [0, 0.17, 0]}
  - {name: south, material: m, plane: {normal: [0, 1, 0]}, position: [0, -0.17, 0]}
fills:
  - {name: grains, material: m, count: 300, radius: [0.045, 0.055], min: [-0.17, -0.17, 0], max: [0.17, 0.17, 12]}
";

/// The mean speed of the bodies that move, m/s, but for the fastest hundredth, which may be loose, and the error of the vertical force on those
/// that do not move over the weight.
fn unrest(sim: &Simulation) -> (f64, f64) {
    let (model, state) = (&sim.model, &sim.state);
    let moving: Vec<usize> = (0..model.n_bodies()).filter(|b| model.inv_mass[*b] > 0.0).collect();
    let weight = moving.iter().map(|b| 9.81 / model.inv_mass[*b]).sum::<f64>();
    let mut speeds: Vec<f64> = moving.iter().map(|b| state.velocity[*b].length()).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.truncate((99 * speeds.len()).div_ceil(100));
    let speed = speeds.iter().sum::<f64>() / speeds.len() as f64;
    let held = |b: u32| model.inv_mass[b as usize] == 0.0;
    let force = (0..state.contacts.len()).map(|i| match state.contacts.bodies[i].map(held) {
        [true, false] => state.contacts.impulse[i].z,
        [false, true] => -state.contacts.impulse[i].z,
        _ => 0.0,
    });
    (speed, (force.sum::<f64>() / model.step / weight - 1.0).abs())
}

#[test]
fn a_deep_bed_comes_to_rest_with_few_iterations() {
    for solver in
        ["method: apgd", "method: barzilai_borwein", "method: gauss_seidel", "method: gauss_seidel, friction: exact"]
    {
        let mut sim = simulation(&format!("solver: {{{solver}, iterations: 50}}\n{SHAFT}"));
        (0..5_500).for_each(|_| drop(sim.step()));
        for _ in 0..500 {
            sim.step();
            let (speed, force) = unrest(&sim);
            assert!(speed <= 1e-4 && force <= 1e-3, "{solver}: {speed:.1e} m/s, {force:.1e} of the weight");
        }
        assert!(sim.state.contacts.worst_penetration() < 1e-4, "{solver}");
    }
}

#[test]
fn the_layers_of_a_bed_do_not_sink_into_each_other_while_it_lands() {
    // A thousand grains that fall from up to nine metres, by methods that fifty iterations do not take to the solution.
    let bed = SHAFT.replace("0.17", "0.28").replace("count: 300", "count: 1000").replace("12]", "9]");
    let deepest_of = |bed: &str, solver: &str| {
        let mut sim = simulation(&format!("solver: {{{solver}, friction: exact, iterations: 50}}\n{bed}"));
        (0..1_200).map(|_| sim.step().worst_penetration).fold(0.0, f64::max)
    };
    let deepest = |solver: &str| deepest_of(&bed, solver);
    // Three hundred, beside a pendulum and one that is by far heavier: what decides is that the bed lands.
    let beside = "fills:";
    let with = "  - {name: bob, material: m, box: {size: [0.1, 0.1, 0.1]}, position: [0, 0, 13]}
  - {name: anvil, material: iron, box: {size: [0.3, 0.3, 2]}, position: [0, 0, 30]}
joints:
  - {name: string, kind: spherical, a: world, b: bob, position: [0, 0, 14]}
fills:";
    let shaft = SHAFT.replace(beside, with).replace("}\nbodies", ", iron: {density: 8000, friction: 0.5}}\nbodies");
    for method in ["apgd", "jacobi"] {
        let depth = deepest_of(&shaft, &format!("method: {method}"));
        assert!(depth < 2e-3, "shaft, {method}: {depth:.1e} m");
    }
    for method in ["apgd", "barzilai_borwein", "jacobi"] {
        let depth = deepest(&format!("method: {method}"));
        assert!(depth < 1e-3, "{method}: {depth:.1e} m");
    }
    let alone = deepest("method: barzilai_borwein, sweep_landings: false");
    assert!(alone > 2e-3, "the bed tells nothing: {alone:.1e} m");
}

/// What falls on a bed between walls does not get energy back, however few sweeps each step has: the impulses of the impact are not those of the
/// step after it.
#[test]
fn a_ball_that_hits_a_confined_bed_gains_no_energy() {
    for (solver, most) in
        [("friction: exact", 1e-3), ("friction: relaxed", 1e-3), ("friction: exact, method: gauss_seidel", 2e-2)]
    {
        let ball = "  - {name: ball, material: m, mass: 1000, sphere: {radius: 0.16}, position: [0, 0, 12.5], velocity: [0, 0, -9]}\nfills:";
        let mut sim = simulation(&format!("solver: {{{solver}}}\n{}", SHAFT.replace("fills:", ball)));
        let energy = |sim: &Simulation| sim.state.kinetic_energy(&sim.model) + sim.state.potential_energy(&sim.model);
        let before = energy(&sim);
        let (mut least, mut gained) = (before, 0.0f64);
        for _ in 0..1_500 {
            sim.step();
            let now = energy(&sim);
            gained = gained.max(now - least);
            least = least.min(now);
        }
        let lost = before - least;
        assert!(gained < most * lost && lost > 1e4, "{solver}: {gained:.1} J of {lost:.1} J come back");
    }
}

/// A plate on a bed, three thousand times as heavy as a grain, weighs what it weighs by methods that the iterations do not take to the solution.
#[test]
fn a_load_on_a_bed_comes_to_rest() {
    let plate = "  - {name: plate, material: m, mass: 3000, box: {size: [0.3, 0.3, 0.1]}, position: [0, 0, 3.95]}
joints:
  - {name: guide, kind: prismatic, a: world, b: plate, position: [0, 0, 3.9], axis: [0, 0, 1]}
fills:
  - {name: grains, material: m, count: 300, radius: [0.04, 0.05], packing: hexagonal, min: [-0.165, -0.165, 0], max: [0.165, 0.165, 3.9]}
";
    let (bodies, _) = SHAFT.split_once("fills:").unwrap();
    let mut sim = simulation(&format!("solver: {{method: barzilai_borwein}}\n{bodies}{plate}"));
    let load = (0..sim.model.n_bodies()).find(|b| sim.model.inv_mass[*b] == 1.0 / 3000.0).unwrap() as u32;
    let mut error = 0.0f64;
    while sim.state.time < 2.5 {
        sim.step();
        let contacts = &sim.state.contacts;
        let force = (0..contacts.len()).map(|i| {
            let [a, b] = contacts.bodies[i];
            contacts.impulse[i].z * ((b == load) as i32 - (a == load) as i32) as f64 / sim.model.step
        });
        if sim.state.time > 2.2 {
            error = error.max((force.sum::<f64>() / (3000.0 * 9.81) - 1.0).abs());
        }
    }
    assert!(error < 2e-3, "the plate's weight is off by {error:.1e}");
}

#[test]
fn sweeps_go_on_where_a_step_would_add_overlap() {
    let deepest = |overlap_tolerance| {
        let solver = sim::SolverSettings {
            friction: sim::FrictionLaw::Exact,
            recovery_speed: 0.03,
            overlap_tolerance,
            ..workload::solver(sim::Method::GaussSeidel, 18)
        };
        let (model, state) = workload::build(workload::Workload::S, 1000, solver, 1.5e-3);
        let mut sim = Simulation::new(model, state);
        let (mut depth, mut sweeps) = (0.0f64, 0);
        for _ in 0..250 {
            let report = sim.step();
            (depth, sweeps) = (depth.max(report.worst_penetration), sweeps + report.iterations);
        }
        (depth / 0.075, sweeps)
    };
    let ((alone, fewer), (with_more, more)) = (deepest(None), deepest(Some(3e-4 * 0.075)));
    assert!(alone > 1.5e-3 && with_more < 9e-4, "{alone:.1e} of a radius alone, {with_more:.1e} with more sweeps");
    assert!(fewer < more && more < fewer * 5 / 4, "{fewer} sweeps alone, {more} with more");
}

#[test]
fn a_deep_pile_of_boxes_comes_to_rest() {
    // Their contacts come and go: 16 layers of 2 × 2 boxes, thrown into a shaft.
    let boxes: String = (0..64)
        .map(|i| {
            let [x, y, z] = [i % 2, i / 2 % 2, i / 4].map(f64::from);
            let (position, axis) = ([0.22 * (x - 0.5), 0.22 * (y - 0.5), 0.2 + 0.25 * z], [1, 2, i % 7]);
            format!("  - {{name: b{i}, material: m, box: {{size: [0.2, 0.15, 0.1]}}, position: {position:?}, rotate: {{axis: {axis:?}, angle: {}}}}}\n", 20 * i)
        })
        .collect();
    let walls = SHAFT.split("fills:").next().expect("walls").replace("0.17", "0.28");
    for method in ["apgd", "gauss_seidel"] {
        let mut sim = simulation(&format!("solver: {{method: {method}, iterations: 50}}\n{walls}{boxes}"));
        // At rest after 1.7 s in the mean of 35 piles; in three of 70 a box that leant tipped over after 2.5 to 3.5 s.
        (0..4_000).for_each(|_| drop(sim.step()));
        for _ in 0..500 {
            sim.step();
            let (speed, force) = unrest(&sim);
            assert!(speed <= 1e-4 && force <= 1e-3, "{method}: {speed:.1e} m/s, {force:.1e} of the weight");
        }
        assert!(sim.state.contacts.worst_penetration() < 1e-4, "{method}");
    }
}

#[test]
fn columns_that_fall_on_each_other_come_to_rest() {
    // Columns of boxes that begin with gaps between them, each one alone: by sweeps half of those of ten go on swaying at centimetres a second.
    for (n, gap, size, friction) in
        [(8, 1e-3, 0.1, "relaxed"), (10, 2e-4, 0.1, "relaxed"), (10, 0.03, 0.2, "relaxed"), (15, 5e-3, 0.2, "exact")]
    {
        let body = |k: usize| {
            let height = gap * (k + 1) as f64 + size * (k as f64 + 0.5);
            format!(
                "  - {{name: b{k}, material: m, box: {{size: [{size}, {size}, {size}]}}, position: [0, 0, {height}]}}\n"
            )
        };
        let mut sim = simulation(&format!(
            "quality: normal
solver: {{friction: {friction}}}
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
{}",
            (0..n).map(body).collect::<String>()
        ));
        while sim.state.time < 5.0 {
            sim.step();
        }
        let top = sim.state.position[n];
        assert!(
            (top.z - (n as f64 - 0.5) * size).abs() < 0.02 * size,
            "{n} boxes of {size} m: the top one is at {top}"
        );
        let (speed, error) = unrest(&sim);
        assert!(speed < 5e-5 && error < 0.01, "{n} boxes of {size} m, {gap} m apart: {speed} m/s, {error}");
    }
}

#[test]
fn a_run_on_a_bed_at_rest_starts_at_rest() {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    std::fs::write(
        at("bed.yaml"),
        format!("duration: 5\nframe_rate: 1\nsolver: {{method: gauss_seidel, iterations: 50}}\n{SHAFT}"),
    )
    .unwrap();
    scree(&["simulate", &at("bed.yaml"), "-o", &at("bed")]).ok();
    // In another step than the bed's, overlaps are another rate of recovery.
    for (step, most) in [("1e-3", 1e-3), ("5e-4", 3e-3)] {
        let on =
            format!("step: {step}\nmaterials: {{m: {{density: 2500, friction: 0.5}}}}\nbase: {{run: {}}}\n", at("bed"));
        let mut sim = simulation(&on);
        assert!(sim.state.contacts.len() > 300);
        for k in 0..20 {
            sim.step();
            let (speed, force) = unrest(&sim);
            assert!(speed <= 1e-4 && force <= most, "step {k} of {step} s: {speed:.1e} m/s, {force:.1e} of the weight");
        }
    }
}

/// A chain with a load at its end.
struct Chain {
    /// Number of links, and the mass of each, kg.
    links: usize,
    mass: f64,
    /// Length of a link, m, and its radius over that.
    length: f64,
    thin: f64,
    kind: &'static str,
    /// Angle from the vertical, rad.
    lean: f64,
    /// kg
    load: f64,
    /// Velocity of the load alone, m/s.
    thrown: [f64; 3],
    /// Angular velocity of the chain about the vertical through its pin, rad/s; there is no gravity then.
    spin: f64,
}

impl Default for Chain {
    fn default() -> Chain {
        let (links, mass, length, thin, kind, load) = (60, 0.01, 0.1, 0.14, "spherical", 1000.0);
        Chain { links, mass, length, thin, kind, lean: 0.3, load, thrown: [0.0; 3], spin: 0.0 }
    }
}

impl Chain {
    fn simulation(&self) -> Simulation {
        let Chain { links, mass, length, thin, kind, lean, load, spin, .. } = *self;
        let (x, z) = (lean.sin() * length, -lean.cos() * length);
        let at = |s: f64| format!("[{}, 0, {}]", x * s, z * s);
        let (along, across) = (0.5 * (thin * length).powi(2), (0.25 * thin * thin + 1.0 / 12.0) * length * length);
        let inertia = format!("[{}, {}, {}]", mass * along, mass * across, mass * across);
        let turned = format!("{{axis: [0, 1, 0], angle: {}}}", 90.0 - lean.to_degrees());
        let motion = |s: f64| format!("velocity: [0, {}, 0], angular_velocity: [0, 0, {spin}]", spin * x * s);
        let (mut bodies, mut joints) = (String::new(), String::new());
        for k in 0..links {
            let (start, before) = (k as f64, if k == 0 { "world".into() } else { format!("link{}", k - 1) });
            let (middle, ends) = match kind {
                "distance" => (start + 1.0, format!("position_b: {}", at(start + 1.0))),
                _ => (start + 0.5, "axis: [0, 1, 0]".into()),
            };
            let (place, motion) = (at(middle), motion(middle));
            bodies += &format!(
                "  - {{name: link{k}, shapes: [], mass: {mass}, inertia: {inertia}, position: {place}, rotate: {turned}, {motion}}}\n"
            );
            joints += &format!(
                "  - {{name: pin{k}, kind: {kind}, a: {before}, b: link{k}, position: {}, {ends}}}\n",
                at(start)
            );
        }
        let (end, last) = (at(links as f64), links - 1);
        let [vx, vy, vz] = self.thrown;
        let velocity =
            format!("velocity: [{vx}, {}, {vz}], angular_velocity: [0, 0, {spin}]", vy + spin * x * links as f64);
        bodies += &format!(
            "  - {{name: load, shapes: [], mass: {load}, inertia: [10, 10, 10], position: {end}, {velocity}}}\n"
        );
        joints += &format!("  - {{name: hook, kind: spherical, a: link{last}, b: load, position: {end}}}\n");
        let gravity = if spin == 0.0 { -9.81 } else { 0.0 };
        simulation(&format!(
            "step: 1e-3\ngravity: [0, 0, {gravity}]\nmaterials: {{m: {{density: 1000, friction: 0}}}}\n\
             bodies:\n{bodies}joints:\n{joints}"
        ))
    }

    /// Swing for some steps: no warning, never longer by more than `stretch` of its length, and the energy within `drift` of the kinetic
    /// energy that it may have.
    fn swings(&self, steps: usize, (stretch, drift): (f64, f64)) {
        let (mut sim, links) = (self.simulation(), self.links);
        let length = self.length * links as f64;
        let weight = if self.spin == 0.0 { 9.81 } else { 0.0 };
        let energy = |s: &Simulation| {
            let (v, z) = (s.state.velocity[links].length_squared(), s.state.position[links].z);
            self.load * (0.5 * v + weight * (z + length))
        };
        let first = energy(&sim);
        let name = format!("{links} {} links of {} m", self.kind, self.length);
        for step in 0..steps {
            let warnings = sim.step().warnings;
            assert!(warnings.is_empty(), "{name}, step {step}: {warnings:?}");
            let reach = sim.state.position[links].length();
            assert!(reach / length - 1.0 < stretch, "{name}, step {step}, reach {reach} m");
            let change = energy(&sim) / first - 1.0;
            assert!(change.abs() < drift, "{name}, step {step}: the energy drifts by {change}");
        }
    }
}

#[test]
fn a_light_chain_swings_a_heavy_load() {
    for (links, kind) in [(200, "spherical"), (60, "revolute"), (60, "distance")] {
        Chain { links, kind, ..Chain::default() }.swings(1_000, (1e-4, 0.01));
    }
}

/// Let go level, by chains whose links are short or thin: these have next to no moment about their own axes.
#[test]
fn short_and_thin_light_chains_swing_a_heavy_load() {
    let level = Chain { lean: std::f64::consts::FRAC_PI_2, thin: 0.05, ..Chain::default() };
    for (links, mass, length, thin) in [
        (2, 0.01, 0.05, 0.05),
        (3, 0.01, 0.033, 0.05),
        (10, 0.01, 0.02, 0.02),
        (50, 0.01, 0.01, 0.05),
        (200, 0.01, 0.005, 0.05),
        (5, 0.1, 0.02, 0.05),
        (5, 0.03, 0.02, 0.5),
    ] {
        Chain { links, mass, length, thin, ..level }.swings(1_500, (2e-3, 0.01));
    }
}

/// The load comes to its chain with a speed that the links do not have, and the chain turns taut with it.
#[test]
fn a_light_chain_takes_up_a_load_that_moves() {
    let level = Chain { lean: std::f64::consts::FRAC_PI_2, thin: 0.05, length: 0.1, ..Chain::default() };
    for (links, mass, thrown) in [
        (10, 0.01, [0.0, 0.0, 0.5]),
        (10, 0.01, [0.0, 0.0, 1.0]),
        (50, 0.01, [0.0, 0.5, 0.0]),
        (20, 0.1, [0.0, 0.0, 2.0]),
    ] {
        Chain { links, mass, thrown, ..level }.swings(1_500, (5e-4, 0.05));
    }
}

/// Taut chains of thin links that rotate, without gravity.
#[test]
fn light_chains_whirl_a_heavy_load() {
    let level = Chain { lean: std::f64::consts::FRAC_PI_2, thin: 0.04, ..Chain::default() };
    for (links, length, load, spin) in [(10, 0.1, 1000.0, 10.0), (2, 0.5, 1000.0, 20.0), (10, 0.1, 100.0, 20.0)] {
        Chain { links, length, load, spin, ..level }.swings(3_000, (2e-3, 0.005));
    }
}

#[test]
fn light_springs_swing_a_heavy_load() {
    // Points of 10 g between springs of 1e7 N/m that are let go at 0.3 rad under 1000 kg.
    for springs in [5, 20] {
        let at = |i: usize| {
            let way = 0.1 * i as f64;
            format!("[{}, 0, {}]", way * 0.3f64.sin(), -way * 0.3f64.cos())
        };
        let (mut bodies, mut rows) = (String::new(), String::new());
        for i in 0..springs {
            let (mass, moment) = if i + 1 == springs { (1000.0, 1.0) } else { (0.01, 1e-5) };
            let place = at(i + 1);
            bodies += &format!(
                "  - {{name: p{i}, shapes: [], mass: {mass}, inertia: [{moment}, {moment}, {moment}], position: {place}}}\n"
            );
            let before = if i == 0 { "world".to_string() } else { format!("p{}", i - 1) };
            let from = at(i);
            rows += &format!(
                "  - {{name: s{i}, a: {before}, b: p{i}, position: {from}, position_b: {place}, stiffness: 1.0e+7}}\n"
            );
        }
        let mut sim = simulation(&format!("bodies:\n{bodies}springs:\n{rows}"));
        let length = 0.1 * springs as f64;
        let most = 1000.0 * 9.81 * length * (1.0 - 0.3f64.cos());
        for _ in 0..2_000 {
            sim.step();
            let (reach, speed) = (sim.state.position[springs - 1].length(), sim.state.velocity[springs - 1].length());
            assert!((reach / length - 1.0).abs() < 0.05, "{springs} springs reach {reach} m");
            assert!(500.0 * speed * speed < 1.2 * most, "{springs} springs: {speed} m/s");
        }
    }
}

#[test]
fn the_reaction_of_a_container_is_the_weight() {
    let spheres: String = (0..8)
        .map(|i| {
            let [x, y, z] = [i % 2, i / 2 % 2, i / 4].map(|k| 0.11 + 0.21 * f64::from(k));
            format!("  - {{name: s{i}, material: m, mass: 5, sphere: {{radius: 0.1}}, position: [{x}, {y}, {z}]}}\n")
        })
        .collect();
    let mut sim = simulation(&format!(
        "materials: {{m: {{density: 1000, friction: 0.3}}}}
bodies:
  - {{name: floor, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: a, material: m, plane: {{normal: [1, 0, 0]}}}}
  - {{name: b, material: m, plane: {{normal: [0, 1, 0]}}}}
  - {{name: c, material: m, plane: {{normal: [-1, 0, 0]}}, position: [0.43, 0, 0]}}
  - {{name: d, material: m, plane: {{normal: [0, -1, 0]}}, position: [0, 0.43, 0]}}
{spheres}"
    ));
    (0..2_000).for_each(|_| drop(sim.step()));
    let (_, error) = unrest(&sim);
    assert!(error * 392.4 < 1e-3, "{} N off", error * 392.4);
}

#[test]
fn an_impact_acts_at_the_surface() {
    // A sphere that hits a rough ground stops to slide: 5/7 of its speed are left.
    let mut sim = simulation(
        "gravity: [0, 0, 0]
solver: {friction: exact, tolerance: 1e-12}
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: ball, material: m, sphere: {radius: 0.1}, position: [0, 0, 0.101], velocity: [3, 0, -4]}
",
    );
    sim.step();
    let (v, w) = (sim.state.velocity[1], sim.state.angular_velocity[1]);
    assert!((v.x - 15.0 / 7.0).abs() < 1e-9 && (w.y - 150.0 / 7.0).abs() < 1e-8, "{v} {w}");
}

#[test]
fn motion_that_is_prescribed_is_no_violation_and_a_range_of_zero_holds() {
    let body = "materials: {m: {density: 1000, friction: 0}}
bodies:
  - {name: a, material: m, box: {size: [0.2, 0.2, 0.2]}, position: [1, 0, 0]}
joints:
  - {name: j, kind: revolute, a: world, b: a, position: [0, 0, 0], axis: [0, 1, 0], ";
    let mut sim = simulation(&format!("{body}motor: {{motion: {{ramp: {{times: [0, 1], values: [0, 1]}}}}}}}}\n"));
    (0..300).for_each(|_| drop(sim.step()));
    assert!((sim.state.joints[0].coordinate - 0.3).abs() < 1e-5);
    assert!(sim.state.joints[0].violation < 1e-5, "{}", sim.state.joints[0].violation);
    let mut sim = simulation(&format!("{body}limits: [0, 0]}}\n"));
    (0..300).for_each(|_| drop(sim.step()));
    assert!(sim.state.joints[0].coordinate.abs() < 1e-6, "{}", sim.state.joints[0].coordinate);
}

#[test]
fn equal_limits_make_a_beam_of_a_chain_of_hinges() {
    let (mut bodies, mut joints) = (String::from("materials: {}\nbodies:\n"), String::from("joints:\n"));
    for k in 0..30 {
        let (x, before) = (0.1 * k as f64, if k == 0 { "world".into() } else { format!("l{}", k - 1) });
        bodies += &format!(
            "  - {{name: l{k}, shapes: [], mass: 0.1, inertia: [1e-5, 1e-4, 1e-4], position: [{}, 0, 0]}}\n",
            x + 0.05
        );
        joints += &format!(
            "  - {{name: j{k}, kind: revolute, a: {before}, b: l{k}, position: [{x}, 0, 0], axis: [0, 1, 0], limits: [0, 0]}}\n"
        );
    }
    let mut sim = simulation(&(bodies + &joints));
    (0..300).for_each(|_| drop(sim.step()));
    let (end, v) = (sim.state.position[29], sim.state.velocity[29]);
    assert!(end.z.abs() < 1e-4 && v.length() < 1e-9, "the end hangs at {end} and moves at {v}");
    // Weight times arm: 30 links of 0.1 kg, 1.5 m from the wall.
    let torque = sim.state.joints[0].torque;
    assert!((torque.length() / (3.0 * 9.81 * 1.5) - 1.0).abs() < 1e-6, "{torque}");
}

#[test]
fn a_distance_with_limits_is_a_rope() {
    let rope = |limits: &str| {
        simulation(&format!(
            "materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies: [{{name: b, material: m, mass: 10, sphere: {{radius: 0.1}}, position: [0.6, 0, -0.8]}}]
joints: [{{name: r, kind: distance, a: world, b: b, position: [0, 0, 0], position_b: [0.6, 0, -0.8], {limits}}}]
"
        ))
    };
    let mut sim = rope("limits: [0, 2]");
    // It falls freely until the rope is taut.
    (0..300).for_each(|_| drop(sim.step()));
    let fall = 0.5 * 9.81 * 0.3 * 0.301;
    assert!((sim.state.position[0].z + 0.8 + fall).abs() < 1e-9, "{}", sim.state.position[0]);
    let mut longest = 0.0f64;
    for _ in 0..2000 {
        sim.step();
        longest = longest.max(sim.state.position[0].length());
    }
    assert!((longest - 2.0).abs() < 1e-3, "{longest}");
    // A rope whose ends are in one place.
    let mut sim = simulation(
        "materials: {m: {density: 1000, friction: 0.5}}
bodies: [{name: b, material: m, mass: 10, sphere: {radius: 0.1}}]
joints: [{name: r, kind: distance, a: world, b: b, position: [0, 0, 0], position_b: [0, 0, 0], limits: [0, 2]}]
",
    );
    (0..300).for_each(|_| drop(sim.step()));
    assert!((sim.state.position[0].z + fall).abs() < 1e-9, "{}", sim.state.position[0]);
    (0..1000).for_each(|_| drop(sim.step()));
    assert!((sim.state.position[0].z + 2.0).abs() < 1e-3, "{}", sim.state.position[0]);
    // Equal limits are a rod.
    let mut sim = rope("limits: [1, 1]");
    (0..500).for_each(|_| drop(sim.step()));
    assert!((sim.state.position[0].length() - 1.0).abs() < 1e-4, "{}", sim.state.position[0]);
}
