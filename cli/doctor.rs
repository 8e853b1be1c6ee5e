//! `scree doctor`: processors, memory, graphics adapters, tools, scheduler and output folder of the machine, as far as scree can use them.

use crate::job::DoctorJob;
use crate::report::{Exit, Failure, Outcome};
use crate::{batch, machine, movie, preview};
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What scree finds of a machine.
#[derive(Serialize)]
struct Findings {
    scree: &'static str,
    processors: usize,
    memory_bytes: Option<u64>,
    /// Kinds of vector lanes.
    contact_lanes: &'static str,
    sample_lanes: &'static str,
    /// First line of `ffmpeg -version`.
    ffmpeg: Option<String>,
    /// Of each kind of movie, the encoder that makes it; none if ffmpeg has none of those that scree knows.
    encoders: Vec<(&'static str, Option<&'static str>)>,
    adapters: Vec<Adapter>,
    slurm: Option<batch::Slurm>,
    /// The program that shows previews.
    preview: Option<PathBuf>,
    output: Output,
}

#[derive(Serialize)]
struct Adapter {
    /// By which, or by a part of its name, it is chosen.
    index: usize,
    name: String,
    driver: String,
    is_software: bool,
    max_buffer_bytes: u64,
    max_binding_bytes: u64,
    workgroup_memory_bytes: u32,
    max_workgroup_invocations: u32,
    /// Least and greatest size.
    subgroup_size: Option<[u32; 2]>,
    features: Vec<&'static str>,
}

impl Adapter {
    fn of(a: gpu::Adapter) -> Adapter {
        Adapter {
            index: a.index,
            name: a.name,
            driver: a.driver,
            is_software: a.software,
            max_buffer_bytes: a.max_buffer,
            max_binding_bytes: a.max_binding,
            workgroup_memory_bytes: a.workgroup_memory,
            max_workgroup_invocations: a.max_invocations,
            subgroup_size: a.subgroup,
            features: a.features,
        }
    }

    fn print(&self) {
        const MIB: u64 = 1 << 20;
        let kind = if self.is_software { "software, for tests only" } else { "hardware" };
        println!("graphics: adapter {}: {} ({}): {kind}", self.index, self.name, self.driver);
        let [buffer, binding] = [self.max_buffer_bytes, self.max_binding_bytes].map(|bytes| bytes / MIB);
        println!(
            "  buffers up to {buffer} MiB, bound up to {binding} MiB; workgroups up to {} invocations and {} KiB",
            self.max_workgroup_invocations,
            self.workgroup_memory_bytes / 1024
        );
        let subgroups = match self.subgroup_size {
            Some([least, most]) if least == most => format!("subgroups of {least}"),
            Some([least, most]) => format!("subgroups of {least} to {most}"),
            None => "no subgroups".into(),
        };
        let others = self.features.iter().filter(|name| **name != "subgroups");
        println!("  {}", others.fold(subgroups, |text, name| text + ", " + name));
    }
}

/// The folder that results would go to.
#[derive(Serialize)]
struct Output {
    folder: PathBuf,
    free_bytes: Option<u64>,
    /// Speed of writing a file, until it is on the disk, bytes/s.
    write_bytes_per_second: f64,
}

/// Run `scree doctor`.
pub fn run(job: DoctorJob) -> Outcome {
    let findings = Findings {
        scree: env!("CARGO_PKG_VERSION"),
        processors: rayon::current_num_threads(),
        memory_bytes: machine::memory_kib().map(|kib| kib * 1024),
        contact_lanes: match sim::registers() {
            sim::Registers::Arrays => "plain",
            sim::Registers::Avx2 => "AVX2",
            sim::Registers::Avx512 => "AVX-512",
        },
        sample_lanes: if render::has_wide_lanes() { "AVX2" } else { "plain" },
        ffmpeg: movie::ffmpeg_version(),
        encoders: movie::encoders(),
        adapters: gpu::adapters().into_iter().map(Adapter::of).collect(),
        slurm: batch::slurm(),
        preview: preview::program().ok(),
        output: output(&job.folder)?,
    };
    if job.json {
        println!("{}", serde_json::to_string_pretty(&findings).unwrap_or_default());
    } else {
        findings.print();
    }
    Ok(())
}

/// Measure the folder of results by writing a file that is then removed.
fn output(folder: &Path) -> Outcome<Output> {
    /// Size of the file, bytes.
    const SIZE: usize = 64 << 20;
    let fault = |e: std::io::Error| Failure::new(Exit::Fault, format!("{} cannot be written: {e}", folder.display()));
    let part: Vec<u8> = (0..1_u32 << 18).flat_map(|k| k.wrapping_mul(0x9e37_79b9).to_le_bytes()).collect();
    let mut file = tempfile::tempfile_in(folder).map_err(fault)?;
    let started = Instant::now();
    for _ in 0..SIZE / part.len() {
        file.write_all(&part).map_err(fault)?;
    }
    file.sync_all().map_err(fault)?;
    let write_bytes_per_second = SIZE as f64 / started.elapsed().as_secs_f64();
    let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
    Ok(Output { free_bytes: machine::free_bytes(&folder), folder, write_bytes_per_second })
}

impl Findings {
    fn print(&self) {
        const GIB: f64 = (1_u64 << 30) as f64;
        println!("scree {}", self.scree);
        println!("processors: {}", self.processors);
        if let Some(bytes) = self.memory_bytes {
            println!("memory: {:.1} GiB", bytes as f64 / GIB);
        }
        println!("lanes: {} for contacts, {} for samples", self.contact_lanes, self.sample_lanes);
        match &self.ffmpeg {
            Some(version) => {
                println!("movies: {version}");
                for (kind, encoder) in &self.encoders {
                    println!(
                        "  {kind} {}",
                        encoder.map_or("cannot be made: ffmpeg has no encoder of it".into(), |e| format!("by {e}"))
                    );
                }
            }
            None => println!(
                "movies: ffmpeg is not on PATH; animated PNGs are written instead (Debian: apt-get install ffmpeg)"
            ),
        }
        if self.adapters.is_empty() {
            println!("graphics: no Vulkan adapter; everything runs on the processor");
        } else {
            self.adapters.iter().for_each(Adapter::print);
            println!("everything runs on the processor but `simulate --backend gpu` and `render --backend gpu`");
        }
        match &self.preview {
            Some(program) => println!("previews: {}", program.display()),
            None => println!("previews: scree-preview is not installed (`cargo install --locked --path preview`)"),
        }
        match &self.slurm {
            Some(slurm) => {
                let most = slurm.most_tasks.map_or("not answering".into(), |n| format!("arrays of up to {n} tasks"));
                let version = if slurm.version.is_empty() { "Slurm" } else { &slurm.version };
                println!("cluster: {version}, {most}");
                slurm.faults.iter().for_each(|fault| println!("  {fault}"));
                for p in &slurm.partitions {
                    println!(
                        "  partition {}: {} nodes of {} processors and {} MB, up to {}",
                        p.name, p.nodes, p.cpus, p.memory_mb, p.time
                    );
                }
            }
            None => println!(
                "cluster: Slurm is not on PATH; films are made by processes of this machine, or by scripts of --dry-run"
            ),
        }
        let Output { folder, free_bytes, write_bytes_per_second } = &self.output;
        let free = free_bytes.map_or(String::new(), |bytes| format!(", {:.1} GiB free", bytes as f64 / GIB));
        println!("output: {} takes {:.0} MB/s{free}", folder.display(), write_bytes_per_second / 1e6);
    }
}
