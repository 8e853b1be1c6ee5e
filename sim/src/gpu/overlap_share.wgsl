// Recovery of overlaps: the share of the displacement that is made, half the step to the minimum along it.
// in   of_contacts [n_groups]  J: work of the pushes
// in   of_bodies   [n_groups]  J, twice: energy of the displacement
// out  share       [1]
// in   count       [1]         n_contacts
// in   params      [1]         n_bodies
// Twin: cpu/solve/overlaps.rs
#import partial

@group(0) @binding(0) var<storage, read> of_contacts: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> of_bodies: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> share: array<f32>;
@group(0) @binding(3) var<storage, read> count: array<u32>;
@group(0) @binding(4) var<storage, read> params: array<u32>;

const SHARE: f32 = 0.5;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) thread: u32) {
    var slope = vec4(0.0);
    for (var i = thread; i < groups_of(count[0]); i += 256u) {
        slope += of_contacts[i];
    }
    slope = group_total(thread, slope);
    var curvature = vec4(0.0);
    for (var i = thread; i < groups_of(params[0]); i += 256u) {
        curvature += of_bodies[i];
    }
    curvature = group_total(thread, curvature);
    if thread == 0u {
        let found = SHARE * min(slope.x / curvature.x, 1.0);
        share[0] = select(0.0, found, slope.x > 0.0 && curvature.x > 0.0);
    }
}
