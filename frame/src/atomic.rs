//! Atomic writing of files: to a temporary file in the same folder, which is then renamed, so that a reader never sees a part of a
//! file.

use crate::Fault;
use std::io::Write;
use std::path::Path;

/// Write `bytes` to the file `path`, creating its folder if it is missing. On an error the file is unchanged.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Fault> {
    write_io(path, bytes).map_err(|e| Fault::unwritable(path, &e))
}

fn write_io(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut part = tempfile::Builder::new().prefix(".part-").tempfile_in(folder)?;
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
