// Whether Gauss–Seidel takes over the step: its starting point is far from the solution, and there are more contacts than iterations.
// in   scalars  [1]  the residual of the starting point
// in   count    [1]  n_contacts
// out  verdict  [2]  whether it takes over; whether the step is undone, which is not known yet
// in   params   [2]  the most iterations, 0 for the default; as bits: what the root mean square of the residual terms may be (m/s)
// Twin: cpu/contact_solve.rs
#import scalars

@group(0) @binding(0) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(1) var<storage, read> count: array<u32>;
@group(0) @binding(2) var<storage, read_write> verdict: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> params: array<u32>;

@compute @workgroup_size(1)
fn main() {
    let n = blocks_of(count[0]);
    let lands = n > max_iterations(params[0], n) && scalars[0].residual * sqrt(f32(n)) > bitcast<f32>(params[1]);
    verdict[0] = vec2(select(0u, 1u, lands), 0u);
}
