//! Polygon meshes of files: Wavefront OBJ, STL and PLY.

use crate::{Column, Fault, FaultKind, obj, ply};
use std::io::Cursor;
use std::path::Path;

/// A mesh of polygons.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Points, in the file's unit of length.
    pub points: Vec<[f64; 3]>,
    /// Normals, one a point, or none at all.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates s and t, one a point, or none at all; t goes up.
    pub st: Vec<[f32; 2]>,
    /// Count of corners of each polygon, at least 3.
    pub arities: Vec<u32>,
    /// Points of the corners, polygon by polygon.
    pub corners: Vec<u32>,
}

impl Mesh {
    /// The polygons as triangles that fan out from the first corner of each.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let mut all = vec![];
        let mut rest = &self.corners[..];
        for arity in &self.arities {
            let (polygon, others) = rest.split_at(*arity as usize);
            all.extend(polygon[1..].windows(2).map(|edge| [polygon[0], edge[0], edge[1]]));
            rest = others;
        }
        all
    }

    /// The mesh, if its numbers agree.
    fn checked(self, path: &Path) -> Result<Mesh, Fault> {
        let fault = |message: String| Err(Fault::whole(FaultKind::Data, path, message));
        if let Some(k) = self.points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return fault(format!("vertex {k} is not finite"));
        }
        if let Some(k) = self.arities.iter().position(|n| *n < 3) {
            return fault(format!("face {k} has {} corners, expected at least 3", self.arities[k]));
        }
        if let Some(corner) = self.corners.iter().find(|corner| **corner as usize >= self.points.len()) {
            return fault(format!("a face has the vertex {}, and there are {}", *corner as i32, self.points.len()));
        }
        Ok(self)
    }
}

/// Read the meshes of a file: several where an OBJ file has objects and groups.
pub fn read(path: &Path) -> Result<Vec<Mesh>, Fault> {
    parse(path, &crate::read_bytes(FaultKind::Data, path)?)
}

/// The meshes of a file of these bytes. Its name tells OBJ and STL; PLY files begin with their own.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<Mesh>, Fault> {
    let meshes = match path.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase).as_deref() {
        _ if ply::is_ply(bytes) => vec![of_ply(path, bytes)?],
        Some("stl") => vec![of_stl(path, bytes)?],
        Some("obj") => obj::parse(path, bytes)?.into_iter().map(of_polygons).collect(),
        _ => return Err(Fault::whole(FaultKind::Data, path, "is neither an .obj, nor an .stl, nor a .ply file")),
    };
    if meshes.iter().all(|mesh| mesh.arities.is_empty()) {
        let message = "has no faces: there is no surface to draw or to touch";
        return Err(
            Fault::whole(FaultKind::Data, path, message).hint("points alone are a table: draw a sphere at each")
        );
    }
    meshes.into_iter().map(|mesh| mesh.checked(path)).collect()
}

fn of_polygons(polygons: obj::Polygons) -> Mesh {
    let obj::Polygons { points, normals, st, arities, corners } = polygons;
    Mesh { points: points.into_iter().map(|p| p.map(f64::from)).collect(), normals, st, arities, corners }
}

fn of_stl(path: &Path, bytes: &[u8]) -> Result<Mesh, Fault> {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes))
        .map_err(|wrong| Fault::whole(FaultKind::Data, path, wrong.to_string()))?;
    Ok(Mesh {
        points: mesh.vertices.iter().map(|v| [v[0].into(), v[1].into(), v[2].into()]).collect(),
        arities: vec![3; mesh.faces.len()],
        corners: mesh.faces.iter().flat_map(|face| face.vertices.map(|v| v as u32)).collect(),
        ..Mesh::default()
    })
}

