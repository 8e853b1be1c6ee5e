// The states of the bodies that are probed.
// in   body         [n_probed]
// in   position     [n_bodies]  fine units
// in   orientation  [n_bodies]
// in   velocity     [n_bodies]  m/s, world
// in   spin         [n_bodies]  rad/s, in the bodies' frames
// out  states       [n_probed]
// Twin: probe.rs
#import body_state

@group(0) @binding(0) var<storage, read> body: array<u32>;
@group(0) @binding(1) var<storage, read> position: array<Fixed>;
@group(0) @binding(2) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> velocity: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> spin: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> states: array<BodyState>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let i = row_of(group, thread);
    if i < arrayLength(&body) {
        let b = body[i];
        states[i] = BodyState(position[b], b, 0u, orientation[b], velocity[b], spin[b]);
    }
}
