// Recovery of overlaps: the impulse that alone would recover what is left of each overlap, and its work, summed over a workgroup.
// in   contact  [n_contacts]
// in   motion   [n_bodies]    m/s, rad/s: velocities at the step's end
// out  push     [n_contacts]  N s, along the normal
// out  parts    [n_groups]    J
// in   count    [1]           n_contacts
// in   row      [n_contacts]
// in   params   [3]           as bits: 1 / h (1/s), overlap that is left as it is (m), maximum speed (m/s)
// Twin: cpu/solve/overlaps.rs
#import contact
#import solve_row
#import partial
#import push

@group(0) @binding(0) var<storage, read> contact: array<Contact>;
@group(0) @binding(1) var<storage, read> motion: array<Body>;
@group(0) @binding(2) var<storage, read_write> push: array<f32>;
@group(0) @binding(3) var<storage, read_write> parts: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> count: array<u32>;
@group(0) @binding(5) var<storage, read> rows: array<Row>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    var own = vec4(0.0);
    if k < count[0] {
        let c = contact[k];
        let least = bitcast<f32>(params[1]);
        var impulse = 0.0;
        if c.gap < -least {
            let a = motion[c.bodies.x];
            let b = motion[c.bodies.y];
            let pushed = pushed_by(k, c.normal, a, b);
            let left = clamp(-(c.gap + least) * bitcast<f32>(params[0]) - pushed.x, 0.0, bitcast<f32>(params[2]));
            impulse = left / pushed.y;
            own.x = impulse * left;
        }
        push[k] = impulse;
    }
    let sum = group_total(thread, own);
    if thread == 0u {
        parts[k / 256u] = sum;
    }
}
