// Which pairs are of a family, the part `family`.
// in   sphere   [n_spheres]
// in   solid    [n_spheres]
// in   fixture  [n_fixtures]
// in   pairs    [n_pairs]
// out  flag     [n_pairs]   1 if it is, else 0
// in   count    [1]         n_pairs
// Twin: cpu/collide.rs
#import family

@group(0) @binding(0) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(1) var<storage, read> solid: array<Solid>;
@group(0) @binding(2) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(3) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> flag: array<u32>;
@group(0) @binding(5) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k < count[0] {
        flag[k] = select(0u, 1u, is_of_family(pairs[k]));
    }
}
