// Scaling of the starting point: γᵀNγ and the energy of the bodies with joints.
// The columns of `joint_solve`, and
// in   motion      [n_bodies]  m/s, rad/s: velocities with γ
// in   free        [n_bodies]  m/s, rad/s: velocities with joints, without impulses
// out  parts       [n_groups + 1]  J, twice: the last row
// in   mass        [n_bodies]  1/kg, and principal, 1/(kg m²)
// in   orientation [n_bodies]  of the principal frames
// in   params      [1]         the last row of parts
// Twin: cpu/solve/scale.rs
#import sphere
#import solve_row
#import inertia
#import partial
#import joint_solve

@group(0) @binding(10) var<storage, read> motion: array<Body>;
@group(0) @binding(11) var<storage, read> free: array<Body>;
@group(0) @binding(12) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(14) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(15) var<storage, read> params: array<u32>;

fn change_of(body: u32) -> Twist {
    return Twist(motion[body].v - free[body].v, motion[body].w - free[body].w);
}

fn change_body(body: u32, change: Twist) {}

fn energy_of(b: u32, change: Twist) -> f32 {
    return dot(change.v, change.v) / mass[b].x + turning_energy(b, motion[b], change.w);
}

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    var own = vec4(0.0);
    for (var m = thread; m < joint_sizes[0]; m += 256u) {
        let b = member[m].body;
        own += vec4(energy_of(b, change_of(b)), energy_of(b, Twist(motion[b].v, motion[b].w)), 0.0, 0.0);
    }
    for (var r = thread; r < joint_sizes[1]; r += 256u) {
        own.x += joint_row[r].softness * lambda[r].x * lambda[r].x;
    }
    let sum = group_total(thread, own);
    if thread == 0u {
        parts[params[0]] = sum;
    }
}
