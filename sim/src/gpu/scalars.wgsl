// The scalars of a solve, which stay on the device.
#import rolls

// Of APGD: Nesterov's θ and the factor β of the extrapolation, the step length t, whether the last trial was taken, trials since one was
// too long. Iterations so far and the most; whether the solve goes on. The least residual so far, whether it is that of the last iterate; which
// half of the columns of iterates has x, whose other half has the iterate before it; the curvature below which there is rounding alone. The factor of the starting point. Of Jacobi: ω, and the
// square of the last step; of Barzilai–Borwein ω is the step length. The residual, m/s.
struct Scalars {
    theta: f32,
    beta: f32,
    step: f32,
    accepted: u32,
    kept: u32,
    trials: u32,
    limit: u32,
    goes_on: u32,
    best: f32,
    is_current: u32,
    half: u32,
    rounding: f32,
    factor: f32,
    omega: f32,
    last_step2: f32,
    residual: f32,
}

// Maximum number of iterations of a problem with `n` blocks: that which is given, or its default where 0 is, of which single precision makes use of
// no more than 2,000.
// Twin: settings.rs, contact_solve.rs
fn max_iterations(given: u32, n: u32) -> u32 {
    return select(given, clamp(50000u / max(n, 1u), 50u, 2000u), given == 0u);
}

// Number of blocks of three multipliers of so many contacts.
fn blocks_of(n_contacts: u32) -> u32 {
    return select(n_contacts, 2u * n_contacts, ROLLS);
}
