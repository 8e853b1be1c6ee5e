// APGD: the velocities that a trial z gives bodies with joints, from those that its impulses give alone; and the energy of their difference
// from those of y, with that of the compliance.
// The columns of `joint_solve`, and
// inout motion_next [n_bodies]  m/s, rad/s
// in    free        [n_bodies]  m/s, rad/s: velocities with joints, without impulses
// in    motion_y    [n_bodies]  m/s, rad/s
// in    scalars     [1]
// in    groups      [5]         workgroups of an iteration, the second over bodies
// out   parts       [n_groups + 1]  J, twice: the last row
// in    mass        [n_bodies]  1/kg, and principal, 1/(kg m²)
// in    orientation [n_bodies]  of the principal frames
// in    params      [2]         the last row of parts; whether the trials are those of spectral projected gradients, each of which is taken in part
// Twin: cpu/solve/apgd.rs, cpu/solve/joints.rs
#import sphere
#import solve_row
#import inertia
#import scalars
#import partial
#import joint_solve

@group(0) @binding(10) var<storage, read_write> motion_next: array<Body>;
@group(0) @binding(11) var<storage, read> free: array<Body>;
@group(0) @binding(12) var<storage, read> motion_y: array<Body>;
@group(0) @binding(13) var<storage, read> scalars: array<Scalars>;
@group(0) @binding(14) var<storage, read> groups: array<vec4<u32>>;
@group(0) @binding(15) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(16) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(17) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(18) var<storage, read> params: array<u32>;

fn change_of(body: u32) -> Twist {
    return Twist(motion_next[body].v - free[body].v, motion_next[body].w - free[body].w);
}

fn change_body(body: u32, change: Twist) {
    motion_next[body].v += change.v;
    motion_next[body].w += change.w;
}

// If the last trial was taken, it is x now, and y is extrapolated as the impulses are; a part of it that was taken is both.
fn extrapolate(thread: u32) {
    let is_spectral = params[1] == 1u;
    if scalars[0].accepted == 0u && !is_spectral {
        return;
    }
    for (var r = thread; r < joint_sizes[1]; r += 256u) {
        let own = lambda[r];
        let y = own.x + (own.x - own.y) * scalars[0].beta;
        lambda[r] = vec4(own.x, select(own.x, y, is_spectral), y, 0.0);
    }
}

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    if groups[1].x == 0u {
        return;
    }
    extrapolate(thread);
    solve_joints(thread, joint_sizes[4]);
    var energy = 0.0;
    for (var m = thread; m < joint_sizes[0]; m += 256u) {
        let b = member[m].body;
        let v = motion_next[b].v - motion_y[b].v;
        energy += dot(v, v) / mass[b].x + turning_energy(b, motion_next[b], motion_next[b].w - motion_y[b].w);
    }
    for (var r = thread; r < joint_sizes[1]; r += 256u) {
        let more = lambda[r].x - lambda[r].z;
        energy += joint_row[r].softness * more * more;
    }
    let sum = group_total(thread, vec4(energy, 0.0, 0.0, 0.0));
    if thread == 0u {
        parts[params[0]] = sum;
    }
}
