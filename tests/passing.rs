//! Shapes that slide, roll and fall past the edges of others, which they touch nowhere else, keep their motion; what stands in the way stops them.

use crate::analytic::simulation;
use sim::Simulation;

/// Slabs of half a metre along x whose tops are flush, each a fixed body.
fn slabs(top: f64) -> String {
    let slab = |k: i32| {
        format!(
            "  - {{name: slab{k}, material: m, box: {{size: [0.5, 2, 0.2]}}, position: [{}, 0, {}], fixed: true}}\n",
            0.5 * f64::from(k),
            top - 0.1
        )
    };
    (-1..=8).map(slab).collect()
}

/// A model at a quality, or at the defaults, with this friction.
fn model(quality: &str, friction: f64, bodies: &str) -> Simulation {
    let quality = if quality.is_empty() { String::new() } else { format!("quality: {quality}\n") };
    simulation(&format!("{quality}materials: {{m: {{density: 2000, friction: {friction}}}}}\nbodies:\n{bodies}"))
}

fn run(sim: &mut Simulation, until: f64) {
    while sim.state.time < until - 1e-9 {
        let report = sim.step();
        assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    }
}

const HULL: &str = "hull: {points: [[0.1, 0.1, 0.1], [-0.1, 0.1, 0.1], [0.1, -0.1, 0.1], [-0.1, -0.1, 0.1], [0.1, 0.1, -0.1], [-0.1, 0.1, -0.1], [0.1, -0.1, -0.1], [-0.1, -0.1, -0.1]]}";
const BOX: &str = "box: {size: [0.2, 0.2, 0.2]}";

#[test]
fn what_slides_and_rolls_over_flush_slabs_keeps_its_speed() {
    for quality in ["normal", "tight", ""] {
        for (shape, speed) in [(BOX, 3.0), (BOX, 0.5), (HULL, 3.0)] {
            let block =
                format!("  - {{name: b, material: m, {shape}, position: [0, 0, 0.1], velocity: [{speed}, 0, 0]}}\n");
            let mut sim = model(quality, 0.0, &(slabs(0.0) + &block));
            run(&mut sim, 1.0);
            let [v, w] = [&sim.state.velocity, &sim.state.angular_velocity].map(|column| *column.last().unwrap());
            assert!((v.x - speed).abs() < 0.015 && v.z.abs() < 1e-3 && w.length() < 1e-2, "{quality} {shape}: {v} {w}");
        }
        for (shape, spin, most) in [
            ("sphere: {radius: 0.1}", "[0, 30, 0]", 1e-3),
            ("cylinder: {radius: 0.1, length: 0.3}, rotate: {axis: [1, 0, 0], angle: 90}", "[0, 0, -30]", 0.1),
            ("capsule: {radius: 0.1, length: 0.3}, rotate: {axis: [1, 0, 0], angle: 90}", "[0, 0, -30]", 0.1),
        ] {
            let roller = format!(
                "  - {{name: b, material: m, {shape}, position: [0, 0, 0.1], velocity: [3, 0, 0], angular_velocity: {spin}}}\n"
            );
            let mut sim = model(quality, 0.5, &(slabs(0.0) + &roller));
            run(&mut sim, 1.0);
            let v = *sim.state.velocity.last().unwrap();
            assert!((v.x - 3.0).abs() < most && v.y.abs() < 0.05, "{quality} {shape}: {v}");
        }
    }
}

#[test]
fn what_falls_past_a_ledge_or_down_a_shaft_of_blocks_falls_freely() {
    let wall: String = (-14..=2)
        .flat_map(|k| [("w", -0.2), ("e", 0.2)].map(|(side, x)| (k, side, x)))
        .map(|(k, side, x)| {
            let z = 0.25 * f64::from(k);
            format!("  - {{name: {side}{k}, material: m, box: {{size: [0.2, 0.4, 0.25]}}, position: [{x}, 0, {z}], fixed: true}}\n")
        })
        .collect();
    for quality in ["normal", "tight", ""] {
        let ledge = |clearance: f64, shape: &str| {
            let x = -0.2 - clearance;
            format!(
                "  - {{name: ledge, material: m, box: {{size: [0.2, 1, 0.1]}}, position: [{x}, 0, -0.4], fixed: true}}\n  - {{name: b, material: m, {shape}, position: [0, 0, 0]}}\n"
            )
        };
        let shaft = format!("{wall}  - {{name: b, material: m, {BOX}, position: [0, 0, 0]}}\n");
        let cases = [ledge(2e-3, BOX), ledge(5e-4, HULL), shaft];
        for bodies in cases {
            let mut sim = model(quality, 0.0, &bodies);
            run(&mut sim, 0.6);
            let [v, w] = [&sim.state.velocity, &sim.state.angular_velocity].map(|column| *column.last().unwrap());
            let falls = -9.81 * 0.6;
            assert!((v.z - falls).abs() < 0.02 && v.x.abs() < 1e-3 && w.length() < 1e-2, "{quality}: {v} {w} {bodies}");
        }
    }
}

#[test]
fn what_stands_in_the_way_stops() {
    for quality in ["normal", "tight", ""] {
        // A slab that is a fortieth of the height of the block higher, over whose edge it may tip but not slide.
        let step = slabs(0.0)
            + "  - {name: step, material: m, box: {size: [0.5, 2, 0.2]}, position: [0.7, 0, -0.095], fixed: true}\n"
            + &format!("  - {{name: b, material: m, {BOX}, position: [0, 0, 0.1], velocity: [1, 0, 0]}}\n");
        let mut sim = model(quality, 0.0, &step);
        run(&mut sim, 0.5);
        let (x, v) = (sim.state.position.last().unwrap().x, *sim.state.velocity.last().unwrap());
        assert!(x < 0.4 && v.x < 0.1, "{quality}: {x} {v}");
        // A ledge that the block hits with a hundredth of its width.
        let hit = format!(
            "  - {{name: ledge, material: m, box: {{size: [0.2, 1, 0.1]}}, position: [-0.198, 0, -0.4], fixed: true}}\n  - {{name: b, material: m, {BOX}, position: [0, 0, 0]}}\n"
        );
        let mut sim = model(quality, 0.0, &hit);
        run(&mut sim, 0.3);
        let w = *sim.state.angular_velocity.last().unwrap();
        assert!(w.length() > 1.0, "{quality}: {w}");
    }
}
