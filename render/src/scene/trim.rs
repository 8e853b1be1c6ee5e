//! Trim loops: which parameters of a NURBS patch are cut away (RISpec 5.3). A point is kept inside an odd number of loops.

/// Loops of straight pieces in u and v.
#[derive(Clone, Debug)]
pub struct Trim {
    /// The points of each loop.
    pub loops: Vec<Vec<[f32; 2]>>,
    /// Whether what is outside is kept instead (`Attribute "trimcurve" "sense"`).
    pub outside: bool,
}

impl Trim {
    /// Whether a point is kept: inside an odd number of loops, as the specification's outermost loop keeps what is within it.
    pub fn keeps(&self, u: f32, v: f32) -> bool {
        let mut inside = false;
        for line in &self.loops {
            for (k, a) in line.iter().enumerate() {
                let b = line[(k + 1) % line.len()];
                if (a[1] > v) != (b[1] > v) && u < a[0] + (b[0] - a[0]) * (v - a[1]) / (b[1] - a[1]) {
                    inside = !inside;
                }
            }
        }
        inside != self.outside
    }
}
