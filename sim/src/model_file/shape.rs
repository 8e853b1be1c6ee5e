//! Resolution of a shape: its values are checked, its files read, and its kind, size, hull or surface computed.

use super::types::*;
use crate::ShapeKind;
use crate::geometry::{Hull, Surface};
use crate::shape::FARTHEST;
use frame::yaml::Document;
use frame::{Fault, mesh};
use glam::{DQuat, DVec3};
use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A resolved shape.
pub struct Shape {
    /// Kind.
    pub kind: ShapeKind,
    /// Size, m, as [`ShapeKind`] has it.
    pub size: DVec3,
    /// Hull, where the kind is one.
    pub hull: Option<Arc<Hull>>,
    /// Triangles, where the kind is a mesh or a height field.
    pub surface: Option<Surface>,
    /// Position of the shape's origin in the file's frame, m.
    pub shift: DVec3,
    /// Orientation of the shape in the file's frame: a plane's rotation to its normal.
    pub rotation: DQuat,
}

impl Shape {
    /// A shape without hull, surface, shift or rotation.
    pub fn simple(kind: ShapeKind, size: DVec3) -> Shape {
        Shape { kind, size, hull: None, surface: None, shift: DVec3::ZERO, rotation: DQuat::IDENTITY }
    }
}

pub fn positive(doc: &Document, key: &str, value: f64) -> Result<(), Fault> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(doc.fault(key, format!("is {value}, expected a number above 0")))
}

pub fn not_negative(doc: &Document, key: &str, value: f64) -> Result<(), Fault> {
    if value >= 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(doc.fault(key, format!("is {value}, expected a number of at least 0")))
}

pub fn at_most_one(doc: &Document, key: &str, value: f64) -> Result<(), Fault> {
    match value <= 1.0 {
        true => Ok(()),
        false => Err(doc.fault(key, format!("is {value}, expected 0 to 1"))),
    }
}

pub fn finite(doc: &Document, key: &str, values: &[f64]) -> Result<(), Fault> {
    match values.iter().find(|v| !v.is_finite()) {
        Some(v) => Err(doc.fault(key, format!("has a component {v}, expected finite numbers"))),
        None => Ok(()),
    }
}

pub fn direction(doc: &Document, key: &str, v: [f64; 3]) -> Result<DVec3, Fault> {
    finite(doc, key, &v)?;
    DVec3::from_array(v).try_normalize().ok_or_else(|| doc.fault(key, "is zero, expected a direction"))
}

/// The orientation of the keys `rotate` or `orientation`, or the identity.
pub fn orientation(
    doc: &Document,
    key: &str,
    rotate: &Option<RotateFile>,
    quaternion: &Option<[f64; 4]>,
) -> Result<DQuat, Fault> {
    match (rotate, quaternion) {
        (Some(_), Some(_)) => {
            Err(doc.fault(&format!("{key}.orientation"), "there are both `rotate` and `orientation`: expected one"))
        }
        (Some(rotate), None) => {
            let axis = direction(doc, &format!("{key}.rotate.axis"), rotate.axis)?;
            finite(doc, &format!("{key}.rotate.angle"), &[rotate.angle])?;
            Ok(DQuat::from_axis_angle(axis, rotate.angle.to_radians()))
        }
        (None, Some([w, x, y, z])) => {
            finite(doc, &format!("{key}.orientation"), &[*w, *x, *y, *z])?;
            let q = DQuat::from_xyzw(*x, *y, *z, *w);
            if !(q.length() > 0.0) {
                return Err(doc.fault(&format!("{key}.orientation"), "is zero, expected a quaternion w, x, y, z"));
            }
            Ok(q.normalize())
        }
        (None, None) => Ok(DQuat::IDENTITY),
    }
}

/// Names of the shapes, for messages.
const NAMES: &str =
    "`sphere`, `ellipsoid`, `box`, `cylinder`, `capsule`, `cone`, `hull`, `plane`, `mesh` or `height_field`";

