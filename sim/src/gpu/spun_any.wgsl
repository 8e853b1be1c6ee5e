// Rotation of any body over a step, from the columns `mass`, `orientation` and `displaced` of the kernel: the angular momentum in the world
// stays, and the energy is split about the principal axes.
// Twin: cpu/integrate.rs
#import inertia

struct Spun {
    orientation: vec4<f32>,
    spin: vec3<f32>,
}

// The greatest angle of the swing between two axes in a part of the step, rad, and the most parts.
const PART: f32 = 0.25;
const MOST_PARTS: f32 = 1e4;

// The body's rotation about an axis of its own, and its angular momentum in its frame.
struct Turn {
    turned: vec4<f32>,
    local: vec3<f32>,
}

fn about(now: Turn, axis: vec3<f32>, rate: f32, time: f32) -> Turn {
    if rate == 0.0 {
        return now;
    }
    let angle = rotation_by(axis * (rate * dot(now.local, axis) * time));
    return Turn(product_of(now.turned, angle), turned_back(angle, now.local));
}

// Quotients to rounding: the devices' are off by some roundings to one side, which depends on the divisor, and the inverse moments of a body are
// the same in every step.
fn quotient(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    let q = a / b;
    return q + fma(-q, b, a) / b;
}

// Orientation and angular velocity in its own frame after a step without torque: about the angular momentum by the middle moment, and in
// turns about the two other axes by what their moments differ.
fn tumbled(before: vec4<f32>, w: vec3<f32>, inverse: vec3<f32>, h: f32) -> Spun {
    let least = min(inverse.x, min(inverse.y, inverse.z));
    let most = max(inverse.x, max(inverse.y, inverse.z));
    // The first of the least, the last of the most, and what is left.
    let slow = select(select(vec3(0.0, 0.0, 1.0), vec3(0.0, 1.0, 0.0), inverse.y == least), vec3(1.0, 0.0, 0.0), inverse.x == least);
    let fast = select(select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), inverse.y == most), vec3(0.0, 0.0, 1.0), inverse.z == most);
    let middle = dot(inverse, 1.0 - slow - fast);
    let rates = vec2(least - middle, most - middle);
    let start = quotient(turned_back(before, w), inverse);
    let momentum = turned(before, start);
    let swing = sqrt(-rates.x * rates.y) * length(momentum) * h;
    let parts = clamp(ceil(swing / PART), 1.0, MOST_PARTS);
    var now = Turn(vec4(0.0, 0.0, 0.0, 1.0), start);
    let time = h / parts;
    for (var i = 0.0; i < parts; i += 1.0) {
        now = about(now, slow, rates.x, 0.5 * time);
        now = about(now, fast, rates.y, time);
        now = about(now, slow, rates.x, 0.5 * time);
    }
    let after = unit(product_of(rotation_by(momentum * (middle * h)), product_of(before, now.turned)));
    return Spun(after, turned_back(after, momentum) * inverse);
}

// Orientation and angular velocity in its own frame after a step `h` that begins with the angular velocity `w`, and the recovery of overlaps
// of a share `part`, which keeps the angular momentum.
fn spun(body: u32, w: vec3<f32>, h: f32, part: f32) -> Spun {
    let inverse = mass[body].yzw;
    var own: Spun;
    if inverse.x == inverse.y && inverse.y == inverse.z {
        own.orientation = unit(product_of(rotation_by(w * h), orientation[body]));
        own.spin = turned_back(own.orientation, w);
    } else {
        own = tumbled(orientation[body], w, inverse, h);
    }
    if part > 0.0 {
        let momentum = turned(own.orientation, quotient(own.spin, inverse));
        let moved = displaced[DISPLACED * body + 2u].xyz * part;
        own.orientation = unit(product_of(rotation_by(moved), own.orientation));
        own.spin = turned_back(own.orientation, momentum) * inverse;
    }
    return own;
}
