// The feature of a shape that faces a direction, with the radius around its core, in one of the places of corners.
// Twin: cpu/collide/manifold.rs
#import clip
#import support

// Number of corners of the polygon in place of the flat end of a cylinder or a cone.
const RIM: u32 = 8u;

fn feature_of(shape: Placed, direction: vec3<f32>, place: u32) -> Feature {
    if shape.kind == BOX {
        return box_face(shape, direction, place);
    }
    if shape.kind == HULL {
        return hull_face_facing(shape, direction * shape.frame, place);
    }
    let d = normalize(direction * shape.frame);
    let half = shape.half;
    let size = length(d.xy);
    let across = select(vec2(0.0), d.xy / size, size > 0.0);
    var f = no_corners(place);
    if (shape.kind == CYLINDER && abs(d.z) > 0.7) || (shape.kind == CONE && d.z < -0.7) {
        let side = select(0u, RIM, shape.kind == CYLINDER && d.z < 0.0);
        for (var k = 0u; k < RIM; k++) {
            let angle = f32(k) * (6.2831853 / f32(RIM));
            let z = select(half.z, -half.z, d.z < 0.0);
            push_local(&f, shape, vec3(half.x * cos(angle), half.x * sin(angle), z), side + k + 1u);
        }
    } else if shape.kind == CYLINDER {
        push_local(&f, shape, vec3(across * half.x, half.z), 41u);
        push_local(&f, shape, vec3(across * half.x, -half.z), 42u);
    } else if shape.kind == CONE && dot(normalize(vec3(across * 2.0 * half.z, half.x)), d) > 0.95 {
        push_local(&f, shape, vec3(0.0, 0.0, half.z), 41u);
        push_local(&f, shape, vec3(across * half.x, -half.z), 42u);
    } else if shape.kind == CAPSULE && abs(d.z) < 0.7 {
        push_local(&f, shape, vec3(0.0, 0.0, half.z) + d * half.x, 41u);
        push_local(&f, shape, vec3(0.0, 0.0, -half.z) + d * half.x, 42u);
    } else {
        push_local(&f, shape, support_local(shape, d) + d * radius_of(shape), 43u);
    }
    return f;
}

// The face of a hull whose normal is closest to a direction in its frame.
fn hull_face_facing(shape: Placed, d: vec3<f32>, place: u32) -> Feature {
    var face = 0u;
    var far = -3e38;
    for (var k = 0u; k < hull_size(shape).y; k++) {
        let here = dot(hull_normal(shape, k), d);
        if here > far {
            far = here;
            face = hull_face(shape, k);
        }
    }
    var f = no_corners(place);
    for (var k = 0u; k < (face & 31u); k++) {
        let v = hull_corner(shape, face, k);
        push_local(&f, shape, hull_vertex(shape, v), v + 1u);
    }
    return f;
}

fn push_local(f: ptr<function, Feature>, shape: Placed, p: vec3<f32>, id: u32) {
    push(f, shape.position + shape.frame * p, id);
}
