// What the watch over the run needs of the bodies: energies, summed over a workgroup, and the greatest speed and kinetic energy.
// in    mass      [n_bodies]  1/kg, and principal, 1/(kg m²); zero for a body that does not move
// in    position  [n_bodies]  fine units
// in    velocity  [n_bodies]  m/s
// in    spin      [n_bodies]  rad/s
// in    level     [1]         fine units: the point whose height is zero
// inout lowest    [n_bodies]  J/kg: least potential so far
// out   parts     [n_groups]  J: kinetic, potential, over the lowest; and h |F·v| of weights
// inout peaks     [4]         as bits: greatest speed squared and kinetic energy; zeros in
// in    room      [2]         whether there was room for all pairs, second
// in    params    [5]         as bits: gravity (m/s²), h (s), fine unit (m)
// Twin: watch.rs, Survey
#import sphere
#import partial

@group(0) @binding(0) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> position: array<Fixed>;
@group(0) @binding(2) var<storage, read> velocity: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> spin: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> level: array<Fixed>;
@group(0) @binding(5) var<storage, read_write> lowest: array<f32>;
@group(0) @binding(6) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> peaks: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read> room: array<u32>;
@group(0) @binding(9) var<storage, read> params: array<u32>;

fn raise(peak: u32, value: u32) {
    if value > atomicLoad(&peaks[peak]) {
        atomicMax(&peaks[peak], value);
    }
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    var own = vec4(0.0);
    if b < arrayLength(&mass) && room[1] == 1u && mass[min(b, arrayLength(&mass) - 1u)].x > 0.0 {
        let m = 1.0 / mass[b].x;
        let v = velocity[b].xyz;
        let w = spin[b].xyz;
        let gravity = vec3(bitcast<f32>(params[0]), bitcast<f32>(params[1]), bitcast<f32>(params[2]));
        let at = fine_difference(position[b], level[0]);
        let height = -dot(gravity, real_fixed(at) * bitcast<f32>(params[4]));
        let kinetic = 0.5 * (m * dot(v, v) + dot(w, w / mass[b].yzw));
        lowest[b] = min(lowest[b], height);
        own = vec4(kinetic, m * height, m * (height - lowest[b]), m * abs(bitcast<f32>(params[3]) * dot(gravity, v)));
        // A state that is not finite, or as far as positions go, is told by an infinite speed.
        let p = position[b];
        let far = max(max(top(p.x), top(p.y)), top(p.z));
        let is_sound = is_finite(kinetic + height) && far < 0x20000000u;
        raise(0u, select(0x7f800000u, bitcast<u32>(dot(v, v)), is_sound));
        raise(1u, select(0x7f800000u, bitcast<u32>(kinetic), is_sound));
    }
    let sum = group_total(thread, own);
    if thread == 0u && b / 256u < arrayLength(&parts) {
        parts[b / 256u] = sum;
    }
}

// High word of the size of a number.
fn top(x: vec2<u32>) -> u32 {
    return select(x.y, ~x.y, x.y >= 0x80000000u);
}
