//! Pixel filters (RISpec 4.1.2): separable, evaluated from a table along each axis.

/// The kind of a pixel filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterKind {
    /// Constant over the filter's width.
    Box,
    /// Falls linearly from the centre to 0 at half the width.
    Triangle,
    /// Gaussian, cut off at half the width.
    Gaussian,
    /// Catmull and Rom's interpolating cubic.
    CatmullRom,
    /// Sinc times a window.
    Sinc,
    /// Mitchell and Netravali's cubic, B = C = 1/3.
    Mitchell,
}

impl FilterKind {
    /// The filter of a name: `box`, `triangle`, `gaussian`, `catmull-rom`, `sinc` or `mitchell`; `None` for others.
    pub fn of_name(name: &str) -> Option<FilterKind> {
        Some(match name {
            "box" => FilterKind::Box,
            "triangle" => FilterKind::Triangle,
            "gaussian" => FilterKind::Gaussian,
            "catmull-rom" => FilterKind::CatmullRom,
            "sinc" => FilterKind::Sinc,
            "mitchell" => FilterKind::Mitchell,
            _ => return None,
        })
    }

    /// The filter's value at `x` pixels from its centre, for a full width of `width` pixels; 0 from half the width on.
    pub fn value(self, x: f32, width: f32) -> f32 {
        let half = 0.5 * width;
        let x = x.abs();
        if x >= half {
            return 0.0;
        }
        match self {
            FilterKind::Box => 1.0,
            FilterKind::Triangle => 1.0 - x / half,
            // As the specification has it: e^(−2 (2x/width)²).
            FilterKind::Gaussian => (-2.0 * (x / half) * (x / half)).exp(),
            FilterKind::CatmullRom => {
                if x < 1.0 {
                    1.5 * x * x * x - 2.5 * x * x + 1.0
                } else if x < 2.0 {
                    -0.5 * x * x * x + 2.5 * x * x - 4.0 * x + 2.0
                } else {
                    0.0
                }
            }
            FilterKind::Sinc => {
                let s =
                    |t: f32| if t == 0.0 { 1.0 } else { (std::f32::consts::PI * t).sin() / (std::f32::consts::PI * t) };
                s(x) * s(x / half)
            }
            FilterKind::Mitchell => {
                // The cubic has a support of 2; it is stretched to the width.
                let t = 2.0 * x / half;
                let (b, c) = (1.0 / 3.0, 1.0 / 3.0);
                if t < 1.0 {
                    ((12.0 - 9.0 * b - 6.0 * c) * t * t * t + (-18.0 + 12.0 * b + 6.0 * c) * t * t + 6.0 - 2.0 * b)
                        / 6.0
                } else {
                    ((-b - 6.0 * c) * t * t * t
                        + (6.0 * b + 30.0 * c) * t * t
                        + (-12.0 * b - 48.0 * c) * t
                        + 8.0 * b
                        + 24.0 * c)
                        / 6.0
                }
            }
        }
    }
}

/// A pixel filter along one axis, tabulated.
#[derive(Clone, Debug)]
pub struct Filter {
    table: Vec<f32>,
    half: f32,
    kind: FilterKind,
}

impl Filter {
    /// Entries of the table for a pixel.
    const STEPS: f32 = 256.0;

    /// Tabulate a filter of a full width of `width` pixels.
    pub fn new(kind: FilterKind, width: f32) -> Filter {
        let n = (0.5 * width * Self::STEPS).ceil() as usize + 2;
        Filter {
            table: (0..n).map(|i| kind.value((i as f32 + 0.5) / Self::STEPS, width)).collect(),
            half: 0.5 * width,
            kind,
        }
    }

    /// The filter's value at `x` pixels from its centre.
    #[inline]
    pub fn at(&self, x: f32) -> f32 {
        let x = x.abs();
        if x >= self.half { 0.0 } else { self.table[(x * Self::STEPS) as usize] }
    }

    /// Whether the filter is a box of one pixel's width.
    pub fn is_pixel(&self) -> bool {
        self.kind == FilterKind::Box && self.half == 0.5
    }

    /// The filter's reach beyond the pixel on either side, pixels, rounded up.
    pub fn margin(&self) -> usize {
        (self.half - 0.5).max(0.0).ceil() as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_are_even_bells_that_end_at_their_width() {
        for name in ["box", "triangle", "gaussian", "catmull-rom", "sinc", "mitchell"] {
            let kind = FilterKind::of_name(name).unwrap();
            assert_eq!(kind.value(2.0, 4.0), 0.0, "{name}");
            assert!(kind.value(0.0, 4.0) > 0.5 && kind.value(0.3, 4.0) == kind.value(-0.3, 4.0), "{name}");
            assert!((Filter::new(kind, 4.0).at(0.7) - kind.value(0.7, 4.0)).abs() < 0.01, "{name}");
        }
        assert_eq!(Filter::new(FilterKind::Box, 1.0).margin(), 0);
        assert_eq!(Filter::new(FilterKind::Gaussian, 2.0).margin(), 1);
    }
}
