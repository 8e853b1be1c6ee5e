//! The points that are shaded.

/// The points to be shaded: `n = nu · nv`, in rows of `nu`.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// Points in a row.
    pub nu: usize,
    /// Rows.
    pub nv: usize,
    /// 1, or −1 where the rows' cross product points into the surface.
    pub orientation: f32,
    /// Globals: name and values, one or one a point, a triple as three runs.
    pub globals: Vec<(&'static str, Vec<f32>)>,
    /// Primitive variables, which go before parameters of the same name.
    pub inputs: Vec<(String, Vec<f32>)>,
}

impl Points {
    /// Number of points.
    pub fn n(&self) -> usize {
        self.nu * self.nv
    }

    /// A global's values.
    pub fn get(&self, name: &str) -> Option<&[f32]> {
        self.globals.iter().find(|(n, _)| *n == name).map(|(_, v)| v.as_slice())
    }

    /// A global's buffer, emptied, for new values.
    pub fn refill(&mut self, name: &'static str) -> &mut Vec<f32> {
        let i = self.globals.iter().position(|(n, _)| *n == name).unwrap_or_else(|| {
            self.globals.push((name, Vec::new()));
            self.globals.len() - 1
        });
        let buffer = &mut self.globals[i].1;
        buffer.clear();
        buffer
    }
}
