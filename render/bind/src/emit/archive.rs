//! Files that are read in place: RIB, and meshes.

use crate::emit::directive::take_alone;
use crate::emit::wrong::{Origin, Wrong};
use frame::{Fault, FaultKind, mesh};
use ri::files::Files;
use ri::{Class, Fail, Param, Ri, Type, reader};
use std::path::Path;

/// Read a RIB file or a mesh in place, which the key of `at` names.
pub(super) fn include(file: &str, files: &Files, at: Origin<'_>, ri: &mut dyn Ri) -> Result<(), Wrong> {
    let ending = Path::new(file).extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_lowercase();
    if ["obj", "stl", "ply"].contains(&ending.as_str()) {
        return mesh(file, files, at, ri);
    }
    const OTHERS: [&str; 14] =
        ["off", "gltf", "glb", "fbx", "dae", "3ds", "step", "stp", "iges", "igs", "3mf", "wrl", "usd", "usdz"];
    if OTHERS.contains(&ending.as_str()) {
        let message =
            format!("{file} is none of the files that can be drawn, which are RIB and meshes as OBJ, STL and PLY");
        return Err(at.wrong(Fail::new(message)));
    }
    let (path, text) = files.read(file, &["scenes"]).map_err(|message| at.wrong(Fail::new(message)))?;
    reader::read(&path, text.as_bytes(), files, ri, &mut |_, directive| take_alone(directive).map(|_| None))
        .map_err(|error| at.in_rib(error))
}

/// The polygons of a mesh, with the normals and texture coordinates that it has. Materials are the binding's.
fn mesh(file: &str, files: &Files, at: Origin<'_>, ri: &mut dyn Ri) -> Result<(), Wrong> {
    let (path, bytes) = files.read_bytes(file, &["scenes"]).map_err(|message| at.wrong(Fail::new(message)))?;
    for mesh in mesh::parse(&path, &bytes).map_err(|fault| at.within(fault))? {
        let points: Vec<f32> = mesh.points.as_flattened().iter().map(|x| *x as f32).collect();
        let mut params = vec![Param::floats("P", Class::Vertex, Type::Point, points)];
        if !mesh.normals.is_empty() {
            params.push(Param::floats("N", Class::Vertex, Type::Normal, mesh.normals.concat()));
        }
        if !mesh.st.is_empty() {
            // The file's t goes up, the image's down.
            params.push(Param::floats(
                "s",
                Class::Vertex,
                Type::Float,
                mesh.st.iter().map(|[s, _]| *s).collect::<Vec<_>>(),
            ));
            params.push(Param::floats(
                "t",
                Class::Vertex,
                Type::Float,
                mesh.st.iter().map(|[_, t]| 1.0 - t).collect::<Vec<_>>(),
            ));
        }
        let whole = |numbers: Vec<u32>| numbers.into_iter().map(|n| n as i32).collect();
        let drawn = ri.points_polygons(whole(mesh.arities), whole(mesh.corners), params);
        drawn.map_err(|fail| at.within(Fault::whole(FaultKind::Data, &path, fail.message)))?;
    }
    Ok(())
}
