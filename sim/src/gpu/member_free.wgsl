// Write the velocities without contacts of the bodies that joints, springs and loads act on, and their inertia in this step.
// in   member_free  [n_members]
// out  free         [n_bodies]  m/s, rad/s: velocities with joints, without contacts; the inverse moment is negative where joints act
// out  mass         [n_bodies]  1/kg, and principal, 1/(kg m²), where joints act
// out  orientation  [n_bodies]  of the principal frames, where joints act
// in   sizes        [5]         n_members
// in   params       [1]         whether joints act
// Twin: cpu/mechanism.rs
#import sphere
#import solve_row

struct MemberFree {
    v: vec3<f32>,
    inv_mass: f32,
    w: vec3<f32>,
    body: u32,
    moments: vec4<f32>,
    axes: vec4<f32>,
}

@group(0) @binding(0) var<storage, read> member_free: array<MemberFree>;
@group(0) @binding(1) var<storage, read_write> free: array<Body>;
@group(0) @binding(2) var<storage, read_write> mass: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> orientation: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> sizes: array<u32>;
@group(0) @binding(5) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let m = row_of(group, thread);
    if m >= sizes[0] {
        return;
    }
    let own = member_free[m];
    let has_joints = params[0] == 1u;
    free[own.body] = Body(own.v, own.inv_mass, own.w, select(own.moments.x, -1.0, has_joints));
    if has_joints {
        mass[own.body] = vec4(own.inv_mass, own.moments.xyz);
        orientation[own.body] = own.axes;
    }
}
