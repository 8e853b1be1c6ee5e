//! Solids: what `SolidBegin` makes primitives a part of (RISpec 5.9).

use crate::context::open_solid::OpenSolid;
use crate::context::state::Context;
use crate::scene::attributes::Attribute;
use crate::scene::solid::{Lone, Operation};
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
        let (spot, depth) = (self.scene.warnings.spot(), self.attribute_stack.len());
        self.open_solids.push(OpenSolid { operation, spot, depth, before: self.given() });
        self.attribute_begin()?;
        // What bounds a volume by itself is drawn as it is.
        if outer.is_some() || operation != Operation::Primitive {
            self.attributes.solid = Some(self.scene.solids.add(operation, outer));
            self.sets(Attribute::Solid);
        }
        Ok(())
    }

    /// `SolidEnd`: say that there is nothing in the solid, which encloses nothing then.
    pub(super) fn close_solid(&mut self) -> RiResult {
        self.pop_attributes().map_err(|_| Fail::new("SolidEnd without SolidBegin"))?;
        // Those that another block has ended are none any more.
        while self.open_solids.last().is_some_and(|solid| solid.depth > self.attribute_stack.len()) {
            self.open_solids.pop();
        }
        let here = self.attribute_stack.len();
        let Some(OpenSolid { operation, spot, before, .. }) = self.open_solids.pop_if(|solid| solid.depth == here)
        else {
            return Ok(());
        };
        let [given, kept] = self.given();
        if given == before[0] {
            let name = operation.name();
            let message = format!("`SolidBegin \"{name}\"` has no primitive in it: it encloses nothing");
            self.scene.warnings.add_at(spot, message);
        } else if operation == Operation::Primitive
            && self.attributes.solid.is_none()
            && self.open_object.is_none()
            && given - before[0] == kept - before[1]
        {
            self.scene.solids.lone.push(Lone { sources: before[1] as u32..kept as u32, spot });
        }
        Ok(())
    }

    /// The primitives that were given, to the scene and to objects, and those that the scene has kept.
    fn given(&self) -> [u64; 2] {
        [self.n_given, self.scene.sources.len() as u64]
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
