//! Files that are read in place: RIB, and the meshes of Wavefront OBJ.

use ri::files::Files;
use ri::{Class, Fail, Param, Ri, RiResult, Type, reader};
use std::path::Path;

/// Read a RIB or OBJ file in place.
pub(super) fn include(file: &str, files: &Files, ri: &mut dyn Ri) -> RiResult {
    if file.to_lowercase().ends_with(".obj") {
        return wavefront(file, files, ri);
    }
    let (path, text) = files.read(file, &["scenes"]).map_err(Fail::new)?;
    reader::read(&path, text.as_bytes(), files, ri, &mut |_, _| Ok(())).map_err(|e| Fail::new(format!("in {e}")))
}

/// The polygons of a Wavefront OBJ file, with the normals and texture coordinates that it has.
fn wavefront(file: &str, files: &Files, ri: &mut dyn Ri) -> RiResult {
    let (path, text) = files.read(file, &["scenes"]).map_err(Fail::new)?;
    // Materials are the binding's.
    let none = |_: &Path| Ok((vec![], Default::default()));
    let options = tobj::LoadOptions { single_index: true, ..Default::default() };
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, none)
        .map_err(|e| Fail::new(format!("in {}: {e}", path.display())))?;
    for mesh in models.into_iter().map(|m| m.mesh).filter(|m| !m.indices.is_empty()) {
        let vertices: Vec<i32> = mesh.indices.iter().map(|i| *i as i32).collect();
        let faces = if mesh.face_arities.is_empty() {
            vec![3; vertices.len() / 3]
        } else {
            mesh.face_arities.iter().map(|n| *n as i32).collect()
        };
        let mut params = vec![Param::floats("P", Class::Vertex, Type::Point, mesh.positions)];
        if !mesh.normals.is_empty() {
            params.push(Param::floats("N", Class::Vertex, Type::Normal, mesh.normals));
        }
        if !mesh.texcoords.is_empty() {
            // The file's t goes up, the image's down.
            let corner = |k: usize| mesh.texcoords.iter().skip(k).step_by(2);
            params.push(Param::floats("s", Class::Vertex, Type::Float, corner(0).copied().collect::<Vec<_>>()));
            params.push(Param::floats("t", Class::Vertex, Type::Float, corner(1).map(|t| 1.0 - t).collect::<Vec<_>>()));
        }
        ri.points_polygons(faces, vertices, params)?;
    }
    Ok(())
}
