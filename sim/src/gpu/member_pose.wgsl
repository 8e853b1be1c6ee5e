// Write the state of the bodies that joints, springs and loads act on, which the processor keeps.
// in   states       [n_members]
// out  position     [n_bodies]  fine units
// out  orientation  [n_bodies]
// out  velocity     [n_bodies]  m/s, world
// out  spin         [n_bodies]  rad/s, in the bodies' frames; the fourth number says whether a joint holds the body
// in   sizes        [5]         n_members
// Twin: cpu/mechanism.rs
#import body_state

@group(0) @binding(0) var<storage, read> states: array<BodyState>;
@group(0) @binding(1) var<storage, read_write> position: array<Fixed>;
@group(0) @binding(2) var<storage, read_write> orientation: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> velocity: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> spin: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> sizes: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let m = row_of(group, thread);
    if m >= sizes[0] {
        return;
    }
    let own = states[m];
    position[own.body] = own.position;
    orientation[own.body] = own.orientation;
    velocity[own.body] = own.velocity;
    spin[own.body] = vec4(own.spin.xyz, f32(own.is_held));
}
