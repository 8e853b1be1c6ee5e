// What shaders' kernels read of the scene: rows of whole numbers, or of the bits of numbers.
// in   world  [n]  its first rows say where the others begin: 0 nodes and occluders of rays, and count of nodes; 1 nodes, spheres and half axes
//                  of what closes the sky, and count of nodes; 2 nodes and facets of the same, and count of nodes; 3 maps

@group(0) @binding(7) var<storage, read> world: array<vec4<u32>>;

fn world_row(at: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(world[at]);
}

// The primitive that is shaded, which a grid's own numbers begin with: its number in two halves; then how near the start of a ray a
// surface does not count, others and its own, its normal if it is flat, else 0, and the number of the whole that it is of, in two halves.
fn own_primitive() -> u32 {
    return u32(values[work.own]) + (u32(values[work.own + 1u]) << 16u);
}

fn own_whole() -> u32 {
    return u32(values[work.own + 7u]) + (u32(values[work.own + 8u]) << 16u);
}
