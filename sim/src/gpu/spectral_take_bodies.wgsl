// Spectral projected gradients: the velocities with the step, or with the share of it that is taken.
// in    motion_next [n_bodies]  m/s, rad/s
// inout motion      [n_bodies]  m/s, rad/s
// in    scalars     [1]         β is one less than the share
// Twin: cpu/solve/barzilai_borwein.rs
#import sphere
#import solve_row
#import scalars

@group(0) @binding(0) var<storage, read> motion_next: array<Body>;
@group(0) @binding(1) var<storage, read_write> motion: array<BodyRow>;
@group(0) @binding(2) var<storage, read> scalars: array<Scalars>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let body = row_of(group, thread);
    if body >= arrayLength(&motion) {
        return;
    }
    let x = body_of(motion[body]);
    let z = motion_next[body];
    let beta = scalars[0].beta;
    let v = z.v + (z.v - x.v) * beta;
    let w = z.w + (z.w - x.w) * beta;
    motion[body] = BodyRow(vec4(v, z.inv_mass), vec4(w, z.inv_inertia));
}
