// Convex hulls, from the column `hull` of the kernel. The row that a shape names has the numbers of its vertices and faces; then come the
// vertices, m, in its frame, the faces (outward unit normal, and a word that `hull_corner` reads), and their corners, four to a row.
// Twin: geometry.rs, Hull
#import placed

// Number of vertices and of faces.
fn hull_size(shape: Placed) -> vec2<u32> {
    return hull[shape.part].xy;
}

fn hull_vertex(shape: Placed, k: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(hull[shape.part + 1u + k].xyz);
}

// The normal of a face.
fn hull_normal(shape: Placed, face: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(hull[shape.part + 1u + hull_size(shape).x + face].xyz);
}

// The word of a face: the number of its corners in 5 bits, and the place of the first in words behind the shape's row.
fn hull_face(shape: Placed, face: u32) -> u32 {
    return hull[shape.part + 1u + hull_size(shape).x + face].w;
}

// The vertex at a corner of a face, by the face's word.
fn hull_corner(shape: Placed, face: u32, k: u32) -> u32 {
    let word = (face >> 5u) + k;
    return hull[shape.part + word / 4u][word % 4u];
}
