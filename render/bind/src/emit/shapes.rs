//! The objects that instances repeat, of unit size.

use super::archive;
use super::group::Group;
use super::wrong::{Origin, Wrong};
use crate::binding::Shape;
use ri::files::Files;
use ri::{Class, Declaration, Param, Params, Ri, RiResult, Type, Values};

/// The retained object of a shape that is not a sphere: a unit box, a unit square, a cylinder, a cone, a part of an
/// arrow, or what the group's file has.
pub(super) fn define(
    shape: &Shape,
    group: &Group,
    files: &Files,
    at: Origin<'_>,
    ri: &mut dyn Ri,
) -> Result<(), Wrong> {
    if let Shape::Archive(..) = shape {
        let key = format!("{}.geometry.archive.file", at.key);
        return group.archive.map_or(Ok(()), |file| archive::include(file, files, at.key(&key), ri));
    }
    Ok(unit(shape, group, ri)?)
}

/// The unit shape of a geometry that is from no file.
fn unit(shape: &Shape, group: &Group, ri: &mut dyn Ri) -> RiResult {
    match shape {
        Shape::Archive(..) => Ok(()),
        Shape::Plane(_) => {
            ri.polygon(polygon([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]))
        }
        Shape::Cylinder(_) => turned(1.0, true, ri),
        Shape::Capsule(_) => turned(1.0, false, ri),
        Shape::Cone(_) => turned(0.0, true, ri),
        Shape::Arrow(_) => turned(if group.is_head { 0.0 } else { 1.0 }, true, ri),
        Shape::Trail(_) => Ok(()),
        Shape::Box(_) | Shape::Sphere(_) | Shape::Ellipsoid(_) => cube(ri),
    }
}

fn polygon(corners: [[f32; 3]; 4]) -> Params {
    let decl = Declaration::new("P", Class::Vertex, Type::Point);
    vec![Param { decl, values: Values::Floats(corners.concat()) }]
}

/// The six faces of a cube from −1 to 1.
fn cube(ri: &mut dyn Ri) -> RiResult {
    for axis in 0..3 {
        for side in [-1.0f32, 1.0] {
            // Around the face, so that its normal points outwards.
            let corner = |s: f32, t: f32| {
                let mut p = [0.0; 3];
                p[axis] = side;
                p[(axis + 1) % 3] = s * side;
                p[(axis + 2) % 3] = t;
                p
            };
            ri.polygon(polygon([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]))?;
        }
    }
    Ok(())
}

/// A cylinder (`top` 1) or a cone (`top` 0) of radius 1 from z = −1 to 1 as four bicubic patches, with flat ends if `closed`.
fn turned(top: f32, closed: bool, ri: &mut dyn Ri) -> RiResult {
    /// The distance of a Bézier curve's inner points from its ends that makes a quarter circle.
    const ARC: f32 = 0.552_284_8;
    let points = |p: Vec<f32>| {
        vec![Param { decl: Declaration::new("P", Class::Vertex, Type::Point), values: Values::Floats(p) }]
    };
    for quarter in 0..4 {
        let (s, c) = (quarter as f32 * std::f32::consts::FRAC_PI_2).sin_cos();
        let arc = [[1.0, 0.0], [1.0, ARC], [ARC, 1.0], [0.0, 1.0]].map(|[x, y]| [c * x - s * y, s * x + c * y]);
        let row = |z: f32, r: f32| arc.iter().flat_map(move |[x, y]| [r * x, r * y, z]);
        // Straight along z: the inner rows divide it by three.
        let rows = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|t: f32| (2.0 * t - 1.0, 1.0 + t * (top - 1.0)));
        ri.patch("bicubic", points(rows.iter().flat_map(|(z, r)| row(*z, *r)).collect()))?;
        for (z, r) in [(-1.0, 1.0), (1.0, top)] {
            if closed && r > 0.0 {
                // A sector of the end: the same arc drawn in to the middle, outwards up or down.
                let rings = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|t: f32| if z > 0.0 { r * (1.0 - t) } else { r * t });
                ri.patch("bicubic", points(rings.iter().flat_map(|r| row(z, *r)).collect()))?;
            }
        }
    }
    Ok(())
}
