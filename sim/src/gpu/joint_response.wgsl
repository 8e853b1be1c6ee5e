// The velocities with impulses and joints, from those with the impulses alone.
// The columns of `joint_solve`, and
// inout motion  [n_bodies]  m/s, rad/s
// in    free    [n_bodies]  m/s, rad/s: velocities with joints, without impulses
// in    groups  [5]         workgroups of an iteration, the second over bodies
// in    params  [3]         whether there is nothing to do where these are none; rounds, 0 for those of a trial; whether `motion` has the
//                           multipliers that there are
// Twin: cpu/solve/joints.rs
#import sphere
#import solve_row
#import joint_solve

@group(0) @binding(10) var<storage, read_write> motion: array<Body>;
@group(0) @binding(11) var<storage, read> free: array<Body>;
@group(0) @binding(12) var<storage, read> groups: array<vec4<u32>>;
@group(0) @binding(13) var<storage, read> params: array<u32>;

fn change_of(body: u32) -> Twist {
    return Twist(motion[body].v - free[body].v, motion[body].w - free[body].w);
}

fn change_body(body: u32, change: Twist) {
    motion[body].v += change.v;
    motion[body].w += change.w;
}

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    if params[0] == 1u && groups[1].x == 0u {
        return;
    }
    let rounds = select(params[1], joint_sizes[4], params[1] == 0u);
    if params[2] == 1u {
        solve_more(thread, rounds);
    } else {
        solve_joints(thread, rounds);
    }
    for (var r = thread; r < joint_sizes[1]; r += 256u) {
        lambda[r] = vec4(lambda[r].xxx, 0.0);
    }
}
