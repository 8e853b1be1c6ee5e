//! A call of a shading function over a grid, as its evaluator sees it.

use super::runs::{at, run_of};

/// Values of an argument: one for all points, or one a point; a triple or a matrix as one run for each component.
#[derive(Clone, Copy, Debug, Default)]
pub struct Values<'a> {
    /// The numbers.
    pub v: &'a [f32],
    /// Components of a value: 1, 3 or 16.
    pub width: usize,
}

impl Values<'_> {
    /// One value for all points.
    #[inline]
    pub fn is_uniform(&self) -> bool {
        self.v.len() == self.width
    }
}

/// A call.
pub struct Call<'a> {
    /// Number of points.
    pub n: usize,
    /// Points in a row.
    pub nu: usize,
    /// 1, or −1 where the rows' cross product points into the surface.
    pub orientation: f32,
    /// What points stand for, as in the points of the grid.
    pub footprints: &'a [[f32; 3]],
    /// Active points; `None` is all. What comes out at the others is not read.
    pub mask: Option<&'a [bool]>,
    /// P of the grid, if the shader reads it.
    pub place: Option<&'a [f32]>,
    /// Tells the turns of the loops around the call apart; 0 outside of loops.
    pub turn: u32,
    /// Arguments.
    pub args: &'a [Values<'a>],
    /// Components of a value of the result.
    pub width: usize,
}

/// Computes a function: appends the result, one value or one a point, to an empty buffer.
pub type Evaluator = fn(&Call<'_>, &mut Vec<f32>);

impl<'a> Call<'a> {
    /// The numbers of an argument.
    #[inline]
    pub fn arg(&self, k: usize) -> &'a [f32] {
        self.args[k].v
    }

    /// Values that come out: one if all arguments are uniform, otherwise one a point.
    #[inline]
    pub fn lanes(&self) -> usize {
        if self.args.iter().all(Values::is_uniform) { 1 } else { self.n }
    }

    /// Whether a point is to be computed.
    #[inline]
    pub fn active(&self, k: usize) -> bool {
        self.mask.is_none_or(|m| m[k])
    }

    /// Compute `f` of the values of all arguments, point by point, or once if all are uniform.
    #[inline]
    pub fn pointwise(&self, out: &mut Vec<f32>, f: impl Fn(&[[f32; 16]]) -> [f32; 16]) {
        let (n, width, lanes) = (self.n, self.width, self.lanes());
        out.resize(width * lanes, 0.0);
        let mut values = vec![[0.0; 16]; self.args.len()];
        for k in 0..lanes {
            if self.mask.is_some_and(|m| lanes == n && !m[k]) {
                continue;
            }
            for (value, arg) in values.iter_mut().zip(self.args) {
                let w = arg.width;
                (0..w).for_each(|c| value[c] = at(run_of(arg.v, w, c, n), k));
            }
            let result = f(&values);
            (0..width).for_each(|c| out[c * lanes + k] = result[c]);
        }
    }
}
