//! What is wrong in the calls of a directive: told in the scene, or in the metadata file and the files that it names.

use crate::binding::{Binding, Shader};
use frame::{Fault, FaultKind};
use ri::Fail;
use ri::reader::{Place, RibError};

/// What is wrong in the calls of a directive.
pub(super) enum Wrong {
    /// The scene asks for what there is not: told at the directive.
    Scene(Fail),
    /// The metadata file, or a file that it names, is at fault.
    File(Box<Fault>),
}

impl From<Fail> for Wrong {
    fn from(fail: Fail) -> Wrong {
        Wrong::Scene(fail)
    }
}

impl From<Fault> for Wrong {
    fn from(fault: Fault) -> Wrong {
        Wrong::File(fault.into())
    }
}

/// Where the calls come from: a key of the metadata file, and the object of that key if it is of one.
#[derive(Clone, Copy)]
pub(super) struct Origin<'a> {
    pub(super) binding: &'a Binding,
    pub(super) key: &'a str,
    pub(super) object: Option<&'a str>,
}

impl<'a> Origin<'a> {
    /// The origin of a part of an object.
    pub(super) fn key(self, key: &'a str) -> Origin<'a> {
        Origin { key, ..self }
    }

    /// What fails in a call, at the key.
    pub(super) fn wrong(&self, fail: Fail) -> Wrong {
        if let Some((file, (line, column))) = fail.at {
            return self.within(Fault { line, column, ..Fault::whole(FaultKind::Input, &file, fail.message) });
        }
        let of = self.object.map_or(String::new(), |name| format!("the object `{name}`: "));
        self.binding.doc.fault(self.key, of + &fail.message).into()
    }

    /// A fault of a file that the key names, at its own place.
    pub(super) fn within(&self, fault: Fault) -> Wrong {
        let (line, column) = self.binding.doc.place(self.key);
        let of = self.object.map_or(String::new(), |name| format!(", for the object `{name}`"));
        let used = format!("it is used by {}:{line}:{column}{of}", self.binding.doc.path.display());
        let hint = fault.hint.as_ref().map_or(used.clone(), |hint| format!("{hint}; {used}"));
        fault.hint(hint).into()
    }

    /// An error in a RIB file that the key names.
    pub(super) fn in_rib(&self, error: RibError) -> Wrong {
        let RibError { place: Place { file, line, column }, text, message } = error;
        self.within(Fault { kind: FaultKind::Input, file, line, column, text, message, hint: None })
    }
}

/// The key of a shader, or of that parameter of it that a message names.
pub(super) fn key_of_shader(key: &str, shader: &Shader, message: &str) -> String {
    let named = shader.params.iter().find(|param| message.contains(&format!("`{}`", param.decl.name)));
    named.map_or(key.into(), |param| format!("{key}.{}", param.decl.name))
}
