// Narrow phase of the pairs of a family: count, then write, their contact points. The part `points` is that of the
// family.
// in    position     [n_bodies]    fine units
// in    orientation  [n_bodies]
// in    sphere       [n_spheres]
// in    solid        [n_spheres]
// in    fixture      [n_fixtures]
// in    margin       [n_spheres]   m
// in    pairs        [n_pairs]
// inout place        [n_pairs + 1] number of points of each pair out when counting; contacts of the pairs before it in when writing
// out   contact      [n_contacts]  when writing: see put_contact.wgsl
// out   arms         [n_contacts]  m, when writing
// in    n_contacts   [1]           0 where there is no room for all
// in    list         [n_list]      the pairs of the family
// in    count        [1]           n_list
// in    hull         [n_rows]      hulls
// in    params       [3]           as bits: fine unit (m), margin of the fixtures (m); whether contacts are written
// Twin: cpu/contact_write.rs, cpu/collide.rs
#import points
#import put_contact

@group(0) @binding(0) var<storage, read> position: array<Fixed>;
@group(0) @binding(1) var<storage, read> orientation: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> sphere: array<Sphere>;
@group(0) @binding(3) var<storage, read> solid: array<Solid>;
@group(0) @binding(4) var<storage, read> fixture: array<Fixture>;
@group(0) @binding(5) var<storage, read> margin: array<f32>;
@group(0) @binding(6) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read_write> place: array<u32>;
@group(0) @binding(8) var<storage, read_write> contact: array<Contact>;
@group(0) @binding(9) var<storage, read_write> arms: array<Arms>;
@group(0) @binding(10) var<storage, read> n_contacts: array<u32>;
@group(0) @binding(11) var<storage, read> list: array<u32>;
@group(0) @binding(12) var<storage, read> count: array<u32>;
@group(0) @binding(13) var<storage, read> hull: array<vec4<u32>>;
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
    // Pairs without points, and where there is no room. What is asked for again below would be in registers during the search.
    if params[2] == 1u && (place[k + 1u] == place[k] || place[k + 1u] > n_contacts[0]) {
        return;
    }
    let origin = position[sphere[pair.x].body];
    let n = points_of(pair, origin, fine, reach);
    if params[2] != 1u {
        place[k] = n;
        return;
    }
    let first = place[k];
    for (var j = 0u; j < n; j++) {
        put_contact(first + j, pair, found[j]);
    }
}
