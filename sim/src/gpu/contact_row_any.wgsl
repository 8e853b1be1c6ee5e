// The row of a contact with arms of any direction, from the columns of `solve_rows`.
// Twin: cpu/contact_solve.rs
#import turn

// What an arm adds to the trace of N_ii, and to its component along the normal.
fn turning(body: u32, arm: vec3<f32>, normal: vec3<f32>) -> vec2<f32> {
    let moments = mass[body].yzw;
    let local = turned_back(orientation[body], arm);
    let squares = vec3(local.yz, local.x) * vec3(local.yz, local.x) + vec3(local.z, local.xy) * vec3(local.z, local.xy);
    let torque = turned_back(orientation[body], cross(arm, normal));
    return vec2(dot(squares, moments), dot(torque * torque, moments));
}

// Velocity of a body at the end of an arm, at the step's start.
fn velocity_at(body: u32, arm: vec3<f32>) -> vec3<f32> {
    return velocity[body].xyz + cross(turned(orientation[body], spin[body].xyz), arm);
}

// Φ/h of a face: a share of an overlap beyond that of rest is recovered by the impulses.
fn lifting_rate(gap: f32) -> f32 {
    if gap > 0.0 {
        return max(gap - bitcast<f32>(params[3]), 0.0) * bitcast<f32>(params[1]);
    }
    let of_rest = bitcast<f32>(params[4]);
    let lifted = max(0.125 * min(gap + of_rest, 0.0), -10.0 * of_rest);
    return max(lifted * bitcast<f32>(params[1]), -bitcast<f32>(params[5]));
}

// Velocity of B relative to A at a contact, at the step's start.
fn velocity_between(k: u32, c: Contact) -> vec3<f32> {
    return velocity_at(c.bodies.y, arms[k].b) - velocity_at(c.bodies.x, arms[k].a);
}

fn contact_row(k: u32, c: Contact) -> Row {
    let inverse = mass[c.bodies.x].x + mass[c.bodies.y].x;
    let arm = arms[k];
    let sums = turning(c.bodies.x, arm.a, c.normal) + turning(c.bodies.y, arm.b, c.normal);
    let speed = dot(velocity_between(k, c), c.normal);
    // Bodies on joints are lifted as faces are.
    let is_lifted = arm.is_face == 1u || spin[c.bodies.x].w > 0.0 || spin[c.bodies.y].w > 0.0;
    let opening = select(max(c.gap, 0.0) * bitcast<f32>(params[1]), lifting_rate(c.gap), is_lifted);
    let eta = 3.0 / (3.0 * inverse + sums.x);
    return Row(c.normal, offset_of(c, opening, speed), arm.a, law[c.law].x, arm.b, eta, c.bodies, inverse + sums.y, adhesion_of(c));
}
