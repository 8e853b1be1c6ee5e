// Support functions of shapes: a core, with a radius around it.
// Twin: cpu/collide/convex.rs
#import placed
#import hulls

// Whether cylinders are capsules of the same axes for now.
var<private> as_capsules: bool;

// The farthest point of the core of a shape in a direction, in its frame.
fn support_local(shape: Placed, d: vec3<f32>) -> vec3<f32> {
    let half = shape.half;
    let across = length(d.xy);
    let rim = select(vec2(half.x, 0.0), d.xy * (half.x / across), across > 0.0);
    let end = select(half.z, -half.z, d.z < 0.0);
    switch shape.kind {
        case BOX: { return select(half, -half, d < vec3(0.0)); }
        case CAPSULE: { return vec3(0.0, 0.0, end); }
        case CYLINDER: { return vec3(select(rim, vec2(0.0), as_capsules), end); }
        case CONE: {
            let base = vec3(rim, -half.z);
            return select(base, vec3(0.0, 0.0, half.z), d.z * half.z > dot(base, d));
        }
        case ELLIPSOID: {
            let scaled = half * d;
            let size = length(scaled);
            return select(vec3(0.0, 0.0, half.z), half * scaled / size, size > 0.0);
        }
        case TRIANGLE: { return corner_farthest(d); }
        case HULL: { return hull_farthest(shape, d); }
        default: { return vec3(0.0); }
    }
}

// The corners of the pair's triangle, in its frame, m.
var<private> local_corner: array<vec3<f32>, 3>;

fn corner_farthest(d: vec3<f32>) -> vec3<f32> {
    let at = vec3(dot(local_corner[0], d), dot(local_corner[1], d), dot(local_corner[2], d));
    if at.x >= at.y && at.x >= at.z {
        return local_corner[0];
    }
    return select(local_corner[2], local_corner[1], at.y >= at.z);
}

// The vertex of a hull that is farthest in a direction, in its frame.
fn hull_farthest(shape: Placed, d: vec3<f32>) -> vec3<f32> {
    var best = vec3(0.0);
    var far = -3e38;
    for (var k = 0u; k < hull_size(shape).x; k++) {
        let p = hull_vertex(shape, k);
        let here = dot(p, d);
        if here > far {
            far = here;
            best = p;
        }
    }
    return best;
}

// The same in the world.
fn support(shape: Placed, direction: vec3<f32>) -> vec3<f32> {
    return shape.position + shape.frame * support_local(shape, direction * shape.frame);
}

// Radius around the core.
fn radius_of(shape: Placed) -> f32 {
    let is_round = shape.kind == BALL || shape.kind == SPHERE || shape.kind == CAPSULE;
    return select(0.0, shape.half.x, is_round || (shape.kind == CYLINDER && as_capsules));
}
