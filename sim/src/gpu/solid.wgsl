// The row of a shape of any kind, in the frame of its body.
#import fixture

// Half lengths as the kind has them, m; kind; position in the body's frame, m; distance of the farthest point from the centre of mass, m,
// 0 for a sphere about it; orientation in the body's frame; the first row of a hull.
struct Solid {
    half: vec3<f32>,
    kind: u32,
    offset: vec3<f32>,
    lever: f32,
    turn: vec4<f32>,
    part: u32,
    pad: u32,
    more: vec2<u32>,
}

// Kinds beside those of fixtures: a sphere about its body's centre of mass, one that is not, and an ellipsoid.
const BALL: u32 = 5u;
const SPHERE: u32 = 6u;
const ELLIPSOID: u32 = 7u;
