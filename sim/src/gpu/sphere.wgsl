// The rows that the collision stages of spheres share.
#import fixed

// Radius, in steps of the fixed-point scale, the shape's id, and its body, material and collision group.
struct Sphere {
    radius: u32,
    shape: u32,
    body: u32,
    material: u32,
    group: u32,
}

// The corners of an axis-aligned box, m, world; the fourth numbers are not used.
struct Aabb {
    low: vec4<f32>,
    high: vec4<f32>,
}

// Activity of a body.
const MOVING: u32 = 0u;
const HELD: u32 = 1u;
const INACTIVE: u32 = 2u;

fn overlap(a: Aabb, b: Aabb) -> bool {
    return all(a.low.xyz <= b.high.xyz) && all(b.low.xyz <= a.high.xyz);
}

fn row_of(group: vec3<u32>, thread: u32) -> u32 {
    return (group.x + group.y * 65535u) * 256u + thread;
}
