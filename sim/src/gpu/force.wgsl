// Velocities at the step's end without contacts: gravity.
// in   mass         [n_bodies]  1/kg, and principal, 1/(kg m²); zero for a body that does not move
// in   orientation  [n_bodies]
// in   velocity     [n_bodies]  m/s
// in   spin         [n_bodies]  rad/s, in the bodies' frames
// out  free         [n_bodies]  m/s, rad/s, world
// in   params       [3]         as bits: gravity times the step size, m/s
// Twin: cpu/force.rs
#import sphere
#import solve_row
#import turn

@group(0) @binding(0) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> velocity: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> spin: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> free: array<Body>;
@group(0) @binding(5) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    if b >= arrayLength(&free) {
        return;
    }
    if mass[b].x == 0.0 {
        free[b] = Body(vec3(0.0), 0.0, vec3(0.0), 0.0);
        return;
    }
    let fall = vec3(bitcast<f32>(params[0]), bitcast<f32>(params[1]), bitcast<f32>(params[2]));
    free[b] = Body(velocity[b].xyz + fall, mass[b].x, turned(orientation[b], spin[b].xyz), mass[b].y);
}
