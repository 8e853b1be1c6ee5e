//! Whole steps on a graphics adapter: of workload S, of workload A with a thousand iterations a step, of mixed convex shapes, and of the tracked
//! vehicle on a bed.

use super::budget::Budget;
use ::gpu::{Choice, Device, GpuError};
use serde_json::{Map, Value, json};
use sim::gpu::Fault;
use sim::stages::Stage;
use sim::workload::{self, Workload};
use sim::{Method, Model, ModelBuilder, Quality, Simulation, SolverSettings, State};
use std::time::Instant;

/// Steps before those that are timed, and the most of these.
const BEFORE: usize = 2;
const STEPS: usize = 5;

/// Steps in which mixed shapes come to rest.
const RESTS: usize = 250;

/// Bodies up to which the same steps are taken by the processor, too.
const COMPARED: usize = 10_000;

/// Methods with their iterations, of spheres and of any shapes: those of Gauss–Seidel are eight passes of four sweeps, and twelve of two.
const SPHERES: [(Method, u32); 3] = [(Method::Jacobi, 50), (Method::Apgd, 50), (Method::GaussSeidel, 14)];
const SHAPES: [(Method, u32); 3] = [(Method::Jacobi, 50), (Method::Apgd, 50), (Method::GaussSeidel, 12)];

/// The same for workload A: a thousand iterations, or as many sweeps.
const LONG: [(Method, u32); 3] = [(Method::Jacobi, 1000), (Method::Apgd, 1000), (Method::GaussSeidel, 498)];

/// The adapter, and the time that there is.
pub struct Steps<'a> {
    /// The adapter.
    pub adapter: &'a Choice,
    /// The most bytes of a buffer that it allows.
    pub most_bytes: u64,
    /// Its copy bandwidth, bytes/s.
    pub bandwidth: f64,
    /// The time that there is.
    pub time: &'a Budget,
    /// Time for the timed steps of a row, s; there is one at least.
    pub seconds: f64,
}

/// What a row is about.
#[derive(Clone, Copy)]
struct Row {
    workload: &'static str,
    n: usize,
    method: Method,
    /// A length of the bodies, m.
    radius: f64,
}

impl Row {
    /// The row where it has not been measured.
    fn without(&self, key: &str, why: String) -> Value {
        json!({ "workload": self.workload, "n": self.n, "method": self.method.name(), key: why })
    }
}

/// What takes a row.
type Add<'a> = &'a mut dyn FnMut(Value) -> Result<(), Fault>;

