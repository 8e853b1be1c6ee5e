// Spectral projected gradients: take the step, or a share of it.
// inout x         [n_contacts]  N s, world
// in    next      [n_contacts]  N s, world: z
// in    scalars   [1]           β is one less than the share
// in    count     [1]           n_contacts
// inout roll_x    [n_contacts]  N m s, world: the same of rolling and spinning impulses
// in    roll_next [n_contacts]
// Twin: cpu/solve/barzilai_borwein.rs
#import sphere
#import scalars
#import rolls

@group(0) @binding(0) var<storage, read_write> x_column: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> next: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(3) var<storage, read> count: array<u32>;
@group(0) @binding(4) var<storage, read_write> roll_x: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> roll_next: array<vec4<f32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let beta = scalars[0].beta;
    x_column[k] = next[k] + (next[k] - x_column[k]) * beta;
    if ROLLS {
        roll_x[k] = roll_next[k] + (roll_next[k] - roll_x[k]) * beta;
    }
}
