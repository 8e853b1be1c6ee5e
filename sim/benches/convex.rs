//! Convex bodies and joints by the levels of quality: cost against penetration.
//!
//! `cargo bench -p sim --bench convex [WORD…]` writes `results/convex.csv` and `results/convex.svg`; words choose among the names of scenes and
//! levels. One thread. The plot has the points of `results/convex_peers.csv` beside, crosses.

mod clock;

use clock::cpu_seconds;
use plotters::prelude::*;
use sim::Quality;
use sim::workload::{self, Convex, Measure};
use std::path::Path;

const SCENES: [Convex; 4] = [Convex::Pyramid, Convex::Pile, Convex::Boxes, Convex::Grid];
const LEVELS: [Quality; 3] = [Quality::Draft, Quality::Normal, Quality::Tight];

/// A row of the table, and the point of the plot: cost, and penetration over the inradius.
struct Row {
    scene: Convex,
    text: String,
    point: (f64, f64),
}

fn run(scene: Convex, quality: Quality) -> Row {
    let (n, seconds) = scene.size();
    let before = cpu_seconds();
    let mut model = workload::scene(scene, n);
    model.file.quality = Some(quality);
    let mut sim = model.simulation().expect("the model of a workload is sound");
    let mut measure = Measure::new(&sim);
    sim.step();
    let (startup, cpu) = (cpu_seconds() - before, cpu_seconds());
    let (mut iterations, mut steps) = (0, 1);
    while sim.state.time < seconds - 1e-9 {
        let report = sim.step();
        iterations += report.iterations;
        steps += 1;
        measure.note(&sim.state, &report);
    }
    let cost = (cpu_seconds() - cpu) / (sim.state.time - sim.model.step);
    let (last, worst) = (measure.penetration(&sim.state), measure.worst);
    let [drift, drop] = measure.drift_and_drop(&sim);
    let moving = sim.model.inv_mass.iter().filter(|inv_mass| **inv_mass > 0.0).count() as f64;
    let speed = sim.state.velocity.iter().map(|v| v.length()).sum::<f64>() / moving;
    let gap = sim.state.joints.iter().map(|joint| joint.violation).fold(0.0, f64::max);
    let text = format!(
        "{scene:?},{},{:.2},{:.1},{startup:.2},{cost:.2},{last:.1e},{worst:.1e},{drift:.1e},{drop:.1e},{speed:.1e},{gap:.1e}",
        quality.name(),
        sim.model.step * 1e3,
        f64::from(iterations) / f64::from(steps),
    );
    eprintln!("{text}");
    Row { scene, text, point: (cost, last) }
}

/// The penetrations over the inradius and the costs that peers were measured at, with the names of the scenes.
fn peers(table: &str) -> Vec<(String, (f64, f64))> {
    let row = |line: &str| {
        let [scene, _, cost, penetration] = line.split(',').collect::<Vec<_>>().try_into().ok()?;
        Some((scene.to_string(), (penetration.parse().ok()?, cost.parse().ok()?)))
    };
    table.lines().skip(1).filter_map(row).collect()
}

/// The cost of each scene against its penetration, a curve for each scene, and a cross for each of the peers.
fn draw(rows: &[Row], peers: &[(String, (f64, f64))], goal: &Path) -> Result<(), Box<dyn std::error::Error>> {
    plotters::style::register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
        .unwrap_or_else(|_| panic!("the built-in font can be read"));
    let area = SVGBackend::new(goal, (900, 560)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption("Cost of convex bodies against their penetration", ("sans-serif", 22))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(80)
        .build_cartesian_2d((1e-7..1.0).log_scale(), (0.2..100.0).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("worst penetration at the end over the inradius")
        .y_desc("CPU-seconds per simulated second")
        .x_label_formatter(&|x| format!("{x:.0e}"))
        .draw()?;
    for (k, scene) in SCENES.into_iter().enumerate() {
        let points: Vec<(f64, f64)> =
            rows.iter().filter(|r| r.scene == scene && r.point.1 > 0.0).map(|r| (r.point.1, r.point.0)).collect();
        if points.is_empty() {
            continue;
        }
        let color = Palette99::pick(k).to_rgba();
        let line = LineSeries::new(points.iter().copied(), color.stroke_width(2));
        let legend = move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color.stroke_width(2));
        chart.draw_series(line)?.label(format!("{scene:?}")).legend(legend);
        chart.draw_series(points.iter().map(|p| Circle::new(*p, 4, color.filled())))?;
        let own = peers.iter().filter(|(name, _)| *name == format!("{scene:?}"));
        let crosses = own.map(|(_, p)| Cross::new(*p, 6, color.stroke_width(2))).collect::<Vec<_>>();
        if !crosses.is_empty() {
            let legend = move |(x, y)| Cross::new((x + 8, y), 5, color.stroke_width(2));
            chart.draw_series(crosses)?.label(format!("{scene:?}, Rapier")).legend(legend);
        }
    }
    chart.configure_series_labels().background_style(WHITE.mix(0.8)).border_style(BLACK).draw()?;
    area.present()?;
    Ok(())
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let is_wanted = |words: &[String], word: &str| {
        let own: Vec<_> = wanted.iter().filter(|w| words.contains(w)).collect();
        own.is_empty() || own.iter().any(|w| *w == word)
    };
    let scenes = SCENES.map(|scene| format!("{scene:?}").to_lowercase());
    let levels = LEVELS.map(|level| level.name().to_string());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("threads");
    let mut rows = vec![];
    for (scene, name) in SCENES.into_iter().zip(&scenes).filter(|(_, name)| is_wanted(&scenes, name)) {
        for (quality, level) in LEVELS.into_iter().zip(&levels).filter(|(_, level)| is_wanted(&levels, level)) {
            // The grid has no contacts to be drafted.
            if name != "grid" || level != "draft" {
                rows.push(pool.install(|| run(scene, quality)));
            }
        }
    }
    let header = "scene,quality,step [ms],iterations,start-up [CPU-s],cost [CPU-s/s],penetration over inradius,the greatest of the run,drift [m],drop [m],mean speed [m/s],joint violation [m]";
    let table = rows.iter().fold(format!("{header}\n"), |table, row| table + &row.text + "\n");
    print!("{table}");
    if wanted.is_empty() {
        let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/results");
        std::fs::write(results.join("convex.csv"), table).expect("the folder of results can be written");
        let table = std::fs::read_to_string(results.join("convex_peers.csv")).expect("the peers' table");
        draw(&rows, &peers(&table), &results.join("convex.svg")).expect("a plot can be drawn");
    }
}
