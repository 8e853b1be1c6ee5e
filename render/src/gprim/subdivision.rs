//! Catmull–Clark subdivision (1978) with creases, corners, holes and boundaries.
//!
//! A mesh is subdivided a few times, until its extraordinary vertices and creases are small; then each face becomes a bicubic
//! patch by the masks of Loop and Schaefer (2008), which is the limit surface itself where a face is regular.

use crate::scene::patch::Patch;
use glam::Vec3;
use ri::{Fail, Tags};
use std::collections::HashMap;

/// A mesh of faces, with values at the faces' corners that are interpolated linearly.
#[derive(Clone, Default)]
pub struct Mesh {
    points: Vec<Vec3>,
    /// Vertices of each face.
    faces: Vec<Vec<u32>>,
    /// Rows of corner values of each face, `width` numbers a corner.
    values: Vec<Vec<f32>>,
    width: usize,
    /// The face that each came from.
    origin: Vec<u32>,
    /// Sharpness of edges, the lower vertex first.
    creases: HashMap<[u32; 2], f32>,
    /// Sharpness of vertices.
    corners: HashMap<u32, f32>,
}

/// A face of the limit surface.
pub struct LimitPatch {
    /// The patch.
    pub patch: Patch,
    /// Values at (0,0), (1,0), (0,1), (1,1), `width` numbers each.
    pub values: Vec<f32>,
    /// The face that it came from.
    pub face: usize,
}

/// From so much on an edge is sharp for good.
const SHARP: f32 = 10.0;

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// What meets at the edges and the vertices.
struct Around {
    /// Faces at each edge.
    edges: HashMap<[u32; 2], Vec<u32>>,
    /// Faces at each vertex.
    faces: Vec<Vec<u32>>,
    /// Neighbours of each vertex along edges.
    neighbours: Vec<Vec<u32>>,
}

impl Mesh {
    /// A mesh with its tags; `values` has a row of `width` numbers for each corner of each face, in order.
    pub fn new(
        points: Vec<Vec3>,
        n_vertices: &[i32],
        vertices: &[i32],
        tags: &Tags,
        values: &[f32],
        width: usize,
    ) -> Result<Mesh, Fail> {
        let mut mesh = Mesh { points, width, ..Mesh::default() };
        let mut at = 0;
        for (f, n) in n_vertices.iter().enumerate() {
            let n = usize::try_from(*n).ok().filter(|n| *n >= 3);
            let n = n.ok_or(Fail::new(format!("face {f} has fewer than 3 vertices")))?;
            let own = vertices.get(at..at + n).ok_or(Fail::new(format!("the vertex list ends in face {f}")))?;
            let face: Option<Vec<u32>> =
                own.iter().map(|v| u32::try_from(*v).ok().filter(|v| (*v as usize) < mesh.points.len())).collect();
            mesh.faces.push(face.ok_or(Fail::new(format!("face {f} has a vertex that is not in \"P\"")))?);
            mesh.values.push(values[at * width..(at + n) * width].to_vec());
            mesh.origin.push(f as u32);
            at += n;
        }
        mesh.tag(tags)?;
        Ok(mesh)
    }

