//! What points of a grid stand for on the image: a micropolygon, and a pixel at least.
//!
//! In: points `[n]` in rows of `nu`, world space; the camera; the area of a micropolygon, pixels. Out: [`Points::footprints`], `[n]`.
//! Where a surface is seen askew the rows and columns of its grid run nearly the same way on the image, and micropolygons are slivers of
//! pixels: filters as narrow as these leave grain, so those of maps and of `filterwidth` reach over the pixel.

use crate::scene::camera::Camera;
use glam::{Vec2, Vec3};
use sl::Global;
use sl::machine::Points;

/// The least breadth of a micropolygon, in parts of the edge that the shading rate asks for, whose filter stays as it is; from half of
/// it down the filter is as broad as the whole edge.
const BROAD: f32 = 0.5;

/// The least breadth that is told from none.
const LEAST: f32 = 1e-3;

/// The footprint of a micropolygon that is broad enough.
const OWN: [f32; 3] = [1.0, 0.0, 1.0];

/// Give points their footprints, none if all are the micropolygons themselves.
pub fn fill(points: &mut Points, camera: &Camera, rate: f32) {
    let mut all = std::mem::take(&mut points.footprints);
    all.clear();
    let (n, nu) = (points.n(), points.nu);
    if let Some(p) = points.get(Global::P).filter(|p| p.len() == 3 * n && n > 1) {
        let edge = rate.sqrt().min(1.0);
        let place = |k: usize| camera.to_camera.transform_point3(Vec3::new(p[k], p[n + k], p[2 * n + k]));
        let raster: Vec<Vec2> = (0..n).map(|k| camera.project(place(k)) / edge).collect();
        let change = |k: usize, here: usize, count: usize, stride: usize| {
            let (back, on) = (here.min(1) * stride, (count - 1 - here).min(1) * stride);
            (raster[k + on] - raster[k - back]) / ((back + on) / stride).max(1) as f32
        };
        let of = |k: usize| footprint(change(k, k % nu, nu, 1), change(k, k / nu, n / nu, nu));
        all.extend((0..n).map(of));
    }
    if all.iter().all(|footprint| *footprint == OWN) {
        all.clear();
    }
    points.footprints = all;
}

/// The symmetric matrix that takes the steps to the next points of the row and of the column, which are these on the image, to the axes
/// of an ellipse around both the micropolygon and the pixel: uu, uv, vv.
fn footprint(along_row: Vec2, along_column: Vec2) -> [f32; 3] {
    // Squares of the steps on the image: their greatest and least over all ways on the grid.
    let (a, b, c) = (along_row.length_squared(), along_row.dot(along_column), along_column.length_squared());
    let greatest = 0.5 * (a + c) + (0.25 * (a - c) * (a - c) + b * b).sqrt();
    let least = along_row.perp_dot(along_column).powi(2) / greatest.max(f32::MIN_POSITIVE);
    if !greatest.is_finite() || least >= BROAD * BROAD {
        return OWN;
    }
    let [most, more] = [greatest, least].map(|square| growth(square.sqrt()));
    if greatest - least < 1e-4 * greatest {
        return [more, 0.0, more];
    }
    // The polynomial of the squares that is `most` and `more` at these.
    let slope = (most - more) / (greatest - least);
    let constant = most - slope * greatest;
    [constant + slope * a, slope * b, constant + slope * c]
}

/// How often a step of this length on the image, in edges, is to be taken to reach over a pixel.
fn growth(step: f32) -> f32 {
    let whole = 0.5 * BROAD;
    if step <= whole {
        return 1.0 / step.max(LEAST);
    }
    1.0 + (1.0 / whole - 1.0) * ((BROAD - step) / whole).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slivers_reach_over_a_pixel_and_others_stay() {
        assert_eq!(footprint(Vec2::X, Vec2::Y), OWN);
        assert_eq!(footprint(Vec2::new(3.0, 0.0), Vec2::new(0.0, 0.6)), OWN);
        // Flat ones reach ten times as far down as they are high.
        let [uu, uv, vv] = footprint(Vec2::X, Vec2::new(0.0, 0.1));
        assert!((uu - 1.0).abs() < 1e-4 && uv.abs() < 1e-4 && (vv - 10.0).abs() < 1e-3, "{uu} {uv} {vv}");
        // Skewed ones too: on the image the ellipse is one pixel high.
        let [row, column] = [Vec2::new(1.0, 0.0), Vec2::new(1.0, 0.1)];
        let [uu, uv, vv] = footprint(row, column);
        let axes = [row * uu + column * uv, row * uv + column * vv];
        let high = axes[0].y.hypot(axes[1].y);
        assert!((high - 1.0).abs() < 0.02, "{axes:?}");
        assert_eq!(footprint(Vec2::NAN, Vec2::Y), OWN);
    }
}
