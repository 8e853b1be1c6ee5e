//! Figures of this machine and of this process (Linux; 0 or none elsewhere).

/// The peak memory of this process, bytes.
pub fn peak_bytes() -> u64 {
    kib("/proc/self/status", "VmHWM").unwrap_or(0) * 1024
}

/// The memory of this machine, KiB.
pub fn memory_kib() -> Option<u64> {
    kib("/proc/meminfo", "MemTotal")
}

/// A value in KiB of a file in /proc.
fn kib(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    text.lines().find(|l| l.starts_with(key))?.split_whitespace().nth(1)?.parse().ok()
}

/// Processor time of this process so far, user and system, s.
pub fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}
