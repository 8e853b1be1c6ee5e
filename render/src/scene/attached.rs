//! Primitive variables attached to shaders: the slots in which the shaders of a primitive find its variables.

use crate::scene::attributes::Attributes;
use crate::scene::variables::{VariableName, VariableNames};
use ri::Type;
use sl::machine::{BoundShader, VariableSlots};

/// The variables of a primitive, attached to its shaders: slots are those of [`sl::machine::Points`], in turn the uniform variables
/// of its source, those of its instance, and the uniform and the varying ones of its patches.
#[derive(Debug, Default)]
pub struct Attached {
    /// Names by slots.
    names: Vec<String>,
    /// Count of those that are the same all over, which come first.
    pub n_uniform: usize,
    /// For the surface shader.
    pub surface: VariableSlots,
    /// For the displacement shader.
    pub displacement: VariableSlots,
    /// For the atmosphere shader.
    pub atmosphere: VariableSlots,
    /// The slot of `Cs`.
    pub color: Option<usize>,
    /// The slot of `Os`.
    pub opacity: Option<usize>,
    /// Those that are of a place or a direction, which shaders want in world space.
    pub spatial: Vec<Spatial>,
}

/// A variable of places or directions.
#[derive(Clone, Copy, Debug)]
pub struct Spatial {
    /// Its slot.
    pub slot: usize,
    /// Point, vector, normal or homogeneous point.
    pub ty: Type,
    /// It is the source's or the instance's, and not the patch's.
    pub of_source: bool,
}

impl Attached {
    /// Attach variables to the shaders of some attributes: `own` are the names of the source's and the instance's, the others those
    /// of the patches.
    pub fn new(attributes: &Attributes, own: &[VariableName], patches: &VariableNames) -> Attached {
        let slots = |shader: Option<&BoundShader>, names: &[String]| {
            shader.map_or(VariableSlots::default(), |shader| VariableSlots::of(&shader.program, names))
        };
        let all = || own.iter().chain(&patches.uniform).chain(&patches.varying);
        let names: Vec<String> = all().map(|variable| variable.name.clone()).collect();
        let is_spatial = |ty: Type| matches!(ty, Type::Point | Type::Vector | Type::Normal | Type::HPoint);
        let spatial = all()
            .enumerate()
            .filter(|(_, variable)| is_spatial(variable.ty))
            .map(|(slot, variable)| Spatial { slot, ty: variable.ty, of_source: slot < own.len() });
        let slot = |name: &str| names.iter().position(|n| n == name);
        Attached {
            n_uniform: own.len() + patches.uniform.len(),
            surface: slots(Some(&attributes.surface), &names),
            displacement: slots(attributes.displacement.as_deref(), &names),
            atmosphere: slots(attributes.atmosphere.as_deref(), &names),
            color: slot("Cs"),
            opacity: slot("Os"),
            spatial: spatial.collect(),
            names,
        }
    }

    /// The slot of the variable of a name.
    pub fn slot(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }
}
