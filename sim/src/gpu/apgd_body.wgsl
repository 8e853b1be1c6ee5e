// APGD: the velocities that a trial z gives the bodies, and the energy of their difference from those of y, summed over a workgroup.
// in   spin        [n_contacts]    what z turns the bodies by, as in `spin.wgsl`
// in   gamma       [n_contacts]    N s, world: z
// in   free        [n_bodies]      m/s, rad/s
// in   side        [2 n_contacts]  sorted by body: twice the contact, and one more for B
// in   side_start  [n_bodies]      first side of each body, and the end
// in   motion_y    [n_bodies]      m/s, rad/s
// out  motion_next [n_bodies]      m/s, rad/s
// out  parts       [n_groups]      J, twice
// in   mass        [n_bodies]      1/kg, and principal, 1/(kg m²)
// in   orientation [n_bodies]      at the step's start
// in    roll     [n_contacts]  N m s, world: rolling and spinning impulses on B
// Twin: cpu/solve/apgd.rs
#import sphere
#import body_spin
#import body_response
#import partial

@group(0) @binding(0) var<storage, read> spin: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> gamma: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> free: array<Body>;
@group(0) @binding(3) var<storage, read> side: array<u32>;
@group(0) @binding(4) var<storage, read> side_start: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> motion_y: array<Body>;
@group(0) @binding(6) var<storage, read_write> motion_next: array<BodyRow>;
@group(0) @binding(7) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> mass: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read> roll: array<vec4<f32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let body = row_of(group, thread);
    var energy = vec4(0.0);
    if body < arrayLength(&free) {
        let own = response_of(body);
        motion_next[body] = body_row(own);
        if own.inv_mass > 0.0 && !is_joined(own) {
            let v = own.v - motion_y[body].v;
            let w = own.w - motion_y[body].w;
            energy.x = dot(v, v) / own.inv_mass + turning_energy(body, own, w);
        }
    }
    let sum = group_total(thread, energy);
    if thread == 0u && body / 256u < arrayLength(&parts) {
        parts[body / 256u] = sum;
    }
}
