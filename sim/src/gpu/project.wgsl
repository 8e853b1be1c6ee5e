// Friction cones, and the velocity of B relative to A at a contact.
#import solve_row

// Project onto the cone |γ_t| ≤ μ γ_n about the axis n.
fn project(y: vec3<f32>, n: vec3<f32>, mu: f32) -> vec3<f32> {
    let normal = dot(y, n);
    let tangent = y - n * normal;
    let t = length(tangent);
    if normal >= 0.0 && t <= mu * normal {
        return y;
    }
    if t * mu <= -normal {
        return vec3(0.0);
    }
    let kept = (t * mu + normal) / (mu * mu + 1.0);
    // Without a tangent the normal is positive, and y is in the cone.
    return n * kept + tangent * (mu * kept / t);
}

// Project onto the cone of a contact, whose tip adhesion puts below zero.
fn project_row(y: vec3<f32>, row: Row) -> vec3<f32> {
    let tip = row.normal * row.adhesion;
    return project(y + tip, row.normal, row.friction) - tip;
}

// Four roundings.
const ROUNDINGS: f32 = 4.7683716e-7;

// The square of what rounding leaves of the velocity of B relative to A at a contact, m²/s².
fn rounding_of(row: Row, a: Body, b: Body) -> f32 {
    let rolling = rolling_of(row, a.w, b.w);
    return ROUNDINGS * ROUNDINGS * (dot(a.v, a.v) + dot(b.v, b.v) + dot(rolling, rolling));
}

// Block of Nγ + r, from the velocities that γ gives the bodies.
fn gradient_of(row: Row, a: Body, b: Body) -> vec3<f32> {
    return b.v - a.v + rolling_of(row, a.w, b.w) + row.normal * row.offset;
}
