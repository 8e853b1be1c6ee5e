//! Primitive variables that parameters of shaders take their values from.

use crate::ir::{Operand, Parameter, Program};

/// The slots of the primitive variables that override the parameters of a program: names are looked up once per primitive and
/// shader, not once per grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VariableSlots {
    /// By the slots of parameters; empty if no variable has the name of one.
    of_parameter: Vec<Option<usize>>,
}

impl VariableSlots {
    /// Match the parameters of a program with primitive variables, whose names are given in the order of their slots, with how many
    /// numbers a value of each has; of two variables of one name the first counts. One that has other numbers than the parameter is
    /// none of it.
    pub fn of(program: &Program, variables: &[(String, usize)]) -> VariableSlots {
        let of_parameter: Vec<Option<usize>> = if variables.is_empty() {
            vec![]
        } else {
            let fits = |p: &Parameter, slot: &usize| numbers(p) == Some(variables[*slot].1);
            program.params.iter().map(|p| slot_of(variables, &p.name).filter(|slot| fits(p, slot))).collect()
        };
        let any = of_parameter.iter().any(Option::is_some);
        VariableSlots { of_parameter: if any { of_parameter } else { vec![] } }
    }

    /// The parameters of a program that have a variable's name and other numbers: the name, the numbers of the variable and those of
    /// the parameter, none of which are those of a string.
    pub fn misfits<'a>(
        program: &'a Program,
        variables: &'a [(String, usize)],
    ) -> impl Iterator<Item = (&'a str, usize, Option<usize>)> {
        let given = program.params.iter().filter_map(|p| Some((p, variables[slot_of(variables, &p.name)?].1)));
        given.map(|(p, width)| (p.name.as_str(), width, numbers(p))).filter(|(_, width, own)| *own != Some(*width))
    }

    /// The slot of the variable that goes before a parameter.
    pub(in crate::back) fn of_parameter(&self, parameter: usize) -> Option<usize> {
        self.of_parameter.get(parameter).copied().flatten()
    }
}

/// Count of the numbers that a parameter has, if it is no string.
fn numbers(param: &Parameter) -> Option<usize> {
    match param.reg {
        Operand::Number(r) => Some(r.width() * param.array.unwrap_or(1) as usize),
        Operand::Text(_) => None,
    }
}

/// The slot of the variable of a name.
fn slot_of(variables: &[(String, usize)], name: &str) -> Option<usize> {
    variables.iter().position(|(n, _)| n == name)
}
