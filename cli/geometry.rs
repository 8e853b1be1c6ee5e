//! Hulls, meshes and height fields of a model as RIB archives in its run directory, one for each shape name of the frames.

use frame::{Fault, FaultKind, atomic};
use glam::DVec3;
use render::ri::writer::Writer;
use render::ri::{Class, Fail, Param, Ri, Type};
use sim::{Model, ShapeKind};
use std::path::Path;

/// Write the archives: `geometry/hull_0.rib`, `geometry/mesh_0.rib`, …. Many shapes may have one hull; surfaces are of one shape each.
pub fn write_archives(model: &Model, folder: &Path) -> Result<(), Fault> {
    let write = |kind: ShapeKind, part: usize, rib: Result<Vec<u8>, Fail>| {
        let path = folder.join(format!("geometry/{}_{part}.rib", kind.name()));
        let rib = rib.map_err(|e| Fault::whole(FaultKind::Machine, &path, e.message))?;
        atomic::write(&path, &rib)
    };
    for (part, hull) in model.hulls.iter().enumerate() {
        write(ShapeKind::Hull, part, polygons(&hull.vertices, &hull.faces, &[]))?;
    }
    for (kind, part) in model.shape_kind.iter().zip(&model.shape_part) {
        // A height field is smooth ground; a mesh keeps its edges.
        let is_smooth = match kind {
            ShapeKind::Mesh => false,
            ShapeKind::HeightField => true,
            _ => continue,
        };
        let surface = &model.surfaces[*part as usize];
        let faces: Vec<Vec<u32>> = surface.triangles.iter().map(|t| t.to_vec()).collect();
        let normals = if is_smooth { vertex_normals(&surface.vertices, &surface.triangles) } else { vec![] };
        write(*kind, *part as usize, polygons(&surface.vertices, &faces, &normals))?;
    }
    Ok(())
}

/// The RIB of a `PointsPolygons` request.
fn polygons(vertices: &[DVec3], faces: &[Vec<u32>], normals: &[DVec3]) -> Result<Vec<u8>, Fail> {
    let floats = |v: &[DVec3]| v.iter().flat_map(|p| p.as_vec3().to_array()).collect::<Vec<f32>>();
    let mut params = vec![Param::floats("P", Class::Vertex, Type::Point, floats(vertices))];
    if !normals.is_empty() {
        params.push(Param::floats("N", Class::Varying, Type::Normal, floats(normals)));
    }
    let counts = faces.iter().map(|f| f.len() as i32).collect();
    let corners = faces.iter().flatten().map(|v| *v as i32).collect();
    let mut writer = Writer::archive(Vec::new());
    writer.points_polygons(counts, corners, params)?;
    Ok(writer.into_inner())
}

/// The normal of each vertex: the mean over its triangles, weighted by area.
fn vertex_normals(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; vertices.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| vertices[v as usize]);
        t.iter().for_each(|v| normals[*v as usize] += (b - a).cross(c - a));
    }
    normals.into_iter().map(|n| n.normalize_or(DVec3::Z)).collect()
}
