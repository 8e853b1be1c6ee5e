// APGD: keep the velocities of the best iterate.
// in   motion  [n_bodies]  m/s, rad/s
// out  best    [n_bodies]  m/s, rad/s
#import sphere
#import solve_row

@group(0) @binding(0) var<storage, read> motion: array<BodyRow>;
@group(0) @binding(1) var<storage, read_write> best: array<BodyRow>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    if b < arrayLength(&motion) {
        best[b] = motion[b];
    }
}
