//! Primitive variables that parameters of shaders take their values from.

use crate::ir::{Operand, Program};

/// The slots of the primitive variables that override the parameters of a program: names are looked up once per primitive and
/// shader, not once per grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VariableSlots {
    /// By the slots of parameters; empty if no variable has the name of one.
    of_parameter: Vec<Option<usize>>,
}

impl VariableSlots {
    /// Match the parameters of a program with primitive variables, whose names are given in the order of their slots; of two
    /// variables of one name the first counts.
    pub fn of(program: &Program, names: &[String]) -> VariableSlots {
        let slot = |name: &str| names.iter().position(|n| n == name);
        let of_parameter: Vec<Option<usize>> = if names.is_empty() {
            vec![]
        } else {
            let numbers = |p| matches!(p, Operand::Number(_));
            program.params.iter().map(|p| slot(&p.name).filter(|_| numbers(p.reg))).collect()
        };
        let any = of_parameter.iter().any(Option::is_some);
        VariableSlots { of_parameter: if any { of_parameter } else { vec![] } }
    }

    /// The slot of the variable that goes before a parameter.
    pub(in crate::back) fn of_parameter(&self, parameter: usize) -> Option<usize> {
        self.of_parameter.get(parameter).copied().flatten()
    }
}
