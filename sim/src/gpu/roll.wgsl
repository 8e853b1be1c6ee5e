// Rolling and spinning friction: a second block of each contact, an angular impulse on B. Its cone's width is that of the normal impulse and the adhesion:
// a disc across the normal, and a range along it. Its row has the two coefficients, m, the step η = 3 / trace of the sum of the inverse
// inertia tensors, and the square of the radius of gyration √(η_roll / η), m².
// Twin: cpu/solve/bodies.rs
#import rolls
#import solve_row

// Project onto the cone of a contact with the impulse `gamma`.
fn project_roll(y: vec3<f32>, contact_row: Row, gamma: vec3<f32>, row: vec4<f32>) -> vec3<f32> {
    let n = contact_row.normal;
    let normal = max(dot(gamma, n) + contact_row.adhesion, 0.0);
    let spin = dot(y, n);
    let roll = y - n * spin;
    let size = length(roll);
    let most = row.x * normal;
    return n * clamp(spin, -row.y * normal, row.y * normal) + roll * select(1.0, most / size, size > most);
}

// The residual term, (γ − Π(γ − g G)) / g with g = 10⁻³ η, rad/s, without the difference of nearly equal impulses: an impulse that is at
// its bound to rounding is at its bound.
fn roll_term(own: vec3<f32>, gradient: vec3<f32>, contact_row: Row, gamma: vec3<f32>, row: vec4<f32>) -> vec3<f32> {
    let g = 1e-3 * row.z;
    let n = contact_row.normal;
    let normal = max(dot(gamma, n) + contact_row.adhesion, 0.0);
    let y = own - gradient * g;
    let spin = dot(y, n);
    let along = dot(own, n);
    var term = gradient;
    let widest = row.y * normal;
    if abs(spin) > widest {
        let at = select(-widest, widest, spin > 0.0);
        term -= n * dot(gradient, n);
        term += n * select((along - at) / g, 0.0, abs(along - at) <= 5e-7 * widest);
    }
    let across = y - n * spin;
    let size = length(across);
    let most = row.x * normal;
    if size > most {
        let before = own - n * along;
        let length_before = length(before);
        let change = gradient - n * dot(gradient, n);
        let grown = (g * dot(change, change) - 2.0 * dot(before, change)) / (size + length_before);
        let over = length_before - most;
        term += across / size * (grown + select(over / g, 0.0, abs(over) <= 5e-7 * most));
    }
    return term;
}

// The gradient of the block.
fn roll_gradient(a: Body, b: Body) -> vec3<f32> {
    return b.w - a.w;
}
