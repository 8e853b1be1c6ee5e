// Start each contact from the impulse that the contact of the same shapes had in the last step.
// in   contact     [n_contacts]
// in   last_key    [n_last]      shapes
// in   last_gamma  [n_last]      N s, world
// in   table       [n_slots]     one more than the index of a contact of the last step
// out  gamma       [n_contacts]  N s, world; zero for a new contact
// in   count       [1]           n_contacts
// Twin: cpu/warm_start.rs
#import contact
#import contact_hash

@group(0) @binding(0) var<storage, read> contact: array<Contact>;
@group(0) @binding(1) var<storage, read> last_key: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> last_gamma: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> table: array<u32>;
@group(0) @binding(4) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> count: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let key = contact[k].shapes;
    let n = arrayLength(&table);
    var slot = slot_of(key, n);
    var found = vec4(0.0);
    for (var i = 0u; i < n; i++) {
        let entry = table[slot];
        if entry == 0u {
            break;
        }
        if all(last_key[entry - 1u] == key) {
            found = last_gamma[entry - 1u];
            break;
        }
        slot = (slot + 1u) & (n - 1u);
    }
    gamma[k] = found;
}
