//! Atomic writing of files: to a temporary file in the same folder, which is then renamed, so that a reader never sees a part of a
//! file.

use crate::Fault;
use std::io::Write;
use std::path::Path;

/// Write `bytes` to the file `path`, creating its folder if it is missing. On an error the file is unchanged.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Fault> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|e| Fault::unwritable(folder, &e))?;
    write_in(folder, path, bytes).map_err(|e| Fault::unwritable(path, &e))
}

/// What the names of temporary files begin with.
const PREFIX: &str = ".part-";

/// Remove the temporary files that writers of this machine have left in a folder, which were ended before they could.
pub fn sweep(folder: &Path) {
    let own = format!("{PREFIX}{}-", host());
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let writer = name.strip_prefix(&own).and_then(|rest| rest.split_once('-')?.0.parse::<u32>().ok());
        let is_left = |writer: u32| !Path::new("/proc").join(writer.to_string()).exists();
        if Path::new("/proc/self").exists() && writer.is_some_and(is_left) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// The name of this machine, in letters, digits and dots.
fn host() -> String {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    name.trim().chars().filter(|c| c.is_ascii_alphanumeric() || *c == '.').collect()
}

fn write_in(folder: &Path, path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut part =
        tempfile::Builder::new().prefix(&format!("{PREFIX}{}-{}-", host(), std::process::id())).tempfile_in(folder)?;
    part.write_all(bytes)?;
    part.flush()?;
    publish_permissions(part.as_file())?;
    part.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// Temporary files are private; what is published is readable as any file of the user's.
fn publish_permissions(file: &std::fs::File) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        file.set_permissions(std::fs::Permissions::from_mode(0o644))?;
    }
    let _ = file;
    Ok(())
}
