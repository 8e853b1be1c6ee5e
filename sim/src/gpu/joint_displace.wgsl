// Recovery of overlaps: the displacement of bodies with joints, over h, from that which the pushes give alone; and its energy, with that of
// the compliance.
// The columns of `joint_solve`, and
// inout displaced   [3 n_bodies]  m/s; what keeps the angular momentum; rad/s
// out   parts       [n_groups + 1]  J, twice: the last row
// in    mass        [n_bodies]    1/kg, and principal, 1/(kg m²)
// in    orientation [n_bodies]    of the principal frames
// in    params      [2]           the last row of parts; rounds
// Twin: cpu/solve/overlaps.rs, cpu/solve/joints.rs
#import sphere
#import solve_row
#import inertia
#import partial
#import displaced
#import joint_solve

@group(0) @binding(10) var<storage, read_write> displaced: array<vec4<f32>>;
@group(0) @binding(11) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(12) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(14) var<storage, read> params: array<u32>;

fn change_of(body: u32) -> Twist {
    return Twist(displaced[DISPLACED * body].xyz, displaced[DISPLACED * body + 2u].xyz);
}

fn change_body(body: u32, change: Twist) {
    displaced[DISPLACED * body] += vec4(change.v, 0.0);
    displaced[DISPLACED * body + 2u] += vec4(change.w, 0.0);
}

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    solve_joints(thread, params[1]);
    var energy = 0.0;
    for (var m = thread; m < joint_sizes[0]; m += 256u) {
        let b = member[m].body;
        let own = change_of(b);
        energy += dot(own.v, own.v) / mass[b].x + turning_energy(b, Body(own.v, mass[b].x, own.w, 0.0), own.w);
    }
    for (var r = thread; r < joint_sizes[1]; r += 256u) {
        energy += joint_row[r].softness * lambda[r].x * lambda[r].x;
    }
    let sum = group_total(thread, vec4(energy, 0.0, 0.0, 0.0));
    if thread == 0u {
        parts[params[0]] = sum;
    }
}
