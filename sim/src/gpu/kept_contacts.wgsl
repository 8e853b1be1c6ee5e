// Put the points that solid_contacts.wgsl has found and kept where the contacts of their pairs are.
// in   pairs       [n_pairs]
// in   place       [n_pairs + 1]  contacts of the pairs before each pair
// out  contact     [n_contacts]   see put_contact.wgsl
// out  arms        [n_contacts]   m
// in   n_contacts  [1]            0 where there is no room for all
// in   list        [n_list]       the pairs of a family
// in   count       [1]            n_list
// in   kept        [3 n_contacts] points of pairs, in any order
// in   kept_at     [n_list]       the first point of each pair
// Twin: cpu/contact_write.rs
#import put_contact

@group(0) @binding(0) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> place: array<u32>;
@group(0) @binding(2) var<storage, read_write> contact: array<Contact>;
@group(0) @binding(3) var<storage, read_write> arms: array<Arms>;
@group(0) @binding(4) var<storage, read> n_contacts: array<u32>;
@group(0) @binding(5) var<storage, read> list: array<u32>;
@group(0) @binding(6) var<storage, read> count: array<u32>;
@group(0) @binding(7) var<storage, read> kept: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> kept_at: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let i = (group.x + group.y * 65535u) * 64u + thread;
    if i >= count[0] {
        return;
    }
    let k = list[i];
    let first = place[k];
    let end = place[k + 1u];
    // Without any pairs the list is that of the last step, and places are none.
    if end <= first || end > n_contacts[0] {
        return;
    }
    for (var j = 0u; j < end - first; j++) {
        let at = 3u * (kept_at[i] + j);
        let normal = kept[at];
        let on_first = kept[at + 1u];
        let feature = bitcast<u32>(on_first.w);
        put_contact(first + j, pairs[k], Point(normal.xyz, on_first.xyz, kept[at + 2u].xyz, normal.w, feature));
    }
}
