//! The vehicle of Negrut et al. 2012, section 5.2: it stands with its tracks on a bed of spheres, and drives off.

use super::convex::walls;
use crate::ModelBuilder;
use crate::assembly::TrackedVehicle;
use crate::model_file::{AssemblyFile, FunctionFile, ShapeFile};

/// Layers of the bed.
const LAYERS: usize = 8;

/// Edge of the bed, m: the vehicle is 2.3 m long and 1.3 m wide.
const EDGE: f64 = 3.2;

/// The vehicle on a bed of about `n` spheres in close layers between four walls, with torque on both sprockets from the start.
pub fn vehicle(n: usize) -> ModelBuilder {
    let mut model = ModelBuilder::new(&format!("vehicle({n})"));
    model.file.gravity = [0.0, 0.0, -9.81];
    model.material("steel", 7800.0, 0.4);
    model.material("soil", 2000.0, 0.8);
    walls(&mut model, "soil", EDGE);
    // A row has a sphere for each diameter, and rows are √3 radii apart.
    let along = ((n as f64 / LAYERS as f64 * 0.75f64.sqrt()).sqrt() as usize).max(4);
    let radius = 0.5 * EDGE / (along as f64 + 0.5);
    let row = 3f64.sqrt() * radius;
    let across = ((EDGE - 2.0 * radius - row / 3.0) / row) as usize + 1;
    let layer = 2.0 * (2.0f64 / 3.0).sqrt() * radius;
    for k in 0..LAYERS * across * along {
        let [i, j, level] = [k % along, k / along % across, k / (along * across)];
        let shift = [((j + level) % 2) as f64 * radius, (level % 2) as f64 * row / 3.0];
        let grain = model.body(&format!("g{k}"), "soil", ShapeFile::sphere(radius));
        grain.class = Some("grain".into());
        grain.position = [
            radius + 2.0 * radius * i as f64 + shift[0],
            radius + row * j as f64 + shift[1],
            radius + layer * level as f64,
        ];
    }
    let top = 2.0 * radius + layer * (LAYERS - 1) as f64;
    let vehicle = TrackedVehicle {
        position: [0.5 * EDGE, 0.5 * EDGE, top],
        idler_spring: true,
        torque: [100.0, 100.0].map(FunctionFile::Constant),
        ..TrackedVehicle::default()
    };
    model.file.assemblies.push(AssemblyFile {
        name: "vehicle".into(),
        tracked_vehicle: Some(vehicle),
        helical_anchor: None,
    });
    model
}

#[cfg(test)]
mod tests {
    use super::vehicle;

    /// It touches the bed at the start, is in none of it, and stays on top.
    #[test]
    fn the_vehicle_stands_on_its_bed() {
        let mut sim = vehicle(700).simulation().unwrap();
        let grains = sim.model.class.iter().filter(|class| sim.model.class_names[**class as usize] == "grain").count();
        assert!(grains.abs_diff(700) < 200, "{grains} grains");
        let chassis = sim.model.body_names["vehicle_chassis"] as usize;
        let before = sim.state.position[chassis].z;
        for _ in 0..10 {
            let report = sim.step();
            assert!(report.broken.is_none() && report.worst_penetration < 1e-3, "{report:?}");
        }
        let shoes = |b: &u32| sim.model.class_names[sim.model.class[*b as usize] as usize] == "vehicle_shoe";
        let on_grains = sim.state.contacts.bodies.iter().filter(|[a, b]| shoes(a) != shoes(b)).count();
        assert!(on_grains > 20, "{on_grains} contacts of shoes");
        assert!((sim.state.position[chassis].z - before).abs() < 2e-3, "{} {before}", sim.state.position[chassis].z);
    }
}
