//! `scree doctor`: processors, memory, graphics adapters and tools of the machine, as far as scree can use them.

use crate::report::Outcome;
use crate::{machine, movie};

/// Run `scree doctor`.
pub fn run() -> Outcome {
    println!("scree {}", env!("CARGO_PKG_VERSION"));
    println!("processors: {}", rayon::current_num_threads());
    if let Some(kib) = machine::memory_kib() {
        println!("memory: {:.1} GiB", kib as f64 / 1_048_576.0);
    }
    let lanes = |wide: bool| if wide { "AVX2" } else { "plain" };
    println!("lanes: {} for contacts, {} for samples", lanes(sim::has_wide_lanes()), lanes(render::has_wide_lanes()));
    match movie::ffmpeg_version() {
        Some(version) => println!("movies: {version}"),
        None => println!(
            "movies: ffmpeg is not on PATH; animated PNGs are written instead (Debian: apt-get install ffmpeg)"
        ),
    }
    let adapters = gpu::adapters();
    if adapters.is_empty() {
        println!("graphics: no Vulkan adapter; everything runs on the processor");
    }
    for a in adapters {
        let kind = if a.software { "software, for tests only" } else { "usable" };
        println!("graphics: {} ({}): {kind}", a.name, a.driver);
    }
    println!("simulation and rendering run on the processor");
    Ok(())
}