    fn tag(&mut self, tags: &Tags) -> Result<(), Fail> {
        let (mut i, mut x) = (0, 0);
        let mut holes = vec![];
        let mut boundary = false;
        for (k, name) in tags.names.iter().enumerate() {
            let count = |j: usize| usize::try_from(*tags.n_args.get(2 * k + j)?).ok();
            let (Some(ni), Some(nf)) = (count(0), count(1)) else {
                return Err(Fail::new(format!("tag `{name}` has no numbers of arguments")));
            };
            let (Some(integers), Some(floats)) = (tags.integers.get(i..i + ni), tags.floats.get(x..x + nf)) else {
                return Err(Fail::new(format!("the arguments of tag `{name}` are missing")));
            };
            (i, x) = (i + ni, x + nf);
            let vertex = |v: &i32| {
                let known = u32::try_from(*v).ok().filter(|v| (*v as usize) < self.points.len());
                known.ok_or(Fail::new(format!("tag `{name}` names vertex {v}, which does not exist")))
            };
            match name.as_str() {
                "hole" => {
                    let n = self.faces.len();
                    if let Some(f) = integers.iter().find(|f| !usize::try_from(**f).is_ok_and(|f| f < n)) {
                        return Err(Fail::new(format!("tag `hole` names face {f}, which does not exist")));
                    }
                    holes.extend(integers.iter().map(|f| *f as u32));
                }
                "crease" => {
                    for (e, pair) in integers.windows(2).enumerate() {
                        let sharp = floats.get(e).or(floats.first()).copied().unwrap_or(SHARP);
                        let (a, b) = (vertex(&pair[0])?, vertex(&pair[1])?);
                        self.creases.insert(key(a, b), sharp);
                    }
                }
                "corner" => {
                    for (e, v) in integers.iter().enumerate() {
                        let sharp = floats.get(e).or(floats.first()).copied().unwrap_or(SHARP);
                        let v = vertex(v)?;
                        self.corners.insert(v, sharp);
                    }
                }
                "interpolateboundary" => boundary = integers.first() != Some(&0),
                // How values are carried over and what else renderers add changes little.
                _ => {}
            }
        }
        let around = self.around();
        let on_edge = |f: &[u32]| f.iter().any(|v| self.on_boundary(*v, &around));
        let keep: Vec<bool> = (0..self.faces.len())
            .map(|f| !holes.contains(&(f as u32)) && (boundary || !on_edge(&self.faces[f])))
            .collect();
        if boundary {
            for (edge, faces) in &around.edges {
                if faces.len() == 1 {
                    self.creases.insert(*edge, SHARP);
                }
            }
            for v in 0..self.points.len() as u32 {
                if around.faces[v as usize].len() == 1 {
                    self.corners.insert(v, SHARP);
                }
            }
        }
        // Faces that are not drawn shape the others all the same.
        for (f, keep) in keep.iter().enumerate() {
            if !keep {
                self.origin[f] = u32::MAX;
            }
        }
        Ok(())
    }

    fn around(&self) -> Around {
        let mut edges: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
        let mut faces = vec![vec![]; self.points.len()];
        let mut neighbours = vec![vec![]; self.points.len()];
        for (f, face) in self.faces.iter().enumerate() {
            for (k, v) in face.iter().enumerate() {
                let next = face[(k + 1) % face.len()];
                faces[*v as usize].push(f as u32);
                let edge = edges.entry(key(*v, next)).or_default();
                if edge.is_empty() {
                    neighbours[*v as usize].push(next);
                    neighbours[next as usize].push(*v);
                }
                edge.push(f as u32);
            }
        }
        Around { edges, faces, neighbours }
    }

    fn on_boundary(&self, v: u32, around: &Around) -> bool {
        around.neighbours[v as usize].iter().any(|n| around.edges[&key(v, *n)].len() == 1)
    }

    /// Sharpness of an edge; one with a face on one side only is sharp.
    fn sharpness(&self, edge: [u32; 2], around: &Around) -> f32 {
        if around.edges.get(&edge).is_none_or(|f| f.len() != 2) {
            return SHARP;
        }
        self.creases.get(&edge).copied().unwrap_or(0.0)
    }

    /// One step of subdivision: every face becomes as many quadrilaterals as it has corners.
    fn subdivide(&self) -> Mesh {
        let around = self.around();
        let mut out = Mesh { width: self.width, ..Mesh::default() };
        let middle = |face: &[u32]| face.iter().map(|v| self.points[*v as usize]).sum::<Vec3>() / face.len() as f32;
        let centers: Vec<Vec3> = self.faces.iter().map(|f| middle(f)).collect();
        for v in 0..self.points.len() {
            out.points.push(self.moved(v as u32, &centers, &around));
        }
        let first_center = out.points.len() as u32;
        out.points.extend(&centers);
        // Edges in the order in which faces meet them, whatever a hash map does.
        let mut edge_point: HashMap<[u32; 2], u32> = HashMap::new();
        for face in &self.faces {
            for (k, v) in face.iter().enumerate() {
                let edge = key(*v, face[(k + 1) % face.len()]);
                if edge_point.contains_key(&edge) {
                    continue;
                }
                let ends = 0.5 * (self.points[edge[0] as usize] + self.points[edge[1] as usize]);
                let sharp = self.sharpness(edge, &around);
                let faces = &around.edges[&edge];
                let smooth = if faces.len() == 2 {
                    0.5 * ends + 0.25 * (centers[faces[0] as usize] + centers[faces[1] as usize])
                } else {
                    ends
                };
                edge_point.insert(edge, out.points.len() as u32);
                out.points.push(smooth.lerp(ends, sharp.clamp(0.0, 1.0)));
                let next = if sharp >= SHARP { sharp } else { sharp - 1.0 };
                if next > 0.0 && faces.len() == 2 || self.creases.get(&edge).is_some_and(|s| *s >= SHARP) {
                    let m = edge_point[&edge];
                    out.creases.insert(key(edge[0], m), next);
                    out.creases.insert(key(edge[1], m), next);
                }
            }
        }
        for (v, sharp) in &self.corners {
            let next = if *sharp >= SHARP { *sharp } else { sharp - 1.0 };
            if next > 0.0 {
                out.corners.insert(*v, next);
            }
        }
        let w = self.width;
        for (f, face) in self.faces.iter().enumerate() {
            let n = face.len();
            let value = |k: usize| &self.values[f][(k % n) * w..(k % n + 1) * w];
            let mean = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect::<Vec<f32>>();
            let center: Vec<f32> = (0..w).map(|c| (0..n).map(|k| value(k)[c]).sum::<f32>() / n as f32).collect();
            for k in 0..n {
                let (before, here, after) = (face[(k + n - 1) % n], face[k], face[(k + 1) % n]);
                out.faces.push(vec![
                    here,
                    edge_point[&key(here, after)],
                    first_center + f as u32,
                    edge_point[&key(before, here)],
                ]);
                let mut corner = value(k).to_vec();
                corner.extend(mean(value(k), value(k + 1)));
                corner.extend(&center);
                corner.extend(mean(value(k + n - 1), value(k)));
                out.values.push(corner);
                out.origin.push(self.origin[f]);
            }
        }
        out
    }

