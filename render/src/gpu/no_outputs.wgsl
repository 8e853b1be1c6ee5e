// Displays take nothing of layers but their colours.

fn lay_outputs(sum: Sum, k: u32, seen: Seen, opacity: vec3<f32>, takes: bool) {}

fn finish_outputs(sum: Sum, k: u32, sample: u32, closed: bool) {}
