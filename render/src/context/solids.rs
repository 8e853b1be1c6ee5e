//! Solids: what `SolidBegin` makes primitives a part of (RISpec 5.9).

use crate::context::state::Context;
use crate::scene::attributes::Attribute;
use crate::scene::solid::Operation;
use ri::{Fail, Ri, RiResult};

/// The most solids that one may be within.
const DEEPEST: u32 = 256;

impl Context {
    /// `SolidBegin`.
    pub(super) fn open_solid(&mut self, operation: &str) -> RiResult {
        let Some(operation) = Operation::of_name(operation) else {
            let message = format!("unknown solid `{operation}`, expected primitive, union, intersection or difference");
            return Err(Fail::new(message));
        };
        let outer = self.attributes.solid;
        if outer.is_some_and(|outer| self.scene.solids.operation(outer) == Operation::Primitive) {
            return Err(Fail::new("SolidBegin within SolidBegin \"primitive\", which holds primitives alone"));
        }
        if outer.is_some_and(|outer| self.scene.solids.depth(outer) + 1 >= DEEPEST) {
            return Err(Fail::new(format!("solids are nested more than {DEEPEST} deep")));
        }
        self.attribute_begin()?;
        // What bounds a volume by itself is drawn as it is.
        if outer.is_some() || operation != Operation::Primitive {
            self.attributes.solid = Some(self.scene.solids.add(operation, outer));
            self.sets(Attribute::Solid);
        }
        Ok(())
    }

    /// A primitive that stands in a solid of parts is a part by itself. Answers the solid around it, to be set again.
    pub(super) fn enter_part(&mut self) -> Option<u32> {
        let outer = self.attributes.solid;
        if let Some(solid) = outer.filter(|solid| self.scene.solids.operation(*solid) != Operation::Primitive) {
            self.attributes.solid = Some(self.scene.solids.add(Operation::Primitive, Some(solid)));
            self.sets(Attribute::Solid);
        }
        outer
    }
}
