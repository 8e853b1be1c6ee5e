// Scaling of the starting point: γᵀNγ and the energy of the bodies, summed over a workgroup.
// in   free     [n_bodies]  m/s, rad/s: velocities without contacts
// in   motion   [n_bodies]  m/s, rad/s: velocities with γ
// out  parts    [n_groups]  J, twice
// in   mass     [n_bodies]  1/kg, and principal, 1/(kg m²)
// in   orientation [n_bodies]  at the step's start
// Twin: cpu/solve/scale.rs
#import sphere
#import solve_row
#import inertia
#import partial

@group(0) @binding(0) var<storage, read> free: array<Body>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> orientation: array<vec4<f32>>;

fn energy(body: u32, own: Body, v: vec3<f32>, w: vec3<f32>) -> f32 {
    return dot(v, v) / own.inv_mass + turning_energy(body, own, w);
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    var own = vec4(0.0);
    if b < arrayLength(&free) && free[min(b, arrayLength(&free) - 1u)].inv_mass > 0.0 && !is_joined(free[min(b, arrayLength(&free) - 1u)]) {
        let now = motion[b];
        own = vec4(energy(b, now, now.v - free[b].v, now.w - free[b].w), energy(b, now, now.v, now.w), 0.0, 0.0);
    }
    let sum = group_total(thread, own);
    if thread == 0u && b / 256u < arrayLength(&parts) {
        parts[b / 256u] = sum;
    }
}