/// Number of geometries that are given.
pub fn count(file: &ShapeFile) -> usize {
    [
        file.sphere.is_some(),
        file.ellipsoid.is_some(),
        file.block.is_some(),
        file.cylinder.is_some(),
        file.capsule.is_some(),
        file.cone.is_some(),
        file.hull.is_some(),
        file.plane.is_some(),
        file.mesh.is_some(),
        file.height_field.is_some(),
    ]
    .into_iter()
    .filter(|x| *x)
    .count()
}

/// Hulls with their centroids, by the file and the bits of the points or of the scale that they were made of: bodies by the thousand have the same.
pub type Hulls = HashMap<(Option<PathBuf>, Vec<[u64; 3]>), (Arc<Hull>, DVec3)>;

/// Check and resolve a shape. `key` is its key in the file, `what` the name of its owner for messages; hulls that there are already are not made again.
pub fn resolve(doc: &Document, key: &str, what: &str, file: &ShapeFile, hulls: &mut Hulls) -> Result<Shape, Fault> {
    let shape = resolve_any(doc, key, what, file, hulls)?;
    match shape.size.max_element().max(shape.shift.abs().max_element()) <= FARTHEST {
        true => Ok(shape),
        false => Err(doc.fault(key, format!("{what} has a shape that reaches farther than {FARTHEST:e} m"))),
    }
}

fn resolve_any(doc: &Document, key: &str, what: &str, file: &ShapeFile, hulls: &mut Hulls) -> Result<Shape, Fault> {
    if count(file) != 1 {
        return Err(doc.fault(key, format!("{what} needs exactly one shape: {NAMES}")));
    }
    let round = |name: &str, kind: ShapeKind, c: &CylinderFile| {
        positive(doc, &format!("{key}.{name}.radius"), c.radius)?;
        positive(doc, &format!("{key}.{name}.length"), c.length)?;
        Ok(Shape::simple(kind, DVec3::new(c.radius, c.radius, 0.5 * c.length)))
    };
    if let Some(sphere) = &file.sphere {
        positive(doc, &format!("{key}.sphere.radius"), sphere.radius)?;
        Ok(Shape::simple(ShapeKind::Sphere, DVec3::splat(sphere.radius)))
    } else if let Some(e) = &file.ellipsoid {
        e.radii.iter().try_for_each(|r| positive(doc, &format!("{key}.ellipsoid.radii"), *r))?;
        Ok(Shape::simple(ShapeKind::Ellipsoid, e.radii.into()))
    } else if let Some(block) = &file.block {
        block.size.iter().try_for_each(|l| positive(doc, &format!("{key}.box.size"), *l))?;
        Ok(Shape::simple(ShapeKind::Box, DVec3::from_array(block.size) * 0.5))
    } else if let Some(c) = &file.cylinder {
        round("cylinder", ShapeKind::Cylinder, c)
    } else if let Some(c) = &file.capsule {
        round("capsule", ShapeKind::Capsule, c)
    } else if let Some(c) = &file.cone {
        round("cone", ShapeKind::Cone, c)
    } else if let Some(hull) = &file.hull {
        hull_shape(doc, &format!("{key}.hull"), hull, hulls)
    } else if let Some(plane) = &file.plane {
        let normal = direction(doc, &format!("{key}.plane.normal"), plane.normal)?;
        Ok(Shape {
            rotation: DQuat::from_rotation_arc(DVec3::Z, normal),
            ..Shape::simple(ShapeKind::Plane, DVec3::ZERO)
        })
    } else if let Some(mesh) = &file.mesh {
        let key = format!("{key}.mesh");
        positive(doc, &format!("{key}.scale"), mesh.scale)?;
        let (vertices, triangles) = read_triangles(doc, &format!("{key}.file"), &mesh.file, mesh.scale)?;
        if triangles.is_empty() {
            return Err(doc.fault(&format!("{key}.file"), format!("{} has no triangles", mesh.file.display())));
        }
        Ok(surface_shape(ShapeKind::Mesh, Surface::mesh(vertices, triangles)))
    } else {
        let field = file.height_field.as_ref().expect("one of them is there");
        height_field_shape(doc, &format!("{key}.height_field"), field)
    }
}

