//! A call of `Blobby`, kept until its motion block ends.

use crate::gprim::blobby::motion::blend;
use crate::gprim::blobby::{Field, LeafVariable};
use crate::gprim::variables::attach_variables;
use crate::scene::patch::Patch;
use crate::scene::variables::{VariableName, VariableNames};
use ri::{Fail, Params, Type};

/// A call of `Blobby`.
pub struct BlobbyCall {
    leaves: usize,
    codes: Vec<i32>,
    floats: Vec<f32>,
    /// Variables of the leaves, by name.
    varying: Vec<(VariableName, LeafVariable)>,
    /// Those of the whole.
    whole: Params,
}

impl BlobbyCall {
    pub fn new(leaves: i32, codes: Vec<i32>, floats: Vec<f32>, params: Params) -> Result<BlobbyCall, Fail> {
        let mut varying = Vec::new();
        for param in params.iter().filter(|p| !p.decl.class.is_whole() && !p.numbers().is_empty()) {
            let width = param.decl.width();
            if param.numbers().len() != width * leaves as usize {
                return Err(Fail::new(format!("`{}` needs a value for each of {leaves} leaves", param.decl.name)));
            }
            // The field gives the normals.
            if param.decl.name != "N" {
                let is_place = param.decl.ty == Type::MatrixPoint;
                let ty = if is_place { Type::Point } else { param.decl.ty };
                let variable = LeafVariable { numbers: width, values: param.numbers().to_vec(), is_place };
                varying.push((VariableName::of_type(&param.decl, ty), variable));
            }
        }
        let whole = params.iter().filter(|p| p.decl.class.is_whole()).cloned().collect();
        let call = BlobbyCall { leaves: leaves.max(0) as usize, codes, floats, varying, whole };
        call.field().map(|_| call)
    }

    fn field(&self) -> Result<Field, Fail> {
        self.field_of(&self.floats)
    }

    /// The field of other numbers.
    pub fn field_of(&self, floats: &[f32]) -> Result<Field, Fail> {
        Field::new(self.leaves, &self.codes, floats)
    }

    /// The numbers at a part of the way to those of a call like this.
    pub fn floats_towards(&self, other: &BlobbyCall, part: f32) -> Vec<f32> {
        blend(&self.floats, &other.floats, part)
    }

    /// The variables of the leaves at a part of the way to those of a call like this.
    pub fn variables_towards(&self, other: &BlobbyCall, part: f32) -> Vec<LeafVariable> {
        let pairs = self.varying.iter().zip(&other.varying);
        let mixed = pairs.map(|((_, a), (_, b))| LeafVariable { values: blend(&a.values, &b.values, part), ..*a });
        mixed.collect()
    }

    /// Whether another call differs in numbers alone.
    pub fn is_like(&self, other: &BlobbyCall) -> bool {
        let names = |call: &BlobbyCall| call.varying.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        self.codes == other.codes && self.floats.len() == other.floats.len() && names(self) == names(other)
    }

    /// Whether another call, which is like it, gives the variables other values.
    pub fn varies_from(&self, other: &BlobbyCall) -> bool {
        let values = |call: &BlobbyCall| call.varying.iter().map(|(_, v)| v.values.clone()).collect::<Vec<_>>();
        values(self) != values(other) || self.whole != other.whole
    }

    /// The patches of a net, with the names of their variables.
    pub fn attached(&self, mut patches: Vec<Patch>) -> Result<(Vec<Patch>, VariableNames), Fail> {
        let VariableNames { uniform, .. } = attach_variables(&mut patches, &self.whole)?;
        let varying = self.varying.iter().map(|(name, _)| name.clone()).collect();
        Ok((patches, VariableNames { uniform, varying }))
    }

    /// The patches of the blobby as it is.
    pub fn patches(&self) -> Result<(Vec<Patch>, VariableNames), Fail> {
        let field = self.field()?;
        self.attached(field.patches(&field.net(), &self.variables_towards(self, 0.0)))
    }
}
