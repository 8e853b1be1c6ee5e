//! Figures of this machine and of this process (Linux; 0 or none elsewhere).

use crate::report::Exit;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The peak memory of this process, bytes.
pub fn peak_bytes() -> u64 {
    kib("/proc/self/status", "VmHWM").unwrap_or(0) * 1024
}

/// The memory of this machine, KiB.
pub fn memory_kib() -> Option<u64> {
    kib("/proc/meminfo", "MemTotal")
}

/// Memory that the user has allowed, bytes.
static ALLOWED: OnceLock<Option<u64>> = OnceLock::new();

/// Let reading and rendering take what the user has `allowed`, bytes, or half of what there is.
pub fn limit_memory(allowed: Option<u64>) {
    let allowed = *ALLOWED.get_or_init(|| allowed);
    let bytes = allowed.or(available_bytes().map(|all| all / 2)).unwrap_or(u64::MAX);
    guard::memory::set_limit(bytes, Exit::Data as i32);
}

/// Do work that may take all memory that there is, or what the user has allowed.
pub fn with_all_memory<T>(work: impl FnOnce() -> T) -> T {
    let before = guard::memory::limit();
    if let Some(None) = ALLOWED.get() {
        guard::memory::set_limit(available_bytes().unwrap_or(u64::MAX), Exit::Data as i32);
    }
    let done = work();
    guard::memory::set_limit(before, Exit::Data as i32);
    done
}

/// The memory that this process can have, bytes: the machine's, that of its control group and its own limits, whichever is least.
fn available_bytes() -> Option<u64> {
    let of_machine = memory_kib().map(|kib| kib * 1024);
    of_machine.into_iter().chain(of_group()).chain(of_limits()).min()
}

/// The least memory of the control groups around this process, as a scheduler or a container sets it.
fn of_group() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let limit = |file: PathBuf| std::fs::read_to_string(file).ok()?.trim().parse::<u64>().ok();
    let of = |line: &str| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, path) = (parts.next()?, parts.next()?.trim_start_matches('/'));
        let (root, name) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            list if list.split(',').any(|c| c == "memory") => ("/sys/fs/cgroup/memory", "memory.limit_in_bytes"),
            _ => return None,
        };
        Path::new(root)
            .join(path)
            .ancestors()
            .take_while(|p| p.starts_with(root))
            .filter_map(|p| limit(p.join(name)))
            .min()
    };
    groups.lines().filter_map(of).min()
}

/// The limits of this process, as `ulimit -v` sets them.
#[cfg(unix)]
fn of_limits() -> Option<u64> {
    let limit = |which| {
        let mut limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
        // SAFETY: the call writes the structure that it is given.
        let done = unsafe { libc::getrlimit(which, &mut limit) };
        (done == 0 && limit.rlim_cur != libc::RLIM_INFINITY).then_some(limit.rlim_cur)
    };
    [libc::RLIMIT_AS, libc::RLIMIT_DATA].into_iter().filter_map(limit).min()
}

#[cfg(not(unix))]
fn of_limits() -> Option<u64> {
    None
}

/// The space that a user has left on the disk of a folder, bytes.
#[cfg(unix)]
pub fn free_bytes(folder: &Path) -> Option<u64> {
    use std::os::unix::ffi::OsStrExt;
    let path = std::ffi::CString::new(folder.as_os_str().as_bytes()).ok()?;
    // SAFETY: all of the structure's fields are numbers, of which 0 is one.
    let mut figures: libc::statvfs = unsafe { std::mem::zeroed() };
    // SAFETY: the path ends with 0, and the call writes the structure that it is given.
    let done = unsafe { libc::statvfs(path.as_ptr(), &mut figures) };
    (done == 0).then(|| figures.f_bavail as u64 * figures.f_frsize as u64)
}

#[cfg(not(unix))]
pub fn free_bytes(_: &Path) -> Option<u64> {
    None
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
