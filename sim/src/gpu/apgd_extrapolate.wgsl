// APGD: if the trial was taken, its velocities are those of x, and those of y are extrapolated from them, as y is from x.
// in    motion_next [n_bodies]  m/s, rad/s
// inout motion      [n_bodies]  m/s, rad/s
// inout motion_y    [n_bodies]  m/s, rad/s
// in    scalars     [1]
// Twin: cpu/solve/apgd.rs
#import sphere
#import solve_row
#import scalars

@group(0) @binding(0) var<storage, read> motion_next: array<BodyRow>;
@group(0) @binding(1) var<storage, read_write> motion: array<BodyRow>;
@group(0) @binding(2) var<storage, read_write> motion_y: array<BodyRow>;
@group(0) @binding(3) var<storage, read> scalars: array<Scalars>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let body = row_of(group, thread);
    if body >= arrayLength(&motion) || scalars[0].accepted == 0u {
        return;
    }
    let x = motion[body];
    let z = motion_next[body];
    let beta = scalars[0].beta;
    let v = z.linear.xyz + (z.linear.xyz - x.linear.xyz) * beta;
    let w = z.angular.xyz + (z.angular.xyz - x.angular.xyz) * beta;
    motion_y[body] = BodyRow(vec4(v, z.linear.w), vec4(w, z.angular.w));
    motion[body] = z;
}
