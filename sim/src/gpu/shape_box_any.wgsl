// The box of a shape of any kind, from the columns `position`, `orientation`, `spin`, `sphere` and `solid` of the kernel.
// Twin: cpu/bounds.rs
#import tight
#import solid
#import turn

fn shape_box(s: u32, margin: f32, unit: f32) -> Aabb {
    let own = solid[s];
    let body = sphere[s].body;
    let q = product_of(orientation[body], own.turn);
    let at = move_fixed(position[body], turned(orientation[body], own.offset) / (unit * FINE));
    return tight_box(at, reach_of(own, q), margin, unit);
}

// Half lengths of the box of a shape with a rotation.
fn reach_of(own: Solid, q: vec4<f32>) -> vec3<f32> {
    let half = own.half;
    let x = turned(q, vec3(1.0, 0.0, 0.0));
    let y = turned(q, vec3(0.0, 1.0, 0.0));
    let z = turned(q, vec3(0.0, 0.0, 1.0));
    switch own.kind {
        case BALL, SPHERE: { return half; }
        case ELLIPSOID: {
            let squares = x * x * (half.x * half.x) + y * y * (half.y * half.y) + z * z * (half.z * half.z);
            return sqrt(squares);
        }
        case CAPSULE: { return abs(z) * half.z + half.x; }
        case CYLINDER: { return abs(z) * half.z + sqrt(max(1.0 - z * z, vec3(0.0))) * half.x; }
        default: { return abs(x) * half.x + abs(y) * half.y + abs(z) * half.z; }
    }
}

// Maximum speed of a shape's surface by the angular velocity of its body, m/s; of a sphere about its body's centre of mass none.
fn surface_speed(s: u32) -> f32 {
    return length(spin[sphere[s].body].xyz) * solid[s].lever;
}
