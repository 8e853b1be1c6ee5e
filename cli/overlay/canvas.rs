//! A canvas: lines, panels, triangles and glyphs with smooth edges over the pixels of an image.

/// A place, pixels from the upper left.
pub type Place = [f32; 2];

/// A colour as screens have it, 0 to 1, and its opacity.
pub type Ink = [f32; 4];

/// Pixels that are drawn on: colours, premultiplied by their coverage.
pub struct Canvas<'a> {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// The pixels, row by row from the top.
    pub pixels: &'a mut [[f32; 4]],
}

impl Canvas<'_> {
    /// Lay a colour over a pixel that it covers in part.
    pub fn blend(&mut self, x: i64, y: i64, ink: Ink, cover: f32) {
        let [width, height] = self.size.map(|n| n as i64);
        if !(0..width).contains(&x) || !(0..height).contains(&y) || cover <= 0.0 {
            return;
        }
        let pixel = &mut self.pixels[(y * width + x) as usize];
        let a = ink[3] * cover.min(1.0);
        for c in 0..3 {
            pixel[c] += (ink[c] - pixel[c]) * a;
        }
        pixel[3] += (1.0 - pixel[3]) * a;
    }

    /// Fill what is at a distance of 0 or less, within the box from `lo` to `hi`; the distance is in pixels, negative inside.
    fn fill(&mut self, lo: Place, hi: Place, ink: Ink, distance: impl Fn(Place) -> f32) {
        let ends = |k: usize| {
            let most = self.size[k] as f32;
            (lo[k] - 1.0).clamp(0.0, most) as i64..(hi[k] + 2.0).clamp(0.0, most) as i64
        };
        let (across, down) = (ends(0), ends(1));
        for y in down {
            for x in across.clone() {
                let cover = (0.5 - distance([x as f32 + 0.5, y as f32 + 0.5])).clamp(0.0, 1.0);
                self.blend(x, y, ink, cover);
            }
        }
    }

    /// A rectangle whose corners are round.
    pub fn panel(&mut self, [x0, y0]: Place, [x1, y1]: Place, round: f32, ink: Ink) {
        let (middle, half) = ([(x0 + x1) / 2.0, (y0 + y1) / 2.0], [(x1 - x0) / 2.0, (y1 - y0) / 2.0]);
        let round = round.min(half[0]).min(half[1]);
        self.fill([x0, y0], [x1, y1], ink, |p| {
            let d = [0, 1].map(|k| (p[k] - middle[k]).abs() - half[k] + round);
            d[0].max(0.0).hypot(d[1].max(0.0)) + d[0].max(d[1]).min(0.0) - round
        });
    }

    /// A line with round ends.
    pub fn line(&mut self, a: Place, b: Place, width: f32, ink: Ink) {
        let (r, along) = (width / 2.0, [b[0] - a[0], b[1] - a[1]]);
        let square = along[0] * along[0] + along[1] * along[1];
        let [lo, hi] = [[a[0].min(b[0]) - r, a[1].min(b[1]) - r], [a[0].max(b[0]) + r, a[1].max(b[1]) + r]];
        self.fill(lo, hi, ink, |p| {
            let t = ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / square.max(1e-12);
            let t = t.clamp(0.0, 1.0);
            (p[0] - a[0] - t * along[0]).hypot(p[1] - a[1] - t * along[1]) - r
        });
    }

    /// A triangle.
    pub fn triangle(&mut self, corners: [Place; 3], ink: Ink) {
        let [a, b, c] = corners;
        let turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let span = |k: usize| [a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k])];
        let ([x0, x1], [y0, y1]) = (span(0), span(1));
        self.fill([x0, y0], [x1, y1], ink, |p| {
            let off = |a: Place, b: Place| {
                let [x, y] = [b[0] - a[0], b[1] - a[1]];
                -turn.signum() * (x * (p[1] - a[1]) - y * (p[0] - a[0])) / x.hypot(y).max(1e-6)
            };
            off(a, b).max(off(b, c)).max(off(c, a))
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum of what is covered by a drawing on an empty canvas.
    fn area(draw: impl Fn(&mut Canvas<'_>)) -> f32 {
        let mut pixels = vec![[0.0; 4]; 40 * 30];
        draw(&mut Canvas { size: [40, 30], pixels: &mut pixels });
        pixels.iter().map(|p| p[3]).sum()
    }

    #[test]
    fn shapes_cover_their_areas_and_stay_on_the_canvas() {
        let ink = [1.0; 4];
        let panel = area(|c| c.panel([4.25, 3.5], [24.25, 13.5], 0.0, ink));
        assert!((panel - 200.0).abs() < 1.0, "{panel}");
        let line = area(|c| c.line([5.0, 5.0], [25.0, 20.0], 3.0, ink));
        assert!((line - (75.0 + 2.25 * std::f32::consts::PI)).abs() < 1.5, "{line}");
        for corners in [[[5.0, 5.0], [25.0, 5.0], [5.0, 25.0]], [[5.0, 25.0], [25.0, 5.0], [5.0, 5.0]]] {
            let triangle = area(|c| c.triangle(corners, ink));
            assert!((triangle - 200.0).abs() < 4.0, "either way round: {triangle}");
        }
        assert_eq!(area(|c| c.panel([-50.0, -50.0], [90.0, 90.0], 2.0, ink)), 1200.0);
        assert_eq!(area(|c| c.line([-50.0, -9.0], [90.0, -9.0], 2.0, ink)), 0.0);
    }

    #[test]
    fn translucent_ink_lies_over_what_is_there() {
        let mut pixels = vec![[0.5, 0.5, 0.5, 1.0]; 4];
        Canvas { size: [2, 2], pixels: &mut pixels }.panel([0.0, 0.0], [1.0, 2.0], 0.0, [1.0, 0.0, 0.5, 0.5]);
        assert_eq!(pixels[0], [0.75, 0.25, 0.5, 1.0]);
        assert_eq!(pixels[1], [0.5, 0.5, 0.5, 1.0]);
    }
}
