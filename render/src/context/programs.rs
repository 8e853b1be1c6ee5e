//! The programs of shaders that this process has compiled: those of a film are the same from frame to frame.

use ri::files::Files;
use sl::Diagnostic;
use sl::ir::Program;
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The most programs that are kept.
const MOST: usize = 256;

/// A file that a shader includes: its name there, the file that includes it, and what is found, its path and text.
type Included = (String, PathBuf, (PathBuf, String));

/// A program, with all that its text includes.
struct Compiled {
    included: Vec<Included>,
    program: Arc<Program>,
}

/// By path and text of the shader.
static COMPILED: Mutex<Option<HashMap<(PathBuf, String), Arc<Compiled>>>> = Mutex::new(None);

/// The program of the shader of a text, read from a path. It is compiled again if a file that it includes is not what it was: these are read each
/// time, as what an image depends on.
///
/// # Errors
/// What is wrong with the text.
pub fn program(path: PathBuf, source: String, files: &Files) -> Result<Arc<Program>, Diagnostic> {
    let key = (path, source);
    let known = compiled().as_ref().and_then(|all| all.get(&key).cloned());
    let is_found = |(name, from, found): &Included| files.include(name, from).as_ref() == Ok(found);
    if let Some(known) = known.filter(|known| known.included.iter().all(is_found)) {
        return Ok(known.program.clone());
    }
    let included = RefCell::new(vec![]);
    let include = |name: &str, from: &Path| {
        let found = files.include(name, from)?;
        included.borrow_mut().push((name.into(), from.into(), found.clone()));
        Ok(found)
    };
    let program = Arc::new(sl::compile_with(&key.0, &key.1, &include)?);
    let own = Arc::new(Compiled { included: included.into_inner(), program: program.clone() });
    let mut all = compiled();
    let all = all.get_or_insert_default();
    if all.len() >= MOST {
        all.clear();
    }
    all.insert(key, own);
    Ok(program)
}

fn compiled() -> MutexGuard<'static, Option<HashMap<(PathBuf, String), Arc<Compiled>>>> {
    COMPILED.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_is_compiled_again_when_a_file_that_it_includes_is_another() {
        let folder = tempfile::tempdir().unwrap();
        let (path, source) = (folder.path().join("s.sl"), "#include \"k.h\"\nsurface s() { Ci = K; }\n");
        let write = |k: f32| std::fs::write(folder.path().join("k.h"), format!("#define K {k}\n")).unwrap();
        let found = || program(path.clone(), source.into(), &Files::default());
        let failed = |found: Result<Arc<Program>, Diagnostic>| found.err().map(|d| d.to_string()).unwrap_or_default();
        assert!(failed(found()).contains("k.h"), "{}", failed(found()));
        write(0.5);
        let [first, again] = [(); 2].map(|()| found().unwrap());
        assert!(Arc::ptr_eq(&first, &again));
        guard::trace();
        found().unwrap();
        let read = guard::trace();
        assert!(read.iter().any(|path| path.ends_with("k.h")), "an image depends on it: {read:?}");
        write(0.25);
        let changed = found().unwrap();
        let body = |program: &Program| format!("{:?}", program.body);
        assert!(!Arc::ptr_eq(&first, &changed) && body(&first) != body(&changed));
        let other = program(path.clone(), source.replace("= K", "= 2 * K"), &Files::default()).unwrap();
        assert!(body(&other) != body(&changed));
        write(0.5);
        assert!(body(&found().unwrap()) == body(&first));
        std::fs::remove_file(folder.path().join("k.h")).unwrap();
        assert!(failed(found()).contains("k.h"));
    }
}
