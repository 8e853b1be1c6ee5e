// The bodies of the greatest speed and of the greatest kinetic energy: those of the least ids.
// in    mass      [n_bodies]  1/kg, and principal, 1/(kg m²); zero for a body that does not move
// in    velocity  [n_bodies]  m/s
// in    spin      [n_bodies]  rad/s
// inout peaks     [4]         as bits: greatest speed squared and kinetic energy; all ones in, the bodies out
// Twin: watch.rs, Survey
#import sphere
#import partial

@group(0) @binding(0) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> velocity: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> spin: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> peaks: array<u32>;
@group(0) @binding(4) var<storage, read_write> body: array<atomic<u32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let b = row_of(group, thread);
    if b >= arrayLength(&mass) || mass[min(b, arrayLength(&mass) - 1u)].x == 0.0 {
        return;
    }
    let v = velocity[b].xyz;
    let w = spin[b].xyz;
    let kinetic = 0.5 * (dot(v, v) / mass[b].x + dot(w, w / mass[b].yzw));
    let is_broken = !is_finite(kinetic);
    let at = vec2(bitcast<f32>(peaks[0]), bitcast<f32>(peaks[1]));
    // Speeds may be rounded in another way than in the kernel before.
    if is_broken || dot(v, v) >= at.x * 0.999999 {
        atomicMin(&body[0], b);
    }
    if is_broken || kinetic >= at.y * 0.999999 {
        atomicMin(&body[1], b);
    }
}
