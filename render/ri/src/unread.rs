//! Calls of archives that a stream holds and nobody reads: they are made of nothing, so that what is wrong in them is found.

use crate::instances::Instances;
use crate::params::Params;
use crate::ri::{Knots, Ri, RiResult, Tags, TrimCurves};
use crate::table::requests;

/// Takes all calls and does nothing; warnings are kept.
#[derive(Default)]
pub(crate) struct Nobody {
    pub(crate) warnings: Vec<String>,
}

macro_rules! ignored {
    ($(#[doc = $doc:literal] $name:ident [$($where:ident)+]
       $(=> $method:ident($($kind:ident $($what:literal)? ($($arg:ident: $ty:ty),+))*))?;)*) => {
        #[allow(unused_variables)]
        impl Ri for Nobody {
            $($(
                fn $method(&mut self, $($($arg: $ty),+),*) -> RiResult {
                    Ok(())
                }
            )?)*

            fn archive_record(&mut self, kind: &str, text: &str) -> RiResult {
                Ok(())
            }

            fn warn(&mut self, message: String) {
                self.warnings.push(message);
            }

            fn instances(&mut self, instances: Instances) -> RiResult {
                Ok(())
            }
        }
    };
}
requests!(ignored);