fn of_ply(path: &Path, bytes: &[u8]) -> Result<Mesh, Fault> {
    let mut faces = ply::Faces::default();
    let columns = ply::parse(path, bytes, Some(&mut faces))?;
    let column = |name: &str| columns.iter().find(|(field, _)| field.name == name).map(|(_, column)| column);
    let number = |column: &Column, row: usize| column.number(row).unwrap_or(f64::NAN);
    let rows = columns.first().map_or(0, |(_, column)| column.len());
    let (Some(x), Some(y), Some(z)) = (column("x"), column("y"), column("z")) else {
        return Err(Fault::whole(FaultKind::Data, path, "its vertices have no x, y and z"));
    };
    let normals = match (column("nx"), column("ny"), column("nz")) {
        (Some(x), Some(y), Some(z)) => (0..rows).map(|k| [x, y, z].map(|column| number(column, k) as f32)).collect(),
        _ => vec![],
    };
    let pairs = [("s", "t"), ("u", "v"), ("texture_u", "texture_v")];
    let st = pairs.into_iter().find_map(|(s, t)| Some((column(s)?, column(t)?)));
    let st = st.map_or(vec![], |(s, t)| (0..rows).map(|k| [s, t].map(|column| number(column, k) as f32)).collect());
    Ok(Mesh {
        points: (0..rows).map(|k| [x, y, z].map(|column| number(column, k))).collect(),
        normals,
        st,
        arities: faces.arities,
        corners: faces.corners,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::tests::mutated;

    const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n\
         property float ny\nproperty float nz\nproperty float s\nproperty float t\nelement face 2\nproperty uchar red\n\
         property list uchar int vertex_indices\nend_header\n0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n1 1 0 0 0 1 1 1\n0 1 0 0 0 1 0 1\n\
         2 0 0 0 0 1 2 0\n9 4 0 1 2 3\n9 3 1 4 2\n";

    fn mesh(name: &str, bytes: &[u8]) -> Result<Vec<Mesh>, Fault> {
        parse(Path::new(name), bytes)
    }

    #[test]
    fn polygons_of_all_formats_are_the_same_triangles() {
        let triangles = vec![[0, 1, 2], [0, 2, 3], [1, 4, 2]];
        let ply = mesh("a.ply", PLY.as_bytes()).unwrap().remove(0);
        assert_eq!((ply.arities.clone(), ply.triangles()), (vec![4, 3], triangles.clone()));
        assert_eq!((ply.points[4], ply.normals[4], ply.st[4]), ([2.0, 0.0, 0.0], [0.0, 0.0, 1.0], [2.0, 0.0]));

        let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 1 2 3 4\nf 2 5 3\n";
        let obj = mesh("a.obj", obj.as_bytes()).unwrap().remove(0);
        assert_eq!((obj.points.clone(), obj.triangles()), (ply.points.clone(), triangles));

        let corner = |k: u32| ply.points[k as usize].map(|x| x as f32);
        let mut stl = vec![];
        let facet = |t: &[u32; 3]| stl_io::Triangle {
            normal: stl_io::Normal::new([0.0, 0.0, 1.0]),
            vertices: t.map(|k| stl_io::Vertex::new(corner(k))),
        };
        stl_io::write_stl(&mut stl, ply.triangles().iter().map(facet).collect::<Vec<_>>().iter()).unwrap();
        let stl = mesh("a.STL", &stl).unwrap().remove(0);
        let places = |mesh: &Mesh| -> Vec<[f64; 3]> {
            mesh.triangles().concat().into_iter().map(|k| mesh.points[k as usize]).collect()
        };
        assert_eq!(places(&stl), places(&ply));
    }

    #[test]
    fn binary_faces_are_those_of_the_text() {
        let whole = mesh("a.ply", PLY.as_bytes()).unwrap();
        let (head, rows) = PLY.split_once("end_header\n").unwrap();
        for (order, is_big) in [("binary_little_endian", false), ("binary_big_endian", true)] {
            let mut bytes = format!("{}end_header\n", head.replace("ascii", order)).into_bytes();
            let turned = |mut bytes: [u8; 4]| {
                if is_big {
                    bytes.reverse();
                }
                bytes
            };
            for (k, row) in rows.lines().enumerate() {
                for (i, word) in row.split(' ').enumerate() {
                    match (k, i) {
                        (0..5, _) => bytes.extend(turned(word.parse::<f32>().unwrap().to_le_bytes())),
                        (_, 0 | 1) => bytes.push(word.parse().unwrap()),
                        _ => bytes.extend(turned(word.parse::<i32>().unwrap().to_le_bytes())),
                    }
                }
            }
            assert_eq!(mesh("a.ply", &bytes).unwrap(), whole);
            mutated(&bytes, |_, path| drop(read(path)));
        }
    }

    #[test]
    fn wrong_meshes_are_faults() {
        for (name, text, line, message) in [
            ("a.obj", "v 0 0 0\nv 1 0 zero\nf 1 1 1\n".to_string(), 2, "`zero` is no number"),
            ("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nf 1 2 9\n".to_string(), 5, "out of bounds"),
            ("a.obj", "v 0 0 nan\nv 1 0 0\nv 1 1 0\nf 1 2 3\n".to_string(), 0, "vertex 0 is not finite"),
            ("a.txt", "v 0 0 0\n".to_string(), 0, "is neither"),
            ("a.ply", PLY.replace("3 1 4 2", "3 1 5 2"), 0, "the vertex 5, and there are 5"),
            ("a.ply", PLY.replace("3 1 4 2", "2 1 4"), 0, "face 1 has 2 corners"),
            ("a.ply", PLY.replace("3 1 4 2", "3 1 -4 2"), 22, "`-4` is no number of a vertex"),
            ("a.ply", PLY.replace("property float z", "property float w"), 0, "no x, y and z"),
            ("a.stl", "solid a\nfacet normal 0 0 one\n".to_string(), 0, ""),
        ] {
            let fault = mesh(name, text.as_bytes()).unwrap_err();
            assert!(fault.message.contains(message) && fault.line == line, "{fault} for\n{text}");
        }
    }
}
