//! Primitive variables attached to shaders: the slots in which the shaders of a primitive find its variables.

use crate::scene::attributes::Attributes;
use crate::scene::variables::{VariableName, VariableNames};
use ri::Type;
use sl::machine::{BoundShader, VariableSlots};

/// The variables of a primitive, attached to its shaders: slots are those of [`sl::machine::Points`], in turn the uniform variables
/// of its source, those of its instance, and the uniform and the varying ones of its patches.
#[derive(Debug, Default)]
pub struct Attached {
    /// Names by slots, and how many numbers a value has.
    names: Vec<(String, usize)>,
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
    /// For s and t the slot of the source or the instance that has them, and which of its numbers they are.
    pub coordinates: [Option<(usize, usize)>; 2],
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
        let slots = |shader: Option<&BoundShader>, names: &[(String, usize)]| {
            shader.map_or(VariableSlots::default(), |shader| VariableSlots::of(&shader.program, names))
        };
        let all = || own.iter().chain(&patches.uniform).chain(&patches.varying);
        let names: Vec<(String, usize)> = all().map(|variable| (variable.name.clone(), variable.width)).collect();
        let is_spatial = |ty: Type| matches!(ty, Type::Point | Type::Vector | Type::Normal | Type::HPoint);
        let spatial = all()
            .enumerate()
            .filter(|(_, variable)| is_spatial(variable.ty))
            .map(|(slot, variable)| Spatial { slot, ty: variable.ty, of_source: slot < own.len() });
        let slot = |name: &str, width: usize| names.iter().position(|(n, w)| n == name && *w == width);
        let of_source = |found: Option<usize>| found.filter(|slot| *slot < own.len());
        let coordinate = |name: &str, k: usize| {
            let alone = of_source(slot(name, 1)).map(|slot| (slot, 0));
            alone.or(of_source(slot("st", 2)).map(|slot| (slot, k)))
        };
        Attached {
            n_uniform: own.len() + patches.uniform.len(),
            surface: slots(Some(&attributes.surface), &names),
            displacement: slots(attributes.displacement.as_deref(), &names),
            atmosphere: slots(attributes.atmosphere.as_deref(), &names),
            coordinates: [coordinate("s", 0), coordinate("t", 1)],
            color: slot("Cs", 3),
            opacity: slot("Os", 3),
            spatial: spatial.collect(),
            names,
        }
    }

    /// The slot of the variable of a name.
    pub fn slot(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|(n, _)| n == name)
    }

    /// The names of all variables by their slots, and how many numbers a value of each has.
    pub fn names(&self) -> &[(String, usize)] {
        &self.names
    }
}
