// The row of a box of the tree of a surface's triangles: its corners, m, in the surface's frame; the number of a leaf's triangles in three
// bits and the first of them, 0 where boxes follow; the node beside this one.
struct Node {
    low: vec3<f32>,
    leaf: u32,
    high: vec3<f32>,
    next: u32,
}
