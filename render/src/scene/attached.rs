//! Primitive variables attached to shaders: the slots in which the shaders of a primitive find its variables.

use crate::scene::attributes::Attributes;
use crate::scene::variables::VariableNames;
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
    /// For the displacement shader, which has the variables of source and instance alone.
    pub displacement: VariableSlots,
    /// For the atmosphere shader.
    pub atmosphere: VariableSlots,
    /// The slot of `Cs`.
    pub color: Option<usize>,
    /// The slot of `Os`.
    pub opacity: Option<usize>,
}

impl Attached {
    /// Attach variables to the shaders of some attributes: `own` are the names of the source's and the instance's, the others those
    /// of the patches.
    pub fn new(attributes: &Attributes, own: Vec<String>, patches: &VariableNames) -> Attached {
        let slots = |shader: Option<&BoundShader>, names: &[String]| {
            shader.map_or(VariableSlots::default(), |shader| VariableSlots::of(&shader.program, names))
        };
        let displacement = slots(attributes.displacement.as_deref(), &own);
        let n_uniform = own.len() + patches.uniform.len();
        let mut names = own;
        names.extend(patches.uniform.iter().chain(&patches.varying).cloned());
        let slot = |name: &str| names.iter().position(|n| n == name);
        Attached {
            n_uniform,
            surface: slots(Some(&attributes.surface), &names),
            displacement,
            atmosphere: slots(attributes.atmosphere.as_deref(), &names),
            color: slot("Cs"),
            opacity: slot("Os"),
            names,
        }
    }

    /// The slot of the variable of a name.
    pub fn slot(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }
}
