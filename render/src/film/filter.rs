//! Pixel filters (RISpec 4.1.2 and appendix E): products of those along each axis, or of the distance, evaluated from a table.

/// The kind of a pixel filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterKind {
    /// Constant over the filter's width.
    Box,
    /// Falls linearly from the centre to 0 at half the width.
    Triangle,
    /// Gaussian, cut off at half the width.
    Gaussian,
    /// Catmull and Rom's cubic of the distance in pixels, which ends at 2, within the rectangle of the widths.
    CatmullRom,
    /// Sinc times a window.
    Sinc,
    /// Mitchell and Netravali's cubic, B = C = 1/3.
    Mitchell,
    /// Constant over the ellipse of the widths.
    Disk,
    /// Of a round aperture, 2 J₁(x)/x up to its first zero at the ellipse of the widths, times a cosine.
    Bessel,
}

impl FilterKind {
    /// The filter of a name: `box`, `triangle`, `gaussian`, `catmull-rom`, `sinc`, `mitchell`, `disk` or `bessel`; `None` for others.
    pub fn of_name(name: &str) -> Option<FilterKind> {
        Some(match name {
            "box" => FilterKind::Box,
            "triangle" => FilterKind::Triangle,
            "gaussian" => FilterKind::Gaussian,
            "catmull-rom" => FilterKind::CatmullRom,
            "sinc" => FilterKind::Sinc,
            "mitchell" => FilterKind::Mitchell,
            "disk" => FilterKind::Disk,
            "bessel" => FilterKind::Bessel,
            _ => return None,
        })
    }

    /// Whether it depends on the distance from the centre in half widths, and is not a product of filters along x and y.
    pub fn is_round(self) -> bool {
        matches!(self, FilterKind::Disk | FilterKind::Bessel)
    }

    /// How far from the centre it has values, pixels.
    fn reach(self, width: f32) -> f32 {
        if self == FilterKind::CatmullRom { 2.0 } else { 0.5 * width }
    }

