// The scalars of APGD, which stay on the device.

// Nesterov's θ and the factor β of the extrapolation, the step length t, whether the last trial was taken, trials since one was too long,
// and the number of trials.
struct Scalars {
    theta: f32,
    beta: f32,
    step: f32,
    accepted: u32,
    kept: u32,
    trials: u32,
}
