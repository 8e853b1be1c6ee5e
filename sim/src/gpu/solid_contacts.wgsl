// Narrow phase of the pairs of a family: find and count their contact points, and keep them until the contacts before each pair are known. The
// part `points` is that of the family.
// in    position     [n_bodies]    fine units
// in    orientation  [n_bodies]
// in    sphere       [n_spheres]
// in    solid        [n_spheres]
// in    fixture      [n_fixtures]
// in    margin       [n_spheres]   m
// in    pairs        [n_pairs]
// inout place        [n_pairs + 1] number of points of each pair out
// in    list         [n_list]      the pairs of the family
// in    count        [1]           n_list
// in    hull         [n_rows]      hulls
// out   kept         [3 n_contacts] points of pairs, in any order: normal and gap (m); the point on the first shape, m, and the feature as bits;
//                                  that on the second
// inout n_kept       [1]           their number, also of those that there is no room for
// out   kept_at      [n_list]      the first point of each pair
// in    params       [2]           as bits: fine unit (m), margin of the fixtures (m)
// Twin: cpu/contact_write.rs, cpu/collide.rs
#import points
#import placed

@group(0) @binding(0) var<storage, read> position: array<Fixed>;
@group(0) @binding(1) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(3) var<storage, read> solid: array<Solid>;
@group(0) @binding(4) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(5) var<storage, read> margin: array<f32>;
@group(0) @binding(6) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read_write> place: array<u32>;
@group(0) @binding(8) var<storage, read> list: array<u32>;
@group(0) @binding(9) var<storage, read> count: array<u32>;
@group(0) @binding(10) var<storage, read> hull: array<vec4<u32>>;
@group(0) @binding(11) var<storage, read_write> kept: array<vec4<f32>>;
@group(0) @binding(12) var<storage, read_write> n_kept: array<atomic<u32>>;
@group(0) @binding(13) var<storage, read_write> kept_at: array<u32>;
@group(0) @binding(14) var<storage, read> params: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let i = (group.x + group.y * 65535u) * 64u + thread;
    if i >= count[0] {
        return;
    }
    let k = list[i];
    let pair = pairs[k];
    let fine = bitcast<f32>(params[0]);
    var reach = margin[pair.x];
    if pair.y < arrayLength(&sphere) {
        reach += margin[pair.y];
    } else {
        reach += bitcast<f32>(params[1]);
    }
    let origin = position[sphere[pair.x].body];
    let n = points_of(pair, origin, fine, reach);
    place[list[i]] = n;
    if n == 0u {
        return;
    }
    let first = atomicAdd(&n_kept[0], n);
    kept_at[i] = first;
    // Where there is no room for all, the contacts are found again with more.
    for (var j = 0u; j < n && 3u * (first + j) + 2u < arrayLength(&kept); j++) {
        let to = 3u * (first + j);
        kept[to] = vec4(found[j].normal, found[j].gap);
        kept[to + 1u] = vec4(found[j].on_first, bitcast<f32>(found[j].feature));
        kept[to + 2u] = vec4(found[j].on_second, 0.0);
    }
}