impl Steps<'_> {
    /// Measure all rows. Small ones, which the processor takes, too, come first, and the largest last.
    ///
    /// # Errors
    /// Those of the steps, and of `add`.
    pub fn all(&self, is_small: bool, add: Add) -> Result<(), Fault> {
        self.spheres(1_000, add)?;
        self.anchor(1_000, add)?;
        self.mixed(1_000, add)?;
        self.resting(1_000, add)?;
        self.vehicle(1_000, add)?;
        if is_small {
            return self.spheres(10_000, add).map(drop);
        }
        self.spheres(84_000, add)?;
        self.anchor(10_000, add)?;
        self.mixed(100_000, add)?;
        self.resting(10_000, add)?;
        self.vehicle(100_000, add)?;
        match self.spheres(1_000_000, add)? {
            Some(large) => self.ten_times(&large, add),
            None => Ok(()),
        }
    }

    /// Measure all methods on a bed of `n` spheres. Returns the last row.
    fn spheres(&self, n: usize, add: Add) -> Result<Option<Value>, Fault> {
        let mut last = None;
        for (method, iterations) in SPHERES {
            let row = Row { workload: "S", n, method, radius: workload::radius(Workload::S) };
            let row = self.row(row, || Ok(bed(n, method, iterations)))?;
            last = Some(row.clone());
            add(row)?;
        }
        Ok(last)
    }

    /// The same for ten times the spheres of a measured row, which says what buffers these took. Where those would be larger than the adapter
    /// allows, that is said in its stead.
    fn ten_times(&self, smaller: &Value, add: Add) -> Result<(), Fault> {
        let n = 10 * smaller["n"].as_u64().unwrap_or(0) as usize;
        let largest = smaller["largest_buffer_bytes"].as_u64();
        let limit = self.most_bytes;
        let Some(largest) = largest.filter(|largest| 10 * largest > limit) else {
            return self.spheres(n, add).map(drop);
        };
        let why = format!(
            "by those of {} spheres the largest buffer would have {} bytes, all of them {}, and this adapter allows {limit} for a buffer",
            smaller["n"],
            10 * largest,
            10 * smaller["device_bytes"].as_u64().unwrap_or(0)
        );
        SPHERES.into_iter().try_for_each(|(method, _)| {
            add(Row { workload: "S", n, method, radius: 0.0 }.without("does_not_fit", why.clone()))
        })
    }

    /// Measure the methods with a thousand iterations or sweeps on a bed of `n` grains of workload A.
    fn anchor(&self, n: usize, add: Add) -> Result<(), Fault> {
        LONG.into_iter().try_for_each(|(method, iterations)| {
            let row = Row { workload: "A", n, method, radius: workload::radius(Workload::A) };
            add(self.row(row, || Ok(drawn(Workload::A, n, workload::solver(method, iterations), (5e-4, 0.8))))?)
        })
    }

    /// Measure the methods on a bed of `n` mixed convex shapes, drawn together until neighbours touch.
    fn mixed(&self, n: usize, add: Add) -> Result<(), Fault> {
        self.built(("mixed", n, 0.075), &workload::mixed(n), (1.5e-3, 0.8), add)
    }

    /// Measure a bed of `n` mixed convex shapes that has come to rest, by the settings of normal quality, of which the processor takes what is before.
    fn resting(&self, n: usize, add: Add) -> Result<(), Fault> {
        let row = Row { workload: "resting", n, method: Method::GaussSeidel, radius: 0.075 };
        add(self.row(row, || {
            let mut bed =
                workload::mixed(n).into_simulation().map_err(|fault| Fault::Unsupported(fault.to_string()))?;
            let (step, solver) = Quality::Normal.settings(&bed.model, &bed.state, None);
            (bed.model.step, bed.model.solver) = (step, SolverSettings { start_iterations: None, ..solver });
            let moves: Vec<bool> = bed.model.inv_mass.iter().map(|inv_mass| *inv_mass > 0.0).collect();
            bed.state.position.iter_mut().zip(moves).filter(|(_, moves)| *moves).for_each(|(p, _)| *p *= 0.8);
            let mut bed = Simulation::new(bed.model, bed.state);
            for _ in (0..RESTS).take_while(|_| !self.time.is_over()) {
                bed.step();
            }
            Ok((bed.model, bed.state))
        })?)
    }

    /// Measure the methods on the tracked vehicle on a bed of about `n` spheres.
    fn vehicle(&self, n: usize, add: Add) -> Result<(), Fault> {
        self.built(("vehicle", n, 0.01), &workload::vehicle(n), (1e-3, 1.0), add)
    }

    /// Measure the methods on a model with a step, s, whose bodies are as much closer.
    fn built(
        &self,
        (workload, n, radius): (&'static str, usize, f64),
        builder: &ModelBuilder,
        (step, closer): (f64, f64),
        add: Add,
    ) -> Result<(), Fault> {
        let mut bed = builder.simulation().map_err(|fault| Fault::Unsupported(fault.to_string()))?;
        let moves: Vec<bool> = bed.model.inv_mass.iter().map(|inv_mass| *inv_mass > 0.0).collect();
        bed.state.position.iter_mut().zip(moves).filter(|(_, moves)| *moves).for_each(|(p, _)| *p *= closer);
        SHAPES.into_iter().try_for_each(|(method, iterations)| {
            add(self.row(Row { workload, n, method, radius }, || {
                let mut model = bed.model.clone();
                (model.step, model.solver) = (step, workload::solver(method, iterations));
                Ok((model, bed.state.clone()))
            })?)
        })
    }

    /// A row, if there is time for it and memory.
    fn row(&self, row: Row, build: impl FnOnce() -> Result<(Model, State), Fault>) -> Result<Value, Fault> {
        let kind = format!("{} {}", row.workload, row.method.name());
        if let Some(why) = self.time.left_out(&kind, row.n) {
            return Ok(row.without("left_out", why));
        }
        let measured = match self.time.measure(&kind, row.n, || self.measure(row, build()?)) {
            Err(Fault::Gpu(error @ (GpuError::TooLarge { .. } | GpuError::Memory { .. }))) => {
                row.without("does_not_fit", error.to_string())
            }
            measured => measured?,
        };
        eprintln!("{measured}");
        Ok(measured)
    }

    fn measure(
        &self,
        Row { workload, n, method, radius }: Row,
        (model, state): (Model, State),
    ) -> Result<Value, Fault> {
        let mut cpu = (n <= COMPARED).then(|| Simulation::new(model.clone(), state.clone()));
        let mut own = Simulation::on_device(model, state, Device::open(self.adapter)?)?;
        let step = |own: &mut Simulation| {
            own.try_step().map_err(|fault| match fault {
                sim::StepFault::Device(fault) => fault,
                sim::StepFault::Columns(why) => panic!("{why}"),
            })
        };
        for _ in 0..BEFORE {
            step(&mut own)?;
        }
        let (mut stage_ms, mut steps, mut last) = ([0.0; Stage::ALL.len()], 0, None);
        let started = Instant::now();
        let before = own.device_usage().expect("it is on a device");
        let has_time = || !self.time.is_over() && started.elapsed().as_secs_f64() < self.seconds;
        while steps == 0 || (steps < STEPS && has_time()) {
            let report = step(&mut own)?;
            stage_ms.iter_mut().zip(report.stage_ms).for_each(|(sum, ms)| *sum += ms);
            last = Some(report);
            steps += 1;
        }
        let seconds = started.elapsed().as_secs_f64() / steps as f64;
        stage_ms.iter_mut().for_each(|ms| *ms /= steps as f64);
        // What brings the state back is not the steps'.
        let spent = own.device_usage().expect("it is on a device");
        own.fetch()?;
        let stages: Map<String, Value> =
            Stage::ALL.iter().zip(stage_ms).map(|(stage, ms)| (stage.name().to_string(), json!(ms))).collect();
        let off = cpu.as_mut().map(|cpu| {
            (0..BEFORE + steps).for_each(|_| drop(cpu.step()));
            let pairs = own.state.position.iter().zip(&cpu.state.position);
            pairs.map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max)
        });
        let last = last.expect("a step at least");
        let usage = own.device_usage().expect("it is on a device");
        let per_step = |n: u64| n as f64 / steps as f64;
        let dispatches: Map<String, Value> = (usage.dispatches.iter())
            .map(|(stage, n)| (stage.to_string(), json!(per_step(n - before.dispatches.get(stage).unwrap_or(&0)))))
            .collect();
        let traffic = spent.traffic - before.traffic;
        // Where the adapter takes no times, the stage has none.
        let solving = 1e-3 * stage_ms[Stage::ContactSolve as usize];
        let sweeps = per_step(spent.contact_sweeps - before.contact_sweeps);
        let rate = (solving > 0.0).then(|| sweeps / solving);
        Ok(json!({
            "workload": workload, "n": n, "bodies": own.state.position.len(), "method": method.name(),
            "iterations": last.iterations, "contacts": last.contacts, "steps": steps,
            "seconds_per_step": seconds, "stage_ms": stages, "worst_penetration_over_r": last.worst_penetration / radius,
            "contact_iterations_per_second": rate,
            "fraction_of_copy_bandwidth": rate.map(|rate| rate * usage.bytes_per_contact_sweep / self.bandwidth),
            "max_position_difference_m": off, "longest_submission_seconds": usage.longest_submission,
            "dispatches_per_step": dispatches, "submissions_per_step": per_step(traffic.submissions), "waits_per_step": per_step(traffic.waits),
            "device_bytes": usage.most_bytes, "largest_buffer_bytes": usage.largest_buffer,
        }))
    }
}

/// A bed of workload S whose lattice is drawn together so that neighbours touch, and falls.
fn bed(n: usize, method: Method, iterations: u32) -> (Model, State) {
    drawn(Workload::S, n, workload::solver(method, iterations), (1.5e-3, 0.955))
}

/// A workload with its step, s, whose spheres are as much closer.
fn drawn(workload: Workload, n: usize, solver: SolverSettings, (step, closer): (f64, f64)) -> (Model, State) {
    let (model, mut state) = workload::build(workload, n, solver, step);
    for body in (0..model.n_bodies()).filter(|b| model.inv_mass[*b] > 0.0) {
        state.position[body] *= closer;
    }
    (model, state)
}
