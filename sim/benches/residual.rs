//! Residual and objective against iterations for the four methods, on the step of a settled bed of 8,000 spheres.
//!
//! `cargo bench -p sim --bench residual` writes `results/residual.csv` and `results/residual.svg`. The bed is workload S after
//! one second; the step is taken cold, without recovery of overlaps.

use plotters::prelude::*;
use sim::workload::{self, Workload};
use sim::{Method, Simulation, SolverSettings};
use std::path::Path;

const ITERATIONS: [u32; 9] = [3, 10, 20, 30, 60, 100, 200, 300, 1000];

fn main() {
    let settle = SolverSettings { recovery_speed: 0.05, ..workload::solver(Method::GaussSeidel, 8) };
    let (model, state) = workload::build(Workload::S, 8000, settle, 1e-3);
    let mut bed = Simulation::new(model, state);
    for _ in 0..1000 {
        bed.step();
    }
    let mut table = String::from("iterations");
    Method::ALL.iter().for_each(|m| table += &format!(",{} [m/s]", m.name()));
    table += "\n";
    let mut curves = vec![vec![]; Method::ALL.len()];
    for n in ITERATIONS {
        table += &n.to_string();
        for (k, method) in Method::ALL.into_iter().enumerate() {
            let mut model = bed.model.clone();
            model.solver = SolverSettings { warm_start: false, ..workload::solver(method, n) };
            let residual = Simulation::new(model, bed.state.clone()).step().residual;
            table += &format!(",{residual:.4e}");
            curves[k].push((n as f64, residual));
        }
        table += "\n";
    }
    print!("{table}");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/results");
    std::fs::write(folder.join("residual.csv"), &table).expect("the folder of results can be written");
    let goal = folder.join("residual.svg");
    plotters::style::register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
        .unwrap_or_else(|_| panic!("the built-in font can be read"));
    let area = SVGBackend::new(&goal, (900, 560)).into_drawing_area();
    draw(&area, &curves).expect("a plot can be drawn");
}

fn draw(
    area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
    curves: &[Vec<(f64, f64)>],
) -> Result<(), Box<dyn std::error::Error>> {
    area.fill(&WHITE)?;
    let all = || curves.iter().flatten().map(|p| p.1).filter(|x| *x > 0.0);
    let (lo, hi) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    let mut chart = ChartBuilder::on(area)
        .caption("Residual of a cold step on a settled bed of 8,000 spheres", ("sans-serif", 22))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(80)
        .build_cartesian_2d((3.0..1000.0).log_scale(), (lo / 2.0..hi * 2.0).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("iterations")
        .y_desc("residual [m/s]")
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .draw()?;
    for (k, curve) in curves.iter().enumerate() {
        let color = Palette99::pick(k).to_rgba();
        chart
            .draw_series(LineSeries::new(curve.iter().copied(), color.stroke_width(3)))?
            .label(Method::ALL[k].name())
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 24, y)], color.stroke_width(3)));
    }
    chart.configure_series_labels().background_style(WHITE.mix(0.9)).border_style(BLACK).draw()?;
    area.present()?;
    Ok(())
}