/// A mesh or height field; its size is the half lengths of the box about its origin that contains it.
pub fn surface_shape(kind: ShapeKind, surface: Surface) -> Shape {
    let (lo, hi) = surface.bounds();
    Shape { surface: Some(surface), ..Shape::simple(kind, lo.abs().max(hi.abs())) }
}

fn hull_shape(doc: &Document, key: &str, file: &HullFile, hulls: &mut Hulls) -> Result<Shape, Fault> {
    positive(doc, &format!("{key}.scale"), file.scale)?;
    let given: Vec<DVec3> = match (&file.points, &file.file) {
        (Some(points), None) => points.iter().map(|p| DVec3::from_array(*p) * file.scale).collect(),
        (None, Some(_)) => vec![DVec3::splat(file.scale)],
        _ => return Err(doc.fault(key, "needs exactly one of `points` and `file`")),
    };
    let bits = given.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
    let (hull, centre) = match hulls.entry((file.file.clone(), bits)) {
        Entry::Occupied(known) => known.get().clone(),
        Entry::Vacant(new) => {
            let points = match &file.file {
                Some(path) => read_vertices(doc, &format!("{key}.file"), path, file.scale)?,
                None => given,
            };
            if points.iter().any(|p| !p.is_finite()) {
                return Err(doc.fault(key, "has a point that is not finite"));
            }
            if points.len() < 4 {
                return Err(doc.fault(key, format!("has {} points, expected at least 4", points.len())));
            }
            let (hull, centre) = Hull::of_points(&points).ok_or_else(|| {
                doc.fault(key, "has points that lie in a plane: expected points that enclose a volume")
            })?;
            new.insert((Arc::new(hull), centre)).clone()
        }
    };
    let size = hull.half_extent();
    Ok(Shape { hull: Some(hull), shift: centre, ..Shape::simple(ShapeKind::Hull, size) })
}

/// Vertices of an OBJ, STL or PLY file. An OBJ of vertices alone is a cloud of points.
fn read_vertices(doc: &Document, key: &str, path: &Path, scale: f64) -> Result<Vec<DVec3>, Fault> {
    let (vertices, _) = read_triangles(doc, key, path, scale)?;
    if !vertices.is_empty() {
        return Ok(vertices);
    }
    let fail = |why: String| doc.fault(key, format!("{}: {why}", path.display()));
    let text = guard::read_to_string(path).map_err(|e| fail(e.to_string()))?;
    let vertex = |line: &str| -> Option<DVec3> {
        let mut numbers = line.strip_prefix("v ")?.split_whitespace().map(str::parse::<f64>);
        Some(DVec3::new(numbers.next()?.ok()?, numbers.next()?.ok()?, numbers.next()?.ok()?) * scale)
    };
    Ok(text.lines().filter_map(|line| vertex(line.trim())).collect())
}

/// Vertices and triangles of an OBJ, STL or PLY file.
fn read_triangles(doc: &Document, key: &str, path: &Path, scale: f64) -> Result<(Vec<DVec3>, Vec<[u32; 3]>), Fault> {
    let (mut vertices, mut triangles) = (vec![], vec![]);
    for mesh in mesh::read(path).map_err(|fault| doc.fault(key, fault.to_string()))? {
        let first = vertices.len() as u32;
        vertices.extend(mesh.points.iter().map(|p| DVec3::from_array(*p) * scale));
        triangles.extend(mesh.triangles().iter().map(|t| t.map(|k| k + first)));
    }
    Ok((vertices, triangles))
}

