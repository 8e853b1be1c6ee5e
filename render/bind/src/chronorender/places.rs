//! Where the parts of a job are looked for.

use std::path::{Path, PathBuf};

/// The folders of a job: its own, then its search paths.
pub(super) struct Places(pub(super) Vec<PathBuf>);

impl Places {
    /// Where jobs keep their parts: the folders, and those beside and around the file, whose layout its author had elsewhere.
    pub(super) fn rooms(&self) -> Vec<PathBuf> {
        let mut out = self.0.clone();
        let folder = &self.0[0];
        let around = [folder.clone(), folder.join("..")];
        for base in around {
            out.push(base.clone());
            let inner = std::fs::read_dir(&base).into_iter().flatten().flatten().map(|e| e.path());
            let mut inner: Vec<PathBuf> = inner.filter(|p| p.is_dir()).collect();
            inner.sort();
            out.extend(inner);
        }
        // Ours: where the command is called.
        out.push(PathBuf::from("."));
        out
    }

    /// The file of a name, or of the name's last part.
    pub(super) fn locate(&self, file: &Path) -> Option<PathBuf> {
        let rooms = self.rooms();
        let whole = rooms.iter().map(|room| room.join(file)).find(|p| p.is_file());
        let by_name =
            || file.file_name().and_then(|name| rooms.iter().map(|room| room.join(name)).find(|p| p.is_file()));
        let found = whole.or_else(by_name)?;
        Some(std::fs::canonicalize(&found).unwrap_or(found))
    }

    /// The first place where files fit a pattern: as it stands, then by its last parts alone.
    pub(super) fn locate_pattern(&self, pattern: &str) -> Option<PathBuf> {
        let parts: Vec<&str> = pattern.split('/').filter(|p| !matches!(*p, "" | "." | "..")).collect();
        let fits = |p: &Path| frame::sequence::find(p).is_ok_and(|f| !f.is_empty());
        let rooms = self.rooms();
        let mut tries: Vec<PathBuf> = rooms.iter().take(self.0.len()).map(|r| r.join(pattern)).collect();
        for k in 0..parts.len() {
            let tail: PathBuf = parts[k..].iter().collect();
            tries.extend(rooms.iter().map(|r| r.join(&tail)));
        }
        let found = tries.into_iter().find(|p| fits(p))?;
        // Absolute, as our own metadata's folder may be another.
        let folder = found.parent().and_then(|p| std::fs::canonicalize(p).ok())?;
        Some(folder.join(found.file_name()?))
    }
}