    /// Neighbours along sharp edges.
    fn sharp_neighbours(&self, v: u32, around: &Around) -> Vec<(u32, f32)> {
        let all = around.neighbours[v as usize].iter();
        all.map(|n| (*n, self.sharpness(key(v, *n), around))).filter(|(_, s)| *s > 0.0).collect()
    }

    /// Where a vertex goes in a step.
    fn moved(&self, v: u32, centers: &[Vec3], around: &Around) -> Vec3 {
        let p = self.points[v as usize];
        let n = around.neighbours[v as usize].len() as f32;
        if n == 0.0 {
            return p;
        }
        let sharp = self.sharp_neighbours(v, around);
        let corner = self.corners.get(&v).copied().unwrap_or(0.0);
        if corner >= 1.0 || sharp.len() > 2 {
            return p;
        }
        let faces = &around.faces[v as usize];
        let f = faces.iter().map(|f| centers[*f as usize]).sum::<Vec3>() / faces.len() as f32;
        let e = around.neighbours[v as usize].iter().map(|q| self.points[*q as usize]).sum::<Vec3>() / n;
        let smooth = (f + e + p * (n - 2.0)) / n;
        let soft = smooth.lerp(p, corner.clamp(0.0, 1.0));
        match sharp[..] {
            [(a, s), (b, t)] => {
                let crease = 0.75 * p + 0.125 * (self.points[a as usize] + self.points[b as usize]);
                soft.lerp(crease, (0.5 * (s + t)).clamp(0.0, 1.0))
            }
            _ => soft,
        }
    }

    /// The limit surface as patches: of every quadrilateral after `levels` steps, or as soon as all faces are regular.
    pub fn patches(mut self, levels: u32) -> Vec<LimitPatch> {
        self = self.subdivide();
        for _ in 1..levels {
            if self.is_regular() {
                break;
            }
            self = self.subdivide();
        }
        let around = self.around();
        let limits: Vec<Vec3> = (0..self.points.len()).map(|v| self.limit(v as u32, &around)).collect();
        let mut out = Vec::new();
        for (f, face) in self.faces.iter().enumerate() {
            if self.origin[f] == u32::MAX {
                continue;
            }
            // Corner k of the face and the two inner sides of its edges: B(k) inner, E(k, next) and E(k, previous) on the edges.
            let inner = |f: usize, k: usize| self.inner(f, k, &around);
            let edge = |k: usize, towards_next: bool| -> Vec3 {
                let (a, b) = (face[k], if towards_next { face[(k + 1) % 4] } else { face[(k + 3) % 4] });
                let pair = key(a, b);
                if self.sharpness(pair, &around) >= 1.0 {
                    // A sharp edge is a curve of its own.
                    return (2.0 * self.points[a as usize] + self.points[b as usize]) / 3.0;
                }
                let own = inner(f, k);
                let other = around.edges[&pair].iter().find(|g| **g as usize != f).map(|g| {
                    let j = self.faces[*g as usize].iter().position(|v| *v == a).unwrap_or(0);
                    inner(*g as usize, j)
                });
                own.lerp(other.unwrap_or(own), 0.5)
            };
            // Rows along the edge from corner 0 to 1, columns from corner 0 to 3.
            let mut p = [Vec3::ZERO; 16];
            for (k, [corner, in_row, in_column, within]) in
                [[0, 1, 4, 5], [3, 2, 7, 6], [15, 14, 11, 10], [12, 13, 8, 9]].into_iter().enumerate()
            {
                p[corner] = limits[face[k] as usize];
                p[in_row] = edge(k, k % 2 == 0);
                p[in_column] = edge(k, k % 2 == 1);
                p[within] = inner(f, k);
            }
            let w = self.width;
            let value = |k: usize| &self.values[f][k * w..(k + 1) * w];
            let values = [value(0), value(1), value(3), value(2)].concat();
            out.push(LimitPatch {
                patch: Patch::smooth(p, [0.0, 1.0], [0.0, 1.0]),
                values,
                face: self.origin[f] as usize,
            });
        }
        out
    }

