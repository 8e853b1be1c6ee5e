// The velocities of the bodies with the impulses γ of an iteration, v_free + M⁻¹ D γ.
// in   spin        [n_contacts]    what γ turns the bodies by, as in `spin.wgsl`
// in   gamma       [n_contacts]    N s, world
// in   free        [n_bodies]      m/s, rad/s
// in   side        [2 n_contacts]  sorted by body: twice the contact, and one more for B
// in   side_start  [n_bodies]      first side of each body, and the end
// out  motion      [n_bodies]      m/s, rad/s
// in   mass        [n_bodies]      1/kg, and principal, 1/(kg m²)
// in   orientation [n_bodies]      at the step's start
// in    roll     [n_contacts]  N m s, world: rolling and spinning impulses on B
// Twin: cpu/solve/bodies.rs
#import sphere
#import body_spin
#import body_response

@group(0) @binding(0) var<storage, read> spin: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> free: array<Body>;
@group(0) @binding(3) var<storage, read> side: array<u32>;
@group(0) @binding(4) var<storage, read> side_start: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> motion: array<BodyRow>;
@group(0) @binding(6) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> roll: array<vec4<f32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let body = row_of(group, thread);
    if body >= arrayLength(&free) {
        return;
    }
    motion[body] = body_row(response_of(body));
}
