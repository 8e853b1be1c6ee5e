// Narrow phase, first pass: which pairs of spheres touch or come within their margins.
// in   position  [n_bodies]   steps of the scale
// in   sphere    [n_spheres]
// in   margin    [n_spheres]  m
// in   pairs     [n_pairs]
// out  touches   [n_pairs]    1 if there is a contact, else 0
// in   count     [1]          n_pairs
// in   params    [1]          as bits: step of the scale (m)
// Twin: cpu/sphere_pairs.rs, Find
#import sphere

@group(0) @binding(0) var<storage, read> position: array<Fixed>;
@group(0) @binding(1) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(2) var<storage, read> margin: array<f32>;
@group(0) @binding(3) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> touches: array<u32>;
@group(0) @binding(5) var<storage, read> count: array<u32>;
@group(0) @binding(6) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= min(count[0], arrayLength(&pairs)) {
        return;
    }
    let pair = pairs[k];
    let offset = subtract_fixed(position[sphere[pair.y].body], position[sphere[pair.x].body]);
    let radii = add64(vec2(sphere[pair.x].radius, 0u), vec2(sphere[pair.y].radius, 0u));
    let gap = normal_and_gap(offset, radii).w * bitcast<f32>(params[0]);
    touches[k] = select(0u, 1u, gap <= margin[pair.x] + margin[pair.y]);
}
