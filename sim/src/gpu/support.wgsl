// Support functions of shapes: a core, with a radius around it.
// Twin: cpu/collide/convex.rs
#import placed

// The farthest point of the core of a shape in a direction, in its frame.
fn support_local(shape: Placed, d: vec3<f32>) -> vec3<f32> {
    let half = shape.half;
    let across = length(d.xy);
    let rim = select(vec2(half.x, 0.0), d.xy * (half.x / across), across > 0.0);
    let end = select(half.z, -half.z, d.z < 0.0);
    switch shape.kind {
        case BOX: { return select(half, -half, d < vec3(0.0)); }
        case CAPSULE: { return vec3(0.0, 0.0, end); }
        case CYLINDER: { return vec3(rim, end); }
        case CONE: {
            let base = vec3(rim, -half.z);
            return select(base, vec3(0.0, 0.0, half.z), d.z * half.z > dot(base, d));
        }
        case ELLIPSOID: {
            let scaled = half * d;
            let size = length(scaled);
            return select(vec3(0.0, 0.0, half.z), half * scaled / size, size > 0.0);
        }
        default: { return vec3(0.0); }
    }
}

// The same in the world.
fn support(shape: Placed, direction: vec3<f32>) -> vec3<f32> {
    return shape.position + shape.frame * support_local(shape, direction * shape.frame);
}

// Radius around the core.
fn radius_of(shape: Placed) -> f32 {
    return select(0.0, shape.half.x, shape.kind == BALL || shape.kind == SPHERE || shape.kind == CAPSULE);
}
