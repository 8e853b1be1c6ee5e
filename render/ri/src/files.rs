//! The search path of scenes, archives, shaders and textures: folders in order, then files built into the program.

pub use crate::programs::{Permission, resolve};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Text that is UTF-8, or else Latin-1.
pub(crate) fn text_of(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap_or_else(|e| e.into_bytes().into_iter().map(char::from).collect())
}

/// The text of a shader, without the mark of UTF-8 with which some editors begin it.
fn source_of(bytes: Vec<u8>) -> String {
    match bytes.strip_prefix(b"\xef\xbb\xbf") {
        Some(rest) => text_of(rest.to_vec()),
        None => text_of(bytes),
    }
}

/// A search path: folders, then files built into the program.
#[derive(Clone, Debug, Default)]
pub struct Files {
    /// Folders, in the order of the search.
    pub folders: Vec<PathBuf>,
    /// Files built into the program: paths, as `scenes/studio.rib`, and texts.
    pub built_in: Vec<(&'static str, &'static str)>,
    /// Programs that the files may run.
    pub programs: Permission,
    /// How long a program may take for an answer, if not as long as usual.
    pub program_time: Option<Duration>,
}

impl Files {
    /// The search path with these built-in files added: paths and texts.
    pub fn with(mut self, files: &[(&'static str, &'static str)]) -> Files {
        self.built_in.extend_from_slice(files);
        self
    }

    /// Find and read the text file `name`: its path and text. Each folder is searched itself and in the subfolders `rooms`, such as
    /// `scenes` or `shaders/surface`; an absolute path is taken as it is. An error if there is no such file, or it cannot be read
    /// or is not UTF-8.
    pub fn read(&self, name: &str, rooms: &[&str]) -> Result<(PathBuf, String), String> {
        let (path, bytes) = self.read_bytes(name, rooms)?;
        let text = String::from_utf8(bytes).map_err(|_| format!("{} is not UTF-8 text", path.display()))?;
        Ok((path, text))
    }

    /// Find and read the source of a shader, as [`Files::read`] does; what is not UTF-8 is taken for Latin-1, in which old shaders
    /// have their comments.
    pub fn read_source(&self, name: &str, rooms: &[&str]) -> Result<(PathBuf, String), String> {
        let (path, bytes) = self.read_bytes(name, rooms)?;
        Ok((path, source_of(bytes)))
    }

    /// Find and read the file `name`, as [`Files::read`] does: its path and bytes.
    pub fn read_bytes(&self, name: &str, rooms: &[&str]) -> Result<(PathBuf, Vec<u8>), String> {
        let path = Path::new(name);
        let mut places: Vec<PathBuf> = vec![path.into()];
        if path.is_relative() {
            places.clear();
            for folder in &self.folders {
                places.push(folder.join(path));
                places.extend(rooms.iter().map(|room| folder.join(room).join(path)));
            }
        }
        let is_free = |p: &&PathBuf| p.is_file() && guard::permit(p).is_ok();
        let found = places.iter().find(is_free);
        places.iter().take_while(|place| Some(*place) != found).for_each(|place| guard::look_for(place));
        if let Some(found) = found {
            let bytes = guard::read(found).map_err(|e| format!("{} cannot be read: {e}", found.display()))?;
            return Ok((found.clone(), bytes));
        }
        let inside = |p: &str| p == name || rooms.iter().any(|room| p == format!("{room}/{name}"));
        if let Some((p, text)) = self.built_in.iter().find(|(p, _)| inside(p)) {
            return Ok((PathBuf::from(p), text.as_bytes().to_vec()));
        }
        if let Some(other) = places.iter().find(|p| p.exists() && !p.is_file()) {
            let kind = if other.is_dir() { "a folder" } else { "a device, a pipe or a socket" };
            return Err(format!("{} is {kind}, expected a file", other.display()));
        }
        match places.iter().find(|p| p.is_file()).map(|p| (p, guard::permit(p))) {
            Some((path, Err(e))) => Err(format!("{} cannot be read: {e}", path.display())),
            _ => Err(self.not_found(name, rooms)),
        }
    }

    /// Find and read a file that the shader file `from` includes: in that file's own folder, or as [`Files::read`] does in
    /// `shaders/include` and `shaders`.
    pub fn include(&self, name: &str, from: &Path) -> Result<(PathBuf, String), String> {
        let beside = from.parent().map(|folder| folder.join(name));
        beside.iter().for_each(|path| guard::look_for(path));
        match beside.filter(|path| path.is_file()) {
            Some(path) => {
                let bytes = guard::read(&path).map_err(|e| format!("{} cannot be read: {e}", path.display()))?;
                Ok((path, source_of(bytes)))
            }
            None => self.read_source(name, &["shaders/include", "shaders"]),
        }
    }

    fn not_found(&self, name: &str, rooms: &[&str]) -> String {
        let known =
            self.built_in.iter().filter(|(p, _)| rooms.first().is_some_and(|room| p.starts_with(&format!("{room}/"))));
        let near = known
            .map(|(p, _)| p.rsplit('/').next().unwrap_or(p))
            .min_by_key(|p| strsim::damerau_levenshtein(p, name))
            .filter(|p| strsim::damerau_levenshtein(p, name) <= 3);
        let folders: Vec<String> = self
            .folders
            .iter()
            .map(|f| if f.as_os_str().is_empty() { ".".into() } else { f.display().to_string() })
            .collect();
        let folders = folders.into_iter().fold(Vec::new(), |mut list: Vec<String>, f| {
            if !list.contains(&f) {
                list.push(f);
            }
            list
        });
        let hint = near.map_or(String::new(), |n| format!("; did you mean `{n}`?"));
        format!("`{name}` was not found in {} or the library{hint}", folders.join(", "))
    }
}
