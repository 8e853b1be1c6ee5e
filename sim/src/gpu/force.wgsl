// Velocities at the step's end without contacts: gravity, and what is slower than `rest_speed` loses up to half of its velocity.
// in   mass         [n_bodies]  1/kg, and principal, 1/(kg m²); zero for a body that does not move
// in   orientation  [n_bodies]
// in   velocity     [n_bodies]  m/s
// in   spin         [n_bodies]  rad/s, in the bodies' frames
// out  free         [n_bodies]  m/s, rad/s, world
// in   params       [4]         as bits: gravity times the step size, m/s; the speed of rest, m/s
// Twin: cpu/force.rs
#import sphere
#import solve_row
#import turn

@group(0) @binding(0) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> velocity: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> spin: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> free: array<BodyRow>;
@group(0) @binding(5) var<storage, read> params: array<u32>;

// The share of its velocity that a body keeps.
fn kept(least: f32, v: vec3<f32>, w: vec3<f32>, mass: vec4<f32>) -> f32 {
    if least == 0.0 {
        return 1.0;
    }
    let turning = select(w * w / mass.yzw, vec3(0.0), w == vec3(0.0));
    let speed = sqrt(dot(v, v) + mass.x * (turning.x + turning.y + turning.z));
    return min(speed / least, 1.0);
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    if b >= arrayLength(&free) {
        return;
    }
    if mass[b].x == 0.0 {
        free[b] = BodyRow(vec4(0.0), vec4(0.0));
        return;
    }
    let fall = vec3(bitcast<f32>(params[0]), bitcast<f32>(params[1]), bitcast<f32>(params[2]));
    let kept = kept(bitcast<f32>(params[3]), velocity[b].xyz, spin[b].xyz, mass[b]);
    let v = kept * velocity[b].xyz + fall;
    free[b] = BodyRow(vec4(v, mass[b].x), vec4(turned(orientation[b], kept * spin[b].xyz), mass[b].y));
}
