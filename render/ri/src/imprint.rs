//! An [`Ri`] that writes what tells calls apart, for a hash: RIB, but instance arrays by their columns rather than as standard calls.

use crate::instances::{InstanceShape, Instances};
use crate::params::{Params, Values};
use crate::ri::{Knots, Ri, RiResult, Tags, TrimCurves};
use crate::table::requests;
use crate::writer::Writer;
use std::io::Write;

/// A writer of imprints onto a byte stream: the same calls give the same bytes, and other calls others.
pub struct Imprint<W: Write>(Writer<W>);

impl<W: Write> Imprint<W> {
    /// An imprint onto `out`.
    pub fn new(out: W) -> Imprint<W> {
        Imprint(Writer::archive(out))
    }

    /// The byte stream that was written.
    pub fn into_inner(self) -> W {
        self.0.into_inner()
    }
}

macro_rules! methods {
    ($(#[doc = $doc:literal] $name:ident [$($where:ident)+]
       $(=> $method:ident($($kind:ident $($what:literal)? ($($arg:ident: $ty:ty),+))*))?;)*) => {
        impl<W: Write> Ri for Imprint<W> {
            $($(
                fn $method(&mut self, $($($arg: $ty),+),*) -> RiResult {
                    self.0.$method($($($arg),+),*)
                }
            )?)*

            fn archive_record(&mut self, _kind: &str, _text: &str) -> RiResult {
                Ok(())
            }

            /// The call itself says what there is to warn of, when it is made.
            fn warn(&mut self, _message: String) {}

            fn instances(&mut self, all: Instances) -> RiResult {
                let bytes = imprint(&all);
                self.0.raw(&bytes)
            }
        }
    };
}
requests!(methods);

/// The bytes of an instance array. Each column has its length before it.
fn imprint(all: &Instances) -> Vec<u8> {
    let mut bytes = b"instances".to_vec();
    let text = |bytes: &mut Vec<u8>, text: &str| {
        bytes.extend((text.len() as u64).to_le_bytes());
        bytes.extend(text.bytes());
    };
    match &all.shape {
        InstanceShape::Sphere => text(&mut bytes, "sphere"),
        InstanceShape::Object(handle) => text(&mut bytes, &format!("object {handle}")),
    }
    let column = |bytes: &mut Vec<u8>, numbers: &[f32]| {
        bytes.extend((numbers.len() as u64).to_le_bytes());
        bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    };
    column(&mut bytes, all.position.as_flattened());
    column(&mut bytes, all.orientation.as_flattened());
    column(&mut bytes, all.scale.as_flattened());
    column(&mut bytes, all.offset.as_flattened());
    for param in &all.params {
        text(&mut bytes, &param.decl.inline());
        match &param.values {
            Values::Floats(numbers) => column(&mut bytes, numbers),
            Values::Strings(texts) => texts.iter().for_each(|s| text(&mut bytes, s)),
        }
    }
    if let Some((times, to)) = &all.moved {
        column(&mut bytes, times);
        column(&mut bytes, to.as_flattened());
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{Class, Param, Type};

    #[test]
    fn calls_that_differ_have_other_imprints() {
        let calls = |radius: f32, x: f32, red: f32| {
            let mut ri = Imprint::new(vec![]);
            ri.sphere(radius, -radius, radius, 360.0, vec![]).unwrap();
            let params = vec![Param::floats("Cs", Class::Uniform, Type::Color, [red, 0.0, 0.0])];
            let (position, orientation, scale) = (vec![[x, 0.0, 0.0]], vec![], vec![]);
            let shape = InstanceShape::Sphere;
            ri.instances(Instances { shape, position, orientation, scale, offset: vec![], params, moved: None })
                .unwrap();
            ri.into_inner()
        };
        let one = calls(1.0, 2.0, 0.5);
        assert_eq!(one, calls(1.0, 2.0, 0.5));
        for other in [calls(1.5, 2.0, 0.5), calls(1.0, 2.1, 0.5), calls(1.0, 2.0, 0.4)] {
            assert_ne!(one, other);
        }
    }
}