    /// Whether the patch of every face is the limit surface itself: four edges meet at each vertex within, three at the boundary but two
    /// at its corners, and no other edge is sharp. Values at corners that are not those of neighbours stay as they are all the same.
    fn is_regular(&self) -> bool {
        let around = self.around();
        let is_within = |v: u32| !self.on_boundary(v, &around);
        let is_smooth = |edge: &[u32; 2]| around.edges.get(edge).is_none_or(|faces| faces.len() != 2);
        let is_corner = |v: u32| self.corners.get(&v).is_some_and(|sharp| *sharp >= SHARP);
        self.creases.iter().all(|(edge, sharp)| is_smooth(edge) && *sharp >= SHARP)
            && self.corners.keys().all(|v| is_corner(*v))
            && around.edges.values().all(|faces| faces.len() <= 2)
            && (0..self.points.len() as u32).all(|v| match around.neighbours[v as usize].len() {
                0 => true,
                2 => !is_within(v) && is_corner(v) && around.faces[v as usize].len() == 1,
                3 => !is_within(v) && !is_corner(v) && around.faces[v as usize].len() == 2,
                4 => is_within(v) && !is_corner(v) && around.faces[v as usize].len() == 4,
                _ => false,
            })
    }

    /// The inner control point of a face next to its corner k.
    fn inner(&self, f: usize, k: usize, around: &Around) -> Vec3 {
        let face = &self.faces[f];
        let p = |i: usize| self.points[face[(k + i) % 4] as usize];
        let (v, next, across, last) = (p(0), p(1), p(2), p(3));
        let corner = face[k];
        let sharp_to = |q: u32| self.sharpness(key(corner, q), around) >= 1.0;
        let (n, l) = (sharp_to(face[(k + 1) % 4]), sharp_to(face[(k + 3) % 4]));
        let held = self.corners.contains_key(&corner) || self.sharp_neighbours(corner, around).len() > 2;
        // On a sharp edge or at a corner as where four edges meet, which keeps a regular boundary exact.
        let weight = if n || l || held { 4.0 } else { around.neighbours[corner as usize].len() as f32 };
        (v * weight + 2.0 * (next + last) + across) / (weight + 5.0)
    }

    /// The limit position of a vertex.
    fn limit(&self, v: u32, around: &Around) -> Vec3 {
        let p = self.points[v as usize];
        let sharp: Vec<u32> = around.neighbours[v as usize]
            .iter()
            .copied()
            .filter(|q| self.sharpness(key(v, *q), around) >= 1.0)
            .collect();
        if self.corners.get(&v).is_some_and(|s| *s >= 1.0) || sharp.len() > 2 {
            return p;
        }
        if let [a, b] = sharp[..] {
            return (4.0 * p + self.points[a as usize] + self.points[b as usize]) / 6.0;
        }
        let n = around.neighbours[v as usize].len() as f32;
        let mut sum = p * n * n;
        for q in &around.neighbours[v as usize] {
            sum += 4.0 * self.points[*q as usize];
        }
        for f in &around.faces[v as usize] {
            let face = &self.faces[*f as usize];
            let k = face.iter().position(|q| *q == v).unwrap_or(0);
            sum += self.points[face[(k + 2) % face.len()] as usize];
        }
        sum / (n * (n + 5.0))
    }
}
