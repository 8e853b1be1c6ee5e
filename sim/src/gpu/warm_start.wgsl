// Start each contact from the impulse that the contact of the same shapes and feature had in the last step.
// in   contact     [n_contacts]
// in   last_key    [n_last]      shapes and feature
// in   last_gamma  [n_last]      N s, world
// in   table       [n_slots]     one more than the index of a contact of the last step
// out  gamma       [n_contacts]  N s, world; zero for a new contact
// in   count       [1]           n_contacts
// in   last_roll   [n_last]      N m s, world, where there is rolling friction
// out  roll        [n_contacts]  N m s, world
// Twin: cpu/warm_start.rs
#import contact
#import contact_hash
#import rolls

@group(0) @binding(0) var<storage, read> contact: array<Contact>;
@group(0) @binding(1) var<storage, read> last_key: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> last_gamma: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> table: array<u32>;
@group(0) @binding(4) var<storage, read_write> gamma: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> count: array<u32>;
@group(0) @binding(6) var<storage, read> last_roll: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> roll: array<vec4<f32>>;

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let k = row_of(group, thread);
    if k >= count[0] {
        return;
    }
    let key = vec4(contact[k].shapes, contact[k].feature, 0u);
    let n = arrayLength(&table);
    var slot = slot_of(key, n);
    // Features of a pair may have the same id: the first counts, wherever it is in the table.
    var first = arrayLength(&last_key);
    for (var i = 0u; i < n; i++) {
        let entry = table[slot];
        if entry == 0u {
            break;
        }
        if all(last_key[entry - 1u] == key) {
            first = min(first, entry - 1u);
        }
        slot = (slot + 1u) & (n - 1u);
    }
    gamma[k] = vec4(0.0);
    if first < arrayLength(&last_key) {
        gamma[k] = last_gamma[first];
    }
    if ROLLS {
        roll[k] = vec4(0.0);
        if first < arrayLength(&last_key) {
            roll[k] = last_roll[first];
        }
    }
}
