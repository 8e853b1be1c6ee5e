// The slip that is fed back to the rate of a gap by Coulomb's law itself.
// Twin: cpu/solve/slip.rs

// Share of the cone's width from which on a contact slides.
const SLIDES: f32 = 0.99;

// The slip μ |v_t| without that of contacts which hardly slip, and of those which stick: it is that of the solver's errors. All is fed from
// twice the least slip on; `least_speed` is that slip over μ.
fn slip_of(v: vec3<f32>, gamma: vec3<f32>, normal: vec3<f32>, mu: f32, least_speed: f32) -> f32 {
    let slip = mu * length(v - normal * dot(v, normal));
    let least = least_speed * mu;
    let along = dot(gamma, normal);
    if least > 0.0 && length(gamma - normal * along) < SLIDES * mu * along {
        return 0.0;
    }
    return select(slip, slip * max((slip - least) / least, 0.0), slip < 2.0 * least);
}
