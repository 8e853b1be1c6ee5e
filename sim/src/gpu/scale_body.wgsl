// Scaling of the starting point: γᵀNγ and the energy of the bodies, summed over a workgroup.
// in   free     [n_bodies]  m/s, rad/s: velocities without contacts
// in   motion   [n_bodies]  m/s, rad/s: velocities with γ
// out  parts    [n_groups]  J, twice
// Twin: cpu/solve/scale.rs
#import sphere
#import solve_row
#import partial

@group(0) @binding(0) var<storage, read> free: array<Body>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read_write> parts: array<vec4<f32>>;

fn energy(b: Body, v: vec3<f32>, w: vec3<f32>) -> f32 {
    return dot(v, v) / b.inv_mass + dot(w, w) / b.inv_inertia;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    var own = vec4(0.0);
    if b < arrayLength(&free) && free[min(b, arrayLength(&free) - 1u)].inv_mass > 0.0 {
        let now = motion[b];
        own = vec4(energy(now, now.v - free[b].v, now.w - free[b].w), energy(now, now.v, now.w), 0.0, 0.0);
    }
    let sum = group_total(thread, own);
    if thread == 0u && b / 256u < arrayLength(&parts) {
        parts[b / 256u] = sum;
    }
}
