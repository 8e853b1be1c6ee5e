//! Hulls, meshes and height fields of a model as RIB archives in its run directory, one for each shape name of the frames.

use frame::{Fault, FaultKind, atomic};
use glam::DVec3;
use render::ri::writer::Writer;
use render::ri::{Class, Fail, Param, Ri, Type};
use sim::{Model, ShapeKind};
use std::collections::BTreeSet;
use std::path::Path;

/// Write the archives: `geometry/hull_0.rib`, `geometry/mesh_0.rib`, …, each once, whatever number of shapes has it.
pub fn write_archives(model: &Model, folder: &Path) -> Result<(), Fault> {
    let mut written = BTreeSet::new();
    for s in 0..model.n_shapes() {
        let (kind, part) = (model.shape_kind[s], model.shape_part[s] as usize);
        if !written.insert((kind.name(), part)) {
            continue;
        }
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
        let rib = rib.map_err(|e| Fault::whole(FaultKind::Machine, &path, e.message))?;
        atomic::write(&path, &rib)?;
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
