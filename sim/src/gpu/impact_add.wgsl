// Add what impacts one after another change of the velocities to those without contacts.
// in    change  [n_bodies]  m/s, rad/s
// inout free    [n_bodies]  m/s, rad/s
// Twin: cpu/force.rs
#import sphere
#import solve_row

@group(0) @binding(0) var<storage, read> change: array<Body>;
@group(0) @binding(1) var<storage, read_write> free: array<Body>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    if b < arrayLength(&free) {
        free[b].v += change[b].v;
        free[b].w += change[b].w;
    }
}
