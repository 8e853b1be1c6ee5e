// The row of a contact between spheres.
#import sphere

// A contact: bodies A and B, the lower id first; shapes, the lower id first; unit normal out of A; gap, m; lengths of the arms on A and B
// along the normal, m; contact law.
struct Contact {
    bodies: vec2<u32>,
    shapes: vec2<u32>,
    normal: vec3<f32>,
    gap: f32,
    reach: vec2<f32>,
    law: u32,
    pad: u32,
}
