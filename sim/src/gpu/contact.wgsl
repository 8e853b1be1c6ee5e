// The rows of a contact.
#import sphere

// A contact: bodies A and B, the lower id first; shapes, the lower id first; unit normal out of A; gap, m; lengths of the arms on A and B
// along the normal, m, where they lie along it; contact law; feature id.
struct Contact {
    bodies: vec2<u32>,
    shapes: vec2<u32>,
    normal: vec3<f32>,
    gap: f32,
    reach: vec2<f32>,
    law: u32,
    feature: u32,
}

// The arms of a contact on A and B where they are of any direction, m, and whether it is one of a face that moves.
struct Arms {
    a: vec3<f32>,
    is_face: u32,
    b: vec3<f32>,
    pad: u32,
}
