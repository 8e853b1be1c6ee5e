// Fat box of each sphere, grown for the motion of several steps.
// in   position  [n_bodies]   fine units
// in   velocity  [n_bodies]   m/s
// in   activity  [n_bodies]
// in   sphere    [n_spheres]
// in   margin    [n_spheres]  m
// out  fat_aabb  [n_spheres]  m; empty for a body that is inactive
// in   count     [1]          n_spheres if pairs are to be found, else 0
// in   orientation, spin [n_bodies]  rad/s, in the bodies' frames
// in   solid     [n_spheres]  where shapes are of any kind
// in   params    [4]          as bits: h (s), unit of the scale (m); number of steps for which a fat box covers the motion of its sphere, and its
//                             margin at rest over half the edge of the tight box
// Twin: cpu/bounds.rs
#import shape_box

@group(0) @binding(0) var<storage, read> position: array<Fixed>;
@group(0) @binding(1) var<storage, read> velocity: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> activity: array<u32>;
@group(0) @binding(3) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(4) var<storage, read> margin: array<f32>;
@group(0) @binding(5) var<storage, read_write> fat_aabb: array<Aabb>;
@group(0) @binding(6) var<storage, read> count: array<u32>;
@group(0) @binding(7) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> spin: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> solid: array<Solid>;
@group(0) @binding(10) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let s = row_of(group, thread);
    if s >= count[0] {
        return;
    }
    let body = sphere[s].body;
    if activity[body] == INACTIVE {
        fat_aabb[s] = Aabb(vec4(3.4e38), vec4(-3.4e38));
        return;
    }
    var fat = shape_box(s, margin[s], bitcast<f32>(params[1]));
    if activity[body] == MOVING {
        let edge = fat.high - fat.low;
        let time = bitcast<f32>(params[0]) * bitcast<f32>(params[2]);
        let grown = vec4(vec3(0.5 * bitcast<f32>(params[3]) * min(edge.x, min(edge.y, edge.z)) + surface_speed(s) * time), 0.0);
        let moved = vec4(velocity[body].xyz * time, 0.0);
        fat.low += min(moved, vec4(0.0)) - grown;
        fat.high += max(moved, vec4(0.0)) + grown;
    }
    fat_aabb[s] = fat;
}
