// Narrow phase, first pass: which pairs touch or come within their margins.
// in   position  [n_bodies]   fine units
// in   sphere    [n_spheres]
// in   fixture   [n_fixtures]
// in   margin    [n_spheres]  m
// in   pairs     [n_pairs]
// out  touches   [n_pairs]    1 if there is a contact, else 0
// in   count     [1]          n_pairs
// in   params    [2]          as bits: unit of the scale (m), margin of the fixtures (m)
// Twin: cpu/sphere_pairs.rs, Find
#import touch

@group(0) @binding(0) var<storage, read> position: array<Fixed>;
@group(0) @binding(1) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(2) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(3) var<storage, read> margin: array<f32>;
@group(0) @binding(4) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> touches: array<u32>;
@group(0) @binding(6) var<storage, read> count: array<u32>;
@group(0) @binding(7) var<storage, read> params: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let pair = pairs[k];
    let n = arrayLength(&sphere);
    let unit = bitcast<f32>(params[0]);
    var other = bitcast<f32>(params[1]);
    if pair.y < n {
        other = margin[pair.y];
    }
    touches[k] = select(0u, 1u, is_met(pair, touch(pair).w, (margin[pair.x] + other) / unit));
}
