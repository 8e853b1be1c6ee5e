// The sides that are to be put in the order of their bodies: those of all pairs where these were found in this step, else none, and the order stays.
// in   spheres  [1]  not zero if the pairs were found in this step
// in   n_pairs  [1]
// out  n_due    [1]  twice n_pairs or 0
// out  bodies   [1]  n_bodies or 0
// in   params   [1]  n_bodies
@group(0) @binding(0) var<storage, read> spheres: array<u32>;
@group(0) @binding(1) var<storage, read> n_pairs: array<u32>;
@group(0) @binding(2) var<storage, read_write> n_due: array<u32>;
@group(0) @binding(3) var<storage, read_write> bodies: array<u32>;
@group(0) @binding(4) var<storage, read> params: array<u32>;

@compute @workgroup_size(1)
fn main() {
    let is_due = spheres[0] != 0u;
    n_due[0] = select(0u, 2u * n_pairs[0], is_due);
    bodies[0] = select(0u, params[0], is_due);
}
