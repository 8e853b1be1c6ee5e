// The residual term of a contact, (γ − Π(γ − g (Nγ + r))) / g with g = 10⁻³ η, m/s, without the difference of nearly equal impulses that
// single precision would lose.
// Twin: cpu/solve/residual.rs
#import solve_row

fn residual_term(impulse: vec3<f32>, gradient: vec3<f32>, row: Row) -> vec3<f32> {
    let n = row.normal;
    let mu = row.friction;
    // From the tip of the cone, which adhesion puts below zero.
    let gamma = impulse + n * row.adhesion;
    let g = 1e-3 * row.eta;
    let y = gamma - gradient * g;
    let normal = dot(y, n);
    let tangent = y - n * normal;
    let t = length(tangent);
    if normal >= 0.0 && t <= mu * normal {
        return gradient;
    }
    if t * mu <= -normal {
        return gamma / g;
    }
    // Beyond the cone's surface by a distance along its unit normal there: that of γ, which is on the surface to rounding, and what the
    // gradient adds.
    let gamma_n = dot(gamma, n);
    let gamma_t = gamma - n * gamma_n;
    let s = length(gamma_t);
    let gradient_n = dot(gradient, n);
    let gradient_t = gradient - n * gradient_n;
    let widened = (g * dot(gradient_t, gradient_t) - 2.0 * dot(gamma_t, gradient_t)) / (t + s);
    let over = s - mu * gamma_n;
    let known = select(over / g, 0.0, abs(over) <= 5e-7 * (s + mu * abs(gamma_n)));
    let root = sqrt(1.0 + mu * mu);
    let outward = (tangent / t - n * mu) / root;
    return gradient + outward * ((widened + mu * gradient_n + known) / root);
}
