// Where no shape is a hull.
#import placed

fn hull_size(shape: Placed) -> vec2<u32> {
    return vec2(0u);
}

fn hull_vertex(shape: Placed, k: u32) -> vec3<f32> {
    return vec3(0.0);
}

fn hull_normal(shape: Placed, face: u32) -> vec3<f32> {
    return vec3(0.0);
}

fn hull_face(shape: Placed, face: u32) -> u32 {
    return 0u;
}

fn hull_corner(shape: Placed, face: u32, k: u32) -> u32 {
    return 0u;
}
