// What is left of the residual terms of some pairs squared, m²/s², by those that decide whether slow bodies are swept on: the terms, negative where
// some of their bodies are fast, or where the residual of their contacts, four a pair, is no more than that of the settings (squared).
fn settled(terms: f32, n_fast: f32, n_pairs: f32, residual2: f32) -> f32 {
    let is_settled = n_fast > 0.0 || terms <= 4.0 * n_pairs * residual2;
    return select(terms, -terms, is_settled);
}