    /// The filter's value at `x` pixels from its centre, for a full width of `width` pixels; 0 from half the width on, but for
    /// Catmull and Rom's, which the widths cut along x and y.
    pub fn value(self, x: f32, width: f32) -> f32 {
        let half = 0.5 * width;
        let x = x.abs();
        if x >= self.reach(width) {
            return 0.0;
        }
        match self {
            FilterKind::Box | FilterKind::Disk => 1.0,
            FilterKind::Bessel => {
                let d = x / half;
                2.0 * j1_over(FIRST_ZERO * d) * (0.5 * std::f32::consts::PI * d).cos()
            }
            FilterKind::Triangle => 1.0 - x / half,
            // As the specification has it: e^(−2 (2x/width)²).
            FilterKind::Gaussian => (-2.0 * (x / half) * (x / half)).exp(),
            FilterKind::CatmullRom => {
                if x < 1.0 {
                    1.5 * x * x * x - 2.5 * x * x + 1.0
                } else {
                    -0.5 * x * x * x + 2.5 * x * x - 4.0 * x + 2.0
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

/// The first zero of J₁ above 0.
const FIRST_ZERO: f32 = 3.831_706;

/// J₁(x)/x of Bessel's function, by its series, up to the first zero.
fn j1_over(x: f32) -> f32 {
    let q = -0.25 * x * x;
    let (mut term, mut sum) = (0.5f32, 0.5f32);
    for k in 1..14 {
        term *= q / (k * (k + 1)) as f32;
        sum += term;
    }
    sum
}

/// The pixel filter of an image.
#[derive(Clone, Debug)]
pub struct PixelFilter {
    /// Along x and y; of a round one, along any radius of the ellipse of its widths.
    axes: [Filter; 2],
}

impl PixelFilter {
    /// A filter of widths along x and y, pixels.
    pub fn new(kind: FilterKind, widths: [f32; 2]) -> PixelFilter {
        PixelFilter { axes: widths.map(|width| Filter::new(kind, width)) }
    }

    /// The same filter for samples in the middles of pixels, one in each: where it takes nothing of a pixel's neighbours, a box of a pixel.
    pub fn of_middles(self) -> PixelFilter {
        let alone = self.at(0.0, 0.0) != 0.0 && self.at(1.0, 0.0) == 0.0 && self.at(0.0, 1.0) == 0.0;
        if alone { PixelFilter::new(FilterKind::Box, [1.0; 2]) } else { self }
    }

    /// Its value at a place from its centre, pixels.
    #[inline]
    pub fn at(&self, dx: f32, dy: f32) -> f32 {
        let [x, y] = &self.axes;
        if x.kind == FilterKind::CatmullRom {
            let is_within = dx.abs() < x.half && dy.abs() < y.half;
            return if is_within { x.of_distance((dx * dx + dy * dy).sqrt()) } else { 0.0 };
        }
        if !x.kind.is_round() {
            return x.at(dx) * y.at(dy);
        }
        x.at((dx * dx + dy * dy * (x.half / y.half).powi(2)).sqrt())
    }

    /// Its axes.
    pub fn axes(&self) -> &[Filter; 2] {
        &self.axes
    }

    /// Whether it is a box of one pixel.
    pub fn is_pixel(&self) -> bool {
        self.axes.iter().all(Filter::is_pixel)
    }

    /// Its reach beyond the pixel along x and y, pixels, rounded up.
    pub fn margin(&self) -> [usize; 2] {
        [self.axes[0].margin(), self.axes[1].margin()]
    }
}

/// A pixel filter along one axis, tabulated.
#[derive(Clone, Debug)]
pub struct Filter {
    pub(crate) table: Vec<f32>,
    pub(crate) half: f32,
    pub(crate) kind: FilterKind,
}

impl Filter {
    /// Entries of the table for a pixel.
    const STEPS: f32 = 256.0;

    /// Tabulate a filter of a full width of `width` pixels.
    pub fn new(kind: FilterKind, width: f32) -> Filter {
        let n = (kind.reach(width) * Self::STEPS).ceil() as usize + 2;
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

    /// The filter's value at a distance from its centre, pixels, however wide it is.
    #[inline]
    fn of_distance(&self, r: f32) -> f32 {
        self.table.get((r * Self::STEPS) as usize).copied().unwrap_or(0.0)
    }

    /// What its kernels are told that it is: 1 is a box of one pixel along both axes, 2 depends on the distance in half widths, 3 on
    /// that in pixels.
    pub(crate) fn shape(&self) -> u32 {
        match self.kind {
            FilterKind::CatmullRom => 3,
            kind => 2 * kind.is_round() as u32,
        }
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
        for name in ["box", "triangle", "gaussian", "catmull-rom", "sinc", "mitchell", "bessel"] {
            let kind = FilterKind::of_name(name).unwrap();
            assert_eq!(kind.value(2.0, 4.0), 0.0, "{name}");
            assert!(kind.value(0.0, 4.0) > 0.5 && kind.value(0.3, 4.0) == kind.value(-0.3, 4.0), "{name}");
            assert!((Filter::new(kind, 4.0).at(0.7) - kind.value(0.7, 4.0)).abs() < 0.01, "{name}");
        }
        // Round filters end at an ellipse; J₁(1.915853) = 0.5815 of the half way to its first zero (Abramowitz and Stegun, 9.1).
        let disk = PixelFilter::new(FilterKind::Disk, [4.0, 2.0]);
        assert_eq!([disk.at(1.9, 0.0), disk.at(0.0, 0.9), disk.at(1.5, 0.7)], [1.0, 1.0, 0.0]);
        let half = 2.0 * 0.581_52 / 1.915_853 * std::f32::consts::FRAC_PI_4.cos();
        assert!((FilterKind::Bessel.value(1.0, 4.0) - half).abs() < 1e-3, "{}", FilterKind::Bessel.value(1.0, 4.0));
        // Of the distance, within the rectangle of the widths: 3/2 r³ − 5/2 r² + 1 up to 1, −1/2 r³ + 5/2 r² − 4 r + 2 up to 2.
        let cubic = PixelFilter::new(FilterKind::CatmullRom, [4.0, 2.0]);
        for (x, y, expected) in
            [(0.3, 0.4, 0.5625), (0.6, 0.8, 0.0), (0.9, -1.1, 0.0), (1.2, 0.9, -0.0625), (1.6, 0.9, -0.0116)]
        {
            assert!((cubic.at(x, y) - expected).abs() < 6e-3, "({x}, {y}): {}, expected {expected}", cubic.at(x, y));
        }
        // Samples in the middles of pixels: none of a neighbour's within a width of two.
        assert!(PixelFilter::new(FilterKind::Gaussian, [2.0; 2]).of_middles().is_pixel());
        assert!(!PixelFilter::new(FilterKind::Gaussian, [2.0, 2.1]).of_middles().is_pixel());
        assert_eq!(Filter::new(FilterKind::Box, 1.0).margin(), 0);
        assert_eq!(Filter::new(FilterKind::Gaussian, 2.0).margin(), 1);
    }
}
