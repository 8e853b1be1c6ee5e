//! The points that are shaded.

use crate::ir::{Ask, Global};

/// What a shader that ran over points before tells others: an output parameter of it.
#[derive(Clone, Debug)]
pub struct Message {
    /// Which shader: as its displacement or its surface is asked.
    pub from: Ask,
    /// Name of the parameter.
    pub name: String,
    /// Values, one or one a point, a triple as three runs.
    pub values: Vec<f32>,
}

/// The points of a grid to shade, with their global and primitive variables: n = `nu` · `nv` points, row by row. A variable holds
/// one value (uniform) or n values (varying); a varying triple is stored as three runs, all x, all y, all z.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// Count of points in a row.
    pub nu: usize,
    /// Count of rows.
    pub nv: usize,
    /// 1, or −1 where the cross product of the directions along rows and columns points into the surface.
    pub orientation: f32,
    /// Globals by their slots: values, one or one a point, a triple as three runs.
    globals: [Vec<f32>; Global::COUNT],
    /// The slots that have values, a bit each.
    given: u32,
    /// Primitive variables by their slots: values, or one a point, a triple as three runs. Slots from `n_variables` on have no
    /// values and keep their memory.
    variables: Vec<Vec<f32>>,
    n_variables: usize,
    /// What each point stands for, if that is more than its micropolygon: the symmetric matrix uu, uv, vv that takes the changes of a
    /// value to the next points of the row and of the column to those over what the point stands for; none for all, or one a point.
    pub footprints: Vec<[f32; 3]>,
    /// What shaders that ran before tell.
    pub messages: Vec<Message>,
}

impl Points {
    /// A grid of `nv` rows of `nu` points, without variables.
    pub fn new(nu: usize, nv: usize, orientation: f32) -> Points {
        Points { nu, nv, orientation, ..Points::default() }
    }

    /// Count of points, n.
    pub fn n(&self) -> usize {
        self.nu * self.nv
    }

    fn has(&self, global: Global) -> bool {
        self.given >> global.slot() & 1 == 1
    }

    /// The values of a global variable, if it has any.
    pub fn get(&self, global: Global) -> Option<&[f32]> {
        self.has(global).then(|| self.globals[global.slot()].as_slice())
    }

    /// The buffer of a global variable, if it has values.
    pub fn get_mut(&mut self, global: Global) -> Option<&mut Vec<f32>> {
        if self.has(global) { Some(&mut self.globals[global.slot()]) } else { None }
    }

    /// The buffers of all global variables that have values.
    pub fn globals_mut(&mut self) -> impl Iterator<Item = &mut Vec<f32>> {
        let given = self.given;
        self.globals.iter_mut().enumerate().filter(move |(k, _)| given >> k & 1 == 1).map(|(_, v)| v)
    }

    /// The buffer of a global variable, cleared, for new values.
    pub fn refill(&mut self, global: Global) -> &mut Vec<f32> {
        self.given |= 1 << global.slot();
        let buffer = &mut self.globals[global.slot()];
        buffer.clear();
        buffer
    }

    /// Remove all primitive variables; their buffers keep their memory.
    pub fn clear_variables(&mut self) {
        self.n_variables = 0;
        self.messages.clear();
    }

    /// Add a primitive variable in the next slot, and return its cleared buffer.
    pub fn next_variable(&mut self) -> &mut Vec<f32> {
        if self.n_variables == self.variables.len() {
            self.variables.push(Vec::new());
        }
        let buffer = &mut self.variables[self.n_variables];
        self.n_variables += 1;
        buffer.clear();
        buffer
    }

    /// The values of the primitive variable in a slot.
    pub fn variable(&self, slot: usize) -> Option<&[f32]> {
        self.variables[..self.n_variables].get(slot).map(Vec::as_slice)
    }

    /// The buffer of the primitive variable in a slot.
    pub fn variable_mut(&mut self, slot: usize) -> Option<&mut Vec<f32>> {
        self.variables[..self.n_variables].get_mut(slot)
    }

    /// The values of all primitive variables, by slot.
    pub fn variables(&self) -> &[Vec<f32>] {
        &self.variables[..self.n_variables]
    }

    /// Set a global variable to the values of the primitive variable in `slot`, or to `others` if there is none.
    pub fn refill_from(&mut self, global: Global, slot: Option<usize>, others: &[f32]) {
        let mut buffer = std::mem::take(self.refill(global));
        buffer.extend_from_slice(slot.and_then(|slot| self.variable(slot)).unwrap_or(others));
        *self.refill(global) = buffer;
    }

    /// Set the values of a global variable.
    pub fn set(&mut self, global: Global, values: Vec<f32>) {
        *self.refill(global) = values;
    }
}
