//! The points that are shaded.

use crate::ir::Global;

/// The points to be shaded: `n = nu · nv`, in rows of `nu`.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// Points in a row.
    pub nu: usize,
    /// Rows.
    pub nv: usize,
    /// 1, or −1 where the rows' cross product points into the surface.
    pub orientation: f32,
    /// Globals by their slots: values, one or one a point, a triple as three runs.
    globals: [Vec<f32>; Global::COUNT],
    /// The slots that have values, a bit each.
    given: u32,
    /// Primitive variables by their slots: values, or one a point, a triple as three runs. Slots from `n_variables` on have no
    /// values and keep their memory.
    variables: Vec<Vec<f32>>,
    n_variables: usize,
}

impl Points {
    /// Points in `nv` rows of `nu`, without values.
    pub fn new(nu: usize, nv: usize, orientation: f32) -> Points {
        Points { nu, nv, orientation, ..Points::default() }
    }

    /// Number of points.
    pub fn n(&self) -> usize {
        self.nu * self.nv
    }

    fn has(&self, global: Global) -> bool {
        self.given >> global.slot() & 1 == 1
    }

    /// A global's values.
    pub fn get(&self, global: Global) -> Option<&[f32]> {
        self.has(global).then(|| self.globals[global.slot()].as_slice())
    }

    /// A global's buffer.
    pub fn get_mut(&mut self, global: Global) -> Option<&mut Vec<f32>> {
        if self.has(global) { Some(&mut self.globals[global.slot()]) } else { None }
    }

    /// The buffers of all globals that have values.
    pub fn globals_mut(&mut self) -> impl Iterator<Item = &mut Vec<f32>> {
        let given = self.given;
        self.globals.iter_mut().enumerate().filter(move |(k, _)| given >> k & 1 == 1).map(|(_, v)| v)
    }

    /// A global's buffer, emptied, for new values.
    pub fn refill(&mut self, global: Global) -> &mut Vec<f32> {
        self.given |= 1 << global.slot();
        let buffer = &mut self.globals[global.slot()];
        buffer.clear();
        buffer
    }

    /// Take all primitive variables away.
    pub fn clear_variables(&mut self) {
        self.n_variables = 0;
    }

    /// The buffer, emptied, of the primitive variable in the next slot.
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

    /// The values of all primitive variables, slot by slot.
    pub fn variables(&self) -> &[Vec<f32>] {
        &self.variables[..self.n_variables]
    }

    /// Give a global the values of the primitive variable in a slot, or others where there is none.
    pub fn refill_from(&mut self, global: Global, slot: Option<usize>, others: &[f32]) {
        let mut buffer = std::mem::take(self.refill(global));
        buffer.extend_from_slice(slot.and_then(|slot| self.variable(slot)).unwrap_or(others));
        *self.refill(global) = buffer;
    }

    /// Give a global values.
    pub fn set(&mut self, global: Global, values: Vec<f32>) {
        *self.refill(global) = values;
    }
}