fn height_field_shape(doc: &Document, key: &str, file: &HeightFieldFile) -> Result<Shape, Fault> {
    /// Bytes that a height takes while its surface is made.
    const POINT: u64 = 200;
    file.size.iter().try_for_each(|l| positive(doc, &format!("{key}.size"), *l))?;
    finite(doc, &format!("{key}.height"), &file.height)?;
    let (heights, n) = match (&file.image, &file.grid) {
        (Some(path), None) => {
            let fail = |why: String| doc.fault(&format!("{key}.image"), format!("{}: {why}", path.display()));
            let image = guard::read_image(path).map_err(fail)?.into_luma16();
            let [black, white] = file.height;
            let (nx, ny) = (image.width() as usize, image.height() as usize);
            // The image's first row is the far side, +y.
            let heights = (0..nx * ny)
                .map(|k| {
                    let pixel = image.get_pixel((k % nx) as u32, (ny - 1 - k / nx) as u32);
                    black + (white - black) * pixel.0[0] as f64 / 65_535.0
                })
                .collect::<Vec<f64>>();
            (heights, [nx, ny])
        }
        (None, Some(path)) => read_grid(doc, &format!("{key}.grid"), path)?,
        _ => return Err(doc.fault(key, "needs exactly one of `image` and `grid`")),
    };
    if n[0] < 2 || n[1] < 2 {
        return Err(doc.fault(key, format!("has {}×{} heights, expected at least 2×2", n[0], n[1])));
    }
    if (n[0] * n[1]) as u64 * POINT > guard::memory::room() {
        return Err(doc.fault(key, format!("has {}×{} heights: {}", n[0], n[1], guard::memory::Full)));
    }
    let spacing = [0, 1].map(|k| file.size[k] / (n[k] - 1) as f64);
    let origin = file.size.map(|l| -0.5 * l);
    Ok(surface_shape(ShapeKind::HeightField, Surface::height_field(&heights, n, origin, spacing)))
}

/// The cells of a row, which commas, semicolons, tabs or blanks separate. A comma is that of a decimal fraction where something else does.
fn cells(row: &str) -> impl Iterator<Item = Cow<'_, str>> {
    let words = || row.split_whitespace();
    let are_fractions = words().count() > 1 && words().any(|w| w.contains(',')) && !words().any(|w| w.ends_with(','));
    let (separators, has_fractions): (&[char], bool) = match row.contains([';', '\t']) {
        true => (&[';', '\t'], true),
        false if are_fractions => (&[' '], true),
        false => (&[',', ' '], false),
    };
    let cells = row.split(separators).map(str::trim).filter(|cell| !cell.is_empty());
    cells.map(move |cell| if has_fractions { cell.replace(',', ".").into() } else { cell.into() })
}

/// Heights of a text file, row by row, m, and their counts along x and y.
fn read_grid(doc: &Document, key: &str, path: &Path) -> Result<(Vec<f64>, [usize; 2]), Fault> {
    let text = guard::read_to_string(path).map_err(|e| doc.fault(key, format!("{}: {e}", path.display())))?;
    let text = text.trim_start_matches('\u{feff}');
    let (mut heights, mut nx, mut ny) = (vec![], 0, 0);
    for (line, row) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#')) {
        let before = heights.len();
        for cell in cells(row) {
            match cell.parse::<f64>() {
                Ok(z) if z.is_finite() => heights.push(z),
                _ => {
                    let message = format!("{}, line {}: `{cell}` is not a number", path.display(), line + 1);
                    return Err(doc.fault(key, message));
                }
            }
        }
        let n = heights.len() - before;
        if ny > 0 && n != nx {
            let message = format!("{}, line {}: {n} heights, the lines before have {nx}", path.display(), line + 1);
            return Err(doc.fault(key, message));
        }
        (nx, ny) = (n, ny + 1);
    }
    Ok((heights, [nx, ny]))
}

#[cfg(test)]
mod tests {
    use super::cells;

    #[test]
    fn commas_of_heights_separate_or_are_decimal() {
        for (row, expected) in [
            ("0.5,0.6", vec!["0.5", "0.6"]),
            ("0.5, 0.6,", vec!["0.5", "0.6"]),
            (" 0.5  0.6 ", vec!["0.5", "0.6"]),
            ("0,5;0,6", vec!["0.5", "0.6"]),
            ("0,5\t0,6", vec!["0.5", "0.6"]),
            ("0,5 0,6", vec!["0.5", "0.6"]),
            ("1,2,3", vec!["1", "2", "3"]),
        ] {
            assert_eq!(cells(row).collect::<Vec<_>>(), expected, "{row}");
        }
    }
}
