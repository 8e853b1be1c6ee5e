// Rotation of any body over a step, from the columns `mass`, `orientation` and `displaced` of the kernel: the angular momentum in the world
// stays, and the body turns by what it makes of it in the middle of the step.
// Twin: cpu/integrate.rs
#import inertia

struct Spun {
    orientation: vec4<f32>,
    spin: vec3<f32>,
}

// The most iterations, and the change over the angular velocity at which the middle is found.
const MOST: u32 = 12u;
const FOUND: f32 = 2e-7;

// The frame of a body after it has turned by an angle, and its angular velocity there.
fn spin_after(angle: vec3<f32>, momentum: vec3<f32>, inverse: vec3<f32>) -> vec3<f32> {
    return turned_back(rotation_by(angle), momentum) * inverse;
}

// The greatest angle of a part of the step, rad, and the most parts.
const PART: f32 = 0.5;
const MOST_PARTS: f32 = 1e4;

// Orientation and angular velocity in its own frame after a step without torque. Fast rotation goes in parts.
fn tumbled(before: vec4<f32>, w: vec3<f32>, inverse: vec3<f32>, h: f32) -> Spun {
    let parts = clamp(ceil(length(w) * h / PART), 1.0, MOST_PARTS);
    var now = Spun(before, turned_back(before, w));
    for (var i = 0.0; i < parts; i += 1.0) {
        now = tumbled_by_a_part(now, inverse, h / parts);
    }
    return now;
}

fn tumbled_by_a_part(before: Spun, inverse: vec3<f32>, h: f32) -> Spun {
    let momentum = before.spin / inverse;
    var middle = before.spin;
    for (var i = 0u; i < MOST; i++) {
        let next = spin_after(middle * (0.5 * h), momentum, inverse);
        let change = next - middle;
        middle = next;
        if dot(change, change) <= FOUND * FOUND * dot(next, next) {
            break;
        }
    }
    let after = normalize(product_of(before.orientation, rotation_by(middle * h)));
    return Spun(after, spin_after(middle * h, momentum, inverse));
}

// Orientation and angular velocity in its own frame after a step `h` that begins with the angular velocity `w`, and the recovery of overlaps
// of a share `part`, which keeps the angular momentum.
fn spun(body: u32, w: vec3<f32>, h: f32, part: f32) -> Spun {
    let inverse = mass[body].yzw;
    var own: Spun;
    if inverse.x == inverse.y && inverse.y == inverse.z {
        own.orientation = normalize(product_of(rotation_by(w * h), orientation[body]));
        own.spin = turned_back(own.orientation, w);
    } else {
        own = tumbled(orientation[body], w, inverse, h);
    }
    if part > 0.0 {
        let momentum = turned(own.orientation, own.spin / inverse);
        let moved = displaced[DISPLACED * body + 2u].xyz * part;
        own.orientation = normalize(product_of(rotation_by(moved), own.orientation));
        own.spin = turned_back(own.orientation, momentum) * inverse;
    }
    return own;
}
