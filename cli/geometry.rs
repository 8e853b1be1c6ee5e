//! The hulls, meshes and height fields of a model as RIB archives in its run directory, one for each shape name of the frames.

use crate::report::Outcome;
use frame::atomic;
use glam::DVec3;
use sim::{Model, ShapeKind};
use std::fmt::Write;
use std::path::Path;

/// Write `geometry/hull_0.rib` and its like.
pub fn write_archives(model: &Model, folder: &Path) -> Outcome {
    for s in 0..model.n_shapes() {
        let (kind, part) = (model.shape_kind[s], model.shape_part[s] as usize);
        let rib = match kind {
            ShapeKind::Hull => {
                let hull = &model.hulls[part];
                polygons(&hull.vertices, &hull.faces, &[])
            }
            ShapeKind::Mesh | ShapeKind::HeightField => {
                let surface = &model.surfaces[part];
                let faces: Vec<Vec<u32>> = surface.triangles.iter().map(|t| t.to_vec()).collect();
                // A height field is smooth ground; a mesh keeps its edges.
                let smooth = kind == ShapeKind::HeightField;
                let normals = if smooth { vertex_normals(&surface.vertices, &surface.triangles) } else { vec![] };
                polygons(&surface.vertices, &faces, &normals)
            }
            _ => continue,
        };
        let path = folder.join(format!("geometry/{}_{part}.rib", kind.name()));
        atomic::write(&path, rib.as_bytes())?;
    }
    Ok(())
}

/// A `PointsPolygons` request.
fn polygons(vertices: &[DVec3], faces: &[Vec<u32>], normals: &[DVec3]) -> String {
    let mut rib = String::from("PointsPolygons [");
    faces.iter().for_each(|f| {
        let _ = write!(rib, "{} ", f.len());
    });
    rib.push_str("] [");
    faces.iter().flatten().for_each(|v| {
        let _ = write!(rib, "{v} ");
    });
    rib.push_str("] \"P\" [");
    vertices.iter().for_each(|p| {
        let _ = write!(rib, "{} {} {} ", p.x as f32, p.y as f32, p.z as f32);
    });
    rib.push(']');
    if !normals.is_empty() {
        rib.push_str(" \"N\" [");
        normals.iter().for_each(|p| {
            let _ = write!(rib, "{} {} {} ", p.x as f32, p.y as f32, p.z as f32);
        });
        rib.push(']');
    }
    rib.push('\n');
    rib
}

/// The mean normal of the triangles around each vertex, by their areas.
fn vertex_normals(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; vertices.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| vertices[v as usize]);
        t.iter().for_each(|v| normals[*v as usize] += (b - a).cross(c - a));
    }
    normals.into_iter().map(|n| n.normalize_or(DVec3::Z)).collect()
}
