//! Shapes without an archetype of their own as meshes: cones, and the archives of hulls, meshes and height fields.

use bind::binding::Shape;
use frame::mesh;
use rerun::Mesh3D;
use ri::files::Files;
use ri::{Param, Params, Ri, RiResult, Values, reader};
use std::path::Path;

/// Points and triangles.
#[derive(Default)]
pub struct Triangles {
    points: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Triangles {
    /// The mesh of a shape of unit size, or of what the file `archive` has. An error says why there is none.
    pub fn of(shape: &Shape, archive: Option<&str>, files: &Files) -> Result<Triangles, String> {
        match (shape, archive) {
            (_, Some(file)) => Triangles::of_file(file, files),
            (Shape::Cone(_), None) => Ok(Triangles::cone()),
            _ => Err("it has no mesh".into()),
        }
    }

    fn of_file(file: &str, files: &Files) -> Result<Triangles, String> {
        let ending = Path::new(file).extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
        let mut all = Triangles::default();
        if ["obj", "stl", "ply"].contains(&ending.as_str()) {
            let (path, bytes) = files.read_bytes(file, &["scenes"])?;
            for mesh in mesh::parse(&path, &bytes).map_err(|fault| fault.to_string())? {
                let points = mesh.points.iter().map(|p| p.map(|x| x as f32)).collect();
                all.add(points, &mesh.arities, &mesh.corners);
            }
        } else {
            let (path, text) = files.read(file, &["scenes"])?;
            reader::read(&path, text.as_bytes(), files, &mut all, &mut |_, _| Ok(None)).map_err(|e| e.to_string())?;
        }
        if all.triangles.is_empty() { Err(format!("{file} has no polygons")) } else { Ok(all) }
    }

    /// A cone of radius 1 from z = −1 to its tip at 1.
    fn cone() -> Triangles {
        const CORNERS: u32 = 24;
        let at = |k: u32| (std::f32::consts::TAU * k as f32 / CORNERS as f32).sin_cos();
        let ring = (0..CORNERS).map(at).map(|(s, c)| [c, s, -1.0]);
        let points = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]].into_iter().chain(ring).collect();
        let sides = (0..CORNERS).flat_map(|k| {
            let (a, b) = (2 + k, 2 + (k + 1) % CORNERS);
            [[0, a, b], [1, b, a]]
        });
        Triangles { points, triangles: sides.collect() }
    }

    fn add(&mut self, points: Vec<[f32; 3]>, arities: &[u32], corners: &[u32]) {
        let first = self.points.len() as u32;
        let mut rest = corners;
        for arity in arities {
            let (polygon, others) = rest.split_at(*arity as usize);
            let fan = polygon[1..].windows(2).map(|edge| [polygon[0], edge[0], edge[1]].map(|k| first + k));
            self.triangles.extend(fan);
            rest = others;
        }
        self.points.extend(points);
    }

    /// The archetype, with a normal at each corner of each triangle, so that edges are edges.
    pub fn archetype(&self, color: rerun::Color) -> Mesh3D {
        let corners: Vec<[f32; 3]> = self.triangles.iter().flatten().map(|k| self.points[*k as usize]).collect();
        let normals = corners.chunks_exact(3).flat_map(|t| [normal(t); 3]);
        Mesh3D::new(corners.clone()).with_vertex_normals(normals).with_albedo_factor(color.0)
    }
}

/// The normal of a triangle; upwards if it has none.
fn normal(triangle: &[[f32; 3]]) -> [f32; 3] {
    let edge = |k: usize| [0, 1, 2].map(|i| triangle[k][i] - triangle[0][i]);
    let (a, b) = (edge(1), edge(2));
    let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
    if length > 0.0 { n.map(|x| x / length) } else { [0.0, 0.0, 1.0] }
}

/// The points of a primitive.
fn points(params: &Params) -> Vec<[f32; 3]> {
    let of = |param: &Param| match &param.values {
        Values::Floats(v) if param.decl.name == "P" => Some(v.as_chunks().0.to_vec()),
        _ => None,
    };
    params.iter().find_map(of).unwrap_or_default()
}

/// Polygons are taken, all other primitives are refused.
impl Ri for Triangles {
    fn polygon(&mut self, params: Params) -> RiResult {
        let points = points(&params);
        let n = points.len() as u32;
        self.add(points, &[n], &(0..n).collect::<Vec<_>>());
        Ok(())
    }

    fn points_polygons(&mut self, arities: Vec<i32>, corners: Vec<i32>, params: Params) -> RiResult {
        let whole = |numbers: Vec<i32>| numbers.into_iter().map(|n| n as u32).collect::<Vec<u32>>();
        self.add(points(&params), &whole(arities), &whole(corners));
        Ok(())
    }

    fn archive_record(&mut self, _kind: &str, _text: &str) -> RiResult {
        Ok(())
    }

    fn attribute_begin(&mut self) -> RiResult {
        Ok(())
    }

    fn attribute_end(&mut self) -> RiResult {
        Ok(())
    }
}
