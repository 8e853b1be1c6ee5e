//! Claims on tasks: who works on one, so that two who work on the same images share them. A claim is a lock on a byte of a file, which
//! the ledger has for images and a run directory for its simulation; the system ends it with its process, on whatever machine of a shared file system that runs.

use std::fs::File;
use std::path::Path;

/// The claims that a file has.
pub struct Claims {
    /// The file of the locks; none where there are no locks, and then every task is free.
    file: Option<File>,
}

/// A claim on a task, until it is dropped.
pub struct Claim<'a> {
    claims: &'a Claims,
    at: i64,
}

impl Claims {
    /// The claims of a file, which is made if it is not there, with its folder.
    pub fn open(path: &Path) -> Claims {
        let make = || {
            std::fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
            std::fs::OpenOptions::new().create(true).truncate(false).write(true).open(path)
        };
        Claims { file: make().ok() }
    }

    /// Claim a task; none if another process has it.
    pub fn claim(&self, task: &str) -> Option<Claim<'_>> {
        let hash = blake3::hash(task.as_bytes());
        let head: [u8; 8] = hash.as_bytes()[..8].try_into().expect("eight bytes of 32");
        // Offsets of files are below 2⁶³.
        let at = (u64::from_le_bytes(head) >> 2) as i64;
        self.lock(at, true).then_some(Claim { claims: self, at })
    }

    /// Lock a byte, or let it go; false if another process has it.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    fn lock(&self, at: i64, is_taken: bool) -> bool {
        use std::os::fd::AsRawFd;
        let Some(file) = &self.file else { return true };
        let kind = if is_taken { libc::F_WRLCK } else { libc::F_UNLCK };
        // SAFETY: a zeroed `flock` is valid, and the call only reads it; the file is open.
        unsafe {
            let mut range: libc::flock = std::mem::zeroed();
            (range.l_type, range.l_whence) = (kind as i16, libc::SEEK_SET as i16);
            (range.l_start, range.l_len) = (at, 1);
            libc::fcntl(file.as_raw_fd(), libc::F_OFD_SETLK, &range) == 0
                || !matches!(std::io::Error::last_os_error().raw_os_error(), Some(libc::EAGAIN | libc::EACCES))
        }
    }

    /// Locks of bytes that go by open files are Linux's: elsewhere every task is free, and its image is drawn by whoever comes.
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    fn lock(&self, _at: i64, _is_taken: bool) -> bool {
        true
    }
}

impl Drop for Claim<'_> {
    fn drop(&mut self) {
        self.claims.lock(self.at, false);
    }
}

#[cfg(all(test, target_os = "linux", target_env = "gnu"))]
mod tests {
    use super::*;

    #[test]
    fn a_task_is_claimed_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("locks/lock");
        let (one, other) = (Claims::open(&path), Claims::open(&path));
        let claim = one.claim("000001.png");
        assert!(claim.is_some() && other.claim("000001.png").is_none() && other.claim("000002.png").is_some());
        drop(claim);
        assert!(other.claim("000001.png").is_some());
    }
}
